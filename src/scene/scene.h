/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * From a resolved config to the first state: the grains of the bed and the floor, explicit grains, an
 * empty fluid column. Ids: explicit grains in the order of the file, then the bed, then the floor. */
#ifndef RY_SCENE_SCENE_H
#define RY_SCENE_SCENE_H

#include "ryusa/config.h"
#include "store/state.h"

ry_status ry_scene_build(const ry_config *config, ry_state *state, ry_error *error);

/* How many grains ry_scene_build makes, and the cells of its column, without building. */
typedef struct ry_scene_size {
    int64_t explicit_grains, bed, floor;
    int32_t nz;
    double dz; /* [m] */
} ry_scene_size;
ry_scene_size ry_scene_measure(const ry_config *config);

#endif
