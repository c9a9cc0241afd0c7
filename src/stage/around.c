/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Who is around a grain, by the grid of the last rebuild. */
#include <math.h>

#include "base/memory.h"
#include "stage/neighbor.h"

void ry_neighbor_look(ry_neighbor *b, const ry_grains *g)
{
    const double half = b->periodic ? 0.5 * b->length : INFINITY;
    double most2 = 0.0;
    for (int32_t k = 0; k < g->n; k++) {
        double dx = g->x[k] - b->x0[k];
        dx -= dx > half ? b->length : (dx < -half ? -b->length : 0.0);
        const double dz = g->z[k] - b->z0[k], way2 = dx * dx + dz * dz;
        most2 = way2 > most2 ? way2 : most2;
    }
    b->strayed = sqrt(most2);
}

/* Appends the grains of a cell that are near k. */
static size_t near_in_cell(const ry_neighbor *b, const ry_grains *g, int32_t k, int32_t cell, double gap, int32_t *out,
                           size_t n)
{
    const double half = b->periodic ? 0.5 * b->length : INFINITY;
    for (int32_t m = b->cell_start[cell]; m < b->cell_start[cell + 1]; m++) {
        const int32_t j = b->member[m];
        double dx = g->x[j] - g->x[k];
        dx -= dx > half ? b->length : (dx < -half ? -b->length : 0.0);
        const double dz = g->z[j] - g->z[k], far = g->radius[j] + g->radius[k] + gap;
        out[n] = j;
        n += dx * dx + dz * dz < far * far;
    }
    return n;
}

ry_status ry_neighbor_around(ry_neighbor *b, const ry_grains *g, int32_t k, double gap, const int32_t **near,
                             int32_t *n_near, ry_error *error)
{
    struct ry_found *const found = &b->found[0];
    const double reach = 2.0 * b->radius_max + gap + b->strayed;
    const int32_t cell_of = ry_neighbor_cell(b, g, k), column = cell_of / b->rows, row = cell_of % b->rows;
    const int32_t wide = (int32_t)ceil(fmin(reach / b->cell_x, b->columns));
    const int32_t high = (int32_t)ceil(fmin(reach / b->cell_z, b->rows));
    const int all = 2 * wide + 1 >= b->columns;
    const int32_t first = all ? 0 : column - wide, last = all ? b->columns - 1 : column + wide;
    size_t n = 0;
    for (int32_t c = first; c <= last; c++) {
        const int32_t wrapped = c < 0 ? c + b->columns : (c >= b->columns ? c - b->columns : c);
        if (wrapped != c && !b->periodic) {
            continue;
        }
        for (int32_t r = row - high < 0 ? 0 : row - high; r <= row + high && r < b->rows; r++) {
            const int32_t cell = wrapped * b->rows + r;
            const size_t more = (size_t)(b->cell_start[cell + 1] - b->cell_start[cell]);
            RY_TRY(ry_array_grow(&found->near, &found->room, n, n + more, sizeof *found->near, error));
            n = near_in_cell(b, g, k, cell, gap, found->near, n);
        }
    }
    ry_sort_by_id(found->near, n, g->id);
    *near = found->near;
    *n_near = (int32_t)n;
    return RY_OK;
}
