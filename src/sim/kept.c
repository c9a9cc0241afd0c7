/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "sim/kept.h"

#include <string.h>

#include "base/memory.h"

/* What never changes: radius, density, id, fixed. */
#define KEPT_FIELDS(KEPT)                                                                                       \
    KEPT(double, x) KEPT(double, z) KEPT(double, vx) KEPT(double, vz) KEPT(double, spin) \
    KEPT(double, push) KEPT(double, met) KEPT(int32_t, image)

#define ONE(...) +1
enum { CHANGE = 0 KEPT_FIELDS(ONE), NEVER_CHANGE = 4, ALL = 0 RY_GRAIN_FIELDS(ONE) };
#undef ONE
_Static_assert(CHANGE + NEVER_CHANGE == ALL, "a field of the grains that is not kept");

ry_status ry_kept_create(ry_state *kept, const ry_state *state, ry_error *error)
{
    const size_t n = (size_t)state->grains.n, nz = (size_t)state->column.nz;
    int whole = 1;
    *kept = (ry_state){0};
#define MAKE(type, name) whole = whole && (state->grains.name == NULL || \
                                           (kept->grains.name = ry_array(n, sizeof(type))) != NULL);
    KEPT_FIELDS(MAKE)
#undef MAKE
#define MAKE(type, name, unit, text) whole = whole && (state->sleepers.name == NULL || \
                                                       (kept->sleepers.name = ry_array(n, sizeof(type))) != NULL);
    RY_SLEEP_FIELDS(MAKE)
#undef MAKE
#define MAKE(name, unit, text) whole = whole && (kept->column.name = ry_array(nz, sizeof(double))) != NULL;
    RY_COLUMN_FIELDS(MAKE)
#undef MAKE
    if (!whole) {
        return ry_no_memory(error, n * 100);
    }
    kept->column.nz = state->column.nz;
    ry_kept_take(kept, state);
    return RY_OK;
}

static void copy_the_rest(ry_state *to, const ry_state *from)
{
    to->step = from->step;
    to->time = from->time;
    to->ledger = from->ledger;
    to->column.dz = from->column.dz;
    to->column.bed_level = from->column.bed_level;
#define COPY(name, unit, text) memcpy(to->column.name, from->column.name, (size_t)from->column.nz * sizeof(double));
    if (from->column.nz > 0) {
        RY_COLUMN_FIELDS(COPY)
    }
#undef COPY
}

void ry_kept_take(ry_state *kept, const ry_state *state)
{
    const int32_t n = state->grains.n, *const id = state->grains.id;
#define TAKE(type, name)                                                      \
    for (int32_t k = 0; state->grains.name != NULL && k < n; k++) {           \
        kept->grains.name[id[k]] = state->grains.name[k];                     \
    }
    KEPT_FIELDS(TAKE)
#undef TAKE
#define TAKE(type, name, unit, text)                                          \
    for (int32_t k = 0; state->sleepers.name != NULL && k < n; k++) {         \
        kept->sleepers.name[id[k]] = state->sleepers.name[k];                 \
    }
    RY_SLEEP_FIELDS(TAKE)
#undef TAKE
    copy_the_rest(kept, state);
}

ry_status ry_kept_give(const ry_state *kept, ry_state *state, ry_error *error)
{
    const int32_t n = state->grains.n, *const id = state->grains.id;
#define GIVE(type, name)                                                      \
    for (int32_t k = 0; state->grains.name != NULL && k < n; k++) {           \
        state->grains.name[k] = kept->grains.name[id[k]];                     \
    }
    KEPT_FIELDS(GIVE)
#undef GIVE
#define GIVE(type, name, unit, text)                                          \
    for (int32_t k = 0; state->sleepers.name != NULL && k < n; k++) {         \
        state->sleepers.name[k] = kept->sleepers.name[id[k]];                 \
    }
    RY_SLEEP_FIELDS(GIVE)
#undef GIVE
    copy_the_rest(state, kept);
    return ry_contacts_copy(&state->contacts, &kept->contacts, error);
}
