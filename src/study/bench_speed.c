/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa bench speed`: grain-steps per second of a settled bed and of one that is sheared with drag on
 * every grain, for a linear law and for the default one. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "sim/sim.h"
#include "study/bench_machine.h"
#include "study/bench_private.h"

static const struct {
    int columns, layers;
} sizes[] = {{5, 10}, {100, 10}, {200, 10}, {500, 20}, {5000, 20}};
static const ry_law laws[] = {RY_LAW_CUNDALL, RY_LAW_ENERGY};
static const char *const scenes[] = {"settled", "sheared"};
enum {
    SIZES = sizeof sizes / sizeof sizes[0],
    QUICK_SIZES = 2,
    LAWS = 2,
    SCENES = 2,
    MOST_THREADS = 2
};

typedef struct row {
    int sheared, law, n, threads; /* n: grains that can move */
    double rate;                  /* grain-steps per second, best window */
    double median;                /* of the windows */
    double bytes;                 /* per grain */
    int n_stages;
    const char *stage[RY_MOST_STAGES];
    double ns[RY_MOST_STAGES]; /* per grain-step, in the best window */
} row;

enum { MOST_ROWS = SIZES * LAWS * SCENES * MOST_THREADS, WINDOWS = 7 };

typedef struct study {
    ry_bench_run *run;
    int n;
    row rows[MOST_ROWS];
} study;

/* --- what is said ------------------------------------------------------------------------------- */

static void say_head(const study *s, const ry_machine *m)
{
    ry_bench_say(s->run, "%s, %d cores, load %.2f; %s\n", m->processor, m->cores, m->load,
                 m->compiler);
    ry_bench_say(s->run, "%-8s %-8s %8s %7s %12s %8s %7s  %s\n", "scene", "law", "grains",
                 "threads", "grain-st./s", "median", "bytes", "ns per grain-step of each stage");
}

static void say_row(const study *s, const row *r)
{
    ry_bench_say(s->run, "%-8s %-8s %8d %7d %10.3f M %6.2f M %7.0f ", scenes[r->sheared],
                 ry_bench_law[laws[r->law]], r->n, r->threads, r->rate * 1e-6, r->median * 1e-6,
                 r->bytes);
    for (int i = 0; i < r->n_stages; i++) {
        ry_bench_say(s->run, " %s %.3g", r->stage[i], r->ns[i]);
    }
    ry_bench_say(s->run, "\n");
}

/* --- measuring ---------------------------------------------------------------------------------- */

/* alpha_cn as large as an explicit dashpot bears in a bed, so that both laws run the same scene. */
static ry_config make_config(const row *r, int columns, int layers)
{
    ry_config config = ry_config_default(1);
    config.grains_columns = columns;
    config.grains_layers = layers;
    config.contact_law = laws[r->law];
    config.contact_alpha_cn = 0.1;
    config.time_settle = 0.0;
    config.fluid_model = r->sheared ? RY_FLUID_BALANCE : RY_FLUID_NONE;
    config.fluid_shields = 0.5;
    config.output_fields = RY_FIELD_FLUX;
    return config;
}

static int compare(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* ns per grain-step of each stage since `before`; nothing where no step of the window was timed. */
static void keep_stages(row *r, const ry_sim *sim, const double *before, long long timed)
{
    for (int s = 0; s < r->n_stages && timed > 0; s++) {
        const double seconds = sim->plan.stage[s].seconds - before[s];
        r->ns[s] = 1e9 * seconds / ((double)r->n * (double)timed);
    }
}

/* Windows of `steps` steps each; the stages are those of the best one. */
static ry_status time_windows(row *r, ry_sim *sim, long long steps, ry_error *error)
{
    double rate[WINDOWS], before[RY_MOST_STAGES];
    r->n_stages = sim->plan.n_stages;
    for (int k = 0; k < WINDOWS; k++) {
        const long long timed = sim->timed;
        for (int s = 0; s < r->n_stages; s++) {
            r->stage[s] = sim->plan.stage[s].name;
            before[s] = sim->plan.stage[s].seconds;
        }
        const double begun = ry_clock();
        RY_TRY(ry_sim_step(sim, steps, error));
        rate[k] = (double)r->n * (double)steps / (ry_clock() - begun);
        if (rate[k] > r->rate) {
            r->rate = rate[k];
            keep_stages(r, sim, before, sim->timed - timed);
        }
    }
    qsort(rate, WINDOWS, sizeof *rate, compare);
    r->median = rate[WINDOWS / 2];
    return RY_OK;
}

/* The bed first runs until it lies still, or moves: 3000 steps, fewer where that would take long. */
static ry_status measure(row *r, const ry_config *config, int quick, ry_error *error)
{
    const double heap = ry_machine_heap();
    ry_sim *const sim = ry_sim_create(config, r->threads, error);
    if (sim == NULL) {
        return error->status;
    }
    const double budget = quick ? 2e5 : 2e7, window = quick ? 2e5 : 3e6;
    ry_status status = ry_sim_step(sim, (long long)fmin(3000.0, ceil(budget / r->n)), error);
    r->bytes = (ry_machine_heap() - heap) / r->n;
    if (status == RY_OK) {
        status = time_windows(r, sim, (long long)ceil(window / r->n), error);
    }
    ry_sim_free(sim);
    return status;
}

static ry_status run_rows(study *s, ry_error *error)
{
    for (int k = 0; k < s->n; k++) {
        row *const r = &s->rows[k];
        const int size = k / (LAWS * SCENES * MOST_THREADS);
        ry_config config = make_config(r, sizes[size].columns, sizes[size].layers);
        ry_status status = ry_config_resolve(&config, error);
        if (status == RY_OK) {
            status = measure(r, &config, s->run->options->quick, error);
        }
        ry_config_free(&config);
        RY_TRY(status);
        say_row(s, r);
        ry_bench_progress(s->run);
    }
    return RY_OK;
}

static void lay_rows(study *s)
{
    const int n_sizes = s->run->options->quick ? QUICK_SIZES : SIZES;
    for (int size = 0; size < n_sizes; size++) {
        for (int k = 0; k < LAWS * SCENES * MOST_THREADS; k++) {
            s->rows[s->n++] = (row){.n = sizes[size].columns * sizes[size].layers,
                                    .sheared = k / (LAWS * MOST_THREADS),
                                    .law = k / MOST_THREADS % LAWS,
                                    .threads = k % MOST_THREADS + 1};
        }
    }
    s->run->n = s->n;
}

/* --- what is written ---------------------------------------------------------------------------- */

static void write_machine(const study *s, const ry_machine *m)
{
    ry_table_file *const f = s->run->file;
    ry_table_file_set_text(f, "machine", "processor", m->processor);
    ry_table_file_set_text(f, "machine", "compiler", m->compiler);
    ry_table_file_set_number(f, "machine", "cores", m->cores);
    ry_table_file_set_number(f, "machine", "load", m->load);
}

static void write_file(const study *s, const ry_machine *machine)
{
    enum { COLUMNS = 5 };
    static const char *const name[COLUMNS] = {"grains", "threads", "rate", "median", "bytes"};
    static const char *const unit[COLUMNS] = {"1", "1", "1/s", "1/s", "1"};
    static const char *const text[COLUMNS] = {
        "grains that can move", "threads", "grain-steps per second, best window",
        "the same, median window", "memory per grain [bytes]"};
    double value[COLUMNS][MOST_ROWS];
    const char *scene[MOST_ROWS], *law[MOST_ROWS];
    for (int k = 0; k < s->n; k++) {
        const row *const r = &s->rows[k];
        const double line[COLUMNS] = {r->n, r->threads, r->rate, r->median, r->bytes};
        scene[k] = scenes[r->sheared];
        law[k] = ry_bench_law[laws[r->law]];
        for (int i = 0; i < COLUMNS; i++) {
            value[i][k] = line[i];
        }
        for (int i = 0; i < r->n_stages; i++) {
            const ry_bench_path at =
                ry_bench_at("stages/%s/%s/%d/%d", scene[k], law[k], r->n, r->threads);
            ry_table_file_set_number(s->run->file, at.text, r->stage[i], r->ns[i]);
        }
    }
    write_machine(s, machine);
    ry_table_file_set_text(s->run->file, "stages", "text",
                           "ns per grain-step: scene/law/grains/threads");
    ry_table_file_texts(s->run->file, "runs/scene", "settled bed, or sheared with drag", s->n,
                        scene);
    ry_table_file_texts(s->run->file, "runs/law", "contact law", s->n, law);
    for (int i = 0; i < COLUMNS; i++) {
        ry_table_file_numbers(s->run->file, ry_bench_at("runs/%s", name[i]).text, unit[i], text[i],
                              s->n, value[i]);
    }
}

/* bench-speed.h5 -> bench-speed.csv */
static char *csv_name(const char *output)
{
    const size_t length = strlen(output);
    const size_t stem = length > 3 && strcmp(output + length - 3, ".h5") == 0 ? length - 3 : length;
    char *const name = malloc(stem + sizeof ".csv");
    if (name != NULL) {
        memcpy(name, output, stem);
        memcpy(name + stem, ".csv", sizeof ".csv");
    }
    return name;
}

static void fill_csv(FILE *file, const study *s, const ry_machine *m)
{
    fprintf(file, "# ryusa %s; %s; %d cores, load %.2f; %s\n", ry_version(), m->processor, m->cores,
            m->load, m->compiler);
    fprintf(file, "scene,law,grains,threads,grain_steps_per_second,median,bytes_per_grain\n");
    for (int k = 0; k < s->n; k++) {
        const row *const r = &s->rows[k];
        fprintf(file, "%s,%s,%d,%d,%.4g,%.4g,%.4g\n", scenes[r->sheared],
                ry_bench_law[laws[r->law]], r->n, r->threads, r->rate, r->median, r->bytes);
    }
}

static ry_status write_csv(const study *s, const ry_machine *m, ry_error *error)
{
    char *const name = csv_name(s->run->options->output);
    if (name == NULL) {
        return ry_no_memory(error, strlen(s->run->options->output));
    }
    FILE *const file = fopen(name, "w");
    ry_status status = RY_OK;
    if (file != NULL) {
        fill_csv(file, s, m);
    }
    if (file == NULL || (ferror(file) | (fclose(file) != 0))) {
        status = ry_fail(error, RY_BAD_FILE, "%s: %s", name, strerror(errno));
    }
    free(name);
    return status;
}

ry_status ry_bench_speed(ry_bench_run *run, ry_error *error)
{
    const ry_machine machine = ry_machine_describe();
    study s = {.run = run};
    lay_rows(&s);
    say_head(&s, &machine);
    RY_TRY(run_rows(&s, error));
    write_file(&s, &machine);
    return write_csv(&s, &machine, error);
}
