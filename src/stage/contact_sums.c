/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the contacts hold, and how deep they are. */
#include <math.h>

#include "stage/contact.h"

/* As ry_contact_tangential. Laws whose closing step replaces the overlap hold no energy in a contact before it. */
static double normal_energy(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p,
                            ry_gap gap, double a)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double rest = pairs->rest != NULL ? pairs->rest[p] : 0.0;
    const double stretch = ry_max(g->radius[i] + g->radius[j] - gap.distance - rest, 0.0);
    const double root = c->coef.hertz > 0.0 ? sqrt(stretch) : 1.0;
    const double power = c->coef.hertz > 0.0 ? 0.4 : 0.5; /* int a d^1.5, int a d */
    const double run = ((g->vx[i] - g->vx[j]) * gap.dx + (g->vz[i] - g->vz[j]) * gap.dz) / gap.distance * c->dt;
    const double half = c->explicit_spring && !ry_contact_in_impact(c, pairs, p) ? 0.5 * run : 0.0;
    return a * root * stretch * (power * stretch - half) / ((c->im[i] + c->im[j]) * c->dt * c->dt);
}

ry_contact_depth ry_contact_deepest(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs)
{
    ry_contact_depth most = {0.0, -1};
    for (int32_t p = 0; p < pairs->n; p++) {
        if (pairs->age[p] != 0) {
            const int32_t i = pairs->i[p], j = pairs->j[p];
            const double overlap = g->radius[i] + g->radius[j] - ry_contact_gap(c, g, pairs, p).distance;
            const double smaller = j < g->n ? ry_min(g->radius[i], g->radius[j]) : g->radius[i];
            if (overlap > most.overlap * smaller) {
                most = (ry_contact_depth){overlap / smaller, i};
            }
        }
    }
    return most;
}

static void measure_pair(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p,
                         ry_contact_sums *sums)
{
    const ry_gap gap = ry_contact_gap(c, g, pairs, p);
    const ry_bond q = ry_contact_bond(c, pairs, p);
    sums->touching++;
    sums->elastic_normal += normal_energy(c, g, pairs, p, gap, q.a);
    if (c->features & RY_CONTACT_FRICTION) {
        sums->elastic_tangential += ry_contact_tangential(c, g, pairs, p, gap, q.stretch);
    }
}

ry_contact_sums ry_contact_measure_run(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs)
{
    ry_contact_sums sums = {0};
    for (int32_t p = 0; p < pairs->n; p++) {
        measure_pair(c, g, pairs, p, &sums);
    }
    return sums;
}

/* Sums run over the owners in ascending id, so that they don't depend on the list. */
ry_contact_sums ry_contact_measure(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs)
{
    ry_contact_sums sums = {0};
    for (int32_t id = 0; id < g->n; id++) {
        const int32_t k = pairs->place[id];
        const int32_t own = pairs->row[k + 1] - pairs->row[k];
        for (int32_t m = 0; m < own + c->n_walls; m++) {
            const int32_t p = m < own ? pairs->row[k] + m : pairs->wall_slot[m - own][k];
            if (p >= 0 && pairs->age[p] != 0) {
                measure_pair(c, g, pairs, p, &sums);
            }
        }
    }
    return sums;
}
