/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the benches share: text, progress, the file, the names of the laws. */
#ifndef RY_STUDY_BENCH_PRIVATE_H
#define RY_STUDY_BENCH_PRIVATE_H

#include <math.h>

#include "base/text.h"
#include "config/laws.h"
#include "io/table_file.h"
#include "study/bench.h"
#include "study/each.h"

typedef struct ry_bench_run {
    const ry_bench_options *options;
    ry_table_file *file;
    int done, n; /* pieces of work */
} ry_bench_run;

#define ry_bench_say(run, ...) ry_text_say((run)->options->write, (run)->options->data, __VA_ARGS__)

/* One more piece is done; from any thread. */
void ry_bench_progress(ry_bench_run *run);

/* "a/b/c", for the file. */
typedef struct ry_bench_path {
    char text[160];
} ry_bench_path;
__attribute__((format(printf, 1, 2))) ry_bench_path ry_bench_at(const char *format, ...);

/* Which laws were asked for, and how many. */
int ry_bench_has_law(const ry_bench_run *run, int law);
int ry_bench_laws(const ry_bench_run *run);

/* The benches. */
#define RY_BENCH_FUNCTION(name, word, text) \
    ry_status ry_bench_##name(ry_bench_run *run, ry_error *error);
RY_LIST_bench(RY_BENCH_FUNCTION)
#undef RY_BENCH_FUNCTION

#endif
