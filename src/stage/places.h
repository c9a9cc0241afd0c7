/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The order of grains in memory, and how they change places. No bit of a result depends on it. */
#ifndef RY_STAGE_PLACES_H
#define RY_STAGE_PLACES_H

#include <stddef.h>

#include "store/pairs.h"
#include "store/state.h"

/* An array in storage order. */
typedef struct ry_carried {
    void *array;
    size_t size;
} ry_carried;
enum { RY_MOST_CARRIED = 64 };

typedef struct ry_places {
    int32_t n; /* grains */
    ry_carried carried[RY_MOST_CARRIED];
    int n_carried;
    /* while there is room: */
    int32_t *was; /* n: the old place of each */
    int32_t *now, *moved;
    char *scratch;
} ry_places;

/* Room for changes of n grains, until it is given back. */
ry_status ry_places_make_room(ry_places *places, int32_t n, ry_error *error);
void ry_places_give_back(ry_places *places);

/* An array, or NULL, that goes along with the grains: whatever outlasts a step, but for the list. */
void ry_places_carry(ry_places *places, void *array, size_t size);
void ry_places_carry_grains(ry_places *places, const ry_grains *grains);

/* Fills `was` with an order along the bed: by columns as wide as d, in each by id. */
ry_status ry_places_along_bed(ry_places *places, const ry_grains *grains, const int32_t *place, double d,
                              ry_error *error);

/* Moves everything to the order of `was`; the list is then to be made anew. */
void ry_places_change(const ry_places *places, ry_pairs *pairs);

#endif
