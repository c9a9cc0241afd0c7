/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Whole simulations of few grains against closed forms. */
#include "config/laws.h"
#include "law/drag.h"
#include "scene_bench.h"
#include "sim/sim.h"

/* ---- no contact ---------------------------------------------------------------------------------- */

/* Constant acceleration: x = x0 + v t, z = z0 + v t - g t^2/2, exact for any step. */
static void test_free_flight(void **state)
{
    (void)state;
    const double g = 9.81, vx = 0.3, vz = 1.7, dt = 1e-4;
    scene *const s =
        open_scene("time: {step: %g}\ndomain: {gravity: %g}\nparticles:\n"
                   "  - {position: [0.1, 2.0], velocity: [%g, %g], spin: 5, diameter: 1 mm, "
                   "density: 2650}\n",
                   dt, g, vx, vz);
    for (int k = 1; k <= 5; k++) {
        step_scene(s, 2000);
        const double t = 2000.0 * k * dt;
        const grain a = grain_of(s, 0);
        assert_true(fabs(a.x - (0.1 + vx * t)) <= 1e-12);
        assert_true(fabs(a.z - (2.0 + vz * t - 0.5 * g * t * t)) <= 1e-12 * 5.0);
        assert_true(a.vx == vx && a.spin == 5.0);
        assert_true(fabs(a.vz - (vz - g * t)) <= 1e-12 * 10.0);
    }
    close_scene(s);
}

/* Drag coefficients as printed in the sources that src/law/drag.h names. */
static double drag_coefficient(int law, double re, double c)
{
    if (law == 0) {
        return pow(sqrt(c) + sqrt(24.0 / re), 2.0);
    }
    return fmax(24.0 / re * (1.0 + 0.15 * pow(re, 0.687)), c);
}

/* The speed at which drag carries the weight in the fluid, by bisection; law 2 has a closed form. */
static double terminal_speed(int law, double excess, double g, double d, double nu, double c)
{
    if (law == 2) {
        return excess * g * d * d / (18.0 * nu + sqrt(0.75 * c * excess * g * d * d * d));
    }
    double low = 1e-9, high = 100.0;
    for (int k = 0; k < 200; k++) {
        const double w = 0.5 * (low + high);
        const double drag = 0.75 * drag_coefficient(law, w * d / nu, c) * w * w / d;
        *(drag < excess * g ? &low : &high) = w;
    }
    return 0.5 * (low + high);
}

static void test_terminal_velocity(void **state)
{
    (void)state;
    const char *const drags[] = {"dallavalle", "schiller-naumann", "ferguson-church"};
    const char *const models[] = {"stress", "log"};
    const double sizes[] = {0.05e-3, 0.5e-3, 5e-3};
    for (int law = 0; law < 3; law++) {
        for (int k = 0; k < 6; k++) {
            const double d = sizes[k % 3];
            scene *const s = open_scene(
                "time: {step: 1e-4, end: 4}\ndomain: {gravity: 9.81, length: 0.1, periodic: true}\n"
                "fluid: {model: %s, shields: 0, drag: %s, density: 1000, viscosity: 1e-6}\n"
                "particles: [{position: [0.05, 2], diameter: %g, density: 2650}]\n",
                models[k / 3], drags[law], d);
            run_until(s, d < 1e-4 ? 0.2 : 2.0);
            const double exact = terminal_speed(law, 1.65, 9.81, d, 1e-6, 0.4);
            const double error = fabs(-grain_of(s, 0).vz / exact - 1.0);
            printf("%s, d = %g mm: terminal velocity %.5g m/s, error %.1e\n", drags[law], 1e3 * d,
                   exact, error);
            assert_true(error <= 1e-6);
            close_scene(s);
        }
    }
}

/* d ln(rate)/d ln(speed), which the fluid column reckons with, against a difference. */
static void test_power_of_drag(void **state)
{
    (void)state;
    const double d = 0.5e-3, nu = 1e-6, c = 0.4, by = 1e-5;
    for (int k = 0; k <= 60; k++) {
        const double speed = nu / d * pow(10.0, -3.0 + 0.15 * k), more = speed * exp(by), less = speed * exp(-by);
        const double root = sqrt(24.0 * nu / d);
        const double found[] = {ry_drag_dallavalle_power(speed, root, c), ry_drag_schiller_power(speed, nu / d, c),
                                ry_drag_ferguson_power(speed, nu / d, c)};
        const double ratio[] = {ry_drag_dallavalle(more, root, c) / ry_drag_dallavalle(less, root, c),
                                ry_drag_schiller(more, nu / d, c) / ry_drag_schiller(less, nu / d, c),
                                ry_drag_ferguson(more, nu / d, c) / ry_drag_ferguson(less, nu / d, c)};
        for (int law = 0; law < 3; law++) {
            assert_true(fabs(found[law] - log(ratio[law]) / (2.0 * by)) < 1e-6);
        }
    }
}

/* A grain without weight goes with the logarithmic profile above the level that is given. */
static void test_level_of_the_profile(void **state)
{
    (void)state;
    const double tau = 1.0, level = 4e-3, z = 12e-3, roughness = 1e-3;
    scene *const s = open_scene(
        "time: {step: 1e-4, end: 4}\ndomain: {gravity: 0, length: 0.01, periodic: true}\n"
        "fluid: {model: log, shear_stress: %g, level: %g, roughness: %g}\n"
        "particles: [{position: [0.005, %g], diameter: 0.1 mm, density: 2650}]\n",
        tau, level, roughness, z);
    run_until(s, 0.5);
    const double exact = sqrt(tau / 1000.0) / 0.41 * log(30.0 * (z - level) / roughness);
    printf("grain %.6g m/s, profile %.6g\n", grain_of(s, 0).vx, exact);
    assert_true(fabs(grain_of(s, 0).vx / exact - 1.0) <= 1e-4);
    close_scene(s);
}

/* A grain that is shot out of the bed: in each step there is a velocity of the fluid for it that is no older than the
 * column, also where it has left the column at the top, and when the flow sets in. */
static void test_above_the_column(void **state)
{
    (void)state;
    scene *const s = open_scene("time: {step: 10 us, end: 1, settle: 2 ms}\ngrains: {columns: 10, layers: 3}\n"
                                "fluid: {model: balance, shields: 0.4, start: rest, density: 10}\n"
                                "particles: [{position: [2 mm, 4 mm], velocity: [0, 15]}]\n");
    const ry_flow *const f = &s->sim->plan.flow;
    int above = 0;
    for (int step = 0; step < 1200; step++) {
        double highest = 0.0;
        const ry_view v = ry_sim_view(s->sim);
        for (int k = 0; k < v.n; k++) {
            highest = fmax(highest, v.z[k]);
        }
        const int is_first = v.step == 200; /* of the flow */
        const double vx = grain_of(s, 0).vx;
        step_scene(s, 1);
        above += highest > f->nz * f->dz;
        assert_true(f->faces > f->nz || f->faces * f->dz > highest + f->dz);
        assert_true(!is_first || (highest > f->nz * f->dz && grain_of(s, 0).vx > vx));
    }
    assert_true(above > 100);
    close_scene(s);
}

/* ---- sliding to rolling --------------------------------------------------------------------------- */

/* A sphere thrown along a floor without spin: friction mu m g slows it by mu g and spins it up; it rolls
 * from t = 2 v0/(7 mu g) on with 5/7 v0 (angular momentum about the point of contact). */
static void test_sliding_to_rolling(void **state)
{
    (void)state;
    const double v0 = 0.1, mu = 0.3, g = 9.81, end = 2.0 * v0 / (7.0 * mu * g);
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        scene *const s = open_scene(
            "time: {step: 1e-6, end: 1}\ndomain: {gravity: %g, floor: flat}\n"
            "contact: {law: %s, alpha_m: 60, alpha_cn: 0.3, friction: %g}\n"
            "particles: [{position: [0, 0.5 mm], velocity: [%g, 0], diameter: 1 mm, density: 2650}]\n",
            g, law_words[law], mu, v0);
        run_until(s, 0.5 * end);
        const double half = grain_of(s, 0).vx / (v0 - 0.5 * mu * g * end) - 1.0;
        run_until(s, 0.98 * end);
        const grain early = grain_of(s, 0);
        run_until(s, 1.02 * end);
        const grain late = grain_of(s, 0);
        run_until(s, 2.0 * end);
        const grain last = grain_of(s, 0);
        const double rolled = last.vx / (5.0 / 7.0 * v0) - 1.0;
        printf("%s: half way %+.1e, rolling %+.1e, slips %.1e before and %.1e after\n",
               law_words[law], half, rolled, 1.0 - early.spin * early.radius / early.vx,
               1.0 - late.spin * late.radius / late.vx);
        assert_true(fabs(half) <= 0.01);
        assert_true(fabs(rolled) <= 1e-3);
        assert_true(fabs(last.spin * last.radius / last.vx - 1.0) <= 2e-3);
        close_scene(s);
    }
}

/* ---- a single bounce -------------------------------------------------------------------------------- */

/* Restitution against the floor, without gravity, in steps of 1/alpha of the period. */
static double bounce_once(const char *law, double e, double alpha_m, const char *mapping,
                          double phase, double *says)
{
    const double speed = alpha_m > 1e3 ? 1e-4 : 0.5;
    scene *const s = open_scene(
        "time: {step: 1e-6}\ndomain: {floor: flat}\n"
        "contact: {law: %s, alpha_m: %g, restitution: %.17g, friction: 0, mapping: %s}\n"
        "particles: [{position: [0, %.17g], velocity: [0, %.17g], diameter: 1 mm, density: 2650}]\n",
        law, alpha_m, e, mapping, 0.5e-3 + speed * 1e-6 * (2.0 + phase), -speed);
    step_scene(s, 200 + (long long)(3.0 * alpha_m));
    *says = ry_config_derive(&s->config).restitution_wall;
    const double after = grain_of(s, 0).vz / speed;
    close_scene(s);
    return after;
}

static void test_single_bounce(void **state)
{
    (void)state;
    const double e = 0.7;
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        const double alpha_m = ry_laws[law].ratio ? 1e5 : 20.0;
        double worst = 0.0, says = 0.0;
        for (int k = 0; k < 8; k++) {
            const double after = bounce_once(law_words[law], e, alpha_m, k % 2 ? "usual" : "exact",
                                             0.125 * k, &says);
            worst = fmax(worst, fabs(after - says));
        }
        printf("%s: a bounce with e = 0.7 is told to be %.6f, off by %.1e\n", law_words[law], says,
               worst);
        const double limit =
            ry_laws[law].ratio ? 2e-4 : law == RY_LAW_FUJIOKA2_PRINTED ? 1e-4 : 1e-12;
        assert_true(worst <= limit);
    }
}

/* ---- bounces under gravity --------------------------------------------------------------------------- */

/* bounce-slow.yaml: each bounce keeps e^2 = 0.49 of the energy as long as the flight before it lasts 20
 * steps or more. */
static void test_bounces(void **state)
{
    (void)state;
    scene *const s = open_file("bounce-slow.yaml", 1, "time.end=5");
    const double dt = s->config.time_step, g = s->config.domain_gravity;
    double before = 0.0, flight = 0.0, worst = 0.0;
    int bounces = 0, was_down = 1;
    for (int k = 1; k <= 5000; k++) {
        step_scene(s, 1);
        const grain a = grain_of(s, 0);
        const double height = a.z - a.radius, energy = 0.5 * a.vz * a.vz + g * height;
        const int up = a.vz > 0.0 && height > 0.0;
        if (up && was_down) {
            if (flight >= 20.0) {
                worst = fmax(worst, fabs(energy / before / 0.49 - 1.0));
                bounces++;
            }
            flight = 2.0 * sqrt(2.0 * energy) / (g * dt);
        }
        was_down = up ? 0 : (a.vz < 0.0 ? 1 : was_down);
        if (up || (bounces == 0 && k == 1)) {
            before = energy;
        }
        if (k == 1) {
            flight = 1e9;
        }
    }
    printf(
        "slow bounce: %d bounces after flights of 20 steps or more, energy ratio off by at most %.1e\n",
        bounces, worst);
    assert_true(bounces >= 12);
    assert_true(worst <= 0.01);
    close_scene(s);
}

/* ---- three spheres ------------------------------------------------------------------------------------ */

/* Section 5.6 of Fujioka & Ushijima (2005): k, eq. 29, and d' = sqrt((sqrt3/2 - k) k^2/(1 + k^2)), eq. 28. */
static double three_spheres_exact(void)
{
    const double k = cbrt(0.5 * (sqrt(3.0) + sqrt(7.0))) + cbrt(0.5 * (sqrt(3.0) - sqrt(7.0)));
    return sqrt((0.5 * sqrt(3.0) - k) * k * k / (1.0 + k * k));
}

static double three_spheres(const char *law, double dt)
{
    scene *const s = open_file("three-spheres.yaml", 1, "time.step=%g contact.law=%s", dt, law);
    run_until(s, 0.12);
    const grain a = grain_of(s, 0), b = grain_of(s, 1);
    close_scene(s);
    return 0.5 * (b.vx - a.vx) / sqrt(4.0 * 9.8 * 0.02);
}

static void test_three_spheres(void **state)
{
    (void)state;
    const double exact = three_spheres_exact();
    const double dt[] = {1e-4, 1e-5, 1e-6}, goal[] = {1.6e-4, 1.6e-6, 1.6e-8};
    assert_true(fabs(exact - 0.271463) < 5e-7);
    double error[RY_LAW_COUNT][3];
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        for (int k = 0; k < 3; k++) {
            error[law][k] = fabs(three_spheres(law_words[law], dt[k]) / exact - 1.0);
        }
        printf("three spheres, %s: d' off by %.2e, %.2e, %.2e at dt = 1e-4, 1e-5, 1e-6\n",
               law_words[law], error[law][0], error[law][1], error[law][2]);
    }
    for (int k = 0; k < 3; k++) {
        assert_true(error[RY_LAW_ENERGY][k] <= goal[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_free_flight),          cmocka_unit_test(test_terminal_velocity),
        cmocka_unit_test(test_power_of_drag),
        cmocka_unit_test(test_level_of_the_profile), cmocka_unit_test(test_sliding_to_rolling),
        cmocka_unit_test(test_single_bounce),        cmocka_unit_test(test_bounces),
        cmocka_unit_test(test_three_spheres),        cmocka_unit_test(test_above_the_column),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
