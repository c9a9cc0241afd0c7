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

/* Their distances, with the nearest images; whether contacts have opened, or are in their first steps. */
RY_INLINE void find_distances(const ry_contact *c, ry_near *near)
{
    const double length = c->length, half = c->half;
    int opens = 0, young = 0;
#pragma omp simd reduction(| : opens, young)
    for (int32_t k = 0; k < near->n_padded; k++) {
        const double dx = ry_nearest(near->dx[k], length, half), dz = near->dz[k];
        const double distance = sqrt(dx * dx + dz * dz), age = near->age[k];
        const int touches = distance < near->radii[k];
        near->dx[k] = dx;
        near->distance[k] = distance;
        near->per_all[k] = 1.0 / (distance * near->im[k] * near->tm[k] * near->radii[k]);
        opens |= !touches & (age != 0.0);
        young |= touches & (age <= RY_IMPACT_STEPS);
    }
    near->opens = opens;
    near->young = young;
}

/* Asks for what pairs further on will want. */
RY_INLINE void ask_ahead(const ry_contact *c, const ry_near *near, int32_t k, int32_t at_once)
{
    for (int32_t m = 0; m < at_once; m += 2) { /* two pairs have about one owner */
        __builtin_prefetch(c->body[near->i[k + m / 4 * 4] + m % 4 / 2] + AHEAD * RY_BODY);
    }
    for (int a = 0; k % A_LINE == 0 && a < c->n_ahead; a++) {
        __builtin_prefetch(c->ahead[a] + near->i[k]);
    }
}

RY_INLINE void fetch_body(const ry_contact *c, ry_near *near, const int ahead)
{
    for (int32_t k = 0; k < near->n_padded; k += 4) {
        fetch_four(c->body, near, k);
        if (ahead) {
            ask_ahead(c, near, k, 4);
        }
    }
    find_distances(c, near);
}

#define FETCH(name, ahead)                                         \
    RY_CLONES static void name(const ry_contact *c, ry_near *near) \
    {                                                              \
        fetch_body(c, near, ahead);                                \
    }
FETCH(fetch_cached, 0)
FETCH(fetch_ahead, 1)

#if RY_INTRINSICS
/* Where vectors are so wide one load fetches a whole grain, and what is found of eight pairs stays in registers: the
 * roots and divisions of some are taken while others are fetched. */
RY_WIDE static inline void fetch_eight(const double (*body)[RY_BODY], ry_near *near, int32_t k, __m512d row[8])
{
    const ry_eight flip = {-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0};
    ry_eight *const rows = (ry_eight *)row;
    for (int32_t m = 0; m < 8; m++) {
        ry_eight owner, partner;
        ry_eight_load(&owner, body[near->i[k + m]]);
        ry_eight_load(&partner, body[near->j[k + m]]);
        rows[m] = partner + flip * owner;
    }
    ry_eight_turn(rows);
}

/* ry_nearest */
RY_WIDE static inline __m512d nearest_of_eight(__m512d dx, __m512d length, __m512d half)
{
    const __mmask8 right = _mm512_cmp_pd_mask(dx, half, _CMP_GT_OQ);
    const __mmask8 left = _mm512_cmp_pd_mask(dx, _mm512_sub_pd(_mm512_setzero_pd(), half), _CMP_LT_OQ);
    return _mm512_mask_add_pd(_mm512_mask_sub_pd(dx, right, dx, length), left, dx, length);
}

RY_WIDE static inline void fetch_wide(const ry_contact *c, ry_near *near, const int ahead)
{
    double *const to[RY_BODY] = {near->dx, near->dz, near->radii, near->turn, near->dvx, near->dvz, near->im, near->tm};
    const __m512d length = _mm512_set1_pd(c->length), half = _mm512_set1_pd(c->half);
    __mmask8 opens = 0, young = 0;
    for (int32_t k = 0; k < near->n_padded; k += 8) {
        __m512d row[8];
        fetch_eight(c->body, near, k, row);
        const __m512d dx = nearest_of_eight(row[RY_BODY_X], length, half), dz = row[RY_BODY_Z];
        const __m512d distance = _mm512_sqrt_pd(_mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dz, dz)));
        const __m512d age = _mm512_loadu_pd(near->age + k);
        const __mmask8 touches = _mm512_cmp_pd_mask(distance, row[RY_BODY_R], _CMP_LT_OQ);
        opens |= (__mmask8)~touches & _mm512_cmp_pd_mask(age, _mm512_setzero_pd(), _CMP_NEQ_UQ);
        young |= touches & _mm512_cmp_pd_mask(age, _mm512_set1_pd(RY_IMPACT_STEPS), _CMP_LE_OQ);
        row[RY_BODY_X] = dx;
        for (int32_t m = 0; m < RY_BODY; m++) {
            _mm512_storeu_pd(to[m] + k, row[m]);
        }
        _mm512_storeu_pd(near->distance + k, distance);
        const __m512d masses = _mm512_mul_pd(_mm512_mul_pd(distance, row[RY_BODY_IM]), row[RY_BODY_TM]);
        const __m512d all = _mm512_mul_pd(masses, row[RY_BODY_R]);
        _mm512_storeu_pd(near->per_all + k, _mm512_div_pd(_mm512_set1_pd(1.0), all));
        if (ahead) {
            ask_ahead(c, near, k, 8);
        }
    }
    near->opens = opens;
    near->young = young;
}

RY_WIDE static void fetch_cached_wide(const ry_contact *c, ry_near *near)
{
    fetch_wide(c, near, 0);
}

RY_WIDE static void fetch_ahead_wide(const ry_contact *c, ry_near *near)
{
    fetch_wide(c, near, 1);
}
#else
#define fetch_cached_wide fetch_cached
#define fetch_ahead_wide fetch_ahead
#endif

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
        near->per_all[k] = 1.0 / (gap.distance * near->im[k] * near->tm[k] * near->radii[k]);
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
