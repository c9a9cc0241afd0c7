/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Bed-load relations against nineteen times ten published numbers, thresholds against closed forms,
 * and postprocess/relations.csv against the table in C. After a change of that table
 *
 *     RY_UPDATE=1 build/tests/test_relations
 *
 * writes postprocess/relations.csv anew. */
#include "analysis/relations.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define CHECK_FILE RY_SOURCE_DIR "/tests/data/bedload_relations.csv"
#define CURVE_FILE RY_SOURCE_DIR "/postprocess/relations.csv"

enum { LINE = 8192, COLUMNS = 10, CURVE_POINTS = 161 };

/* Next line that is no comment, without its end; 0 at the end of the file. */
static int read_line(FILE *file, char *line)
{
    while (fgets(line, LINE, file)) {
        line[strcspn(line, "\r\n")] = '\0';
        if (line[0] != '#') {
            return 1;
        }
    }
    return 0;
}

static FILE *open_file(const char *path, const char *mode)
{
    FILE *file = fopen(path, mode);
    if (!file) {
        fail_msg("%s cannot be opened", path);
    }
    return file;
}

/* Cuts `line` at its commas and reads the numbers behind the first item. */
static int split(char *line, double *value, int most)
{
    int n = 0;
    for (char *next = strchr(line, ','); next && n < most; n++) {
        *next++ = '\0';
        value[n] = strtod(next, NULL);
        next = strchr(next, ',');
    }
    return n;
}

/* Half a unit of the sixth digit. */
static double half_digit(double value)
{
    return value > 0.0 ? 0.5000001 * pow(10.0, floor(log10(value)) - 5.0) : 1e-300;
}

static void test_published_numbers(void **state)
{
    (void)state;
    FILE *file = open_file(CHECK_FILE, "r");
    char line[LINE];
    double theta[COLUMNS], expected[COLUMNS];
    int rows = 0;
    assert_true(read_line(file, line));
    assert_int_equal(split(line, theta, COLUMNS), COLUMNS);
    while (read_line(file, line)) {
        assert_int_equal(split(line, expected, COLUMNS), COLUMNS);
        const ry_relation *relation = ry_relation_find(line);
        if (!relation) {
            fail_msg("no relation '%s'", line);
            break;
        }
        for (int k = 0; k < COLUMNS; k++) {
            const double q = ry_relation_flux(relation, theta[k]);
            if (!(fabs(q - expected[k]) <= half_digit(expected[k]))) {
                fail_msg("%s at theta = %g: %.9g, published %.6g", line, theta[k], q, expected[k]);
            }
        }
        rows++;
    }
    fclose(file);
    assert_int_equal(rows, 19);
    assert_int_equal(rows, ry_relation_count()); /* every relation is checked */
}

static void test_table(void **state)
{
    (void)state;
    for (int i = 0; i < ry_relation_count(); i++) {
        const ry_relation *r = ry_relation_at(i);
        assert_ptr_equal(ry_relation_find(r->key), r);
        assert_null(strchr(r->key, ',')); /* they become a table with commas */
        assert_null(strchr(r->authors, ','));
        assert_null(strchr(r->formula, ','));
        assert_true(r->year > 1900 && r->year < 2100);
        double last = 0.0;
        for (double theta = 0.0; theta <= 5.0; theta += 0.001) {
            const double q = ry_relation_flux(r, theta);
            assert_true(isfinite(q) && q >= 0.0);
            /* More stress, more transport, but where Brown's two pieces meet (his own 5 % step). */
            if (strcmp(r->key, "einstein-brown") != 0 || fabs(theta - 0.18) > 0.02) {
                assert_true(q >= last);
            }
            last = q;
        }
    }
    assert_null(ry_relation_find("no such relation"));
    assert_null(ry_relation_at(-1));
    assert_null(ry_relation_at(ry_relation_count()));
}

static void test_thresholds_of_relations(void **state)
{
    (void)state;
    for (int i = 0; i < ry_relation_count(); i++) {
        const ry_relation *r = ry_relation_at(i);
        assert_true(ry_relation_flux(r, 0.0) == 0.0);
        assert_true(ry_relation_flux(r, -1.0) == 0.0);
        assert_true(isnan(ry_relation_flux(r, NAN)));
        if (strcmp(r->key, "camenen-larson") == 0) {
            assert_true(ry_relation_flux(r, 0.5 * r->theta_c) > 0.0);
        } else if (r->theta_c > 0.0) {
            assert_true(ry_relation_flux(r, r->theta_c) == 0.0);
            assert_true(ry_relation_flux(r, r->theta_c * 1.0001) > 0.0);
        }
    }
}

/* Another threshold, other grains. */
static void test_other_conditions(void **state)
{
    (void)state;
    ry_relation_input in = {.theta = 0.2, .theta_c = 0.03, .s = 2.65, .d_star = 150.0};
    const ry_relation *ashida = ry_relation_find("ashida-michiue");
    assert_non_null(ashida);
    /* 17 theta^1.5 (1 - c)(1 - sqrt(c)), c = theta_c/theta: the form as printed in 1972. */
    const double c = 0.03 / 0.2;
    assert_true(fabs(ry_relation_flux_of(ashida, &in) / (17.0 * pow(0.2, 1.5) * (1.0 - c) * (1.0 - sqrt(c))) -
                     1.0) < 1e-14);
    in.theta_c = NAN;
    assert_true(ry_relation_flux_of(ashida, &in) == ry_relation_flux(ashida, 0.2));
    in.theta_c = 0.3;
    assert_true(ry_relation_flux_of(ashida, &in) == 0.0);

    /* Rubey's F falls from sqrt(2/3) for coarse grains. */
    const ry_relation *brown = ry_relation_find("einstein-brown");
    assert_non_null(brown);
    in = (ry_relation_input){.theta = 0.5, .theta_c = NAN, .s = 2.65, .d_star = 1e6};
    assert_true(fabs(ry_relation_flux_of(brown, &in) / (40.0 * 0.125 * sqrt(2.0 / 3.0)) - 1.0) < 1e-7);
    in.d_star = 10.0;
    assert_true(fabs(ry_relation_flux_of(brown, &in) / (5.0 * (sqrt(2.0 / 3.0 + 0.036) - sqrt(0.036))) - 1.0) <
                1e-14);
}

static double threshold(const char *key, double d_star)
{
    const ry_threshold *t = ry_threshold_find(key);
    if (!t) {
        fail_msg("no threshold '%s'", key);
        return NAN;
    }
    return t->theta_c(d_star);
}

static void assert_close(double a, double b, double tolerance)
{
    if (!(fabs(a / b - 1.0) <= tolerance)) {
        fail_msg("%.9g is not %.9g within %g", a, b, tolerance);
    }
}

static void test_soulsby_whitehouse(void **state)
{
    (void)state;
    assert_close(threshold("soulsby-whitehouse", 1e9), 0.055, 1e-6); /* coarse grains */
    assert_close(threshold("soulsby-whitehouse", 1e-9), 0.30, 1e-6); /* dust */
    assert_close(threshold("soulsby-whitehouse", 50.0), 0.30 / 61.0 + 0.055 * (1.0 - exp(-1.0)), 1e-14);
}

static void test_brownlie(void **state)
{
    (void)state;
    assert_close(threshold("brownlie", 1e12), 0.06, 1e-6);
    /* R* = 1: Y = 1. And the other form of the same formula, 0.06 exp(-17.77 Y). */
    assert_close(threshold("brownlie", 1.0), 0.22 + 0.06 * pow(10.0, -7.7), 1e-14);
    const double y = pow(12.65, -0.9);
    assert_close(threshold("brownlie", 12.65), 0.22 * y + 0.06 * exp(-17.77 * y), 5e-3);
}

/* The pieces meet, and agree with Iwagaki's dimensional form, u*c^2 in cm^2/s^2 for d in cm, quartz in
 * water of 20 degrees: 80.9 d, 134.6 d^(31/22), 55.0 d, 8.41 d^(11/32), 226 d. */
static void test_iwagaki(void **state)
{
    (void)state;
    const double joints[] = {2.14, 54.2, 162.7, 671.0};
    for (size_t i = 0; i < sizeof joints / sizeof *joints; i++) {
        const double d = pow(joints[i], 2.0 / 3.0);
        assert_close(threshold("iwagaki", d * (1.0 - 1e-9)), threshold("iwagaki", d * (1.0 + 1e-9)), 5e-3);
    }
    static const struct {
        double d, u2;
    } points[] = {{0.5, 80.9 * 0.5}, {0.2, 13.936}, {0.08, 55.0 * 0.08}, {0.03, 2.5196}, {0.005, 226.0 * 0.005}};
    assert_close(134.6 * pow(0.2, 31.0 / 22.0), points[1].u2, 1e-3);
    assert_close(8.41 * pow(0.03, 11.0 / 32.0), points[3].u2, 1e-3);
    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
        const double s = 2.65, g = 980.0, nu = 0.01;
        const double d_star = ry_relation_d_star(points[i].d, s, g, nu);
        assert_close(threshold("iwagaki", d_star), points[i].u2 / ((s - 1.0) * g * points[i].d), 0.03);
    }
}

static void test_threshold_table(void **state)
{
    (void)state;
    assert_int_equal(ry_threshold_count(), 3);
    for (int i = 0; i < ry_threshold_count(); i++) {
        const ry_threshold *t = ry_threshold_at(i);
        assert_ptr_equal(ry_threshold_find(t->key), t);
        for (double d_star = 0.5; d_star < 1000.0; d_star *= 1.1) {
            assert_true(t->theta_c(d_star) > 0.01 && t->theta_c(d_star) < 0.5);
        }
    }
    assert_null(ry_threshold_find("no such threshold"));
    assert_null(ry_threshold_at(3));
}

/* 0.5 mm quartz in water: D* = 5e-4 (1.65 x 9.81/1e-12)^(1/3) = 12.65; D*^1.5 = R*. */
static void test_d_star(void **state)
{
    (void)state;
    const double d_star = ry_relation_d_star(0.5e-3, 2.65, 9.81, 1e-6);
    assert_close(d_star, 12.6479, 1e-5);
    assert_close(pow(d_star, 1.5), sqrt(1.65 * 9.81 * 0.5e-3) * 0.5e-3 / 1e-6, 1e-12);
}

/* Text of postprocess/relations.csv: a row per relation, a column per Shields number. */
static void curve_text(char *text, size_t size)
{
    size_t at = 0;
    at += (size_t)snprintf(text + at, size - at,
                           "# Made from src/analysis/relations.c by RY_UPDATE=1 build/tests/test_relations.\n"
                           "# q* over theta (first row); einstein-brown at D* = 150, yalin at s = 2.65.\n"
                           "key,authors,year,formula");
    double theta[CURVE_POINTS];
    for (int k = 0; k < CURVE_POINTS; k++) {
        theta[k] = pow(10.0, -1.6 + 2.2 * k / (CURVE_POINTS - 1)); /* 0.025 to 4 */
        at += (size_t)snprintf(text + at, size - at, ",%.5g", theta[k]);
    }
    for (int i = 0; i < ry_relation_count(); i++) {
        const ry_relation *r = ry_relation_at(i);
        at += (size_t)snprintf(text + at, size - at, "\n%s,%s,%d,%s", r->key, r->authors, r->year, r->formula);
        for (int k = 0; k < CURVE_POINTS; k++) {
            char number[32];
            snprintf(number, sizeof number, "%.5g", theta[k]); /* q* at theta as printed */
            at += (size_t)snprintf(text + at, size - at, ",%.4g", ry_relation_flux(r, strtod(number, NULL)));
        }
        assert_true(at < size);
    }
    snprintf(text + at, size - at, "\n");
}

static void test_curves_for_plots(void **state)
{
    (void)state;
    enum { SIZE = 1 << 16 };
    char *expected = calloc(1, SIZE), *found = calloc(1, SIZE);
    assert_true(expected && found);
    curve_text(expected, SIZE);
    if (getenv("RY_UPDATE")) {
        FILE *file = open_file(CURVE_FILE, "w");
        fputs(expected, file);
        assert_int_equal(fclose(file), 0);
    }
    FILE *file = open_file(CURVE_FILE, "r");
    fread(found, 1, SIZE - 1, file);
    fclose(file);
    if (strcmp(found, expected) != 0) {
        fail_msg("postprocess/relations.csv is out of date: RY_UPDATE=1 build/tests/test_relations");
    }
    free(expected);
    free(found);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_published_numbers), cmocka_unit_test(test_table),
        cmocka_unit_test(test_thresholds_of_relations), cmocka_unit_test(test_other_conditions),
        cmocka_unit_test(test_soulsby_whitehouse), cmocka_unit_test(test_brownlie),
        cmocka_unit_test(test_iwagaki), cmocka_unit_test(test_threshold_table),
        cmocka_unit_test(test_d_star), cmocka_unit_test(test_curves_for_plots),
    };
    return cmocka_run_group_tests_name("relations", tests, NULL, NULL);
}
