/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/exact.h"

#include <math.h>

enum { BITS = 40 }; /* between the units */

/* 512 terms of the largest size make 2^53 coarse units. */
ry_scale ry_scale_make(double largest)
{
    const int coarse = ilogb(largest) + 1 - 44;
    return (ry_scale){ldexp(1.5, coarse + 52), ldexp(1.5, coarse + 52 - BITS)};
}

static double unit(double cut)
{
    return cut / 6755399441055744.0; /* 1.5 x 2^52 */
}

/* Not a number, or beyond all bounds: such a run is stopped anyway. */
static int64_t units(double sum, double cut)
{
    const double n = sum / unit(cut);
    return fabs(n) < 0x1p62 ? (int64_t)n : 0;
}

/* Totals wrap rather than overflow. */
static int64_t add(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}

void ry_exact_join(ry_exact *sum, ry_exact other)
{
    const int64_t low = sum->low + other.low, fine = INT64_C(1) << BITS;
    const int64_t rest = low & (fine - 1);
    sum->high = add(add(sum->high, other.high), (low - rest) / fine);
    sum->low = rest;
}

/* Contraction and reordering are off everywhere, but for that of the sums, which is free. */
RY_CLONES static ry_exact units_of(ry_scale scale, const double *terms, int32_t n)
{
    double high = 0.0, low = 0.0;
#pragma omp simd reduction(+ : high, low)
    for (int32_t k = 0; k < n; k++) {
        const double coarse = (terms[k] + scale.high) - scale.high;
        const double fine = ((terms[k] - coarse) + scale.low) - scale.low;
        high += coarse;
        low += fine;
    }
    return (ry_exact){units(high, scale.high), units(low, scale.low)};
}

void ry_exact_add(ry_exact *sum, ry_scale scale, const double *terms, int32_t n)
{
    ry_exact_join(sum, units_of(scale, terms, n));
}

double ry_exact_value(ry_exact sum, ry_scale scale)
{
    return (double)sum.high * unit(scale.high) + (double)sum.low * unit(scale.low);
}
