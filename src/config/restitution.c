/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Restitution of a linear spring and dashpot that never pulls, see law/damping.h. */
#include "law/damping.h"
#include "ryusa/config.h"

double ry_restitution_from_damping(double zeta)
{
    return zeta <= 0.0 ? 1.0 : isinf(zeta) ? 0.0 : exp(-ry_damping_loss(zeta));
}

/* Bisection down to neighbouring doubles: the loss rises from 0 without bound. */
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
        if (ry_damping_loss(middle) < wanted) {
            low = middle;
        } else {
            high = middle;
        }
    }
}
