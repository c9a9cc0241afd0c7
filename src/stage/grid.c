/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The grid is numbered column by column, so that what a grain must look at of a column is one run of `member`. */
#include <string.h>

#include "base/memory.h"
#include "stage/neighbor_private.h"

/* Sizes of a cell in reaches of the furthest grain: a pair reaches two of them. */
#define CELL_WIDTH 4.0
#define CELL_HEIGHT 1.0
#define FURTHEST 16.0 /* radii of the largest */

/* ---- the grid ------------------------------------------------------------------------------- */

/* How far each grain may go before the list is made anew: fast grains further, so that the few of them don't
 * make the list short-lived, or long, for all. And never less than a step takes it: grains that touched in the last
 * step stay a pair in this one, in which their law lets them go. Nobody goes further than FURTHEST in a step of a run
 * that is to go on. Returns the furthest. */
RY_CLONES static double set_limits(ry_neighbor *b, const ry_grains *g)
{
    const double *const vx = g->vx, *const vz = g->vz;
    float *restrict const limit2 = b->limit2;
    const double least = b->skin_least, most = b->skin_most, ahead = b->horizon;
    const double two_steps = 2.0 * b->step, cap = FURTHEST * b->radius_max;
    double furthest = 0.0;
#pragma omp simd reduction(max : furthest)
    for (int32_t k = 0; k < g->n; k++) {
        const double speed = sqrt(vx[k] * vx[k] + vz[k] * vz[k]);
        const double way = least + ahead * speed, jump = least + two_steps * speed; /* twice: it may have slowed down */
        const double once = jump < cap ? jump : cap, often = way < most ? way : most;
        const double s = once > often ? once : often;
        limit2[k] = (float)(RY_NEARLY_ONE * s * s);
        furthest = s > furthest ? s : furthest;
    }
    return furthest;
}

RY_CLONES static ry_bounds bounds_of(const ry_grains *g)
{
    double left = INFINITY, right = -INFINITY, bottom = INFINITY, top = -INFINITY;
    const double *const x = g->x, *const z = g->z;
#pragma omp simd reduction(min : left, bottom) reduction(max : right, top)
    for (int32_t k = 0; k < g->n; k++) {
        left = x[k] < left ? x[k] : left;
        right = x[k] > right ? x[k] : right;
        bottom = z[k] < bottom ? z[k] : bottom;
        top = z[k] > top ? z[k] : top;
    }
    return (ry_bounds){left, right, bottom, top};
}

/* The box that the grid covers, which is never so large that numbers fail. Who is outside, for an instant of a run that
 * breaks down, counts as being at its edge, for all that look for one another alike: all go closer together by that. */
static ry_bounds lay_box(const ry_neighbor *b, ry_bounds in, double pair)
{
    const double most = 0x1p20 * pair;
    ry_bounds box = {ry_within(in.left, -most, most), ry_within(in.right, -most, most),
                     ry_within(in.bottom, -most, most), ry_within(in.top, -most, most)};
    if (b->periodic) {
        box.left = 0.0;
        box.right = b->length;
    }
    return box;
}

/* Positions in the box as whole numbers that wrap where x does. Where it does not, zero is in the middle. */
static ry_raster lay_raster(const ry_neighbor *b, ry_bounds in, double pair)
{
    const double whole = 0x1p32, half = 0x1p31;
    const double wide = fmax(fmax(fabs(in.left), fabs(in.right)), pair);
    const double high = fmax(fmax(fabs(in.bottom), fabs(in.top)), pair);
    ry_raster raster = {.per_x = b->periodic ? whole / b->length : 0.5 * half / wide, .per_z = 0.5 * half / high,
                        .zero_x = b->periodic ? 0.0 : 0.5 * half, .most_x = b->periodic ? whole : half};
    raster.x = (float)(1.0 / raster.per_x);
    raster.z = (float)(1.0 / raster.per_z);
    raster.margin = 1.0 / raster.per_x + 1.0 / raster.per_z;
    return raster;
}

/* Larger cells where the grains lie so far apart that cells would outnumber them. */
static ry_status lay_cells(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    const double reach = b->radius_max + set_limits(b, g), cell_x = CELL_WIDTH * reach, cell_z = CELL_HEIGHT * reach;
    const ry_bounds in = lay_box(b, bounds_of(g), 2.0 * reach);
    b->raster = lay_raster(b, in, 2.0 * reach);
    const double most = 4096.0 + 2.0 * (double)g->n;
    const double width = in.right - in.left, height = in.top - in.bottom;
    double columns = fmax(1.0, floor(width / cell_x)), rows = fmax(1.0, floor(height / cell_z) + 1.0);
    if (columns * rows > most) { /* first thin out rows, then columns */
        rows = fmax(1.0, fmin(rows, floor(most / columns)));
        columns = fmax(1.0, fmin(columns, floor(most / rows)));
    }
    b->grid = (ry_grid){.reach = ry_neighbor_safe(b, reach), .box = in,
                        .per_x = 1.0 / (b->periodic ? width / columns : fmax(width / columns, cell_x)),
                        .per_z = 1.0 / fmax(height / rows, cell_z), .columns = (int32_t)columns, .rows = (int32_t)rows};
    return ry_array_grow(&b->cell_start, &b->n_cells_room, 0, (size_t)b->grid.columns * (size_t)b->grid.rows + 1,
                         sizeof *b->cell_start, error);
}

RY_CLONES static void count_members(const ry_neighbor *b, const ry_grains *g, int32_t *count)
{
    ry_seen seen;
    const int32_t rows = b->grid.rows;
    for (int32_t begin = 0; begin < g->n; begin += RY_STRETCH) {
        const int32_t n = g->n - begin < RY_STRETCH ? g->n - begin : RY_STRETCH;
        ry_neighbor_look_at(b, g, begin, n, &seen);
        for (int32_t k = 0; k < n; k++) {
            count[seen.column[k] * rows + seen.row[k]]++;
        }
    }
}

RY_CLONES static void place_members(const ry_neighbor *b, const ry_grains *g, int32_t *next)
{
    ry_seen seen;
    const int32_t rows = b->grid.rows;
    for (int32_t begin = 0; begin < g->n; begin += RY_STRETCH) {
        const int32_t n = g->n - begin < RY_STRETCH ? g->n - begin : RY_STRETCH;
        ry_neighbor_look_at(b, g, begin, n, &seen);
        for (int32_t k = 0; k < n; k++) {
            const int32_t m = next[seen.column[k] * rows + seen.row[k]]++;
            b->member[m] = begin + k;
            b->member_x[m] = seen.x[k];
            b->member_z[m] = seen.z[k];
            b->member_reach[m] = seen.reach[k];
        }
    }
}

/* A counting sort. */
void ry_grid_fill(ry_neighbor *b, const ry_grains *g, void *scratch)
{
    const int32_t n_cells = b->grid.columns * b->grid.rows;
    b->member_x = scratch;
    b->member_z = b->member_x + g->n + RY_SPARE;
    b->member_reach = (float *)(b->member_z + g->n + RY_SPARE);
    b->member = b->own_member != NULL ? b->own_member : (int32_t *)(b->member_reach + g->n + RY_SPARE);
    memset(b->cell_start, 0, ((size_t)n_cells + 1) * sizeof *b->cell_start);
    count_members(b, g, b->cell_start);
    int32_t sum = 0;
    for (int32_t c = 0; c <= n_cells; c++) {
        const int32_t count = c < n_cells ? b->cell_start[c] : 0;
        b->cell_start[c] = sum;
        sum += count;
    }
    place_members(b, g, b->cell_start);
    memmove(b->cell_start + 1, b->cell_start, (size_t)n_cells * sizeof *b->cell_start);
    b->cell_start[0] = 0;
}

/* ---- who is near somebody awake --------------------------------------------------------------- */

RY_CLONES static void mark_busy(ry_neighbor *b, const ry_grains *g)
{
    ry_seen seen;
    for (int32_t begin = 0; begin < g->n; begin += RY_STRETCH) {
        const int32_t n = g->n - begin < RY_STRETCH ? g->n - begin : RY_STRETCH;
        ry_neighbor_look_at(b, g, begin, n, &seen);
        ry_neighbor_look_around(b, g, begin, n, &seen);
        for (int32_t k = 0; k < n; k++) {
            const int rows = seen.high[k] - seen.low[k] + 1;
            for (int32_t c = seen.first[k]; c <= seen.last[k] && rows > 0 && !b->still[begin + k]; c++) {
                memset(b->busy + ry_grid_column(&b->grid, c) + seen.low[k], 1, (size_t)rows);
            }
        }
    }
}

ry_status ry_grid_lay(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    RY_TRY(lay_cells(b, g, error));
    if (!b->has_sleepers) {
        return RY_OK;
    }
    if (b->own_member == NULL && (b->own_member = ry_array((size_t)g->n + RY_SPARE, sizeof(int32_t))) == NULL) {
        return ry_no_memory(error, (size_t)g->n * sizeof(int32_t));
    }
    const size_t n_cells = (size_t)b->grid.columns * (size_t)b->grid.rows;
    RY_TRY(ry_array_grow(&b->busy, &b->n_busy_room, 0, n_cells, 1, error));
    memset(b->busy, 0, n_cells);
    mark_busy(b, g);
    return RY_OK;
}
