/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/eddies.h"

#include <math.h>

#include "base/parallel.h"
#include "base/random.h"
#include "stage/column.h"

typedef struct ry_eddies_task {
    const ry_flow *flow;
    ry_grains *grains;
    int64_t step;
} ry_eddies_task;

/* [s]; where nothing is sheared for ever, but there eddies have no strength. */
static double lasts(const ry_flow *f, double z)
{
    const ry_spot spot = ry_column_spot(f, z);
    const double shear = fabs(f->u[spot.cell + 1] - f->u[spot.cell]) / f->dz;
    return isnan(f->eddy_time) ? RY_EDDY_TURN / shear : f->eddy_time;
}

void ry_eddies_meet(const ry_flow *f, const ry_grains *g, int32_t k)
{
    double drawn[2] = {0.0, 0.0};
    if (g->met[k] > 0.0) {
        ry_random_normal(f->seed, RY_RANDOM_EDDY, (uint64_t)g->met[k], (uint32_t)g->id[k], drawn);
    }
    f->eddy_z[k] = drawn[0];
    f->eddy_x[k] = drawn[1] - drawn[0];
}

static void renew(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_eddies_task *const t = context;
    const ry_flow *const f = t->flow;
    ry_grains *const g = t->grains;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        const double now = (double)t->step + 1.0, age = (now - g->met[k] + 0.5 * f->advance) * f->dt;
        if (g->met[k] == 0.0 || age >= lasts(f, g->z[k])) {
            g->met[k] = now;
            ry_eddies_meet(f, g, k);
        }
    }
}

void ry_eddies_renew(const ry_flow *f, ry_grains *g, int64_t step)
{
    ry_eddies_task task = {.flow = f, .grains = g, .step = step};
    ry_parallel(f->threads, g->n, renew, &task);
}
