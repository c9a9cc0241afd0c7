/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Impacts of two grains in whole simulations: what no law may break. Energy, with that of spin, never
 * rises; momentum and angular momentum about any point, orbit and spin together, are kept. */
#include "config/laws.h"
#include "scene_bench.h"

enum { WITH_GRAIN, WITH_FIXED, WITH_FLOOR, PARTNERS };
static const char *const partner_words[] = {"grain", "fixed grain", "floor"};

typedef struct shot {
    int law, partner;
    double angle;   /* of incidence, 0: head on [degrees] */
    double speed;   /* mean diameters per step */
    double ratio;   /* diameter of the second grain over that of the first */
    double density; /* the same of the densities */
    double e, friction;
    double a;      /* k dt^2/m_r */
    double spin;   /* surface speed over speed */
    double phase;  /* of a step, where the contact closes */
    double common; /* velocity of both over speed; only two free grains */
} shot;

typedef struct outcome {
    double gain;              /* energy after/before - 1 */
    double momentum, angular; /* change over scale */
    double parting;           /* normal restitution; only head on */
} outcome;

/* Grain 0 flies along +x (or down onto the floor) and meets its partner under the angle; unit of length
 * 1 mm, dt = 1 us. */
static scene *aim(const shot *s)
{
    const double dt = 1e-6, r = 0.5e-3,
                 mean = s->partner == WITH_GRAIN ? r * (1.0 + s->ratio) : 2.0 * r;
    const double v = s->speed * mean / dt, t = s->angle * M_PI / 180.0;
    const double r2 = r * s->ratio, reach = r + r2, way = v * dt * (2.0 + s->phase);
    const double common = s->partner == WITH_GRAIN ? s->common * v : 0.0;
    const double mass = 2650.0 * 4.0 / 3.0 * M_PI * r * r * r;
    const double mass2 = mass * s->density * s->ratio * s->ratio * s->ratio;
    const double stiffness =
        s->a / (dt * dt) / (1.0 / mass + (s->partner == WITH_GRAIN ? 1.0 / mass2 : 0.0));
    if (s->partner == WITH_FLOOR) {
        return open_scene(
            "time: {step: 1e-6}\ndomain: {floor: flat}\noutput: {fields: [energy]}\n"
            "contact: {law: %s, stiffness: %.17g, restitution: %.17g, friction: %.17g}\n"
            "particles: [{position: [0, %.17g], velocity: [%.17g, %.17g], spin: %.17g, diameter: 1 mm, density: 2650}]\n",
            law_words[s->law], stiffness, s->e, s->friction, r + way * cos(t), v * sin(t),
            -v * cos(t), s->spin * v / r);
    }
    return open_scene(
        "time: {step: 1e-6}\noutput: {fields: [energy]}\n"
        "contact: {law: %s, stiffness: %.17g, restitution: %.17g, friction: %.17g}\n"
        "particles:\n"
        "  - {position: [%.17g, %.17g], velocity: [%.17g, %.17g], spin: %.17g, diameter: 1 mm, density: 2650}\n"
        "  - {position: [0, 0], velocity: [%.17g, %.17g], spin: %.17g, diameter: %.17g, density: %.17g, fixed: %s}\n",
        law_words[s->law], stiffness, s->e, s->friction, -reach * cos(t) - way, reach * sin(t),
        v + common, common, s->spin * v / r, common, common,
        s->partner == WITH_FIXED ? 0.0 : -0.5 * s->spin * v / r2, 2.0 * r2, 2650.0 * s->density,
        s->partner == WITH_FIXED ? "true" : "false");
}

static int touches(const scene *s, int partner)
{
    const grain p = grain_of(s, 0);
    if (partner == WITH_FLOOR) {
        return p.z < p.radius;
    }
    const grain q = grain_of(s, 1);
    return hypot(p.x - q.x, p.z - q.z) < p.radius + q.radius;
}

static outcome shoot(const shot *s)
{
    scene *const run = aim(s);
    const totals before = totals_of(run);
    step_scene(run, 4);
    for (int k = 0; k < 60 && touches(run, s->partner); k++) {
        step_scene(run, 2 + (long long)(2.0 / sqrt(s->a)));
    }
    const totals after = totals_of(run);
    const outcome out = {.gain = after.kinetic / before.kinetic - 1.0,
                         .momentum =
                             hypot(after.px - before.px, after.pz - before.pz) / before.scale_p,
                         .angular = fabs(after.angular - before.angular) /
                                    (before.scale_angular + after.scale_angular)};
    close_scene(run);
    return out;
}

/* Laws with an explicit spring meet an overlap that they have not paid for. Without damping the step
 * v' = v - a d, d' = d + v' keeps v^2 + a d^2 - a v d. A contact closes with d = p v and opens with d = q v,
 * p and q parts of a step, so that it multiplies the energy of approach by
 * (1 - a p (1-p))/(1 - a q (1-q)): at most 1/(1 - a/4). A Hertz spring does the same with less at its ends. */
static double excess_allowed(const shot *s)
{
    if (ry_laws[s->law].hertz) {
        return s->e > 0.95 ? 5e-3 : 1e-6;
    }
    return ry_laws[s->law].ratio ? 0.25 * s->a / (1.0 - 0.25 * s->a) : 1e-12;
}

/* Speed of approach along the line of centres, down the floor. */
static double approach(const scene *s, int partner)
{
    const grain p = grain_of(s, 0);
    return partner == WITH_FLOOR ? -p.vz : p.vx - grain_of(s, 1).vx;
}

typedef struct worst {
    outcome most;
    shot at_gain;
    int gains; /* shots that gained more than is allowed */
} worst;

static void note(worst *w, const shot *s, const outcome *out)
{
    w->gains += out->gain > excess_allowed(s);
    if (out->gain > w->most.gain) {
        w->most.gain = out->gain;
        w->at_gain = *s;
    }
    if (s->partner == WITH_GRAIN) {
        w->most.momentum = fmax(w->most.momentum, out->momentum);
        w->most.angular = fmax(w->most.angular, out->angular);
    }
}

static shot random_shot(int law, int partner)
{
    const double edge = floor(evenly(0.0, 6.0));
    return (shot){.law = law,
                  .partner = partner,
                  .speed = evenly_log(1e-3, 2e-2),
                  .angle = evenly(0.0, 89.0),
                  .ratio =
                      partner == WITH_FLOOR || evenly(0.0, 1.0) < 0.3 ? 1.0 : evenly_log(0.2, 5.0),
                  .density = evenly(0.0, 1.0) < 0.5 ? 1.0 : evenly_log(0.1, 10.0),
                  .e = edge == 0.0 ? 0.0 : (edge == 1.0 ? 1.0 : evenly(0.0, 1.0)),
                  .friction = evenly(0.0, 1.0) < 0.3 ? 0.0 : evenly(0.0, 1.5),
                  .a = evenly_log(1e-3, 0.5),
                  .spin = evenly(0.0, 1.0) < 0.4 ? 0.0 : evenly(-2.0, 2.0),
                  .phase = evenly(0.0, 1.0),
                  .common = evenly(0.0, 1.0) < 0.5 ? 0.0 : evenly(-1.0, 1.0)};
}

static void report(const worst *w, int law)
{
    const shot *const s = &w->at_gain;
    printf("%s: energy gained %.1e, momentum %.1e, angular momentum %.1e\n", law_words[law],
           w->most.gain, w->most.momentum, w->most.angular);
    if (w->most.gain > 0.0) {
        printf(
            "  at: %s, %.2f degrees, speed %.2e, diameters %.3g, densities %.3g, e %.3g, mu %.3g, a %.3g, "
            "spin %.3g, phase %.3g, common %.3g\n",
            partner_words[s->partner], s->angle, s->speed, s->ratio, s->density, s->e, s->friction,
            s->a, s->spin, s->phase, s->common);
    }
}

static void sweep(int law, worst *w)
{
    const int shots = getenv("SHOTS") ? atoi(getenv("SHOTS")) : 12;
    for (int partner = 0; partner < PARTNERS; partner++) {
        for (int angle = 0; angle < 90; angle++) {
            for (int k = 0; k < shots; k++) {
                shot s = random_shot(law, partner);
                s.angle = angle;
                if (law == RY_LAW_FUJIOKA1) { /* what it can keep at all */
                    s.e = fmax(s.e, 1.0001 * sqrt(s.a / (1.0 + s.a)));
                }
                const outcome out = shoot(&s);
                note(w, &s, &out);
            }
        }
    }
}

static void test_oblique(void **state)
{
    (void)state;
    set_seed("oblique", 11);
    int failed = 0;
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        worst w = {0};
        sweep(law, &w);
        report(&w, law);
        failed += w.gains > 0 || w.most.momentum > 1e-12 || w.most.angular > 1e-12;
    }
    assert_int_equal(failed, 0);
}

/* ---- rebound ---------------------------------------------------------------------------------------- */

/* Velocity and spin behind an oblique impact on a floor, of law energy, against rough rigid spheres: J_n = (1 + e) m
 * v_n, and J_t what friction allows, mu J_n, or what stops the contact point, 2/7 m w. Few steps or many, any angle. */
static double rebound_is_off(const shot *s)
{
    scene *const run = aim(s);
    const grain before = grain_of(run, 0);
    const double slides = -before.vx + before.spin * before.radius;
    const double normal = -(1.0 + s->e) * before.vz;
    const double along = -copysign(fmin(s->friction * normal, fabs(slides) / 3.5), slides);
    step_scene(run, 4);
    for (int k = 0; k < 60 && touches(run, s->partner); k++) {
        step_scene(run, 2 + (long long)(2.0 / sqrt(s->a)));
    }
    const grain after = grain_of(run, 0);
    const double off = fmax(hypot(after.vx - (before.vx - along), after.vz - (before.vz + normal)),
                            fabs(after.spin * after.radius - (before.spin * before.radius + 2.5 * along)));
    close_scene(run);
    return off / hypot(before.vx, before.vz);
}

static void test_rebound(void **state)
{
    (void)state;
    set_seed("rebound", 15);
    double most = 0.0;
    for (int k = 0; k < 3000; k++) {
        shot s = random_shot(RY_LAW_ENERGY, WITH_FLOOR);
        s.a = evenly_log(1e-3, 9.0);
        s.speed = evenly_log(1e-3, 0.1);
        most = fmax(most, rebound_is_off(&s));
    }
    printf("rebound from a floor: velocity and spin off by at most %.1e of the speed\n", most);
    assert_true(most < 1e-11);
}

/* ---- restitution of unequal pairs ------------------------------------------------------------------ */

/* Head on, in a common motion, mass ratios 1e-3 to 1e3. The overlap is the difference of positions of the
 * order of a diameter, so it is known to about 1e-16/speed of itself, which enters with a. */
static void test_unequal_pairs(void **state)
{
    (void)state;
    set_seed("unequal", 12);
    const int tested[] = {RY_LAW_ENERGY, RY_LAW_FUJIOKA2};
    for (int m = 0; m < 2; m++) {
        double most = 0.0;
        for (int k = 0; k < 1500; k++) {
            shot s = random_shot(tested[m], k % PARTNERS);
            s.angle = s.spin = 0.0;
            s.speed = evenly_log(1e-2, 5e-2);
            s.e = evenly(0.05, 1.0);
            s.ratio = s.partner == WITH_FLOOR ? 1.0 : evenly_log(0.25, 4.0);
            s.density = evenly_log(0.1, 10.0);
            scene *const run = aim(&s);
            const double before = approach(run, s.partner);
            step_scene(run, 12);
            const double e = -approach(run, s.partner) / before;
            most = fmax(most, fabs(e - s.e));
            close_scene(run);
        }
        printf("%s: restitution of unequal pairs off by at most %.1e\n", law_words[tested[m]],
               most);
        assert_true(most <= 1e-12);
    }
}

/* ---- a cloud ---------------------------------------------------------------------------------------- */

/* Sixty grains of random sizes fly together; thousands of contacts, with friction and spin. */
static scene *open_cloud(int law, uint64_t seed)
{
    static char list[24000];
    size_t end = 0;
    random_state = seed;
    for (int k = 0; k < 64; k++) {
        const double x = 1.5e-3 * (k % 8 - 3.5), z = 1.5e-3 * (k / 8 - 3.5);
        end += (size_t)snprintf(
            list + end, sizeof list - end,
            "  - {position: [%.17g, %.17g], velocity: [%.17g, %.17g], spin: %.17g, "
            "diameter: %.17g, density: 2650}\n",
            x, z, -80.0 * x + evenly(-0.3, 0.3), -80.0 * z + evenly(-0.3, 0.3),
            evenly(-300.0, 300.0), evenly(0.6e-3, 1.4e-3));
    }
    static char text[26000];
    snprintf(
        text, sizeof text,
        "time: {step: 2e-6}\ncontact: {law: %s, alpha_m: 40, restitution: 0.7, friction: 0.5}\n"
        "output: {fields: [energy]}\nparticles:\n%s",
        law_words[law], list);
    return open_text(text);
}

static void test_cloud(void **state)
{
    (void)state;
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        scene *const s = open_cloud(law, 13);
        const totals before = totals_of(s);
        double worst_p = 0.0, worst_l = 0.0;
        for (int k = 0; k < 20; k++) {
            step_scene(s, 500);
            const totals t = totals_of(s);
            worst_p = fmax(worst_p, hypot(t.px - before.px, t.pz - before.pz) / before.scale_p);
            worst_l = fmax(worst_l, fabs(t.angular - before.angular) / before.scale_angular);
        }
        const ry_sample end = ry_sim_sample(s->sim);
        const double lost =
            end.loss_impact + end.loss_dashpot + end.loss_friction + end.loss_opening;
        printf(
            "cloud, %s: momentum %.1e, angular momentum %.1e; lost %.1f %% of the energy, integration %.1e of it\n",
            law_words[law], worst_p, worst_l, 100.0 * lost / before.kinetic,
            end.integration / lost);
        assert_true(worst_p <= 1e-12);
        /* shifts of several contacts at once turn a grain's arm: only a pair's is put right */
        assert_true(worst_l <= (ry_laws[law].moves ? 1e-6 : 1e-12));
        assert_true(lost > 0.2 * before.kinetic);
        close_scene(s);
    }
}

/* ---- clusters ------------------------------------------------------------------------------------------- */

/* n grains of 1 mm from all sides meet in the middle, where one more lies. No friction; a step of 1 us. */
static scene *open_cluster(int n, double a, double speed)
{
    const double dt = 1e-6, d = 1e-3, mass = 2650.0 * M_PI / 6.0 * d * d * d, v = speed * d / dt;
    const double start = 1.3 * d * n / M_PI + 10.0 * v * dt;
    char list[2000] = "";
    size_t end = 0;
    for (int k = 0; k < n; k++) {
        const double at = 2.0 * M_PI * (k + evenly(-0.2, 0.2)) / n, way = at + evenly(-0.15, 0.15);
        const double r = start * evenly(0.97, 1.03), u = v * evenly(0.7, 1.3);
        end += (size_t)snprintf(list + end, sizeof list - end,
                                "  - {position: [%.17g, %.17g], velocity: [%.17g, %.17g], diameter: 1 mm, density: 2650}\n",
                                r * cos(at), r * sin(at), -u * cos(way), -u * sin(way));
    }
    return open_scene("time: {step: 1e-6}\noutput: {fields: [energy]}\n"
                      "contact: {law: energy, stiffness: %.17g, restitution: 1, friction: 0}\nparticles:\n%s"
                      "  - {position: [0, 0], diameter: 1 mm, density: 2650}\n",
                      0.5 * a * mass / (dt * dt), list);
}

/* With e = 1 nothing hides a gain. What an impact's spring holds is what was paid into it, whatever the others do; only
 * when it lets go in their midst it may give more than it has. */
static void test_clusters(void **state)
{
    (void)state;
    enum { CLUSTERS = 1500 };
    set_seed("clusters", 16);
    double most = 0.0, sum = 0.0;
    for (int s = 0; s < CLUSTERS; s++) {
        const double a = evenly_log(0.05, 0.9), speed = evenly_log(1e-3, 3e-2);
        scene *const run = open_cluster(3 + s % 4, a, speed);
        const double before = totals_of(run).kinetic;
        step_scene(run, 300 + (long long)(8.0 / speed));
        const double gain = totals_of(run).kinetic / before - 1.0;
        most = fmax(most, gain);
        sum += fmax(gain, 0.0);
        close_scene(run);
    }
    printf("clusters with e = 1: gain up to %.1e, in the mean %.1e\n", most, sum / CLUSTERS);
    assert_true(most <= 1e-2);
    assert_true(sum <= 1e-5 * CLUSTERS);
}

/* ---- the ledger of a single impact -------------------------------------------------------------------- */

/* What is left in row `integration` after a central impact without friction, over the energy that came. */
static double left_over(const shot *s, double gravity)
{
    const double speed = 1e-3 / 1e-6 * s->speed, way = speed * 1e-6 * (2.0 + s->phase);
    scene *const run = open_scene(
        "time: {step: 1e-6}\ndomain: {floor: flat, gravity: %.17g}\noutput: {fields: [energy]}\n"
        "contact: {law: %s, alpha_m: 30, restitution: %.17g, friction: 0}\n"
        "particles: [{position: [0, %.17g], velocity: [0, %.17g], diameter: 1 mm, density: 2650}]\n",
        gravity, law_words[s->law], s->e, 0.5e-3 + way, -speed);
    double came = 0.0, most = 0.0;
    for (int k = 0; k < 100; k++) {
        step_scene(run, 1);
        const ry_sample now = ry_sim_sample(run->sim);
        came = fmax(came, now.kinetic_energy);
        most = fmax(most, fabs(now.integration) * (s->law == RY_LAW_ENERGY || k == 99));
    }
    close_scene(run);
    return most / came;
}

static void test_ledger_of_impacts(void **state)
{
    (void)state;
    set_seed("ledger", 14);
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        double most[2] = {0.0, 0.0};
        for (int k = 0; k < 200; k++) {
            const shot s = {.law = law,
                            .speed = evenly_log(1e-3, 2e-2),
                            .e = evenly(0.35, 1.0),
                            .phase = evenly(0.0, 1.0)};
            const double flight =
                evenly_log(120.0, 2000.0); /* steps of the flight that would follow */
            const double gravity =
                k % 2 ? 2.0 * s.e * 1e-3 / 1e-6 * s.speed / (flight * 1e-6) : 0.0;
            most[k % 2] = fmax(most[k % 2], left_over(&s, gravity));
        }
        printf("ledger of an impact, %s: integration is %.1e without, %.1e with gravity\n",
               law_words[law], most[0], most[1]);
        assert_true(most[0] <= 0.05 && most[1] <= 0.05); /* the time stepping's own; a wrong column of laws.def: 20 */
        if (law == RY_LAW_ENERGY) {
            assert_true(most[0] <= 1e-12);
            assert_true(most[1] <= 1e-12);
        }
    }
}

/* ---- oblique impacts: the loss and the books ------------------------------------------------------------ */

/* Two grains alone, or one and a floor: what they lose without friction is (1 - e^2) m_r w_c^2/2, w_c the approach
 * along the line of centres as they meet, whatever the step and where in it they meet. */
typedef struct books {
    double loss; /* less the closed form, over the energy that came */
    double left; /* the most that row `integration` ever had, over the energy that came */
    double back; /* the most that row `loss_impact` ever gave back in a step, likewise */
} books;

static books keep_books(const shot *s)
{
    scene *const run = aim(s);
    const totals before = totals_of(run);
    const grain a = grain_of(run, 0);
    const double reduced = s->partner != WITH_GRAIN ? a.mass : 1.0 / (1.0 / a.mass + 1.0 / grain_of(run, 1).mass);
    const double mean = s->partner == WITH_GRAIN ? a.radius * (1.0 + s->ratio) : 2.0 * a.radius;
    const double closing = s->speed * mean / 1e-6 * cos(s->angle * M_PI / 180.0);
    books out = {0.0, 0.0, 0.0};
    double lost = 0.0;
    for (int k = 0; k < 400 && (k < 5 || touches(run, s->partner)); k++) {
        step_scene(run, 1);
        const ry_sample now = ry_sim_sample(run->sim);
        out.left = fmax(out.left, fabs(now.integration) / before.kinetic);
        out.back = fmax(out.back, (lost - now.loss_impact) / before.kinetic);
        lost = now.loss_impact;
    }
    const double expected = 0.5 * reduced * (1.0 - s->e * s->e) * closing * closing;
    out.loss = fabs(before.kinetic - totals_of(run).kinetic - expected) / before.kinetic;
    close_scene(run);
    return out;
}

static void note_books(double found, const shot *s, double *most, shot *at)
{
    *at = found > *most ? *s : *at;
    *most = fmax(*most, found);
}

static void report_books(const char *what, double most, const shot *s)
{
    printf("oblique impacts of energy: %s %.1e\n  at: %s, %.2f degrees, speed %.2e, diameters %.3g, densities %.3g, "
           "e %.3g, mu %.3g, a %.3g, spin %.3g, phase %.3g\n",
           what, most, partner_words[s->partner], s->angle, s->speed, s->ratio, s->density, s->e, s->friction, s->a,
           s->spin, s->phase);
}

static void test_books_of_oblique_impacts(void **state)
{
    (void)state;
    set_seed("books", 15);
    const int shots = 270 * (getenv("SHOTS") ? atoi(getenv("SHOTS")) : 12);
    double left = 0.0, back = 0.0, loss = 0.0;
    shot at_left = {0}, at_back = {0}, at_loss = {0};
    for (int k = 0; k < shots; k++) {
        shot s = random_shot(RY_LAW_ENERGY, k % PARTNERS);
        s.speed = k % 4 ? s.speed : evenly_log(2e-2, 0.2);
        s.ratio = s.speed < 2e-2 ? s.ratio : 1.0; /* no grain goes half a diameter in a step */
        const books with = keep_books(&s);
        note_books(with.left, &s, &left, &at_left);
        note_books(with.back, &s, &back, &at_back);
        s.spin = s.friction = s.common = 0.0;
        s.e = evenly(0.3, 0.9);
        const double across = s.partner == WITH_FLOOR ? 0.0 : sin(s.angle * M_PI / 180.0);
        const double pace = s.speed * (s.partner == WITH_GRAIN ? 1.0 : 2.0 / (1.0 + s.ratio));
        if (s.e * s.e * cos(s.angle * M_PI / 180.0) > 2.5 * pace * across * across) { /* else too little is left */
            note_books(keep_books(&s).loss, &s, &loss, &at_loss);
        }
    }
    report_books("integration", left, &at_left);
    report_books("given back", back, &at_back);
    report_books("loss off by", loss, &at_loss);
    assert_true(left <= 1e-12);
    assert_true(back <= 1e-12);
    assert_true(loss <= 1e-12);
}

/* ---- two impacts at once -------------------------------------------------------------------------------- */

/* A grain meets two others in the same step, from above, between them; they are `gap` diameters apart.
 * Largest kinetic energy over that before. */
static double meet_two(int law, double e, double gap, int fixed)
{
    const char *const word = fixed ? "true" : "false";
    const double half = 0.5e-3 * (1.0 + gap);
    scene *const s = open_scene(
        "time: {step: 1e-6}\ncontact: {law: %s, alpha_m: 30, restitution: %.17g, friction: 0}\nparticles:\n"
        "  - {position: [0, %.17g], velocity: [0, -2], diameter: 1 mm, density: 2650}\n"
        "  - {position: [%.17g, 0], diameter: 1 mm, density: 2650, fixed: %s}\n"
        "  - {position: [%.17g, 0], diameter: 1 mm, density: 2650, fixed: %s}\n",
        law_words[law], e, sqrt(1e-6 - half * half) + 5e-6, -half, word, half, word);
    const double before = totals_of(s).kinetic;
    double most = 0.0;
    for (int k = 0; k < 200; k++) {
        step_scene(s, 1);
        most = fmax(most, totals_of(s).kinetic / before);
    }
    close_scene(s);
    return most;
}

/* The goal is that no law gains energy. Impact laws reverse the approach at each contact as if it were the
 * only one, and so far they miss it where restitution is high; what is asserted is the default law at e
 * up to 0.7, the rest is printed. */
static void test_two_at_once(void **state)
{
    (void)state;
    const double gaps[] = {0.001, 0.2, 0.4, 0.6, 0.8}, es[] = {0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        printf("two at once, %s:", law_words[law]);
        for (int k = 0; k < 7; k++) {
            double most = 0.0;
            for (int m = 0; m < 10; m++) {
                most = fmax(most, meet_two(law, es[k], gaps[m % 5], m < 5));
            }
            printf(" e %.1f: %+.2f", es[k], most - 1.0);
            assert_true(law != RY_LAW_ENERGY || es[k] > 0.7 || most <= 1.0 + 1e-12);
        }
        printf(" of the energy gained; the goal is 0\n");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_oblique), cmocka_unit_test(test_rebound),     cmocka_unit_test(test_unequal_pairs),
        cmocka_unit_test(test_cloud),       cmocka_unit_test(test_clusters),
        cmocka_unit_test(test_ledger_of_impacts),
        cmocka_unit_test(test_books_of_oblique_impacts), cmocka_unit_test(test_two_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
