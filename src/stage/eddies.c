/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/eddies.h"

#include <math.h>

#include "base/parallel.h"
#include "base/random.h"
#include "stage/column.h"

typedef struct ry_eddies_task {
    const ry_flow *flow;
    const ry_grains *grains;
    int64_t step;
} ry_eddies_task;

/* [s]; where nothing is sheared for ever, but there eddies have no strength. */
static double lasts(const ry_flow *f, double z)
{
    const ry_spot spot = ry_column_spot(f, z);
    const double shear = fabs(f->u[spot.cell + 1] - f->u[spot.cell]) / f->dz;
    return isnan(f->eddy_time) ? RY_EDDY_TURN / shear : f->eddy_time;
}

static void renew(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_eddies_task *const t = context;
    const ry_eddies *const e = t->flow->eddies;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        const double age = ((double)t->step - e->born[k] + 0.5 * t->flow->advance) * t->flow->dt;
        if (e->born[k] < 0.0 || age >= lasts(t->flow, t->grains->z[k])) {
            double drawn[2];
            ry_random_normal(t->flow->seed, RY_RANDOM_EDDY, (uint64_t)t->step, (uint32_t)t->grains->id[k], drawn);
            e->up[k] = drawn[0];
            e->along[k] = drawn[1] - drawn[0];
            e->born[k] = (double)t->step;
        }
    }
}

void ry_eddies_renew(const ry_flow *f, const ry_grains *g, int64_t step)
{
    ry_eddies_task task = {.flow = f, .grains = g, .step = step};
    ry_parallel(f->threads, g->n, renew, &task);
}
