/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Mean, error and equilibration cut against processes whose mean and autocorrelation time are known.
 * Every number comes from a counter-based generator, so a failure repeats; the seeds are printed.
 *
 * AR(1), x_i = rho x_(i-1) + noise: rho_k = rho^k, tau_int = 1/2 (1 + rho)/(1 - rho). */
#include "analysis/statistics.h"

#include <Random123/philox.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WARM_UP = 500, SEEDS = 400 };

static const double PI = 3.14159265358979323846;

/* Number `index` of the standard normal sequence `seed` (Box & Muller 1958). */
static double normal(uint32_t seed, uint32_t index)
{
    const philox4x32_ctr_t counter = {{index, seed, 0, 0}};
    const philox4x32_key_t key = {{0x72797573u, 0x61u}};
    const philox4x32_ctr_t r = philox4x32(counter, key);
    const double u = ((double)r.v[0] + 0.5) / 4294967296.0;
    const double v = ((double)r.v[1] + 0.5) / 4294967296.0;
    return sqrt(-2.0 * log(u)) * cos(2.0 * PI * v);
}

/* A stationary AR(1) of mean 0 and variance 1. */
static void ar1(double *x, int64_t n, double rho, uint32_t seed)
{
    double y = normal(seed, 0);
    const double noise = sqrt(1.0 - rho * rho);
    for (int64_t i = -WARM_UP; i < n; i++) {
        y = rho * y + noise * normal(seed, (uint32_t)(i + WARM_UP + 1));
        if (i >= 0) {
            x[i] = y;
        }
    }
}

static double *series(int64_t n)
{
    double *x = malloc((size_t)n * sizeof *x);
    assert_non_null(x);
    return x;
}

static ry_series_statistics mean_of(const double *x, int64_t n)
{
    ry_error error = {0};
    ry_series_statistics s;
    assert_int_equal(ry_series_mean(x, n, &s, &error), RY_OK);
    return s;
}

static ry_series_statistics equilibrated(const double *x, int64_t n)
{
    ry_error error = {0};
    ry_series_statistics s;
    assert_int_equal(ry_series_equilibrated(x, n, &s, &error), RY_OK);
    return s;
}

static void assert_within(double value, double low, double high, const char *what, double parameter)
{
    if (!(value >= low && value <= high)) {
        fail_msg("%s = %g at %g, expected %g to %g", what, value, parameter, low, high);
    }
}

static void test_short_series(void **state)
{
    (void)state;
    const double x[] = {3.0, 5.0, 4.0};
    ry_series_statistics s = mean_of(NULL, 0);
    assert_true(isnan(s.mean) && isnan(s.standard_error));
    assert_int_equal(s.samples, 0);
    s = mean_of(x, 1);
    assert_true(s.mean == 3.0);
    assert_true(isnan(s.standard_error)); /* one sample says nothing about its error */
    s = mean_of(x, 2);
    assert_true(s.mean == 4.0);
    assert_true(fabs(s.standard_error - 1.0) < 1e-15);
    s = mean_of(x, 3);
    assert_true(s.mean == 4.0);
    assert_true(fabs(s.standard_error - 1.0 / sqrt(3.0)) < 1e-15);
    assert_true(s.autocorrelation_time == 0.5);
    assert_int_equal(s.samples, 3);
    for (int n = 0; n <= 3; n++) {
        s = equilibrated(x, n);
        assert_int_equal(s.first, 0);
        assert_int_equal(s.samples, n);
    }
}

/* The value has no short binary form: a naive mean would leave a variance of rounding. */
static void test_constant(void **state)
{
    (void)state;
    double x[1000];
    for (int i = 0; i < 1000; i++) {
        x[i] = 0.1;
    }
    const int lengths[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 100, 1000};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        const int n = lengths[i];
        ry_series_statistics s = equilibrated(x, n);
        assert_true(s.mean == 0.1);
        assert_true(n == 1 ? isnan(s.standard_error) : s.standard_error == 0.0);
        assert_true(s.autocorrelation_time == 0.5);
        assert_int_equal(s.first, 0);
        assert_int_equal(s.samples, n);
    }
}

static void test_bad_input(void **state)
{
    (void)state;
    double x[20] = {0};
    ry_series_statistics s;
    ry_error error = {0};
    x[17] = NAN;
    assert_int_equal(ry_series_mean(x, 20, &s, &error), RY_BAD_INPUT);
    assert_non_null(strstr(error.text, "17"));
    x[17] = INFINITY;
    assert_int_equal(ry_series_equilibrated(x, 20, &s, NULL), RY_BAD_INPUT);
    assert_int_equal(ry_series_mean(x, -1, &s, NULL), RY_BAD_INPUT);
    assert_int_equal(ry_series_mean(NULL, 3, &s, NULL), RY_BAD_INPUT);
}

/* White noise and AR(1), positive and negative: autocorrelation time, error, effective samples. */
static void test_autocorrelation_time(void **state)
{
    (void)state;
    const int64_t n = 100000;
    const double rho[] = {0.0, 0.2, 0.5, 0.8, 0.9, 0.98, -0.2, -0.5, -0.8};
    double *x = series(n);
    for (size_t k = 0; k < sizeof rho / sizeof *rho; k++) {
        const uint32_t seed = 1000 + (uint32_t)k;
        ar1(x, n, rho[k], seed);
        const double tau = 0.5 * (1.0 + rho[k]) / (1.0 - rho[k]);
        const ry_series_statistics s = mean_of(x, n);
        print_message("rho %5.2f  tau %8.4f  found %8.4f  error %.3e  (seed %u)\n", rho[k], tau,
                      s.autocorrelation_time, s.standard_error, seed);
        /* Madras & Sokal 1988: error sqrt(2 (2 M + 1)/n) of tau, M some ten tau; of max(tau, 1/2)
         * where correlations cancel. */
        const double part = fmax(tau, 0.5);
        const double band = 4.0 * sqrt(2.0 * (20.0 * part + 1.0) / (double)n) * part / tau;
        assert_within(s.autocorrelation_time / tau, 1.0 - band, 1.0 + band, "tau/exact", rho[k]);
        assert_within(s.standard_error / sqrt(2.0 * tau / (double)n), 1.0 - band, 1.0 + band,
                      "error/exact", rho[k]);
        assert_within(s.effective_samples * 2.0 * s.autocorrelation_time / (double)n, 1.0 - 1e-12,
                      1.0 + 1e-12, "samples", rho[k]);
    }
    free(x);
}

/* What is stated about a mean holds as often as stated. The band is four standard deviations of the
 * binomial wide, and lower by what the scatter of the estimated error itself costs. */
static void test_coverage(void **state)
{
    (void)state;
    static const struct {
        double rho;
        int64_t n;
        int cut;
        double loss;
    } cases[] = {{0.0, 1000, 0, 0.01}, {0.5, 1000, 0, 0.01}, {0.9, 5000, 0, 0.02},
                 {-0.5, 1000, 0, 0.02}, {0.98, 5000, 0, 0.06}, {0.0, 1000, 1, 0.03},
                 {0.9, 5000, 1, 0.04},
                 /* 10 and 20 independent samples: the best cut is the one that noise favours most */
                 {0.9, 190, 1, 0.05}, {0.9, 380, 1, 0.03}};
    double *x = series(5000);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        int one = 0, two = 0;
        double tau = 0.0;
        for (uint32_t seed = 0; seed < SEEDS; seed++) {
            ar1(x, cases[k].n, cases[k].rho, 2000 + seed);
            const ry_series_statistics s =
                cases[k].cut ? equilibrated(x, cases[k].n) : mean_of(x, cases[k].n);
            one += fabs(s.mean) <= s.standard_error;
            two += fabs(s.mean) <= 2.0 * s.standard_error;
            tau += s.autocorrelation_time / SEEDS;
        }
        const double c1 = (double)one / SEEDS, c2 = (double)two / SEEDS;
        print_message("rho %5.2f  n %5d  cut %d  coverage %.3f %.3f  mean tau %.3f  (seeds %d-%d)\n",
                      cases[k].rho, (int)cases[k].n, cases[k].cut, c1, c2, tau, 2000,
                      2000 + SEEDS - 1);
        const double p1 = 0.6827, p2 = 0.9545;
        const double band1 = 4.0 * sqrt(p1 * (1.0 - p1) / SEEDS);
        const double band2 = 4.0 * sqrt(p2 * (1.0 - p2) / SEEDS);
        assert_within(c1, p1 - band1 - cases[k].loss, p1 + band1, "coverage, 1 sigma", cases[k].rho);
        assert_within(c2, p2 - band2 - cases[k].loss, 1.0, "coverage, 2 sigma", cases[k].rho);
    }
    free(x);
}

/* A weak, slow part beneath strong white noise carries most of the error of the mean. */
static void test_two_scales(void **state)
{
    (void)state;
    const int64_t n = 20000;
    const double rho = 0.98, share = 0.3; /* share: of the slow part in the standard deviation */
    double *x = series(n), *noise = series(n);
    double error2 = 0.0;
    for (uint32_t seed = 0; seed < 50; seed++) {
        ar1(x, n, rho, 3000 + seed);
        ar1(noise, n, 0.0, 4000 + seed);
        for (int64_t i = 0; i < n; i++) {
            x[i] = share * x[i] + noise[i];
        }
        const ry_series_statistics s = mean_of(x, n);
        error2 += s.standard_error * s.standard_error / 50.0;
    }
    const double exact2 = (share * share * (1.0 + rho) / (1.0 - rho) + 1.0) / (double)n;
    print_message("two scales: error/exact %.3f  (seeds 3000-3049, 4000-4049)\n",
                  sqrt(error2 / exact2));
    assert_within(sqrt(error2 / exact2), 0.85, 1.15, "error/exact", rho);
    free(x);
    free(noise);
}

/* A swing in the autocorrelation: the error may be too large, never too small. AR(2) with poles at
 * r exp(+-i w); the variance of the mean is the noise over (1 - a1 - a2)^2. */
static void test_oscillating(void **state)
{
    (void)state;
    const int n = 5000;
    const double r = 0.95, w = 2.0 * PI / 20.0;
    const double a1 = 2.0 * r * cos(w), a2 = -r * r;
    double *x = series(n);
    double ratio = 0.0;
    for (uint32_t seed = 5000; seed < 5020; seed++) {
        double y = 0.0, before = 0.0;
        for (int i = -WARM_UP; i < n; i++) {
            const double next = a1 * y + a2 * before + normal(seed, (uint32_t)(i + WARM_UP));
            before = y;
            y = next;
            if (i >= 0) {
                x[i] = y;
            }
        }
        const double exact = 1.0 / (1.0 - a1 - a2) / sqrt((double)n);
        ratio += mean_of(x, n).standard_error / exact / 20.0;
    }
    print_message("oscillating: error/exact %.3f  (seeds 5000-5019)\n", ratio);
    assert_within(ratio, 0.95, 2.2, "error/exact", w);
    free(x);
}

/* An exponential approach to the mean: the cut lies where the rest of it is lost in the noise. */
static void test_transient(void **state)
{
    (void)state;
    const int64_t n = 10000;
    double *x = series(n);
    int covered = 0;
    for (uint32_t seed = 6000; seed < 6040; seed++) {
        ar1(x, n, 0.9, seed);
        for (int64_t i = 0; i < n; i++) {
            x[i] += 7.0 + 10.0 * exp(-(double)i / 200.0);
        }
        const ry_series_statistics all = mean_of(x, n), s = equilibrated(x, n);
        if (seed == 6000) {
            print_message("transient: mean 7, uncut %.3f, cut at %d: %.3f +- %.3f, tau %.2f "
                          "(seeds 6000-6039)\n",
                          all.mean, (int)s.first, s.mean, s.standard_error, s.autocorrelation_time);
        }
        /* 10 exp(-t/200) equals the noise at 460 and its error of 0.04 at 1100. */
        assert_within((double)s.first, 350, 2500, "cut", seed);
        assert_int_equal(s.first + s.samples, n);
        assert_within(s.autocorrelation_time, 5.0, 20.0, "tau", seed);
        covered += fabs(s.mean - 7.0) <= 2.0 * s.standard_error;
    }
    assert_within(covered, 32, 40, "covered of 40", 0);
    free(x);
}

/* A flux that changes slowly, tau 100, behind a push that is over soon: the cut that is found misses most of it. */
static void test_come_down(void **state)
{
    (void)state;
    const int64_t n = 4000;
    double *x = series(n), with = 0.0, without = 0.0;
    for (uint32_t seed = 7000; seed < 7100; seed++) {
        ar1(x, n, 0.99, seed);
        assert_within((double)ry_series_under_way(x, n), 0, 1000, "nothing to come down from", seed);
        for (int64_t i = 0; i < n; i++) {
            x[i] = 7.0 + x[i] + 30.0 * exp(-(double)i / 30.0);
        }
        const int64_t first = ry_series_under_way(x, n);
        assert_within((double)first, 60, 1000, "come down", seed); /* 30 exp(-t/30) equals the noise at 100 */
        without += (equilibrated(x, n).mean - 7.0) / 100;
        with += (equilibrated(x + first, n - first).mean - 7.0) / 100;
    }
    print_message("behind a push: off by %.3f, %.3f without the way down (+- 0.02)\n", without, with);
    assert_true(fabs(with) < 0.06 && without > 0.06);
    double rest[20] = {0.0};
    assert_int_equal(ry_series_under_way(rest, 20), 0);
    assert_int_equal(ry_series_under_way(rest, 0), 0);
    rest[0] = 1.0;
    assert_int_equal(ry_series_under_way(rest, 20), 1);
    free(x);
}

/* A flux that begins at rest and goes too far at first, as at a high stress without a push. */
static void test_go_up(void **state)
{
    (void)state;
    const int64_t n = 4000;
    double *x = series(n), with = 0.0, without = 0.0;
    for (uint32_t seed = 7100; seed < 7200; seed++) {
        ar1(x, n, 0.99, seed);
        for (int64_t i = 0; i < n; i++) {
            const double t = (double)i;
            x[i] = (40.0 + x[i]) * (1.0 - exp(-t / 20.0)) + 30.0 * (exp(-t / 150.0) - exp(-t / 20.0));
        }
        const int64_t first = ry_series_under_way(x, n);
        assert_within((double)first, 60, 1500, "under way", seed);
        without += (equilibrated(x, n).mean - 40.0) / 100;
        with += (equilibrated(x + first, n - first).mean - 40.0) / 100;
    }
    print_message("from rest: off by %.3f, %.3f with the beginning (+- 0.02)\n", with, without);
    assert_true(fabs(with) < 0.06);
    for (int64_t i = 0; i < n; i++) { /* bursts, the first of them late */
        x[i] = i % 1000 > 900 ? 1.0 : 0.0;
    }
    assert_int_equal(ry_series_under_way(x, n), 0);
    free(x);
}

/* A step that ends past the middle: the cut never takes more than half. */
static void test_cut_is_bounded(void **state)
{
    (void)state;
    const int lengths[] = {16, 17, 100, 5000, 50001};
    for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) {
        const int n = lengths[k];
        double *x = series(n);
        ar1(x, n, 0.0, 7000);
        for (int i = 0; i < n; i++) {
            x[i] += i < 3 * n / 4 ? 100.0 : 0.0;
        }
        const ry_series_statistics s = equilibrated(x, n);
        assert_true(s.first >= 0 && s.samples >= n / 2);
        assert_int_equal(s.first + s.samples, n);
        free(x);
    }
}

/* Scaling and shifting a series does the same to its mean and error. A large mean is the case of a
 * level measured from far away. */
static void test_scale_and_shift(void **state)
{
    (void)state;
    const int n = 3000;
    double *x = series(n), *y = series(n);
    ar1(x, n, 0.7, 8000);
    for (int i = 0; i < n; i++) {
        y[i] = 1e6 + 1e-3 * x[i];
    }
    const ry_series_statistics a = equilibrated(x, n), b = equilibrated(y, n);
    assert_int_equal(a.first, b.first);
    assert_within(b.standard_error / (1e-3 * a.standard_error), 1.0 - 1e-6, 1.0 + 1e-6, "error", 0);
    assert_within((b.mean - 1e6) / (1e-3 * a.mean), 1.0 - 1e-4, 1.0 + 1e-4, "mean", 0);
    free(x);
    free(y);
}

/* Longer than the number of blocks that an estimate takes: the same answer from block means. */
static void test_long_series(void **state)
{
    (void)state;
    const int64_t n = 3000001;
    double *x = series(n);
    ar1(x, n, 0.9, 9000);
    const ry_series_statistics s = equilibrated(x, n);
    print_message("long: n %d  cut %d  tau %.4f (9.5)  (seed 9000)\n", (int)n, (int)s.first,
                  s.autocorrelation_time);
    assert_within(s.autocorrelation_time / 9.5, 0.93, 1.07, "tau/exact", 0.9);
    assert_within(fabs(s.mean), 0.0, 4.0 * s.standard_error, "mean", 0.9);
    free(x);
}

typedef struct job {
    const double *x;
    int64_t n;
    ry_series_statistics result;
    ry_status status;
} job;

static void *work(void *data)
{
    job *j = data;
    for (int i = 0; i < 20; i++) {
        j->status = ry_series_equilibrated(j->x, j->n, &j->result, NULL);
    }
    return NULL;
}

/* Several threads at once, different lengths: each gets the bits that one thread alone gets. */
static void test_threads(void **state)
{
    (void)state;
    enum { JOBS = 6 };
    double *x = series(5000);
    ar1(x, 5000, 0.9, 10000);
    job jobs[JOBS];
    pthread_t threads[JOBS];
    for (int i = 0; i < JOBS; i++) {
        jobs[i] = (job){.x = x, .n = 1000 + 700 * i};
        assert_int_equal(pthread_create(&threads[i], NULL, work, &jobs[i]), 0);
    }
    for (int i = 0; i < JOBS; i++) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
        assert_int_equal(jobs[i].status, RY_OK);
        const ry_series_statistics alone = equilibrated(x, jobs[i].n);
        assert_memory_equal(&alone, &jobs[i].result, sizeof alone);
    }
    free(x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_short_series),    cmocka_unit_test(test_constant),
        cmocka_unit_test(test_bad_input),       cmocka_unit_test(test_autocorrelation_time),
        cmocka_unit_test(test_coverage),        cmocka_unit_test(test_two_scales),
        cmocka_unit_test(test_oscillating),     cmocka_unit_test(test_transient),
        cmocka_unit_test(test_come_down),
        cmocka_unit_test(test_go_up),
        cmocka_unit_test(test_cut_is_bounded),  cmocka_unit_test(test_scale_and_shift),
        cmocka_unit_test(test_long_series),     cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests_name("statistics", tests, NULL, NULL);
}
