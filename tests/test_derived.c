/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What follows from a scene: stiffness and damping, restitution, scales of the fluid, numbers of
 * steps, and the limits of the time step. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ryusa/config.h"

#define BED "grains: {columns: 5, layers: 2}\n"

static ry_status parse(ry_config *config, const char *text, const char *override_, ry_error *error)
{
    *error = (ry_error){0};
    return ry_config_parse(config, text, "scene.yaml", &override_, override_ != NULL, error);
}

/* A config that must load. */
static ry_config good(const char *text, const char *override_)
{
    ry_config config;
    ry_error error;
    if (parse(&config, text, override_, &error) != RY_OK) {
        fail_msg("%s", error.text);
    }
    return config;
}

static void restitution_and_damping(void **state)
{
    (void)state;
    static const double pairs[][2] = {{0.05, 0.859}, {0.2155, 0.5503}, {0.4, 0.364}, {0.7, 0.210},
                                      {1.0, 0.1353}, {1.3, 0.0937},    {3.0, 0.0238}};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        assert_true(fabs(ry_restitution_from_damping(pairs[i][0]) - pairs[i][1]) < 6e-4);
    }
    assert_true(ry_restitution_from_damping(0.0) == 1.0);
    assert_true(ry_damping_from_restitution(1.0) == 0.0);
    assert_true(isinf(ry_damping_from_restitution(0.0)));
    assert_true(ry_restitution_from_damping(INFINITY) == 0.0);
    double last = 1.0;
    for (double zeta = 1e-6; zeta < 1e4; zeta *= 1.001) {
        const double e = ry_restitution_from_damping(zeta);
        assert_true(e < last);
        last = e;
        assert_true(fabs(ry_restitution_from_damping(ry_damping_from_restitution(e)) / e - 1) <
                    1e-12);
    }
    for (double h = -1e-4; h < 1e-4; h += 1.7e-7) { /* continuous where the three forms meet */
        const double slope = exp(-2.0) * (1.0 + 4.0 / 3.0 * h + (0.4 + 8.0 / 9.0) * h * h);
        assert_true(fabs(ry_restitution_from_damping(1.0 - h) - slope) < 1e-12);
    }
}

/* The same restitution by integrating the impact in small steps. */
static double integrated_restitution(double zeta)
{
    const double dt = 1e-5;
    double x = 0.0, v = 1.0;
    for (;;) { /* midpoint rule */
        const double xm = x + 0.5 * dt * v, vm = v - 0.5 * dt * (2.0 * zeta * v + x);
        x += dt * vm;
        v -= dt * (2.0 * zeta * vm + xm);
        if (2.0 * zeta * v + x <= 0.0) {
            return -v;
        }
    }
}

static void restitution_by_integration(void **state)
{
    (void)state;
    for (double zeta = 0.05; zeta < 4.0; zeta *= 1.5) {
        assert_true(fabs(integrated_restitution(zeta) - ry_restitution_from_damping(zeta)) < 1e-5);
    }
}

static void harada_constants(void **state)
{
    (void)state;
    ry_config config;
    ry_error error = {0};
    if (ry_config_load(&config, RY_SOURCE_DIR "/params/harada.yaml", NULL, 0, &error) != RY_OK) {
        fail_msg("%s", error.text);
    }
    const ry_derived q = ry_config_derive(&config);
    const double pi = 3.14159265358979323846, m = 2650.0 * pi / 6.0 * 1.25e-10;
    assert_true(fabs(q.mass / m - 1.0) < 1e-14);
    /* alpha_m: T = 2 pi sqrt(m/k) = 20 dt; alpha_cn: eta = 1.3 x 2 sqrt(m k) */
    assert_true(fabs(2.0 * pi * sqrt(m / q.stiffness) / (20.0 * 20e-6) - 1.0) < 1e-14);
    assert_true(fabs(q.damping / (2.6 * sqrt(m * q.stiffness)) - 1.0) < 1e-14);
    const double wet = m * (1.0 + 0.5 * 1000.0 / 2650.0);
    assert_true(fabs(q.step_ratio / (2.0 * q.stiffness * 4e-10 / wet) - 1.0) < 1e-14);
    assert_true(fabs(q.zeta_pair / (q.damping / (2.0 * sqrt(wet / 2 * q.stiffness))) - 1.0) <
                1e-14);
    assert_true(config.contact_restitution == ry_restitution_from_damping(q.zeta_pair));
    assert_true(fabs(q.shear_stress - 0.2 * 1650.0 * 9.81 * 0.5e-3) < 1e-12);
    assert_true(fabs(q.friction_velocity - sqrt(q.shear_stress / 1000.0)) < 1e-15);
    assert_true(fabs(q.flux_unit - sqrt(1.65 * 9.81 * 1.25e-10)) < 1e-15);
    assert_true(fabs(q.length - 10e-3) < 1e-16);
    assert_true(q.steps_settle == 25000 && q.steps_end == 300000);
    assert_true(q.steps_frame == 500 && q.steps_series == 50);
    config.contact_beta = 15.8; /* k falls with beta^2, eta stays */
    const ry_derived soft = ry_config_derive(&config);
    assert_true(fabs(soft.stiffness * 15.8 * 15.8 / q.stiffness - 1.0) < 1e-13);
    assert_true(fabs(soft.damping / q.damping - 1.0) < 1e-13);
    ry_config_free(&config);
}

static void frames_and_samples(void **state)
{
    (void)state;
    static const struct {
        const char *interval;
        int frame, series;
    } cases[] = {{"1e-9", 1, 1},     {"20 us", 1, 1},       {"49 us", 2, 2},
                 {"10 ms", 500, 50}, {"9.98 ms", 499, 499}, {"2 ms", 100, 50},
                 {"1.5 ms", 75, 75}, {"0.02", 1000, 50},    {"6.4 ms", 320, 40},
                 {"50.06 ms", 2503, 2503}, {"0.10012", 5006, 2503}, {"380 us", 19, 19}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[100];
        (void)snprintf(text, sizeof text, BED "output: {interval: %s}\n", cases[i].interval);
        ry_config config = good(text, NULL);
        const ry_derived q = ry_config_derive(&config);
        assert_int_equal(q.steps_frame, cases[i].frame);
        assert_int_equal(q.steps_series, cases[i].series);
        assert_true(config.output_interval == cases[i].frame * config.time_step);
        ry_config_free(&config);
    }
    ry_config config = good(BED "time: {end: 0, settle: 0}\n", NULL);
    assert_int_equal(ry_config_derive(&config).steps_end, 0);
    ry_config_free(&config);
}

static void restitution_of_the_laws(void **state)
{
    (void)state;
    const char *scene = "particles: [{position: [0, 0]}]\ncontact: {restitution: 0.5}\n";
    ry_config config = good(scene, "contact.law=cundall");
    ry_derived q = ry_config_derive(&config);
    assert_true(fabs(q.zeta_impact - 0.21545376) < 1e-8);
    assert_true(fabs(q.restitution - 0.5503) < 1e-4 && q.restitution == q.restitution_wall);
    ry_config_free(&config);
    config = good(BED "contact: {restitution: 0.5, law: cundall}\n", "contact.mapping=exact");
    q = ry_config_derive(&config);
    assert_true(fabs(q.restitution - 0.5) < 1e-12);
    ry_config_free(&config);
    config = good(scene, "contact.law=cundall-tension");
    assert_true(fabs(ry_config_derive(&config).restitution - 0.5) < 1e-15);
    ry_config_free(&config);
    config = good(scene, NULL);
    q = ry_config_derive(&config);
    assert_true(q.restitution == 0.5 && q.restitution_wall == 0.5 && isnan(q.zeta_impact));
    ry_config_free(&config);
    /* No restitution: the dashpot rules, and a wall makes another pair of it. */
    config =
        good("particles: [{position: [0, 0]}]\ncontact: {alpha_cn: 0.1}\n", "contact.law=cundall");
    q = ry_config_derive(&config);
    assert_true(isnan(q.zeta_impact));
    assert_true(fabs(q.restitution - ry_restitution_from_damping(0.1 * sqrt(2.0))) < 1e-15);
    assert_true(fabs(q.restitution_wall - ry_restitution_from_damping(0.1)) < 1e-15);
    ry_config_free(&config);
}

/* The step that a message allows is allowed, 1 % more is not. */
static void limits_are_sharp(void **state)
{
    (void)state;
    static const char *const laws[] = {"cundall", "cundall-tension", "energy", "tanaka",
                                       "fujioka-2"};
    for (size_t i = 0; i < sizeof laws / sizeof laws[0]; i++) {
        for (int bed = 0; bed < 2; bed++) {
            char text[300], change[60];
            (void)snprintf(text, sizeof text, "%s\ncontact: {law: %s, alpha_m: 2}\n",
                           bed ? BED : "particles: [{position: [0, 0]}, {position: [1, 0]}]",
                           laws[i]);
            ry_config config;
            ry_error error;
            if (parse(&config, text, NULL, &error) == RY_OK) { /* tanaka with two grains */
                ry_config_free(&config);
                continue;
            }
            const char *at = strstr(error.text, "contact.alpha_m of at least ");
            assert_non_null(at);
            const double allowed = strtod(at + strlen("contact.alpha_m of at least "), NULL);
            (void)snprintf(change, sizeof change, "contact.alpha_m=%.10g", allowed);
            config = good(text, change);
            ry_config_free(&config);
            (void)snprintf(change, sizeof change, "contact.alpha_m=%.10g", allowed * 0.99);
            assert_int_equal(parse(&config, text, change, &error), RY_BAD_INPUT);
            assert_non_null(strstr(error.text, "too few steps"));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(restitution_and_damping), cmocka_unit_test(restitution_by_integration),
        cmocka_unit_test(harada_constants),        cmocka_unit_test(frames_and_samples),
        cmocka_unit_test(restitution_of_the_laws), cmocka_unit_test(limits_are_sharp),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
