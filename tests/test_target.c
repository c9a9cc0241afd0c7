/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Targets: relations by key, curves and points from CSV, and what is wrong with a CSV. */
#include "analysis/target.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static void near(double value, double expected)
{
    if (!(fabs(value - expected) <= 1e-12 * fabs(expected))) {
        fail_msg("%.17g, but %.17g is expected", value, expected);
    }
}

static void test_relation(void **state)
{
    (void)state;
    ry_target target;
    double low, high;
    assert_int_equal(ry_target_open(&target, "wong-parker", NULL), RY_OK);
    near(ry_target_flux(&target, 0.2), 3.97 * pow(0.2 - 0.0495, 1.5));
    assert_true(isnan(ry_target_error(&target, 0.2)));
    ry_target_range(&target, &low, &high);
    assert_true(low == 0.0 && isinf(high));
    ry_target_free(&target);
}

static void test_points(void **state)
{
    (void)state;
    static const char text[] =
        "\xEF\xBB\xBF# measured\r\n\r\nrun, error, \"q_star\", theta\r\n"
        "a, 0.01, 0, 0.05\r\nb, 0.02, 0.1, 0.1\r\n# between\r\nc, 0.04, 0.8, 0.4\r\n";
    ry_target target;
    ry_error error = {0};
    double low, high;
    assert_int_equal(ry_target_parse(&target, text, "points.csv", &error), RY_OK);
    assert_int_equal(target.n, 3);
    ry_target_range(&target, &low, &high);
    assert_true(low == 0.05 && high == 0.4);
    assert_true(ry_target_flux(&target, 0.05) == 0.0 && ry_target_flux(&target, 0.4) == 0.8);
    near(ry_target_flux(&target, 0.075), 0.05); /* a line up from 0 */
    near(ry_target_flux(&target, 0.2), 0.1 * pow(2.0, 1.5));
    near(ry_target_error(&target, 0.25), 0.03);
    assert_true(isnan(ry_target_flux(&target, 0.04)) && isnan(ry_target_flux(&target, 0.41)));
    assert_true(isnan(ry_target_flux(&target, NAN)));
    ry_target_free(&target);
}

static void test_one_point(void **state)
{
    (void)state;
    ry_target target;
    assert_int_equal(ry_target_parse(&target, "theta,q_star\n0.1,0.05", "one.csv", NULL), RY_OK);
    assert_true(ry_target_flux(&target, 0.1) == 0.05);
    assert_true(isnan(ry_target_error(&target, 0.1)));
    ry_target_free(&target);
}

static void test_bad_tables(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says[2];
    } bad[] = {
        {"", {"t.csv: no points", "theta,q_star"}},
        {"theta,q_star\n# nothing\n", {"t.csv: no points", "at least one row"}},
        {"0.1,0.2\n", {"t.csv:1: no column theta", "first line"}},
        {"theta,flux\n0.1,0.2\n", {"t.csv:1: no column q_star", "theta,q_star,error"}},
        {"theta,q_star,theta\n", {"t.csv:1: two columns", "theta"}},
        {"theta,q_star\n0.1,0.2\n0.2,many\n", {"t.csv:3: q_star: 'many' is not a number", ""}},
        {"theta,q_star\n0.1 Pa,0.2\n", {"t.csv:2: theta: ", "plain number"}},
        {"theta,q_star\n0.1,nan\n", {"t.csv:2: q_star: ", "'nan'"}},
        {"theta,q_star\n0.1,\n", {"t.csv:2: q_star: nothing", "number"}},
        {"theta,q_star\n0.1,0.2,0.3\n", {"t.csv:2: 3 columns", "2"}},
        {"theta,q_star\n0.1\n", {"t.csv:2: 1 columns", "2"}},
        {"theta,q_star\n0.2,0.2\n0.1,0.3\n", {"t.csv:3: theta: 0.1", "sort the rows"}},
        {"theta,q_star\n0.2,0.2\n0.2,0.3\n", {"t.csv:3: theta: 0.2", "once"}},
        {"theta,q_star\n0,0.2\n", {"t.csv:2: theta: 0", "above 0"}},
        {"theta,q_star\n0.1,-0.2\n", {"t.csv:2: q_star: -0.2", "0 or more"}},
        {"theta,q_star\n0.1,0.2\n\xff\n", {"t.csv: not a text file", "CSV"}},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        ry_target target;
        ry_error error = {0};
        assert_int_equal(ry_target_parse(&target, bad[k].text, "t.csv", &error), RY_BAD_INPUT);
        for (int i = 0; i < 2; i++) {
            if (strstr(error.text, bad[k].says[i]) == NULL) {
                fail_msg("'%s' does not say '%s'", error.text, bad[k].says[i]);
            }
        }
        assert_null(target.theta);
        assert_null(target.name);
    }
}

static void test_bad_names(void **state)
{
    (void)state;
    ry_target target;
    ry_error error = {0};
    assert_int_equal(ry_target_open(&target, "wong-praker", &error), RY_BAD_INPUT);
    assert_non_null(strstr(error.text, "did you mean wong-parker?"));
    error = (ry_error){0};
    assert_int_equal(ry_target_open(&target, "nowhere.csv", &error), RY_BAD_FILE);
    assert_non_null(strstr(error.text, "nowhere.csv: can't be opened"));
    error = (ry_error){0};
    assert_int_equal(ry_target_open(&target, "/tmp", &error), RY_BAD_FILE);
    assert_non_null(strstr(error.text, "folder"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_relation),  cmocka_unit_test(test_points),
        cmocka_unit_test(test_one_point), cmocka_unit_test(test_bad_tables),
        cmocka_unit_test(test_bad_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
