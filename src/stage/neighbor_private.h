/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What stage/neighbor.c asks of stage/grid.c. */
#ifndef RY_STAGE_NEIGHBOR_PRIVATE_H
#define RY_STAGE_NEIGHBOR_PRIVATE_H

#include <math.h>

#include "base/parallel.h"
#include "stage/neighbor.h"

/* Vectors of members may be read, partners written, beyond the last. */
enum { RY_SPARE = 4 };

/* No grain is listed further out than this beyond the limit at which the list is made anew: rounding. */
#define RY_NEARLY_ONE 0.999

/* The reach of a grain beyond its centre: its radius, and how far it may go. */
RY_INLINE double ry_neighbor_reach(const ry_neighbor *b, const ry_grains *g, int32_t k)
{
    return g->radius[k] + sqrt(b->limit2[k] * (1.0 / RY_NEARLY_ONE));
}

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
int ry_grid_find(ry_neighbor *neighbor, const ry_grains *grains, ry_pairs *pairs);

#endif
