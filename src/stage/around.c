/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Who is around a grain, by the grid of the last rebuild. */
#include <math.h>

#include "base/memory.h"
#include "stage/neighbor_private.h"

double ry_neighbor_strayed(const ry_neighbor *b, const ry_grains *g)
{
    const double half = b->periodic ? 0.5 * b->length : INFINITY;
    double most2 = 0.0;
    for (int32_t k = 0; k < g->n; k++) {
        const double dx = ry_nearest(g->x[k] - b->x0[k], b->length, half);
        const double dz = g->z[k] - b->z0[k], way2 = dx * dx + dz * dz;
        most2 = way2 > most2 ? way2 : most2;
    }
    return sqrt(most2);
}

/* Appends those of the members from .. to-1 that are near k. */
static size_t near_in_run(const ry_neighbor *b, const ry_grains *g, int32_t k, int32_t from, int32_t to, double gap,
                          int32_t *out, size_t n)
{
    const double half = b->periodic ? 0.5 * b->length : INFINITY;
    for (int32_t m = from; m < to; m++) {
        const int32_t j = b->member[m];
        const double dx = ry_nearest(g->x[j] - g->x[k], b->length, half);
        const double dz = g->z[j] - g->z[k], far = g->radius[j] + g->radius[k] + gap;
        out[n] = j;
        n += dx * dx + dz * dz < far * far;
    }
    return n;
}

ry_status ry_neighbor_around(ry_neighbor *b, const ry_grains *g, int32_t k, double gap, double strayed,
                             const int32_t **near, int32_t *n_near, ry_error *error)
{
    struct ry_found *const found = &b->found[0];
    const double reach = ry_neighbor_safe(b, g->radius[k] + b->radius_max + gap + strayed);
    const ry_window in = ry_grid_window(&b->grid, b->periodic, g->x[k], g->z[k], reach);
    size_t n = 0;
    for (int32_t c = in.first; c <= in.last && in.low <= in.high; c++) {
        const int32_t *const start = b->cell_start + ry_grid_column(&b->grid, c);
        const int32_t from = start[in.low], to = start[in.high + 1];
        RY_TRY(ry_array_grow(&found->near, &found->room, n, n + (size_t)(to - from), sizeof *found->near, error));
        n = near_in_run(b, g, k, from, to, gap, found->near, n);
    }
    ry_sort_by_id(found->near, n, g->id);
    *near = found->near;
    *n_near = (int32_t)n;
    return RY_OK;
}
