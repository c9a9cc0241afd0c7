/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Damping ratio zeta of a linear spring and dashpot and the logarithmic loss L = -ln e of its impact.
 *
 * A dashpot that never pulls (Schwager & Poeschel 2007, Granular Matter 9, 465): the contact ends when the
 * force, not the overlap, is back to zero. With x'' + 2 zeta x' + x = 0, x(0) = 0, x'(0) = 1 and zeta =
 * cos(phi), omega = sin(phi): x = exp(-zeta t) sin(omega t)/omega, and x'' = 0 again at omega t = 2 phi, where
 * x' = -exp(-zeta t). So
 *
 *     L = 2 phi/tan(phi) = 2 zeta acos(zeta)/sqrt(1 - zeta^2),   over-damped with acosh,
 *       = 2 zeta R_C(zeta^2, 1),
 *
 * Carlson's elementary integral, by duplication (1995, Numer. Algorithms 10, 13): it has no seam at zeta = 1
 * and needs roots only.
 *
 * The usual formula, for a dashpot that may pull until the overlap ends: L = pi zeta/sqrt(1 - zeta^2). */
#ifndef RY_LAW_DAMPING_H
#define RY_LAW_DAMPING_H

#include <math.h>

#include "base/parallel.h"

/* Stands for an infinite loss: e^-700 is no restitution at all. */
#define RY_DAMPING_ALL 700.0

/* A dashpot that never pulls. */
RY_INLINE double ry_damping_loss(double zeta)
{
    double x = zeta * zeta, y = 1.0, mean, s;
    do {
        const double lambda = 2.0 * sqrt(x * y) + y;
        x = 0.25 * (x + lambda);
        y = 0.25 * (y + lambda);
        mean = (x + y + y) / 3.0;
        s = (y - mean) / mean;
    } while (s > 5e-3 || s < -5e-3);
    const double series = 0.3 + s * (1.0 / 7.0 + s * (3.0 / 8.0 + s * (9.0 / 22.0 + s * (159.0 / 208.0))));
    return 2.0 * zeta * (1.0 + s * s * series) / sqrt(mean);
}

/* Its inverse between low and high, whose losses lie on either side of `loss`: regula falsi of the Illinois
 * kind; the loss is smooth and monotonic. */
RY_INLINE double ry_damping_of_loss(double loss, double low, double high)
{
    double f_low = ry_damping_loss(low) - loss, f_high = ry_damping_loss(high) - loss;
    double zeta = high;
    int side = 0;
    for (int k = 0; k < 60 && f_low < 0.0 && f_high > 0.0; k++) {
        const double before = zeta;
        zeta = (low * f_high - high * f_low) / (f_high - f_low);
        const double f = ry_damping_loss(zeta) - loss;
        const double moved = zeta > before ? zeta - before : before - zeta;
        if (f == 0.0 || moved <= 1e-15 * zeta) {
            break;
        }
        if (f > 0.0) {
            high = zeta;
            f_high = f;
            f_low *= side > 0 ? 0.5 : 1.0;
            side = 1;
        } else {
            low = zeta;
            f_low = f;
            f_high *= side < 0 ? 0.5 : 1.0;
            side = -1;
        }
    }
    return zeta;
}

RY_INLINE double ry_damping_usual(double loss)
{
    return loss < RY_DAMPING_ALL ? loss / sqrt(9.869604401089358 + loss * loss) : 1.0;
}

RY_INLINE double ry_damping_usual_loss(double zeta)
{
    return zeta < 1.0 ? 3.141592653589793 * zeta / sqrt(1.0 - zeta * zeta) : RY_DAMPING_ALL;
}

#endif
