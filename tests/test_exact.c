/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sums that do not depend on the order of their terms: the same bits in any order and in any parts, right to the last
 * unit, over all sizes that terms may have. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/exact.h"
#include "base/random.h"

enum { N = 20000 };
static const double largest = 3e-4;

/* Terms of either sign from 2^-82 of the largest size up to it. */
static double term(int k)
{
    const double size = ldexp(largest, -(int)(82.0 * ry_random(1, RY_RANDOM_SAMPLE, (uint64_t)k)));
    return size * (2.0 * ry_random(2, RY_RANDOM_SAMPLE, (uint64_t)k) - 0.7) / 1.3;
}

static double *make_terms(void)
{
    double *const terms = malloc(N * sizeof *terms);
    for (int k = 0; k < N; k++) {
        terms[k] = term(k);
    }
    return terms;
}

static ry_exact sum_in_parts(const double *terms, int at_most)
{
    const ry_scale scale = ry_scale_make(largest);
    ry_exact sum = {0, 0};
    for (int k = 0; k < N; k += at_most) {
        ry_exact part = {0, 0};
        ry_exact_add(&part, scale, terms + k, at_most < N - k ? at_most : N - k);
        ry_exact_join(&sum, part);
    }
    return sum;
}

static void test_any_order(void **state)
{
    (void)state;
    double *const terms = make_terms();
    const ry_exact one = sum_in_parts(terms, RY_EXACT_TERMS);
    const int parts[] = {1, 3, 64, 509};
    for (int turn = 0; turn < 4; turn++) {
        for (int k = N - 1; k > 0; k--) { /* shuffled */
            const int other = (int)(ry_random(3, RY_RANDOM_SAMPLE, (uint64_t)(turn * N + k)) * (k + 1));
            const double kept = terms[k];
            terms[k] = terms[other];
            terms[other] = kept;
        }
        const ry_exact again = sum_in_parts(terms, parts[turn]);
        assert_true(again.high == one.high && again.low == one.low);
    }
    free(terms);
}

/* Against long double, summed up from small to large terms. */
static int by_size(const void *a, const void *b)
{
    const double p = fabs(*(const double *)a), q = fabs(*(const double *)b);
    return (p > q) - (p < q);
}

static void test_right(void **state)
{
    (void)state;
    double *const terms = make_terms();
    qsort(terms, N, sizeof *terms, by_size);
    long double sum = 0.0L;
    for (int k = 0; k < N; k++) {
        sum += terms[k];
    }
    const ry_scale scale = ry_scale_make(largest);
    const double value = ry_exact_value(sum_in_parts(terms, RY_EXACT_TERMS), scale);
    assert_true(fabs(value - (double)sum) <= 2.0 * 2.220446049250313e-16 * fabs((double)sum));
    free(terms);
}

/* What is lost of one term is half a unit: 2^-84 of the largest; below that all of it. */
static void test_single(void **state)
{
    (void)state;
    const ry_scale scale = ry_scale_make(largest);
    for (int power = 0; power >= -80; power--) {
        const double small = -ldexp(largest, power) / 3.0;
        ry_exact sum = {0, 0};
        ry_exact_add(&sum, scale, &small, 1);
        assert_true(sum.low >= 0 && sum.low < INT64_C(1) << 40);
        assert_true(fabs(ry_exact_value(sum, scale) - small) <= ldexp(largest, -84) + 2e-16 * fabs(small));
    }
}

/* As many of the largest terms as an array may have. */
static void test_large(void **state)
{
    (void)state;
    const ry_scale scale = ry_scale_make(largest);
    double terms[RY_EXACT_TERMS];
    ry_exact sum = {0, 0};
    for (int k = 0; k < RY_EXACT_TERMS; k++) {
        terms[k] = largest;
    }
    for (int k = 0; k < 500; k++) {
        ry_exact_add(&sum, scale, terms, RY_EXACT_TERMS);
    }
    assert_true(fabs(ry_exact_value(sum, scale) / (500.0 * RY_EXACT_TERMS * largest) - 1.0) <= 4e-16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_any_order), cmocka_unit_test(test_right),
                                       cmocka_unit_test(test_single), cmocka_unit_test(test_large)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
