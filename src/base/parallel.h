/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the hot loops need from the compiler. Every macro here changes time, never bits. */
#ifndef RY_BASE_PARALLEL_H
#define RY_BASE_PARALLEL_H

#include <stdint.h>

#define RY_INLINE static inline __attribute__((always_inline))

/* One compilation per vector width, chosen when the program starts. Contraction is off everywhere,
 * so all give the same bits. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(RY_ONE_TARGET)
#define RY_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define RY_CLONES
#endif

/* Cuts 0 .. n-1 into one range for each thread and calls `task` for each of them, in parallel. With one
 * thread it is a plain call: entering a parallel region of one costs more than a step of a few grains. */
typedef void ry_range_fn(void *context, int32_t begin, int32_t end, int thread);
enum { RY_MOST_THREADS = 1024 };
void ry_parallel(int threads, int32_t n, ry_range_fn *task, void *context);

/* A piece of work in phases: each phase is done for all parts 0 .. parts-1, in parallel, before the next begins. */
typedef void ry_phase_fn(void *context, int phase, int part);
void ry_phases(int parts, int phases, ry_phase_fn *task, void *context);

/* Sums that must not depend on the number of threads run over blocks of this many ids, then over
 * the blocks in order. */
enum { RY_SUM_BLOCK = 1024, RY_SUM_AT_ONCE = 16 /* blocks of a thread, before they are added to the total */ };

#endif
