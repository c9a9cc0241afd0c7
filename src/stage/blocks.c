/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/blocks.h"

#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"

/* Pairs that are pushed at a time. */
enum { PUSHED = 128 };
/* Partners further away than so many grains are far. */
enum { FAR = 1024 };
/* In chunks of fewer blocks so many are late that a ring gains nothing. */
enum { FEW = 48 };

/* A level: a pass and those that follow it at once, block by block. */
static int level_end(const ry_blocks *b, int pass)
{
    do {
        pass++;
    } while (pass < b->n_passes && !b->pass[pass].around);
    return pass;
}

ry_status ry_blocks_create(ry_blocks *b, int32_t n_grains, ry_error *error)
{
    b->n = (n_grains + RY_BLOCK - 1) / RY_BLOCK;
    const size_t n = (size_t)b->n;
    b->low = ry_array(n, sizeof *b->low);
    b->high = ry_array(n, sizeof *b->high);
    b->way = ry_array(n, sizeof *b->way);
    b->edge = ry_array((size_t)b->threads + 1, sizeof *b->edge);
    int whole = b->low && b->high && b->way && b->edge;
    for (int q = 0; q <= b->n_passes; q++) {
        b->due[q] = ry_array(n, sizeof **b->due);
        whole = whole && b->due[q];
    }
    return whole ? RY_OK : ry_no_memory(error, n * 32);
}

void ry_blocks_free(ry_blocks *b)
{
    free(b->low);
    free(b->high);
    free(b->way);
    free(b->edge);
    for (int q = 0; q <= RY_MOST_PASSES; q++) {
        free(b->due[q]);
    }
    *b = (ry_blocks){0};
}

static int32_t smaller(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t larger(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* The first grain of a block; of the one after the last: the number of grains. */
static int32_t first_grain(const ry_pairs *pairs, int32_t block)
{
    return smaller(block * RY_BLOCK, pairs->n_grains);
}

static int32_t first_pair(const ry_pairs *pairs, int32_t block)
{
    return pairs->row[first_grain(pairs, block)];
}

/* ---- chunks ----------------------------------------------------------------------------------- */

/* As many pairs for each thread as whole blocks allow; the pairs with walls come last. */
static void cut_chunks(ry_blocks *b, ry_pairs *pairs)
{
    const int32_t all = pairs->row[pairs->n_grains];
    pairs->n_chunks = b->threads;
    for (int t = 0; t <= b->threads; t++) {
        const int32_t pair = (int32_t)((int64_t)all * t / b->threads);
        const int32_t nearest = pair < all ? (pairs->i[pair] + RY_BLOCK / 2) / RY_BLOCK : b->n;
        b->edge[t] = t == 0 ? 0 : (t == b->threads ? b->n : smaller(nearest, b->n));
        pairs->chunk[t] = first_pair(pairs, b->edge[t]);
    }
}

/* ---- who is due when -------------------------------------------------------------------------- */

typedef struct ry_reach_task {
    ry_blocks *blocks;
    const ry_pairs *pairs;
} ry_reach_task;

static void find_reach(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_reach_task *const task = context;
    ry_blocks *const b = task->blocks;
    const ry_pairs *const pairs = task->pairs;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        const int32_t grain = first_grain(pairs, k), next = first_grain(pairs, k + 1);
        int32_t low = grain, high = grain;
        for (int32_t p = pairs->row[grain]; p < pairs->row[next]; p++) {
            low = smaller(low, pairs->j[p]);
            high = larger(high, pairs->j[p]);
        }
        for (int32_t p = pairs->below_start[grain]; p < pairs->below_start[next]; p++) {
            const int32_t owner = pairs->i[pairs->below[p]];
            low = smaller(low, owner);
            high = larger(high, owner);
        }
        b->low[k] = low / RY_BLOCK;
        b->high[k] = high / RY_BLOCK;
    }
}

static int is_far(const ry_blocks *b, int32_t k)
{
    return (k - b->low[k]) * RY_BLOCK > FAR || (b->high[k] - k) * RY_BLOCK > FAR;
}

/* Grains whose pairs must be done before all contacts of a block are known. */
static int32_t known_at(const ry_blocks *b, const ry_pairs *pairs, int chunk, int32_t k)
{
    const int elsewhere = b->low[k] < b->edge[chunk] || b->high[k] >= b->edge[chunk + 1];
    return b->apart || is_far(b, k) || elsewhere ? RY_LATE : first_grain(pairs, b->high[k] + 1);
}

/* The latest of a block and those of its partners. */
static int32_t latest_around(const ry_blocks *b, const int32_t *due, int32_t k)
{
    int32_t latest = 0;
    for (int32_t other = b->low[k]; other <= b->high[k]; other++) {
        latest = larger(latest, due[other]);
    }
    return latest;
}

/* Each pass in its turn, from when all contacts are known on; blocks of a chunk are due in their order. */
static void find_due(ry_blocks *b, const ry_pairs *pairs, int chunk)
{
    for (int32_t k = b->edge[chunk]; k < b->edge[chunk + 1]; k++) {
        b->due[0][k] = known_at(b, pairs, chunk, k);
    }
    for (int q = 0; q < b->n_passes; q = level_end(b, q)) {
        const int32_t *const before = b->due[q];
        int32_t *const due = b->due[level_end(b, q)], last = 0;
        for (int32_t k = b->edge[chunk]; k < b->edge[chunk + 1]; k++) {
            due[k] = before[k] == RY_LATE || !b->pass[q].around ? before[k] : latest_around(b, before, k);
            last = due[k] == RY_LATE ? last : larger(last, due[k]);
            due[k] = due[k] == RY_LATE ? RY_LATE : last;
        }
    }
}

/* ---- slots ------------------------------------------------------------------------------------ */

typedef struct ry_stretch {
    int32_t begin, end;
} ry_stretch;

/* The partners' blocks of late block k that are inside of `inner`, from the first to behind the last. */
static ry_stretch partners_within(const ry_pairs *pairs, int32_t k, ry_stretch inner)
{
    ry_stretch found = {inner.end, inner.begin};
    const int32_t grain = first_grain(pairs, k), next = first_grain(pairs, k + 1);
    const int32_t below = pairs->below_start[grain], n_below = pairs->below_start[next] - below;
    const int32_t row = pairs->row[grain], n = n_below + pairs->row[next] - row;
    for (int32_t q = 0; q < n; q++) {
        const int32_t partner = q < n_below ? pairs->i[pairs->below[below + q]] : pairs->j[row + q - n_below];
        const int32_t block = partner / RY_BLOCK;
        if (block >= inner.begin && block < inner.end) {
            found.begin = smaller(found.begin, block);
            found.end = larger(found.end, block + 1);
        }
    }
    return found;
}

/* The blocks between the late ones at both ends of a chunk; empty if there are others. */
static ry_stretch find_inner(const ry_blocks *b, int chunk)
{
    const int32_t *const due = b->due[b->n_passes];
    ry_stretch inner = {b->edge[chunk], b->edge[chunk + 1]};
    while (inner.begin < inner.end && due[inner.begin] == RY_LATE) {
        inner.begin++;
    }
    while (inner.end > inner.begin && due[inner.end - 1] == RY_LATE) {
        inner.end--;
    }
    for (int32_t k = inner.begin; k < inner.end; k++) {
        if (due[k] == RY_LATE) {
            return (ry_stretch){0, 0};
        }
    }
    return inner;
}

/* Slots of late grains' pairs are kept, if the late blocks are the first and the last ones of a chunk; else all. */
static ry_shelf lay_shelf(const ry_blocks *b, const ry_pairs *pairs, int chunk)
{
    const int32_t first = pairs->chunk[chunk], n = pairs->chunk[chunk + 1] - first;
    const ry_shelf all = {.first = first, .head = n, .tail = n, .mask = -1};
    const ry_stretch inner = find_inner(b, chunk);
    int32_t head = inner.begin, tail = inner.end, window = 0, ring = PUSHED;
    if (inner.end - inner.begin < FEW) {
        return all;
    }
    for (int32_t k = b->edge[chunk]; k < inner.begin; k++) {
        head = larger(head, partners_within(pairs, k, inner).end);
    }
    for (int32_t k = inner.end; k < b->edge[chunk + 1]; k++) {
        tail = smaller(tail, partners_within(pairs, k, inner).begin);
    }
    for (int32_t k = inner.begin; k < inner.end; k++) {
        window = larger(window, pairs->row[b->due[b->n_passes][k]] + PUSHED - first_pair(pairs, b->low[k]));
    }
    while (ring < window) {
        ring *= 2;
    }
    const int32_t kept = (first_pair(pairs, head) + PUSHED - 1) / PUSHED * PUSHED - first;
    const int32_t again = first_pair(pairs, tail) / PUSHED * PUSHED - first;
    if (kept + ring >= again) {
        return all;
    }
    return (ry_shelf){.first = first, .head = kept, .tail = again, .mask = ring - 1};
}

static int32_t shelf_length(const ry_shelf *s, int32_t n)
{
    return s->mask < 0 ? n : n - (s->tail - s->head - s->mask - 1);
}

/* All pairs of a block's grains in the ring, or all kept: one rule for them. Late ones may have others. */
static ry_way find_way(const ry_blocks *b, const ry_pairs *pairs, const ry_shelf *s, int32_t k)
{
    const int32_t low = first_pair(pairs, b->low[k]) - s->first;
    const int32_t high = first_pair(pairs, b->high[k] + 1) - s->first;
    if (s->mask < 0 || high <= s->head) {
        return (ry_way){.base = s->base - s->first, .mask = -1};
    }
    if (low >= s->head && high <= s->tail) {
        return (ry_way){.base = s->base + s->head, .mask = s->mask};
    }
    return (ry_way){0, 0};
}

static ry_status lay_slots(ry_blocks *b, ry_pairs *pairs, ry_error *error)
{
    int32_t base = 0;
    int plain = 1;
    for (int t = 0; t < b->threads; t++) {
        ry_shelf *const s = &pairs->shelf[t];
        *s = lay_shelf(b, pairs, t);
        s->base = base;
        base += shelf_length(s, pairs->chunk[t + 1] - pairs->chunk[t]);
        plain = plain && s->mask < 0;
    }
    base += pairs->n_inner - pairs->row[pairs->n_grains]; /* to fill vectors up */
    const int32_t n_walls = pairs->n - pairs->n_inner;
    pairs->shelf[b->threads] =
        (ry_shelf){.first = pairs->n_inner, .base = base, .head = n_walls, .tail = n_walls, .mask = -1};
    for (int t = 0; t < b->threads; t++) {
        for (int32_t k = b->edge[t]; k < b->edge[t + 1]; k++) {
            const int alone = b->due[b->n_passes][k] != RY_LATE;
            b->way[k] = plain ? (ry_way){0, -1} : alone ? find_way(b, pairs, &pairs->shelf[t], k) : (ry_way){0, 0};
        }
    }
    return ry_pairs_reserve_slots(pairs, (size_t)base + (size_t)ry_pairs_fill(n_walls), error);
}

ry_status ry_blocks_lay(ry_blocks *b, ry_pairs *pairs, ry_error *error)
{
    ry_reach_task task = {b, pairs};
    cut_chunks(b, pairs);
    if (!b->apart) {
        ry_parallel(b->threads, b->n, find_reach, &task);
    }
    b->n_far = 0;
    for (int32_t k = 0; k < b->n; k++) {
        b->n_far += is_far(b, k);
    }
    for (int t = 0; t < b->threads; t++) {
        find_due(b, pairs, t);
    }
    return lay_slots(b, pairs, error);
}

/* ---- a step ----------------------------------------------------------------------------------- */

typedef struct ry_turn {
    const ry_blocks *blocks;
    const ry_pairs *pairs;
    void *context;
    int timed;
} ry_turn;

/* Adds the time since `before`, which becomes now. */
static void lap(const ry_turn *s, int chunk, double *seconds, double *before)
{
    if (s->timed && chunk == 0) {
        const double now = ry_clock();
        *seconds += now - *before;
        *before = now;
    }
}

/* The passes of the level that begins with pass q, over a block; or several, if it likes. */
static void do_level(const ry_turn *s, int q, int32_t block, int32_t next, int chunk, double *before)
{
    const ry_blocks *const b = s->blocks;
    const int32_t begin = first_grain(s->pairs, block), end = first_grain(s->pairs, next);
    const int last = level_end(b, q);
    for (; q < last; q++) {
        b->pass[q].run(s->context, begin, end, b->way[block], chunk);
        lap(s, chunk, b->pass[q].seconds, before);
    }
}

/* All that is due when the pairs of so many grains are done; next: of each pass. */
static void do_due(const ry_turn *s, int32_t done, int32_t *next, int chunk, double *before)
{
    const ry_blocks *const b = s->blocks;
    for (int q = 0; q < b->n_passes; q = level_end(b, q)) {
        const int32_t *const due = b->due[level_end(b, q)];
        for (; next[q] < b->edge[chunk + 1] && (due[next[q]] <= done || due[next[q]] == RY_LATE); next[q]++) {
            if (due[next[q]] != RY_LATE) {
                do_level(s, q, next[q], next[q] + 1, chunk, before);
            }
        }
    }
}

static void do_chunk(const ry_turn *s, int chunk)
{
    const ry_blocks *const b = s->blocks;
    const int32_t *const range = s->pairs->chunk + chunk;
    double before = s->timed ? ry_clock() : 0.0;
    int32_t next[RY_MOST_PASSES];
    for (int q = 0; q < b->n_passes; q++) {
        next[q] = b->edge[chunk];
    }
    for (int32_t p = range[0], end; p < range[1]; p = end) {
        end = smaller((p / PUSHED + 1) * PUSHED, range[1]);
        b->push(s->context, p, end, chunk);
        lap(s, chunk, b->push_seconds, &before);
        if (end < range[1]) {
            do_due(s, s->pairs->i[end], next, chunk, &before);
        }
    }
    do_due(s, first_grain(s->pairs, b->edge[chunk + 1]), next, chunk, &before);
}

static void do_late(const ry_turn *s, int q, int chunk)
{
    const ry_blocks *const b = s->blocks;
    const int32_t *const due = b->due[level_end(b, q)];
    double before = s->timed ? ry_clock() : 0.0;
    for (int32_t k = b->edge[chunk], next; k < b->edge[chunk + 1]; k = next) {
        next = k + 1;
        while (b->pass[q].any_length && due[k] == RY_LATE && next < b->edge[chunk + 1] && due[next] == RY_LATE) {
            next++;
        }
        if (due[k] == RY_LATE) {
            do_level(s, q, k, next, chunk, &before);
        }
    }
}

/* First what can be done in one go, then the late ones, level by level. */
static void do_phase(void *context, int phase, int chunk)
{
    const ry_turn *const s = context;
    int q = 0;
    for (int level = 1; level < phase; level++) {
        q = level_end(s->blocks, q);
    }
    if (phase == 0) {
        do_chunk(s, chunk);
    } else {
        do_late(s, q, chunk);
    }
}

void ry_blocks_run(const ry_blocks *b, const ry_pairs *pairs, void *context, int timed)
{
    ry_turn step = {b, pairs, context, timed};
    int phases = 1;
    for (int q = 0; q < b->n_passes; q = level_end(b, q)) {
        phases++;
    }
    ry_phases(b->threads, phases, do_phase, &step);
}
