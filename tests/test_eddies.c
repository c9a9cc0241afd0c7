/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * fluid.turbulence: walk. What is drawn is normal; grains that follow the fluid at once have the moments of its eddies,
 * <u'w'> = -s^2, <u'^2> = 2 s^2, <w'^2> = s^2, s = u_star in a log profile; eddies last as long as they are to; s is
 * what the closure of model balance says; and what the stress gives is what fluid, grains and floor get. */
#include "base/random.h"
#include "scene_bench.h"
#include "sim/sim.h"
#include "stage/eddies.h"

/* ---- what is drawn ------------------------------------------------------------------------------------ */

static void test_normal(void **state)
{
    (void)state;
    enum { N = 200000, BOUNDS = 7 };
    /* Part of a normal distribution below -3 ... 3. */
    static const double below[BOUNDS] = {0.001349898, 0.022750132, 0.158655254, 0.5,
                                          0.841344746, 0.977249868, 0.998650102};
    double sum[2] = {0.0, 0.0}, square[2] = {0.0, 0.0}, both = 0.0, count[BOUNDS] = {0.0};
    for (int n = 0; n < N; n++) {
        double drawn[2], again[2];
        ry_random_normal(7, RY_RANDOM_EDDY, (uint64_t)(n / 100), (uint32_t)(n % 100), drawn);
        ry_random_normal(7, RY_RANDOM_EDDY, (uint64_t)(n / 100), (uint32_t)(n % 100), again);
        assert_true(drawn[0] == again[0] && drawn[1] == again[1]);
        for (int q = 0; q < 2; q++) {
            sum[q] += drawn[q];
            square[q] += drawn[q] * drawn[q];
            for (int b = 0; b < BOUNDS; b++) {
                count[b] += drawn[q] < b - 3.0;
            }
        }
        both += drawn[0] * drawn[1];
    }
    for (int q = 0; q < 2; q++) { /* within five standard errors */
        assert_true(fabs(sum[q] / N) < 5.0 / sqrt(N));
        assert_true(fabs(square[q] / N - 1.0) < 5.0 * sqrt(2.0 / N));
    }
    assert_true(fabs(both / N) < 5.0 / sqrt(N));
    for (int b = 0; b < BOUNDS; b++) {
        const double error = sqrt(below[b] * (1.0 - below[b]) / (2.0 * N));
        printf("below %+d: %.6f, normal %.6f\n", b - 3, count[b] / (2.0 * N), below[b]);
        assert_true(fabs(count[b] / (2.0 * N) - below[b]) < 5.0 * error);
    }
}

/* ---- what a grain feels ------------------------------------------------------------------------------- */

/* A row of grains at one height, far from each other. */
static scene *open_row(int n, double z, const char *fixed, const char *fluid, double step, const char *more)
{
    char *const text = malloc((size_t)n * 90 + 1000);
    int at = sprintf(text, "domain: {length: %.9g, periodic: true, floor: none, gravity: 0}\n"
                           "fluid: {%s, start: rest, turbulence: walk%s}\n"
                           "time: {step: %.9g, end: 100, settle: 0}\nparticles:\n", n * 2e-3, fluid, more, step);
    for (int k = 0; k < n; k++) {
        at += sprintf(text + at, "  - {position: [%.9g, %.9g], diameter: 0.5 mm, fixed: %s}\n", (k + 0.5) * 2e-3, z, fixed);
    }
    scene *const s = open_text(text);
    free(text);
    return s;
}

/* In an oil in which a grain has the fluid's velocity after a few steps. */
static void test_moments(void **state)
{
    (void)state;
    enum { GRAINS = 4000, STEPS = 20 };
    scene *const s = open_row(GRAINS, 0.02, "false", "model: log, shear_stress: 3 Pa, level: 0, viscosity: 1e-1", 2e-5, "");
    const double star = sqrt(3.0 / 1000.0);
    step_scene(s, STEPS);
    const ry_view v = ry_sim_view(s->sim);
    double u = 0.0, w = 0.0, uu = 0.0, ww = 0.0, uw = 0.0;
    for (int k = 0; k < GRAINS; k++) {
        u += v.vx[k] / GRAINS;
        w += v.vz[k] / GRAINS;
    }
    for (int k = 0; k < GRAINS; k++) {
        uu += (v.vx[k] - u) * (v.vx[k] - u) / (GRAINS * star * star);
        ww += (v.vz[k] - w) * (v.vz[k] - w) / (GRAINS * star * star);
        uw += (v.vx[k] - u) * (v.vz[k] - w) / (GRAINS * star * star);
    }
    const double flow = star / RY_FLOW_KAPPA * log(30.0 * 0.02 / (2.5 * 0.5e-3));
    printf("<u> %.4f of %.4f m/s, <u'u'> %.3f, <w'w'> %.3f, <u'w'> %.3f u_star^2\n", u, flow, uu, ww, uw);
    assert_true(fabs(u - flow) < 5.0 * star * sqrt(2.0 / GRAINS) + 0.01 * star);
    assert_true(fabs(w) < 5.0 * star / sqrt(GRAINS));
    assert_true(fabs(uu - 2.0) < 5.0 * 2.0 * sqrt(2.0 / GRAINS));
    assert_true(fabs(ww - 1.0) < 5.0 * sqrt(2.0 / GRAINS));
    assert_true(fabs(uw + 1.0) < 5.0 * sqrt(3.0 / GRAINS)); /* <u'^2 w'^2> = 4 */
    close_scene(s);
}

/* How many eddies a held grain meets in `seconds`. */
static double count_eddies(scene *s, double seconds, double dt)
{
    const ry_grains *const g = &s->sim->state.grains;
    double count = 0.0, met = 0.0;
    for (double t = 0.0; t < seconds; t += dt) {
        step_scene(s, 1);
        count += g->met[0] != met;
        met = g->met[0];
    }
    return count;
}

static void test_lifetimes(void **state)
{
    (void)state;
    const char *const flow = "model: log, shear_stress: 3 Pa, level: 0, advance: 1";
    const double star = sqrt(3.0 / 1000.0), z = 2e-3, dt = 2e-5, seconds = 1.0;
    scene *const given = open_row(3, z, "true", flow, dt, ", eddy_time: 5 ms");
    scene *const local = open_row(3, z, "true", flow, dt, "");
    const double lasts = RY_EDDY_TURN * RY_FLOW_KAPPA * z / star;
    const double some = count_eddies(given, seconds, dt), more = count_eddies(local, seconds, dt);
    printf("%g eddies of 5 ms in 1 s; %g of %.3g ms\n", some, more, 1e3 * lasts);
    assert_true(fabs(some - seconds / 5e-3) <= 1.0);
    assert_true(fabs(more - seconds / lasts) < 0.02 * seconds / lasts);
    close_scene(given);
    close_scene(local);
}

/* ---- model balance ------------------------------------------------------------------------------------ */

/* What is left of the stress without viscosity is what the mixing length makes: l^2 u'^2. */
static void test_reynolds(void **state)
{
    (void)state;
    scene *const s = open_row(8, 2e-3, "true", "model: balance, shear_stress: 3 Pa", 2e-5, "");
    step_scene(s, 20000);
    const ry_flow *const f = &s->sim->plan.flow;
    const ry_column *const c = &s->sim->state.column;
    double largest = 0.0, worst = 0.0;
    for (int k = 1; k + 1 < f->clear; k++) {
        double mean = 0.0;
        for (int face = k - 1; face <= k; face++) {
            const double shear = (c->u[face + 1] - c->u[face]) / c->dz;
            mean += 0.5 * f->mix[face] * f->mix[face] * shear * fabs(shear);
        }
        largest = fmax(largest, mean);
        worst = fmax(worst, fabs(mean - f->reynolds[k]));
    }
    const double star2 = 3.0 / 1000.0;
    const int high = f->valid - 2; /* nothing takes momentum there */
    const double carried = f->viscosity * (c->u[high + 1] - c->u[high - 1]) / (2.0 * c->dz);
    printf("Reynolds stress up to %.3f of tau_b, off by %.1e of it; above the grains %.3f, and viscosity %.3f\n",
           largest / star2, worst / star2, f->reynolds[high] / star2, carried / star2);
    assert_true(largest > 0.5 * star2);
    assert_true(worst < 1e-5 * star2); /* less than a millionth of tau_b is none */
    assert_true(fabs(f->reynolds[high] + carried - star2) < 1e-9 * star2);
    close_scene(s);
}

/* Held grains, which feel other forces at each moment: the fluid loses just what they get. */
static void test_momentum(void **state)
{
    (void)state;
    enum { GRAINS = 30, ADVANCE = 20, TIMES = 1000 };
    scene *const s = open_row(GRAINS, 1.5e-3, "true", "model: balance, shear_stress: 3 Pa", 2e-5, "");
    const ry_flow *const f = &s->sim->plan.flow;
    const ry_column *const c = &s->sim->state.column;
    const ry_grains *const g = &s->sim->state.grains;
    const double area = f->length * f->d * f->dt * ADVANCE;
    double floor = 0.0, got = 0.0, squares = 0.0;
    for (int n = 0; n < TIMES; n++) {
        step_scene(s, ADVANCE);
        double force = 0.0;
        for (int k = 0; k < GRAINS; k++) {
            force += g->push[k] / ADVANCE;
        }
        got += force * f->dt * ADVANCE;
        squares += force * force / TIMES;
        floor += f->density * (1.0 - c->phi[0]) * f->viscosity * c->u[0] / (0.5 * c->dz) * area;
    }
    double has = 0.0;
    for (int k = 0; k < f->clear; k++) {
        has += f->density * (1.0 - c->phi[k]) * c->u[k] * c->dz * f->length * f->d;
    }
    const double given = TIMES * f->tau * area, mean = got / (TIMES * ADVANCE * f->dt);
    printf("given %.6g: grains %.6g, floor %.3g, fluid %.3g N s; the force varies by %.0f %%\n", given, got, floor, has,
           100.0 * sqrt(squares / (mean * mean) - 1.0));
    assert_true(fabs(got + floor + has - given) < 3.0 * f->tau * area); /* of a thousand advances */
    assert_true(squares > 1.01 * mean * mean);
    close_scene(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normal),   cmocka_unit_test(test_moments),  cmocka_unit_test(test_lifetimes),
        cmocka_unit_test(test_reynolds), cmocka_unit_test(test_momentum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
