/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The grid is numbered column by column, so that the three cells of a column which a grain must look
 * at are one run of `member`. Ids, not places, order what comes out: the list is the same for any
 * number of threads and any storage order. */
#include <string.h>

#include "base/memory.h"
#include "stage/neighbor_private.h"

/* ---- the grid ------------------------------------------------------------------------------- */

/* How far each grain may go before the list is made anew: fast grains further, so that the few of them don't
 * make the list short-lived, or long, for all. Returns the furthest. */
RY_CLONES static double set_limits(ry_neighbor *b, const ry_grains *g)
{
    const double *const vx = g->vx, *const vz = g->vz;
    double *restrict const limit2 = b->limit2;
    const double least = b->skin_least, most = b->skin_most, ahead = b->horizon;
    double furthest = 0.0;
#pragma omp simd reduction(max : furthest)
    for (int32_t k = 0; k < g->n; k++) {
        const double way = least + ahead * sqrt(vx[k] * vx[k] + vz[k] * vz[k]);
        const double s = way < most ? way : most;
        limit2[k] = RY_NEARLY_ONE * s * s;
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

/* Positions as whole numbers that wrap where x does. Where it does not, zero is in the middle, and who is out of
 * bounds counts as being at their edge: all go closer together by that, so no pair is missed. */
static ry_raster lay_raster(const ry_neighbor *b, ry_bounds in, double reach)
{
    const double most = 0x1p20 * reach, whole = 0x1p32, half = 0x1p31;
    const double wide = fmin(fmax(fmax(fabs(in.left), fabs(in.right)), reach), most);
    const double high = fmin(fmax(fmax(fabs(in.bottom), fabs(in.top)), reach), most);
    ry_raster raster = {.per_x = b->periodic ? whole / b->length : 0.5 * half / wide, .per_z = 0.5 * half / high,
                        .zero_x = b->periodic ? 0.0 : 0.5 * half, .most_x = b->periodic ? whole : half};
    raster.x = (float)(1.0 / raster.per_x);
    raster.z = (float)(1.0 / raster.per_z);
    raster.margin = 1.0 / raster.per_x + 1.0 / raster.per_z;
    return raster;
}

/* Cells at least as large as the reach of a pair; larger where the grains lie so far apart that
 * cells would outnumber them. */
static ry_status lay_cells(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    const double reach = 2.0 * (b->radius_max + set_limits(b, g));
    ry_bounds in = bounds_of(g);
    b->raster = lay_raster(b, in, reach);
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
    b->per_cell_x = 1.0 / b->cell_x;
    b->per_cell_z = 1.0 / b->cell_z;
    return ry_array_grow(&b->cell_start, &b->n_cells_room, 0,
                         (size_t)b->columns * (size_t)b->rows + 1, sizeof *b->cell_start, error);
}

RY_INLINE int32_t clamp_cell(double position, int32_t n)
{
    const double inside = position > 0.0 ? (position < 2e9 ? position : 2e9) : 0.0;
    const int32_t cell = (int32_t)inside;
    return cell < n ? cell : n - 1;
}

/* The cell of a grain: the number of its column, and in that. */
RY_INLINE int32_t column_of(const ry_neighbor *b, double x)
{
    return clamp_cell((x - b->left) * b->per_cell_x, b->columns);
}

RY_INLINE int32_t row_of(const ry_neighbor *b, double z)
{
    return clamp_cell((z - b->bottom) * b->per_cell_z, b->rows);
}

int32_t ry_neighbor_cell(const ry_neighbor *b, const ry_grains *g, int32_t k)
{
    return column_of(b, g->x[k]) * b->rows + row_of(b, g->z[k]);
}

/* The nearest whole number to 0 <= u <= 2^32, which wraps to 0; of anything else the nearest bound. */
RY_INLINE uint32_t whole_number(double u, double most)
{
    const double shifted = (u > 0.0 ? (u < most ? u : most) : 0.0) + 0x1p52;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return (uint32_t)bits;
}

/* A stretch of grains as the grid sees them. */
enum { STRETCH = 64 };
typedef struct ry_seen {
    int32_t column[STRETCH], row[STRETCH];
    uint32_t x[STRETCH], z[STRETCH];
    float reach[STRETCH];
} ry_seen;

/* Rounding makes no reach shorter: each of two grains is half a unit off at most along x and along z, and the
 * arithmetic of near_in_run less than 1e-6. Who is nowhere (not a number) is near nobody. */
RY_INLINE void look_at(const ry_neighbor *b, const ry_grains *g, int32_t begin, int32_t n, ry_seen *seen)
{
    const double *const x = g->x + begin, *const z = g->z + begin;
    const ry_raster in = b->raster;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double reach = ry_neighbor_reach(b, g, begin + k);
        seen->column[k] = column_of(b, x[k]);
        seen->row[k] = row_of(b, z[k]);
        seen->x[k] = whole_number(x[k] * in.per_x + in.zero_x, in.most_x);
        seen->z[k] = whole_number(z[k] * in.per_z + 0x1p30, 0x1p31);
        seen->reach[k] = (float)(reach * (1.0 + 1e-6) + in.margin + (x[k] - x[k]) + (z[k] - z[k]));
    }
}

RY_CLONES static void count_members(const ry_neighbor *b, const ry_grains *g, int32_t *count)
{
    ry_seen seen;
    for (int32_t begin = 0; begin < g->n; begin += STRETCH) {
        const int32_t n = g->n - begin < STRETCH ? g->n - begin : STRETCH;
        look_at(b, g, begin, n, &seen);
        for (int32_t k = 0; k < n; k++) {
            count[seen.column[k] * b->rows + seen.row[k]]++;
        }
    }
}

RY_CLONES static void place_members(const ry_neighbor *b, const ry_grains *g, int32_t *next)
{
    ry_seen seen;
    for (int32_t begin = 0; begin < g->n; begin += STRETCH) {
        const int32_t n = g->n - begin < STRETCH ? g->n - begin : STRETCH;
        look_at(b, g, begin, n, &seen);
        for (int32_t k = 0; k < n; k++) {
            const int32_t m = next[seen.column[k] * b->rows + seen.row[k]]++;
            b->member[m] = begin + k;
            b->member_x[m] = seen.x[k];
            b->member_z[m] = seen.z[k];
            b->member_reach[m] = seen.reach[k];
        }
    }
}

/* A counting sort. */
void ry_grid_fill(ry_neighbor *b, const ry_grains *g, void *scratch)
{
    const int32_t n_cells = b->columns * b->rows;
    b->member_x = scratch;
    b->member_z = b->member_x + g->n + RY_SPARE;
    b->member_reach = (float *)(b->member_z + g->n + RY_SPARE);
    b->member = b->own_member != NULL ? b->own_member : (int32_t *)(b->member_reach + g->n + RY_SPARE);
    memset(b->cell_start, 0, ((size_t)n_cells + 1) * sizeof *b->cell_start);
    count_members(b, g, b->cell_start);
    int32_t sum = 0;
    for (int32_t c = 0; c <= n_cells; c++) {
        const int32_t count = c < n_cells ? b->cell_start[c] : 0;
        b->cell_start[c] = sum;
        sum += count;
    }
    place_members(b, g, b->cell_start);
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
        const int32_t cell = ry_neighbor_cell(b, g, k);
        if (!b->still[k] && !(b->busy[cell] & DONE)) {
            mark_around(b, cell);
        }
    }
    return RY_OK;
}

ry_status ry_grid_lay(ry_neighbor *b, const ry_grains *g, ry_error *error)
{
    RY_TRY(lay_cells(b, g, error));
    if (!b->has_sleepers) {
        return RY_OK;
    }
    if (b->own_member == NULL && (b->own_member = ry_array((size_t)g->n + RY_SPARE, sizeof(int32_t))) == NULL) {
        return ry_no_memory(error, (size_t)g->n * sizeof(int32_t));
    }
    return mark_busy(b, g, error);
}

/* ---- the pairs ------------------------------------------------------------------------------ */

/* Those of four numbers whose bits are set, first. */
typedef int32_t ry_quad __attribute__((vector_size(4 * sizeof(int32_t))));
typedef uint32_t ry_whole __attribute__((vector_size(4 * sizeof(uint32_t))));
typedef float ry_single __attribute__((vector_size(4 * sizeof(float))));
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

/* Appends the members first .. last-1 that are near grain k of those seen, itself among them. */
RY_INLINE size_t near_in_run(const ry_neighbor *b, const ry_seen *seen, int32_t k, int32_t first, int32_t last,
                             int32_t *out)
{
    const float unit_x = b->raster.x, unit_z = b->raster.z, reach = seen->reach[k];
    size_t n = 0;
    for (int32_t m = first; m < last; m += 4) {
        ry_whole x, z;
        ry_single far;
        memcpy(&x, b->member_x + m, sizeof x);
        memcpy(&z, b->member_z + m, sizeof z);
        memcpy(&far, b->member_reach + m, sizeof far);
        const ry_single dx = __builtin_convertvector((ry_quad)(x - seen->x[k]), ry_single) * unit_x;
        const ry_single dz = __builtin_convertvector((ry_quad)(z - seen->z[k]), ry_single) * unit_z;
        far += reach;
        const ry_quad bits = (ry_quad)(dx * dx + dz * dz < far * far) & (ry_quad){1, 2, 4, 8};
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

/* Adds to a thread's part of an array; writes four at a time. */
RY_INLINE void add_part(struct ry_part *part, const int32_t *j, size_t n)
{
    if (part->n + n + RY_SPARE <= part->room) {
        for (size_t p = 0; p < n; p += 4) {
            memcpy(part->j + part->n + p, j + p, 4 * sizeof *j);
        }
    } else {
        part->full = 1;
    }
    part->n += n;
}

typedef struct ry_find_task {
    ry_neighbor *neighbor;
    const ry_grains *grains;
    ry_pairs *pairs;
    int failed;
} ry_find_task;

/* All partners of grain k of those seen from `begin` on, in ascending id: how many it owns, of higher id, and how
 * many own it. */
RY_INLINE ry_status find_of_grain(const ry_find_task *t, const ry_seen *seen, int32_t begin, int32_t k,
                                  struct ry_found *found)
{
    const ry_neighbor *const b = t->neighbor;
    const int32_t *const id = t->grains->id;
    const int32_t column = seen->column[k], row = seen->row[k];
    const int32_t low = row > 0 ? row - 1 : 0, high = row + 1 < b->rows ? row + 1 : row;
    const int32_t spread = b->columns > 2 ? 1 : 0; /* one or two columns: look at each once */
    const int32_t first = b->columns == 2 ? 0 : column - spread;
    const int32_t last = b->columns == 2 ? 1 : column + spread;
    size_t n = 0;
    for (int32_t c = first; c <= last; c++) {
        const int32_t wrapped = c < 0 ? c + b->columns : (c >= b->columns ? c - b->columns : c);
        if (wrapped != c && !b->periodic) {
            continue;
        }
        const int32_t from = b->cell_start[wrapped * b->rows + low];
        const int32_t to = b->cell_start[wrapped * b->rows + high + 1];
        const size_t most = n + (size_t)(to - from) + RY_SPARE;
        RY_TRY(ry_array_grow(&found->near, &found->room, n, most, sizeof *found->near, NULL));
        n += near_in_run(b, seen, k, from, to, found->near + n);
    }
    n = drop_pairless(b->still, begin + k, found->near, n);
    ry_sort_by_id(found->near, n, id);
    size_t below = 0;
    while (below < n && id[found->near[below]] < id[begin + k]) {
        below++;
    }
    add_part(&found->below, found->near, below);
    add_part(&found->above, found->near + below, n - below);
    t->pairs->below_start[begin + k] = (int32_t)below;
    t->pairs->row[begin + k] = (int32_t)(n - below);
    return RY_OK;
}

/* Where many sleep nobody is looked for around those that are far from all others. */
RY_CLONES static ry_status find_stretch(const ry_find_task *t, int32_t begin, int32_t n, struct ry_found *found)
{
    const ry_neighbor *const b = t->neighbor;
    ry_seen seen;
    look_at(b, t->grains, begin, n, &seen);
    for (int32_t k = 0; k < n; k++) {
        const int far = b->has_sleepers && b->still[begin + k] && !b->busy[seen.column[k] * b->rows + seen.row[k]];
        if (far) {
            t->pairs->below_start[begin + k] = t->pairs->row[begin + k] = 0;
        } else {
            RY_TRY(find_of_grain(t, &seen, begin, k, found));
        }
    }
    return RY_OK;
}

static void find_grains(void *context, int32_t begin, int32_t end, int thread)
{
    ry_find_task *const t = context;
    for (int32_t k = begin; k < end; k += STRETCH) {
        const int32_t n = end - k < STRETCH ? end - k : STRETCH;
        if (find_stretch(t, k, n, &t->neighbor->found[thread]) != RY_OK) {
#pragma omp atomic write
            t->failed = 1;
        }
    }
}

int ry_grid_find(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs)
{
    ry_find_task task = {.neighbor = b, .grains = g, .pairs = pairs};
    ry_parallel(b->threads, g->n, find_grains, &task);
    return !task.failed;
}
