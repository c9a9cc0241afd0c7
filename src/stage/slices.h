/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * How a sphere's volume is spread over the cells of the column: the exact slice volumes. */
#ifndef RY_STAGE_SLICES_H
#define RY_STAGE_SLICES_H

#include <math.h>
#include <stdint.h>

#include "base/parallel.h"
#include "stage/four.h"

/* Part of a sphere that lies below t radii above its centre, -1 <= t <= 1 beyond which it is 0 or 1. */
RY_INLINE double ry_slice_below(double t)
{
    const double c = t < -1.0 ? -1.0 : (t > 1.0 ? 1.0 : t);
    return 0.25 * (2.0 + c * (3.0 - c * c));
}

/* Four heights at once; written in vectors because the compiler makes branches of it otherwise. */
RY_INLINE ry_four ry_slice_clamp4(ry_four t)
{
    const ry_four one = {1.0, 1.0, 1.0, 1.0};
    const ry_four c = ry_four_select(t < -one, -one, t);
    return ry_four_select(c > one, one, c);
}

RY_INLINE ry_four ry_slice_below4(ry_four c)
{
    return 0.25 * (2.0 + c * (3.0 - c * c));
}

/* Cells are worked on in runs of RY_SLICES, fours of them at a time. Of one four: the heights of the feet of its cells,
 * cut off where the sphere ends, and the parts of the sphere in them. */
enum { RY_SLICES = 8, RY_SLICE_FOURS = RY_SLICES / 4 };
typedef struct ry_slices {
    ry_four foot, part;
} ry_slices;

/* `t`: the foot of the first cell of the run in radii above the centre, `step`: the height of a cell in radii. */
RY_INLINE ry_slices ry_slice_cut(double t, double step, int32_t four)
{
    const ry_four k = {4.0 * four, 4.0 * four + 1.0, 4.0 * four + 2.0, 4.0 * four + 3.0};
    ry_slices s;
    s.foot = ry_slice_clamp4(t + k * step);
    s.part = ry_slice_below4(ry_slice_clamp4(t + (k + 1.0) * step)) - ry_slice_below4(s.foot);
    return s;
}

RY_INLINE void ry_slice_add(double *row, ry_four value)
{
    ry_four_store(row, ry_four_load(row) + value);
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
