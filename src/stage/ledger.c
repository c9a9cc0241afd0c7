/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/ledger.h"

#include <math.h>

/* Of a grain, or of one against another [m/s]. */
typedef struct ry_velocity {
    double x, z;
} ry_velocity;

/* Of a grain, or a wall, over this step. */
static ry_velocity mean_of(const ry_motion *m, const ry_grains *g, int32_t k)
{
    return k >= m->n_awake ? /* walls and sleepers */ (ry_velocity){0.0, 0.0}
                     : (ry_velocity){g->vx[k] + 0.5 * (m->cx[k] * m->im[k] + m->gx[k]),
                                     g->vz[k] + 0.5 * (m->cz[k] * m->im[k] + m->gz[k])};
}

/* Loss of an impact: the work of its force less what its spring holds of it, before the step and after
 * the drift that follows. Gravity towards an immovable partner, which the law balances over the drift of
 * a touching grain, w' dt, works over the mean: the difference belongs to the law. Zero (rounding) but in
 * the closing step for a pair alone. */
static double lose_in_impact(const ry_contact *c, const ry_motion *m, const ry_grains *g, const ry_pairs *pairs,
                             int32_t p, double impulse, double before_step)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double nx = pairs->t_nx[p], nz = pairs->t_nz[p];
    const double dt = c->dt, ims = c->im[i] + c->im[j];
    const ry_velocity mean_i = mean_of(m, g, i), mean_j = mean_of(m, g, j);
    const ry_velocity meet = {mean_i.x - mean_j.x, mean_i.z - mean_j.z}; /* approach: the mean, and after the step */
    const ry_velocity then = {2.0 * meet.x - (g->vx[i] - g->vx[j]), 2.0 * meet.z - (g->vz[i] - g->vz[j])};
    const double mean = meet.x * nx + meet.z * nz, after = then.x * nx + then.z * nz;
    const ry_gap gap = ry_contact_gap(c, g, pairs, p);
    const double x = gap.dx - then.x * dt, z = gap.dz - then.z * dt;
    const double distance = j < pairs->n_grains ? sqrt(x * x + z * z) : gap.distance - after * dt;
    const double overlap = g->radius[i] + g->radius[j] - distance;
    const double stretch = ry_max(overlap - pairs->rest[p], 0.0);
    const double held = 0.5 * ry_contact_bond(c, pairs, p).a * stretch * stretch / (ims * dt * dt);
    const double side = (double)ry_contact_rests(c, pairs, i) - (double)ry_contact_rests(c, pairs, j);
    const double fall = impulse != 0.0 ? c->coef.g_dt2 * nz * side : 0.0;
    return -impulse * mean - (held - before_step) - fall * (mean - after) / (ims * dt);
}

void ry_ledger_impacts(const ry_contact *c, const ry_motion *m, const ry_grains *g, const ry_pairs *pairs,
                       int32_t first, int32_t end, int chunk)
{
    const ry_entries young = ry_pairs_young(pairs, first, end, chunk);
    for (int32_t y = young.begin; y < young.end; y++) {
        if (pairs->young_en[y] >= 0.0) {
            const double lost = lose_in_impact(c, m, g, pairs, pairs->young[y], pairs->young_jn[y], pairs->young_en[y]);
            ry_exact_add(&c->books[chunk].loss_impact, c->scale, &lost, 1);
        }
    }
}
