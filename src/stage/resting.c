/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/resting.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "stage/column.h"

ry_status ry_resting_create(ry_flow *f, const ry_grains *g, ry_error *error)
{
    ry_resting *const q = &f->resting;
    const size_t n = (size_t)g->n;
    double largest = 0.0;
    for (size_t k = 0; k < n; k++) {
        largest = g->radius[k] > largest ? g->radius[k] : largest;
    }
    q->changes = -1;
    q->runs = ((int32_t)(2.0 * largest / f->dz) + 1) / RY_SLICES + 1;
    q->volumes = ry_array(ry_column_row_length(f), sizeof *q->volumes);
    q->force = ry_array(n, sizeof *q->force);
    q->slope = ry_array(n, sizeof *q->slope);
    q->imprint = ry_array(n * (size_t)q->runs, sizeof *q->imprint);
    if (!q->volumes || !q->force || !q->slope || !q->imprint) {
        return ry_no_memory(error, n * (size_t)q->runs * sizeof *q->imprint);
    }
    for (size_t m = 0; m < n * (size_t)q->runs; m++) {
        q->imprint[m].z = NAN;
    }
    return RY_OK;
}

void ry_resting_free(ry_flow *f)
{
    ry_resting *const q = &f->resting;
    void *const arrays[] = {q->volumes, q->force, q->slope, q->imprint};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    *q = (ry_resting){0};
}

/* Runs that it does not need are at the foot of the column, and empty. */
RY_INLINE void make_imprint(const ry_flow *f, double z, double r, ry_imprint *runs)
{
    const ry_span span = ry_slice_span(z, r, 1.0 / f->dz, f->nz);
    for (int32_t m = 0; m < f->resting.runs; m++) {
        const int32_t first = span.first + m * RY_SLICES;
        runs[m] = (ry_imprint){.z = z};
        if (first > span.last) {
            continue;
        }
        runs[m].first = first;
        for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
            const ry_slices slices = ry_slice_cut((first * f->dz - z) / r, f->dz / r, four);
            ry_four_store(runs[m].part + 4 * four, slices.part);
        }
    }
}

/* Where a sleeper lies is looked up; those that have just fallen asleep lie elsewhere than the last time. */
RY_CLONES static void sum_volumes(const ry_flow *f, const ry_grains *g, const ry_sets *sets)
{
    const ry_resting *const q = &f->resting;
    memset(q->volumes, 0, ry_column_row_length(f) * sizeof *q->volumes);
    for (int32_t rank = 0; rank < sets->n_asleep; rank++) {
        const int32_t k = sets->asleep[rank];
        ry_imprint *const runs = q->imprint + (size_t)g->id[k] * (size_t)q->runs;
        if (runs->z != g->z[k]) {
            make_imprint(f, g->z[k], g->radius[k], runs);
        }
        for (int32_t m = 0; m < q->runs; m++) {
            for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
                ry_slice_add(q->volumes + runs[m].first + 4 * four,
                             ry_column_volume(g->radius[k]) * ry_four_load(runs[m].part + 4 * four));
            }
        }
    }
}

void ry_resting_update(ry_flow *f, const ry_grains *g, const ry_sets *sets)
{
    if (f->resting.changes != sets->changes && sets->n_asleep > 0) {
        sum_volumes(f, g, sets);
        f->resting.changes = sets->changes;
    }
}

RY_CLONES static void sum_forces(const ry_resting *q, const int32_t *id, const int32_t *asleep, int32_t n,
                                 double *restrict gots, double *restrict forces, double *restrict slopes)
{
    for (int32_t rank = 0; rank < n; rank++) {
        const int32_t k = asleep[rank];
        const ry_imprint *const runs = q->imprint + (size_t)id[k] * (size_t)q->runs;
        const double force = q->force[k], slope = q->slope[k];
        for (int32_t m = 0; m < q->runs; m++) {
            for (int32_t four = 0; four < RY_SLICE_FOURS; four++) {
                const ry_four part = ry_four_load(runs[m].part + 4 * four);
                ry_slice_add(gots + runs[m].first + 4 * four, force * part);
                ry_slice_add(forces + runs[m].first + 4 * four, force * part);
                ry_slice_add(slopes + runs[m].first + 4 * four, slope * part);
            }
        }
    }
}

void ry_resting_sum(const ry_flow *f, const ry_grains *g, const ry_sets *sets, int32_t first, int32_t end,
                    double *gots, double *forces, double *slopes)
{
    sum_forces(&f->resting, g->id, sets->asleep + first, end - first, gots, forces, slopes);
}
