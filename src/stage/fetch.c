/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Blocks of pairs: what the law needs of them and of their grains, side by side. */
#include "stage/contact_private.h"

#include <math.h>

#include "stage/four.h"

/* Large beds come from beyond the caches, and records that are read here and there are not foreseen by the
 * processor: those of so many grains further on are asked for. */
enum { AHEAD = 96 };
/* So many pairs have as many owners as a line has numbers, about: as often the next of ry_contact.ahead are due. */
enum { A_LINE = 16 };

/* What the law needs of a pair is differences (of position and velocity) and sums. One load fetches half a grain, */
RY_INLINE void fetch_four(const double (*body)[RY_BODY], ry_near *near, int32_t k)
{
    const int32_t *const i = near->i + k, *const j = near->j + k;
    const ry_four flip = {-1.0, -1.0, 1.0, 1.0};
    ry_four place[4], motion[4];
    for (int32_t m = 0; m < 4; m++) {
        const double *const a = body[i[m]], *const b = body[j[m]];
        place[m] = ry_four_load(b) + flip * ry_four_load(a);
        motion[m] = ry_four_load(b + RY_BODY_VX) + flip * ry_four_load(a + RY_BODY_VX);
    }
    ry_four_turn(place);
    ry_four_turn(motion);
    ry_four_store(near->dx + k, place[RY_BODY_X]);
    ry_four_store(near->dz + k, place[RY_BODY_Z]);
    ry_four_store(near->radii + k, place[RY_BODY_R]);
    ry_four_store(near->turn + k, place[RY_BODY_TURN]);
    ry_four_store(near->dvx + k, motion[RY_BODY_VX - RY_BODY_VX]);
    ry_four_store(near->dvz + k, motion[RY_BODY_VZ - RY_BODY_VX]);
    ry_four_store(near->im + k, motion[RY_BODY_IM - RY_BODY_VX]);
    ry_four_store(near->tm + k, motion[RY_BODY_TM - RY_BODY_VX]);
}

/* or, where vectors are so wide, a whole one. */
RY_INLINE void fetch_eight(const double (*body)[RY_BODY], ry_near *near, int32_t k)
{
    const ry_eight flip = {-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0};
    double *const to[RY_BODY] = {near->dx, near->dz, near->radii, near->turn, near->dvx, near->dvz, near->im, near->tm};
    ry_eight row[8];
    for (int32_t m = 0; m < 8; m++) {
        ry_eight owner, partner;
        ry_eight_load(&owner, body[near->i[k + m]]);
        ry_eight_load(&partner, body[near->j[k + m]]);
        row[m] = partner + flip * owner;
    }
    ry_eight_turn(row);
    for (int32_t m = 0; m < RY_BODY; m++) {
        ry_eight_store(to[m] + k, &row[m]);
    }
}

RY_INLINE void fetch_body(const ry_contact *c, ry_near *near, const int wide, const int ahead)
{
    const double (*const body)[RY_BODY] = c->body;
    const int32_t n = near->n_padded, at_once = wide ? 8 : 4;
    for (int32_t k = 0; k < n; k += at_once) {
        if (wide) {
            fetch_eight(body, near, k);
        } else {
            fetch_four(body, near, k);
        }
        for (int32_t m = 0; ahead && m < at_once; m += 2) { /* two pairs have about one owner */
            __builtin_prefetch(body[near->i[k + m / 4 * 4] + m % 4 / 2] + AHEAD * RY_BODY);
        }
        for (int a = 0; ahead && k % A_LINE == 0 && a < c->n_ahead; a++) {
            __builtin_prefetch(c->ahead[a] + near->i[k]);
        }
    }
    const double length = c->length, half = c->half;
    int opens = 0, young = 0;
#pragma omp simd reduction(| : opens, young)
    for (int32_t k = 0; k < n; k++) {
        const double dx = ry_nearest(near->dx[k], length, half), dz = near->dz[k];
        const double distance = sqrt(dx * dx + dz * dz), age = near->age[k];
        const int touches = distance < near->radii[k];
        near->dx[k] = dx;
        near->distance[k] = distance;
        opens |= !touches & (age != 0.0);
        young |= touches & (age < RY_IMPACT_STEPS);
    }
    near->opens = opens;
    near->young = young;
}

#define FETCH(name, target, wide, ahead)                        \
    target static void name(const ry_contact *c, ry_near *near) \
    {                                                           \
        fetch_body(c, near, wide, ahead);                       \
    }
FETCH(fetch_cached, RY_CLONES, 0, 0)
FETCH(fetch_ahead, RY_CLONES, 0, 1)
FETCH(fetch_cached_wide, RY_WIDE, 1, 0)
FETCH(fetch_ahead_wide, RY_WIDE, 1, 1)

static void fetch_grains(const ry_contact *c, ry_near *near)
{
    if (ry_is_wide()) {
        (c->large ? fetch_ahead_wide : fetch_cached_wide)(c, near);
    } else {
        (c->large ? fetch_ahead : fetch_cached)(c, near);
    }
}

/* Walls are at rest and have no radius. */
static void fetch_walls(const ry_contact *c, const ry_grains *g, ry_near *near)
{
    fetch_grains(c, near);
    for (int32_t k = 0; k < near->n_padded; k++) {
        const ry_gap gap = ry_contact_wall_gap(c, c->wall[near->j[k] - g->n], g->x[near->i[k]], g->z[near->i[k]]);
        near->dx[k] = gap.dx;
        near->dz[k] = gap.dz;
        near->distance[k] = gap.distance;
    }
    near->opens = near->young = 1;
}

void ry_contact_fetch_geometry(const ry_contact *c, const ry_grains *g, ry_near *near)
{
    if (near->j[0] >= g->n) { /* a block has one kind of partner */
        fetch_walls(c, g, near);
    } else {
        fetch_grains(c, near);
    }
}

RY_CLONES static void fetch_ages(const uint8_t *restrict age, int32_t n, double *restrict out)
{
    for (int32_t k = 0; k < n; k++) {
        out[k] = age[k];
    }
}

/* A run of listed pairs that fills the vectors, or after which the list is filled up, is worked on in place. */
void ry_contact_fetch_run(ry_pairs *pairs, int32_t first, int32_t n, ry_near *near)
{
    near->n = n;
    near->n_padded = ry_pairs_fill(n);
    near->i = pairs->i + first;
    near->j = pairs->j + first;
    near->slip = pairs->slip + first;
    near->rest = pairs->rest != NULL ? pairs->rest + first : near->spare[0]; /* which nobody reads */
    near->wet = pairs->wet != NULL ? pairs->wet + first : NULL;
#define RY_TOUCH_AT(name, unit, text) near->t_##name = pairs->t_##name + first;
    if (pairs->t_nx != NULL) {
        RY_TOUCH_FIELDS(RY_TOUCH_AT)
    }
#undef RY_TOUCH_AT
#define RY_BOND_AT(name) near->b_##name = pairs->b_##name + first;
    if (pairs->b_a != NULL) {
        RY_BOND_FIELDS(RY_BOND_AT)
    }
#undef RY_BOND_AT
    fetch_ages(pairs->age + first, near->n_padded, near->age);
}

static const double *fetch_bonds(const double *from, const ry_near *near, double *out)
{
    for (int32_t k = 0; k < near->n_padded; k++) {
        out[k] = from[near->list[0][k]];
    }
    return out;
}

/* Any others are copied: those of near->list[0]; the last is repeated to fill the vectors. */
void ry_contact_fetch_list(ry_pairs *pairs, int32_t n, ry_near *near)
{
    int32_t *const pair = near->list[0], *const i = near->list[1], *const j = near->list[2];
    near->n = n;
    near->n_padded = ry_pairs_fill(n);
    near->i = i;
    near->j = j;
    double (*spare)[RY_CONTACT_BLOCK] = near->spare;
    near->slip = *spare++;
    near->rest = *spare++;
    near->wet = pairs->wet != NULL ? *spare++ : NULL;
#define RY_TOUCH_AT(name, unit, text) near->t_##name = *spare++;
    RY_TOUCH_FIELDS(RY_TOUCH_AT)
#undef RY_TOUCH_AT
    for (int32_t k = 0; k < near->n_padded; k++) {
        const int32_t p = k < n ? pair[k] : pair[n - 1];
        pair[k] = p;
        i[k] = pairs->i[p];
        j[k] = pairs->j[p];
        near->slip[k] = pairs->slip[p];
        near->rest[k] = pairs->rest != NULL ? pairs->rest[p] : 0.0;
        near->age[k] = pairs->age[p];
    }
    for (int32_t k = 0; near->wet != NULL && k < near->n_padded; k++) {
        near->wet[k] = pairs->wet[pair[k]];
    }
#define RY_TOUCH_FETCH(name, unit, text) near->t_##name[k] = pairs->t_##name[pair[k]];
    for (int32_t k = 0; pairs->t_nx != NULL && k < near->n_padded; k++) {
        RY_TOUCH_FIELDS(RY_TOUCH_FETCH)
    }
#undef RY_TOUCH_FETCH
#define RY_BOND_COPY(name) near->b_##name = fetch_bonds(pairs->b_##name, near, *spare++);
    if (pairs->b_a != NULL) {
        RY_BOND_FIELDS(RY_BOND_COPY)
    }
#undef RY_BOND_COPY
}
