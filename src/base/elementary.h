/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * exp, log and pow from + - x / alone: the C library's differ in the last bit between machines, and a
 * result must not. Accurate to a few units in the last place over the stated ranges. */
#ifndef RY_BASE_ELEMENTARY_H
#define RY_BASE_ELEMENTARY_H

#include <stdint.h>
#include <string.h>

#include "base/parallel.h"

#define RY_LN2_HIGH 0x1.62e42fefa3800p-1
#define RY_LN2_LOW 0x1.ef35793c76730p-45

/* e^x for |x| < 700; 0 below. Reduction to |r| <= ln2/2, then Taylor to r^13. */
RY_INLINE double ry_exp(double x)
{
    const double bounded = x < -700.0 ? -700.0 : (x > 700.0 ? 700.0 : x);
    const double shifted = bounded * 0x1.71547652b82fep+0 + 0x1.8p52;
    const double k = shifted - 0x1.8p52;
    const double r = (bounded - k * RY_LN2_HIGH) - k * RY_LN2_LOW;
    /* the Taylor series, added up in pairs (Estrin 1960): a chain would wait for each term */
    const double r2 = r * r, r4 = r2 * r2;
    const double low = (1.0 + r) + (0.5 + r * (1.0 / 6.0)) * r2;
    const double middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + (1.0 / 720.0 + r * (1.0 / 5040.0)) * r2;
    const double high = (1.0 / 40320.0 + r * (1.0 / 362880.0)) + (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) * r2;
    const double highest = 1.0 / 479001600.0 + r * (1.0 / 6227020800.0);
    const double p = (low + middle * r4) + (high + highest * r4) * (r4 * r4);
    const int64_t bits = ((int64_t)k + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return x < -700.0 ? 0.0 : p * power;
}

/* ln x for normal x > 0: x = 2^k m, m in [sqrt(1/2), sqrt 2), then the atanh series in
 * (m - 1)/(m + 1), |.| < 0.172. */
RY_INLINE double ry_log(double x)
{
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const int64_t above = (bits - 0x3fe6a09e667f3bcd) >> 52;
    bits -= above * ((int64_t)1 << 52);
    double m;
    memcpy(&m, &bits, sizeof m);
    const double k = (double)above;
    const double t = (m - 1.0) / (m + 1.0);
    const double q = t * t;
    double p = 1.0 / 21.0;
    p = p * q + 1.0 / 19.0;
    p = p * q + 1.0 / 17.0;
    p = p * q + 1.0 / 15.0;
    p = p * q + 1.0 / 13.0;
    p = p * q + 1.0 / 11.0;
    p = p * q + 1.0 / 9.0;
    p = p * q + 1.0 / 7.0;
    p = p * q + 1.0 / 5.0;
    p = p * q + 1.0 / 3.0;
    p = p * q + 1.0;
    return k * RY_LN2_HIGH + (2.0 * t * p + k * RY_LN2_LOW);
}

/* x^y for normal x > 0. */
RY_INLINE double ry_pow(double x, double y)
{
    return ry_exp(y * ry_log(x));
}

#endif
