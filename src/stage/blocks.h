/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The order of work within a step: one stretch of the bed after the other, so that what a grain's contacts give it
 * is still in the cache when the grain is moved.
 *
 * Grains are stored along the bed, and a block is 256 of them. A chunk is a run of blocks with the pairs
 * that its grains own, and each thread has one. It goes through its pairs in order; when those of all partners of a
 * block's grains are done, the block is due for the next pass: its young contacts, if the law treats those apart, then
 * gather, integrate. So each pass follows the one before at a distance of some blocks, which stay in the cache; what
 * contacts give is kept in a ring of slots (ry_shelf), not for the whole list.
 *
 * Blocks with a partner in another chunk, or far away in memory (x wraps; grains that have flowed), are late: they wait
 * until all chunks are through, each pass for itself. No bit depends on who is late: every pass reads what is
 * complete, and each grain adds its slots in ascending id of the partner. */
#ifndef RY_STAGE_BLOCKS_H
#define RY_STAGE_BLOCKS_H

#include "store/pairs.h"

/* Grains of a block. */
enum { RY_BLOCK = 256, RY_MOST_PASSES = 6 };

/* Where the slots of a block's pairs are: slot base + (pair & mask); mask 0: ask ry_pairs_slot. */
typedef struct ry_way {
    int32_t base, mask;
} ry_way;

/* A pass over the grains begin .. end-1, a block of this chunk. */
typedef void ry_pass_fn(void *context, int32_t begin, int32_t end, ry_way way, int chunk);

typedef struct ry_pass {
    ry_pass_fn *run;
    int around; /* needs the pass before to be done with the partners of its grains, too; else it follows at once */
    int any_length; /* takes several blocks at once */
    double *seconds; /* to which its time is added, when steps are timed */
} ry_pass;

typedef struct ry_blocks {
    int threads;
    int apart; /* all are late */
    void (*push)(void *context, int32_t first, int32_t end, int chunk); /* the pairs first .. end-1, at most 128 */
    double *push_seconds;
    int n_passes;
    ry_pass pass[RY_MOST_PASSES];

    int32_t n;           /* blocks */
    int32_t n_far;       /* of which so many have partners far away in memory */
    int32_t *low, *high; /* n: blocks of the furthest partners */
    int32_t *due[RY_MOST_PASSES + 1]; /* n: grains whose pairs must be done before; RY_LATE. Of each pass that does
                                         not follow at once; first of all: when all contacts are known */
    ry_way *way;         /* n */
    int32_t *edge;       /* n_chunks + 1: first block of each chunk */
} ry_blocks;

enum { RY_LATE = INT32_MAX };

/* For n grains; the passes are known. */
ry_status ry_blocks_create(ry_blocks *blocks, int32_t n_grains, ry_error *error);
void ry_blocks_free(ry_blocks *blocks);

/* For a new list: cuts it into chunks, finds out who is due when, and makes room for the slots. */
ry_status ry_blocks_lay(ry_blocks *blocks, ry_pairs *pairs, ry_error *error);

/* All pairs of grains, and all passes. `timed`: the first thread's time is added to the passes' seconds. */
void ry_blocks_run(const ry_blocks *blocks, const ry_pairs *pairs, void *context, int timed);

#endif
