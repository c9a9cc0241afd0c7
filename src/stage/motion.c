/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "law/law.h"
#include "stage/four.h"

static ry_status make(double **array, size_t n, int wanted, ry_error *error)
{
    *array = wanted ? ry_array(n, sizeof(double)) : NULL;
    return *array != NULL || !wanted ? RY_OK : ry_no_memory(error, n * sizeof(double));
}

ry_status ry_motion_create(ry_motion *m, int32_t n, ry_error *error)
{
    double **const always[] = {&m->im, &m->tm, &m->spin_gain, &m->weight};
    double **const sums[] = {&m->cx, &m->cz, &m->ct};
    const size_t room = (size_t)n + RY_MAX_WALLS;
    m->n_awake = n;
    m->highest_asleep = -INFINITY;
    for (size_t k = 0; k < sizeof always / sizeof *always; k++) {
        RY_TRY(make(always[k], room, 1, error));
    }
    for (size_t k = 0; k < sizeof sums / sizeof *sums; k++) {
        RY_TRY(make(sums[k], m->kept ? room : (size_t)m->threads * RY_BLOCK, 1, error));
    }
    m->body = ry_array(room, sizeof *m->body);
    m->extent = ry_array((size_t)m->threads, sizeof *m->extent);
    if (m->body == NULL || m->extent == NULL) {
        return ry_no_memory(error, room * sizeof *m->body);
    }
    const size_t pushes = m->pushes_kept ? room : (size_t)m->threads * RY_BLOCK;
    RY_TRY(make(&m->gx, pushes, m->pushed, error));
    RY_TRY(make(&m->gz, pushes, m->pushed, error));
    m->gz = m->pushed ? m->gz : m->weight;
    RY_TRY(make(&m->sx, room, m->moves, error));
    return make(&m->sz, room, m->moves, error);
}

void ry_motion_free(ry_motion *m)
{
    double *const arrays[] = {m->im, m->tm, m->spin_gain, m->gx, m->pushed ? m->gz : NULL, m->weight,
                              m->cx, m->cz, m->ct, m->sx, m->sz};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    free(m->body);
    free(m->extent);
    *m = (ry_motion){0};
}

/* ---- bodies --------------------------------------------------------------------------------- */

static void write_body(const ry_motion *m, const ry_grains *g, int32_t k)
{
    const double body[RY_BODY] = {g->x[k], g->z[k], g->radius[k], g->spin[k] * g->radius[k],
                                  g->vx[k], g->vz[k], m->im[k], m->tm[k]};
    memcpy(m->body[k], body, sizeof body);
}

RY_INLINE void write_four(const ry_motion *m, const ry_grains *g, int32_t k)
{
    const ry_four r = ry_four_load(g->radius + k);
    ry_four place[4] = {ry_four_load(g->x + k), ry_four_load(g->z + k), r, ry_four_load(g->spin + k) * r};
    ry_four motion[4] = {ry_four_load(g->vx + k), ry_four_load(g->vz + k), ry_four_load(m->im + k),
                         ry_four_load(m->tm + k)};
    ry_four_turn(place);
    ry_four_turn(motion);
    for (int32_t q = 0; q < 4; q++) {
        ry_four_store(m->body[k + q], place[q]);
        ry_four_store(m->body[k + q] + RY_BODY_VX, motion[q]);
    }
}

RY_INLINE void write_eight(const ry_motion *m, const ry_grains *g, int32_t k)
{
    const double *const from[RY_BODY] = {g->x, g->z, g->radius, g->spin, g->vx, g->vz, m->im, m->tm};
    ry_eight column[8];
    for (int32_t q = 0; q < RY_BODY; q++) {
        ry_eight_load(&column[q], from[q] + k);
    }
    column[RY_BODY_TURN] *= column[RY_BODY_R];
    ry_eight_turn(column);
    for (int32_t q = 0; q < 8; q++) {
        ry_eight_store(m->body[k + q], &column[q]);
    }
}

RY_INLINE void write_range(const ry_motion *m, const ry_grains *g, int32_t begin, int32_t end, const int wide)
{
    const int32_t at_once = wide ? 8 : 4;
    int32_t k = begin;
    for (; k + at_once <= end; k += at_once) {
        if (wide) {
            write_eight(m, g, k);
        } else {
            write_four(m, g, k);
        }
    }
    for (; k < end; k++) {
        write_body(m, g, k);
    }
}

RY_CLONES static void write_by_four(const ry_motion *m, const ry_grains *g, int32_t begin, int32_t end)
{
    write_range(m, g, begin, end, 0);
}

RY_WIDE static void write_by_eight(const ry_motion *m, const ry_grains *g, int32_t begin, int32_t end)
{
    write_range(m, g, begin, end, 1);
}

static void write_bodies(const ry_motion *m, const ry_grains *g, int32_t begin, int32_t end)
{
    (ry_is_wide() ? write_by_eight : write_by_four)(m, g, begin, end);
}

void ry_motion_settle(ry_motion *m, const ry_grains *g)
{
    write_bodies(m, g, 0, g->n + RY_MAX_WALLS);
    m->highest = -INFINITY;
    for (int32_t k = 0; k < g->n; k++) {
        m->highest = g->z[k] > m->highest ? g->z[k] : m->highest;
    }
}

/* ---- gather --------------------------------------------------------------------------------- */

/* A grain whose contacts begin to endure, or cease to, gets half a kick of gravity less, or more: velocities lie
 * half a step before positions there, and beside them in flight. Without it each landing and take-off would
 * gain m g dt/2 times the change of the velocity. `marks`: the sums of its contacts' marks, which tell how many hold it
 * now, and did before. For all grains alike: who turns is nothing that a branch could guess. */
RY_CLONES static void turn_half_a_kick(const ry_motion *m, const double *restrict marks, int32_t begin, int32_t n,
                                       double *restrict cz)
{
    const double *const im = m->im + begin, *const weight = m->weight + begin;
    const double holds = RY_MARK_HOLDS, half = RY_MARK_HOLDS / 2;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double now = (double)(int32_t)((marks[k] + half) / holds), before = now - (marks[k] - holds * now);
        const double turns = (before != 0.0 ? 1.0 : 0.0) - (now != 0.0 ? 1.0 : 0.0);
        const double inverse = im[k] > 0.0 ? im[k] : 1.0; /* fixed grains have no weight */
        cz[k] += turns * 0.5 * weight[k] / inverse;
    }
}

/* How to find slots: each at its pair's place; all of a block's pairs by the one rule of its way; or each looked up,
 * most of them on the shelf of their own chunk. */
enum { PLAIN, NEAR, FAR };

typedef struct ry_slots {
    const char *near; /* of slot 0 of the rule, which may lie before the array */
    size_t mask;
    const ry_pairs *pairs;
    ry_shelf own;
    int32_t first, end; /* its pairs */
} ry_slots;

static ry_slots slots_for(const ry_pairs *pairs, ry_way way, int chunk)
{
    const intptr_t base = (intptr_t)way.base * (intptr_t)sizeof *pairs->slot;
    return (ry_slots){.near = (const char *)((intptr_t)pairs->slot + base), .mask = (uint32_t)way.mask, .pairs = pairs,
                     .own = pairs->shelf[chunk], .first = pairs->chunk[chunk], .end = pairs->chunk[chunk + 1]};
}

RY_INLINE const double *near_slot(const ry_slots *from, int32_t p)
{
    return (const double *)(from->near + ((uint32_t)p & from->mask) * RY_SLOT * sizeof(double));
}

RY_INLINE ry_four load_slot(const ry_slots *from, const int how, int32_t p)
{
    const ry_pairs *const pairs = from->pairs;
    if (how == PLAIN) {
        return ry_four_load(pairs->slot[p]);
    }
    if (how == NEAR) {
        return ry_four_load(near_slot(from, p));
    }
    const int own = p >= from->first && p < from->end;
    return ry_four_load(own ? pairs->slot[ry_shelf_slot(&from->own, p)] : ry_pairs_slot(pairs, p));
}

/* In small beds, which are the same for many steps, the processor learns how many pairs each grain has; in large ones
 * it guesses wrong, and it is faster to look at so many on each side always, zeros for those that are not there. */
enum { GUESSED = 3 };
static const double nothing[RY_SLOT];

RY_INLINE ry_four load_if(const ry_slots *from, int is_there, int32_t p)
{
    const intptr_t zeros = (intptr_t)nothing;
    const intptr_t slot = (intptr_t)from->near + (intptr_t)(((uint32_t)p & from->mask) * sizeof nothing);
    return ry_four_load((const double *)(zeros + ((slot - zeros) & -(intptr_t)is_there))); /* no branch */
}

/* Ascending id of the partner: those with lower ids (where the grain is the partner of the pair), its
 * own row, then the walls. */
RY_INLINE ry_four sum_slots(const ry_pairs *pairs, const ry_slots *from, const int how, int walls, int32_t k)
{
    const int32_t *const below = pairs->below, *const below_start = pairs->below_start, *const row = pairs->row;
    const ry_four opposite = {-1.0, -1.0, 1.0, 1.0};
    ry_four sum = {0.0, 0.0, 0.0, 0.0};
    int32_t b = below_start[k], p = row[k];
    const int32_t b_end = below_start[k + 1], p_end = row[k + 1];
    for (int m = 0; how == NEAR && m < GUESSED; m++, b++) { /* there is room behind the last */
        sum += opposite * load_if(from, b < b_end, below[b]);
    }
    for (; b < b_end; b++) {
        sum += opposite * load_slot(from, how, below[b]);
    }
    for (int m = 0; how == NEAR && m < GUESSED; m++, p++) {
        sum += load_if(from, p < p_end, p);
    }
    for (; p < p_end; p++) {
        sum += load_slot(from, how, p);
    }
    for (int w = 0; w < walls; w++) {
        const int32_t at_wall = pairs->wall_slot[w][k];
        if (at_wall >= 0) {
            sum += load_slot(from, how, at_wall);
        }
    }
    return sum;
}

static int count_walls(const ry_pairs *pairs)
{
    int walls = 0;
    while (walls < RY_MAX_WALLS && pairs->wall_slot[walls] != NULL) {
        walls++;
    }
    return walls;
}

void ry_motion_listed(const ry_pairs *pairs, int32_t k, double *slot)
{
    const ry_slots slots = slots_for(pairs, (ry_way){0}, 0);
    ry_four_store(slot, sum_slots(pairs, &slots, FAR, count_walls(pairs), k));
}

/* Where the sums of a block go. */
typedef struct ry_sums {
    double *member[RY_SLOT];
} ry_sums;

RY_INLINE ry_sums sums_to(const ry_motion *m, int32_t begin, int chunk, double *marks)
{
    const int32_t at = ry_motion_at(m, begin, chunk);
    ry_sums to;
    to.member[RY_SLOT_X] = m->cx + at;
    to.member[RY_SLOT_Z] = m->cz + at;
    to.member[RY_SLOT_TURN] = m->ct + at;
    to.member[RY_SLOT_MARK] = marks;
    return to;
}

RY_INLINE void put_sum(const ry_sums *to, int32_t k, const ry_four sum)
{
    for (int q = 0; q < RY_SLOT; q++) {
        to->member[q][k] = sum[q];
    }
}

RY_INLINE void gather_body(const ry_motion *m, const ry_pairs *pairs, ry_way way, int chunk, const int how,
                           int32_t begin, int32_t n, double *restrict marks)
{
    const ry_sums to = sums_to(m, begin, chunk, marks);
    const ry_slots slots = slots_for(pairs, way, chunk);
    const int walls = count_walls(pairs);
    for (int32_t k = 0; k < n; k++) {
        put_sum(&to, k, sum_slots(pairs, &slots, how, walls, begin + k));
    }
}

#define GATHER(name, how)                                                                                 \
    RY_CLONES static void name(const ry_motion *m, const ry_pairs *pairs, ry_way way, int chunk,          \
                               int32_t begin, int32_t n, double *marks)                                   \
    {                                                                                                     \
        gather_body(m, pairs, way, chunk, how, begin, n, marks);                                          \
    }
GATHER(gather_plain, PLAIN)
GATHER(gather_near, NEAR)
GATHER(gather_far, FAR)

#if RY_INTRINSICS
/* With the masks of AVX-512, which load zeros: four bits for each slot that is looked at always, and so cheap that it
 * pays to look at one more. Where slots lie in a ring there are no walls (stage/blocks.c: all is late). */
RY_WIDE static inline ry_four sum_near(const ry_pairs *pairs, const ry_slots *from, int32_t k)
{
    enum { EACH = 4, LOOKED_AT = GUESSED + 1, ALL = (1 << EACH * LOOKED_AT) - 1 };
    const int32_t *const below = pairs->below + pairs->below_start[k], p = pairs->row[k];
    const int32_t n_below = pairs->below_start[k + 1] - pairs->below_start[k], n_own = pairs->row[k + 1] - p;
    const unsigned low = _bzhi_u32(ALL, EACH * (unsigned)(n_below < LOOKED_AT ? n_below : LOOKED_AT));
    const unsigned own = _bzhi_u32(ALL, EACH * (unsigned)(n_own < LOOKED_AT ? n_own : LOOKED_AT));
    const __m256d opposite = _mm256_set_pd(0.0, 0.0, -0.0, -0.0);
    __m256d sum = _mm256_setzero_pd();
    for (int q = 0; q < LOOKED_AT; q++) { /* there is room behind the last */
        const __m256d slot = _mm256_maskz_loadu_pd((__mmask8)(low >> EACH * q), near_slot(from, below[q]));
        sum = _mm256_add_pd(sum, _mm256_xor_pd(slot, opposite));
    }
    for (int32_t q = LOOKED_AT; q < n_below; q++) {
        sum = _mm256_add_pd(sum, _mm256_xor_pd(_mm256_loadu_pd(near_slot(from, below[q])), opposite));
    }
    for (int q = 0; q < LOOKED_AT; q++) {
        sum = _mm256_add_pd(sum, _mm256_maskz_loadu_pd((__mmask8)(own >> EACH * q), near_slot(from, p + q)));
    }
    for (int32_t q = LOOKED_AT; q < n_own; q++) {
        sum = _mm256_add_pd(sum, _mm256_loadu_pd(near_slot(from, p + q)));
    }
    return (ry_four)sum;
}

RY_WIDE static void gather_near_wide(const ry_motion *m, const ry_pairs *pairs, ry_way way, int chunk, int32_t begin,
                                     int32_t n, double *marks)
{
    const ry_sums to = sums_to(m, begin, chunk, marks);
    const ry_slots slots = slots_for(pairs, way, chunk);
    for (int32_t k = 0; k < n; k++) {
        put_sum(&to, k, sum_near(pairs, &slots, begin + k));
    }
}
#else
#define gather_near_wide gather_near
#endif

static void gather_shifts(const ry_motion *m, const ry_pairs *pairs, int32_t begin, int32_t end)
{
    const int walls = count_walls(pairs);
    for (int32_t k = begin; k < end; k++) {
        double x = 0.0, z = 0.0;
        for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
            x -= pairs->sx[pairs->below[b]];
            z -= pairs->sz[pairs->below[b]];
        }
        for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
            x += pairs->sx[p];
            z += pairs->sz[p];
        }
        for (int w = 0; w < walls; w++) {
            const int32_t p = pairs->wall_slot[w][k];
            x += p >= 0 ? pairs->sx[p] : 0.0;
            z += p >= 0 ? pairs->sz[p] : 0.0;
        }
        m->sx[k] = x;
        m->sz[k] = z;
    }
}

void ry_motion_gather(const ry_motion *m, const ry_pairs *pairs, int32_t begin, int32_t end, ry_way way, int chunk)
{
    _Alignas(RY_ALIGNMENT) double marks[RY_BLOCK];
    const int plain = way.mask == -1 && way.base == 0;
    const int near = way.mask != 0;
    (plain ? gather_plain : near ? (ry_is_wide() ? gather_near_wide : gather_near) : gather_far)(
        m, pairs, way, chunk, begin, end - begin, marks);
    if (m->marks) {
        turn_half_a_kick(m, marks, begin, end - begin, m->cz + ry_motion_at(m, begin, chunk));
    }
    if (m->moves) {
        gather_shifts(m, pairs, begin, end);
    }
}

/* ---- integrate ------------------------------------------------------------------------------ */

/* The drift of one grain over a step. */
RY_INLINE double drift(double v, double after, int touched, double dt)
{
    return (touched ? after : 0.5 * (v + after)) * dt;
}

/* The grains of a block, from `begin` on; at: place of cx, cz, ct; push_at: of gx, gz. x that wrap are rare: `over` is
 * what is taken off, and whether any is not 0 is returned. */
RY_INLINE int integrate_body(const ry_motion *m, ry_grains *g, const double *restrict x0, const double *restrict z0,
                             const float *restrict limit2, int32_t begin, int32_t n, int32_t at, int32_t push_at,
                             const int pushed, const int books, double *restrict over, double *restrict work,
                             ry_extent *extent)
{
    double *restrict const x = g->x + begin, *restrict const z = g->z + begin, *restrict const vx = g->vx + begin;
    double *restrict const vz = g->vz + begin, *restrict const spin = g->spin + begin;
    const double *restrict const im = m->im + begin, *restrict const gain = m->spin_gain + begin;
    const double *restrict const cx = m->cx + at, *restrict const cz = m->cz + at, *restrict const ct = m->ct + at;
    const double *restrict const gx = pushed ? m->gx + push_at : im, *restrict const gz = m->gz + push_at;
    const double *restrict const weight = m->weight + begin;
    const double dt = m->dt, length = m->periodic ? m->length : 0.0;
    const double right = m->periodic ? m->length : 1e300;
    const double left = m->periodic ? 0.0 : -1e300;
    double furthest = extent->furthest, highest = extent->highest;
    double wrapped = 0.0;
    x0 += begin;
    z0 += begin;
    limit2 += begin;
#pragma omp simd reduction(max : furthest, highest, wrapped)
    for (int32_t k = 0; k < n; k++) {
        const int touched = (cx[k] != 0.0) | (cz[k] != 0.0);
        const double ux = vx[k] + cx[k] * im[k] + (pushed ? gx[k] : 0.0);
        const double uz = vz[k] + cz[k] * im[k] + gz[k];
        if (books) { /* impulse x (velocity before and after)/2 */
            const double half_mass = 0.5 / (im[k] > 0.0 ? im[k] : 1.0); /* fixed: nothing changes its velocity */
            work[k] = half_mass * (gx[k] * (vx[k] + ux) + (gz[k] - weight[k]) * (vz[k] + uz));
        }
        double xn = x[k] + drift(vx[k], ux, touched, dt);
        const double zn = z[k] + drift(vz[k], uz, touched, dt);
        vx[k] = ux;
        vz[k] = uz;
        spin[k] += ct[k] * gain[k];
        const double run_x = xn - x0[k], run_z = zn - z0[k];
        const double beyond = run_x * run_x + run_z * run_z - (double)limit2[k];
        furthest = beyond > furthest ? beyond : furthest;
        highest = zn > highest ? zn : highest;
        const double in = xn < left ? length : 0.0; /* came in at the right end */
        xn += in;
        const double out = xn >= right ? length : 0.0;
        xn -= out;
        over[k] = out - in;
        wrapped = in + out > wrapped ? in + out : wrapped;
        x[k] = xn;
        z[k] = zn;
    }
    extent->furthest = furthest;
    extent->highest = highest;
    return wrapped != 0.0;
}

#define INTEGRATE(name, pushed, books)                                                                    \
    RY_CLONES static int name(const ry_motion *m, ry_grains *g, const double *x0, const double *z0,       \
                              const float *limit2, int32_t begin, int32_t n, int32_t at, int32_t push_at, \
                              double *over, double *work, ry_extent *extent)                              \
    {                                                                                                     \
        return integrate_body(m, g, x0, z0, limit2, begin, n, at, push_at, pushed, books, over, work, extent); \
    }
INTEGRATE(integrate_range, 1, 0)
INTEGRATE(integrate_falling, 0, 0)
INTEGRATE(integrate_and_work, 1, 1) /* also the work of the fluid on each grain [J] */

static void wrap(ry_grains *g, double *x0, const double *over, int32_t begin, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        x0[begin + k] -= over[k];
        g->image[begin + k] += (over[k] > 0.0) - (over[k] < 0.0);
    }
}

static void shift_range(const ry_motion *m, ry_grains *g, int32_t begin, int32_t end)
{
    for (int32_t k = begin; k < end; k++) {
        g->x[k] += m->sx[k] * m->im[k];
        g->z[k] += m->sz[k] * m->im[k];
    }
}

void ry_motion_integrate(const ry_motion *m, ry_grains *g, double *x0, const double *z0, const float *limit2,
                         int32_t begin, int32_t end, int chunk)
{
    const int32_t at = ry_motion_at(m, begin, chunk), push_at = ry_motion_push_at(m, begin, chunk), n = end - begin;
    _Alignas(RY_ALIGNMENT) double over[RY_BLOCK], work[RY_BLOCK];
    ry_extent *const extent = &m->extent[chunk];
    if (m->moves) {
        shift_range(m, g, begin, end);
    }
    int wraps;
    if (m->books) {
        wraps = integrate_and_work(m, g, x0, z0, limit2, begin, n, at, push_at, over, work, extent);
        ry_exact_add(&extent->work, m->scale, work, n);
    } else if (m->pushed) {
        wraps = integrate_range(m, g, x0, z0, limit2, begin, n, at, push_at, over, work, extent);
    } else {
        wraps = integrate_falling(m, g, x0, z0, limit2, begin, n, at, push_at, over, work, extent);
    }
    if (wraps) {
        wrap(g, x0, over, begin, n);
    }
    write_bodies(m, g, begin, end);
}

void ry_motion_begin(ry_motion *m)
{
    for (int t = 0; t < m->threads; t++) {
        m->extent[t] = (ry_extent){.furthest = -1.0, .highest = -INFINITY};
    }
}

int ry_motion_end(ry_motion *m, ry_ledger *ledger)
{
    int gone = 0;
    m->highest = m->highest_asleep;
    for (int t = 0; t < m->threads; t++) {
        gone |= m->extent[t].furthest > 0.0;
        m->highest = m->extent[t].highest > m->highest ? m->extent[t].highest : m->highest;
        if (m->books) {
            ry_exact_join(&ledger->fluid_work, m->extent[t].work);
        }
    }
    return gone;
}
