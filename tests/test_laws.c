/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The contact laws alone, without a simulation, against closed forms. */
#include "law_bench.h"

/* ---- laws that keep energy by construction: energy, fujioka-2 ---------------------------------- */

/* Restitution, booked loss 1 - e^2 and momentum of random impacts; a is given directly or bounded as
 * ry_bond_make does. */
static void check_exact(const char *name, law_fn *law, double bounded, uint64_t seed)
{
    set_seed(name, seed);
    double worst = 0.0, worst_loss = 0.0, worst_drift = 0.0;
    for (int k = 0; k < 40000; k++) {
        const ry_law_coef coef = {.k_dt2 = evenly_log(1e-4, 10.0),
                                  .eta_dt = evenly_log(1e-3, 30.0),
                                  .e = k % 20 == 0 ? 0.0 : (k % 20 == 1 ? 1.0 : evenly(0.0, 1.0)),
                                  .bounded = bounded,
                                  .ratio_k = 0.4,
                                  .ratio_eta = 0.6};
        const int wall = k % 4 == 0;
        const double ratio = evenly_log(1e-3, 1e3);
        const double w = evenly_log(1e-9, 1e3);
        entry in = {.w = w,
                    .d = w * (k % 10 == 2 ? evenly_log(1e-12, 1.0) : evenly(1e-9, 1.0)),
                    .im_i = wall ? 1.0 : 1.0 / (1.0 + ratio),
                    .im_j = wall ? 0.0 : ratio / (1.0 + ratio),
                    .centre = wall ? 0.0 : w * evenly(-10.0, 10.0),
                    .most = (int)RY_IMPACT_STEPS}; /* e = 0 leaves them in touch, at rest */
        const impact out = collide(law, ry_bond_make(&coef, 1.0, 3.5), in);
        const double error = fabs(out.e - coef.e);
        if (!(error <= 1e-12)) {
            fail_msg("%s: case %d: a %g e %g d/w %g: restitution %.17g", name, k, coef.k_dt2,
                     coef.e, in.d / in.w, out.e);
        }
        worst = fmax(worst, error);
        worst_loss = fmax(worst_loss, fabs(out.loss - (1.0 - coef.e * coef.e)));
        worst_drift = fmax(worst_drift, fabs(out.drift));
    }
    printf("%s, bound %g: restitution error %.1e, booked loss %.1e, momentum %.1e\n", name, bounded,
           worst, worst_loss, worst_drift);
    assert_true(worst_loss <= 1e-12);
    assert_true(worst_drift <= 1e-12);
}

static void test_exact_restitution(void **state)
{
    (void)state;
    check_exact("energy", ry_law_energy, 0.0, 1);
    check_exact("energy", ry_law_energy, RY_BOND_NEIGHBOURS, 2);
    check_exact("fujioka2", ry_law_fujioka2, 0.0, 3);
}

/* Where a partner can't move gravity g (way per step per step) is part of the balance of law energy:
 * the true speed at contact is w_c^2 = w^2 - 2 g d, and after the bounce w'^2 = e^2 w_c^2 + 2 g d'
 * with the gap -d'. Free flight on either side is exact, so this is the restitution of a bounce. */
static void test_bounce_energy(void **state)
{
    (void)state;
    set_seed("bounce", 4);
    double worst = 0.0;
    for (int k = 0; k < 40000; k++) {
        const ry_bond q = {.a = evenly_log(1e-3, 0.6), .c = 0.3, .e = evenly(0.05, 1.0)};
        const double closing = 1.0; /* true speed; a flight of 2 e/g steps follows */
        const double g = evenly_log(1e-6, 2.0 * q.e / 20.0) * closing;
        const double part = evenly(0.0, 1.0); /* of a step since the true contact */
        ry_touch t = {.d = closing * part + 0.5 * g * part * part, .w = closing + g * part, .g = g, .split = 1.0};
        int steps = 0;
        while (t.d > 0.0 && steps < 100) {
            const ry_push p = ry_law_energy(q, t);
            t.w += p.f + g;
            t.d +=
                p.f != 0.0 ? t.w : t.w - 0.5 * g; /* as stage/motion.h drifts what nothing pushes */
            t.rest = p.rest;
            t.pushed = p.pushed;
            t.then = t.w;
            t.age += 1.0;
            steps++;
        }
        const double after = t.w * t.w + 2.0 * g * -t.d; /* squared speed when it passes d = 0 */
        const double error = fabs(after / (q.e * q.e) - 1.0);
        if (steps <= (int)RY_IMPACT_STEPS) {
            worst = fmax(worst, error);
        }
        if (!(error <= 0.01)) {
            fail_msg("case %d: a %g e %g g %g part %g: ratio off by %g after %d steps", k, q.a, q.e,
                     g, part, error, steps);
        }
    }
    printf("bounce under gravity: energy ratio off by at most %.1e\n", worst);
    assert_true(worst <= 1e-10);
}

/* ---- what the printed form loses ---------------------------------------------------------------- */

/* Worst |restitution - e| over entry phase and e. */
static double worst_printed(double a)
{
    double worst = 0.0;
    for (int i = 1; i <= 1000; i++) {
        for (int k = 1; k <= 50; k++) {
            const ry_bond q = {.a = a, .e = 0.02 * k};
            worst = fmax(worst, fabs(collide_wall(ry_law_fujioka2_printed, q, 0.001 * i).e - q.e));
        }
    }
    return worst;
}

static void test_printed_losses(void **state)
{
    (void)state;
    const double a[] = {0.0987, 0.6, 1.0, 10.0}, known[] = {1.0e-4, 1.2e-2, 3.4e-2, 0.44};
    for (int k = 0; k < 4; k++) {
        const double worst = worst_printed(a[k]);
        printf("fujioka2_printed, a = %g: restitution off by up to %.3g\n", a[k], worst);
        assert_true(fabs(worst / known[k] - 1.0) < 0.06);
    }
}

/* ---- fujioka-1 ---------------------------------------------------------------------------------- */

/* s > 1/e: out in one step with w' = -e w. Else w'^2/2 + a (d + w')^2/2 = e^2 w^2/2 after the closing
 * step and for good, where e^2 s^2 >= a/(1+a). */
static void test_fujioka1(void **state)
{
    (void)state;
    set_seed("fujioka1", 5);
    int at_once = 0, later = 0;
    double worst = 0.0;
    for (int k = 0; k < 20000; k++) {
        const ry_bond q = {.a = evenly_log(1e-4, 10.0), .e = evenly(0.01, 1.0)};
        const double phase = evenly(0.01, 1.0);
        const impact out = collide_wall(ry_law_fujioka1, q, phase);
        if (q.e > phase) {
            assert_int_equal(out.steps, 1);
            assert_true(fabs(out.e - q.e) <= 1e-14);
            at_once++;
        } else if (q.e * q.e >= phase * phase * q.a / (1.0 + q.a)) {
            const ry_touch t = {.d = phase, .w = 1.0, .split = 1.0};
            const double w = 1.0 + ry_law_fujioka1(q, t).f, d = phase + w;
            assert_true(fabs(w * w + q.a * d * d - q.e * q.e) <= 1e-12);
            worst = d > 0.0 ? fmax(worst, fabs(out.e - q.e)) : worst;
            later++;
        }
    }
    printf("fujioka1: %d left at once, %d later, error %.1e\n", at_once, later, worst);
    assert_true(worst <= 1e-12);
    assert_true(at_once > 1000 && later > 1000);
}

/* ---- spring and dashpot -------------------------------------------------------------------------- */

/* A dashpot that may pull, released where the overlap ends: e = exp(-pi zeta/sqrt(1 - zeta^2)); one that
 * never pulls: Schwager & Poeschel (2007). Both to first order in the step, which 4 -> 1 shows. */
static double cundall_error(law_fn *law, double zeta, double e, double a)
{
    const ry_bond q = {.a = a, .c = 2.0 * zeta * sqrt(a), .e = 0.5};
    double error = 0.0;
    for (int k = 1; k <= 8; k++) {
        error = fmax(error, fabs(collide_wall(law, q, k / 8.0).e - e));
    }
    return error;
}

static void test_cundall_restitution(void **state)
{
    (void)state;
    const double zetas[] = {0.0, 0.05, 0.2155, 0.4, 0.7, 0.9, 1.0, 1.3, 3.0};
    for (size_t k = 0; k < sizeof zetas / sizeof *zetas; k++) {
        const double zeta = zetas[k], e = ry_restitution_from_damping(zeta);
        const double coarse = cundall_error(ry_law_cundall, zeta, e, 1.6e-7);
        const double fine = cundall_error(ry_law_cundall, zeta, e, 1e-8);
        printf("cundall, zeta = %g: e = %.4f, error %.1e at a = 1.6e-7, %.1e at 1e-8\n", zeta, e,
               coarse, fine);
        assert_true(fine <= 4e-4);
        assert_true(fine <= 0.3 * coarse || coarse < 1e-6);
        if (zeta < 0.95) {
            const double pull = exp(-M_PI * zeta / sqrt(1.0 - zeta * zeta));
            assert_true(cundall_error(ry_law_cundall_tension, zeta, pull, 1e-8) <= 4e-4);
        }
    }
    /* the usual formula under a dashpot that never pulls */
    const double asked[] = {0.5, 0.1, 0.9}, gets[] = {0.5503, 0.2527, 0.9020};
    for (int k = 0; k < 3; k++) {
        assert_true(fabs(ry_restitution_from_damping(usual_zeta(asked[k])) - gets[k]) < 1e-4);
        assert_true(cundall_error(ry_law_cundall, usual_zeta(asked[k]), gets[k], 1e-8) <= 4e-4);
    }
}

/* With x = d^(5/4), w dw/dx = -(4/5)(a x + c w): the linear spring and dashpot with zeta = alpha/sqrt 5, so
 * one restitution at every speed. alpha is made for release at d = 0; as the force never pulls, the
 * grains part where a x + c w = 0, with Schwager & Poeschel's value: 0.5503 where 0.5 was asked for. */
static void test_tanaka_restitution(void **state)
{
    (void)state;
    const double asked[] = {0.2, 0.5, 0.7, 0.9, 1.0};
    for (size_t k = 0; k < sizeof asked / sizeof *asked; k++) {
        const double zeta = usual_zeta(asked[k]), exact = ry_restitution_from_damping(zeta);
        for (double speed = 1e-3; speed <= 10.0; speed *= 100.0) {
            const double a =
                1e-8 / sqrt(speed); /* a d^1/2 sets the length of the contact in steps */
            const ry_bond q = {.a = a, .c = sqrt(5.0) * zeta * sqrt(a), .e = asked[k]};
            const impact out =
                collide(ry_law_tanaka, q, (entry){.w = speed, .d = 0.5 * speed, .im_i = 1.0});
            if (!(fabs(out.e - exact) <= 1e-3)) {
                fail_msg("tanaka, e = %g: %.6f at speed %g in %d steps, not %.6f", asked[k], out.e,
                         speed, out.steps, exact);
            }
        }
        printf("tanaka, e = %g: really %.4f\n", asked[k], exact);
    }
}

/* Squeezed to a depth and let go, d = sin^2: what a cycle costs is the dashpot's work, int c d^(1/4) w dd, less what
 * the force would pull; without damping nothing, and no force without overlap. */
static double tanaka_cycle(double a, double c, int n)
{
    const ry_bond q = {.a = a, .c = c, .e = 0.5};
    double lost = 0.0;
    for (int k = 0; k < n; k++) {
        const double from = sin(M_PI * k / n), to = sin(M_PI * (k + 1) / n), middle = sin(M_PI * (k + 0.5) / n);
        const double run = to * to - from * from; /* of this step; the law sees speed in units of 1/1000 of the cycle */
        const ry_touch t = {.d = middle * middle, .w = run * n / 1000.0, .age = 9.0, .split = 1.0};
        lost -= ry_law_tanaka(q, t).f * run;
    }
    return lost;
}

static void test_tanaka_cycle(void **state)
{
    (void)state;
    const double a = 1e-3, c = 0.01;
    double exact = 0.0; /* by Simpson's rule over the phase */
    const int n = 200000;
    for (int k = 0; k <= n; k++) {
        const double phase = M_PI * k / n, d = sin(phase) * sin(phase), speed = sin(2.0 * phase) * M_PI;
        const double force = fmax(a * pow(d, 1.5) + c * pow(d, 0.25) * speed / 1000.0, 0.0);
        exact += force * speed / n / 3.0 * (k == 0 || k == n ? 1.0 : (k % 2 ? 4.0 : 2.0));
    }
    const double lost = tanaka_cycle(a, c, 20000);
    printf("tanaka, a cycle: lost %.9g, by quadrature %.9g; undamped %.1e\n", lost, exact, tanaka_cycle(a, 0.0, 20000));
    assert_true(fabs(lost / exact - 1.0) <= 1e-6);
    assert_true(fabs(tanaka_cycle(a, 0.0, 20000)) <= 1e-15);
    const ry_bond q = {.a = a, .c = c};
    assert_true(ry_law_tanaka(q, (ry_touch){.d = 0.0, .w = -1.0, .split = 1.0}).f == 0.0);
}

/* ---- any input ------------------------------------------------------------------------------------ */

static ry_touch random_touch(int k)
{
    const double size = evenly_log(1e-12, 1e3);
    ry_touch t = {.d = k % 7 == 0 ? size * evenly_log(1e-100, 1.0) : size * evenly_log(1e-9, 1.0),
                  .w = k % 5 == 0 ? 0.0 : size * evenly(-1.0, 1.0) * evenly_log(1e-9, 1.0),
                  .age = floor(evenly(0.0, 7.0)),
                  .crowd = floor(evenly(0.0, 4.0)), .split = evenly(1.0, 4.0)};
    t.rest = k % 3 == 0 ? 0.0 : t.d * evenly(0.0, 1.5);
    return t;
}

/* No NaN, no force that pulls and no `rest` but of laws with that column in laws.def. */
static void test_any_input(void **state)
{
    (void)state;
    set_seed("any input", 6);
    for (int k = 0; k < 200000; k++) {
        const double edge[] = {0.0, 1.0, evenly(0.0, 1.0)};
        const double a = evenly_log(1e-8, 40.0);
        const ry_bond q = {.a = a, .c = 2.0 * evenly_log(1e-3, 30.0) * sqrt(a), .e = edge[k % 3]};
        const ry_touch t = random_touch(k);
        for (size_t m = 0; m < sizeof laws / sizeof *laws; m++) {
            const ry_push p = laws[m].law(q, t);
            const double sum = p.f + p.shift + p.rest + p.impact + p.dashpot;
            if (!isfinite(sum)) {
                fail_msg("%s, case %d: a %g c %g e %g d %g w %g: %g", laws[m].name, k, q.a, q.c,
                         q.e, t.d, t.w, sum);
            }
            if (!laws[m].rests && p.rest != 0.0 && p.rest != t.rest) {
                fail_msg("%s, case %d: keeps rest = %g, but has no `rests` in laws.def", laws[m].name, k, p.rest);
            }
            if (!laws[m].pulls && p.f > 4e-16 * (fabs(t.w) + t.d)) {
                fail_msg("%s, case %d: a %g c %g e %g d %g w %g rest %g age %g split %g: pulls %g",
                         laws[m].name, k, q.a, q.c, q.e, t.d, t.w, t.rest, t.age, t.split, p.f);
            }
        }
    }
}

/* The tangential law: bounded by Coulomb's cap, and spring plus motion never gain energy. */
static void test_tangential(void **state)
{
    (void)state;
    set_seed("tangential", 7);
    for (int k = 0; k < 200000; k++) {
        const ry_law_coef coef = {.k_dt2 = evenly_log(1e-6, 40.0),
                                  .eta_dt = evenly_log(1e-4, 30.0),
                                  .e = 0.5,
                                  .ratio_k = 1.0 / (2.0 * (1.0 + evenly(0.0, 0.5))),
                                  .ratio_eta = 0.6,
                                  .bounded = k % 2 ? RY_BOND_NEIGHBOURS : 0.0};
        const ry_bond q = ry_bond_make(&coef, 1.0, 3.5);
        const double f = -evenly_log(1e-9, 10.0), mu = evenly(0.0, 2.0),
                     cap = -mu * q.mass_ratio * f;
        const double w = evenly(-1.0, 1.0), slip = evenly(-1.0, 1.0);
        const ry_slide s = ry_tangential(q, mu, f, w, slip, 0.0);
        const double after = w + s.f, end = s.slip + after; /* slip after the step */
        const double loss =
            0.5 * (w * w - after * after) + 0.5 * q.stretch * (slip * slip - end * end);
        assert_true(isfinite(s.f + s.slip));
        assert_true(fabs(s.f) <= cap * (1.0 + 1e-15));
        if (!(loss >= -1e-15)) {
            fail_msg("case %d: stretch %g drag %g w %g slip %g: gains %g", k, q.stretch, q.drag, w,
                     slip, -loss);
        }
    }
}

/* ---- Table 2 of Fujioka & Ushijima: steps in touch ------------------------------------------------- */

/* Section 5.2: a sphere falls from 0.01 diameters; unit of length: the diameter of 225 m. */
static int steps_in_touch(law_fn *law, ry_bond q, double dt)
{
    const double g = 9.8 * dt * dt / 225.0;
    ry_touch t = {.d = -0.01, .split = 1.0};
    int steps = 0;
    while (steps == 0 || t.d > 0.0) {
        double f = 0.0, shift = 0.0;
        if (t.d > 0.0) {
            const ry_push p = law(q, t);
            f = p.f;
            shift = p.shift;
            t.age += 1.0;
            steps++;
        }
        t.w += f + g;
        t.d += shift + t.w;
    }
    return steps;
}

static void test_steps_in_touch(void **state)
{
    (void)state;
    const double dt[] = {1e-3, 1e-4, 1e-5};
    const double a = 0.104, hertz = 4.6, zeta = usual_zeta(0.7);
    const ry_bond linear = {.a = a, .c = 2.0 * zeta * sqrt(a), .e = 0.7};
    const ry_bond power = {.a = hertz, .c = sqrt(5.0) * zeta * sqrt(hertz), .e = 0.7};
    const struct {
        const char *letter;
        law_fn *law;
        ry_bond bond;
        int table[3];
    } rows[] = {{"T", ry_law_tanaka, power, {14, 23, 37}},
                {"F", ry_law_fujioka1, linear, {2, 1, 1}},
                {"C", ry_law_cundall_tension, linear, {9, 10, 10}},
                {"P", ry_law_fujioka2, linear, {3, 3, 3}}};
    for (int r = 0; r < 4; r++) {
        int steps[3];
        for (int k = 0; k < 3; k++) {
            steps[k] = steps_in_touch(rows[r].law, rows[r].bond, dt[k]);
        }
        printf("Table 2, %s: %d %d %d\n", rows[r].letter, steps[0], steps[1], steps[2]);
        for (int k = 0; k < 3; k++) {
            assert_int_equal(steps[k], rows[r].table[k]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_restitution),   cmocka_unit_test(test_bounce_energy),
        cmocka_unit_test(test_printed_losses),      cmocka_unit_test(test_fujioka1),
        cmocka_unit_test(test_cundall_restitution), cmocka_unit_test(test_tanaka_restitution),
        cmocka_unit_test(test_tanaka_cycle),
        cmocka_unit_test(test_any_input),           cmocka_unit_test(test_tangential),
        cmocka_unit_test(test_steps_in_touch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
