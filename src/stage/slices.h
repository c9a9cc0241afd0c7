/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * How a sphere's volume is spread over the cells of the column: the exact slice volumes. */
#ifndef RY_STAGE_SLICES_H
#define RY_STAGE_SLICES_H

#include <math.h>
#include <stdint.h>

#include "base/parallel.h"

/* Part of a sphere that lies below t radii above its centre, -1 <= t <= 1 beyond which it is 0 or 1. */
RY_INLINE double ry_slice_below(double t)
{
    const double c = t < -1.0 ? -1.0 : (t > 1.0 ? 1.0 : t);
    return 0.25 * (2.0 + c * (3.0 - c * c));
}

/* Parts of a sphere in the RY_SLICES cells from `first` on; cells beyond the sphere get 0. `t`: the
 * foot of the first cell in radii above the centre, `step`: the height of a cell in radii. */
enum { RY_SLICES = 8 };
RY_INLINE void ry_slice_parts(double t, double step, double *parts)
{
    double below[RY_SLICES + 1];
    for (int32_t k = 0; k <= RY_SLICES; k++) {
        below[k] = ry_slice_below(t + k * step);
    }
    for (int32_t k = 0; k < RY_SLICES; k++) {
        parts[k] = below[k + 1] - below[k];
    }
}

/* Cells first .. last of a column of nz cells that a sphere reaches; first > last: none. */
typedef struct ry_span {
    int32_t first, last;
} ry_span;
RY_INLINE ry_span ry_slice_span(double z, double radius, double per_dz, int32_t nz)
{
    const double low = floor((z - radius) * per_dz), high = floor((z + radius) * per_dz);
    ry_span span;
    span.first = low > 0.0 ? (low < nz ? (int32_t)low : nz) : 0;
    span.last = high < nz ? (high >= 0.0 ? (int32_t)high : -1) : nz - 1;
    return span;
}

#endif
