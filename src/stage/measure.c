/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "stage/slices.h"

/* Rows of a block's sums; STEP holds what the stress changes from one plane to the next above. */
enum { ROW_PHI, ROW_MOVING, ROW_TRANSPORT, ROW_STEP, ROW_SLICE, ROW_FLUID_STEP, ROW_COUNT };

/* A row has room for a last run of slices beyond the column. */
static size_t row_length(const ry_measure *m)
{
    return (size_t)m->nz + RY_SLICES;
}

static double *row(const ry_measure *m, double *sums, int which)
{
    return sums + (size_t)which * row_length(m);
}

static double **rows_of(ry_measure *m, double **rows)
{
    double *const all[] = {m->phi, m->moving, m->transport, m->tau_grain, m->u_fluid, m->tau_fluid};
    memcpy(rows, all, sizeof all);
    return rows;
}
enum { N_ROWS = 6 };

ry_status ry_measure_create(ry_measure *m, const ry_state *state, double length, double d, int threads,
                            int window, ry_error *error)
{
    const size_t nz = (size_t)state->column.nz;
    *m = (ry_measure){.nz = state->column.nz, .dz = state->column.dz, .length = length, .d = d,
                      .threads = threads, .window = window,
                      .n_blocks = (state->grains.n + RY_SUM_BLOCK - 1) / RY_SUM_BLOCK};
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
    m->sums = ry_array(((size_t)m->n_blocks + 1) * ROW_COUNT * row_length(m), sizeof(double));
    return m->sums != NULL ? RY_OK : ry_no_memory(error, (size_t)m->n_blocks * ROW_COUNT * nz * 8);
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
    m->samples = 0;
}

typedef struct ry_measure_task {
    ry_measure *measure;
    const ry_state *state;
    const ry_motion *motion;
    const int32_t *place;
} ry_measure_task;

static void tally(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_measure_task *const t = context;
    const double *restrict const cx = t->motion->cx;
    double *restrict const impulse = t->measure->impulse;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        impulse[k] += cx[k];
    }
}

void ry_measure_tally(ry_measure *m, const ry_state *state, const ry_motion *motion)
{
    ry_measure_task task = {.measure = m, .state = state, .motion = motion};
    if (state->step % m->window == m->window / 2) {
        memcpy(m->middle, state->grains.z, (size_t)state->grains.n * sizeof *m->middle);
    }
    m->tallied++;
    ry_parallel(m->threads, state->grains.n, tally, &task);
}

/* ---- one grain ------------------------------------------------------------------------------- */

RY_INLINE void add_volumes(const ry_measure *m, double *sums, double z, double r, double vx, int moving)
{
    const double volume = 4.0 / 3.0 * M_PI * r * r * r, mobile = moving ? volume : 0.0;
    const ry_span span = ry_slice_span(z, r, 1.0 / m->dz, m->nz);
    double *const phi = row(m, sums, ROW_PHI), *const free = row(m, sums, ROW_MOVING);
    double *const transport = row(m, sums, ROW_TRANSPORT);
    for (int32_t first = span.first; first <= span.last; first += RY_SLICES) {
        double parts[RY_SLICES];
        ry_slice_parts((first * m->dz - z) / r, m->dz / r, parts);
        for (int32_t k = 0; k < RY_SLICES; k++) {
            phi[first + k] += volume * parts[k];
        }
        for (int32_t k = 0; k < RY_SLICES; k++) {
            free[first + k] += mobile * parts[k];
        }
        for (int32_t k = 0; k < RY_SLICES; k++) {
            transport[first + k] += mobile * vx * parts[k];
        }
    }
}

/* Planes at the feet of the cells that a grain reaches, plane k at k dz; first > last: none. */
static ry_span planes(const ry_measure *m, double z, double r)
{
    const double low = ceil((z - r) / m->dz), high = floor((z + r) / m->dz);
    ry_span span;
    span.first = low > 0.0 ? (int32_t)fmin(low, m->nz + 1) : 0;
    span.last = high < m->nz ? (int32_t)fmax(high, -1.0) : m->nz;
    return span;
}

/* `contact`, `fluid`: forces along x on a grain at z. */
static void add_forces(const ry_measure *m, double *sums, double z, double r, double contact, double fluid)
{
    double *const step = row(m, sums, ROW_STEP), *const fluid_step = row(m, sums, ROW_FLUID_STEP);
    const ry_span span = planes(m, z, r);
    double above = 1.0; /* part of the grain above the plane before */
    for (int32_t k = span.first; k <= span.last + 1; k++) {
        const double here = k > span.last ? 0.0 : 1.0 - ry_slice_below((k * m->dz - z) / r);
        if (k > 0) { /* between the planes k-1 and k */
            step[k - 1] += contact * (above - here);
            fluid_step[k - 1] += fluid * (above - here);
        }
        above = here;
    }
}

/* `flux`: m u w of a grain at z. */
static void add_flux(const ry_measure *m, double *sums, double z, double r, double flux)
{
    double *const slice = row(m, sums, ROW_SLICE);
    const ry_span span = planes(m, z, r);
    for (int32_t k = span.first; k <= span.last; k++) {
        const double t = (k * m->dz - z) / r;
        slice[k] += flux * 0.75 / r * (1.0 - t * t);
    }
}

RY_CLONES static void sum_block(const ry_measure *m, const ry_state *state, const ry_motion *motion,
                      const int32_t *place, int32_t block)
{
    const ry_grains *const g = &state->grains;
    double *const sums = m->sums + (size_t)block * ROW_COUNT * row_length(m);
    const int32_t first = block * RY_SUM_BLOCK;
    const int32_t end = first + RY_SUM_BLOCK < g->n ? first + RY_SUM_BLOCK : g->n;
    memset(sums, 0, ROW_COUNT * row_length(m) * sizeof *sums);
    for (int32_t id = first; id < end; id++) {
        const int32_t k = place[id];
        const double im = motion->im[k];
        add_volumes(m, sums, g->z[k], g->radius[k], g->vx[k], im != 0.0);
        if (im != 0.0) {
            add_forces(m, sums, m->middle[k], g->radius[k], m->impulse[k] / (m->tallied * motion->dt),
                       motion->gx[k] / (im * motion->dt));
            add_flux(m, sums, g->z[k], g->radius[k], g->vx[k] * g->vz[k] / im);
        }
    }
}

/* ---- all grains ------------------------------------------------------------------------------ */

static void sum_blocks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_measure_task *const t = context;
    (void)thread;
    for (int32_t block = begin; block < end; block++) {
        sum_block(t->measure, t->state, t->motion, t->place, block);
    }
}

static double *sum_grains(ry_measure *m, const ry_state *state, const ry_motion *motion, const int32_t *place)
{
    const int32_t n_blocks = m->n_blocks;
    const size_t width = ROW_COUNT * row_length(m);
    ry_measure_task task = {m, state, motion, place};
    ry_parallel(m->threads, n_blocks, sum_blocks, &task);
    double *const total = m->sums + (size_t)n_blocks * width;
    memset(total, 0, width * sizeof *total);
    for (int32_t block = 0; block < n_blocks; block++) {
        for (size_t k = 0; k < width; k++) {
            total[k] += m->sums[(size_t)block * width + k];
        }
    }
    return total;
}

void ry_measure_add(ry_measure *m, const ry_state *state, const ry_motion *motion, const int32_t *place,
                    const double *tau_fluid, double tau_bed)
{
    double *const total = sum_grains(m, state, motion, place);
    const double per_area = 1.0 / (m->length * m->d), per_cell = per_area / m->dz;
    const double *const slice = row(m, total, ROW_SLICE);
    double contact = row(m, total, ROW_STEP)[m->nz], fluid = row(m, total, ROW_FLUID_STEP)[m->nz];
    double grain_above = contact + slice[m->nz], fluid_above = fluid;
    for (int32_t k = m->nz - 1; k >= 0; k--) { /* a cell gets the mean of the planes at its ends */
        contact += row(m, total, ROW_STEP)[k];
        fluid += row(m, total, ROW_FLUID_STEP)[k];
        const double grain_here = contact + slice[k];
        m->phi[k] += row(m, total, ROW_PHI)[k] * per_cell;
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

ry_measure_sums ry_measure_grains(const ry_state *state, const ry_motion *motion, const int32_t *place)
{
    const ry_grains *const g = &state->grains;
    ry_measure_sums sums = {.finite = 1, .fastest_grain = -1};
    for (int32_t first = 0; first < g->n; first += RY_SUM_BLOCK) {
        const int32_t end = first + RY_SUM_BLOCK < g->n ? first + RY_SUM_BLOCK : g->n;
        double transport = 0.0, kinetic = 0.0, gravity = 0.0;
        for (int32_t id = first; id < end; id++) {
            const int32_t k = place[id];
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
                gravity -= motion->weight[k] / (im * motion->dt) * g->z[k];
            }
        }
        sums.transport += transport;
        sums.kinetic += kinetic;
        sums.gravity += gravity;
    }
    return sums;
}
