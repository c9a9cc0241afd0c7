/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Who is near whom. A grain has few partners, and how many differs from grain to grain: a loop over them, or a sort,
 * ends where no processor guesses. So four are looked at once, and where vectors are so wide sixteen, which most runs
 * of the grid are shorter than, and sorted by a network. Ids, not places, order what comes out: the list is the same
 * for any number of threads, any storage order and any width. */
#include <string.h>

#include "base/memory.h"
#include "stage/four.h"
#include "stage/neighbor_private.h"

typedef struct ry_find_task {
    ry_neighbor *neighbor;
    const ry_grains *grains;
    ry_pairs *pairs;
    int failed;
} ry_find_task;

/* Sixteen numbers, in a register where there are such. */
typedef int32_t ry_sixteen __attribute__((vector_size(16 * sizeof(int32_t))));

/* Partners are written eight and more at a time. */
RY_INLINE int has_room(const struct ry_part *part, size_t n)
{
    return part->n + n + RY_SPARE <= part->room;
}

/* Adds to a thread's part of an array. */
RY_INLINE void add_part(struct ry_part *part, const int32_t *j, size_t n)
{
    if (has_room(part, n)) {
        for (size_t p = 0; p < n; p += 8) {
            memcpy(part->j + part->n + p, j + p, 8 * sizeof *j);
        }
    } else {
        part->full = 1;
    }
}

/* Grain k has n partners, `below` of them of lower id. */
RY_INLINE void count_partners(const ry_find_task *t, int32_t k, size_t below, size_t n, struct ry_found *found)
{
    found->below.n += below;
    found->above.n += n - below;
    t->pairs->below_start[k] = (int32_t)below;
    t->pairs->row[k] = (int32_t)(n - below);
}

/* Partners of grain k in ascending id, the first `below` of lower id. */
RY_INLINE void put_partners(const ry_find_task *t, int32_t k, const int32_t *near, size_t below, size_t n,
                            struct ry_found *found)
{
    add_part(&found->below, near, below);
    add_part(&found->above, near + below, n - below);
    count_partners(t, k, below, n, found);
}

/* Who is near a grain. */
typedef struct ry_partners {
    int32_t *near;
    size_t n;
    ry_sixteen few; /* the first sixteen of them once more, where as many are looked at at once */
} ry_partners;

/* ---- four at a time ------------------------------------------------------------------------- */

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

/* Appends the members from .. to-1 that are near grain k of those seen but are not itself, grain `own`. */
RY_INLINE void near_in_run(const ry_neighbor *b, const ry_seen *seen, int32_t k, int32_t own, int32_t from,
                           int32_t to, ry_partners *out)
{
    const float unit_x = b->raster.x, unit_z = b->raster.z, reach = seen->reach[k];
    size_t n = out->n;
    for (int32_t m = from; m < to; m += 4) {
        ry_whole x, z;
        ry_quad j;
        ry_single far;
        memcpy(&x, b->member_x + m, sizeof x);
        memcpy(&z, b->member_z + m, sizeof z);
        memcpy(&far, b->member_reach + m, sizeof far);
        memcpy(&j, b->member + m, sizeof j);
        const ry_single dx = __builtin_convertvector((ry_quad)(x - seen->x[k]), ry_single) * unit_x;
        const ry_single dz = __builtin_convertvector((ry_quad)(z - seen->z[k]), ry_single) * unit_z;
        far += reach;
        const ry_quad bits = (ry_quad)(dx * dx + dz * dz < far * far) & (ry_quad)(j != own) & (ry_quad){1, 2, 4, 8};
        const unsigned there = to - m < 4 ? (1u << (to - m)) - 1 : 15;
        n += append_chosen(b->member + m, (unsigned)(bits[0] | bits[1] | bits[2] | bits[3]) & there, out->near + n);
    }
    out->n = n;
}

/* Two that are still make no pair. */
RY_INLINE void drop_still(const uint8_t *still, ry_partners *out)
{
    const size_t n = out->n;
    out->n = 0;
    for (size_t p = 0; p < n; p++) {
        const int32_t j = out->near[p];
        out->near[out->n] = j;
        out->n += !still[j];
    }
    memcpy(&out->few, out->near, sizeof out->few);
}

RY_INLINE void sort_partners(const ry_find_task *t, int32_t k, const ry_partners *out, struct ry_found *found)
{
    const int32_t *const id = t->grains->id;
    size_t below = 0;
    ry_sort_by_id(out->near, out->n, id);
    while (below < out->n && id[out->near[below]] < id[k]) {
        below++;
    }
    put_partners(t, k, out->near, below, out->n, found);
}

/* ---- sixteen at a time ---------------------------------------------------------------------- */

#if RY_INTRINSICS
/* What has just been stored in parts is loaded as a whole only when all of it has left the processor: so the first
 * sixteen stay in a register. */
RY_WIDE static inline void near_in_run_wide(const ry_neighbor *b, const ry_seen *seen, int32_t k, int32_t own,
                                            int32_t from, int32_t to, ry_partners *out)
{
    const __m512i at_x = _mm512_set1_epi32((int32_t)seen->x[k]), at_z = _mm512_set1_epi32((int32_t)seen->z[k]);
    const __m512 unit_x = _mm512_set1_ps(b->raster.x), unit_z = _mm512_set1_ps(b->raster.z);
    const __m512 reach = _mm512_set1_ps(seen->reach[k]);
    size_t n = out->n;
    for (int32_t m = from; m < to; m += 16) {
        const __mmask16 there = (__mmask16)(to - m < 16 ? (1u << (to - m)) - 1u : 0xffffu);
        const __m512i x = _mm512_sub_epi32(_mm512_loadu_si512(b->member_x + m), at_x);
        const __m512i z = _mm512_sub_epi32(_mm512_loadu_si512(b->member_z + m), at_z);
        const __m512 dx = _mm512_mul_ps(_mm512_cvtepi32_ps(x), unit_x);
        const __m512 dz = _mm512_mul_ps(_mm512_cvtepi32_ps(z), unit_z);
        const __m512 far = _mm512_add_ps(_mm512_loadu_ps(b->member_reach + m), reach);
        const __m512 way2 = _mm512_add_ps(_mm512_mul_ps(dx, dx), _mm512_mul_ps(dz, dz));
        const __m512i j = _mm512_loadu_si512(b->member + m);
        const __mmask16 other = _mm512_mask_cmpneq_epi32_mask(there, j, _mm512_set1_epi32(own));
        const __mmask16 near = _mm512_mask_cmp_ps_mask(other, way2, _mm512_mul_ps(far, far), _CMP_LT_OQ);
        const __m512i those = _mm512_maskz_compress_epi32(near, j);
        const __mmask16 behind = (__mmask16)(n < 16 ? 0xffffu << n : 0);
        out->few = (ry_sixteen)_mm512_mask_expand_epi32((__m512i)out->few, behind, those);
        _mm512_storeu_si512(out->near + n, those);
        n += (size_t)__builtin_popcount(near);
    }
    out->n = n;
}

/* Ids in the upper halves, places in the lower ones; who is not there, of eight, comes last. */
RY_WIDE static inline __m512i keys_of(const int32_t *id, __m256i j, size_t n)
{
    const __m256i none = _mm256_set1_epi32(INT32_MAX);
    const __mmask8 there = (__mmask8)(n < 8 ? (1u << n) - 1 : 0xff);
    const __m256i ids = _mm256_mmask_i32gather_epi32(none, there, j, id, 4);
    return _mm512_or_si512(_mm512_slli_epi64(_mm512_cvtepi32_epi64(ids), 32), _mm512_cvtepu32_epi64(j));
}

/* A stage of a sorting network: with whom each is compared, and who keeps the larger. */
#define STAGE(v, larger, ...)                                                                  \
    do {                                                                                       \
        const __m512i with = _mm512_permutexvar_epi64(_mm512_setr_epi64(__VA_ARGS__), v);      \
        v = _mm512_mask_max_epu64(_mm512_min_epu64(v, with), larger, v, with);                 \
    } while (0)

/* Batcher's bitonic sort (1968) of eight; its second part sorts what first ascends, then descends. */
RY_WIDE static inline __m512i merge_eight(__m512i v)
{
    STAGE(v, 0xf0, 4, 5, 6, 7, 0, 1, 2, 3);
    STAGE(v, 0xcc, 2, 3, 0, 1, 6, 7, 4, 5);
    STAGE(v, 0xaa, 1, 0, 3, 2, 5, 4, 7, 6);
    return v;
}

RY_WIDE static inline __m512i sort_eight(__m512i v)
{
    STAGE(v, 0x66, 1, 0, 3, 2, 5, 4, 7, 6);
    STAGE(v, 0x3c, 2, 3, 0, 1, 6, 7, 4, 5);
    STAGE(v, 0x5a, 1, 0, 3, 2, 5, 4, 7, 6);
    return merge_eight(v);
}

RY_WIDE static inline size_t count_below(__m512i keys, __m512i own)
{
    return (size_t)__builtin_popcount(_mm512_cmplt_epu64_mask(keys, own));
}

/* Up to eight, the first `below` of lower id. */
RY_WIDE static inline void put_eight(const ry_find_task *t, int32_t k, __m256i near, size_t below, size_t n,
                                     struct ry_found *found)
{
    const __mmask8 later = (__mmask8)(0xffu << below);
    if (has_room(&found->below, n) && has_room(&found->above, n)) {
        _mm256_storeu_si256((__m256i *)(found->below.j + found->below.n), near);
        _mm256_storeu_si256((__m256i *)(found->above.j + found->above.n), _mm256_maskz_compress_epi32(later, near));
    } else {
        found->below.full = found->above.full = 1;
    }
    count_partners(t, k, below, n, found);
}

RY_WIDE static inline void sort_partners_wide(const ry_find_task *t, int32_t k, const ry_partners *out,
                                              struct ry_found *found)
{
    const int32_t *const id = t->grains->id;
    const size_t n = out->n;
    if (n > 16) {
        sort_partners(t, k, out, found);
        return;
    }
    const __m512i own = _mm512_set1_epi64((int64_t)id[k] << 32); /* ids are positive */
    const __m512i low = sort_eight(keys_of(id, _mm512_castsi512_si256((__m512i)out->few), n));
    if (n <= 8) {
        put_eight(t, k, _mm512_cvtepi64_epi32(low), count_below(low, own), n, found);
        return;
    }
    const __m512i high = sort_eight(keys_of(id, _mm512_extracti64x4_epi64((__m512i)out->few, 1), n - 8));
    const __m512i back = _mm512_permutexvar_epi64(_mm512_setr_epi64(7, 6, 5, 4, 3, 2, 1, 0), high);
    const __m512i first = merge_eight(_mm512_min_epu64(low, back)), rest = merge_eight(_mm512_max_epu64(low, back));
    int32_t near[16 + RY_SPARE];
    _mm256_storeu_si256((__m256i *)near, _mm512_cvtepi64_epi32(first));
    _mm256_storeu_si256((__m256i *)(near + 8), _mm512_cvtepi64_epi32(rest));
    put_partners(t, k, near, count_below(first, own) + count_below(rest, own), n, found);
}
#else
#define near_in_run_wide near_in_run
#define sort_partners_wide sort_partners
#endif

/* ---- all grains ----------------------------------------------------------------------------- */

RY_INLINE ry_status find_of_grain(const ry_find_task *t, const ry_seen *seen, int32_t begin, int32_t k,
                                  struct ry_found *found, const int wide)
{
    const ry_neighbor *const b = t->neighbor;
    ry_partners out = {.near = found->near};
    for (int32_t c = seen->first[k]; c <= seen->last[k] && seen->low[k] <= seen->high[k]; c++) {
        const int32_t *const start = b->cell_start + ry_grid_column(&b->grid, c);
        const int32_t from = start[seen->low[k]], to = start[seen->high[k] + 1];
        const size_t most = out.n + (size_t)(to - from) + RY_SPARE;
        if (most > found->room) {
            RY_TRY(ry_array_grow(&found->near, &found->room, out.n, most, sizeof *found->near, NULL));
            out.near = found->near;
        }
        (wide ? near_in_run_wide : near_in_run)(b, seen, k, begin + k, from, to, &out);
    }
    if (b->still[begin + k] && out.n > 0) {
        drop_still(b->still, &out);
    }
    (wide ? sort_partners_wide : sort_partners)(t, begin + k, &out, found);
    return RY_OK;
}

/* Where many sleep nobody is looked for around those that are far from all others. */
RY_INLINE ry_status find_in_stretch(const ry_find_task *t, int32_t begin, int32_t n, struct ry_found *found,
                                    const int wide)
{
    const ry_neighbor *const b = t->neighbor;
    ry_seen seen;
    ry_neighbor_look_at(b, t->grains, begin, n, &seen);
    ry_neighbor_look_around(b, t->grains, begin, n, &seen);
    for (int32_t k = 0; k < n; k++) {
        const int far = b->has_sleepers && b->still[begin + k] && !b->busy[seen.column[k] * b->grid.rows + seen.row[k]];
        if (far) {
            t->pairs->below_start[begin + k] = t->pairs->row[begin + k] = 0;
        } else {
            RY_TRY(find_of_grain(t, &seen, begin, k, found, wide));
        }
    }
    return RY_OK;
}

RY_CLONES static ry_status find_stretch(const ry_find_task *t, int32_t begin, int32_t n, struct ry_found *found)
{
    return find_in_stretch(t, begin, n, found, 0);
}

RY_WIDE static ry_status find_stretch_wide(const ry_find_task *t, int32_t begin, int32_t n, struct ry_found *found)
{
    return find_in_stretch(t, begin, n, found, 1);
}

static void find_grains(void *context, int32_t begin, int32_t end, int thread)
{
    ry_find_task *const t = context;
    for (int32_t k = begin; k < end; k += RY_STRETCH) {
        const int32_t n = end - k < RY_STRETCH ? end - k : RY_STRETCH;
        if ((ry_is_wide() ? find_stretch_wide : find_stretch)(t, k, n, &t->neighbor->found[thread]) != RY_OK) {
#pragma omp atomic write
            t->failed = 1;
        }
    }
}

int ry_partners_find(ry_neighbor *b, const ry_grains *g, ry_pairs *pairs)
{
    ry_find_task task = {.neighbor = b, .grains = g, .pairs = pairs};
    ry_parallel(b->threads, g->n, find_grains, &task);
    return !task.failed;
}

/* ---- the slots of partners ------------------------------------------------------------------ */

/* The slot of the pair of an owner, whose row begins at p, and its partner k. */
RY_INLINE int32_t slot_of(const ry_pairs *pairs, int32_t p, int32_t k)
{
    while (pairs->j[p] != k) {
        p++;
    }
    return p;
}

#if RY_INTRINSICS
RY_WIDE static inline int32_t slot_of_wide(const ry_pairs *pairs, int32_t p, int32_t k)
{
    for (;; p += 16) { /* there is room behind the last pair */
        const __mmask16 there = _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(pairs->j + p), _mm512_set1_epi32(k));
        if (there != 0) {
            return p + __builtin_ctz(there);
        }
    }
}
#else
#define slot_of_wide slot_of
#endif

RY_INLINE void fill_below_of(const ry_pairs *pairs, int32_t begin, int32_t end, const int wide)
{
    for (int32_t k = begin; k < end; k++) {
        for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
            pairs->i[p] = k;
        }
        for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
            pairs->below[b] = (wide ? slot_of_wide : slot_of)(pairs, pairs->row[pairs->below[b]], k);
        }
    }
}

static void fill_below(const ry_pairs *pairs, int32_t begin, int32_t end)
{
    fill_below_of(pairs, begin, end, 0);
}

RY_WIDE static void fill_below_wide(const ry_pairs *pairs, int32_t begin, int32_t end)
{
    fill_below_of(pairs, begin, end, 1);
}

void ry_partners_link(void *context, int32_t begin, int32_t end, int thread)
{
    (void)thread;
    (ry_is_wide() ? fill_below_wide : fill_below)(context, begin, end);
}
