/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A case is one ry_run in a process of its own, which leaves case-0001.h5 and the record of how it
 * ended. Whatever happens to this process or to the machine, the records and the files tell what is
 * still to be done. */
#include "study/sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/table_file.h"
#include "scene/scene.h"
#include "sim/plan.h"
#include "study/pool.h"
#include "study/sweep_private.h"

static double work_of(const ry_config *config)
{
    const ry_scene_size size = ry_scene_measure(config);
    return (double)(size.explicit_grains + size.bed + size.floor) *
           (double)ry_config_derive(config).steps_end;
}

static int grains_of(const ry_config *config)
{
    const ry_scene_size size = ry_scene_measure(config);
    return (int)(size.explicit_grains + size.bed + size.floor);
}

/* --- one case, in its own process --------------------------------------------------------------- */

static int tell(void *data, long long step, long long last_step, double rate)
{
    (void)rate;
    ry_pool_tell(data, last_step > 0 ? (double)step / (double)last_step : 0.0);
    return ry_pool_must_stop();
}

static ry_case_record make_record(ry_status status, const ry_run_result *r, const ry_error *error)
{
    ry_case_record record = {.known = 1,
                             .status = (int)status,
                             .q_star = r->q_star,
                             .q_star_error = r->q_star_error,
                             .autocorrelation_time = r->autocorrelation_time,
                             .equilibration_time = r->equilibration,
                             .samples = r->samples,
                             .wall_seconds = r->wall_seconds,
                             .stopped_early = r->stopped_early,
                             .hash = r->hash};
    if (status != RY_OK || r->samples == 0) {
        record.q_star = record.q_star_error = record.autocorrelation_time = NAN;
    }
    snprintf(record.message, sizeof record.message, "%.*s", (int)sizeof record.message - 1,
             error->text);
    return record;
}

static int run_case(void *data, int index, ry_pool_worker *worker)
{
    ry_sweep_run *const run = data;
    ry_error error = {0};
    ry_config config;
    ry_run_result result = {0};
    char *const output = ry_sweep_store_name(&run->store, index, ".h5", 1);
    ry_status status = output != NULL ? ry_sweep_case_config(run, index, &config, &error)
                                      : ry_no_memory(&error, 1);
    if (status == RY_OK) {
        const ry_run_options options = {.output = output,
                                        .threads = run->threads,
                                        .resume = run->options->resume,
                                        .progress = tell,
                                        .data = worker};
        const double start = ry_clock();
        status = ry_run(&config, &options, &result, &error);
        if (result.wall_seconds == 0.0 && result.steps > 0) { /* it did not come to its end */
            result.wall_seconds = ry_clock() - start;
        }
    }
    if (status == RY_STOPPED) {
        return RY_STOPPED;
    }
    const ry_case_record record = make_record(status, &result, &error);
    return ry_sweep_store_write(&run->store, index, &record, NULL) == RY_OK ? 0 : RY_BAD_FILE;
}

/* --- all cases ---------------------------------------------------------------------------------- */

static double seconds_left(const ry_sweep_run *run, double work_running)
{
    const double now = run->work_ended + work_running;
    const double done = now - run->work_before, elapsed = ry_clock() - run->started;
    return done > 0.0 && elapsed > 1.0 ? (run->work_all - now) / done * elapsed : NAN;
}

static int report(ry_sweep_run *run, int running, double work_running, const char *news)
{
    const ry_sweep_progress p = {
        .cases = run->n_mine,
        .ended = run->n_ended,
        .failed = run->n_failed,
        .running = running,
        .share = run->work_all > 0.0 ? (run->work_ended + work_running) / run->work_all : 1.0,
        .seconds_left = seconds_left(run, work_running),
        .news = news};
    if (run->options->progress != NULL && run->options->progress(run->options->data, &p)) {
        run->stopping = 1;
    }
    return run->stopping || run->broken;
}

static int look(void *data, int n_running, const int *job, const double *share)
{
    ry_sweep_run *const run = data;
    double work = 0.0;
    for (int k = 0; k < n_running; k++) {
        work += share[k] * run->cases[job[k]].work;
    }
    return report(run, n_running, work, NULL);
}

/* Counts a case that has ended and says so. */
static void count_case(ry_sweep_run *run, int index, int is_new)
{
    const ry_case_record *const r = &run->cases[index].record;
    char *const text = ry_sweep_case_text(run, index), *news = NULL;
    run->n_ended++;
    run->work_ended += run->cases[index].work;
    if (r->status != RY_OK) {
        run->n_failed++;
        news = ry_text_print("case %d of %d (%s): FAILED: %s", index + 1, run->n_cases,
                             text != NULL ? text : "", r->message);
    } else {
        news =
            ry_text_print("case %d of %d (%s): q* = %.4g +- %.2g, %.3g s", index + 1, run->n_cases,
                          text != NULL ? text : "", r->q_star, r->q_star_error, r->wall_seconds);
    }
    if (is_new && news != NULL) {
        report(run, 0, 0.0, news);
    }
    free(text);
    free(news);
}

static void on_end(void *data, int index, int exit_code, int killed_by)
{
    ry_sweep_run *const run = data;
    ry_case_record *const r = &run->cases[index].record;
    if (exit_code == RY_STOPPED) {
        return;
    }
    if (killed_by == 0 && exit_code == 0 &&
        ry_sweep_store_read(&run->store, index, r, NULL) == RY_OK && r->known) {
        count_case(run, index, 1);
        return;
    }
    *r = (ry_case_record){.known = killed_by > 0,
                          .status = 128 + killed_by,
                          .q_star = NAN,
                          .q_star_error = NAN,
                          .autocorrelation_time = NAN,
                          .wall_seconds = NAN};
    if (killed_by > 0) {
        snprintf(r->message, sizeof r->message, "its process was killed by signal %d (%s)",
                 killed_by, strsignal(killed_by));
        ry_sweep_store_write(&run->store, index, r, NULL);
        count_case(run, index, 1);
        return;
    }
    /* The next case would find the same disk full. */
    run->broken = 1;
    ry_fail(
        run->error, RY_BAD_FILE,
        "%s: what became of case %d can't be written there (disk full?); what is done is kept, and --resume goes on",
        run->store.folder, index + 1);
}

/* Before anything is made: which cases are refused. All of them: the sweep is wrong. */
static ry_status check_cases(ry_sweep_run *run)
{
    ry_error first = {0};
    int refused = 0;
    for (int k = 0; k < run->n_cases; k++) {
        ry_error error = {0};
        ry_config config;
        ry_sweep_case *const c = &run->cases[k];
        if (ry_sweep_case_config(run, k, &config, &error) == RY_OK) {
            c->work = work_of(&config);
            ry_config_free(&config);
            continue;
        }
        const ry_run_result none = {.wall_seconds = 0.0};
        c->record = make_record(error.status, &none, &error);
        first = refused++ == 0 ? error : first;
    }
    if (refused == run->n_cases) {
        return ry_fail(run->error, first.status, "%s: every case is refused; the first: %s",
                       run->file.path, first.text);
    }
    return RY_OK;
}

/* 1: the record holds the end of the case. What failed for want of a file or a process is tried again,
 * what became unphysical would do so again. */
static int is_ended(const ry_sweep_run *run, int index, const ry_case_record *r)
{
    if (!r->known || r->status == RY_UNPHYSICAL) {
        return r->known;
    }
    char *const name = ry_sweep_store_name(&run->store, index, ".h5", 1);
    const int there = name != NULL && access(name, F_OK) == 0;
    free(name);
    return r->status == RY_OK && there;
}

/* Which of our cases are to be run; those that are refused have their record already. */
static ry_status choose(ry_sweep_run *run)
{
    const ry_sweep_options *const o = run->options;
    for (int k = 0; k < run->n_cases; k++) {
        ry_sweep_case *const c = &run->cases[k];
        c->mine = o->shards == 0 || k % o->shards == o->shard - 1;
        if (!c->mine) {
            continue;
        }
        run->n_mine++;
        run->work_all += c->work;
        if (o->force) {
            ry_sweep_store_remove(&run->store, k);
        } else if (!o->resume && ry_sweep_store_has(&run->store, k)) {
            return ry_fail(run->error, RY_BAD_FILE,
                           "%s: holds results; --resume goes on with them, --force begins anew",
                           run->store.folder);
        }
        if (c->record.known) {
            RY_TRY(ry_sweep_store_write(&run->store, k, &c->record, run->error));
            count_case(run, k, 1);
            continue;
        }
        RY_TRY(ry_sweep_store_read(&run->store, k, &c->record, run->error));
        c->todo = !is_ended(run, k, &c->record);
        if (!c->todo) {
            count_case(run, k, 0);
        }
    }
    return RY_OK;
}

/* Long cases first, so that no core waits for one at the end. */
static const ry_sweep_case *sorted_cases; /* qsort has no argument for it */

static int by_work(const void *a, const void *b)
{
    const int i = *(const int *)a, k = *(const int *)b;
    const double difference = sorted_cases[k].work - sorted_cases[i].work;
    return difference > 0.0 ? 1 : difference < 0.0 ? -1 : (i > k) - (i < k);
}

static ry_status run_cases(ry_sweep_run *run)
{
    int *const job = calloc((size_t)run->n_cases, sizeof *job);
    int n = 0, most_grains = 0;
    if (job == NULL) {
        return ry_no_memory(run->error, (size_t)run->n_cases * sizeof *job);
    }
    for (int k = 0; k < run->n_cases; k++) {
        if (run->cases[k].todo) {
            job[n++] = k;
        }
    }
    sorted_cases = run->cases;
    qsort(job, (size_t)n, sizeof *job, by_work);
    const int cores = run->options->cores > 0 ? run->options->cores : ry_pool_cores();
    const int workers = n < cores ? n : cores;
    ry_config config;
    if (n > 0 && ry_sweep_case_config(run, job[0], &config, NULL) == RY_OK) {
        most_grains = grains_of(&config);
        ry_config_free(&config);
    }
    /* More than one core for a case only where cores would idle, and where it pays. */
    const int pays = workers < cores ? ry_plan_threads(most_grains) : 1;
    run->threads = workers > 0 && cores / workers < pays ? cores / workers : pays;
    run->work_before = run->work_ended;
    run->started = ry_clock();
    const ry_pool pool = {.n_jobs = n,
                          .job = job,
                          .workers = workers,
                          .data = run,
                          .work = run_case,
                          .ended = on_end,
                          .look = look};
    ry_status status = n > 0 && !run->stopping ? ry_pool_run(&pool, run->error) : RY_OK;
    if (run->broken) {
        status = RY_BAD_FILE;
    } else if (status == RY_OK && run->n_ended < run->n_mine) {
        status = RY_STOPPED;
    }
    free(job);
    return status;
}

/* --- the end ------------------------------------------------------------------------------------ */

static void keep_failure(ry_sweep_run *run, int index)
{
    char *const text = ry_sweep_case_text(run, index);
    if (run->result->failure[0] == '\0') {
        snprintf(run->result->failure, sizeof run->result->failure, "case %d (%.150s): %s",
                 index + 1, text != NULL ? text : "", run->cases[index].record.message);
    }
    free(text);
}

/* Counts what is there of all cases, those of other shards included. */
static ry_status count_all(ry_sweep_run *run)
{
    ry_sweep_result *const r = run->result;
    r->cases = run->n_cases;
    r->shard_cases = run->n_mine;
    for (int k = 0; k < run->n_cases; k++) {
        ry_sweep_case *const c = &run->cases[k];
        if (!c->mine) {
            RY_TRY(ry_sweep_store_read(&run->store, k, &c->record, run->error));
        }
        r->missing += !c->record.known;
        r->done += c->record.known && c->record.status == RY_OK;
        r->failed += c->record.known && c->record.status != RY_OK;
    }
    for (int k = 0; k < run->n_cases; k++) {
        const ry_sweep_case *const c = &run->cases[k];
        if ((c->mine || run->options->merge) && c->record.known && c->record.status != RY_OK) {
            keep_failure(run, k);
        }
    }
    return RY_OK;
}

static ry_status finish(ry_sweep_run *run)
{
    RY_TRY(count_all(run));
    if (run->result->missing == 0 || run->options->merge) {
        /* Shards that end together take turns. */
        RY_TRY(ry_sweep_store_lock_table(&run->store, run->error));
        RY_TRY(ry_sweep_table_write(run, run->error));
        run->result->table = 1;
    }
    const int failed = run->options->merge ? run->result->failed : run->n_failed;
    if (failed > 0) {
        return ry_fail(run->error, RY_UNPHYSICAL, "%d of %d cases failed, the others are done; %s",
                       failed, run->options->merge ? run->n_cases : run->n_mine,
                       run->result->failure);
    }
    return RY_OK;
}

static ry_status merge(ry_sweep_run *run, const char *description)
{
    RY_TRY(ry_sweep_store_look(&run->store, description, run->error));
    return finish(run);
}

static ry_status work(ry_sweep_run *run, const char *description)
{
    const ry_sweep_options *const o = run->options;
    const int anew = o->force && o->shards == 0;
    if (!o->force && !o->resume && access(run->store.output, F_OK) == 0) {
        return ry_fail(run->error, RY_BAD_FILE,
                       "%s: exists; --resume goes on with it, --force begins anew",
                       run->store.output);
    }
    RY_TRY(ry_table_file_check(run->store.output, 1, run->error));
    RY_TRY(check_cases(run));
    RY_TRY(ry_sweep_store_open(&run->store, description, o->shard, o->shards, anew, run->error));
    if (anew) {
        unlink(run->store.output); /* its cases are gone */
    }
    RY_TRY(choose(run));
    RY_TRY(run_cases(run));
    return finish(run);
}

/* A key that is varied can't be set by -s as well. */
static ry_status check_overrides(const ry_sweep_run *run)
{
    const ry_sweep_file *const f = &run->file;
    const ry_sweep_options *const o = run->options;
    for (int k = 0; k < o->n_overrides; k++) {
        for (int i = 0; i < f->n_axes; i++) {
            const size_t length = strlen(f->axis[i].path);
            if (strncmp(o->overrides[k], f->axis[i].path, length) == 0 &&
                o->overrides[k][length] == '=') {
                return ry_fail(run->error, RY_BAD_INPUT,
                               "-s %s: the sweep varies this key, in line %d of %s",
                               o->overrides[k], f->axis[i].line, f->path);
            }
        }
    }
    return RY_OK;
}

/* The scene with `set`, -s and, unless it is below 0, the values of a point. */
static ry_status load_scene(ry_sweep_run *run, int point, ry_error *error)
{
    const ry_sweep_file *const f = &run->file;
    const ry_sweep_options *const o = run->options;
    const int n_own = f->n_set + o->n_overrides, n = n_own + (point >= 0 ? f->n_axes : 0);
    const char **const text = calloc((size_t)n + 1, sizeof *text);
    int good = text != NULL;
    for (int k = 0; k < n && good; k++) {
        text[k] = k < f->n_set ? f->set[k]
                  : k < n_own  ? o->overrides[k - f->n_set]
                               : ry_text_print("%s=%s", f->axis[k - n_own].path,
                                               ry_sweep_file_value(f, point, k - n_own));
        good = text[k] != NULL;
    }
    const ry_status status = good ? ry_config_load(&run->base, f->scene, text, n, error)
                                  : ry_no_memory(error, (size_t)n * sizeof *text);
    for (int k = n_own; k < n && text != NULL; k++) {
        free((void *)text[k]);
    }
    free(text);
    return status;
}

/* A scene may need one of the varied values to be accepted at all; then the first point that makes it
 * so stands for the others. */
static ry_status load_base(ry_sweep_run *run)
{
    enum { MOST_TRIES = 1000 };
    ry_error first = {0};
    RY_TRY(check_overrides(run));
    ry_status status = load_scene(run, -1, &first);
    for (int k = 0; k < run->file.n_points && k < MOST_TRIES && status == RY_BAD_INPUT; k++) {
        status = load_scene(run, k, NULL);
    }
    if (status != RY_OK) {
        return ry_fail(run->error, first.status, "%s", first.text);
    }
    if (run->file.replicas > 1 && !run->base.has_grains) {
        return ry_fail(run->error, RY_BAD_INPUT,
                       "%s: replicas: %d of a scene without 'grains:' would all be equal",
                       run->file.path, run->file.replicas);
    }
    return RY_OK;
}

static ry_status sweep(ry_sweep_run *run)
{
    RY_TRY(ry_sweep_file_load(&run->file, run->options->sweep, run->error));
    RY_TRY(load_base(run));
    run->n_cases = run->file.n_points * run->file.replicas;
    run->cases = calloc((size_t)run->n_cases, sizeof *run->cases);
    char *const description = ry_sweep_describe(run);
    ry_status status =
        run->cases == NULL || description == NULL ? ry_no_memory(run->error, 1) : RY_OK;
    if (status == RY_OK) {
        status = ry_sweep_store_init(&run->store, run->options->output, run->n_cases, run->error);
    }
    if (status == RY_OK) {
        status = run->options->merge ? merge(run, description) : work(run, description);
    }
    free(description);
    return status;
}

ry_status ry_sweep(const ry_sweep_options *options, ry_sweep_result *result, ry_error *error)
{
    ry_error own = {0};
    ry_sweep_run run = {.options = options,
                        .result = result,
                        .error = error != NULL ? error : &own,
                        .store = {.lock = -1}};
    *result = (ry_sweep_result){0};
    const double start = ry_clock();
    const ry_status status = sweep(&run);
    result->seconds = ry_clock() - start;
    if (status == RY_STOPPED) {
        count_all(&run);
    }
    ry_sweep_store_close(&run.store);
    ry_sweep_file_free(&run.file);
    ry_config_free(&run.base);
    free(run.cases);
    return status;
}
