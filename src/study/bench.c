/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench.h"

#include <stdarg.h>
#include <stdio.h>

#include "study/bench_private.h"

static const struct {
    const char *word, *text;
    ry_status (*run)(ry_bench_run *run, ry_error *error);
} benches[RY_BENCHES] = {
#define RY_BENCH(name, word, text) {word, text, ry_bench_##name},
    RY_LIST_bench(RY_BENCH)
#undef RY_BENCH
};

const char *ry_bench_word(int index)
{
    return benches[index].word;
}

const char *ry_bench_text(int index)
{
    return benches[index].text;
}

void ry_bench_progress(ry_bench_run *run)
{
#pragma omp critical
    {
        run->done++;
        if (run->options->progress != NULL) {
            run->options->progress(run->options->data, run->done, run->n);
        }
    }
}

ry_bench_path ry_bench_at(const char *format, ...)
{
    ry_bench_path path;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(path.text, sizeof path.text, format, arguments);
    va_end(arguments);
    return path;
}

int ry_bench_has_law(const ry_bench_run *run, int law)
{
    return run->options->laws == 0 || (run->options->laws >> law & 1u);
}

int ry_bench_laws(const ry_bench_run *run)
{
    int n = 0;
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        n += ry_bench_has_law(run, law);
    }
    return n;
}

ry_status ry_bench(const ry_bench_options *options, ry_error *error)
{
    ry_bench_run run = {.options = options};
    RY_TRY(ry_table_file_create(&run.file, options->output, "ryusa bench", options->force, error));
    ry_table_file_set_text(run.file, "/", "bench", benches[options->bench].word);
    ry_table_file_set_number(run.file, "/", "quick", options->quick);
    if (options->quick) {
        ry_bench_say(&run, "--quick: shorter and fewer runs, to try it out; the numbers of docs/ are those without it\n\n");
    }
    const ry_status status = benches[options->bench].run(&run, error);
    if (status != RY_OK) {
        ry_table_file_discard(run.file);
        return status;
    }
    return ry_table_file_finish(run.file, error);
}
