/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sums that come out the same in whatever order, and over however many threads, their terms are added: each term
 * is cut into a multiple of a coarse unit and one of a fine unit, 2^40 times smaller, by adding and taking away a
 * large number, and multiples add up without rounding (the 1-reduction with two bins of Demmel & Nguyen 2013,
 * "Fast reproducible floating-point summation", with units fixed beforehand). What is beyond the fine unit is lost. */
#ifndef RY_BASE_EXACT_H
#define RY_BASE_EXACT_H

#include <stdint.h>

#include "base/parallel.h"

/* What cuts at a unit: 1.5 x 2^52 of it. */
typedef struct ry_scale {
    double high, low;
} ry_scale;

/* high x coarse unit + low x fine unit, 0 <= low < 2^40. */
typedef struct ry_exact {
    int64_t high, low;
} ry_exact;

/* The most terms that ry_exact_add takes. */
enum { RY_EXACT_TERMS = 512 };

/* For terms up to `largest` > 0 in size, or 64 times that: the fine unit is at most 2^-83 of it, totals go up to 2^18.
 * Totals with larger terms, or such that are no numbers, mean nothing. */
ry_scale ry_scale_make(double largest);

void ry_exact_add(ry_exact *sum, ry_scale scale, const double *terms, int32_t n);
void ry_exact_join(ry_exact *sum, ry_exact other);
double ry_exact_value(ry_exact sum, ry_scale scale);

#endif
