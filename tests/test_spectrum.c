/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Ringing that is known: frequency and damping come back; what does not ring has none. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "analysis/spectrum.h"

enum { N = 4000 };
static const double pi = 3.14159265358979323846;

static void check(double frequency, double damping)
{
    double x[N];
    ry_ringing found;
    const double w = 2.0 * pi * frequency;
    for (int k = 0; k < N; k++) {
        x[k] = 5.5 + 0.02 * exp(-damping * w * k) * cos(w * sqrt(1.0 - damping * damping) * k);
    }
    assert_int_equal(ry_spectrum_ringing(x, N, &found, NULL), 0);
    assert_true(fabs(found.frequency / frequency - 1.0) < 0.05);
    assert_true(fabs(found.damping / damping - 1.0) < 0.15);
}

static void test_known_ringing(void **state)
{
    (void)state;
    check(0.02, 0.02);
    check(0.01, 0.05);
    check(0.05, 0.1);
}

static void test_no_ringing(void **state)
{
    (void)state;
    double x[N];
    ry_ringing found;
    for (int k = 0; k < N; k++) {
        x[k] = 5.5 + exp(-0.01 * k);
    }
    assert_int_equal(ry_spectrum_ringing(x, N, &found, NULL), 0);
    assert_true(isnan(found.frequency) && isnan(found.damping));
    assert_int_equal(ry_spectrum_ringing(x, 3, &found, NULL), 0);
    assert_true(isnan(found.frequency));
    assert_int_equal(ry_spectrum_ringing(x, 0, &found, NULL), 0);
    assert_true(isnan(found.frequency));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_known_ringing),
                                       cmocka_unit_test(test_no_ringing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
