/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Where the grains of a bed lie at the start. Rows of equal places, wide enough for the largest
 * grain, are filled from the floor up, so that nothing overlaps whatever the diameters are. */
#ifndef RY_SCENE_PACKING_H
#define RY_SCENE_PACKING_H

#include <stdint.h>

#include "ryusa/config.h"

typedef struct ry_places {
    int64_t n;            /* grains */
    int64_t columns, rows; /* places of an even row; rows, the last perhaps not full */
    int64_t odd_columns;  /* places of an odd row: one less where a shifted row would stick out */
    double pitch_x, pitch_z; /* [m] */
    double shift;         /* of odd rows along x [m] */
    double play;          /* random packing: how far a grain may lie off its place [m] */
    double base;          /* height of the lowest row's centres [m] */
    uint32_t seed;
} ry_places;

/* The places of the bed of a resolved config with grains. */
ry_places ry_packing_plan(const ry_config *config, double length);

/* Centres and diameters of the n grains, numbered column by column, bottom up, so that grains near
 * each other along the bed have near numbers. */
typedef struct ry_placed {
    double x, z, diameter; /* [m] */
} ry_placed;
void ry_packing_fill(const ry_config *config, const ry_places *places, ry_placed *out);

#endif
