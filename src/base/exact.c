/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/exact.h"

#include <math.h>
#include <string.h>

enum { BITS = 40 }; /* between the units */

/* Terms up to the largest are 2^45 coarse units at most, which leaves 2^51 room for those that are larger. */
ry_scale ry_scale_make(double largest)
{
    const int coarse = ilogb(largest) + 1 - 44;
    return (ry_scale){ldexp(1.5, coarse + 52), ldexp(1.5, coarse + 52 - BITS)};
}

static double unit(double cut)
{
    return cut / 6755399441055744.0; /* 1.5 x 2^52 */
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

RY_INLINE uint64_t bits(double number)
{
    uint64_t same;
    memcpy(&same, &number, sizeof same);
    return same;
}

/* The last bits of what is cut count units: whole numbers, which add up without being turned into any. */
RY_CLONES static ry_exact units_of(ry_scale scale, const double *terms, int32_t n)
{
    uint64_t high = 0, low = 0;
#pragma omp simd reduction(+ : high, low)
    for (int32_t k = 0; k < n; k++) {
        const double coarse = terms[k] + scale.high;
        const double fine = (terms[k] - (coarse - scale.high)) + scale.low;
        high += bits(coarse);
        low += bits(fine);
    }
    const uint64_t count = (uint64_t)n;
    return (ry_exact){(int64_t)(high - count * bits(scale.high)), (int64_t)(low - count * bits(scale.low))};
}

void ry_exact_add(ry_exact *sum, ry_scale scale, const double *terms, int32_t n)
{
    ry_exact_join(sum, units_of(scale, terms, n));
}

double ry_exact_value(ry_exact sum, ry_scale scale)
{
    return (double)sum.high * unit(scale.high) + (double)sum.low * unit(scale.low);
}
