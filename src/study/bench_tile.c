/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench_tile.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

typedef struct tiling {
    const ry_state *base;
    double length;
    int32_t n, moving; /* of the base */
    int32_t *place;    /* of an id in the base */
    int tiles;
} tiling;

/* The movable of all tiles first, then the fixed. */
static int32_t new_id(const tiling *t, int32_t id, int tile)
{
    const int at = (tile + t->tiles) % t->tiles;
    return id < t->moving ? at * t->moving + id
                          : t->tiles * t->moving + at * (t->n - t->moving) + id - t->moving;
}

static void copy_grains(const tiling *t, ry_state *state)
{
    const ry_grains *const from = &t->base->grains;
    ry_grains *const to = &state->grains;
    for (int tile = 0; tile < t->tiles; tile++) {
        for (int32_t id = 0; id < t->n; id++) {
            const int32_t k = new_id(t, id, tile), source = t->place[id];
#define RY_GRAIN_COPY(type, name, unit, text) to->name[k] = from->name != NULL ? from->name[source] : 0;
            RY_GRAIN_FIELDS(RY_GRAIN_COPY)
#undef RY_GRAIN_COPY
            to->id[k] = k;
            to->x[k] += tile * t->length;
        }
    }
}

/* A contact over the end of a tile is one with the next tile, or the one before. */
static void copy_contacts(const tiling *t, ry_state *state)
{
    const ry_contacts *const from = &t->base->contacts;
    const double *const x = t->base->grains.x;
    ry_contacts *const to = &state->contacts;
    for (int tile = 0; tile < t->tiles; tile++) {
        for (int64_t c = 0; c < from->n; c++) {
            const double dx = x[t->place[from->id_j[c]]] - x[t->place[from->id_i[c]]];
            const int step = dx > 0.5 * t->length ? -1 : (dx < -0.5 * t->length ? 1 : 0);
            const int32_t i = new_id(t, from->id_i[c], tile), j = new_id(t, from->id_j[c], tile + step);
            const int64_t k = to->n++;
            to->id_i[k] = i < j ? i : j;
            to->id_j[k] = i < j ? j : i;
            to->slip[k] = from->slip[c]; /* the same seen from either grain */
            to->rest[k] = from->rest != NULL ? from->rest[c] : 0.0;
            to->age[k] = from->age[c];
        }
    }
}

ry_status ry_bench_tile(ry_state *state, const ry_state *base, double length, int tiles, ry_error *error)
{
    tiling t = {.base = base, .length = length, .n = base->grains.n, .tiles = tiles};
    t.place = ry_array((size_t)t.n, sizeof *t.place);
    if (t.place == NULL) {
        return ry_no_memory(error, (size_t)t.n * sizeof *t.place);
    }
    for (int32_t k = 0; k < t.n; k++) {
        t.place[base->grains.id[k]] = k;
        t.moving += !base->grains.fixed[k];
    }
    ry_status status = ry_state_create(state, t.n * tiles, base->column.nz, 0, error);
    if (status == RY_OK) {
        status = ry_contacts_reserve(&state->contacts, base->contacts.n * tiles, error);
    }
    if (status == RY_OK) {
        state->step = base->step;
        state->time = base->time;
        state->column.dz = base->column.dz;
        state->column.bed_level = base->column.bed_level;
#define RY_COLUMN_COPY(name, unit, text) \
    memcpy(state->column.name, base->column.name, (size_t)base->column.nz * sizeof(double));
        if (base->column.nz > 0) {
            RY_COLUMN_FIELDS(RY_COLUMN_COPY)
        }
#undef RY_COLUMN_COPY
        copy_grains(&t, state);
        copy_contacts(&t, state);
    }
    free(t.place);
    return status;
}
