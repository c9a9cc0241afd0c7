/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "store/pairs.h"

#include <stdlib.h>

#include "base/memory.h"

static ry_status make(void *array, size_t count, size_t size, ry_error *error)
{
    void **const slot = array;
    free(*slot);
    *slot = ry_array(count, size);
    return *slot != NULL ? RY_OK : ry_no_memory(error, count * size);
}

ry_status ry_pairs_create(ry_pairs *pairs, int32_t n_grains, int n_walls, unsigned wants, ry_error *error)
{
    const size_t n = (size_t)n_grains;
    *pairs = (ry_pairs){.n_grains = n_grains};
    RY_TRY(make(&pairs->place, n + 1, sizeof *pairs->place, error));
    RY_TRY(make(&pairs->row, n + 1, sizeof *pairs->row, error));
    RY_TRY(make(&pairs->chunk, RY_MOST_THREADS + 1, sizeof *pairs->chunk, error));
    RY_TRY(make(&pairs->n_young, RY_MOST_THREADS + 1, sizeof *pairs->n_young, error));
    RY_TRY(make(&pairs->young_next, RY_MOST_THREADS + 1, sizeof *pairs->young_next, error));
    RY_TRY(make(&pairs->shelf, RY_MOST_THREADS + 1, sizeof *pairs->shelf, error));
    RY_TRY(make(&pairs->below_start, n + 1, sizeof *pairs->below_start, error));
    for (int w = 0; w < n_walls; w++) {
        RY_TRY(make(&pairs->wall_slot[w], n, sizeof **pairs->wall_slot, error));
    }
    if (wants & RY_PAIRS_SHIFTS) { /* any non-NULL arrays tell ry_pairs_reserve that shifts are wanted */
        RY_TRY(make(&pairs->sx, 1, sizeof *pairs->sx, error));
        RY_TRY(make(&pairs->sz, 1, sizeof *pairs->sz, error));
    }
    if (wants & RY_PAIRS_RESTS) {
        RY_TRY(make(&pairs->rest, 1, sizeof(double), error));
    }
    if (wants & RY_PAIRS_WET) {
        RY_TRY(make(&pairs->wet, 1, sizeof(double), error));
    }
    if (wants & RY_PAIRS_YOUNG) {
        RY_TRY(make(&pairs->young, 1, sizeof *pairs->young, error));
    }
    if (wants & RY_PAIRS_BONDS) {
        RY_TRY(make(&pairs->b_a, 1, sizeof(double), error)); /* likewise */
    }
    if (wants & RY_PAIRS_LEDGER) {
        RY_TRY(make(&pairs->t_nx, 1, sizeof(double), error)); /* likewise */
    }
    return ry_pairs_reserve(pairs, 1, error);
}

ry_status ry_pairs_reserve(ry_pairs *pairs, size_t n, ry_error *error)
{
    if (n <= pairs->capacity) {
        return RY_OK;
    }
    const size_t room = n + n / 32 + 256;
    pairs->capacity = 0;
    RY_TRY(make(&pairs->i, room, sizeof *pairs->i, error));
    RY_TRY(make(&pairs->j, room, sizeof *pairs->j, error));
    RY_TRY(make(&pairs->below, room, sizeof *pairs->below, error));
    RY_TRY(make(&pairs->slip, room, sizeof *pairs->slip, error));
    if (pairs->rest != NULL) {
        RY_TRY(make(&pairs->rest, room, sizeof *pairs->rest, error));
    }
    RY_TRY(make(&pairs->age, room, sizeof *pairs->age, error));
    if (pairs->wet != NULL) {
        RY_TRY(make(&pairs->wet, room, sizeof *pairs->wet, error));
    }
    if (pairs->sx != NULL) {
        RY_TRY(make(&pairs->sx, room, sizeof *pairs->sx, error));
        RY_TRY(make(&pairs->sz, room, sizeof *pairs->sz, error));
    }
#define RY_TOUCH_MAKE(name, unit, text) RY_TRY(make(&pairs->t_##name, room, sizeof(double), error));
    if (pairs->t_nx != NULL) {
        RY_TOUCH_FIELDS(RY_TOUCH_MAKE)
    }
#undef RY_TOUCH_MAKE
#define RY_BOND_MAKE(name) RY_TRY(make(&pairs->b_##name, room, sizeof(double), error));
    if (pairs->b_a != NULL) {
        RY_BOND_FIELDS(RY_BOND_MAKE)
    }
#undef RY_BOND_MAKE
    if (pairs->young != NULL) {
        RY_TRY(make(&pairs->young, room, sizeof *pairs->young, error));
        RY_TRY(make(&pairs->young_age, room, sizeof *pairs->young_age, error));
    }
    pairs->capacity = room;
    return RY_OK;
}

ry_status ry_pairs_reserve_slots(ry_pairs *pairs, size_t n, ry_error *error)
{
    if (n <= pairs->n_slots) {
        return RY_OK;
    }
    const size_t room = n + n / 32 + 256;
    pairs->n_slots = 0;
    RY_TRY(make(&pairs->slot, room, sizeof *pairs->slot, error));
    pairs->n_slots = room;
    return RY_OK;
}

const double *ry_pairs_slot(const ry_pairs *pairs, int32_t pair)
{
    int chunk = pair < pairs->n_inner ? 0 : pairs->n_chunks, past = pairs->n_chunks;
    while (chunk + 1 < past) { /* chunk[chunk] <= pair < chunk[past] */
        const int middle = (chunk + past) / 2;
        if (pair < pairs->chunk[middle]) {
            past = middle;
        } else {
            chunk = middle;
        }
    }
    return pairs->slot[ry_shelf_slot(&pairs->shelf[chunk], pair)];
}

/* The first of the entries begin .. end-1 of `young`, which ascend, that is `pair` or later; likely it is `guess`. */
static int32_t find_young(const int32_t *young, int32_t begin, int32_t end, int32_t guess, int32_t pair)
{
    const int follows = guess >= begin && guess <= end && (guess == begin || young[guess - 1] < pair);
    if (follows && (guess == end || young[guess] >= pair)) {
        return guess;
    }
    while (begin < end) {
        const int32_t middle = begin + (end - begin) / 2;
        if (young[middle] < pair) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return begin;
}

ry_entries ry_pairs_young(const ry_pairs *pairs, int32_t first, int32_t end, int chunk)
{
    const int32_t from = chunk < pairs->n_chunks ? pairs->chunk[chunk] : pairs->n_inner;
    const int32_t to = from + pairs->n_young[chunk];
    ry_entries found;
    found.begin = find_young(pairs->young, from, to, pairs->young_next[chunk], first);
    found.end = found.begin;
    while (found.end < to && pairs->young[found.end] < end) {
        found.end++;
    }
    pairs->young_next[chunk] = found.end;
    return found;
}

void ry_pairs_free(ry_pairs *pairs)
{
    void *const arrays[] = {pairs->place, pairs->i,     pairs->j,        pairs->slip,
                            pairs->rest,  pairs->age,   pairs->slot,  pairs->sx,       pairs->sz,
                            pairs->row,   pairs->below, pairs->chunk, pairs->young, pairs->n_young, pairs->young_age,
                            pairs->young_next, pairs->shelf,
                            pairs->below_start, pairs->wet};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    for (int w = 0; w < RY_MAX_WALLS; w++) {
        free(pairs->wall_slot[w]);
    }
#define RY_TOUCH_FREE(name, unit, text) free(pairs->t_##name);
    RY_TOUCH_FIELDS(RY_TOUCH_FREE)
#undef RY_TOUCH_FREE
#define RY_BOND_FREE(name) free(pairs->b_##name);
    RY_BOND_FIELDS(RY_BOND_FREE)
#undef RY_BOND_FREE
    *pairs = (ry_pairs){0};
}

static void export_slot(const ry_pairs *pairs, int32_t slot, int32_t id_i, int32_t id_j,
                        ry_contacts *out)
{
    if (out->sleeps) {
        out->frozen_x[out->n] = out->frozen_z[out->n] = out->frozen_turn[out->n] = 0.0;
    }
    out->id_i[out->n] = id_i;
    out->id_j[out->n] = id_j;
    out->slip[out->n] = pairs->slip[slot];
    if (pairs->rest != NULL) {
        out->rest[out->n] = pairs->rest[slot];
    }
    out->age[out->n] = pairs->age[slot];
    if (pairs->wet != NULL) {
        out->wet[out->n] = pairs->wet[slot];
    }
    out->n++;
}

ry_status ry_pairs_export(const ry_pairs *pairs, const int32_t *id, ry_contacts *out, ry_error *error)
{
    int64_t touching = 0;
    for (int32_t p = 0; p < pairs->n; p++) {
        touching += pairs->age[p] != 0;
    }
    out->n = 0;
    out->is_wet = pairs->wet != NULL;
    if (pairs->rest == NULL) {
        ry_contacts_drop_rest(out);
    }
    RY_TRY(ry_contacts_reserve(out, touching, error));
    for (int32_t id_i = 0; id_i < pairs->n_grains; id_i++) {
        const int32_t k = pairs->place[id_i];
        for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
            if (pairs->age[p] != 0) {
                export_slot(pairs, p, id_i, id[pairs->j[p]], out);
            }
        }
        for (int w = 0; w < RY_MAX_WALLS && pairs->wall_slot[w] != NULL; w++) {
            const int32_t p = pairs->wall_slot[w][k];
            if (p >= 0 && pairs->age[p] != 0) {
                export_slot(pairs, p, id_i, pairs->n_grains + w, out);
            }
        }
    }
    return RY_OK;
}

static int32_t find_slot(const ry_pairs *pairs, const int32_t *id, int32_t id_i, int32_t id_j)
{
    const int32_t k = pairs->place[id_i];
    if (id_j >= pairs->n_grains) {
        return pairs->wall_slot[id_j - pairs->n_grains][k];
    }
    for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
        if (id[pairs->j[p]] == id_j) {
            return p;
        }
    }
    return -1;
}

void ry_pairs_import_one(ry_pairs *pairs, const int32_t *id, const ry_contacts *from, int64_t c)
{
    const int32_t p = find_slot(pairs, id, from->id_i[c], from->id_j[c]);
    if (p < 0) { /* parted since, and so closed anyway; or of two that sleep */
        return;
    }
    pairs->slip[p] = from->slip[c];
    if (pairs->rest != NULL) {
        pairs->rest[p] = from->rest != NULL ? from->rest[c] : 0.0;
    }
    pairs->age[p] = from->age[c];
    if (pairs->wet != NULL && from->wet != NULL) {
        pairs->wet[p] = from->wet[c];
    }
}

void ry_pairs_import(ry_pairs *pairs, const ry_state *state)
{
    for (int64_t c = 0; c < state->contacts.n; c++) {
        ry_pairs_import_one(pairs, state->grains.id, &state->contacts, c);
    }
}
