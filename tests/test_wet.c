/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Contacts in a viscous fluid (contact.wet): e = e_dry exp(-35/St), none below St = 10, for every law. The
 * fluid's drag is taken out of the simulations, so that what the contact leaves can be told from it. */
#include "config/laws.h"
#include "scene_bench.h"
#include "law/wet.h"
#include "sim/sim.h"

/* ---- damping ratios ---------------------------------------------------------------------------- */

static double exact_loss(double zeta)
{
    return zeta < 1.0 ? 2.0 * zeta * acos(zeta) / sqrt((1.0 - zeta) * (1.0 + zeta))
                      : 2.0 * zeta * acosh(zeta) / sqrt((zeta - 1.0) * (zeta + 1.0));
}

static void test_damping(void **state)
{
    (void)state;
    set_seed("damping", 21);
    double worst = 0.0, worst_inverse = 0.0;
    for (int k = 0; k < 20000; k++) {
        const double zeta = evenly_log(1e-6, 1e3);
        if (fabs(zeta - 1.0) > 0.01) { /* nearer, acos and the root cancel */
            worst = fmax(worst, fabs(ry_damping_loss(zeta) / exact_loss(zeta) - 1.0));
        }
        const double low = zeta * evenly(0.0, 1.0), high = zeta * evenly_log(1.0, 50.0);
        const double back = ry_damping_of_loss(ry_damping_loss(zeta), low, high);
        worst_inverse = fmax(worst_inverse, fabs(back / zeta - 1.0));
        const double usual = ry_damping_usual(ry_damping_usual_loss(zeta));
        assert_true(fabs(usual - fmin(zeta, 1.0)) <= 1e-14 || zeta > 0.999);
    }
    printf("loss of a damping ratio off by %.1e, its inverse by %.1e\n", worst, worst_inverse);
    assert_true(worst <= 1e-14);
    assert_true(worst_inverse <= 1e-12);
    assert_true(fabs(ry_damping_loss(1.0) - 2.0) <= 1e-15);
}

/* ---- impacts ------------------------------------------------------------------------------------- */

enum { EQUAL, UNEQUAL, FIXED, FLOOR, PARTNERS };
static const char *const partner_words[] = {"equal grain", "unequal grain", "fixed grain", "floor"};

typedef struct shot {
    int law, partner, exact; /* contact.mapping */
    double e, stokes, a, phase, ratio, density;
} shot;

/* 1/m of a sphere, the added mass being `added`. */
static double inverse_mass(double r, double density, double added)
{
    return 1.0 / (4.0 / 3.0 * M_PI * r * r * r * (density + added));
}

/* Approach, in the time step dt, at which the two have the Stokes number asked for. Stated apart from the
 * program: on a wall rho d V/(9 mu), of a pair with reduced mass and radius. */
static double speed_of(const shot *s, double mu)
{
    const double r = 0.5e-3, rho = 2650.0, r2 = r * s->ratio, rho2 = rho * s->density;
    if (s->partner == FLOOR) {
        return s->stokes * 9.0 * mu / (rho * 2.0 * r);
    }
    const double im = inverse_mass(r, rho, 0.0) + (s->partner == FIXED ? 0.0 : inverse_mass(r2, rho2, 0.0));
    const double reduced = r * r2 / (r + r2);
    return s->stokes * 6.0 * M_PI * mu * reduced * reduced * im;
}

/* The way of an approach per step is 1/100 of a diameter; grain 0 comes from above. `wet` or dry with e. */
static scene *aim(const shot *s, int wet, double e)
{
    const double mu = 1e-3, r = 0.5e-3, r2 = s->partner == FLOOR ? 0.0 : r * s->ratio;
    const double v = speed_of(s, mu), dt = 0.01 * 2.0 * r / v, way = v * dt * (1.0 + s->phase);
    const int both = s->partner == EQUAL || s->partner == UNEQUAL;
    const double im =
        inverse_mass(r, 2650.0, 500.0) + (both ? inverse_mass(r2, 2650.0 * s->density, 500.0) : 0.0);
    char partner[300] = "";
    if (s->partner != FLOOR) {
        snprintf(partner, sizeof partner, "  - {position: [0, 0], diameter: %.17g, density: %.17g, fixed: %s}\n",
                 2.0 * r2, 2650.0 * s->density, s->partner == FIXED ? "true" : "false");
    }
    scene *const run = open_scene(
        "time: {step: %.17g}\ndomain: {floor: %s, length: 20 mm}\n"
        "fluid: {model: stress, shields: 0, viscosity: 1e-6}\noutput: {fields: [flux]}\n"
        "contact: {law: %s, stiffness: %.17g, restitution: %.17g, mapping: %s, wet: %s, friction: 0}\n"
        "particles:\n"
        "  - {position: [0, %.17g], velocity: [0, %.17g], diameter: 1 mm, density: 2650}\n%s",
        dt, s->partner == FLOOR ? "flat" : "none", law_words[s->law], s->a / (dt * dt * im), e,
        s->exact ? "exact" : "usual", wet ? "true" : "false", r + r2 + way, -v, partner);
    ry_plan *const plan = &run->sim->plan; /* without the column's stage, and drag */
    int kept = 0;
    for (int k = 0; k < plan->n_stages; k++) {
        plan->stage[kept] = plan->stage[k];
        kept += strcmp(plan->stage[k].name, "column") != 0;
    }
    assert_int_equal(kept, plan->n_stages - 1);
    plan->n_stages = kept;
    plan->flow.density = 0.0;
    return run;
}

static double approach(const scene *s, int partner)
{
    return -grain_of(s, 0).vz + (partner == FLOOR ? 0.0 : grain_of(s, 1).vz);
}

static double restitution(const shot *s, int wet, double e)
{
    scene *const run = aim(s, wet, e);
    const double before = approach(run, s->partner);
    step_scene(run, 12 + (long long)(7.0 / sqrt(s->a)));
    const double out = -approach(run, s->partner) / before;
    close_scene(run);
    return out;
}

static shot random_shot(int law, int partner)
{
    return (shot){.law = law, .partner = partner, .exact = evenly(0.0, 1.0) < 0.5,
                  .e = evenly(0.4, 1.0), .stokes = evenly_log(10.01, 3e3), .a = evenly_log(1e-3, 0.2),
                  .phase = evenly(0.01, 1.0),
                  .ratio = partner == UNEQUAL || partner == FIXED ? evenly_log(0.3, 3.0) : 1.0,
                  .density = partner == UNEQUAL ? evenly_log(0.5, 3.0) : 1.0};
}

static int is_exact(int law)
{
    return law == RY_LAW_ENERGY || law == RY_LAW_FUJIOKA2 || law == RY_LAW_FUJIOKA1;
}

/* A wet impact is the dry one with the restitution that the fluid leaves, for any law with its own mapping;
 * of the laws that promise it, that restitution is the closed form to rounding. */
static void test_impacts(void **state)
{
    (void)state;
    set_seed("wet impacts", 22);
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        double worst = 0.0, worst_closed = 0.0;
        for (int k = 0; k < 160; k++) {
            const shot s = random_shot(law, k % PARTNERS);
            const double e = s.e * exp(-35.0 / s.stokes);
            if ((law == RY_LAW_FUJIOKA1 && e < 1.001 * sqrt(s.a / (1.0 + s.a))) ||
                (ry_laws[law].ratio && e < 0.2)) {
                continue; /* the dry law does not take it */
            }
            const double wet = restitution(&s, 1, s.e), dry = restitution(&s, 0, e);
            if (!(fabs(wet - dry) <= 1e-10)) {
                fail_msg("%s, %s, e %g St %g a %g: wet %.15g, dry %.15g", law_words[law], partner_words[s.partner],
                         s.e, s.stokes, s.a, wet, dry);
            }
            worst = fmax(worst, fabs(wet - dry));
            worst_closed = fmax(worst_closed, fabs(wet - e));
        }
        printf("%s: wet against dry off by %.1e, against e exp(-35/St) by %.1e\n", law_words[law], worst, worst_closed);
        assert_true(worst_closed <= 1e-12 || !is_exact(law));
    }
}

/* Where alpha_cn gives the dashpot, what it is alone adds to what the fluid takes: -ln e = -ln e_dry + 35/St. */
static void test_added_losses(void **state)
{
    (void)state;
    const ry_law_coef coef = {.k_dt2 = 1e-4, .eta_dt = 3e-3, .e = 0.5};
    for (int tension = 0; tension < 2; tension++) {
        const ry_film film = {.on = 1, .damps = 1, .usual = tension, .pulls = tension, .unit = 2.0, .many = 1.0};
        const double zeta = 0.5 * ry_contact_wet(&film, &coef, 1e-4, 3e-3, 0.7), dry = 0.15;
        const double more = tension ? M_PI * (zeta / sqrt(1.0 - zeta * zeta) - dry / sqrt(1.0 - dry * dry))
                                    : exact_loss(zeta) - exact_loss(dry);
        assert_true(fabs(more - 0.7) <= 1e-12);
    }
}

/* Below St = 10 nothing bounces. A dashpot can't stop a grain; it is as strong as the usual formula or the
 * step allows. */
static void test_no_rebound(void **state)
{
    (void)state;
    set_seed("below 10", 23);
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        double most = 0.0;
        for (int k = 0; k < 80; k++) {
            shot s = random_shot(law, k % PARTNERS);
            s.stokes = evenly_log(1e-3, 9.99);
            s.a = fmax(s.a, 0.02);
            most = fmax(most, fabs(restitution(&s, 1, s.e)));
        }
        printf("%s, St < 10: restitution at most %.1e\n", law_words[law], most);
        assert_true(most <= (ry_laws[law].ratio ? 0.2 : 1e-12));
    }
}

/* ---- what show says -------------------------------------------------------------------------------- */

static void append(void *data, const char *text)
{
    strncat(data, text, 30000 - strlen(data) - 1);
}

/* What show says of the flume with `n` overrides. */
static const char *describe(const char *const *overrides, int n)
{
    static char text[30000];
    ry_config config;
    ry_error error = {0};
    text[0] = '\0';
    assert_int_equal(ry_config_load(&config, RY_SOURCE_DIR "/params/flume.yaml", overrides, n, &error), RY_OK);
    assert_int_equal(ry_describe_scene(&config, append, text, &error), RY_OK);
    ry_config_free(&config);
    return text;
}

/* The first number behind `label`. */
static double number_behind(const char *text, const char *label)
{
    const char *const at = strstr(text, label);
    assert_non_null(at);
    return strtod(at + strlen(label), NULL);
}

/* Row V, St of a pair, e, St at a wall, e: with St = 100 of the pair, whatever the grains are. */
static void test_show(void **state)
{
    (void)state;
    const char *const overrides[] = {"contact.wet=true", "contact.restitution=0.8", "time.end=0.001"};
    const char *const table = strstr(describe(overrides, 3), "WET CONTACTS");
    assert_non_null(table);
    assert_non_null(strstr(table, "settling velocity"));
    assert_non_null(strstr(table, "friction velocity"));
    const char *row = table;
    double v = 0.0, pair = 0.0, e = 0.0, wall = 0.0, e_wall = 0.0;
    for (int k = 0; k < 20 && fabs(pair - 100.0) > 0.01; k++) {
        row = strchr(row, '\n') + 1;
        sscanf(row, "%lf %lf %lf %lf %lf", &v, &pair, &e, &wall, &e_wall);
    }
    assert_true(fabs(2650.0 * 0.5e-3 * v / (9.0 * 1e-3) - 50.0) < 0.02);
    assert_true(fabs(wall - 50.0) < 0.01);
    assert_true(fabs(e - 0.8 * exp(-0.35)) < 1e-4 && fabs(e_wall - 0.8 * exp(-0.7)) < 1e-4);
}

/* Ferguson & Church's law is the one whose settling velocity is known: of sand in water and, beyond 1 m/s, in air. */
static void test_settling_velocity(void **state)
{
    (void)state;
    static const struct {
        const char *density, *viscosity;
        double rho, nu;
    } fluids[] = {{"fluid.density=1000", "fluid.viscosity=1e-6", 1000.0, 1e-6},
                  {"fluid.density=1.2", "fluid.viscosity=1.5e-5", 1.2, 1.5e-5}};
    for (int k = 0; k < 2; k++) {
        const char *const overrides[] = {"contact.wet=true", "time.end=0.001", "fluid.drag=ferguson-church",
                                         fluids[k].density, fluids[k].viscosity};
        const double d = 0.5e-3, pull = (2650.0 / fluids[k].rho - 1.0) * 9.81 * d * d;
        const double w = pull / (18.0 * fluids[k].nu + sqrt(0.75 * 0.4 * pull * d));
        assert_true(fabs(number_behind(describe(overrides, 5), "settling velocity") / w - 1.0) < 1e-3);
    }
}

/* A grain at rest on the floor: m g/k, 1 + 6 k dt^2/(4 m) more with law energy, (m g/(k d))^(2/3) with tanaka; and how
 * much slower drag makes a grain in a step. */
static void test_rest(void **state)
{
    (void)state;
    const double d = 0.5e-3, volume = M_PI / 6.0 * d * d * d, linear = 1650.0 * volume * 9.81 / (10.0 * d);
    const double wet = 3150.0 * volume, soft = 1.0 + 1.5 * 10.0 * 4e-10 / wet, b = 3.0 * M_PI * 1e-3 * d * 2e-5 / wet;
    const char *const laws[] = {"contact.law=cundall", "contact.law=energy", "contact.law=tanaka"};
    const double expected[] = {linear, linear * soft, pow(linear, 2.0 / 3.0)};
    for (int k = 0; k < 3; k++) {
        const char *const overrides[] = {"contact.stiffness=10", "time.end=0.001", laws[k]};
        const char *const text = describe(overrides, 3);
        assert_true(fabs(number_behind(text, "static overlap") / expected[k] - 1.0) < 1e-3);
        assert_true(fabs(number_behind(text, "drag over a step, b") / b - 1.0) < 1e-3);
        assert_true((strstr(text, "bounded by the law") != NULL) == (k == 1));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_damping),    cmocka_unit_test(test_impacts), cmocka_unit_test(test_added_losses),
        cmocka_unit_test(test_no_rebound), cmocka_unit_test(test_show),
        cmocka_unit_test(test_settling_velocity), cmocka_unit_test(test_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
