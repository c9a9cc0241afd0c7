/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "stage/slices.h"

/* Rows of a block's sums, of the grains that can move: volumes of the cells and their transport; momentum
 * through the planes at the feet of the cells; and what the forces on the grains, of their contacts and of the
 * fluid, change the stress by from plane to plane. */
enum { ROW_MOVING, ROW_TRANSPORT, ROW_SLICE, ROW_STEP, ROW_FLUID_STEP, ROW_COUNT };

/* A row has room for a last run of slices, which begins at plane nz at the latest, and behind that for what
 * acts above that plane. */
static size_t row_length(const ry_measure *m)
{
    return (size_t)m->nz + RY_SLICES + 1;
}

static size_t above_top(const ry_measure *m)
{
    return row_length(m) - 1;
}

static int32_t count_blocks(int32_t n)
{
    return (n + RY_SUM_BLOCK - 1) / RY_SUM_BLOCK;
}

static double *row(const ry_measure *m, double *sums, int which)
{
    return sums + (size_t)which * row_length(m);
}

enum { N_ROWS = 6 };
static void rows_of(const ry_measure *m, double **rows)
{
    double *const all[N_ROWS] = {m->phi, m->moving, m->transport, m->tau_grain, m->u_fluid, m->tau_fluid};
    memcpy(rows, all, sizeof all);
}

/* Volume of a grain to the cells. */
RY_INLINE void add_still(const ry_measure *m, const ry_grains *g, int32_t k, double *volumes)
{
    const double z = g->z[k], r = g->radius[k];
    const ry_span span = ry_slice_span(z, r, 1.0 / m->dz, m->nz);
    for (int32_t first = span.first; first <= span.last; first += RY_SLICES) {
        for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
            const ry_four part = ry_slice_cut((first * m->dz - z) / r, m->dz / r, four).part;
            ry_slice_add(volumes + first + 4 * four, 4.0 / 3.0 * M_PI * r * r * r * part);
        }
    }
}

/* Volumes of the fixed grains, once and for all; in ascending id. */
static ry_status sum_fixed(ry_measure *m, const ry_grains *g, ry_error *error)
{
    int32_t *const place = ry_array((size_t)g->n, sizeof *place);
    if (place == NULL) {
        return ry_no_memory(error, (size_t)g->n * sizeof *place);
    }
    for (int32_t k = 0; k < g->n; k++) {
        place[g->id[k]] = k;
    }
    for (int32_t id = 0; id < g->n; id++) {
        if (g->fixed[place[id]]) {
            add_still(m, g, place[id], m->still);
        }
    }
    free(place);
    return RY_OK;
}

/* And of the sleepers, when they have changed. */
RY_CLONES static void sum_asleep(ry_measure *m, const ry_grains *g, const ry_sets *sets)
{
    if (m->changes == sets->changes) {
        return;
    }
    memset(m->asleep, 0, row_length(m) * sizeof *m->asleep);
    for (int32_t rank = 0; rank < sets->n_asleep; rank++) {
        if (!g->fixed[sets->asleep[rank]]) {
            add_still(m, g, sets->asleep[rank], m->asleep);
        }
    }
    m->changes = sets->changes;
}

ry_status ry_measure_create(ry_measure *m, const ry_state *state, double length, double d, int threads,
                            int window, ry_error *error)
{
    const size_t nz = (size_t)state->column.nz;
    *m = (ry_measure){.n = state->grains.n, .nz = state->column.nz, .dz = state->column.dz, .length = length, .d = d,
                      .threads = threads, .window = window,
                      .changes = -1};
    const int32_t n_blocks = count_blocks(m->n);
    m->at_once = n_blocks < RY_SUM_AT_ONCE * threads ? n_blocks : RY_SUM_AT_ONCE * threads;
    double **const rows[] = {&m->phi, &m->moving, &m->transport, &m->tau_grain, &m->u_fluid, &m->tau_fluid};
    for (int r = 0; r < N_ROWS; r++) {
        *rows[r] = ry_array(nz, sizeof(double));
        if (*rows[r] == NULL) {
            return ry_no_memory(error, nz * sizeof(double));
        }
    }
    const size_t n = (size_t)state->grains.n;
    m->impulse = ry_array(n, sizeof(double));
    m->middle = ry_array(n, sizeof(double));
    if (m->impulse == NULL || m->middle == NULL) {
        return ry_no_memory(error, 2 * n * sizeof(double));
    }
    m->still = ry_array(row_length(m), sizeof(double));
    m->asleep = ry_array(row_length(m), sizeof(double));
    m->sums = ry_array(((size_t)m->at_once + 1) * ROW_COUNT * row_length(m), sizeof(double));
    if (m->still == NULL || m->asleep == NULL || m->sums == NULL) {
        return ry_no_memory(error, (size_t)m->at_once * ROW_COUNT * nz * 8);
    }
    return sum_fixed(m, &state->grains, error);
}

void ry_measure_free(ry_measure *m)
{
    double *rows[N_ROWS];
    rows_of(m, rows);
    for (int r = 0; r < N_ROWS; r++) {
        free(rows[r]);
    }
    free(m->impulse);
    free(m->middle);
    free(m->still);
    free(m->asleep);
    free(m->sums);
    *m = (ry_measure){0};
}

void ry_measure_clear(ry_measure *m)
{
    double *rows[N_ROWS];
    rows_of(m, rows);
    for (int r = 0; r < N_ROWS; r++) {
        memset(rows[r], 0, (size_t)m->nz * sizeof(double));
    }
    memset(m->impulse, 0, (size_t)m->n * sizeof *m->impulse);
    m->samples = 0;
    m->tallied = 0;
}

/* ---- to another process ---------------------------------------------------------------------- */

/* samples, tallied, the rows, impulse, middle */
static int64_t saved_size(const ry_measure *m)
{
    return 2 + (int64_t)N_ROWS * m->nz + 2 * (int64_t)m->n;
}

int64_t ry_measure_saved(const ry_measure *m)
{
    return m->samples > 0 || m->tallied > 0 ? saved_size(m) : 0;
}

void ry_measure_save(const ry_measure *m, const int32_t *place, double *to)
{
    double *rows[N_ROWS];
    rows_of(m, rows);
    *to++ = (double)m->samples;
    *to++ = (double)m->tallied;
    for (int r = 0; r < N_ROWS; r++, to += m->nz) {
        memcpy(to, rows[r], (size_t)m->nz * sizeof *to);
    }
    for (int32_t id = 0; id < m->n; id++) {
        to[id] = m->impulse[place[id]];
        to[m->n + id] = m->middle[place[id]];
    }
}

int ry_measure_load(ry_measure *m, const int32_t *place, const double *from, int64_t count)
{
    double *rows[N_ROWS];
    rows_of(m, rows);
    if (count != saved_size(m)) {
        return -1;
    }
    m->samples = (int64_t)*from++;
    m->tallied = (int32_t)*from++;
    for (int r = 0; r < N_ROWS; r++, from += m->nz) {
        memcpy(rows[r], from, (size_t)m->nz * sizeof *from);
    }
    for (int32_t id = 0; id < m->n; id++) {
        m->impulse[place[id]] = from[id];
        m->middle[place[id]] = from[m->n + id];
    }
    return 0;
}

/* ---- steps ----------------------------------------------------------------------------------- */

typedef struct ry_measure_task {
    ry_measure *measure;
    const ry_state *state;
    const ry_motion *motion;
    const ry_sets *sets;
    int32_t n_awake; /* blocks of those awake; the others are of sleepers */
    int32_t first; /* block */
} ry_measure_task;

RY_CLONES static void add_up(double *restrict sum, const double *restrict value, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        sum[k] += value[k];
    }
}

void ry_measure_begin(ry_measure *m, const ry_state *state)
{
    if (state->step % m->window == m->window / 2) {
        memcpy(m->middle, state->grains.z, (size_t)state->grains.n * sizeof *m->middle);
    }
    m->tallied++;
}

void ry_measure_tally(const ry_measure *m, const ry_motion *motion, int32_t begin, int32_t end, int chunk)
{
    add_up(m->impulse + begin, motion->cx + ry_motion_at(motion, begin, chunk), end - begin);
}

/* ---- one grain ------------------------------------------------------------------------------- */

/* A sphere against the column; t: heights in radii above its centre. */
typedef struct ry_reach {
    ry_span span;        /* cells, and planes at their feet, that it reaches: 0 .. nz */
    double z, r, per_r;  /* [m], [1/m] */
    double step;         /* height of a cell in t */
} ry_reach;

RY_INLINE ry_reach reach(const ry_measure *m, double per_dz, double z, double r)
{
    const double per_r = 1.0 / r;
    return (ry_reach){ry_slice_span(z, r, per_dz, m->nz + 1), z, r, per_r, m->dz * per_r};
}

/* Volume and its transport to the cells, momentum to the planes. `flux`: m u w. */
RY_INLINE void add_volumes(const ry_measure *m, double *sums, const ry_reach *at, double volume, double vx, double flux)
{
    double *const moving = row(m, sums, ROW_MOVING), *const transport = row(m, sums, ROW_TRANSPORT);
    double *const slice = row(m, sums, ROW_SLICE);
    const double carried = volume * vx, peak = flux * 0.75 * at->per_r;
    for (int32_t first = at->span.first; first <= at->span.last; first += RY_SLICES) {
        const double t = (first * m->dz - at->z) * at->per_r;
        for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
            const ry_slices s = ry_slice_cut(t, at->step, four);
            const int32_t cell = first + 4 * four;
            ry_slice_add(moving + cell, volume * s.part);
            ry_slice_add(transport + cell, carried * s.part);
            ry_slice_add(slice + cell, peak * (1.0 - s.foot * s.foot));
        }
    }
}

/* `contact`, `fluid`: forces along x. */
RY_INLINE void add_forces(const ry_measure *m, double *sums, const ry_reach *at, double contact, double fluid)
{
    double *const step = row(m, sums, ROW_STEP), *const fluid_step = row(m, sums, ROW_FLUID_STEP);
    const double top = m->nz * m->dz;
    for (int32_t first = at->span.first; first <= at->span.last; first += RY_SLICES) {
        const double t = (first * m->dz - at->z) * at->per_r;
        for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
            const ry_four part = ry_slice_cut(t, at->step, four).part;
            ry_slice_add(step + first + 4 * four, contact * part);
            ry_slice_add(fluid_step + first + 4 * four, fluid * part);
        }
    }
    if (at->z + at->r > top) {
        const double above = 1.0 - ry_slice_below((top - at->z) * at->per_r);
        step[above_top(m)] += contact * above;
        fluid_step[above_top(m)] += fluid * above;
    }
}

/* Of those awake. */
RY_CLONES static void sum_block(const ry_measure *m, const ry_state *state, const ry_motion *motion,
                      const ry_sets *sets, int32_t block, double *sums)
{
    const ry_grains *const g = &state->grains;
    const int32_t first = block * RY_SUM_BLOCK;
    const int32_t end = first + RY_SUM_BLOCK < sets->n_awake ? first + RY_SUM_BLOCK : sets->n_awake;
    const double per_dz = 1.0 / m->dz, per_dt = 1.0 / motion->dt, per_tally = per_dt / m->tallied;
    memset(sums, 0, ROW_COUNT * row_length(m) * sizeof *sums);
    for (int32_t rank = first; rank < end; rank++) {
        const int32_t k = sets->awake[rank];
        if (motion->im[k] == 0.0) {
            continue; /* in `still`, and nothing acts through it */
        }
        const double r = g->radius[k], mass = 1.0 / motion->im[k];
        const ry_reach now = reach(m, per_dz, g->z[k], r), halfway = reach(m, per_dz, m->middle[k], r);
        add_volumes(m, sums, &now, 4.0 / 3.0 * M_PI * r * r * r, g->vx[k], mass * g->vx[k] * g->vz[k]);
        add_forces(m, sums, &halfway, m->impulse[k] * per_tally, motion->gx[k] * mass * per_dt);
    }
}

/* Of sleepers: forces only. */
RY_CLONES static void sum_block_asleep(const ry_measure *m, const ry_grains *g, const ry_motion *motion,
                                       const ry_sets *sets, int32_t block, double *sums)
{
    const int32_t first = block * RY_SUM_BLOCK;
    const int32_t end = first + RY_SUM_BLOCK < sets->n_asleep ? first + RY_SUM_BLOCK : sets->n_asleep;
    const double per_dz = 1.0 / m->dz, per_dt = 1.0 / motion->dt, per_tally = per_dt / m->tallied;
    memset(sums, 0, ROW_COUNT * row_length(m) * sizeof *sums);
    for (int32_t rank = first; rank < end; rank++) {
        const int32_t k = sets->asleep[rank];
        if (motion->im[k] != 0.0) {
            const ry_reach halfway = reach(m, per_dz, m->middle[k], g->radius[k]);
            add_forces(m, sums, &halfway, m->impulse[k] * per_tally, motion->gx[k] / motion->im[k] * per_dt);
        }
    }
}

/* ---- all grains ------------------------------------------------------------------------------ */

static void sum_blocks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_measure_task *const t = context;
    (void)thread;
    for (int32_t at = begin; at < end; at++) {
        double *const sums = t->measure->sums + (size_t)at * ROW_COUNT * row_length(t->measure);
        const int32_t block = t->first + at;
        if (block < t->n_awake) {
            sum_block(t->measure, t->state, t->motion, t->sets, block, sums);
        } else {
            sum_block_asleep(t->measure, &t->state->grains, t->motion, t->sets, block - t->n_awake, sums);
        }
    }
}

static double *sum_grains(ry_measure *m, const ry_state *state, const ry_motion *motion, const ry_sets *sets)
{
    const int32_t n_awake = count_blocks(sets->n_awake), n_blocks = n_awake + count_blocks(sets->n_asleep);
    const size_t width = ROW_COUNT * row_length(m);
    ry_measure_task task = {.measure = m, .state = state, .motion = motion, .sets = sets, .n_awake = n_awake};
    double *const total = m->sums + (size_t)m->at_once * width;
    memset(total, 0, width * sizeof *total);
    for (; task.first < n_blocks; task.first += m->at_once) {
        const int32_t left = n_blocks - task.first, n = left < m->at_once ? left : m->at_once;
        ry_parallel(m->threads, n, sum_blocks, &task);
        for (int32_t block = 0; block < n; block++) {
            for (size_t k = 0; k < width; k++) {
                total[k] += m->sums[(size_t)block * width + k];
            }
        }
    }
    if (sets->n_asleep > 0) {
        sum_asleep(m, &state->grains, sets);
        for (size_t k = 0; k < row_length(m); k++) {
            row(m, total, ROW_MOVING)[k] += m->asleep[k];
        }
    }
    return total;
}

void ry_measure_add(ry_measure *m, const ry_state *state, const ry_motion *motion, const ry_sets *sets,
                    const double *tau_fluid, double tau_bed)
{
    double *const total = sum_grains(m, state, motion, sets);
    const double per_area = 1.0 / (m->length * m->d), per_cell = per_area / m->dz;
    const double *const slice = row(m, total, ROW_SLICE);
    double contact = row(m, total, ROW_STEP)[above_top(m)], fluid = row(m, total, ROW_FLUID_STEP)[above_top(m)];
    double grain_above = contact + slice[m->nz], fluid_above = fluid;
    for (int32_t k = m->nz - 1; k >= 0; k--) { /* a cell gets the mean of the planes at its ends */
        contact += row(m, total, ROW_STEP)[k];
        fluid += row(m, total, ROW_FLUID_STEP)[k];
        const double grain_here = contact + slice[k];
        m->phi[k] += (m->still[k] + row(m, total, ROW_MOVING)[k]) * per_cell;
        m->moving[k] += row(m, total, ROW_MOVING)[k] * per_cell;
        m->transport[k] += row(m, total, ROW_TRANSPORT)[k] * per_cell;
        m->tau_grain[k] -= 0.5 * (grain_above + grain_here) * per_area;
        m->tau_fluid[k] += tau_fluid != NULL ? tau_fluid[k] : tau_bed - 0.5 * (fluid_above + fluid) * per_area;
        m->u_fluid[k] += state->column.u[k];
        grain_above = grain_here;
        fluid_above = fluid;
    }
    memset(m->impulse, 0, (size_t)state->grains.n * sizeof *m->impulse);
    m->tallied = 0;
    m->samples++;
}

ry_measure_sums ry_measure_grains(const ry_state *state, const ry_motion *motion, const ry_sets *sets)
{
    const ry_grains *const g = &state->grains;
    ry_measure_sums sums = {.finite = 1, .fastest_grain = -1};
    for (int32_t first = 0; first < sets->n_awake; first += RY_SUM_BLOCK) {
        const int32_t end = first + RY_SUM_BLOCK < sets->n_awake ? first + RY_SUM_BLOCK : sets->n_awake;
        double transport = 0.0, kinetic = 0.0, gravity = 0.0;
        for (int32_t rank = first; rank < end; rank++) {
            const int32_t k = sets->awake[rank];
            const double im = motion->im[k], r = g->radius[k];
            const double v2 = g->vx[k] * g->vx[k] + g->vz[k] * g->vz[k];
            const double way = sqrt(v2) * motion->dt / (2.0 * r);
            if (!(v2 + fabs(g->x[k]) + fabs(g->z[k]) + fabs(g->spin[k]) < 1e300)) {
                sums.finite = 0;
                sums.fastest_grain = k;
            }
            if (way > sums.fastest) {
                sums.fastest = way;
                sums.fastest_grain = sums.finite ? k : sums.fastest_grain;
            }
            if (im != 0.0) {
                const double inertia = r / motion->spin_gain[k];
                transport += 4.0 / 3.0 * M_PI * r * r * r * g->vx[k];
                kinetic += 0.5 * (v2 / im + inertia * g->spin[k] * g->spin[k]);
                gravity += ry_measure_gravity(g, motion, k);
            }
        }
        sums.transport += transport;
        sums.kinetic += kinetic;
        sums.gravity += gravity;
    }
    return sums;
}
