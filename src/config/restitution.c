/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Restitution of a linear spring and dashpot that never pulls (Schwager & Poeschel 2007, Granular
 * Matter 9, 465): the contact ends when the force, not the overlap, is back to zero.
 *
 * With x'' + 2 zeta x' + x = 0, x(0) = 0, x'(0) = 1 and zeta = cos(phi), omega = sin(phi): x =
 * exp(-zeta t) sin(omega t)/omega, and x'' = 0 again at omega t = 2 phi, where x' = -exp(-zeta t).
 * So
 *
 *     e = exp(-2 phi/tan(phi)),   over-damped: phi = i psi,   e = exp(-2 psi/tanh(psi)) */
#include "ryusa/config.h"

/* -ln e. With h = 1 - zeta: phi/tan(phi) = 1 - 2h/3 - h^2/5 - O(h^3), where both forms are 0/0. */
static double loss(double zeta)
{
    const double h = 1.0 - zeta;
    if (fabs(h) < 1e-5) {
        return 2.0 * (1.0 - h * (2.0 / 3.0 + h / 5.0));
    }
    const double root = sqrt(fabs(h) * (1.0 + zeta));
    return 2.0 * zeta * (h > 0.0 ? acos(zeta) : acosh(zeta)) / root;
}

double ry_restitution_from_damping(double zeta)
{
    return zeta <= 0.0 ? 1.0 : isinf(zeta) ? 0.0 : exp(-loss(zeta));
}

/* Bisection down to neighbouring doubles: loss() rises from 0 without bound. */
double ry_damping_from_restitution(double e)
{
    if (e >= 1.0) {
        return 0.0;
    }
    if (!(e > 0.0)) {
        return isnan(e) ? NAN : INFINITY;
    }
    const double wanted = -log(e);
    double low = 0.0, high = 1.0 + exp(0.5 * wanted);
    for (;;) {
        const double middle = 0.5 * (low + high);
        if (!(middle > low && middle < high)) {
            return middle;
        }
        if (loss(middle) < wanted) {
            low = middle;
        } else {
            high = middle;
        }
    }
}
