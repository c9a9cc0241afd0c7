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
#include "stage/four.h"

/* Vectors of members may be read beyond the last. */
enum { SPARE = 4 };

/* No grain is listed further out than this beyond the limit at which the list is made anew: rounding. */
#define NEARLY_ONE 0.999

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
    b->limit2 = ry_array(n, sizeof(double));
    b->skin = ry_array(n, sizeof(double));
    b->cell_of = ry_array(n, sizeof(int32_t));
    b->member = ry_array(n + SPARE, sizeof(int32_t));
    b->member_x = ry_array(n + SPARE, sizeof(double));
    b->member_z = ry_array(n + SPARE, sizeof(double));
    b->member_r = ry_array(n + SPARE, sizeof(double));
    b->above = ry_array(n, sizeof(int32_t));
    b->old.row = ry_array(n + 1, sizeof(int32_t));
    b->found = ry_array((size_t)threads, sizeof *b->found);
    int whole = b->x0 && b->z0 && b->limit2 && b->skin && b->cell_of && b->member && b->member_x && b->member_z &&
                b->member_r && b->above && b->old.row && b->found;
    for (int w = 0; w < b->n_walls; w++) {
        b->old.wall_slot[w] = ry_array(n, sizeof(int32_t));
        whole = whole && b->old.wall_slot[w];
    }
    return whole ? RY_OK : ry_no_memory(error, n * 80);
}

static void free_old(struct ry_old *old)
{
    void *const arrays[] = {old->j, old->slip, old->rest, old->age, old->wet};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
}

void ry_neighbor_free(ry_neighbor *b)
{
    void *const arrays[] = {b->x0,       b->z0,       b->limit2,   b->skin,  b->cell_of,    b->member,
                            b->member_x, b->member_z, b->member_r, b->above, b->cell_start, b->old.row,
                            b->busy};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        free(arrays[k]);
    }
    for (int w = 0; w < RY_MAX_WALLS; w++) {
        free(b->old.wall_slot[w]);
    }
    for (int t = 0; b->found != NULL && t < b->threads; t++) {
        free(b->found[t].j);
    }
    free_old(&b->old);
    free(b->found);
    *b = (ry_neighbor){0};
}

/* ---- the grid ------------------------------------------------------------------------------- */

/* How far each grain may go before the list is made anew: fast grains further, so that the few of them don't
 * make the list short-lived, or long, for all. Returns the furthest. */
RY_CLONES static double set_skins(ry_neighbor *b, const ry_grains *g)
{
    const double *const vx = g->vx, *const vz = g->vz;
    double *restrict const skin = b->skin, *restrict const limit2 = b->limit2;
    const double least = b->skin_least, most = b->skin_most, ahead = b->horizon;
    double furthest = 0.0;
#pragma omp simd reduction(max : furthest)
    for (int32_t k = 0; k < g->n; k++) {
        const double way = least + ahead * sqrt(vx[k] * vx[k] + vz[k] * vz[k]);
        const double s = way < most ? way : most;
        skin[k] = s;
        limit2[k] = NEARLY_ONE * s * s;
        furthest = s > furthest ? s : furthest;
    }
    return furthest;
}

typedef struct ry_bounds {
    double left, right, bottom, top;
} ry_bounds;

RY_CLONES static ry_bounds bounds_of(const ry_grains *g)
{
    double left = INFINITY, right = -INFINITY, bottom = INFINITY, top = -INFINITY;
    const double *const x = g->x, *const z = g->z;
#pragma omp simd reduction(min : left, bottom) reduction(max : right, top)
    for (int32_t k = 0; k < g->n; k++) {
        left = x[k] < left ? x[k] : left;
        right = x[k] > right ? x[k] : right;
        bottom = z[k] < bottom ? z[k] : bottom;
        top = z[k] > top ? z[k] : top;
    }
    return (ry_bounds){left, right, bottom, top};
}

/* Cells at least as large as the reach of a pair; larger where the grains lie so far apart that
 * cells would outnumber them. */
static ry_status lay_grid(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    const double reach = 2.0 * (b->radius_max + set_skins(b, g));
    ry_bounds in = bounds_of(g);
    if (b->periodic) {
        in.left = 0.0;
        in.right = b->length;
    }
    const double most = 4096.0 + 2.0 * (double)g->n;
    const double width = in.right - in.left, height = in.top - in.bottom;
    double columns = fmax(1.0, floor(width / reach)), rows = fmax(1.0, floor(height / reach) + 1.0);
    if (columns * rows > most) { /* first thin out rows, then columns */
        rows = fmax(1.0, fmin(rows, floor(most / columns)));
        columns = fmax(1.0, fmin(columns, floor(most / rows)));
    }
    b->columns = (int32_t)columns;
    b->rows = (int32_t)rows;
    b->left = in.left;
    b->bottom = in.bottom;
    b->cell_x = fmax(width / columns, reach);
    if (b->periodic) {
        b->cell_x = width / columns;
    }
    b->cell_z = fmax(height / rows, reach);
    return ry_array_grow(&b->cell_start, &b->n_cells_room, 0,
                         (size_t)b->columns * (size_t)b->rows + 1, sizeof *b->cell_start, error);
}

RY_INLINE int32_t clamp_cell(double position, int32_t n)
{
    const double inside = position > 0.0 ? (position < 2e9 ? position : 2e9) : 0.0;
    const int32_t cell = (int32_t)inside;
    return cell < n ? cell : n - 1;
}

RY_CLONES static void find_cells(const ry_neighbor *b, const ry_grains *g, int32_t *restrict cell_of)
{
    const double *const x = g->x, *const z = g->z;
    const double left = b->left, bottom = b->bottom, per_x = 1.0 / b->cell_x, per_z = 1.0 / b->cell_z;
    const int32_t columns = b->columns, rows = b->rows;
#pragma omp simd
    for (int32_t k = 0; k < g->n; k++) {
        cell_of[k] = clamp_cell((x[k] - left) * per_x, columns) * rows + clamp_cell((z[k] - bottom) * per_z, rows);
    }
}

/* Counting sort of the grains by cell. */
static void fill_grid(ry_neighbor *b, const ry_grains *g)
{
    const int32_t n_cells = b->columns * b->rows;
    memset(b->cell_start, 0, ((size_t)n_cells + 1) * sizeof *b->cell_start);
    find_cells(b, g, b->cell_of);
    for (int32_t k = 0; k < g->n; k++) {
        b->cell_start[b->cell_of[k]]++;
    }
    int32_t sum = 0;
    for (int32_t c = 0; c <= n_cells; c++) {
        const int32_t count = c < n_cells ? b->cell_start[c] : 0;
        b->cell_start[c] = sum;
        sum += count;
    }
    for (int32_t k = 0; k < g->n; k++) {
        const int32_t m = b->cell_start[b->cell_of[k]]++;
        b->member[m] = k;
        b->member_x[m] = g->x[k];
        b->member_z[m] = g->z[k];
        b->member_r[m] = g->radius[k] + b->skin[k];
    }
    memmove(b->cell_start + 1, b->cell_start, (size_t)n_cells * sizeof *b->cell_start);
    b->cell_start[0] = 0;
}

enum { BUSY = 1, DONE = 2 }; /* DONE: its neighbours are marked */

static void mark_around(ry_neighbor *b, int32_t cell)
{
    const int32_t column = cell / b->rows, row = cell % b->rows;
    const int32_t low = row > 0 ? row - 1 : 0, high = row + 1 < b->rows ? row + 1 : row;
    for (int32_t c = column - 1; c <= column + 1; c++) {
        const int32_t wrapped = (c + b->columns) % b->columns; /* where x does not wrap, some cells too many */
        for (int32_t r = low; r <= high; r++) {
            b->busy[wrapped * b->rows + r] |= BUSY;
        }
    }
    b->busy[cell] |= DONE;
}

static ry_status mark_busy(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    const size_t n_cells = (size_t)b->columns * (size_t)b->rows;
    RY_TRY(ry_array_grow(&b->busy, &b->n_busy_room, 0, n_cells, 1, error));
    memset(b->busy, 0, n_cells);
    for (int32_t k = 0; k < g->n; k++) {
        if (!b->still[k] && !(b->busy[b->cell_of[k]] & DONE)) {
            mark_around(b, b->cell_of[k]);
        }
    }
    return RY_OK;
}

/* ---- the pairs ------------------------------------------------------------------------------ */

/* Those of four numbers whose bits are set, first. */
typedef int32_t ry_quad __attribute__((vector_size(4 * sizeof(int32_t))));
static const ry_quad chosen[16] = {{0, 1, 2, 3}, {0, 1, 2, 3}, {1, 0, 2, 3}, {0, 1, 2, 3}, {2, 0, 1, 3}, {0, 2, 1, 3},
                                   {1, 2, 0, 3}, {0, 1, 2, 3}, {3, 0, 1, 2}, {0, 3, 1, 2}, {1, 3, 0, 2}, {0, 1, 3, 2},
                                   {2, 3, 0, 1}, {0, 2, 3, 1}, {1, 2, 3, 0}, {0, 1, 2, 3}};

/* Appends them to `out`, which has room for all four; returns how many they are. */
RY_INLINE size_t append_chosen(const int32_t *four, unsigned bits, int32_t *out)
{
#ifdef __clang__ /* cannot shuffle by what is known late */
    for (int q = 0; q < 4; q++) {
        out[q] = four[chosen[bits][q]];
    }
#else
    ry_quad all;
    memcpy(&all, four, sizeof all);
    all = __builtin_shuffle(all, chosen[bits]);
    memcpy(out, &all, sizeof all);
#endif
    return (size_t)__builtin_popcount(bits);
}

/* Appends the members first .. last-1 that are near grain k, itself among them. */
RY_INLINE size_t near_in_run(const ry_neighbor *b, const ry_grains *g, int32_t k, int32_t first,
                          int32_t last, int32_t *out, size_t n)
{
    const double x = g->x[k], z = g->z[k], length = b->periodic ? b->length : 0.0;
    const double half = b->periodic ? 0.5 * length : INFINITY;
    const double reach = g->radius[k] + b->skin[k];
    for (int32_t m = first; m < last; m += 4) {
        ry_four dx = ry_four_load(b->member_x + m) - x;
        const ry_four dz = ry_four_load(b->member_z + m) - z, far = ry_four_load(b->member_r + m) + reach;
        dx = ry_four_select((ry_four_index)(dx > half), dx - length, dx);
        dx = ry_four_select((ry_four_index)(dx < -half), dx + length, dx);
        const ry_four_index near = (ry_four_index)(dx * dx + dz * dz < far * far);
        const ry_four_index bits = near & (ry_four_index){1, 2, 4, 8};
        const unsigned there = last - m < 4 ? (1u << (last - m)) - 1 : 15;
        n += append_chosen(b->member + m, (unsigned)(bits[0] | bits[1] | bits[2] | bits[3]) & there, out + n);
    }
    return n;
}

/* A grain makes no pair with itself, two that are still make none. */
RY_INLINE size_t drop_pairless(const uint8_t *still, int32_t k, int32_t *j, size_t n)
{
    size_t kept = 0;
    for (size_t p = 0; p < n; p++) {
        j[kept] = j[p];
        kept += !((j[p] == k) | (still[k] & still[j[p]]));
    }
    return kept;
}

/* All partners of grain k in ascending id; above[k]: those it owns, of higher id. */
RY_INLINE ry_status find_of_grain(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, int32_t k,
                               struct ry_found *found, ry_error *error)
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
        RY_TRY(ry_array_grow(&found->j, &found->room, n, n + (size_t)(to - from) + SPARE,
                             sizeof *found->j, error));
        n = near_in_run(b, g, k, from, to, found->j, n);
    }
    int32_t *const j = found->j + found->n;
    const size_t partners = drop_pairless(b->still, k, j, n - found->n);
    ry_sort_by_id(j, partners, g->id);
    int32_t below = 0;
    while (below < (int32_t)partners && g->id[j[below]] < g->id[k]) {
        below++;
    }
    pairs->below_start[k] = below;
    b->above[k] = (int32_t)partners - below;
    found->n += partners;
    return RY_OK;
}

typedef struct ry_find_task {
    ry_neighbor *neighbor;
    const ry_grains *grains;
    ry_pairs *pairs;
    int failed;
} ry_find_task;

RY_CLONES static ry_status find_range(const ry_find_task *t, int32_t begin, int32_t end, struct ry_found *found)
{
    const size_t usual = (size_t)(end - begin) * 8; /* so that the array rarely grows */
    RY_TRY(ry_array_grow(&found->j, &found->room, 0, usual + SPARE, sizeof(int32_t), NULL));
    found->n = 0;
    for (int32_t k = begin; k < end; k++) {
        RY_TRY(find_of_grain(t->neighbor, t->grains, t->pairs, k, found, NULL));
    }
    return RY_OK;
}

/* The same where many sleep. */
RY_CLONES static ry_status find_awake(const ry_find_task *t, int32_t begin, int32_t end, struct ry_found *found)
{
    ry_neighbor *const b = t->neighbor;
    found->n = 0;
    for (int32_t k = begin; k < end; k++) {
        if (b->still[k] && !b->busy[b->cell_of[k]]) {
            t->pairs->below_start[k] = b->above[k] = 0;
        } else {
            RY_TRY(find_of_grain(b, t->grains, t->pairs, k, found, NULL));
        }
    }
    return RY_OK;
}

static void find_grains(void *context, int32_t begin, int32_t end, int thread)
{
    ry_find_task *const t = context;
    struct ry_found *const found = &t->neighbor->found[thread];
    if ((t->neighbor->has_sleepers ? find_awake : find_range)(t, begin, end, found) != RY_OK) {
#pragma omp atomic write
        t->failed = 1;
    }
}

/* ---- the list ------------------------------------------------------------------------------- */

/* Distance of a grain's centre from a wall. */
static double wall_distance(const ry_neighbor *b, ry_wall wall, const ry_grains *g, int32_t k)
{
    return wall == RY_WALL_FLOOR ? g->z[k] : (wall == RY_WALL_LEFT ? g->x[k] : b->length - g->x[k]);
}

static int near_wall(const ry_neighbor *b, int w, const ry_grains *g, int32_t k)
{
    return !b->still[k] && wall_distance(b, b->wall[w], g, k) < g->radius[k] + b->skin[k];
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

/* Keeps the memory of the list while it is filled anew: the arrays change places. */
static ry_status set_memory_aside(ry_neighbor *b, ry_pairs *pairs, ry_error *error)
{
    struct ry_old *const old = &b->old;
    if (old->room < pairs->capacity) {
        free_old(old);
        old->room = 0;
        old->j = ry_array(pairs->capacity, sizeof *old->j);
        old->slip = ry_array(pairs->capacity, sizeof *old->slip);
        old->rest = pairs->rest != NULL ? ry_array(pairs->capacity, sizeof *old->rest) : NULL;
        old->age = ry_array(pairs->capacity, sizeof *old->age);
        old->wet = pairs->wet != NULL ? ry_array(pairs->capacity, sizeof *old->wet) : NULL;
        if (!old->j || !old->slip || !old->age || (pairs->rest != NULL && !old->rest) ||
            (pairs->wet != NULL && !old->wet)) {
            return ry_no_memory(error, pairs->capacity * 21);
        }
        old->room = pairs->capacity;
    }
    swap(&old->row, &pairs->row);
    swap(&old->j, &pairs->j);
    swap(&old->slip, &pairs->slip);
    swap(&old->rest, &pairs->rest);
    swap(&old->age, &pairs->age);
    swap(&old->wet, &pairs->wet);
    for (int w = 0; w < b->n_walls; w++) {
        swap(&old->wall_slot[w], &pairs->wall_slot[w]);
    }
    return RY_OK;
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
static void fill_row(const ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, int32_t k,
                     const int32_t *partners)
{
    const struct ry_old *const old = &b->old;
    const int32_t then = b->was != NULL ? b->was[k] : k;
    int32_t from = old->row[then];
    const int32_t end = old->row[then + 1];
    const int32_t first = pairs->row[k];
    for (int32_t m = 0; m < b->above[k]; m++) {
        const int32_t j = partners[m];
        while (from < end && g->id[old->j[from]] < g->id[j]) {
            from++;
        }
        pairs->i[first + m] = k;
        pairs->j[first + m] = j;
        take_over(pairs, first + m, old, from < end && old->j[from] == j ? from : -1);
    }
}

static void fill_rows(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_find_task *const t = context;
    const ry_neighbor *const b = t->neighbor;
    const int32_t *partners = b->found[thread].j;
    for (int32_t k = begin; k < end; k++) {
        partners += t->pairs->below_start[k + 1] - t->pairs->below_start[k];
        fill_row(b, t->grains, t->pairs, k, partners);
        partners += b->above[k];
    }
}

/* For each grain the slots in which it is the partner, in ascending id of the owner. */
static void fill_below(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_find_task *const t = context;
    const ry_pairs *const pairs = t->pairs;
    const int32_t *partners = t->neighbor->found[thread].j;
    for (int32_t k = begin; k < end; k++) {
        for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
            int32_t p = pairs->row[*partners++];
            while (pairs->j[p] != k) {
                p++;
            }
            pairs->below[b] = p;
        }
        partners += t->neighbor->above[k];
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
static void lay_rows(const ry_neighbor *b, const ry_grains *g, ry_pairs *pairs)
{
    int32_t above = 0, below = 0;
    for (int32_t k = 0; k < g->n; k++) {
        const int32_t length = pairs->below_start[k];
        pairs->row[k] = above;
        pairs->below_start[k] = below;
        above += b->above[k];
        below += length;
        pairs->place[g->id[k]] = k;
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

ry_status ry_neighbor_rebuild(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs, ry_error *error)
{
    const int had_list = b->rebuilds > 0;
    ry_find_task task = {.neighbor = b, .grains = g, .pairs = pairs};
    RY_TRY(lay_grid(b, g, error));
    fill_grid(b, g);
    if (b->has_sleepers) {
        RY_TRY(mark_busy(b, g, error));
    }
    RY_TRY(set_memory_aside(b, pairs, error));
    ry_parallel(b->threads, g->n, find_grains, &task);
    if (task.failed) {
        return ry_no_memory(error, (size_t)g->n * 64);
    }
    lay_rows(b, g, pairs);
    pairs->n = pairs->n_inner + count_wall_pairs(b, g);
    RY_TRY(ry_pairs_reserve(pairs, (size_t)ry_pairs_fill(pairs->n), error));
    ry_parallel(b->threads, g->n, fill_rows, &task);
    ry_parallel(b->threads, g->n, fill_below, &task);
    fill_walls(b, g, pairs, had_list);
    fill_up(pairs, pairs->row[g->n], pairs->n_inner);
    fill_up(pairs, pairs->n, ry_pairs_fill(pairs->n));
    memcpy(b->x0, g->x, (size_t)g->n * sizeof(double));
    memcpy(b->z0, g->z, (size_t)g->n * sizeof(double));
    b->rebuilds++;
    return b->blocks != NULL ? ry_blocks_lay(b->blocks, pairs, error) : RY_OK;
}
