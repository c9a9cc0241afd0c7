/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * OUT.h5 of a sweep: /cases, a row for each case; /points, a row for each point with its replicas
 * taken together; /inputs/..., what was varied; /results/case-0001, links to the runs. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/replicas.h"
#include "base/memory.h"
#include "base/text.h"
#include "config/keys.h"
#include "config/quantity.h"
#include "io/table_file.h"
#include "study/sweep_private.h"

/* Below this mean q* a point tells nothing about how much moving beds differ. */
#define LEAST_FLUX 1e-2

/* The columns of /cases. */
typedef struct columns {
    int n;
    double *index, *replica, *seed, *shields, *q_star, *error, *tau, *equilibration, *samples,
        *status, *wall, *early;
    double **input; /* one for each varied key; a choice by its index */
    const char ***word;
    char **text, **message, **file, **hash;
} columns;

static double *numbers(int n)
{
    return calloc((size_t)n + 1, sizeof(double));
}

static char **texts(int n)
{
    return calloc((size_t)n + 1, sizeof(char *));
}

static int reserve(columns *t, int n, int n_axes)
{
    double **const all[] = {&t->index,   &t->replica, &t->seed, &t->shields,
                            &t->q_star,  &t->error,   &t->tau,  &t->equilibration,
                            &t->samples, &t->status,  &t->wall, &t->early};
    int good = 1;
    t->n = n;
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        *all[k] = numbers(n);
        good = good && *all[k] != NULL;
    }
    t->input = calloc((size_t)n_axes + 1, sizeof *t->input);
    t->word = calloc((size_t)n_axes + 1, sizeof *t->word);
    for (int k = 0; k < n_axes && t->input != NULL && t->word != NULL; k++) {
        t->input[k] = numbers(n);
        t->word[k] = calloc((size_t)n + 1, sizeof **t->word);
        good = good && t->input[k] != NULL && t->word[k] != NULL;
    }
    t->text = texts(n);
    t->message = texts(n);
    t->file = texts(n);
    t->hash = texts(n);
    return good && t->input && t->word && t->text && t->message && t->file && t->hash;
}

static void release(columns *t, int n_axes)
{
    double *const all[] = {t->index, t->replica,       t->seed,    t->shields, t->q_star, t->error,
                           t->tau,   t->equilibration, t->samples, t->status,  t->wall,   t->early};
    char **const words[] = {t->text, t->message, t->file, t->hash};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        free(all[k]);
    }
    for (int k = 0; k < n_axes; k++) {
        free(t->input != NULL ? t->input[k] : NULL);
        free(t->word != NULL ? (void *)t->word[k] : NULL);
    }
    for (int k = 0; k < 4; k++) {
        for (int i = 0; words[k] != NULL && i < t->n; i++) {
            free(words[k][i]);
        }
        free(words[k]);
    }
    free(t->input);
    free(t->word);
}

/* What the sweep says of a case that its scene refuses. */
static void fill_asked(const ry_sweep_run *run, columns *t, int k)
{
    for (int i = 0; i < run->file.n_axes; i++) {
        const char *const text = ry_sweep_file_value(&run->file, k / run->file.replicas, i);
        const ry_key_row *const row = ry_keys_row(run->file.axis[i].key);
        char problem[400];
        double value;
        const int is_number = row->words == NULL && ry_quantity_read(text, row->unit, &value, problem, sizeof problem);
        t->input[i][k] = is_number ? value : NAN;
        t->word[i][k] = row->words != NULL ? text : "";
        if (run->file.axis[i].key == RY_KEY_fluid_shields) {
            t->shields[k] = t->input[i][k];
        }
    }
}

/* What was varied, and theta, as the case's scene resolves them. */
static void fill_inputs(const ry_sweep_run *run, columns *t, int k)
{
    ry_config config;
    const int known = ry_sweep_case_config(run, k, &config, NULL) == RY_OK;
    t->seed[k] = known ? (double)config.grains_seed : NAN;
    t->shields[k] =
        known && config.fluid_model != RY_FLUID_NONE ? ry_config_derive(&config).shields : NAN;
    for (int i = 0; i < run->file.n_axes; i++) {
        ry_parameter p = {.word = ""};
        const int key = run->file.axis[i].key;
        t->input[i][k] = known ? ry_keys_get(&config, key) : NAN;
        if (known) {
            ry_config_parameter(&config, key, &p);
        }
        t->word[i][k] = p.word != NULL ? p.word : "";
    }
    if (known) {
        ry_config_free(&config);
    } else {
        fill_asked(run, t, k);
    }
}

/* The name of OUT.d as seen from OUT.h5: they are neighbours. */
static const char *folder_name(const ry_sweep_run *run)
{
    const char *const slash = strrchr(run->store.folder, '/');
    return slash != NULL ? slash + 1 : run->store.folder;
}

static int fill_row(const ry_sweep_run *run, columns *t, int k)
{
    const ry_case_record *const r = &run->cases[k].record;
    char *const name = ry_sweep_store_name(&run->store, k, ".h5", 0);
    t->index[k] = k + 1;
    t->replica[k] = k % run->file.replicas + 1;
    t->q_star[k] = r->known ? r->q_star : NAN;
    t->error[k] = r->known ? r->q_star_error : NAN;
    t->tau[k] = r->known ? r->autocorrelation_time : NAN;
    t->equilibration[k] = r->known ? r->equilibration_time : NAN;
    t->samples[k] = (double)r->samples;
    t->status[k] = r->known ? r->status : -1;
    t->wall[k] = r->known ? r->wall_seconds : NAN;
    t->early[k] = r->stopped_early;
    t->text[k] = ry_sweep_case_text(run, k);
    t->message[k] = strdup(r->known ? r->message : "not run yet");
    t->file[k] = name != NULL ? ry_text_print("%s/%s", folder_name(run), name) : NULL;
    t->hash[k] = ry_text_print("0x%016llx", r->hash);
    free(name);
    fill_inputs(run, t, k);
    return t->text[k] != NULL && t->message[k] != NULL && t->file[k] != NULL && t->hash[k] != NULL;
}

static void write_cases(const ry_sweep_run *run, const columns *t, ry_table_file *f)
{
    const int n = t->n;
    ry_table_file_numbers(f, "cases/case", "1", "number of the case, from 1", n, t->index);
    ry_table_file_numbers(f, "cases/replica", "1", "number of the replica of its point, from 1", n,
                          t->replica);
    ry_table_file_numbers(f, "cases/seed", "1", "grains.seed", n, t->seed);
    ry_table_file_numbers(f, "cases/shields", "1", "Shields number theta", n, t->shields);
    ry_table_file_numbers(f, "cases/q_star", "1", "mean dimensionless flux", n, t->q_star);
    ry_table_file_numbers(f, "cases/q_star_standard_error", "1",
                          "from the autocorrelation of its series", n, t->error);
    ry_table_file_numbers(f, "cases/autocorrelation_time", "s", "integrated, of q*", n, t->tau);
    ry_table_file_numbers(f, "cases/equilibration_time", "s", "samples before it were cut", n,
                          t->equilibration);
    ry_table_file_numbers(f, "cases/samples", "1", "behind the cut", n, t->samples);
    ry_table_file_numbers(f, "cases/status", "1",
                          "0 done, -1 not run yet, otherwise failed: see message", n, t->status);
    ry_table_file_numbers(f, "cases/stopped_early", "1", "1: stop.flux_error was reached", n,
                          t->early);
    ry_table_file_numbers(f, "cases/wall_seconds", "s", "of the call that ended it", n, t->wall);
    ry_table_file_texts(f, "cases/message", "what went wrong", n, (const char *const *)t->message);
    ry_table_file_texts(f, "cases/changes", "what differs from the scene", n,
                        (const char *const *)t->text);
    ry_table_file_texts(f, "cases/file", "result, from the folder of this file", n,
                        (const char *const *)t->file);
    ry_table_file_texts(f, "cases/hash", "of the last state", n, (const char *const *)t->hash);
    for (int k = 0; k < run->file.n_axes; k++) {
        const ry_key_row *const row = ry_keys_row(run->file.axis[k].key);
        char path[120];
        snprintf(path, sizeof path, "inputs/%s", run->file.axis[k].path);
        if (row->type == 'c') {
            ry_table_file_texts(f, path, row->text, n, t->word[k]);
        } else {
            ry_table_file_numbers(f, path, row->unit[0] != '\0' ? row->unit : "1", row->text, n,
                                  t->input[k]);
        }
    }
}

/* Each point's replicas that are done, and what beds differ by over all points; 0: no memory. */
static int gather_points(const columns *t, int n, int replicas, double *value, ry_replicas *point,
                         ry_replicas_interval *interval, double *spread)
{
    for (int k = 0; k < n * replicas; k++) {
        value[k] = t->status[k] == 0.0 ? t->q_star[k] : NAN;
    }
    for (int k = 0; k < n; k++) {
        point[k] = ry_replicas_of(replicas, value + k * replicas, t->error + k * replicas);
    }
    *spread = ry_replicas_spread(n, point, LEAST_FLUX);
    return ry_replicas_pool(n, point, LEAST_FLUX, interval);
}

static int write_points(const ry_sweep_run *run, const columns *t, ry_table_file *f)
{
    enum { CASE, SHIELDS, DONE, MEAN, OWN, SPREAD, BOTH, WIDE, COLUMNS };
    const int n = run->file.n_points, replicas = run->file.replicas;
    double *column[COLUMNS];
    double *const value = numbers(t->n);
    ry_replicas *const point = calloc((size_t)n + 1, sizeof *point);
    ry_replicas_interval *const interval = calloc((size_t)n + 1, sizeof *interval);
    int good = value != NULL && point != NULL && interval != NULL;
    double spread = 0.0;
    for (int c = 0; c < COLUMNS; c++) {
        column[c] = numbers(n);
        good = good && column[c] != NULL;
    }
    good = good && gather_points(t, n, replicas, value, point, interval, &spread);
    for (int k = 0; k < n && good; k++) {
        column[CASE][k] = k * replicas + 1;
        column[SHIELDS][k] = t->shields[k * replicas];
        column[DONE][k] = point[k].n;
        column[MEAN][k] = point[k].mean;
        column[OWN][k] = point[k].within;
        column[SPREAD][k] = point[k].n > 1 ? point[k].between : NAN;
        column[BOTH][k] = interval[k].standard_error;
        column[WIDE][k] = interval[k].confidence_95;
    }
    if (good) {
        ry_table_file_numbers(f, "points/first_case", "1", "row of /cases and /inputs, from 1", n,
                              column[CASE]);
        ry_table_file_numbers(f, "points/shields", "1", "Shields number theta", n, column[SHIELDS]);
        ry_table_file_numbers(f, "points/replicas", "1", "replicas that are done", n, column[DONE]);
        ry_table_file_numbers(f, "points/q_star", "1", "mean of the replicas", n, column[MEAN]);
        ry_table_file_numbers(f, "points/error_within", "1",
                              "error of the mean by the replicas' own errors", n, column[OWN]);
        ry_table_file_numbers(f, "points/error_between", "1",
                              "error of the mean by what the replicas differ by beyond that", n,
                              column[SPREAD]);
        ry_table_file_numbers(f, "points/q_star_standard_error", "1",
                              "+- this holds the mean of all beds in 68.3 %; what beds differ by is pooled over "
                              "points of similar flux", n, column[BOTH]);
        ry_table_file_numbers(f, "points/q_star_confidence_95", "1", "+- this holds it in 95 %, by Student's t", n,
                              column[WIDE]);
        ry_table_file_set_number(f, "points", "spread_between_replicas", spread);
    }
    free(value);
    free(point);
    free(interval);
    for (int c = 0; c < COLUMNS; c++) {
        free(column[c]);
    }
    return good;
}

static void write_head(const ry_sweep_run *run, ry_table_file *f)
{
    const char *const sweep_text = run->file.text, *const scene_text = run->base.text;
    char *keys = strdup("");
    for (int k = 0; k < run->file.n_axes && keys != NULL; k++) {
        char *const longer =
            ry_text_print("%s%s%s", keys, k > 0 ? "," : "", run->file.axis[k].path);
        free(keys);
        keys = longer;
    }
    ry_table_file_texts(f, "sweep_text", "the sweep file", 1, &sweep_text);
    ry_table_file_texts(f, "scene_text", "the scene, with what the sweep sets", 1, &scene_text);
    ry_table_file_set_text(f, "/", "varied", keys != NULL ? keys : "");
    ry_table_file_set_text(f, "/", "title",
                           run->file.title != NULL ? run->file.title : run->base.title);
    ry_table_file_set_text(f, "/", "sample", ry_sweep_file_sampling(&run->file));
    ry_table_file_set_number(f, "/", "replicas", run->file.replicas);
    ry_table_file_set_text(
        f, "/", "q_star",
        "q_b/sqrt((s-1) g d^3), q_b = sum of sphere volume x velocity / (length x d)");
    free(keys);
}

static int write_links(const ry_sweep_run *run, const columns *t, ry_table_file *f)
{
    for (int k = 0; k < t->n; k++) {
        char *const name = ry_sweep_store_name(&run->store, k, "", 0);
        char *const path = name != NULL ? ry_text_print("results/%s", name) : NULL;
        if (path != NULL && t->status[k] == 0.0) {
            ry_table_file_link(f, path, t->file[k]);
        }
        free(name);
        free(path);
        if (path == NULL) {
            return 0;
        }
    }
    return 1;
}

ry_status ry_sweep_table_write(const ry_sweep_run *run, ry_error *error)
{
    columns t = {0};
    ry_table_file *f = NULL;
    int good = reserve(&t, run->n_cases, run->file.n_axes);
    for (int k = 0; k < run->n_cases && good; k++) {
        good = fill_row(run, &t, k);
    }
    ry_status status = good ? ry_table_file_create(&f, run->store.output, RY_SWEEP_PROGRAM, 1, error)
                            : ry_no_memory(error, (size_t)run->n_cases * 200);
    if (status == RY_OK) {
        write_head(run, f);
        write_cases(run, &t, f);
        if (write_points(run, &t, f) && write_links(run, &t, f)) {
            status = ry_table_file_finish(f, error);
        } else {
            ry_table_file_discard(f);
            status = ry_no_memory(error, (size_t)run->n_cases * 200);
        }
    }
    release(&t, run->file.n_axes);
    return status;
}
