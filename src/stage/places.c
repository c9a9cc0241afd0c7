/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

ry_status ry_places_make_room(ry_places *o, int32_t n, ry_error *error)
{
    const size_t room = (size_t)n;
    o->n = n;
    o->was = ry_array(room, sizeof *o->was);
    o->now = ry_array(room, sizeof *o->now);
    o->moved = ry_array(room, sizeof *o->moved);
    o->scratch = ry_array(room, sizeof(double));
    return o->was && o->now && o->moved && o->scratch ? RY_OK : ry_no_memory(error, room * 20);
}

void ry_places_give_back(ry_places *o)
{
    free(o->was);
    free(o->now);
    free(o->moved);
    free(o->scratch);
    o->was = o->now = o->moved = NULL;
    o->scratch = NULL;
}

void ry_places_carry(ry_places *o, void *array, size_t size)
{
    if (array != NULL) {
        o->carried[o->n_carried++] = (ry_carried){array, size};
    }
}

void ry_places_carry_grains(ry_places *o, const ry_grains *g)
{
#define CARRY(type, name, unit, text) ry_places_carry(o, g->name, sizeof(type));
    RY_GRAIN_FIELDS(CARRY)
#undef CARRY
}

/* Whatever x is. */
static int32_t column_of(double x, double left, double width, int32_t columns)
{
    const double column = (x - left) / width;
    return column > 0.0 ? (column < columns ? (int32_t)column : columns - 1) : 0;
}

/* Counting sort by column of the grains in ascending id. */
ry_status ry_places_along_bed(ry_places *o, const ry_grains *g, const int32_t *place, double d, ry_error *error)
{
    double left = INFINITY, right = -INFINITY;
    for (int32_t k = 0; k < g->n; k++) {
        left = fmin(left, g->x[k]);
        right = fmax(right, g->x[k]);
    }
    const double most = (double)g->n, wanted = fmax(1.0, ceil((right - left) / d));
    const int32_t columns = (int32_t)(wanted < most ? wanted : most);
    const double width = (right - left) / columns;
    int32_t *const start = ry_array((size_t)columns + 1, sizeof *start);
    if (start == NULL) {
        return ry_no_memory(error, (size_t)columns * sizeof *start);
    }
    for (int32_t k = 0; k < g->n; k++) {
        start[column_of(g->x[k], left, width, columns) + 1]++;
    }
    for (int32_t c = 0; c < columns; c++) {
        start[c + 1] += start[c];
    }
    for (int32_t id = 0; id < g->n; id++) {
        const int32_t k = place[id];
        o->was[start[column_of(g->x[k], left, width, columns)]++] = k;
    }
    free(start);
    return RY_OK;
}

RY_INLINE void carry_sized(const ry_places *o, char *array, size_t size, int32_t n_moved)
{
    for (int32_t m = 0; m < n_moved; m++) {
        memcpy(o->scratch + (size_t)m * size, array + (size_t)o->was[o->moved[m]] * size, size);
    }
    for (int32_t m = 0; m < n_moved; m++) {
        memcpy(array + (size_t)o->moved[m] * size, o->scratch + (size_t)m * size, size);
    }
}

/* Few grains change places when some wake, which happens often: no calls to copy single numbers. */
static void carry_one(const ry_places *o, char *array, size_t size, int32_t n_moved)
{
    switch (size) {
    case sizeof(double): carry_sized(o, array, sizeof(double), n_moved); break;
    case sizeof(int32_t): carry_sized(o, array, sizeof(int32_t), n_moved); break;
    case sizeof(uint8_t): carry_sized(o, array, sizeof(uint8_t), n_moved); break;
    default: carry_sized(o, array, size, n_moved);
    }
}

void ry_places_change(const ry_places *o, ry_pairs *pairs)
{
    int32_t n_moved = 0;
    for (int32_t k = 0; k < o->n; k++) {
        o->now[o->was[k]] = k;
        o->moved[n_moved] = k;
        n_moved += o->was[k] != k;
    }
    for (int a = 0; a < o->n_carried; a++) {
        carry_one(o, o->carried[a].array, o->carried[a].size, n_moved);
    }
    for (int32_t p = 0; n_moved > 0 && p < pairs->n; p++) {
        const int32_t j = pairs->j[p];
        pairs->j[p] = j < o->n ? o->now[j] : j;
    }
}
