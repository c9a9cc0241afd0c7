/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/neighbor_private.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

ry_status ry_neighbor_create(ry_neighbor *b, const ry_grains *grains, int threads, ry_error *error)
{
    const size_t n = (size_t)grains->n;
    b->threads = threads;
    b->still = grains->fixed;
    b->radius_max = 0.0;
    for (size_t k = 0; k < n; k++) {
        b->radius_max = fmax(b->radius_max, grains->radius[k]);
    }
    b->x0 = ry_array(n, sizeof(double));
    b->z0 = ry_array(n, sizeof(double));
    b->limit2 = ry_array(n, sizeof *b->limit2);
    b->found = ry_array((size_t)threads, sizeof *b->found);
    int whole = b->x0 && b->z0 && b->limit2 && b->found;
    for (int w = 0; w < b->n_walls; w++) {
        b->old.wall_slot[w] = ry_array(n, sizeof(int32_t));
        whole = whole && b->old.wall_slot[w];
    }
    return whole ? RY_OK : ry_no_memory(error, n * 40);
}

static void free_old(struct ry_old *old)
{
    void *const arrays[] = {old->slip, old->rest, old->age, old->wet};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
}

void ry_neighbor_free(ry_neighbor *b)
{
    void *const arrays[] = {b->x0, b->z0, b->limit2, b->own_member, b->cell_start, b->old.row, b->old.j, b->busy};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    for (int w = 0; w < RY_MAX_WALLS; w++) {
        free(b->old.wall_slot[w]);
    }
    for (int t = 0; b->found != NULL && t < b->threads; t++) {
        free(b->found[t].near);
    }
    free_old(&b->old);
    free(b->found);
    *b = (ry_neighbor){0};
}

/* ---- the list ------------------------------------------------------------------------------- */

/* Distance of a grain's centre from a wall. */
static double wall_distance(const ry_neighbor *b, ry_wall wall, const ry_grains *g, int32_t k)
{
    return wall == RY_WALL_FLOOR ? g->z[k] : (wall == RY_WALL_LEFT ? g->x[k] : b->length - g->x[k]);
}

static int near_wall(const ry_neighbor *b, int w, const ry_grains *g, int32_t k)
{
    return !b->still[k] && wall_distance(b, b->wall[w], g, k) < ry_neighbor_reach(b, g, k);
}

static int32_t count_wall_pairs(const ry_neighbor *b, const ry_grains *g)
{
    int32_t n = 0;
    for (int w = 0; w < b->n_walls; w++) {
        for (int32_t k = 0; k < g->n; k++) {
            n += near_wall(b, w, g, k);
        }
    }
    return n;
}

static void swap(void *p, void *q)
{
    void *kept;
    memcpy(&kept, p, sizeof kept);
    memcpy(p, q, sizeof kept);
    memcpy(q, &kept, sizeof kept);
}

/* Keeps the memory of the list while it is filled anew: the arrays change places. What follows from others gives its
 * array for the time: the new partners are found into that of the owners, the new rows into that of the places. */
static ry_status set_memory_aside(ry_neighbor *b, ry_pairs *pairs, ry_error *error)
{
    struct ry_old *const old = &b->old;
    if (old->room < pairs->capacity) {
        free_old(old);
        old->room = 0;
        old->slip = ry_array(pairs->capacity, sizeof *old->slip);
        old->rest = pairs->rest != NULL ? ry_array(pairs->capacity, sizeof *old->rest) : NULL;
        old->age = ry_array(pairs->capacity, sizeof *old->age);
        old->wet = pairs->wet != NULL ? ry_array(pairs->capacity, sizeof *old->wet) : NULL;
        if (!old->slip || !old->age || (pairs->rest != NULL && !old->rest) || (pairs->wet != NULL && !old->wet)) {
            return ry_no_memory(error, pairs->capacity * 17);
        }
        old->room = pairs->capacity;
    }
    old->j = pairs->j;
    pairs->j = pairs->i;
    pairs->i = NULL;
    old->row = pairs->row;
    pairs->row = pairs->place;
    pairs->place = NULL;
    swap(&old->slip, &pairs->slip);
    swap(&old->rest, &pairs->rest);
    swap(&old->age, &pairs->age);
    swap(&old->wet, &pairs->wet);
    for (int w = 0; w < b->n_walls; w++) {
        swap(&old->wall_slot[w], &pairs->wall_slot[w]);
    }
    return RY_OK;
}

/* A part of an array for each thread: as much as it found last time, and a share of the rest. */
static struct ry_part lay_part(int32_t *array, size_t *at, size_t last, size_t rest)
{
    const struct ry_part part = {.j = array + *at, .room = last + rest};
    *at += part.room;
    return part;
}

static void lay_parts(ry_neighbor *b, const ry_pairs *pairs)
{
    size_t all = 0, above = 0, below = 0; /* each pair was found above one grain and below the other */
    for (int t = 0; t < b->threads; t++) {
        all += b->found[t].above.n;
    }
    const int fits = all <= pairs->capacity;
    const size_t rest = (pairs->capacity - (fits ? all : 0)) / (size_t)b->threads;
    for (int t = 0; t < b->threads; t++) {
        struct ry_found *const found = &b->found[t];
        found->above = lay_part(pairs->j, &above, fits ? found->above.n : 0, rest);
        found->below = lay_part(pairs->below, &below, fits ? found->below.n : 0, rest);
    }
}

static int is_full(const ry_neighbor *b)
{
    int full = 0;
    for (int t = 0; t < b->threads; t++) {
        full |= b->found[t].above.full | b->found[t].below.full;
    }
    return full;
}

static void close_up(ry_neighbor *b, const ry_pairs *pairs)
{
    size_t above = b->found[0].above.n, below = b->found[0].below.n;
    for (int t = 1; t < b->threads; t++) {
        const struct ry_found *const found = &b->found[t];
        memmove(pairs->j + above, found->above.j, found->above.n * sizeof *pairs->j);
        memmove(pairs->below + below, found->below.j, found->below.n * sizeof *pairs->below);
        above += found->above.n;
        below += found->below.n;
    }
}

static void take_over(ry_pairs *pairs, int32_t slot, const struct ry_old *old, int32_t from)
{
    pairs->slip[slot] = from >= 0 ? old->slip[from] : 0.0;
    pairs->age[slot] = from >= 0 ? old->age[from] : 0;
    if (pairs->rest != NULL) {
        pairs->rest[slot] = from >= 0 ? old->rest[from] : 0.0;
    }
    if (pairs->wet != NULL) {
        pairs->wet[slot] = from >= 0 ? old->wet[from] : 0.0;
    }
}

/* Rows of owner k, old and new, are both sorted by the partner's id: one merge. */
static void fill_row(const ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, int32_t k)
{
    const struct ry_old *const old = &b->old;
    const int32_t then = b->was != NULL ? b->was[k] : k;
    int32_t from = old->row[then];
    const int32_t end = old->row[then + 1];
    for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
        const int32_t j = pairs->j[p];
        while (from < end && g->id[old->j[from]] < g->id[j]) {
            from++;
        }
        take_over(pairs, p, old, from < end && old->j[from] == j ? from : -1);
    }
}

typedef struct ry_fill_task {
    const ry_neighbor *neighbor;
    const ry_grains *grains;
    ry_pairs *pairs;
} ry_fill_task;

static void fill_rows(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_fill_task *const t = context;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        fill_row(t->neighbor, t->grains, t->pairs, k);
    }
}

/* Old partners and rows are not wanted any more: owners and places take their arrays. */
static void take_back(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs)
{
    if (pairs->i == NULL) { /* else the list has grown */
        swap(&pairs->i, &b->old.j);
    }
    free(b->old.j);
    b->old.j = NULL;
    swap(&pairs->place, &b->old.row);
    for (int32_t k = 0; k < g->n; k++) {
        pairs->place[g->id[k]] = k;
    }
}

static void fill_walls(const ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, int had_list)
{
    int32_t slot = pairs->n_inner;
    for (int w = 0; w < b->n_walls; w++) {
        for (int32_t k = 0; k < g->n; k++) {
            pairs->wall_slot[w][k] = -1;
            if (near_wall(b, w, g, k)) {
                pairs->i[slot] = k;
                pairs->j[slot] = g->n + w;
                take_over(pairs, slot, &b->old, had_list ? b->old.wall_slot[w][b->was != NULL ? b->was[k] : k] : -1);
                pairs->wall_slot[w][k] = slot++;
            }
        }
    }
}

/* From the lengths of the rows to where they start. */
static void lay_rows(const ry_grains *g, ry_pairs *pairs)
{
    int32_t above = 0, below = 0;
    for (int32_t k = 0; k < g->n; k++) {
        const int32_t n_above = pairs->row[k], n_below = pairs->below_start[k];
        pairs->row[k] = above;
        pairs->below_start[k] = below;
        above += n_above;
        below += n_below;
    }
    pairs->row[g->n] = above;
    pairs->below_start[g->n] = below;
    pairs->n_inner = ry_pairs_fill(above) + RY_LANES; /* the last chunk may start anywhere */
}

/* The pairs from .. end-1 are nobody's: of a wall with itself. */
static void fill_up(ry_pairs *pairs, int32_t from, int32_t end)
{
    for (int32_t p = from; p < end; p++) {
        pairs->i[p] = pairs->j[p] = pairs->n_grains;
        take_over(pairs, p, NULL, -1);
    }
}

/* Partners, and who has a grain for a partner, in place. The grid's scratch is the stretches, which are not in use
 * before the memory is given back, unless they are too short. */
static ry_status find_once(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, ry_error *error)
{
    const size_t bytes = ry_grid_scratch(g->n);
    const int is_short = bytes > pairs->capacity * sizeof *pairs->slip;
    void *const scratch = is_short ? ry_array(bytes, 1) : pairs->slip;
    if (scratch == NULL) {
        return ry_no_memory(error, bytes);
    }
    ry_grid_fill(b, g, scratch);
    lay_parts(b, pairs);
    const int found = ry_partners_find(b, g, pairs);
    if (is_short) {
        free(scratch);
    }
    if (!found) {
        return ry_no_memory(error, (size_t)g->n * 64);
    }
    lay_rows(g, pairs);
    pairs->n = pairs->n_inner + count_wall_pairs(b, g);
    return RY_OK;
}

/* What does not fit is counted, and found again with more room. */
static ry_status find_pairs(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, ry_error *error)
{
    for (int fits = 0; !fits;) {
        RY_TRY(find_once(b, g, pairs, error));
        const size_t wanted = (size_t)ry_pairs_fill(pairs->n) + (size_t)b->threads * 2 * RY_SPARE;
        fits = !is_full(b) && wanted <= pairs->capacity;
        RY_TRY(ry_pairs_reserve(pairs, wanted, error));
    }
    close_up(b, pairs);
    return RY_OK;
}

ry_status ry_neighbor_rebuild(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, ry_error *error)
{
    const int had_list = b->rebuilds > 0;
    ry_fill_task task = {.neighbor = b, .grains = g, .pairs = pairs};
    RY_TRY(ry_grid_lay(b, g, error));
    RY_TRY(set_memory_aside(b, pairs, error));
    RY_TRY(find_pairs(b, g, pairs, error));
    ry_parallel(b->threads, g->n, fill_rows, &task);
    take_back(b, g, pairs);
    ry_parallel(b->threads, g->n, ry_partners_link, pairs);
    fill_walls(b, g, pairs, had_list);
    fill_up(pairs, pairs->row[g->n], pairs->n_inner);
    fill_up(pairs, pairs->n, ry_pairs_fill(pairs->n));
    memcpy(b->x0, g->x, (size_t)g->n * sizeof(double));
    memcpy(b->z0, g->z, (size_t)g->n * sizeof(double));
    b->rebuilds++;
    pairs->bonds_made = 0;
    return b->blocks != NULL ? ry_blocks_lay(b->blocks, pairs, error) : RY_OK;
}
