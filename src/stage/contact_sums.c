/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the contacts hold, and how deep they are. */
#include <math.h>

#include "stage/contact_private.h"

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

/* ---- what they hold --------------------------------------------------------------------------- */

/* Pairs whose energies are found together: of grains, or of a grain and a wall. */
typedef struct ry_batch {
    ry_near near;
    _Alignas(RY_ALIGNMENT) double a[RY_CONTACT_BLOCK]; /* as in ry_bond, where they are kept */
    double stretch[RY_CONTACT_BLOCK];
    double normal[RY_CONTACT_BLOCK], tangential[RY_CONTACT_BLOCK]; /* [J] */
} ry_batch;

/* See ry_contact_tangential, whose number the tangential one is. Laws whose closing step replaces the overlap hold no
 * energy in a contact before it. */
RY_INLINE void find_energies(const ry_contact *c, ry_batch *b, const int kept, const int hertz)
{
    const ry_near *const near = &b->near;
    const double dt = c->dt;
    const ry_law_coef coef = c->coef;
    const double impact = c->young != NULL ? RY_IMPACT_STEPS : 0.0; /* who touches has an age of 1 or more */
    const double explicit_half = c->explicit_spring ? 0.5 : 0.0;
#pragma omp simd
    for (int32_t k = 0; k < near->n_padded; k++) {
        const double distance = near->distance[k], radii = near->radii[k], ims = near->im[k], tms = near->tm[k];
        ry_bond q = {.a = b->a[k], .stretch = b->stretch[k]};
        if (!kept) {
            q = ry_bond_make(&coef, ims, tms);
        }
        const int impacts = near->age[k] <= impact;
        /* Hertz: int a d^1.5, else int a d */
        const double stretch = ry_max(radii - distance - near->rest[k], 0.0);
        const double root = hertz ? sqrt(stretch) : 1.0, power = hertz ? 0.4 : 0.5;
        const double closing = -(near->dvx[k] * near->dx[k] + near->dvz[k] * near->dz[k]) / distance * dt;
        const double half = explicit_half * closing;
        const double ux = -near->dvx[k] * dt, uz = -near->dvz[k] * dt;
        const double then = ry_contact_then(near->dx[k], near->dz[k], distance, ux, uz, near->bend[k] > 0.0);
        const double paid = ry_impact_holds(q.a, radii - distance, near->rest[k], near->slip[k], then);
        const double spring = q.a * root * stretch * (power * stretch - half);
        b->normal[k] = (impacts ? paid : spring) / (ims * dt * dt);

        const double nx = near->dx[k] / distance, nz = near->dz[k] / distance, lever = distance / radii;
        const double run = (near->dvz[k] * nx - near->dvx[k] * nz + near->turn[k] * lever) * dt;
        const double slip = near->slip[k] + run;
        const double energy = ry_spring_energy(q.stretch, slip, run);
        b->tangential[k] = impacts ? 0.0 : energy / (tms * dt * dt);
    }
}

RY_CLONES static void find_energies_kept(const ry_contact *c, ry_batch *b)
{
    find_energies(c, b, 1, 0);
}

RY_CLONES static void find_energies_made(const ry_contact *c, ry_batch *b)
{
    find_energies(c, b, 0, 0);
}

RY_CLONES static void find_energies_hertz(const ry_contact *c, ry_batch *b)
{
    find_energies(c, b, 0, 1);
}

/* Of the pairs in near->list[0]; the last is repeated to fill the vectors. */
static void fetch_batch(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int kept, ry_batch *b)
{
    ry_near *const near = &b->near;
    near->n_padded = ry_pairs_fill(near->n);
    near->i = near->list[1];
    near->j = near->list[2];
    near->slip = near->spare[0];
    near->rest = near->spare[1];
    for (int32_t k = 0; k < near->n_padded; k++) {
        const int32_t p = near->list[0][k < near->n ? k : near->n - 1];
        near->list[1][k] = pairs->i[p];
        near->list[2][k] = pairs->j[p];
        near->age[k] = pairs->age[p];
        near->slip[k] = pairs->slip[p];
        near->rest[k] = pairs->rest != NULL ? pairs->rest[p] : 0.0;
        b->a[k] = kept ? pairs->b_a[p] : 0.0;
        b->stretch[k] = kept ? pairs->b_stretch[p] : 0.0;
        near->bend[k] = near->j[k] < g->n; /* whether its line of centres turns */
    }
    ry_contact_fetch_geometry(c, g, near);
}

static void measure_batch(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, ry_batch *b,
                          ry_contact_sums *sums)
{
    const int kept = pairs->b_a != NULL && pairs->bonds_made, hertz = c->coef.hertz > 0.0;
    if (b->near.n > 0) {
        fetch_batch(c, g, pairs, kept && !hertz, b);
        (hertz ? find_energies_hertz : kept ? find_energies_kept : find_energies_made)(c, b);
    }
    for (int32_t k = 0; k < b->near.n; k++) {
        sums->elastic_normal += b->normal[k];
        if (c->features & RY_CONTACT_FRICTION) {
            sums->elastic_tangential += b->tangential[k];
        }
    }
    sums->touching += b->near.n;
    b->near.n = 0;
}

static void measure_one(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p, ry_batch *b,
                        ry_contact_sums *sums)
{
    measure_batch(c, g, pairs, b, sums); /* those before it */
    b->near.list[0][0] = p;
    b->near.n = 1;
    measure_batch(c, g, pairs, b, sums);
}

ry_contact_sums ry_contact_measure_run(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs)
{
    ry_contact_sums sums = {0};
    ry_batch batch;
    batch.near.n = 0;
    for (int32_t p = 0; p < pairs->n; p++) {
        measure_one(c, g, pairs, p, &batch, &sums);
    }
    return sums;
}

/* Sums run over the owners in ascending id, so that they don't depend on the list. */
ry_contact_sums ry_contact_measure(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs)
{
    ry_contact_sums sums = {0};
    ry_batch batch;
    batch.near.n = 0;
    for (int32_t id = 0; id < g->n; id++) {
        const int32_t k = pairs->place[id];
        for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
            batch.near.list[0][batch.near.n] = p;
            batch.near.n += pairs->age[p] != 0;
            if (batch.near.n == RY_CONTACT_BLOCK) {
                measure_batch(c, g, pairs, &batch, &sums);
            }
        }
        for (int w = 0; w < c->n_walls; w++) {
            const int32_t p = pairs->wall_slot[w][k];
            if (p >= 0 && pairs->age[p] != 0) {
                measure_one(c, g, pairs, p, &batch, &sums);
            }
        }
    }
    measure_batch(c, g, pairs, &batch, &sums);
    return sums;
}
