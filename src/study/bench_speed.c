/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa bench speed`: grain-steps per second of a settled bed and of one that is sheared with drag on
 * every grain, for a linear law and for the default one, beside what the machine needs at least. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/text.h"
#include "sim/sim.h"
#include "study/bench_limit.h"
#include "study/bench_machine.h"
#include "study/bench_private.h"
#include "study/bench_tile.h"

/* Long beds are `tiles` copies of one that has run by itself. */
static const struct {
    int columns, layers, tiles;
} sizes[] = {{5, 10, 1}, {100, 10, 1}, {500, 20, 1}, {500, 20, 10}, {500, 20, 100}};
static const ry_law laws[] = {RY_LAW_CUNDALL, RY_LAW_ENERGY};
static const char *const scenes[] = {"settled", "sheared"};
enum {
    SIZES = sizeof sizes / sizeof sizes[0],
    QUICK_SIZES = 2,
    LAWS = 2,
    SCENES = 2,
    MOST_THREADS = 2
};

enum { MOST_ROWS = SIZES * LAWS * SCENES * MOST_THREADS, TURNS = 7, STEPS_OF_BASE = 3000, FEWEST_STEPS = 20 };

typedef struct row {
    int sheared, law, n, threads; /* n: grains that can move; threads: at most so many, if they pay */
    int size, group;              /* group: of a scene and a law */
    double rate;                  /* grain-steps per second, best window */
    double median;                /* of the windows */
    double rates[TURNS];          /* of all */
    double bytes;                 /* per grain */
    double contacts;              /* per grain */
    double arithmetic, moving;    /* what the machine needs at least [ns per grain-step] */
    int n_stages;
    const char *stage[RY_MOST_STAGES];
    double ns[RY_MOST_STAGES]; /* per grain-step, in the best window */
} row;

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
    ry_bench_say(s->run, "limit: the longer of arithmetic and moving data, ns per grain-step\n");
    ry_bench_say(s->run, "%-8s %-8s %8s %7s %12s %8s %7s %8s %11s %8s  %s\n", "scene", "law", "grains",
                 "threads", "grain-st./s", "median", "bytes", "contacts", "limit", "reached",
                 "ns per grain-step of each stage");
}

/* The part of the machine's limit that the best window reached. */
static double reached(const row *r)
{
    return fmax(r->arithmetic, r->moving) * 1e-9 * r->rate;
}

static void say_row(const study *s, const row *r)
{
    ry_bench_say(s->run, "%-8s %-8s %8d %7d %10.3f M %6.2f M %7.0f %8.2f %5.2f %5.2f %6.0f %% ",
                 scenes[r->sheared], ry_laws[laws[r->law]].word, r->n, r->threads, r->rate * 1e-6,
                 r->median * 1e-6, r->bytes, r->contacts, r->arithmetic, r->moving, 100.0 * reached(r));
    for (int i = 0; i < r->n_stages; i++) {
        ry_bench_say(s->run, " %s %.3g", r->stage[i], r->ns[i]);
    }
    ry_bench_say(s->run, "\n");
}

/* The row of this scene and law with so many grains and threads. */
static const row *find_row(const study *s, const row *like, int n, int threads)
{
    for (int k = 0; k < s->n; k++) {
        const row *const r = &s->rows[k];
        if (r->sheared == like->sheared && r->law == like->law && r->n == n && r->threads == threads) {
            return r;
        }
    }
    return NULL;
}

static int compare(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static double median_of(const double *values)
{
    double sorted[TURNS];
    memcpy(sorted, values, sizeof sorted);
    qsort(sorted, TURNS, sizeof *sorted, compare);
    return sorted[TURNS / 2];
}

/* How many times as fast `a` is as `b`: turn by turn, for a machine that others use, too, is slow for seconds at a
 * time; the median. */
static double times_as_fast(const row *a, const row *b)
{
    double ratio[TURNS];
    for (int turn = 0; turn < TURNS; turn++) {
        ratio[turn] = a->rates[turn] / b->rates[turn];
    }
    return median_of(ratio);
}

/* Against the row's own size with one thread, and against 1000 grains. */
static void say_ratios(const study *s)
{
    for (int k = 0; k < s->n; k++) {
        const row *const r = &s->rows[k];
        const row *const alone = find_row(s, r, r->n, 1), *const small = find_row(s, r, 1000, 1);
        if (r->threads > 1) {
            ry_bench_say(s->run, "%s %s, %d grains: %d threads %.2f times one\n", scenes[r->sheared],
                         ry_laws[laws[r->law]].word, r->n, r->threads, times_as_fast(r, alone));
        } else if (small != NULL && r->n > small->n) {
            ry_bench_say(s->run, "%s %s, %d grains: a grain-step costs %.2f times that of 1000 grains\n",
                         scenes[r->sheared], ry_laws[laws[r->law]].word, r->n, times_as_fast(small, r));
        }
    }
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

/* ns per grain-step of each stage since `before`; nothing where no step of the window was timed. */
static void keep_stages(row *r, const ry_sim *sim, const double *before, long long timed)
{
    for (int s = 0; s < r->n_stages && timed > 0; s++) {
        const double seconds = sim->plan.stage[s].seconds - before[s];
        r->ns[s] = 1e9 * seconds / ((double)r->n * (double)timed);
    }
}

static ry_sim *create(const row *r, int tiles, ry_state *state, ry_config *config, ry_error *error)
{
    *config = make_config(r, sizes[r->size].columns * tiles, sizes[r->size].layers);
    const int pay = ry_plan_threads(r->n), threads = pay < r->threads ? pay : r->threads;
    if (ry_config_resolve(config, error) != RY_OK) {
        return NULL;
    }
    return state != NULL ? ry_sim_adopt(config, state, threads, error) : ry_sim_create(config, threads, error);
}

/* A bed that lies still, or moves. */
static ry_status make_base(const row *r, ry_state *state, ry_error *error)
{
    ry_config config;
    const int tiles = sizes[r->size].tiles;
    ry_sim *const sim = create(r, 1, NULL, &config, error);
    if (sim == NULL) {
        ry_config_free(&config);
        return error->status;
    }
    ry_status status = ry_sim_step(sim, STEPS_OF_BASE, error);
    if (status == RY_OK) {
        status = ry_sim_collect(sim, error);
    }
    if (status == RY_OK) {
        status = ry_bench_tile(state, &sim->state, config.domain_length, tiles, error);
    }
    ry_sim_free(sim);
    ry_config_free(&config);
    return status;
}

/* The shorter of this time's and the last ones'. */
static void find_limit(row *r, int threads)
{
    const ry_law law = laws[r->law];
    const double contact = ry_limit_contact(law, threads), grain = ry_limit_grain(r->sheared, threads);
    const double bytes = ry_limit_bytes(law, r->contacts);
    r->arithmetic = fmin(r->arithmetic, 1e9 * (r->contacts * contact + grain));
    r->moving = fmin(r->moving, 1e9 * bytes * ry_limit_move((size_t)(bytes * r->n), threads));
}

/* A row while it is measured. */
typedef struct entry {
    row *row;
    ry_config config;
    ry_sim *sim;
} entry;

static ry_status open_entry(entry *e, ry_error *error)
{
    row *const r = e->row;
    ry_state state = {0};
    const double heap = ry_machine_heap();
    const ry_status status = make_base(r, &state, error);
    if (status != RY_OK) {
        ry_state_free(&state);
        return status;
    }
    r->contacts = (double)state.contacts.n / r->n;
    e->sim = create(r, sizes[r->size].tiles, &state, &e->config, error);
    if (e->sim == NULL) {
        return error->status;
    }
    r->n_stages = e->sim->plan.n_stages;
    r->arithmetic = r->moving = INFINITY;
    RY_TRY(ry_sim_step(e->sim, FEWEST_STEPS, error));
    r->bytes = (ry_machine_heap() - heap) / r->n;
    return RY_OK;
}

static void close_entry(entry *e)
{
    ry_sim_free(e->sim);
    ry_config_free(&e->config);
}

/* A window; the stages are those of the best one. */
static ry_status time_window(entry *e, int turn, int quick, ry_error *error)
{
    row *const r = e->row;
    ry_sim *const sim = e->sim;
    const long long steps = (long long)fmax(ceil((quick ? 2e5 : 3e6) / r->n), FEWEST_STEPS), timed = sim->timed;
    double before[RY_MOST_STAGES];
    for (int s = 0; s < r->n_stages; s++) {
        r->stage[s] = sim->plan.stage[s].name;
        before[s] = sim->plan.stage[s].seconds;
    }
    const double heap = ry_machine_heap(), begun = ry_clock();
    RY_TRY(ry_sim_step(sim, steps, error));
    r->rates[turn] = (double)r->n * (double)steps / (ry_clock() - begun);
    r->bytes += (ry_machine_heap() - heap) / r->n;
    if (r->rates[turn] > r->rate) {
        r->rate = r->rates[turn];
        keep_stages(r, sim, before, sim->timed - timed);
    }
    if (turn == 0 || turn == TURNS - 1) {
        find_limit(r, sim->plan.threads);
    }
    return RY_OK;
}

/* All sizes and threads of a scene and a law take turns, see times_as_fast. */
static ry_status take_turns(entry *all, int n, int quick, ry_error *error)
{
    for (int k = 0; k < n; k++) {
        RY_TRY(open_entry(&all[k], error));
    }
    for (int turn = 0; turn < TURNS; turn++) {
        for (int k = 0; k < n; k++) {
            RY_TRY(time_window(&all[k], turn, quick, error));
        }
    }
    return RY_OK;
}

static ry_status run_rows(study *s, ry_error *error)
{
    for (int first = 0, end; first < s->n; first = end) {
        entry all[SIZES * MOST_THREADS] = {0};
        for (end = first; end < s->n && s->rows[end].group == s->rows[first].group; end++) {
            all[end - first].row = &s->rows[end];
        }
        const ry_status status = take_turns(all, end - first, s->run->options->quick, error);
        for (int k = 0; k < end - first; k++) {
            close_entry(&all[k]);
        }
        RY_TRY(status);
        for (int k = first; k < end; k++) {
            s->rows[k].median = median_of(s->rows[k].rates);
            say_row(s, &s->rows[k]);
            ry_bench_progress(s->run);
        }
    }
    return RY_OK;
}

static ry_status lay_rows(study *s, ry_error *error)
{
    const int n_sizes = s->run->options->quick ? QUICK_SIZES : SIZES;
    for (int k = 0; k < n_sizes * LAWS * SCENES * MOST_THREADS; k++) {
        const int size = k / MOST_THREADS % n_sizes, group = k / (MOST_THREADS * n_sizes), law = group % LAWS;
        if (ry_bench_has_law(s->run, (int)laws[law])) {
            s->rows[s->n++] = (row){.n = sizes[size].columns * sizes[size].layers * sizes[size].tiles,
                                    .size = size,
                                    .group = group,
                                    .sheared = group / LAWS,
                                    .law = law,
                                    .threads = k % MOST_THREADS + 1};
        }
    }
    s->run->n = s->n;
    return s->n > 0 ? RY_OK
                    : ry_fail(error, RY_BAD_INPUT, "bench speed: -l: the laws whose speed is measured are %s and %s",
                              ry_laws[laws[0]].word, ry_laws[laws[1]].word);
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
    enum { COLUMNS = 9 };
    static const char *const name[COLUMNS] = {"grains", "threads", "rate", "median", "bytes",
                                              "contacts", "arithmetic", "moving", "reached"};
    static const char *const unit[COLUMNS] = {"1", "1", "1/s", "1/s", "1", "1", "ns", "ns", "1"};
    static const char *const text[COLUMNS] = {
        "grains that can move", "threads at most", "grain-steps per second, best window",
        "the same, median window", "memory per grain [bytes]", "contacts per grain",
        "arithmetic alone, per grain-step", "moving the data alone, per grain-step",
        "part of the machine's limit that the best window reached"};
    double value[COLUMNS][MOST_ROWS];
    const char *scene[MOST_ROWS], *law[MOST_ROWS];
    for (int k = 0; k < s->n; k++) {
        const row *const r = &s->rows[k];
        const double line[COLUMNS] = {r->n,        r->threads,    r->rate,   r->median, r->bytes,
                                      r->contacts, r->arithmetic, r->moving, reached(r)};
        scene[k] = scenes[r->sheared];
        law[k] = ry_laws[laws[r->law]].word;
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
    return ry_text_print("%.*s.csv", ry_text_stem(output), output);
}

static void fill_csv(FILE *file, const study *s, const ry_machine *m)
{
    fprintf(file, "# ryusa %s; %s; %d cores, load %.2f; %s\n", ry_version(), m->processor, m->cores,
            m->load, m->compiler);
    fprintf(file, "scene,law,grains,threads,grain_steps_per_second,median,bytes_per_grain,"
                  "contacts_per_grain,arithmetic_ns,moving_ns,reached\n");
    for (int k = 0; k < s->n; k++) {
        const row *const r = &s->rows[k];
        fprintf(file, "%s,%s,%d,%d,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.3f\n", scenes[r->sheared],
                ry_laws[laws[r->law]].word, r->n, r->threads, r->rate, r->median, r->bytes,
                r->contacts, r->arithmetic, r->moving, reached(r));
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
    RY_TRY(lay_rows(&s, error));
    say_head(&s, &machine);
    RY_TRY(run_rows(&s, error));
    say_ratios(&s);
    write_file(&s, &machine);
    return write_csv(&s, &machine, error);
}
