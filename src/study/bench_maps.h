/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The stability maps: their axes and the scenes of a point. */
#ifndef RY_STUDY_BENCH_MAPS_H
#define RY_STUDY_BENCH_MAPS_H

#include "study/bench_stress.h"

enum { RY_MAP_POINTS = 12 }; /* along an axis, at most */

typedef struct ry_axis {
    const char *key, *unit;
    int n;
    double value[RY_MAP_POINTS];
} ry_axis;

typedef ry_status ry_map_fn(ry_law law, double x, double y, int quick, ry_stress *out,
                            ry_error *error);

typedef struct ry_map {
    const char *name, *text;
    ry_axis x, y;
    ry_map_fn *run; /* one point */
} ry_map;

enum { RY_MAPS = 4 };
extern const ry_map ry_maps[RY_MAPS];

#endif
