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

static ry_status make(double **array, int32_t n, int wanted, ry_error *error)
{
    *array = wanted ? ry_array((size_t)n + RY_MAX_WALLS, sizeof(double)) : NULL;
    return *array != NULL || !wanted ? RY_OK : ry_no_memory(error, (size_t)n * sizeof(double));
}

ry_status ry_motion_create(ry_motion *m, int32_t n, int moves, ry_error *error)
{
    double **const always[] = {&m->im, &m->tm, &m->spin_gain, &m->gx, &m->gz,
                               &m->weight, &m->cx, &m->cz, &m->ct};
    m->moves = moves;
    m->n_awake = n;
    m->highest_asleep = -INFINITY;
    for (size_t k = 0; k < sizeof always / sizeof *always; k++) {
        RY_TRY(make(always[k], n, 1, error));
    }
    m->body = ry_array((size_t)n + RY_MAX_WALLS, sizeof *m->body);
    if (m->body == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *m->body);
    }
    RY_TRY(make(&m->sx, n, moves, error));
    return make(&m->sz, n, moves, error);
}

void ry_motion_free(ry_motion *m)
{
    double *const arrays[] = {m->im, m->tm, m->spin_gain, m->gx, m->gz, m->weight,
                              m->cx, m->cz, m->ct, m->sx, m->sz};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    free(m->body);
    *m = (ry_motion){0};
}

/* ---- bodies --------------------------------------------------------------------------------- */

static void write_body(const ry_motion *m, const ry_grains *g, int32_t k)
{
    const double body[RY_BODY] = {g->x[k], g->z[k], g->radius[k], g->spin[k] * g->radius[k],
                                  g->vx[k], g->vz[k], m->im[k], m->tm[k]};
    memcpy(m->body[k], body, sizeof body);
}

RY_CLONES static void write_bodies(const ry_motion *m, const ry_grains *g, int32_t begin, int32_t end)
{
    int32_t k = begin;
    for (; k + 4 <= end; k += 4) {
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
    for (; k < end; k++) {
        write_body(m, g, k);
    }
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

/* Grains are gathered in blocks of this many, which stay in the first cache. */
enum { GATHERED = 256 };

/* A grain whose contacts begin to endure, or cease to, gets half a kick of gravity less, or more: velocities lie
 * half a step before positions there, and beside them in flight. Without it each landing and take-off would
 * gain m g dt/2 times the change of the velocity. `marks`: the sums of its contacts' marks, which tell how many hold it
 * now, and did before. For all grains alike: who turns is nothing that a branch could guess. */
RY_CLONES static void turn_half_a_kick(const ry_motion *m, const double *restrict marks, int32_t begin, int32_t n)
{
    const double *const im = m->im + begin, *const weight = m->weight + begin;
    double *restrict const cz = m->cz + begin;
    const double holds = RY_MARK_HOLDS, half = RY_MARK_HOLDS / 2;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double now = (double)(int32_t)((marks[k] + half) / holds), before = now - (marks[k] - holds * now);
        const double turns = (before != 0.0 ? 1.0 : 0.0) - (now != 0.0 ? 1.0 : 0.0);
        const double inverse = im[k] > 0.0 ? im[k] : 1.0; /* fixed grains have no weight */
        cz[k] += turns * 0.5 * weight[k] / inverse;
    }
}

/* Ascending id of the partner: those with lower ids (where the grain is the partner of the pair), its
 * own row, then the walls. */
RY_INLINE ry_four sum_slots(const ry_pairs *pairs, const int32_t *below, const int32_t *below_start, const int32_t *row,
                            int walls, int32_t k)
{
    const double (*const slot)[RY_SLOT] = (const double (*)[RY_SLOT])pairs->slot;
    const ry_four opposite = {-1.0, -1.0, 1.0, 1.0};
    ry_four sum = {0.0, 0.0, 0.0, 0.0};
    for (int32_t b = below_start[k]; b < below_start[k + 1]; b++) {
        sum += opposite * ry_four_load(slot[below[b]]);
    }
    for (int32_t p = row[k]; p < row[k + 1]; p++) {
        sum += ry_four_load(slot[p]);
    }
    for (int w = 0; w < walls; w++) {
        const int32_t p = pairs->wall_slot[w][k];
        if (p >= 0) {
            sum += ry_four_load(slot[p]);
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
    const ry_four sum = sum_slots(pairs, pairs->below, pairs->below_start, pairs->row, count_walls(pairs), k);
    ry_four_store(slot, sum);
}

RY_CLONES static void gather_range(const ry_motion *m, const ry_pairs *pairs, int32_t begin, int32_t end,
                                   double *restrict marks)
{
    const int32_t *const below = pairs->below, *const below_start = pairs->below_start;
    const int32_t *const row = pairs->row;
    const int walls = count_walls(pairs);
    for (int32_t k = begin; k < end; k++) {
        const ry_four sum = sum_slots(pairs, below, below_start, row, walls, k);
        m->cx[k] = sum[RY_SLOT_X];
        m->cz[k] = sum[RY_SLOT_Z];
        m->ct[k] = sum[RY_SLOT_TURN];
        marks[k - begin] = sum[RY_SLOT_MARK];
    }
}

static void gather_shifts(const ry_motion *m, const ry_pairs *pairs)
{
    for (int32_t k = 0; k < pairs->n_grains; k++) {
        double x = 0.0, z = 0.0;
        for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
            x -= pairs->sx[pairs->below[b]];
            z -= pairs->sz[pairs->below[b]];
        }
        for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
            x += pairs->sx[p];
            z += pairs->sz[p];
        }
        m->sx[k] = x;
        m->sz[k] = z;
    }
    for (int32_t p = pairs->n_inner; p < pairs->n; p++) {
        m->sx[pairs->i[p]] += pairs->sx[p];
        m->sz[pairs->i[p]] += pairs->sz[p];
    }
}

typedef struct ry_extent {
    int gone;       /* a grain has gone further than it may */
    double highest; /* [m] */
} ry_extent;

typedef struct ry_motion_task {
    const ry_motion *motion;
    ry_grains *grains;
    ry_pairs *pairs;
    double *x0;
    const double *z0, *limit2;
    ry_extent extent[RY_MOST_THREADS];
    ry_exact work[RY_MOST_THREADS];
} ry_motion_task;

static void gather_grains(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_motion_task *const t = context;
    double marks[GATHERED];
    (void)thread;
    for (int32_t k = begin; k < end; k += GATHERED) {
        const int32_t n = end - k < GATHERED ? end - k : GATHERED;
        gather_range(t->motion, t->pairs, k, k + n, marks);
        if (t->motion->marks) {
            turn_half_a_kick(t->motion, marks, k, n);
        }
    }
}

void ry_motion_gather(const ry_motion *m, const ry_grains *g, ry_pairs *pairs)
{
    ry_motion_task task;
    task.motion = m;
    task.pairs = pairs;
    (void)g;
    ry_parallel(m->threads, m->n_awake, gather_grains, &task);
    if (m->moves) {
        gather_shifts(m, pairs);
    }
}

/* ---- integrate ------------------------------------------------------------------------------ */

/* The drift of one grain over a step. */
RY_INLINE double drift(double v, double after, int touched, double dt)
{
    return (touched ? after : 0.5 * (v + after)) * dt;
}

RY_INLINE ry_extent integrate_body(const ry_motion *m, ry_grains *g, double *restrict x0,
                                   const double *restrict z0, const double *restrict limit2, int32_t begin,
                                   int32_t end, const int books, double *restrict work)
{
    double *restrict const x = g->x, *restrict const z = g->z, *restrict const vx = g->vx;
    double *restrict const vz = g->vz, *restrict const spin = g->spin;
    int32_t *restrict const image = g->image;
    const double *restrict const im = m->im, *restrict const cx = m->cx, *restrict const cz = m->cz;
    const double *restrict const ct = m->ct, *restrict const gain = m->spin_gain;
    const double *restrict const gx = m->gx, *restrict const gz = m->gz;
    const double *restrict const weight = m->weight;
    const double dt = m->dt, length = m->periodic ? m->length : 0.0;
    const double right = m->periodic ? m->length : 1e300;
    const double left = m->periodic ? 0.0 : -1e300;
    double furthest = -1.0, highest = -INFINITY;
#pragma omp simd reduction(max : furthest, highest)
    for (int32_t k = begin; k < end; k++) {
        const int touched = (cx[k] != 0.0) | (cz[k] != 0.0);
        const double ux = vx[k] + cx[k] * im[k] + gx[k];
        const double uz = vz[k] + cz[k] * im[k] + gz[k];
        if (books) { /* impulse x (velocity before and after)/2 */
            const double half_mass = 0.5 / (im[k] > 0.0 ? im[k] : 1.0); /* fixed: nothing changes its velocity */
            work[k - begin] = half_mass * (gx[k] * (vx[k] + ux) + (gz[k] - weight[k]) * (vz[k] + uz));
        }
        double xn = x[k] + drift(vx[k], ux, touched, dt);
        const double zn = z[k] + drift(vz[k], uz, touched, dt);
        vx[k] = ux;
        vz[k] = uz;
        spin[k] += ct[k] * gain[k];
        const double run_x = xn - x0[k], run_z = zn - z0[k];
        const double beyond = run_x * run_x + run_z * run_z - limit2[k];
        furthest = beyond > furthest ? beyond : furthest;
        highest = zn > highest ? zn : highest;
        const double in = xn < left ? length : 0.0; /* came in at the right end */
        xn += in;
        const double out = xn >= right ? length : 0.0;
        xn -= out;
        x[k] = xn;
        z[k] = zn;
        x0[k] += in - out;
        image[k] += (out != 0.0) - (in != 0.0);
    }
    return (ry_extent){furthest > 0.0, highest};
}

RY_CLONES static ry_extent integrate_range(const ry_motion *m, ry_grains *g, double *x0, const double *z0,
                                           const double *limit2, int32_t begin, int32_t end)
{
    return integrate_body(m, g, x0, z0, limit2, begin, end, 0, NULL);
}

/* Also the work of the fluid on each grain [J]. */
RY_CLONES static ry_extent integrate_and_work(const ry_motion *m, ry_grains *g, double *x0, const double *z0,
                                              const double *limit2, int32_t begin, int32_t end, double *work)
{
    return integrate_body(m, g, x0, z0, limit2, begin, end, 1, work);
}

static void shift_range(const ry_motion *m, ry_grains *g, int32_t begin, int32_t end)
{
    for (int32_t k = begin; k < end; k++) {
        g->x[k] += m->sx[k] * m->im[k];
        g->z[k] += m->sz[k] * m->im[k];
    }
}

/* Grains are moved and written as records in blocks that stay in the first cache. */
enum { BLOCK = RY_EXACT_TERMS };

static void integrate_grains(void *context, int32_t begin, int32_t end, int thread)
{
    ry_motion_task *const t = context;
    const ry_motion *const m = t->motion;
    if (m->moves) {
        shift_range(m, t->grains, begin, end);
    }
    ry_extent all = {0, -INFINITY};
    t->work[thread] = (ry_exact){0, 0};
    for (int32_t k = begin; k < end; k += BLOCK) {
        const int32_t next = end - k < BLOCK ? end : k + BLOCK;
        double work[BLOCK];
        const ry_extent here = m->books ? integrate_and_work(m, t->grains, t->x0, t->z0, t->limit2, k, next, work)
                                        : integrate_range(m, t->grains, t->x0, t->z0, t->limit2, k, next);
        if (m->books) {
            ry_exact_add(&t->work[thread], m->scale, work, next - k);
        }
        write_bodies(m, t->grains, k, next);
        all.gone |= here.gone;
        all.highest = here.highest > all.highest ? here.highest : all.highest;
    }
    t->extent[thread] = all;
}

int ry_motion_integrate(ry_motion *m, ry_grains *g, double *x0, const double *z0, const double *limit2,
                        ry_ledger *ledger)
{
    ry_motion_task task;
    task.motion = m;
    task.grains = g;
    task.x0 = x0;
    task.z0 = z0;
    task.limit2 = limit2;
    ry_parallel(m->threads, m->n_awake, integrate_grains, &task);
    int gone = 0;
    m->highest = m->highest_asleep;
    for (int t = 0; t < m->threads; t++) {
        gone |= task.extent[t].gone;
        if (m->books) {
            ry_exact_join(&ledger->fluid_work, task.work[t]);
        }
        m->highest = task.extent[t].highest > m->highest ? task.extent[t].highest : m->highest;
    }
    return gone;
}
