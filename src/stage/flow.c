/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Model balance: one-dimensional momentum balance of the fluid between the grains (Duran, Andreotti &
 * Claudin 2012, Phys. Fluids 24, 103306; Maurin et al. 2015, Phys. Fluids 27, 113302)
 *
 *     rho (1-phi) du/dt = d tau/dz - f,    tau = rho (1-phi) (nu + l^2 |u'|) u',
 *
 * f: force on the grains per volume: drag and the stress gradient (generalised buoyancy V dtau/dz).
 * tau = tau_b at the top, u = 0 at z = 0. In the mean tau(z) = tau_b - int_z^inf f dz. */
#include "stage/flow.h"

#include <stdlib.h>
#include <string.h>

#include "base/elementary.h"
#include "base/memory.h"
#include "law/drag.h"
#include "stage/column.h"
#include "stage/eddies.h"
#include "stage/four.h"
#include "stage/resting.h"
#include "stage/slices.h"

double ry_flow_stress(const ry_flow *f, int64_t step)
{
    return step < f->step_start ? 0.0 : (step < f->step_boost ? f->tau_start : f->tau);
}

/* ---- what a grain feels ---------------------------------------------------------------------- */

/* pi/8 rho_f d^2 of a grain [kg/m], and its volume [m^3]. */
RY_INLINE double area_of(double density, double r)
{
    const double d = 2.0 * r;
    return 0.125 * M_PI * density * d * d;
}

RY_INLINE ry_four see(const double (*face)[RY_FACE], int32_t cell, double part)
{
    const ry_four below = ry_four_load(face[cell]), above = ry_four_load(face[cell + 1]);
    return below + part * (above - below);
}

/* Rate of drag [kg/s]; rx, rz: velocity of the fluid against the grain. */
RY_INLINE double drag_rate(double rx, double rz, double area, double viscous, double hinder, double c,
                           ry_flow_drag law)
{
    const double speed = sqrt(rx * rx + rz * rz);
    const double coefficient = law == RY_FLOW_DALLAVALLE ? ry_drag_dallavalle(speed, viscous, c)
                               : law == RY_FLOW_SCHILLER ? ry_drag_schiller(speed, viscous, c)
                                                         : ry_drag_ferguson(speed, viscous, c);
    return area * coefficient * hinder;
}

/* Of a grain that moves against the fluid by rx, rz, with this rate of drag: how the force that it gets along x, which
 * is `share` of the drag, changes with the fluid's velocity there [kg/s]. */
RY_INLINE double drag_slope(double rx, double rz, double rate, double share, double viscous, double c, ry_flow_drag law)
{
    const double speed2 = rx * rx + rz * rz, speed = sqrt(speed2);
    const double power = law == RY_FLOW_DALLAVALLE ? ry_drag_dallavalle_power(speed, viscous, c)
                         : law == RY_FLOW_SCHILLER ? ry_drag_schiller_power(speed, viscous, c)
                                                   : ry_drag_ferguson_power(speed, viscous, c);
    const double along = speed2 > 0.0 ? rx * rx / speed2 : 0.0;
    return rate * share * (1.0 + power * along * share);
}

/* What a block of grains sees. */
typedef struct ry_seen {
    _Alignas(RY_ALIGNMENT) double u[RY_BLOCK], gradient[RY_BLOCK], hinder[RY_BLOCK], star[RY_BLOCK];
} ry_seen;

RY_INLINE void see_block(const ry_flow *f, const double *z, int32_t n, const int walks, ry_seen *out)
{
    const ry_flow flow = *f; /* a copy that nothing written to below can alias */
    int32_t cell[RY_BLOCK];
    _Alignas(RY_ALIGNMENT) double part[RY_BLOCK];
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const ry_spot spot = ry_column_spot(&flow, z[k]);
        cell[k] = spot.cell;
        part[k] = spot.part;
    }
    for (int32_t k = n; k % 4 != 0; k++) {
        cell[k] = 0;
        part[k] = 0.0;
    }
    const double (*const face)[RY_FACE] = (const double (*)[RY_FACE])f->face;
    for (int32_t k = 0; k < n; k += 4) {
        ry_four rows[4];
        for (int32_t q = 0; q < 4; q++) {
            rows[q] = see(face, cell[k + q], part[k + q]);
        }
        ry_four_turn(rows);
        ry_four_store(out->u + k, rows[RY_FACE_U]);
        ry_four_store(out->gradient + k, rows[RY_FACE_GRADIENT]);
        ry_four_store(out->hinder + k, rows[RY_FACE_HINDER]);
        if (walks) {
            ry_four_store(out->star + k, rows[RY_FACE_STAR]);
        }
    }
}

/* Whose force is wanted, and ry_grains.push: of those awake, without it, where it is summed up, or where it pushes
 * exposed grains; or of sleepers, the latter likewise. WALKS: in eddies. */
enum { AWAKE, SUMMED, PUSHED, RESTING, RESTING_PUSHED, AWAKE_WALKS, SUMMED_WALKS, RESTING_WALKS, WAYS };

/* Grains begin .. begin+n-1; at: their place in gx, gz. */
RY_INLINE void sample_block(const ry_flow *f, const ry_grains *g, const ry_motion *m, int32_t begin, int32_t n,
                            int32_t at, ry_flow_drag law, int way)
{
    const int pushed = way == PUSHED || way == RESTING_PUSHED, walks = way >= AWAKE_WALKS;
    const int rests = way == RESTING || way == RESTING_PUSHED || way == RESTING_WALKS;
    const int summed = way == SUMMED || way == SUMMED_WALKS;
    ry_seen seen;
    const double dt = f->dt, c = f->drag_coefficient, density = f->density;
    const double *const vx = g->vx + begin, *const vz = g->vz + begin, *const radius = g->radius + begin;
    const double *const viscous = f->viscous + begin;
    const double *const im = m->im + begin, *const weight = m->weight + begin;
    const double *const eddy_x = walks ? f->eddy_x + begin : NULL;
    const double *const eddy_z = walks ? f->eddy_z + begin : NULL;
    double *restrict const push = pushed || summed ? g->push + begin : NULL;
    double *restrict const gx = m->gx + at, *restrict const gz = m->gz + at;
    double *restrict const force = rests ? f->resting.force + begin : NULL;
    double *restrict const slope = rests ? f->resting.slope + begin : NULL;
    see_block(f, g->z + begin, n, walks, &seen);
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double rx = seen.u[k] - vx[k] + (walks ? seen.star[k] * eddy_x[k] : 0.0);
        const double rz = vz[k] - (walks ? seen.star[k] * eddy_z[k] : 0.0);
        const double rate = drag_rate(rx, rz, area_of(density, radius[k]), viscous[k], seen.hinder[k], c, law);
        const double b = rate * dt * im[k];
        const double share = 1.0 / (1.0 + b);
        const double along = ry_column_volume(radius[k]) * seen.gradient[k] + (pushed ? push[k] : 0.0);
        gx[k] = (b * rx + along * dt * im[k]) * share;
        gz[k] = (weight[k] - b * rz) * share;
        if (rests) {
            force[k] = (rate * rx + along) * share;
            slope[k] = drag_slope(rx, rz, rate, share, viscous[k], c, law);
        } else if (summed) {
            push[k] += (rate * rx + along) * share;
        }
    }
}

#define SAMPLE(name, law, way)                                                                              \
    RY_CLONES static void name(const ry_flow *f, const ry_grains *g, const ry_motion *m, int32_t begin,     \
                               int32_t n, int32_t at)                                                       \
    {                                                                                                       \
        sample_block(f, g, m, begin, n, at, law, way);                                                      \
    }
#define SAMPLES(name, way)                               \
    SAMPLE(name##_dallavalle, RY_FLOW_DALLAVALLE, way)   \
    SAMPLE(name##_schiller, RY_FLOW_SCHILLER, way)       \
    SAMPLE(name##_ferguson, RY_FLOW_FERGUSON, way)
SAMPLES(awake, AWAKE)
SAMPLES(summed, SUMMED)
SAMPLES(pushed, PUSHED)
SAMPLES(resting, RESTING)
SAMPLES(resting_pushed, RESTING_PUSHED)
SAMPLES(awake_walks, AWAKE_WALKS)
SAMPLES(summed_walks, SUMMED_WALKS)
SAMPLES(resting_walks, RESTING_WALKS)

typedef void sample_fn(const ry_flow *f, const ry_grains *g, const ry_motion *m, int32_t begin, int32_t n, int32_t at);
#define ROW(name) {name##_dallavalle, name##_schiller, name##_ferguson}
static sample_fn *const samplers[WAYS][3] = {
    ROW(awake),       ROW(summed),       ROW(pushed),       ROW(resting), ROW(resting_pushed),
    ROW(awake_walks), ROW(summed_walks), ROW(resting_walks),
};

/* Velocity of grain k against the eddy that it is in, less the mean flow's: `seen` where it is. */
RY_INLINE void in_eddy(const ry_flow *f, const ry_grains *g, int32_t k, const ry_four seen, double *vx, double *vz)
{
    *vx = g->vx[k] - (f->walks ? seen[RY_FACE_STAR] * f->eddy_x[k] : 0.0);
    *vz = g->vz[k] - (f->walks ? seen[RY_FACE_STAR] * f->eddy_z[k] : 0.0);
}

/* Lift by the difference of u^2 between the top and the bottom of a grain (Wiberg & Smith 1985,
 * J. Geophys. Res. 90, 7341): F = pi/8 rho C_L d^2 (u_top^2 - u_bottom^2), upwards. It has the share that gravity has
 * in the implicit step with the drag (sample_block). */
static void add_lift(const ry_flow *f, const ry_grains *g, const ry_motion *m, int32_t begin, int32_t n, int32_t at)
{
    const double (*const face)[RY_FACE] = (const double (*)[RY_FACE])f->face;
    for (int32_t k = begin; k < begin + n; k++) {
        const double r = g->radius[k], area = area_of(f->density, r);
        const ry_spot above = ry_column_spot(f, g->z[k] + r), below = ry_column_spot(f, g->z[k] - r);
        const ry_spot middle = ry_column_spot(f, g->z[k]);
        const ry_four seen = see(face, middle.cell, middle.part);
        double vx, vz;
        in_eddy(f, g, k, seen, &vx, &vz);
        const double top = see(face, above.cell, above.part)[RY_FACE_U] - vx;
        const double foot = see(face, below.cell, below.part)[RY_FACE_U] - vx;
        const double rate = drag_rate(seen[RY_FACE_U] - vx, vz, area, f->viscous[k], seen[RY_FACE_HINDER],
                                      f->drag_coefficient, f->drag);
        const double per_mass = f->dt * m->im[k];
        m->gz[at + k - begin] += f->lift * area * (top * top - foot * foot) * per_mass / (1.0 + rate * per_mass);
    }
}

/* `at` of a grain: `first` more than its index. */
static void sample_range(const ry_flow *f, const ry_grains *g, const ry_motion *m, int32_t begin, int32_t end,
                         int32_t first, int way)
{
    for (int32_t k = begin; k < end; k += RY_BLOCK) {
        const int32_t n = end - k < RY_BLOCK ? end - k : RY_BLOCK;
        samplers[way][f->drag](f, g, m, k, n, k + first);
        if (f->lift > 0.0) {
            add_lift(f, g, m, k, n, k + first);
        }
    }
}

void ry_flow_sample(const ry_flow *f, const ry_grains *g, const ry_motion *m, int32_t begin, int32_t end, int chunk)
{
    const int summed = f->walks ? SUMMED_WALKS : SUMMED, awake = f->walks ? AWAKE_WALKS : AWAKE;
    const int way = f->model == RY_FLOW_STRESS ? PUSHED : (f->model == RY_FLOW_BALANCE ? summed : awake);
    sample_range(f, g, m, begin, end, ry_motion_push_at(m, begin, chunk) - begin, way);
}

void ry_flow_sample_asleep(const ry_flow *f, const ry_grains *g, const ry_motion *m)
{
    const int flows = f->walks ? RESTING_WALKS : RESTING;
    sample_range(f, g, m, m->n_awake, g->n, 0, f->model == RY_FLOW_STRESS ? RESTING_PUSHED : flows);
}

typedef struct ry_flow_task {
    const ry_flow *flow;
    const ry_state *state;
    const ry_motion *motion;
    const ry_sets *sets;
    int32_t n_awake; /* blocks of those awake; the others are of sleepers */
    int32_t first; /* block */
} ry_flow_task;

/* ---- what the column gets -------------------------------------------------------------------- */

/* Adds a grain to the rows of a block, a run of RY_SLICES cells at a time; the rows have that much room
 * to spare at their end. */
RY_INLINE void spread(double *volumes, double *gots, double *forces, double *slopes, const ry_span span, double dz,
                      double z, double r, double volume, double got, double force, double slope)
{
    const double per_r = 1.0 / r;
    for (int32_t first = span.first; first <= span.last; first += RY_SLICES) {
        const double t = (first * dz - z) * per_r;
        for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
            const ry_four part = ry_slice_cut(t, dz * per_r, four).part;
            ry_slice_add(volumes + first + 4 * four, volume * part);
            ry_slice_add(gots + first + 4 * four, got * part);
            ry_slice_add(forces + first + 4 * four, force * part);
            ry_slice_add(slopes + first + 4 * four, slope * part);
        }
    }
}

/* Sums of a block of awake grains into the rows `at`. */
RY_CLONES static void sum_block(const ry_flow *f, const ry_state *state, const ry_motion *m, const ry_sets *sets,
                      int32_t block, int32_t at)
{
    const ry_grains *const g = &state->grains;
    const ry_column *const c = &state->column;
    const int32_t first = block * RY_SUM_BLOCK;
    const int32_t end = first + RY_SUM_BLOCK < sets->n_awake ? first + RY_SUM_BLOCK : sets->n_awake;
    double *const volumes = ry_column_sums(f, at, RY_SUM_VOLUME);
    double *const gots = ry_column_sums(f, at, RY_SUM_GOT);
    double *const forces = ry_column_sums(f, at, RY_SUM_FORCE);
    double *const slopes = ry_column_sums(f, at, RY_SUM_SLOPE);
    for (int32_t rank = first; rank < end; rank++) {
        const int32_t k = sets->awake[rank];
        double got = 0.0, force = 0.0, slope = 0.0;
        if (f->model == RY_FLOW_BALANCE) {
            const ry_spot spot = ry_column_spot(f, g->z[k]);
            const ry_four seen = see((const double (*)[RY_FACE])f->face, spot.cell, spot.part);
            double vx, vz;
            in_eddy(f, g, k, seen, &vx, &vz);
            const double rx = seen[RY_FACE_U] - vx, c_d = f->drag_coefficient;
            const double rate = drag_rate(rx, vz, area_of(f->density, g->radius[k]), f->viscous[k],
                                          seen[RY_FACE_HINDER], c_d, f->drag);
            const double share = 1.0 / (1.0 + rate * f->dt * m->im[k]);
            got = g->push[k] / f->advance;
            force = (rate * rx + ry_column_volume(g->radius[k]) * seen[RY_FACE_GRADIENT]) * share;
            slope = drag_slope(rx, vz, rate, share, f->viscous[k], c_d, f->drag);
        }
        const double z = g->z[k], r = g->radius[k];
        spread(volumes, gots, forces, slopes, ry_slice_span(z, r, 1.0 / c->dz, c->nz), c->dz, z, r,
               ry_column_volume(r), got, force, slope);
    }
}

static void sum_blocks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_flow_task *const t = context;
    const ry_flow *const f = t->flow;
    (void)thread;
    for (int32_t at = begin; at < end; at++) {
        const int32_t block = t->first + at;
        memset(ry_column_sums(f, at, 0), 0, RY_SUM_COUNT * ry_column_row_length(f) * sizeof(double));
        if (block < t->n_awake) {
            sum_block(f, t->state, t->motion, t->sets, block, at);
        } else {
            const int32_t first = (block - t->n_awake) * RY_SUM_BLOCK, left = t->sets->n_asleep - first;
            ry_resting_sum(f, &t->state->grains, t->sets, first, first + (left < RY_SUM_BLOCK ? left : RY_SUM_BLOCK),
                           ry_column_sums(f, at, RY_SUM_GOT), ry_column_sums(f, at, RY_SUM_FORCE),
                           ry_column_sums(f, at, RY_SUM_SLOPE));
        }
    }
}

static int32_t count_blocks(int32_t n)
{
    return (n + RY_SUM_BLOCK - 1) / RY_SUM_BLOCK;
}

/* Sums over fixed blocks in ascending id, then over the blocks in order: no thread count shows. */
static void sum_grains(ry_flow *f, const ry_state *state, ry_motion *m, const ry_sets *sets)
{
    const size_t width = RY_SUM_COUNT * ry_column_row_length(f);
    ry_flow_task task = {.flow = f, .state = state, .motion = m, .sets = sets};
    task.n_awake = count_blocks(sets->n_awake);
    const int32_t n_blocks = task.n_awake + (f->model == RY_FLOW_BALANCE ? count_blocks(sets->n_asleep) : 0);
    double *const total = f->sums + (size_t)f->at_once * width;
    memset(total, 0, width * sizeof *total);
    if (sets->n_asleep > 0) {
        memcpy(ry_column_sums(f, f->at_once, RY_SUM_VOLUME), f->resting.volumes,
               ry_column_row_length(f) * sizeof *total);
    }
    for (; task.first < n_blocks; task.first += f->at_once) {
        const int32_t left = n_blocks - task.first, n = left < f->at_once ? left : f->at_once;
        ry_parallel(f->threads, n, sum_blocks, &task);
        for (int32_t block = 0; block < n; block++) {
            const double *const part = f->sums + (size_t)block * width;
            for (size_t k = 0; k < width; k++) {
                total[k] += part[k];
            }
        }
    }
}

/* The column takes the running mean over the time in which a grain near the bed goes a few diameters; grains, which may
 * fall through water at rest, are hindered by those of now. */
static void average_phi(const ry_flow *f, ry_column *c, int64_t step)
{
    const double *const volume = ry_column_sums(f, f->at_once, RY_SUM_VOLUME);
    const double per_cell = 1.0 / (f->length * f->d * c->dz);
    const double speed = sqrt(f->tau / f->density) + 3.2e-4 * sqrt(f->gravity * f->d);
    const double weight = step < f->advance ? 1.0 : f->advance * f->dt * speed / (5.0 * f->d);
    const double part = weight < 1.0 ? weight : 1.0;
    for (int32_t k = 0; k < c->nz; k++) {
        c->solid[k] = volume[k] * per_cell;
        c->phi[k] += part * (c->solid[k] - c->phi[k]);
    }
}

/* Mean of phi over the cells up to `half` around cell k, as far as there are any. */
static double mean_near_edge(const double *phi, int32_t nz, int32_t half, int32_t k)
{
    const int32_t first = k - half > 0 ? k - half : 0, last = k + half < nz ? k + half : nz - 1;
    double sum = 0.0;
    for (int32_t m = first; m <= last; m++) {
        sum += phi[m];
    }
    return sum / (last - first + 1);
}

/* The same of cells that have all of them. */
RY_CLONES static void find_means(const double *phi, int32_t half, int32_t first, int32_t end, double *restrict out)
{
    const double count = 2 * half + 1;
#pragma omp simd
    for (int32_t k = first; k < end; k++) {
        double sum = 0.0;
        for (int32_t m = -half; m <= half; m++) {
            sum += phi[k + m];
        }
        out[k] = sum / count;
    }
}

static double level_of(const double *mean, int32_t nz, double dz)
{
    double most = 0.0;
    for (int32_t k = 0; k < nz; k++) {
        most = mean[k] > most ? mean[k] : most;
    }
    for (int32_t k = nz - 1; k >= 0 && most > 0.0; k--) {
        if (mean[k] >= 0.5 * most) {
            const double part = k < nz - 1 ? (mean[k] - 0.5 * most) / (mean[k] - mean[k + 1]) : 0.0;
            return (k + 0.5 + part) * dz;
        }
    }
    return 0.0;
}

double ry_flow_bed_level(const double *phi, int32_t nz, double dz, double d, double *mean)
{
    const int32_t half = (int32_t)(0.5 * d / dz + 0.5), inner = nz > 2 * half ? half : nz;
    for (int32_t k = 0; k < inner; k++) {
        mean[k] = mean_near_edge(phi, nz, half, k);
    }
    find_means(phi, half, inner, nz - half, mean);
    for (int32_t k = nz - half > inner ? nz - half : inner; k < nz; k++) {
        mean[k] = mean_near_edge(phi, nz, half, k);
    }
    return level_of(mean, nz, dz);
}

void ry_flow_find_level(ry_flow *f, ry_column *c)
{
    if (f->level_is_old) {
        c->bed_level = ry_flow_bed_level(c->phi, c->nz, c->dz, f->d, f->work);
        f->level_is_old = 0;
    }
}

/* ---- the stress on exposed grains (Harada et al.) -------------------------------------------- */

/* Looks down on the bed: in each bin of x the grain whose surface is highest is exposed. */
static void find_exposed(ry_flow *f, const ry_grains *g, const int32_t *place, int periodic)
{
    const double width = f->length / f->n_bins;
    for (int32_t b = 0; b < f->n_bins; b++) {
        f->bin_top[b] = -1e300;
        f->bin_grain[b] = -1;
    }
    for (int32_t id = 0; id < g->n; id++) {
        const int32_t k = place[id];
        const double x = g->x[k], r = g->radius[k];
        double from = ceil((x - r) / width - 0.5), to = floor((x + r) / width - 0.5);
        if (!periodic) { /* beside the bed nobody is looked at */
            from = fmax(from, 0.0);
            to = fmin(to, f->n_bins - 1);
        }
        for (int32_t b = (int32_t)fmin(from, f->n_bins); b <= (int32_t)fmax(to, -1.0); b++) {
            const int32_t bin = ((b % f->n_bins) + f->n_bins) % f->n_bins;
            const double off = (b + 0.5) * width - x;
            const double top = g->z[k] + sqrt(r * r > off * off ? r * r - off * off : 0.0);
            if (top > f->bin_top[bin]) {
                f->bin_top[bin] = top;
                f->bin_grain[bin] = k;
            }
        }
    }
}

/* tau_b L d, shared over the exposed grains by the width that each shows. */
static void push_exposed(ry_flow *f, ry_grains *g, const int32_t *place, int periodic, double tau)
{
    find_exposed(f, g, place, periodic);
    memset(g->push, 0, (size_t)g->n * sizeof *g->push);
    const double share = tau * f->length * f->d / f->n_bins;
    for (int32_t b = 0; b < f->n_bins; b++) {
        if (f->bin_grain[b] >= 0) {
            g->push[f->bin_grain[b]] += share;
        }
    }
}

/* ---- advance --------------------------------------------------------------------------------- */

void ry_flow_look(ry_flow *f, ry_state *state, ry_motion *m, const ry_sets *sets)
{
    ry_resting_update(f, &state->grains, sets);
    sum_grains(f, state, m, sets);
    average_phi(f, &state->column, state->step);
    f->level_is_old = 1;
}

void ry_flow_advance(ry_flow *f, ry_state *state, ry_motion *m, const ry_sets *sets)
{
    ry_column *const c = &state->column;
    const double tau = ry_flow_stress(f, state->step);
    if (f->walks) {
        ry_eddies_renew(f, &state->grains, state->step);
    }
    ry_flow_look(f, state, m, sets);
    if (f->model == RY_FLOW_BALANCE) {
        memset(state->grains.push, 0, (size_t)state->grains.n * sizeof *state->grains.push);
    }
    if (state->step >= f->step_start) {
        if (f->model == RY_FLOW_BALANCE) {
            ry_column_balance(f, c, tau);
        } else if (f->model == RY_FLOW_LOG) {
            ry_column_log(f, c, tau);
        } else if (f->model == RY_FLOW_STRESS) {
            push_exposed(f, &state->grains, sets->place, m->periodic, tau);
        }
    }
    ry_column_refresh(f, c, 0, ry_column_faces(f));
}

/* ---- making it -------------------------------------------------------------------------------- */

ry_status ry_flow_create(ry_flow *f, const ry_state *state, ry_error *error)
{
    const ry_grains *const g = &state->grains;
    const size_t n = (size_t)g->n, nz = (size_t)state->column.nz;
    f->nz = state->column.nz;
    f->dz = state->column.dz;
    const int32_t n_blocks = count_blocks(g->n);
    f->at_once = n_blocks < RY_SUM_AT_ONCE * f->threads ? n_blocks : RY_SUM_AT_ONCE * f->threads;
    f->n_bins = f->model == RY_FLOW_STRESS ? (int32_t)ceil(8.0 * f->length / f->d) : 0;
    f->viscous = ry_array(n, sizeof(double));
    f->face = ry_array(nz + 1, sizeof *f->face);
    f->u = ry_array(nz + 1, sizeof(double));
    f->gradient = ry_array(nz + 1, sizeof(double));
    f->hinder = ry_array(nz + 1, sizeof(double));
    f->sums = ry_array(((size_t)f->at_once + 1) * RY_SUM_COUNT * ry_column_row_length(f), sizeof(double));
    f->half = (int32_t)ceil(0.5 * f->d / f->dz - 1e-9);
    f->eddy_x = f->walks ? ry_array(n, sizeof(double)) : NULL;
    f->eddy_z = f->walks ? ry_array(n, sizeof(double)) : NULL;
    f->star = f->walks ? ry_array(nz + 1, sizeof(double)) : NULL;
    f->reynolds = f->walks ? ry_array(nz, sizeof(double)) : NULL;
    f->part = ry_array(2 * (size_t)f->half, sizeof(double));
    f->mix = ry_array(nz, sizeof(double));
    f->work = ry_array(5 * nz + 2 * (size_t)f->half + 1, sizeof(double));
    f->bin_top = ry_array((size_t)f->n_bins, sizeof(double));
    f->bin_grain = ry_array((size_t)f->n_bins, sizeof(int32_t));
    if (!f->viscous || !f->face || !f->u || !f->gradient || !f->hinder || !f->sums ||
        !f->work || !f->mix || !f->part || !f->bin_top || !f->bin_grain ||
        (f->walks && (!f->star || !f->reynolds || !f->eddy_x || !f->eddy_z))) {
        return ry_no_memory(error, (n + nz * 20) * sizeof(double));
    }
    for (size_t k = 0; k < n; k++) {
        const double d = 2.0 * g->radius[k];
        f->viscous[k] = f->viscosity / d;
        f->viscous[k] = f->drag == RY_FLOW_DALLAVALLE ? sqrt(24.0 * f->viscous[k]) : f->viscous[k];
    }
    for (int32_t m = 0; m < 2 * f->half; m++) { /* slices of a sphere around a face, from below */
        const double foot = (m - f->half) * f->dz / (0.5 * f->d);
        f->part[m] = ry_slice_below(foot + f->dz / (0.5 * f->d)) - ry_slice_below(foot);
    }
    for (size_t k = 0; k <= nz; k++) {
        f->hinder[k] = 1.0;
    }
    f->valid = f->nz;
    for (int32_t k = 0; f->walks && k < g->n; k++) {
        ry_eddies_meet(f, g, k);
    }
    f->tau_now = state->step > 0 ? ry_flow_stress(f, (state->step - 1) / f->advance * f->advance) : 0.0;
    ry_column_refresh(f, &state->column, 0, ry_column_faces(f));
    return RY_OK;
}

void ry_flow_free(ry_flow *f)
{
    void *const arrays[] = {f->viscous, f->u,       f->gradient,  f->hinder, f->sums, f->mix,
                            f->work,    f->bin_top, f->bin_grain, f->part,   f->face,
                            f->star,    f->reynolds,  f->eddy_x, f->eddy_z};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    ry_resting_free(f);
    *f = (ry_flow){0};
}
