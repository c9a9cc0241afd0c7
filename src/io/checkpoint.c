/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The state in the file, field by field under its own name, in id order, so that storage order and
 * compilers may change between writing and reading. There are two slots, /checkpoint/a and b, written
 * in turn. The arrays of a slot keep their places in the file and are overwritten there (a million
 * grains should not pass through the journal): a kill then spoils the slot that was the older one
 * anyway, which its hash tells. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/result_private.h"

/* A field of the state that is in none of the lists below would be lost: the compiler tells. */
#define ONE(...) +1
enum {
    GRAIN_FIELDS = 0 RY_GRAIN_FIELDS(ONE),
    CONTACT_FIELDS = 0 RY_CONTACT_FIELDS(ONE) RY_WET_FIELDS(ONE) RY_FROZEN_FIELDS(ONE),
    COLUMN_FIELDS = 0 RY_COLUMN_FIELDS(ONE),
    LEDGER_FIELDS = 0 RY_LEDGER_TOTALS(ONE),
    SLEEP_FIELDS = 0 RY_SLEEP_FIELDS(ONE)
};
#undef ONE
_Static_assert(sizeof(ry_grains) == (1 + GRAIN_FIELDS) * sizeof(void *), "a field without a list");
_Static_assert(sizeof(ry_contacts) == (5 + CONTACT_FIELDS) * sizeof(void *),
               "a field without a list");
_Static_assert(sizeof(ry_column) == (3 + COLUMN_FIELDS) * sizeof(void *), "a field without a list");
_Static_assert(sizeof(ry_ledger) == (2 + 2 * LEDGER_FIELDS) * sizeof(int64_t), "a field without a list");
_Static_assert(sizeof(ry_sleepers) == SLEEP_FIELDS * sizeof(void *), "a field without a list");
_Static_assert(sizeof(ry_state) == 2 * sizeof(int64_t) + sizeof(ry_grains) + sizeof(ry_contacts) +
                                       sizeof(ry_column) + sizeof(ry_ledger) + sizeof(ry_sleepers),
               "the state has a field that no checkpoint holds");

enum { FORMAT = 4 }; /* of checkpoints; 1 had a ledger per grain, 2 no books of impacts, 3 no eddies */

/* SCALAR(kind, name in the file, member) */
#define TOTAL(name, text)                                     \
    SCALAR(integer, "ledger_" #name "_high", ledger.name.high) \
    SCALAR(integer, "ledger_" #name "_low", ledger.name.low)
#define SCALARS                                   \
    SCALAR(integer, "step", step)                 \
    SCALAR(number, "time", time)                  \
    SCALAR(number, "cell_height", column.dz)      \
    SCALAR(number, "bed_level", column.bed_level) \
    SCALAR(integer, "ledger", ledger.kept)        \
    RY_LEDGER_TOTALS(TOTAL)                       \
    SCALAR(number, "energy_start", ledger.energy_start)

static hid_t type_double(void)
{
    return H5T_NATIVE_DOUBLE;
}
static hid_t type_int32_t(void)
{
    return H5T_NATIVE_INT32;
}
static hid_t type_uint8_t(void)
{
    return H5T_NATIVE_UINT8;
}

static hid_t type_ry_steps(void)
{
    return H5T_NATIVE_UINT8;
}

static const char *slot_path(int slot)
{
    return slot == 0 ? "checkpoint/a" : "checkpoint/b";
}

typedef struct name {
    char string[100];
} name;

static name join(int slot, const char *group, const char *field)
{
    name joined;
    snprintf(joined.string, sizeof joined.string, "%s/%s/%s", slot_path(slot), group, field);
    return joined;
}

/* --- writing --- */

/* Lets an array be overwritten in place. */
static void expose(const ry_h5 *file, const char *path)
{
    const hid_t dataset = ry_h5_exists(file->id, path) ? H5Dopen2(file->id, path, H5P_DEFAULT) : -1;
    if (dataset < 0) {
        return;
    }
    const haddr_t at = H5Dget_offset(dataset);
    if (at != HADDR_UNDEF) {
        ry_atomic_expose(file->atomic, at, H5Dget_storage_size(dataset));
    }
    H5Dclose(dataset);
}

static int write_array(const ry_h5 *file, const char *path, hid_t type, int64_t n, const char *unit,
                       const void *data)
{
    const ry_h5_shape shape = {type, 1, {(hsize_t)n}};
    expose(file, path);
    return ry_h5_write(file->id, path, &shape, data) == 0 &&
                   ry_h5_set_unit(file->id, path, unit) == 0 && ry_atomic_error(file->atomic) == 0
               ? 0
               : -1;
}

/* One array of the grains in id order; zeros in place of one that the scene lacks. */
static int write_by_id(const ry_h5 *file, const char *path, hid_t type, const ry_grains *grains,
                       const char *unit, const void *data, size_t item)
{
    char *const sorted = ry_array((size_t)grains->n, item);
    if (sorted == NULL) {
        return -1;
    }
    for (int32_t k = 0; data != NULL && k < grains->n; ++k) {
        memcpy(sorted + (size_t)grains->id[k] * item, (const char *)data + (size_t)k * item, item);
    }
    const int written = write_array(file, path, type, grains->n, unit, sorted);
    free(sorted);
    return written;
}

/* Likewise. Contacts come and go. Their arrays have room to spare; the attribute `contacts` tells how many
 * there are. */
static int write_contacts_array(const ry_h5 *file, const char *path, hid_t type, int64_t n,
                                const char *unit, const void *data, size_t item)
{
    ry_h5_shape shape;
    int64_t room = 0;
    if (ry_h5_get_shape(file->id, path, &shape) == 0) {
        room = (int64_t)shape.size[0];
        if (room < n && H5Ldelete(file->id, path, H5P_DEFAULT) < 0) {
            return -1;
        }
    }
    if (room < n || room == 0) {
        room = n + n / 4 + 16;
    }
    char *const padded = ry_array((size_t)room, item);
    if (padded == NULL) {
        return -1;
    }
    if (n > 0 && data != NULL) {
        memcpy(padded, data, (size_t)n * item);
    }
    const int written = write_array(file, path, type, room, unit, padded);
    free(padded);
    return written;
}

static int write_arrays(const ry_h5 *file, int slot, const ry_state *state)
{
#define WRITE(type, field, unit, text)                                                        \
    if (state->grains.field != NULL &&                                                        \
        write_by_id(file, join(slot, "grains", #field).string, type_##type(), &state->grains, \
                    unit, state->grains.field, sizeof(type)) != 0) {                          \
        return -1;                                                                            \
    }
    RY_GRAIN_FIELDS(WRITE);
#undef WRITE
#define WRITE(type, field, unit, text)                                                             \
    if (write_contacts_array(file, join(slot, "contacts", #field).string, type_##type(),           \
                             state->contacts.n, unit, state->contacts.field, sizeof(type)) != 0) { \
        return -1;                                                                                 \
    }
    RY_CONTACT_FIELDS(WRITE);
    if (state->contacts.is_wet) {
        RY_WET_FIELDS(WRITE);
    }
    if (state->contacts.sleeps) {
        RY_FROZEN_FIELDS(WRITE);
    }
#undef WRITE
#define WRITE(type, field, unit, text)                                                          \
    if (state->sleepers.field != NULL &&                                                        \
        write_by_id(file, join(slot, "sleepers", #field).string, type_##type(), &state->grains, \
                    unit, state->sleepers.field, sizeof(type)) != 0) {                          \
        return -1;                                                                              \
    }
    RY_SLEEP_FIELDS(WRITE);
#undef WRITE
#define WRITE(field, unit, text)                                                  \
    if (state->column.nz > 0 &&                                                   \
        write_array(file, join(slot, "column", #field).string, H5T_NATIVE_DOUBLE, \
                    state->column.nz, unit, state->column.field) != 0) {          \
        return -1;                                                                \
    }
    RY_COLUMN_FIELDS(WRITE);
#undef WRITE
    return 0;
}

static int write_scalars(hid_t file, int slot, int64_t sequence, const ry_state *state,
                         uint64_t hash)
{
    const char *const path = slot_path(slot);
#define SCALAR(kind, field, member)                                \
    if (ry_h5_set_##kind(file, path, field, state->member) != 0) { \
        return -1;                                                 \
    }
    SCALARS
#undef SCALAR
    return ry_h5_set_integer(file, path, "format", FORMAT) == 0 &&
                   ry_h5_set_integer(file, path, "sequence", sequence) == 0 &&
                   ry_h5_set_integer(file, path, "grains", state->grains.n) == 0 &&
                   ry_h5_set_integer(file, path, "contacts", state->contacts.n) == 0 &&
                   ry_h5_set_integer(file, path, "cells", state->column.nz) == 0 &&
                   ry_h5_set_numbers(file, path, "hash", H5T_NATIVE_UINT64, 0, &hash) == 0
               ? 0
               : -1;
}

int ry_checkpoint_write(const ry_h5 *file, int slot, int64_t sequence, const ry_state *state)
{
    const uint64_t hash = ry_state_checksum(state);
    char text[20];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)ry_state_hash(state));
    return ry_h5_make_group(file->id, slot_path(slot)) == 0 &&
                   write_arrays(file, slot, state) == 0 &&
                   write_scalars(file->id, slot, sequence, state, hash) == 0 &&
                   ry_h5_set_text(file->id, "checkpoint", "state_hash", text) == 0
               ? 0
               : -1;
}

int ry_checkpoint_write_window(const ry_h5 *file, int slot, const double *values, int64_t n)
{
    const ry_h5_shape shape = {H5T_NATIVE_DOUBLE, 1, {(hsize_t)n}};
    char path[100];
    snprintf(path, sizeof path, "%s/window", slot_path(slot));
    if (n == 0 && ry_h5_exists(file->id, path) && H5Ldelete(file->id, path, H5P_DEFAULT) < 0) {
        return -1;
    }
    return ry_h5_set_integer(file->id, slot_path(slot), "window", n) == 0 &&
                   (n == 0 || ry_h5_write(file->id, path, &shape, values) == 0)
               ? 0
               : -1;
}

/* --- reading --- */

int ry_checkpoint_read_window(hid_t file, int slot, double **values, int64_t *n)
{
    char path[100];
    snprintf(path, sizeof path, "%s/window", slot_path(slot));
    *values = NULL;
    *n = 0;
    if (ry_h5_get_integer(file, slot_path(slot), "window", n) != 0 || *n <= 0) {
        *n = 0; /* files of older programs have none */
        return 0;
    }
    *values = ry_array((size_t)*n, sizeof **values);
    return *values != NULL ? ry_h5_read(file, path, H5T_NATIVE_DOUBLE, (hsize_t)*n, *values) : -1;
}

static int read_first(hid_t file, const char *path, hid_t type, int64_t n, void *data)
{
    return n == 0 ? 0 : ry_h5_read_rows(file, path, type, 0, (hsize_t)n, data);
}

/* Where the fluid has no use for them; they stay 0, as they count. */
static int may_lack(const ry_grains *grains, const void *field)
{
    return field == (const void *)&grains->push || field == (const void *)&grains->met;
}

static int read_arrays(hid_t file, int slot, ry_state *state)
{
#define READ(type, field, unit, text)                                                         \
    if ((!may_lack(&state->grains, &state->grains.field) ||                                   \
         ry_h5_exists(file, join(slot, "grains", #field).string)) &&                          \
        read_first(file, join(slot, "grains", #field).string, type_##type(), state->grains.n, \
                   state->grains.field) != 0) {                                               \
        return -1;                                                                            \
    }
    RY_GRAIN_FIELDS(READ);
#undef READ
#define READ(type, field, unit, text)                                                             \
    if (read_first(file, join(slot, "contacts", #field).string, type_##type(), state->contacts.n, \
                   state->contacts.field) != 0) {                                                 \
        return -1;                                                                                \
    }
    RY_CONTACT_FIELDS(READ);
    if (state->contacts.is_wet) {
        RY_WET_FIELDS(READ);
    }
    if (state->contacts.sleeps) {
        RY_FROZEN_FIELDS(READ);
    }
#undef READ
#define READ(type, field, unit, text)                                                             \
    if (state->sleepers.field != NULL &&                                                          \
        read_first(file, join(slot, "sleepers", #field).string, type_##type(), state->grains.n,   \
                   state->sleepers.field) != 0) {                                                 \
        return -1;                                                                                \
    }
    RY_SLEEP_FIELDS(READ);
#undef READ
#define READ(field, unit, text)                                                                    \
    if (read_first(file, join(slot, "column", #field).string, H5T_NATIVE_DOUBLE, state->column.nz, \
                   state->column.field) != 0) {                                                    \
        return -1;                                                                                 \
    }
    RY_COLUMN_FIELDS(READ);
#undef READ
    return 0;
}

/* Makes a state of the size that the slot has. */
static int read_size(hid_t file, int slot, ry_state *state)
{
    const char *const path = slot_path(slot);
    int64_t format = 0, grains = -1, contacts = -1, cells = -1;
    if (ry_h5_get_integer(file, path, "format", &format) != 0 || format != FORMAT ||
        ry_h5_get_integer(file, path, "grains", &grains) != 0 ||
        ry_h5_get_integer(file, path, "contacts", &contacts) != 0 ||
        ry_h5_get_integer(file, path, "cells", &cells) != 0 || grains < 0 || grains > INT32_MAX ||
        contacts < 0 || cells < 0 || cells > INT32_MAX) {
        return -1;
    }
    if (ry_state_create(state, (int32_t)grains, (int32_t)cells, 0, NULL) != RY_OK) {
        return -1;
    }
    state->contacts.is_wet = ry_h5_exists(file, join(slot, "contacts", "wet").string);
    if (ry_h5_exists(file, join(slot, "sleepers", "asleep").string) && ry_state_add_sleepers(state, NULL) != RY_OK) {
        return -1;
    }
    if (ry_contacts_reserve(&state->contacts, contacts, NULL) != RY_OK) {
        return -1;
    }
    state->contacts.n = contacts;
    return 0;
}

static int read_scalars(hid_t file, int slot, ry_state *state, uint64_t *hash)
{
    const char *const path = slot_path(slot);
#define SCALAR(kind, field, member)                                 \
    if (ry_h5_get_##kind(file, path, field, &state->member) != 0) { \
        return -1;                                                  \
    }
    SCALARS
#undef SCALAR
    const hid_t attribute = H5Aopen_by_name(file, path, "hash", H5P_DEFAULT, H5P_DEFAULT);
    const int read = attribute >= 0 ? H5Aread(attribute, H5T_NATIVE_UINT64, hash) : -1;
    H5Aclose(attribute);
    return read < 0 ? -1 : 0;
}

static int ids_are_ordered(const ry_grains *grains)
{
    for (int32_t k = 0; k < grains->n; ++k) {
        if (grains->id[k] != k) {
            return 0;
        }
    }
    return 1;
}

static int read_slot(hid_t file, int slot, ry_state *state)
{
    uint64_t hash = 0;
    if (read_size(file, slot, state) == 0 && read_arrays(file, slot, state) == 0 &&
        read_scalars(file, slot, state, &hash) == 0 && ids_are_ordered(&state->grains) &&
        ry_state_checksum(state) == hash) {
        return 0;
    }
    ry_state_free(state);
    return -1;
}

int64_t ry_checkpoint_other_format(hid_t file)
{
    int64_t other = 0;
    for (int slot = 0; slot < 2; slot++) {
        int64_t format = FORMAT;
        const int has = ry_h5_exists(file, slot_path(slot)) &&
                        ry_h5_get_integer(file, slot_path(slot), "format", &format) == 0;
        other = has && format != FORMAT ? format : other;
    }
    return other;
}

int ry_checkpoint_read(hid_t file, ry_state *state, int *slot, int64_t *sequence)
{
    int64_t number[2] = {-1, -1};
    for (int k = 0; k < 2; ++k) {
        if (ry_h5_exists(file, slot_path(k)) &&
            ry_h5_get_integer(file, slot_path(k), "sequence", &number[k]) != 0) {
            number[k] = 0;
        }
    }
    const int newest = number[1] > number[0];
    for (int k = 0; k < 2; ++k) {
        const int tried = k == 0 ? newest : !newest;
        if (number[tried] >= 0 && read_slot(file, tried, state) == 0) {
            *slot = tried;
            *sequence = number[tried];
            return 1;
        }
    }
    return number[0] < 0 && number[1] < 0 ? 0 : -1;
}
