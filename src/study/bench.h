/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa bench`: what the simulator costs, what it gets right, and where it stays stable, measured with
 * the simulator itself. docs/accuracy.md tells the outcome. */
#ifndef RY_STUDY_BENCH_H
#define RY_STUDY_BENCH_H

#include "ryusa/ryusa.h"

/* RY_BENCH(name in C, "name on the command line", "what it measures") */
#define RY_LIST_bench(RY_BENCH)                                                               \
    RY_BENCH(accuracy, "accuracy", "run time and steps against error, for every contact law") \
    RY_BENCH(stability, "stability",                                                          \
             "where laws stay quiet, jitter, leak or gain energy, explode")                   \
    RY_BENCH(speed, "speed", "grain-steps per second, time per stage, memory")

#define RY_BENCH_ENUM(name, word, text) RY_BENCH_##name,
enum { RY_LIST_bench(RY_BENCH_ENUM) RY_BENCHES };
#undef RY_BENCH_ENUM

/* The word of a bench, and what it measures. */
const char *ry_bench_word(int index);
const char *ry_bench_text(int index);

typedef struct ry_bench_options {
    int bench;          /* RY_BENCH_... */
    const char *output; /* HDF5 file */
    int force;          /* replace it if it is there */
    unsigned laws;      /* bit ry_law: that contact law; 0: all. `speed`: unused */
    int quick;          /* coarse: tens of seconds, for tests and for a first look */
    int threads;        /* simulations at a time; 0: as many as there are cores. `speed`: unused */
    ry_write_fn *write; /* gets the tables, piece by piece */
    /* Called from whichever thread has finished a piece, one at a time; NULL: never. */
    void (*progress)(void *data, int done, int n);
    void *data;
} ry_bench_options;

/* RY_BAD_FILE where the output can't be written; that is known before anything is measured. */
ry_status ry_bench(const ry_bench_options *options, ry_error *error);

#endif
