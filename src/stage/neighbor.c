/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The grid is numbered column by column, so that the three cells of a column which a grain must look
 * at are one run of `member`. Ids, not places, order what comes out: the list is the same for any
 * number of threads and any storage order. */
#include "stage/neighbor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"

ry_status ry_neighbor_create(ry_neighbor *b, const ry_grains *grains, int threads, ry_error *error)
{
    const size_t n = (size_t)grains->n;
    b->threads = threads;
    b->radius_max = 0.0;
    for (size_t k = 0; k < n; k++) {
        b->radius_max = fmax(b->radius_max, grains->radius[k]);
    }
    b->x0 = ry_array(n, sizeof(double));
    b->z0 = ry_array(n, sizeof(double));
    b->cell_of = ry_array(n, sizeof(int32_t));
    b->member = ry_array(n, sizeof(int32_t));
    b->member_id = ry_array(n, sizeof(int32_t));
    b->member_x = ry_array(n, sizeof(double));
    b->member_z = ry_array(n, sizeof(double));
    b->member_r = ry_array(n, sizeof(double));
    b->row_length = ry_array(n, sizeof(int32_t));
    b->old.row = ry_array(n + 1, sizeof(int32_t));
    b->found = ry_array((size_t)threads, sizeof *b->found);
    int whole = b->x0 && b->z0 && b->cell_of && b->member && b->member_id && b->member_x &&
                b->member_z && b->member_r && b->row_length && b->old.row && b->found;
    for (int w = 0; w < b->n_walls; w++) {
        b->old.wall_slot[w] = ry_array(n, sizeof(int32_t));
        whole = whole && b->old.wall_slot[w];
    }
    return whole ? RY_OK : ry_no_memory(error, n * 80);
}

void ry_neighbor_free(ry_neighbor *b)
{
    void *const arrays[] = {b->x0,       b->z0,       b->cell_of,  b->member,     b->member_id,
                            b->member_x, b->member_z, b->member_r, b->row_length, b->cell_start,
                            b->old.row,  b->old.j,    b->old.slip, b->old.rest,   b->old.age,
                            b->old.wet};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    for (int w = 0; w < RY_MAX_WALLS; w++) {
        free(b->old.wall_slot[w]);
    }
    for (int t = 0; b->found != NULL && t < b->threads; t++) {
        free(b->found[t].j);
    }
    free(b->found);
    *b = (ry_neighbor){0};
}

/* ---- the grid ------------------------------------------------------------------------------- */

/* Cells at least as large as the reach of a pair; larger where the grains lie so far apart that
 * cells would outnumber them. */
static ry_status lay_grid(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    double left = b->periodic ? 0.0 : INFINITY, right = b->periodic ? b->length : -INFINITY;
    double bottom = INFINITY, top = -INFINITY;
    for (int32_t k = 0; k < g->n; k++) {
        left = fmin(left, g->x[k]);
        right = fmax(right, g->x[k]);
        bottom = fmin(bottom, g->z[k]);
        top = fmax(top, g->z[k]);
    }
    const double reach = 2.0 * b->radius_max + b->skin;
    const double most = 4096.0 + 2.0 * (double)g->n;
    const double width = right - left, height = top - bottom;
    double columns = fmax(1.0, floor(width / reach)), rows = fmax(1.0, floor(height / reach) + 1.0);
    if (columns * rows > most) { /* first thin out rows, then columns */
        rows = fmax(1.0, fmin(rows, floor(most / columns)));
        columns = fmax(1.0, fmin(columns, floor(most / rows)));
    }
    b->columns = (int32_t)columns;
    b->rows = (int32_t)rows;
    b->left = left;
    b->bottom = bottom;
    b->cell_x = fmax(width / columns, reach);
    if (b->periodic) {
        b->cell_x = width / columns;
    }
    b->cell_z = fmax(height / rows, reach);
    return ry_array_grow(&b->cell_start, &b->n_cells_room, 0,
                         (size_t)b->columns * (size_t)b->rows + 1, sizeof *b->cell_start, error);
}

static int32_t clamp_cell(double position, int32_t n)
{
    const int32_t cell = position > 0.0 ? (int32_t)fmin(position, 2e9) : 0;
    return cell < n ? cell : n - 1;
}

/* Counting sort of the grains by cell. */
static void fill_grid(ry_neighbor *b, const ry_grains *g)
{
    const int32_t n_cells = b->columns * b->rows;
    memset(b->cell_start, 0, ((size_t)n_cells + 1) * sizeof *b->cell_start);
    for (int32_t k = 0; k < g->n; k++) {
        const int32_t column = clamp_cell((g->x[k] - b->left) / b->cell_x, b->columns);
        const int32_t row = clamp_cell((g->z[k] - b->bottom) / b->cell_z, b->rows);
        b->cell_of[k] = column * b->rows + row;
        b->cell_start[b->cell_of[k]]++;
    }
    int32_t sum = 0;
    for (int32_t c = 0; c <= n_cells; c++) {
        const int32_t count = c < n_cells ? b->cell_start[c] : 0;
        b->cell_start[c] = sum;
        sum += count;
    }
    for (int32_t k = 0; k < g->n; k++) {
        b->member[b->cell_start[b->cell_of[k]]++] = k;
    }
    for (int32_t c = n_cells; c > 0; c--) {
        b->cell_start[c] = b->cell_start[c - 1];
    }
    b->cell_start[0] = 0;
    for (int32_t m = 0; m < g->n; m++) {
        const int32_t k = b->member[m];
        b->member_x[m] = g->x[k];
        b->member_z[m] = g->z[k];
        b->member_r[m] = g->radius[k] + b->skin;
        b->member_id[m] = g->id[k];
    }
}

/* ---- the pairs ------------------------------------------------------------------------------ */

/* Appends the members first..last-1 that have a higher id than k and are near it. */
static size_t near_in_run(const ry_neighbor *b, const ry_grains *g, int32_t k, int32_t first,
                          int32_t last, int32_t *out, size_t n)
{
    const double x = g->x[k], z = g->z[k], length = b->length;
    const double half = b->periodic ? 0.5 * length : INFINITY;
    const double reach = g->radius[k];
    const int32_t id = g->id[k];
    for (int32_t m = first; m < last; m++) {
        double dx = b->member_x[m] - x;
        dx = dx > half ? dx - length : (dx < -half ? dx + length : dx);
        const double dz = b->member_z[m] - z;
        const double far = b->member_r[m] + reach;
        out[n] = b->member[m];
        n += (size_t)((dx * dx + dz * dz < far * far) & (b->member_id[m] > id));
    }
    return n;
}

static void sort_by_id(int32_t *j, size_t n, const int32_t *id)
{
    for (size_t p = 1; p < n; p++) {
        const int32_t moving = j[p];
        size_t q = p;
        for (; q > 0 && id[j[q - 1]] > id[moving]; q--) {
            j[q] = j[q - 1];
        }
        j[q] = moving;
    }
}

/* Two fixed grains make no pair. */
static size_t drop_fixed(const ry_grains *g, int32_t *j, size_t n)
{
    size_t kept = 0;
    for (size_t p = 0; p < n; p++) {
        j[kept] = j[p];
        kept += !g->fixed[j[p]];
    }
    return kept;
}

static ry_status find_of_grain(ry_neighbor *b, const ry_grains *g, int32_t k, struct ry_found *found,
                               ry_error *error)
{
    const int32_t column = b->cell_of[k] / b->rows, row = b->cell_of[k] % b->rows;
    const int32_t low = row > 0 ? row - 1 : 0, high = row + 1 < b->rows ? row + 1 : row;
    const int32_t spread = b->columns > 2 ? 1 : 0; /* one or two columns: look at each once */
    const int32_t first = b->columns == 2 ? 0 : column - spread;
    const int32_t last = b->columns == 2 ? 1 : column + spread;
    size_t n = found->n;
    for (int32_t c = first; c <= last; c++) {
        const int32_t wrapped = c < 0 ? c + b->columns : (c >= b->columns ? c - b->columns : c);
        if (wrapped != c && !b->periodic) {
            continue;
        }
        const int32_t from = b->cell_start[wrapped * b->rows + low];
        const int32_t to = b->cell_start[wrapped * b->rows + high + 1];
        RY_TRY(ry_array_grow(&found->j, &found->room, n, n + (size_t)(to - from) + 1,
                             sizeof *found->j, error));
        n = near_in_run(b, g, k, from, to, found->j, n);
    }
    size_t own = n - found->n;
    if (g->fixed[k]) {
        own = drop_fixed(g, found->j + found->n, own);
    }
    sort_by_id(found->j + found->n, own, g->id);
    b->row_length[k] = (int32_t)own;
    found->n += own;
    return RY_OK;
}

typedef struct ry_find_task {
    ry_neighbor *neighbor;
    const ry_grains *grains;
    ry_pairs *pairs;
    int failed;
} ry_find_task;

static ry_status find_range(ry_neighbor *b, const ry_grains *g, int32_t begin, int32_t end,
                            struct ry_found *found)
{
    const size_t usual = (size_t)(end - begin) * 4; /* so that the array rarely grows */
    RY_TRY(ry_array_grow(&found->j, &found->room, 0, usual + 1, sizeof(int32_t), NULL));
    found->n = 0;
    for (int32_t k = begin; k < end; k++) {
        RY_TRY(find_of_grain(b, g, k, found, NULL));
    }
    return RY_OK;
}

static void find_grains(void *context, int32_t begin, int32_t end, int thread)
{
    ry_find_task *const t = context;
    if (find_range(t->neighbor, t->grains, begin, end, &t->neighbor->found[thread]) != RY_OK) {
#pragma omp atomic write
        t->failed = 1;
    }
}

static ry_status find_all(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    ry_find_task task = {.neighbor = b, .grains = g};
    ry_parallel(b->threads, g->n, find_grains, &task);
    return !task.failed ? RY_OK : ry_no_memory(error, (size_t)g->n * 64);
}

/* ---- the list ------------------------------------------------------------------------------- */

/* Distance of a grain's centre from a wall. */
static double wall_distance(const ry_neighbor *b, ry_wall wall, const ry_grains *g, int32_t k)
{
    return wall == RY_WALL_FLOOR ? g->z[k] : (wall == RY_WALL_LEFT ? g->x[k] : b->length - g->x[k]);
}

static int near_wall(const ry_neighbor *b, int w, const ry_grains *g, int32_t k)
{
    return !g->fixed[k] && wall_distance(b, b->wall[w], g, k) < g->radius[k] + b->skin;
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

/* Keeps the memory of the list while it is filled anew. */
static ry_status set_memory_aside(ry_neighbor *b, ry_pairs *pairs, ry_error *error)
{
    struct ry_old *const old = &b->old;
    if (old->room < pairs->capacity) {
        free(old->j);
        free(old->slip);
        free(old->rest);
        free(old->age);
        free(old->wet);
        old->j = ry_array(pairs->capacity, sizeof *old->j);
        old->slip = ry_array(pairs->capacity, sizeof *old->slip);
        old->rest = ry_array(pairs->capacity, sizeof *old->rest);
        old->age = ry_array(pairs->capacity, sizeof *old->age);
        old->wet = pairs->wet != NULL ? ry_array(pairs->capacity, sizeof *old->wet) : NULL;
        if (!old->j || !old->slip || !old->rest || !old->age || (pairs->wet != NULL && !old->wet)) {
            return ry_no_memory(error, pairs->capacity * 21);
        }
        old->room = pairs->capacity;
    }
    const size_t n = (size_t)pairs->n;
    memcpy(old->row, pairs->row, ((size_t)pairs->n_grains + 1) * sizeof *old->row);
    memcpy(old->j, pairs->j, n * sizeof *old->j);
    memcpy(old->slip, pairs->slip, n * sizeof *old->slip);
    memcpy(old->rest, pairs->rest, n * sizeof *old->rest);
    memcpy(old->age, pairs->age, n * sizeof *old->age);
    if (pairs->wet != NULL) {
        memcpy(old->wet, pairs->wet, n * sizeof *old->wet);
    }
    for (int w = 0; w < b->n_walls; w++) {
        memcpy(old->wall_slot[w], pairs->wall_slot[w], (size_t)pairs->n_grains * sizeof(int32_t));
    }
    return RY_OK;
}

static void take_over(ry_pairs *pairs, int32_t slot, const struct ry_old *old, int32_t from)
{
    pairs->slip[slot] = from >= 0 ? old->slip[from] : 0.0;
    pairs->rest[slot] = from >= 0 ? old->rest[from] : 0.0;
    pairs->age[slot] = from >= 0 ? old->age[from] : 0;
    if (pairs->wet != NULL) {
        pairs->wet[slot] = from >= 0 ? old->wet[from] : 0.0;
    }
}

/* Rows of owner k, old and new, are both sorted by the partner's id: one merge. */
static void fill_row(const ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, int32_t k,
                     const int32_t *partners)
{
    const struct ry_old *const old = &b->old;
    int32_t from = old->row[k];
    const int32_t end = old->row[k + 1];
    const int32_t first = pairs->row[k];
    for (int32_t m = 0; m < b->row_length[k]; m++) {
        const int32_t j = partners[m];
        while (from < end && g->id[old->j[from]] < g->id[j]) {
            from++;
        }
        pairs->i[first + m] = k;
        pairs->j[first + m] = j;
        take_over(pairs, first + m, old, from < end && old->j[from] == j ? from : -1);
    }
}

static void fill_grains(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_find_task *const t = context;
    const int32_t *partners = t->neighbor->found[thread].j;
    for (int32_t k = begin; k < end; k++) {
        fill_row(t->neighbor, t->grains, t->pairs, k, partners);
        partners += t->neighbor->row_length[k];
    }
}

static void fill_rows(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs)
{
    ry_find_task task = {.neighbor = b, .grains = g, .pairs = pairs};
    ry_parallel(b->threads, g->n, fill_grains, &task);
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
                take_over(pairs, slot, &b->old, had_list ? b->old.wall_slot[w][k] : -1);
                pairs->wall_slot[w][k] = slot++;
            }
        }
    }
}

/* For each grain the slots in which it is the partner, in ascending id of the owner. */
static void fill_below(const ry_grains *g, ry_pairs *pairs)
{
    int32_t *const start = pairs->below_start;
    memset(start, 0, ((size_t)g->n + 1) * sizeof *start);
    for (int32_t p = 0; p < pairs->n_inner; p++) {
        start[pairs->j[p]]++;
    }
    int32_t sum = 0;
    for (int32_t k = 0; k <= g->n; k++) {
        const int32_t count = k < g->n ? start[k] : 0;
        start[k] = sum;
        sum += count;
    }
    for (int32_t id = 0; id < g->n; id++) {
        const int32_t k = pairs->place[id];
        for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
            pairs->below[start[pairs->j[p]]++] = p;
        }
    }
    for (int32_t k = g->n; k > 0; k--) {
        start[k] = start[k - 1];
    }
    start[0] = 0;
}

/* Cuts the list into chunks that end where a row ends; the pairs with walls come last. */
static void cut_chunks(ry_pairs *pairs)
{
    int32_t n = 0;
    pairs->chunk[0] = 0;
    for (int32_t k = 0; k < pairs->n_grains; k++) {
        if (pairs->row[k + 1] - pairs->chunk[n] >= RY_CHUNK) {
            pairs->chunk[++n] = pairs->row[k + 1];
        }
    }
    if (pairs->n_inner > pairs->chunk[n]) {
        pairs->chunk[++n] = pairs->n_inner;
    }
    pairs->n_chunks = n;
}

ry_status ry_neighbor_rebuild(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, ry_error *error)
{
    const int had_list = b->rebuilds > 0;
    RY_TRY(lay_grid(b, g, error));
    fill_grid(b, g);
    RY_TRY(find_all(b, g, error));
    RY_TRY(set_memory_aside(b, pairs, error));

    int32_t sum = 0;
    for (int32_t k = 0; k < g->n; k++) {
        pairs->row[k] = sum;
        sum += b->row_length[k];
        pairs->place[g->id[k]] = k;
    }
    pairs->row[g->n] = sum;
    pairs->n_inner = sum;
    pairs->n = sum + count_wall_pairs(b, g);
    RY_TRY(ry_pairs_reserve(pairs, (size_t)pairs->n, error));
    fill_rows(b, g, pairs);
    fill_walls(b, g, pairs, had_list);
    fill_below(g, pairs);
    cut_chunks(pairs);

    const size_t bytes = (size_t)pairs->n * sizeof(double);
    memset(pairs->slot, 0, (size_t)pairs->n * sizeof *pairs->slot);
    if (pairs->sx != NULL) {
        memset(pairs->sx, 0, bytes);
        memset(pairs->sz, 0, bytes);
    }
    memcpy(b->x0, g->x, (size_t)g->n * sizeof(double));
    memcpy(b->z0, g->z, (size_t)g->n * sizeof(double));
    b->rebuilds++;
    return RY_OK;
}
