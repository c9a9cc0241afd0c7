/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What stage/neighbor.c asks of stage/grid.c. */
#ifndef RY_STAGE_NEIGHBOR_PRIVATE_H
#define RY_STAGE_NEIGHBOR_PRIVATE_H

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "stage/neighbor.h"

/* Vectors of members and partners may be read, partners written, beyond the last. */
enum { RY_SPARE = 16 };

/* No grain is listed further out than this beyond the limit at which the list is made anew: rounding. */
#define RY_NEARLY_ONE 0.999

/* The reach of a grain beyond its centre: its radius, and how far it may go. */
RY_INLINE double ry_neighbor_reach(const ry_neighbor *b, const ry_grains *g, int32_t k)
{
    return g->radius[k] + sqrt((double)b->limit2[k] * (1.0 / RY_NEARLY_ONE));
}

/* A reach that rounding makes no shorter: each of two grains is half a unit of the raster off at most along x and along
 * z, and the arithmetic of near_in_run less than 1e-6. */
RY_INLINE double ry_neighbor_safe(const ry_neighbor *b, double reach)
{
    return reach * (1.0 + 1e-6) + b->raster.margin;
}

/* ---- a stretch of grains, as the grid sees them ---------------------------------------------- */

enum { RY_STRETCH = 64 };
typedef struct ry_seen {
    _Alignas(RY_ALIGNMENT) int32_t column[RY_STRETCH], row[RY_STRETCH];
    uint32_t x[RY_STRETCH], z[RY_STRETCH];
    float reach[RY_STRETCH];
    int32_t first[RY_STRETCH], last[RY_STRETCH], low[RY_STRETCH], high[RY_STRETCH]; /* see ry_window */
} ry_seen;

/* u within bounds; what is no number is at the lower. */
RY_INLINE double ry_within(double u, double low, double high)
{
    return u > low ? (u < high ? u : high) : low;
}

/* The cell at a place, of n; the nearest of anything outside. */
RY_INLINE int32_t ry_grid_clamp(double place, int32_t n)
{
    const double inside = place > 0.0 ? (place < 2e9 ? place : 2e9) : 0.0;
    const int32_t cell = (int32_t)inside;
    return cell < n ? cell : n - 1;
}

/* The nearest whole number to 0 <= u <= 2^32, which wraps to 0; of anything else the nearest bound. */
RY_INLINE uint32_t ry_raster_number(double u, double most)
{
    const double shifted = (u > 0.0 ? (u < most ? u : most) : 0.0) + 0x1p52;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return (uint32_t)bits;
}

/* Who is nowhere (not a number) is near nobody. */
RY_INLINE void ry_neighbor_look_at(const ry_neighbor *b, const ry_grains *g, int32_t begin, int32_t n, ry_seen *seen)
{
    const double *const x = g->x + begin, *const z = g->z + begin;
    const ry_raster in = b->raster;
    const ry_grid grid = b->grid;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double reach = ry_neighbor_safe(b, ry_neighbor_reach(b, g, begin + k));
        const double at_x = ry_within(x[k], grid.box.left, grid.box.right);
        const double at_z = ry_within(z[k], grid.box.bottom, grid.box.top);
        seen->column[k] = ry_grid_clamp((at_x - grid.box.left) * grid.per_x, grid.columns);
        seen->row[k] = ry_grid_clamp((at_z - grid.box.bottom) * grid.per_z, grid.rows);
        seen->x[k] = ry_raster_number(at_x * in.per_x + in.zero_x, in.most_x);
        seen->z[k] = ry_raster_number(at_z * in.per_z + 0x1p30, 0x1p31);
        seen->reach[k] = (float)(reach + (x[k] - x[k]) + (z[k] - z[k]));
    }
}

/* Columns first .. last of the grid, which may have to be wrapped, and rows low .. high of them. */
typedef struct ry_window {
    int32_t first, last, low, high;
} ry_window;

/* Where those lie that are nearer than `reach` along x and along z. Conversion cuts towards 0, so all is made positive
 * before. */
RY_INLINE ry_window ry_grid_window(const ry_grid *grid, int periodic, double to_x, double to_z, double reach)
{
    const ry_bounds box = grid->box;
    const double x = ry_within(to_x, box.left, box.right), z = ry_within(to_z, box.bottom, box.top);
    const double columns = grid->columns, rows = grid->rows;
    const double least = periodic ? -columns : 0.0, most = periodic ? 2.0 * columns : columns;
    const double left = (x - reach - box.left) * grid->per_x, right = (x + reach - box.left) * grid->per_x;
    const double below = (z - reach - box.bottom) * grid->per_z, above = (z + reach - box.bottom) * grid->per_z;
    const int32_t first = (int32_t)(ry_within(left, least, most - 1.0) - least) + (int32_t)least;
    const int32_t last = (int32_t)(ry_within(right + 1.0, least, most) - least) + (int32_t)least - 1;
    const int32_t low = (int32_t)ry_within(below, 0.0, rows - 1.0);
    const int32_t high = (int32_t)ry_within(above + 1.0, 0.0, rows) - 1;
    const int all = last - first >= grid->columns - 1;
    return (ry_window){.first = all ? 0 : first, .last = all ? grid->columns - 1 : last, .low = low, .high = high};
}

/* First cell of a column of a window. */
RY_INLINE int32_t ry_grid_column(const ry_grid *grid, int32_t column)
{
    const int32_t over = column < 0 ? -grid->columns : (column >= grid->columns ? grid->columns : 0);
    return (column - over) * grid->rows;
}

/* Where their partners lie. */
RY_INLINE void ry_neighbor_look_around(const ry_neighbor *b, const ry_grains *g, int32_t begin, int32_t n,
                                       ry_seen *seen)
{
    const double *const x = g->x + begin, *const z = g->z + begin;
    const ry_grid grid = b->grid;
    const int periodic = b->periodic;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const ry_window in = ry_grid_window(&grid, periodic, x[k], z[k], grid.reach + (double)seen->reach[k]);
        seen->first[k] = in.first;
        seen->last[k] = in.last;
        seen->low[k] = in.low;
        seen->high[k] = in.high;
    }
}

/* ---- the parts of a rebuild ------------------------------------------------------------------ */

/* Sets how far each grain may go, and the cells that follow from it. */
ry_status ry_grid_lay(ry_neighbor *neighbor, const ry_grains *grains, ry_error *error);

/* Sorts the grains by cell. `scratch`: of so many bytes, in use until they are found. */
RY_INLINE size_t ry_grid_scratch(int32_t n)
{
    return 4 * ((size_t)n + RY_SPARE) * sizeof(float);
}

void ry_grid_fill(ry_neighbor *neighbor, const ry_grains *grains, void *scratch);

/* Fills the parts of `found`, and the number of partners of each grain: row, those it owns, below_start, the others.
 * Returns 0 if there is no memory. */
int ry_partners_find(ry_neighbor *neighbor, const ry_grains *grains, ry_pairs *pairs);

/* With the list in place, for the grains begin .. end-1: the owner of each pair; and for each grain the slots in which
 * it is the partner, in place of their owners, whose ids ascend. A ry_range_fn; `context`: the pairs. */
void ry_partners_link(void *context, int32_t begin, int32_t end, int thread);

#endif
