/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The law over a block of pairs, without a branch. It is written once, contact_body, and stamped for each law
 * of laws.def and each set of features. Pairs that don't touch go through it like the others and get zeros:
 * in a bed two of three do touch, and to sort them out costs more than it saves. */
#include "stage/contact.h"

#include <math.h>

#include "law/all.h"

typedef ry_push ry_law_fn(const ry_bond q, const ry_touch t);

/* Which of the touching pairs a stamp is for. Laws that tell impacts from enduring contacts do the enduring
 * ones first; the young ones, which are impacts or have been until now, then know how crowded their grains are. CLOSING
 * moves nothing: it books what the last step has left. */
enum { EVERY, ENDURING, YOUNG, CLOSING };

RY_INLINE ry_bond pick_bond(const ry_bond pair, const ry_bond lone, int alone)
{
    ry_bond b;
    b.a = alone ? lone.a : pair.a;
    b.c = alone ? lone.c : pair.c;
    b.e = pair.e;
    b.stretch = alone ? lone.stretch : pair.stretch;
    b.per_stretch = alone ? lone.per_stretch : pair.per_stretch;
    b.drag = alone ? lone.drag : pair.drag;
    b.mass_ratio = pair.mass_ratio;
    return b;
}

/* pair, lone: those of equal grains; im_between: sums of inverse masses below belong to the latter. */
RY_INLINE ry_bond bond_of(const ry_near *near, int32_t k, const ry_law_coef *coef, const ry_bond pair,
                          const ry_bond lone, double im_between, const int ratio, const int features)
{
    ry_bond bond;
    if (features & RY_CONTACT_KEPT) {
#define KEPT(name) .name = near->b_##name[k],
        bond = (ry_bond){RY_BOND_FIELDS(KEPT).e = near->own[k]};
#undef KEPT
    } else if (features & RY_CONTACT_SIZES) {
        bond = ry_bond_damped(coef, near->im[k], near->tm[k], ratio ? near->own[k] : 0.0);
        bond.e = ratio ? coef->e : near->own[k];
    } else {
        bond = pick_bond(pair, lone, near->im[k] < im_between);
    }
    return bond;
}

/* What becomes of the age of a contact, and its mark (RY_SLOT_MARK). */
typedef struct ry_ageing {
    double age, mark;
} ry_ageing;

RY_INLINE ry_ageing age_contact(const int which, double age, const ry_push p, int mine)
{
    const double next = ry_min(age + 1.0, RY_AGE_MAX), first = RY_IMPACT_STEPS + 1.0;
    const double start = p.f < 0.0 ? first : RY_AGE_MAX;
    ry_ageing after = {next, 0.0};
    if (which == ENDURING) {
        const double more = ry_min(next, RY_AGE_MAX - 1.0);
        const double lasting = age < RY_AGE_MAX ? more : ry_min(start + 1.0, RY_AGE_MAX); /* no age of the young */
        const double was = age < RY_AGE_MAX ? 1.0 : 0.0, held = age < first ? 0.0 : was;
        const double will = lasting < RY_AGE_MAX ? 1.0 : 0.0;
        after.age = mine ? lasting : next;
        after.mark = (mine ? (1.0 + RY_MARK_HOLDS) * will : 0.0) - held;
    } else if (which == YOUNG) {
        const double starts = p.f < 0.0 ? 1.0 + RY_MARK_HOLDS : 0.0;
        after.age = p.from > 0.0 ? start : next;
        after.mark = p.from > 0.0 ? starts : 0.0;
    }
    return after;
}

/* ---- the ledger ----------------------------------------------------------------------------- */

/* What a contact loses in one of the two halves of a step: dashpots to the one, sliding to the other row. */
typedef struct ry_loss {
    double dashpot, friction; /* [J] */
} ry_loss;

/* Work is impulse times the mean of the velocities before and after the step, so half of it is booked with the
 * one, and half, when they are there, with the other: w_n, w_t are either, along the normal and the tangent of the
 * impulses jn, jt. Of what friction takes the spring keeps the difference of `held`, its energy before and after,
 * both at the time of the velocities (ry_contact_measure). kt >= 0: the contact slides. */
RY_INLINE ry_loss half_loss(double jn, double jt, double kt, double w_n, double w_t, double held, double half_per_dt)
{
    const double normal = -half_per_dt * jn * w_n, along = -half_per_dt * jt * w_t;
    const int slides = kt >= 0.0;
    return (ry_loss){normal + (slides ? 0.0 : along), slides ? along + held : 0.0};
}

/* Approach x dt of the grains of a pair, the normal, and the distance over the sum of the radii. */
typedef struct ry_place {
    double ux, uz, nx, nz, lever;
} ry_place;

/* The half of the last step's losses that waited for the velocities after it. */
RY_INLINE void book_left(ry_near *near, int32_t k, const ry_place at, double slip, double dt, const int features)
{
    const double *const nx = near->t_nx, *const nz = near->t_nz;
    const double kt = near->t_kt[k], w_n = at.ux * nx[k] + at.uz * nz[k];
    double run = 0.0, w_t = 0.0;
    if (features & RY_CONTACT_FRICTION) {
        run = at.ux * at.nz - at.uz * at.nx + near->turn[k] * (dt * at.lever);
        w_t = at.ux * nz[k] - at.uz * nx[k] + near->turn[k] * (dt * near->t_lever[k]);
    }
    const ry_loss left =
        half_loss(near->t_jn[k], near->t_jt[k], kt, w_n, w_t, -ry_spring_energy(kt, slip + run, run), 0.5 / dt);
    near->lost[RY_LOST_DASHPOT][k] = near->t_dashpot[k] + left.dashpot;
    near->lost[RY_LOST_FRICTION][k] = near->t_sliding[k] + left.friction;
}

/* ---- the loop ------------------------------------------------------------------------------- */

/* Normal n from i to j; tangent t = (n_z, -n_x), along which a positive spin of either grain moves
 * its side of the contact; the contact point divides the distance like the radii, so that the lever
 * arms add up to it and angular momentum is kept. In an impact on what can't move, and takes any of it, the lever is
 * the radius, as of rough rigid spheres. */
RY_INLINE void contact_body(const ry_contact *c, ry_near *near, ry_law_fn *law, const int which, const int moves,
                            const int ratio, const int features)
{
    const double dt = c->dt, back = -dt, per_dt = 1.0 / dt, half_per_dt = 0.5 / dt;
    const double *const im = c->im;
    const int32_t n = near->n_padded;
    const int32_t *const pair_i = near->i, *const pair_j = near->j;
    double *const rests = near->rest, *const slips = near->slip;
    double *const t_nx = near->t_nx, *const t_nz = near->t_nz, *const t_lever = near->t_lever;
    double *const t_jn = near->t_jn, *const t_jt = near->t_jt, *const t_kt = near->t_kt;
    double *const t_dashpot = near->t_dashpot, *const t_sliding = near->t_sliding;
    double (*const lost)[RY_CONTACT_BLOCK] = near->lost;
    ry_law_coef coef = c->coef; /* copies, so that the loop has no conditional loads */
    if (ratio) { /* known when compiled: what bounds a dashpot goes, or its root */
        coef.bounded = 0.0;
    } else {
        coef.hertz = 0.0;
    }
    const ry_bond pair = c->bond[0], lone = c->bond[1];
    const double im_between = 1.5 * c->im_lone;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double distance = near->distance[k], sum = near->radii[k], ims = near->im[k];
        const double ux = near->dvx[k] * back, uz = near->dvz[k] * back;
        const double slip_before = slips[k];
        const int touches = distance < sum;
        const int mine = which == ENDURING ? touches & (near->age[k] > RY_IMPACT_STEPS) : touches;
        const double tms = near->tm[k], per_all = near->per_all[k]; /* one division for four */
        const double inverse = ims * tms * sum * per_all;
        const double nx = near->dx[k] * inverse, nz = near->dz[k] * inverse;
        const double per_ims = per_dt * (distance * tms * sum * per_all);
        const double per_tms = per_dt * (distance * ims * sum * per_all);
        double lever = distance * distance * (ims * tms * per_all);
        if (which == YOUNG) {
            lever = near->firm[k] > 0.0 ? 1.0 : lever;
        }
        if (which == CLOSING) {
            book_left(near, k, (ry_place){ux, uz, nx, nz, lever}, slip_before, dt, features);
            continue;
        }
        const ry_bond bond = bond_of(near, k, &coef, pair, lone, im_between, ratio, features);
        double across = ux * nz - uz * nx;
        const double w_t = features & RY_CONTACT_FRICTION ? across + near->turn[k] * (dt * lever) : 0.0;
        ry_touch t = {.d = sum - distance, .w = ux * nx + uz * nz, .rest = rests[k], .age = near->age[k]};
        t.crowd = t.split = 1.0;
        if (which == YOUNG) {
            t.g = coef.g_dt2 * nz * near->side[k];
            t.crowd = near->crowd[k];
            t.busy = near->busy[k];
            t.split = near->share[k] * (dt * per_ims);
            t.bend = near->bend[k];
            t.across = across;
            t.g_across = -coef.g_dt2 * nx * near->side[k];
            t.stick = -w_t * ims * (dt * per_tms);
            t.mu = features & RY_CONTACT_FRICTION ? coef.friction : 0.0;
            t.pushed = t.age > 0.0 ? slip_before : 0.0;
            t.then = ry_contact_then(near->dx[k], near->dz[k], distance, ux, uz, t.bend > 0.0);
        }
        const ry_push p = law(bond, t);
        const double normal = p.f * per_ims;
        double px = normal * nx, pz = normal * nz, pt = 0.0;
        double slip_after = 0.0;
        ry_loss now = {0.0, 0.0};
        if ((features & RY_CONTACT_LEDGER) && which != YOUNG) {
            book_left(near, k, (ry_place){ux, uz, nx, nz, lever}, slip_before, dt, features);
        }
        if (features & RY_CONTACT_FRICTION) {
            const double fresh = which == EVERY ? 0.0 : p.from; /* new, or an impact until now */
            const double slip = t.age <= fresh ? 0.0 : slip_before + w_t;
            const ry_slide s = ry_tangential(bond, coef.friction, p.f, w_t, slip, p.rough);
            const double along = s.f * per_tms;
            px += along * nz;
            pz -= along * nx;
            pt = along * lever;
            across += s.f * ims * (dt * per_tms);
            slip_after = mine ? s.slip : (touches ? slip_before : 0.0);
            if (features & RY_CONTACT_LEDGER) {
                const double kt = p.rough > 0.0 ? 0.0 : bond.stretch * per_tms * per_dt;
                const double damped = p.rough > 0.0 ? along : -bond.drag * w_t * per_tms;
                const double jt = mine ? (s.slides ? along : damped) : 0.0;
                t_lever[k] = mine ? lever : 0.0;
                t_jt[k] = jt;
                t_kt[k] = (mine & s.slides) ? kt : -1.0;
                now = half_loss(0.0, jt, t_kt[k], 0.0, w_t, ry_spring_energy(kt, slip, w_t), half_per_dt);
            }
        }
        if (moves) { /* moving the grains apart would change r x v: take that out of v */
            const int one = (im[pair_i[k]] == 0.0) | (im[pair_j[k]] == 0.0);
            const double turn = one ? 0.0 : across * (p.shift / (distance - p.shift)) * per_ims;
            px += turn * nz;
            pz -= turn * nx;
            near->sx[k] = mine ? p.shift * nx * (dt * per_ims) : 0.0;
            near->sz[k] = mine ? p.shift * nz * (dt * per_ims) : 0.0;
        }
        if (which == YOUNG) { /* an impact has no such spring */
            slip_after = p.rough > 0.0 ? p.pushed : slip_after;
        }
        if (which == YOUNG || (features & RY_CONTACT_FRICTION)) {
            slips[k] = slip_after;
        }
        if (features & RY_CONTACT_LEDGER) {
            const double jn = mine ? p.dashpot * per_ims : 0.0;
            t_nx[k] = mine ? nx : 0.0; /* 0 x not a number of pairs that fill the list up would stay */
            t_nz[k] = mine ? nz : 0.0;
            t_jn[k] = jn;
            now.dashpot += -half_per_dt * jn * t.w;
            if (which != ENDURING) {
                lost[RY_LOST_IMPACT][k] = mine ? p.impact * per_ims * per_dt : 0.0;
            }
            t_dashpot[k] = mine ? now.dashpot : 0.0;
            t_sliding[k] = mine ? now.friction : 0.0;
        }
        near->px[k] = mine ? px : 0.0;
        near->pz[k] = mine ? pz : 0.0;
        near->pt[k] = mine ? pt : 0.0;
        rests[k] = mine ? p.rest : (touches ? t.rest : 0.0);
        const ry_ageing after = age_contact(which, t.age, p, mine);
        near->age[k] = touches ? after.age : 0.0;
        near->mark[k] = after.mark;
    }
}

#define STAMP(name, function, which, moves, ratio, f)                                          \
    RY_CLONES static void name##_##f(const ry_contact *c, ry_near *near)                       \
    {                                                                                          \
        contact_body(c, near, function, which, moves, ratio, f);                      \
    }
#define STAMPS(name, function, which, moves, ratio)                                                     \
    STAMP(name, function, which, moves, ratio, 0) STAMP(name, function, which, moves, ratio, 1)         \
    STAMP(name, function, which, moves, ratio, 2) STAMP(name, function, which, moves, ratio, 3)         \
    STAMP(name, function, which, moves, ratio, 4) STAMP(name, function, which, moves, ratio, 5)         \
    STAMP(name, function, which, moves, ratio, 6) STAMP(name, function, which, moves, ratio, 7)         \
    STAMP(name, function, which, moves, ratio, 10) STAMP(name, function, which, moves, ratio, 11)       \
    STAMP(name, function, which, moves, ratio, 14) STAMP(name, function, which, moves, ratio, 15)
#define ALL(name)                                                                                       \
    {name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6, name##_7,                    \
     NULL, NULL, name##_10, name##_11, NULL, NULL, name##_14, name##_15}

#define FIRST_0(name, moves, ratio) STAMPS(first_##name, ry_law_##name, EVERY, moves, ratio)
#define FIRST_1(name, moves, ratio) STAMPS(first_##name, ry_law_##name##_enduring, ENDURING, moves, ratio)
#define THEN_0(name, moves, ratio)
#define THEN_1(name, moves, ratio) STAMPS(young_##name, ry_law_##name, YOUNG, moves, ratio)
#define YOUNG_0(name) {NULL}
#define YOUNG_1(name) ALL(young_##name)

/* The books are closed alike for all laws. */
RY_INLINE ry_push no_law(const ry_bond q, const ry_touch t)
{
    (void)q;
    (void)t;
    return (ry_push){0};
}
STAMP(close, no_law, CLOSING, 0, 0, 4)
STAMP(close, no_law, CLOSING, 0, 0, 5)
STAMP(close, no_law, CLOSING, 0, 0, 6)
STAMP(close, no_law, CLOSING, 0, 0, 7)

#define RY_LAW(name, law, moves, ratio, parts, ...) \
    FIRST_##parts(name, moves, ratio) THEN_##parts(name, moves, ratio)
#include "law/laws.def"
#undef RY_LAW

static const struct {
    ry_contact_fn *kernel[RY_CONTACT_STAMPS], *young[RY_CONTACT_STAMPS];
} laws[] = {
#define RY_LAW(name, law, moves, ratio, parts, ...) {ALL(first_##name), YOUNG_##parts(name)},
#include "law/laws.def"
#undef RY_LAW
};

ry_contact_fn *ry_contact_select(int law, int features)
{
    return laws[law].kernel[features];
}

ry_contact_fn *ry_contact_select_young(int law, int features)
{
    return laws[law].young[features];
}

ry_contact_fn *ry_contact_select_close(int features)
{
    static ry_contact_fn *const kernels[RY_CONTACT_STAMPS] = {NULL,    NULL,    NULL,    NULL,
                                                              close_4, close_5, close_6, close_7};
    return kernels[features & ~RY_CONTACT_KEPT];
}
