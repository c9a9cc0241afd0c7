/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * contact.sleep: what it changes. Impacts, the flux, and the stress in the bed are as without.
 * ctest: slow */
#include "sleep_bench.h"

/* ---- what it changes ----------------------------------------------------------------------------- */

typedef struct mean {
    double sum, sum2;
    int n;
} mean;

static void add(mean *m, double value)
{
    m->sum += value;
    m->sum2 += value * value;
    m->n++;
}

static double average(const mean *m)
{
    return m->sum / m->n;
}

static double standard_error2(const mean *m)
{
    return (m->sum2 / m->n - average(m) * average(m)) / (m->n - 1);
}

/* The difference is within three standard errors, and those are small enough to tell something. */
static void check_agree(const char *what, const mean *a, const mean *b, double most)
{
    const double error = sqrt(standard_error2(a) + standard_error2(b));
    printf("%s: %.4g with sleep, %.4g without, +- %.2g\n", what, average(a), average(b), error);
    assert_true(error < most * average(b));
    assert_true(fabs(average(a) - average(b)) < 3.0 * error);
}

/* A grain falls for 0.3 s onto a dry bed that has come to rest meanwhile: 3 m/s. How many grains are moved, and how
 * fast the fastest goes up again. */
static void impact(int trial, double sleep, mean *moved, mean *rebound)
{
    scene *const s = open_scene("time: {step: 10 us, end: 1 s}\n"
                                "domain: {periodic: true, floor: rough, gravity: 9.81, length: 8 mm}\n"
                                "grains: {diameter: 0.5 mm, spread: 0.1, columns: 16, layers: 8, seed: %d}\n"
                                "particles: [{position: [%g mm, 450 mm], diameter: 0.5 mm}]\n"
                                "contact: {restitution: 0.5, sleep: %g}\nfluid: {model: none}\n"
                                "output: {fields: [flux]}\n", 1 + trial, 0.37 * trial, sleep);
    double before[400], fastest = 0.0;
    run_until(s, 0.295);
    assert_true(sleep == 0.0 || asleep(s) > 0.95);
    ry_view v = ry_sim_view(s->sim);
    for (int k = 0; k < v.n; k++) {
        before[v.id[k]] = v.x[k] + v.image[k] * 8e-3;
    }
    while (v.time < 0.32) {
        step_scene(s, 100);
        v = ry_sim_view(s->sim);
        for (int k = 0; k < v.n; k++) {
            fastest = fmax(fastest, v.vz[k]);
        }
    }
    int n = 0;
    for (int k = 0; k < v.n; k++) {
        n += fabs(v.x[k] + v.image[k] * 8e-3 - before[v.id[k]]) > 0.2 * 0.5e-3;
    }
    add(moved, n);
    add(rebound, fastest);
    close_scene(s);
}

static void test_impact(void **state)
{
    (void)state;
    mean moved[2] = {{0}}, rebound[2] = {{0}};
    for (int trial = 0; trial < 24; trial++) {
        impact(trial, 1.0, &moved[0], &rebound[0]);
        impact(trial, 0.0, &moved[1], &rebound[1]);
    }
    check_agree("grains moved by an impact", &moved[0], &moved[1], 0.2);
    check_agree("speed upwards", &rebound[0], &rebound[1], 0.2);
}

/* One bed's mean: beds differ by more than their means are uncertain by (0.08 of 0.80, 32 beds). */
static double run_flume(int seed, const char *sleep, mean *q)
{
    scene *const s = open_file("flume.yaml", 1, "grains.columns=16 grains.layers=22 fluid.shields=0.4 grains.seed=%d "
                               "output.fields=[flux] contact.sleep=%s", seed, sleep);
    run_until(s, 0.8);
    double sum = 0.0;
    for (int k = 0; k < 600; k++) {
        step_scene(s, 100);
        sum += ry_sim_sample(s->sim).q_star / 600;
    }
    add(q, sum);
    const double part = asleep(s);
    close_scene(s);
    return part;
}

static void test_flux(void **state)
{
    (void)state;
    mean with = {0}, without = {0};
    double part = 0.0;
    for (int seed = 1; seed <= 10; seed++) {
        part += run_flume(seed, "1", &with) / 10;
        run_flume(seed, "0", &without);
    }
    printf("asleep: %.2f\n", part);
    assert_true(part > 0.3);
    check_agree("q*", &with, &without, 0.1);
}

/* A bed that has fallen asleep in still water wakes when the flow sets in, and goes on flowing, near the threshold too:
 * there drag is less than what others load a grain with. */
static void test_near_threshold(void **state)
{
    (void)state;
    const char *const sleep[] = {"0", "1", "5"};
    double q[3] = {0.0};
    for (int k = 0; k < 3; k++) {
        scene *const s = open_file("flume.yaml", 1, "grains.columns=40 grains.layers=15 grains.packing=random "
                                   "fluid.shields=0.15 output.fields=[flux] contact.sleep=%s", sleep[k]);
        run_until(s, 1.0);
        for (int n = 0; n < 400; n++) {
            step_scene(s, 100);
            q[k] += ry_sim_sample(s->sim).q_star / 400;
        }
        printf("theta = 0.15, sleep %s: q* %.3f, asleep %.2f\n", sleep[k], q[k], asleep(s));
        close_scene(s);
    }
    assert_true(q[0] > 0.05);
    assert_true(fabs(q[1] / q[0] - 1.0) < 0.4 && fabs(q[2] / q[0] - 1.0) < 0.4);
}

/* What sleeps passes the stress on: tau_fluid + tau_grain is the same from below the moving layers down to the
 * floor; and tau_b, but for what the moving grains still gain in 0.8 s (5 % without sleep, too). */
static void test_stress(void **state)
{
    (void)state;
    scene *const s = open_file("flume.yaml", 1, "grains.columns=16 grains.layers=22 fluid.shields=0.4 contact.sleep=1 "
                               "output.fields=[flux,profile]");
    run_until(s, 0.8);
    const ry_measure *const m = &s->sim->plan.measure;
    double part = 0.0;
    for (int k = 0; k < 800; k++) {
        step_scene(s, 50);
        ry_sim_profile(s->sim);
        part += asleep(s) / 800;
    }
    assert_true(part > 0.3);
    const double tau_b = s->sim->plan.derived.shear_stress;
    double least = INFINITY, most = -INFINITY;
    const int below_bed = (int)((ry_sim_sample(s->sim).bed_level - 4.0 * 0.5e-3) / m->dz);
    for (int z = 6; z < below_bed; z++) { /* not the row of the floor */
        const double sum = (m->tau_grain[z] + m->tau_fluid[z]) / (double)m->samples;
        least = fmin(least, sum / tau_b);
        most = fmax(most, sum / tau_b);
    }
    printf("stress in the bed: %.4f to %.4f of that on it\n", least, most);
    assert_true(most - least < 0.01);
    assert_true(least > 0.9 && most < 1.1);
    close_scene(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_impact),
        cmocka_unit_test(test_flux),
        cmocka_unit_test(test_near_threshold),
        cmocka_unit_test(test_stress),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
