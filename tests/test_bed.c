/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Beds of grains: they come to rest and stay there, and a sheared bed takes from the fluid what the
 * fluid loses.
 * ctest: slow */
#include "analysis/relations.h"
#include "scene_bench.h"
#include "sim/sim.h"

/* Kinetic energy per grain that can move, in units of m g' d of the mean grain. */
static double agitation(scene *s)
{
    const ry_derived q = ry_config_derive(&s->config);
    const ry_view v = ry_sim_view(s->sim);
    int n = 0;
    for (int k = 0; k < v.n; k++) {
        n += !v.fixed[k];
    }
    return ry_sim_sample(s->sim).kinetic_energy / (n * q.mass * q.buoyant_gravity * q.d);
}

/* ---- rest ----------------------------------------------------------------------------------------- */

/* Largest agitation in ten looks from `from` to `to`. */
static double largest(scene *s, double from, double to)
{
    double most = 0.0;
    for (int k = 0; k < 10; k++) {
        run_until(s, from + (to - from) * k / 9.0);
        most = fmax(most, agitation(s));
    }
    return most;
}

static void test_settling(void **state)
{
    (void)state;
    const double alpha_m[] = {10.0, 20.0, 60.0, 400.0}, alpha_cn[] = {0.1, 1.3, 20.0};
    /* the slowest mode of the bed dies out with zeta w0 over the square of the layers; one bed in ten has one that
     * takes twice as long (16 seeds looked at) */
    const double ends[4][3] = {{2.0, 2.0, 2.0}, {3.0, 4.0, 2.5}, {4.5, 2.0, 2.0}, {4.0, 2.0, 1.2}};
    int failed = 0;
    for (int seed = 1; seed <= 2; seed++) {
        for (int i = 0; i < 4; i++) {
            for (int k = 0; k < 3; k++) {
                const int slowly = alpha_m[i] > 100.0 && alpha_cn[k] < 1.0;
                const double end = ends[i][k];
                const double gravity =
                    alpha_m[i] > 100.0 ? 6.1 : 9.81; /* in water, or the bed is too soft */
                scene *const s = open_file("settle.yaml", 1,
                                           "grains.seed=%d contact.alpha_m=%g contact.alpha_cn=%g "
                                           "time.end=%g domain.gravity=%g",
                                           seed, alpha_m[i], alpha_cn[k], end, gravity);
                const double half = largest(s, 0.4 * end, 0.5 * end),
                             last = largest(s, 0.8 * end, end);
                printf("settle, seed %d, alpha_m %g, alpha_cn %g: agitation %.1e, then %.1e\n",
                       seed, alpha_m[i], alpha_cn[k], half, last);
                failed += slowly ? !(last < 0.5 * half) : !(last <= 1e-12);
                close_scene(s);
            }
        }
    }
    assert_int_equal(failed, 0);
}

/* Far below the threshold nothing moves. */
static void test_threshold(void **state)
{
    (void)state;
    scene *const s = open_file("flume.yaml", 1, "fluid.shields=0.02 time.end=3");
    const double last = largest(s, 2.5, 3.0);
    printf("shields 0.02: agitation %.1e\n", last);
    close_scene(s);
    assert_true(last <= 1e-12);
}

/* ---- balance of stress ------------------------------------------------------------------------------ */

/* In the mean fluid stress + grain stress = tau_b on every plane above the fixed grains (z > d/2). */
static void test_stress_balance(void **state)
{
    (void)state;
    scene *const s = open_file("flume.yaml", 1,
                               "fluid.shields=0.4 grains.columns=40 grains.layers=6 time.end=20");
    const ry_measure *const m = &s->sim->plan.measure;
    const ry_derived q = ry_config_derive(&s->config);
    run_until(s, 2.5);
    ry_sim_profile(s->sim); /* closes the window of the contacts' impulses */
    ry_measure_clear(&s->sim->plan.measure);
    const double end = 16.0;
    const double start_momentum = totals_of(s).px;
    while (ry_sim_view(s->sim).time < end) {
        step_scene(s, q.steps_series);
        ry_sim_profile(s->sim);
    }
    const double drift =
        (totals_of(s).px - start_momentum) / ((end - 2.5) * q.length * q.d * q.shear_stress);
    double worst = 0.0, worst_z = 0.0;
    for (int k = 0; k < m->nz; k++) {
        const double z = (k + 0.5) * m->dz;
        const double sum =
            (m->tau_fluid[k] + m->tau_grain[k]) / (double)m->samples / q.shear_stress;
        if (z > 0.5 * q.d && fabs(sum - 1.0) > worst) {
            worst = fabs(sum - 1.0);
            worst_z = z;
        }
        if (getenv("RY_PROFILE") != NULL && z < 9.0 * q.d) {
            printf("%6.3f d: phi %.3f fluid %.4f grains %.4f sum %.4f\n", z / q.d,
                   m->phi[k] / (double)m->samples,
                   m->tau_fluid[k] / (double)m->samples / q.shear_stress,
                   m->tau_grain[k] / (double)m->samples / q.shear_stress, sum);
        }
    }
    const ry_sample end_sample = ry_sim_sample(s->sim);
    const double lost = end_sample.loss_impact + end_sample.loss_dashpot +
                        end_sample.loss_friction + end_sample.loss_opening;
    printf("stress balance: off by at most %.2f %% of tau_b, at z = %.2f d (grains took %.2f %%)\n",
           100.0 * worst, worst_z / q.d, 100.0 * drift);
    const double integration = end_sample.integration / lost;
    printf("sheared bed: integration %.1e of the losses\n", integration);
    close_scene(s);
    assert_true(worst <= 0.02);
    assert_true(fabs(integration) <= 1e-3);
}

/* ---- flux -------------------------------------------------------------------------------------------- */

static void test_flux(void **state)
{
    (void)state;
    const double shields[] = {0.2, 0.4, 0.8};
    const ry_relation *const wong = ry_relation_find("wong-parker");
    const ry_relation *const ashida = ry_relation_find("ashida-michiue");
    assert_non_null(wong);
    assert_non_null(ashida);
    for (int k = 0; k < 3; k++) {
        scene *const s = open_file("flume.yaml", 1, "fluid.shields=%g time.end=10", shields[k]);
        run_until(s, 1.0);
        double sum = 0.0;
        int n = 0;
        for (; ry_sim_view(s->sim).time < 4.0; n++) {
            step_scene(s, 50);
            sum += ry_sim_sample(s->sim).q_star;
        }
        close_scene(s);
        const double q = sum / n, a = ry_relation_flux(wong, shields[k]),
                     b = ry_relation_flux(ashida, shields[k]);
        printf("shields %g: q* = %.3g; Wong & Parker %.3g, Ashida & Michiue %.3g\n", shields[k], q,
               a, b);
        assert_true(q >= 0.5 * fmin(a, b) && q <= 2.0 * fmax(a, b));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_settling),
        cmocka_unit_test(test_threshold),
        cmocka_unit_test(test_stress_balance),
        cmocka_unit_test(test_flux),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
