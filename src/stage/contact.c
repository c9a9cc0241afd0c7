/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The listed pairs are first looked at for touch (geometry only) and the touching ones collected side by
 * side; then it is known how many contacts each grain has, and the law's kernel runs over them without
 * a branch. The kernel is written once, contact_body, and stamped for each law of laws.def and each set
 * of features. */
#include "stage/contact.h"

#include <math.h>
#include <string.h>

#include "law/cundall.h"
#include "law/energy.h"
#include "law/fujioka.h"
#include "law/tanaka.h"

/* ---- the kernel ----------------------------------------------------------------------------- */

typedef ry_push ry_law_fn(const ry_bond q, const ry_touch t);

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

/* Normal n from i to j; tangent t = (n_z, -n_x), along which a positive spin of either grain moves
 * its side of the contact; the contact point divides the distance like the radii, so that the lever
 * arms add up to it and angular momentum is kept. */
RY_INLINE void contact_body(const ry_contact *c, const ry_grains *g, ry_near *near, ry_law_fn *law,
                            const int moves, const int ratio, const int features)
{
    const double dt = c->dt, per_dt = 1.0 / dt;
    const double *const vx = g->vx, *const vz = g->vz, *const spin = g->spin, *const r = g->radius;
    const double *const im = c->im, *const tmg = c->tm_grain;
    const int32_t n = near->n_padded;
    ry_law_coef coef = c->coef; /* copies, so that the loop has no conditional loads */
    const double *const own = near->own;
    if (!ratio) { /* known when compiled: the root of ry_bond_damped goes */
        coef.hertz = 0.0;
    }
    const ry_bond pair = c->bond[0], lone = c->bond[1];
    const double tm_pair = c->tm[0], tm_lone = c->tm[1];
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const int32_t i = near->i[k], j = near->j[k];
        const double distance = near->t_lever[k];
        const double sum = r[i] + r[j];
        const double ux = (vx[i] - vx[j]) * dt, uz = (vz[i] - vz[j]) * dt;
        const double im_i = im[i], im_j = im[j];
        const int alone = (im_i == 0.0) | (im_j == 0.0);
        const double ims = im_i + im_j;
        double tms;
        ry_bond bond;
        if (features & RY_CONTACT_SIZES) {
            tms = tmg[i] + tmg[j];
            bond = ry_bond_damped(&coef, ims, tms, ratio ? own[k] : 0.0);
            bond.e = ratio ? coef.e : own[k];
        } else {
            tms = alone ? tm_lone : tm_pair;
            bond = pick_bond(pair, lone, alone);
        }
        const double per_all = 1.0 / (distance * ims * tms * sum); /* one division for four */
        const double inverse = ims * tms * sum * per_all;
        const double nx = near->t_nx[k] * inverse, nz = near->t_nz[k] * inverse;
        const double per_ims = per_dt * (distance * tms * sum * per_all);
        const double per_tms = per_dt * (distance * ims * sum * per_all);
        ry_touch t;
        t.d = sum - distance;
        t.w = ux * nx + uz * nz;
        t.g = coef.g_dt2 * nz * ((im_i == 0.0 ? 1.0 : 0.0) - (im_j == 0.0 ? 1.0 : 0.0));
        t.rest = near->rest[k];
        t.age = near->age[k];
        t.crowd = near->crowd[k];
        t.split = (near->young_i[k] * im_i + near->young_j[k] * im_j) * (dt * per_ims);
        const ry_push p = law(bond, t);
        const double normal = p.f * per_ims;
        double px = normal * nx, pz = normal * nz;
        double across = ux * nz - uz * nx;
        if (features & RY_CONTACT_FRICTION) {
            const double lever = distance * distance * (ims * tms * per_all);
            const double w_t = across + (spin[i] * r[i] + spin[j] * r[j]) * (dt * lever);
            const double slip = t.age == 0.0 ? 0.0 : near->slip[k] + w_t;
            const ry_slide s = ry_tangential(bond, coef.friction, p.f, w_t, slip, p.rough);
            const double along = s.f * per_tms;
            px += along * nz;
            pz -= along * nx;
            across += s.f * ims * (dt * per_tms);
            near->pt[k] = along * lever;
            near->slip[k] = s.slip;
            if (features & RY_CONTACT_LEDGER) {
                const double kt = p.rough > 0.0 ? 0.0 : bond.stretch * per_tms * per_dt;
                const double damped = p.rough > 0.0 ? along : -bond.drag * w_t * per_tms;
                near->t_lever[k] = lever;
                near->t_run[k] = w_t;
                near->t_jt[k] = s.slides ? along : damped;
                near->t_et[k] = s.slides ? 0.5 * kt * slip * slip : -1.0;
                near->t_kt[k] = kt;
            }
        } else if (features & RY_CONTACT_LEDGER) {
            near->t_lever[k] = near->t_run[k] = near->t_jt[k] = near->t_kt[k] = 0.0;
            near->t_et[k] = -1.0;
        }
        if (moves) { /* moving the grains apart would change r x v: take that out of v */
            const double turn = alone ? 0.0 : across * (p.shift / (distance - p.shift)) * per_ims;
            px += turn * nz;
            pz -= turn * nx;
            near->sx[k] = p.shift * nx * (dt * per_ims);
            near->sz[k] = p.shift * nz * (dt * per_ims);
        }
        if (features & RY_CONTACT_LEDGER) {
            near->impact[k] = p.held < 0.0 ? p.impact * per_ims * per_dt : 0.0;
            near->t_en[k] = p.held < 0.0 ? -1.0 : p.held * per_ims * per_dt;
            near->t_nx[k] = nx;
            near->t_nz[k] = nz;
            near->t_jn[k] = p.held < 0.0 ? p.dashpot * per_ims : normal;
        }
        if (!(features & RY_CONTACT_FRICTION)) {
            near->pt[k] = 0.0;
        }
        near->px[k] = px;
        near->pz[k] = pz;
        near->rest[k] = p.rest;
        near->age[k] = ry_min(t.age + 1.0, RY_AGE_MAX);
    }
}

#define STAMP(name, moves, ratio, f)                                                                 \
    RY_CLONES static void contact_##name##_##f(const ry_contact *c, const ry_grains *g, ry_near *near) \
    {                                                                                          \
        contact_body(c, g, near, ry_law_##name, moves, ratio, f);                                     \
    }
#define RY_LAW(name, law, moves, ratio, letter, source)                              \
    STAMP(name, moves, ratio, 0) STAMP(name, moves, ratio, 1) STAMP(name, moves, ratio, 2)         \
    STAMP(name, moves, ratio, 3) STAMP(name, moves, ratio, 4) STAMP(name, moves, ratio, 5)         \
    STAMP(name, moves, ratio, 6) STAMP(name, moves, ratio, 7)
#include "law/laws.def"
#undef RY_LAW

static const struct {
    const char *name;
    int moves, ratio;
    ry_contact_fn *kernel[RY_CONTACT_STAMPS];
} laws[] = {
#define RY_LAW(name, law, moves, ratio, letter, source)                                                 \
    {#name, moves, ratio, {contact_##name##_0, contact_##name##_1, contact_##name##_2, contact_##name##_3, \
                    contact_##name##_4, contact_##name##_5, contact_##name##_6, contact_##name##_7}},
#include "law/laws.def"
#undef RY_LAW
};

ry_contact_fn *ry_contact_select(int law, int features)
{
    return laws[law].kernel[features];
}

const char *ry_contact_law_name(int law)
{
    return laws[law].name;
}

int ry_contact_law_moves(int law)
{
    return laws[law].moves;
}

int ry_contact_law_damps(int law)
{
    return laws[law].ratio;
}

/* ---- who touches ---------------------------------------------------------------------------- */

RY_INLINE ry_gap wall_gap(const ry_contact *c, ry_wall wall, double x, double z)
{
    const double right = c->wall_length - x;
    ry_gap gap;
    gap.dx = wall == RY_WALL_FLOOR ? 0.0 : (wall == RY_WALL_LEFT ? -x : right);
    gap.dz = wall == RY_WALL_FLOOR ? -z : 0.0;
    gap.distance = wall == RY_WALL_FLOOR ? z : (wall == RY_WALL_LEFT ? x : right);
    return gap;
}

ry_gap ry_contact_gap(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    if (j >= g->n) {
        return wall_gap(c, c->wall[j - g->n], g->x[i], g->z[i]);
    }
    ry_gap gap;
    gap.dx = ry_contact_nearest(g->x[j] - g->x[i], c->length, c->half);
    gap.dz = g->z[j] - g->z[i];
    gap.distance = sqrt(gap.dx * gap.dx + gap.dz * gap.dz);
    return gap;
}

/* Tangential velocity of the contact point of i against that of j. */
static double slip_velocity(const ry_grains *g, int32_t i, int32_t j, ry_gap gap)
{
    const double nx = gap.dx / gap.distance, nz = gap.dz / gap.distance;
    const double lever = gap.distance / (g->radius[i] + g->radius[j]);
    return (g->vx[i] - g->vx[j]) * nz - (g->vz[i] - g->vz[j]) * nx +
           (g->spin[i] * g->radius[i] + g->spin[j] * g->radius[j]) * lever;
}

ry_bond ry_contact_bond(const ry_contact *c, int32_t i, int32_t j)
{
    return ry_bond_make(&c->coef, c->im[i] + c->im[j], c->tm_grain[i] + c->tm_grain[j]);
}

static double tangential_energy(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs,
                                int32_t p, ry_gap gap, double stretch)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double slip = pairs->slip[p] + slip_velocity(g, i, j, gap) * c->dt;
    return 0.5 * stretch * slip * slip / ((c->tm_grain[i] + c->tm_grain[j]) * c->dt * c->dt);
}

/* A contact has opened: what its tangential spring holds is lost. */
static void open_contact(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t p)
{
    if ((c->features & RY_CONTACT_LEDGER) && (c->features & RY_CONTACT_FRICTION)) {
        const double stretch = ry_contact_bond(c, pairs->i[p], pairs->j[p]).stretch;
        c->loss_opening[pairs->i[p]] +=
            tangential_energy(c, g, pairs, p, ry_contact_gap(c, g, pairs, p), stretch);
    }
    memset(pairs->slot[p], 0, sizeof pairs->slot[p]);
    pairs->slip[p] = pairs->rest[p] = 0.0;
    pairs->age[p] = 0;
    if (c->film.on) {
        pairs->wet[p] = 0.0;
    }
    if (c->moves) {
        pairs->sx[p] = pairs->sz[p] = 0.0;
    }
}

/* What a look at a block of listed pairs found. */
typedef struct ry_look {
    double dx[RY_CONTACT_BLOCK], dz[RY_CONTACT_BLOCK], distance[RY_CONTACT_BLOCK];
    uint8_t touches[RY_CONTACT_BLOCK];
} ry_look;

RY_CLONES static void look_at_pairs(const ry_contact *c, const ry_grains *g, const int32_t *i,
                                    const int32_t *j, int32_t n, ry_look *look)
{
    const double *const x = g->x, *const z = g->z, *const r = g->radius;
    const double length = c->length, half = c->half;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double dx = ry_contact_nearest(x[j[k]] - x[i[k]], length, half);
        const double dz = z[j[k]] - z[i[k]];
        const double distance = sqrt(dx * dx + dz * dz);
        look->dx[k] = dx;
        look->dz[k] = dz;
        look->distance[k] = distance;
        look->touches[k] = distance < r[i[k]] + r[j[k]];
    }
}

static void look_at_walls(const ry_contact *c, const ry_grains *g, const int32_t *i, const int32_t *j,
                          int32_t n, ry_look *look)
{
    for (int32_t k = 0; k < n; k++) {
        const ry_gap gap = wall_gap(c, c->wall[j[k] - g->n], g->x[i[k]], g->z[i[k]]);
        look->dx[k] = gap.dx;
        look->dz[k] = gap.dz;
        look->distance[k] = gap.distance;
        look->touches[k] = gap.distance < g->radius[i[k]];
    }
}

/* Lists the pairs of a block that touch from place `at` of `touching` on, with what was seen of them, and
 * closes the books of those that have parted. Returns how many touch. */
static int32_t collect(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t first, int32_t n,
                       const ry_look *look, int32_t at)
{
    int32_t hit[RY_CONTACT_BLOCK], parted[RY_CONTACT_BLOCK];
    int32_t hits = 0, partings = 0;
    for (int32_t k = 0; k < n; k++) {
        const int touches = look->touches[k];
        hit[hits] = k;
        hits += touches;
        parted[partings] = k;
        partings += !touches & (pairs->age[first + k] != 0);
    }
    for (int32_t k = 0; k < partings; k++) {
        open_contact(c, g, pairs, first + parted[k]);
    }
    int32_t *const touching = pairs->touching + at;
    double *const nx = pairs->t_nx + at, *const nz = pairs->t_nz + at, *const lever = pairs->t_lever + at;
#pragma omp simd
    for (int32_t m = 0; m < hits; m++) {
        touching[m] = first + hit[m];
        nx[m] = look->dx[hit[m]];
        nz[m] = look->dz[hit[m]];
        lever[m] = look->distance[hit[m]];
    }
    return hits;
}

/* Counts the contacts of each grain. Whole numbers: the order in which threads come does not show. */
static void count_contacts(const ry_contact *c, ry_pairs *pairs, int32_t at, int32_t n)
{
    int32_t *restrict const crowd = pairs->crowd;
    const int32_t *const touching = pairs->touching, *const owner = pairs->i, *const partner = pairs->j;
    const int alone = c->threads == 1;
    for (int32_t m = at; m < at + n; m++) {
        const int32_t p = touching[m];
        const int32_t one = RY_CROWD_ALL + (pairs->age[p] < (int)RY_IMPACT_STEPS);
        if (alone) {
            crowd[owner[p]] += one;
            crowd[partner[p]] += one;
        } else {
#pragma omp atomic
            crowd[owner[p]] += one;
#pragma omp atomic
            crowd[partner[p]] += one;
        }
    }
}

/* Finds who touches among the pairs first .. end-1. */
static int32_t find_range(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t first,
                          int32_t end, int walls)
{
    ry_look look;
    int32_t touching = 0;
    for (int32_t p = first; p < end; p += RY_CONTACT_BLOCK) {
        const int32_t n = end - p < RY_CONTACT_BLOCK ? end - p : RY_CONTACT_BLOCK;
        (walls ? look_at_walls : look_at_pairs)(c, g, pairs->i + p, pairs->j + p, n, &look);
        touching += collect(c, g, pairs, p, n, &look, first + touching);
    }
    if (c->counts) {
        count_contacts(c, pairs, first, touching);
    }
    return touching;
}

/* Loads n touching pairs from place `at` on for the kernel; the last is repeated to fill the vectors. */
RY_CLONES static void load(const ry_contact *c, const ry_pairs *pairs, int32_t at, int32_t n, ry_near *near)
{
    const int32_t *const touching = pairs->touching + at, *const owner = pairs->i, *const partner = pairs->j;
    const int32_t *const crowd = pairs->crowd;
    const double *const slip = pairs->slip, *const rest = pairs->rest;
    const uint8_t *const age = pairs->age;
    const double *const im = c->im;
    near->n = n;
    near->n_padded = (n + RY_CONTACT_LANES - 1) / RY_CONTACT_LANES * RY_CONTACT_LANES;
    memcpy(near->pair, touching, (size_t)n * sizeof *near->pair);
    const int fills = n == near->n_padded;
    int32_t field = 0;
#define RY_GAP_LOAD(name)                                                             \
    near->t_##name = fills ? pairs->t_##name + at : near->spare[field];               \
    field++;
    RY_GAP_FIELDS(RY_GAP_LOAD)
#undef RY_GAP_LOAD
#define RY_TOUCH_LOAD(name, unit, text)                                               \
    near->t_##name = fills ? pairs->t_##name + at : near->spare[field];               \
    field++;
    if (pairs->t_run != NULL) {
        RY_TOUCH_FIELDS(RY_TOUCH_LOAD)
    }
#undef RY_TOUCH_LOAD
#define RY_GAP_COPY(name) memcpy(near->t_##name, pairs->t_##name + at, (size_t)n * sizeof(double));
    if (!fills) {
        RY_GAP_FIELDS(RY_GAP_COPY)
    }
#undef RY_GAP_COPY
    for (int32_t m = n; m < near->n_padded; m++) {
        near->pair[m] = near->pair[n - 1];
#define RY_GAP_PAD(name) near->t_##name[m] = near->t_##name[n - 1];
        RY_GAP_FIELDS(RY_GAP_PAD)
#undef RY_GAP_PAD
    }
#pragma omp simd
    for (int32_t m = 0; m < near->n_padded; m++) {
        const int32_t p = near->pair[m], i = owner[p], j = partner[p];
        near->i[m] = i;
        near->j[m] = j;
        const int32_t all_i = im[i] > 0.0 ? crowd[i] / RY_CROWD_ALL : RY_CROWD_ALL;
        const int32_t all_j = im[j] > 0.0 ? crowd[j] / RY_CROWD_ALL : RY_CROWD_ALL;
        near->crowd[m] = all_i < all_j ? all_i : all_j;
        near->young_i[m] = crowd[i] % RY_CROWD_ALL;
        near->young_j[m] = crowd[j] % RY_CROWD_ALL;
        near->slip[m] = slip[p];
        near->rest[m] = rest[p];
    }
    for (int32_t m = 0; m < near->n_padded; m++) {
        near->age[m] = age[near->pair[m]];
    }
}

/* ---- contacts in a viscous fluid ------------------------------------------------------------- */

double ry_contact_wet(const ry_film *film, const ry_law_coef *coef, double a, double c, double loss)
{
    if (!film->damps) {
        return ry_wet_restitution(coef->e, loss);
    }
    const double root = film->unit * sqrt(a);
    /* what the step bears; and no more than stops the approach within it */
    const double most = ry_min(0.999 * 0.5 * (4.0 / film->many - a), 1.0) / root;
    return film->unit * ry_wet_damping(c / root, loss, most, film->usual);
}

/* Of grains i and j that close with the approach [m/s]. */
static double film_between(const ry_contact *c, const ry_grains *g, int32_t i, int32_t j, double approach)
{
    const double ri = g->radius[i], rj = g->radius[j], volume = 4.0 / 3.0 * 3.141592653589793;
    const double im_i = c->im[i] > 0.0 ? 1.0 / (volume * ri * ri * ri * g->density[i]) : 0.0;
    const double im_j = c->im[j] > 0.0 ? 1.0 / (volume * rj * rj * rj * g->density[j]) : 0.0;
    const double curvature = (ri > 0.0 ? 1.0 / ri : 0.0) + (rj > 0.0 ? 1.0 / rj : 0.0);
    const double stokes = approach * ry_wet_stokes(c->film.per_mu, im_i + im_j, curvature);
    const double a = c->coef.k_dt2 * (c->im[i] + c->im[j]);
    const double damping = c->coef.zeta2 > 0.0 ? c->coef.zeta2 * sqrt(a) : c->coef.eta_dt * (c->im[i] + c->im[j]);
    return ry_contact_wet(&c->film, &c->coef, a, damping, ry_wet_loss(stokes));
}

/* The first step of a contact decides, from its speed, what the fluid leaves; the contact keeps it. */
static void wet_block(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, ry_near *near)
{
    for (int32_t k = 0; k < near->n_padded; k++) {
        const int32_t i = near->i[k], j = near->j[k];
        near->wet[k] = pairs->wet[near->pair[k]];
        if (near->age[k] == 0.0) {
            const double ux = g->vx[i] - g->vx[j], uz = g->vz[i] - g->vz[j];
            const double approach = (ux * near->t_nx[k] + uz * near->t_nz[k]) / near->t_lever[k];
            near->wet[k] = film_between(c, g, i, j, approach);
        }
    }
}

/* ---- the stage ------------------------------------------------------------------------------ */

static void store(const ry_contact *c, ry_pairs *pairs, const ry_near *near)
{
    double (*restrict const slot)[RY_SLOT] = pairs->slot;
    double *restrict const rest = pairs->rest, *restrict const slip = pairs->slip;
    double *restrict const sx = pairs->sx, *restrict const sz = pairs->sz;
    uint8_t *restrict const age = pairs->age;
    const int32_t n = near->n;
    for (int32_t k = 0; k < n; k++) {
        const int32_t p = near->pair[k];
        slot[p][RY_SLOT_X] = near->px[k];
        slot[p][RY_SLOT_Z] = near->pz[k];
        slot[p][RY_SLOT_TURN] = near->pt[k];
        rest[p] = near->rest[k];
        age[p] = (uint8_t)near->age[k];
    }
    if (c->features & RY_CONTACT_FRICTION) {
        for (int32_t k = 0; k < n; k++) {
            slip[near->pair[k]] = near->slip[k];
        }
    }
    for (int32_t k = 0; k < n && c->film.on; k++) {
        pairs->wet[near->pair[k]] = near->wet[k];
    }
    if (c->moves) {
        for (int32_t k = 0; k < n; k++) {
            sx[near->pair[k]] = near->sx[k];
            sz[near->pair[k]] = near->sz[k];
        }
    }
}

/* Chunks end where the pairs of an owner end, so no other thread books for the same grain. */
static void book(const ry_contact *c, ry_pairs *pairs, const ry_near *near, int32_t at)
{
    const size_t bytes = (size_t)near->n * sizeof(double);
    for (int32_t k = 0; k < near->n && !c->counts; k++) { /* energy: the ledger takes it from the work */
        c->loss_impact[near->i[k]] += near->impact[k];
    }
    if (near->n == near->n_padded) {
        return; /* the kernel wrote where it belongs */
    }
#define RY_GAP_COPY(name) memcpy(pairs->t_##name + at, near->t_##name, bytes);
    RY_GAP_FIELDS(RY_GAP_COPY)
#undef RY_GAP_COPY
#define RY_TOUCH_COPY(name, unit, text) memcpy(pairs->t_##name + at, near->t_##name, bytes);
    RY_TOUCH_FIELDS(RY_TOUCH_COPY)
#undef RY_TOUCH_COPY
}

/* Runs the law over the n touching pairs from place `from` on. */
static void push_range(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t from, int32_t n)
{
    ry_near near;
    for (int32_t at = from; at < from + n; at += RY_CONTACT_BLOCK) {
        const int32_t left = from + n - at;
        load(c, pairs, at, left < RY_CONTACT_BLOCK ? left : RY_CONTACT_BLOCK, &near);
        near.own = c->dry;
        if (c->film.on) {
            wet_block(c, g, pairs, &near);
            near.own = near.wet;
        }
        c->kernel(c, g, &near);
        store(c, pairs, &near);
        if (c->features & RY_CONTACT_LEDGER) {
            book(c, pairs, &near, at);
        }
    }
}

typedef struct ry_contact_task {
    const ry_contact *contact;
    const ry_grains *grains;
    ry_pairs *pairs;
} ry_contact_task;

static void find_chunks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_contact_task *const t = context;
    ry_pairs *const pairs = t->pairs;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        pairs->n_touching[k] = find_range(t->contact, t->grains, pairs, pairs->chunk[k], pairs->chunk[k + 1], 0);
    }
}

static void push_chunks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_contact_task *const t = context;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        push_range(t->contact, t->grains, t->pairs, t->pairs->chunk[k], t->pairs->n_touching[k]);
    }
}

void ry_contact_stage(const ry_contact *c, const ry_grains *g, ry_pairs *pairs)
{
    ry_contact_task task = {c, g, pairs};
    int32_t *const at_walls = &pairs->n_touching[pairs->n_chunks];
    if (c->counts) {
        memset(pairs->crowd, 0, ((size_t)g->n + RY_MAX_WALLS) * sizeof *pairs->crowd);
    }
    ry_parallel(c->threads, pairs->n_chunks, find_chunks, &task);
    *at_walls = find_range(c, g, pairs, pairs->n_inner, pairs->n, 1);
    ry_parallel(c->threads, pairs->n_chunks, push_chunks, &task);
    push_range(c, g, pairs, pairs->n_inner, *at_walls);
}

/* ---- measuring ------------------------------------------------------------------------------ */

/* Laws whose closing step replaces the overlap hold no energy in a contact before it. */
static double normal_energy(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p,
                            ry_gap gap, double a)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double stretch = ry_max(g->radius[i] + g->radius[j] - gap.distance - pairs->rest[p], 0.0);
    const double power = c->coef.hertz > 0.0 ? 0.4 * sqrt(stretch) : 0.5; /* int a d^1.5, int a d */
    return power * a * stretch * stretch / ((c->im[i] + c->im[j]) * c->dt * c->dt);
}

static void note_overlap(const ry_grains *g, int32_t i, int32_t j, double overlap, ry_contact_sums *sums)
{
    const double smaller = j < g->n ? ry_min(g->radius[i], g->radius[j]) : g->radius[i];
    if (overlap > sums->worst_overlap * smaller) {
        sums->worst_overlap = overlap / smaller;
        sums->worst_i = i;
        sums->worst_j = j;
    }
}

/* Sums run over the owners in ascending id, so that they don't depend on the list. */
ry_contact_sums ry_contact_measure(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs)
{
    ry_contact_sums sums = {.worst_i = -1, .worst_j = -1};
    for (int32_t id = 0; id < g->n; id++) {
        const int32_t k = pairs->place[id];
        const int32_t own = pairs->row[k + 1] - pairs->row[k];
        for (int32_t m = 0; m < own + c->n_walls; m++) {
            const int32_t p = m < own ? pairs->row[k] + m : pairs->wall_slot[m - own][k];
            if (p < 0 || pairs->age[p] == 0) {
                continue;
            }
            const ry_gap gap = ry_contact_gap(c, g, pairs, p);
            const ry_bond q = ry_contact_bond(c, k, pairs->j[p]);
            note_overlap(g, k, pairs->j[p], g->radius[k] + g->radius[pairs->j[p]] - gap.distance, &sums);
            sums.touching++;
            sums.elastic_normal += normal_energy(c, g, pairs, p, gap, q.a);
            if (c->features & RY_CONTACT_FRICTION) {
                sums.elastic_tangential += tangential_energy(c, g, pairs, p, gap, q.stretch);
            }
        }
    }
    return sums;
}
