/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Memory of the state and its hash. The hash of a state is the sum of one strong hash per grain,
 * contact and cell, each of which mixes in who it belongs to: a sum needs no sorting, so the storage
 * order cannot matter and the hash needs no memory. */
#include "store/state.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

#define ALLOCATED(type, name, unit, text) &&(grains->name = ry_array(entries, sizeof(type))) != NULL

static int create_grains(ry_grains *grains, int32_t n)
{
    const size_t entries = (size_t)n + RY_MAX_WALLS;
    grains->n = n;
    if (!(1 RY_GRAIN_FIELDS(ALLOCATED))) {
        return 0;
    }
    for (int32_t k = 0; k < n; ++k) {
        grains->id[k] = k;
    }
    return 1;
}

#undef ALLOCATED

static int create_column(ry_column *column, int32_t nz)
{
    column->nz = nz;
#define ALLOCATED(name, unit, text) &&(column->name = ry_array((size_t)nz, sizeof(double))) != NULL
    return nz == 0 || (1 RY_COLUMN_FIELDS(ALLOCATED));
#undef ALLOCATED
}

ry_status ry_state_create(ry_state *state, int32_t n, int32_t nz, int ledger, ry_error *error)
{
    *state = (ry_state){0};
    state->ledger.kept = ledger;
    if (create_grains(&state->grains, n) && create_column(&state->column, nz)) {
        return RY_OK;
    }
    ry_state_free(state);
    return ry_no_memory(error, ((size_t)n * 100 + (size_t)nz * 3 * sizeof(double)));
}

ry_status ry_state_add_sleepers(ry_state *state, ry_error *error)
{
    ry_sleepers *const s = &state->sleepers;
    const size_t entries = (size_t)state->grains.n + RY_MAX_WALLS;
#define ALLOCATED(type, name, unit, text) &&(s->name = ry_array(entries, sizeof(type))) != NULL
    if (!(1 RY_SLEEP_FIELDS(ALLOCATED))) {
        return ry_no_memory(error, entries * 100);
    }
#undef ALLOCATED
    ry_contacts *const c = &state->contacts;
    const size_t room = (size_t)c->capacity;
#define ALLOCATED(type, name, unit, text) &&(c->name = ry_array(room, sizeof(type))) != NULL
    if (!c->sleeps && room > 0 && !(1 RY_FROZEN_FIELDS(ALLOCATED))) {
        return ry_no_memory(error, room * 24);
    }
#undef ALLOCATED
    c->sleeps = 1;
    for (int32_t k = 0; k < state->grains.n; k++) {
        s->asleep[k] = state->grains.fixed[k];
        s->from_x[k] = state->grains.x[k];
        s->from_z[k] = state->grains.z[k];
    }
    return RY_OK;
}

void ry_state_free(ry_state *state)
{
#define FREE_GRAINS(type, name, unit, text) free(state->grains.name);
#define FREE_COLUMN(name, unit, text) free(state->column.name);
#define FREE_SLEEPERS(type, name, unit, text) free(state->sleepers.name);
    RY_GRAIN_FIELDS(FREE_GRAINS);
    ry_contacts_free(&state->contacts);
    RY_COLUMN_FIELDS(FREE_COLUMN);
    RY_SLEEP_FIELDS(FREE_SLEEPERS);
#undef FREE_GRAINS
#undef FREE_COLUMN
#undef FREE_SLEEPERS
    *state = (ry_state){0};
}

void ry_contacts_free(ry_contacts *contacts)
{
#define FREE(type, name, unit, text) free(contacts->name);
    RY_CONTACT_FIELDS(FREE)
    RY_WET_FIELDS(FREE)
    RY_FROZEN_FIELDS(FREE)
#undef FREE
    *contacts = (ry_contacts){.no_rest = contacts->no_rest, .is_wet = contacts->is_wet, .sleeps = contacts->sleeps};
}

void ry_contacts_drop_rest(ry_contacts *contacts)
{
    free(contacts->rest);
    contacts->rest = NULL;
    contacts->no_rest = 1;
}

static ry_status grow(void *array, size_t used, size_t room, size_t size, ry_error *error)
{
    void **const slot = array;
    void *const grown = ry_array(room, size);
    if (grown == NULL) {
        return ry_no_memory(error, room * size);
    }
    if (used > 0 && *slot != NULL) {
        memcpy(grown, *slot, used * size);
    }
    free(*slot);
    *slot = grown;
    return RY_OK;
}

ry_status ry_contacts_reserve(ry_contacts *contacts, int64_t n, ry_error *error)
{
    if (n <= contacts->capacity) {
        return RY_OK;
    }
    /* After a failure the old capacity stands: it is true of all arrays. */
    const size_t used = (size_t)contacts->n, room = (size_t)(n + n / 32 + 64);
    const void *const absent = contacts->no_rest ? &contacts->rest : NULL;
#define GROW(type, name, unit, text)                                                   \
    if ((const void *)&contacts->name != absent) {                                     \
        RY_TRY(grow(&contacts->name, used, room, sizeof *contacts->name, error)); \
    }
    RY_CONTACT_FIELDS(GROW)
    if (contacts->is_wet) {
        RY_WET_FIELDS(GROW)
    }
    if (contacts->sleeps) {
        RY_FROZEN_FIELDS(GROW)
    }
#undef GROW
    contacts->capacity = (int64_t)room;
    return RY_OK;
}

ry_status ry_contacts_copy(ry_contacts *to, const ry_contacts *from, ry_error *error)
{
    to->is_wet = from->is_wet;
    to->sleeps = from->sleeps;
    RY_TRY(ry_contacts_reserve(to, from->n, error));
    to->n = from->n;
#define COPY(type, name, unit, text)                                    \
    if (from->n > 0 && from->name != NULL && to->name != NULL) {       \
        memcpy(to->name, from->name, (size_t)from->n * sizeof(type)); \
    }
    RY_CONTACT_FIELDS(COPY)
    RY_WET_FIELDS(COPY)
    RY_FROZEN_FIELDS(COPY)
#undef COPY
    return RY_OK;
}

ry_status ry_state_copy(ry_state *to, const ry_state *from, ry_error *error)
{
    if (from->sleepers.asleep != NULL && to->sleepers.asleep == NULL) {
        RY_TRY(ry_state_add_sleepers(to, error));
    }
    to->step = from->step;
    to->time = from->time;
    const size_t n = (size_t)from->grains.n, nz = (size_t)from->column.nz;
#define RY_GRAIN_COPY(type, name, unit, text)                          \
    if (from->grains.name != NULL) {                                   \
        memcpy(to->grains.name, from->grains.name, n * sizeof(type)); \
    }
    RY_GRAIN_FIELDS(RY_GRAIN_COPY)
#undef RY_GRAIN_COPY
    to->column.dz = from->column.dz;
    to->column.bed_level = from->column.bed_level;
#define RY_COLUMN_COPY(name, unit, text) memcpy(to->column.name, from->column.name, nz * sizeof(double));
    if (nz > 0) {
        RY_COLUMN_FIELDS(RY_COLUMN_COPY)
    }
#undef RY_COLUMN_COPY
    to->ledger = from->ledger;
#define RY_SLEEP_COPY(type, name, unit, text) memcpy(to->sleepers.name, from->sleepers.name, n * sizeof(type));
    if (from->sleepers.asleep != NULL) {
        RY_SLEEP_FIELDS(RY_SLEEP_COPY)
    }
#undef RY_SLEEP_COPY
    return ry_contacts_copy(&to->contacts, &from->contacts, error);
}

/* The finalizer of splitmix64: every bit of x reaches every bit of the result. */
static uint64_t mix(uint64_t x)
{
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

static uint64_t add_word(uint64_t hash, uint64_t word)
{
    return mix((hash ^ word) + UINT64_C(0x9e3779b97f4a7c15));
}

static uint64_t add_double(uint64_t hash, double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    return add_word(hash, word);
}

static uint64_t add_int32_t(uint64_t hash, int32_t value)
{
    return add_word(hash, (uint64_t)(int64_t)value);
}

static uint64_t add_uint8_t(uint64_t hash, uint8_t value)
{
    return add_word(hash, value);
}

static uint64_t add_ry_steps(uint64_t hash, ry_steps value)
{
    return add_double(hash, value);
}

static uint64_t hash_grain(const ry_state *state, int32_t k)
{
    const ry_grains *const grains = &state->grains;
    uint64_t hash = add_int32_t(1, grains->id[k]);
#define ADD(type, name, unit, text) hash = add_##type(hash, grains->name != NULL ? grains->name[k] : 0);
    RY_GRAIN_FIELDS(ADD);
#undef ADD
    return hash;
}

static uint64_t hash_sleeper(const ry_sleepers *sleepers, int32_t id, int32_t k)
{
    uint64_t hash = add_int32_t(5, id);
#define ADD(type, name, unit, text) hash = add_##type(hash, sleepers->name[k]);
    RY_SLEEP_FIELDS(ADD);
#undef ADD
    return hash;
}

static uint64_t hash_books(const ry_ledger *ledger)
{
    uint64_t hash = add_word(4, (uint64_t)ledger->kept);
#define ADD(name, text) hash = add_word(add_word(hash, (uint64_t)ledger->name.high), (uint64_t)ledger->name.low);
    RY_LEDGER_TOTALS(ADD);
#undef ADD
    return add_double(hash, ledger->energy_start);
}

static uint64_t hash_contact(const ry_contacts *contacts, int64_t k)
{
    uint64_t hash = 2;
#define ADD(type, name, unit, text) hash = add_##type(hash, contacts->name != NULL ? contacts->name[k] : 0);
    RY_CONTACT_FIELDS(ADD);
    if (contacts->is_wet) {
        RY_WET_FIELDS(ADD);
    }
    if (contacts->sleeps) {
        RY_FROZEN_FIELDS(ADD);
    }
#undef ADD
    return hash;
}

static uint64_t hash_cell(const ry_column *column, int32_t k)
{
    uint64_t hash = add_int32_t(3, k);
#define ADD(name, unit, text) hash = add_double(hash, column->name[k]);
    RY_COLUMN_FIELDS(ADD);
#undef ADD
    return hash;
}

uint64_t ry_state_hash(const ry_state *state)
{
    uint64_t sum = 0;
    for (int32_t k = 0; k < state->grains.n; ++k) {
        sum += hash_grain(state, k);
    }
    for (int32_t k = 0; k < state->grains.n && state->sleepers.asleep != NULL; ++k) {
        sum += hash_sleeper(&state->sleepers, state->grains.id[k], k);
    }
    for (int64_t k = 0; k < state->contacts.n; ++k) {
        sum += hash_contact(&state->contacts, k);
    }
    for (int32_t k = 0; k < state->column.nz; ++k) {
        sum += hash_cell(&state->column, k);
    }
    uint64_t hash = add_word(sum, (uint64_t)state->step);
    hash = add_double(hash, state->time);
    hash = add_int32_t(hash, state->grains.n);
    hash = add_word(hash, (uint64_t)state->contacts.n);
    hash = add_double(add_int32_t(hash, state->column.nz), state->column.dz);
    return add_double(hash, state->column.bed_level);
}

uint64_t ry_state_checksum(const ry_state *state)
{
    return add_word(ry_state_hash(state), hash_books(&state->ledger));
}
