/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The cases of a sweep: each in a process of its own, the longest first, on this process's cores and on
 * those of the others of its farm. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/scene.h"
#include "sim/plan.h"
#include "study/sweep_private.h"

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

ry_case_record ry_sweep_cases_refused(const ry_error *error)
{
    const ry_run_result none = {.wall_seconds = 0.0};
    return make_record(error->status, &none, error);
}

/* What is there of the case belongs to this sweep: --force has removed what did not, and without
 * --resume there was nothing. So it always goes on from there; another process may have begun it. */
int ry_sweep_cases_work(void *data, int index, ry_pool_worker *worker)
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
                                        .resume = 1,
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

/* --- what is reported --------------------------------------------------------------------------- */

static double seconds_left(const ry_sweep_run *run, double work_running)
{
    const double now = fmin(run->work_ended + work_running, run->work_all);
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
        .share =
            run->work_all > 0.0 ? fmin((run->work_ended + work_running) / run->work_all, 1.0) : 1.0,
        .seconds_left = seconds_left(run, work_running),
        .news = news};
    if (run->options->progress != NULL && run->options->progress(run->options->data, &p)) {
        run->stopping = 1;
    }
    return run->stopping || run->broken;
}

void ry_sweep_cases_say(ry_sweep_run *run, const char *news)
{
    report(run, 0, 0.0, news);
}

void ry_sweep_cases_count(ry_sweep_run *run, int index, int is_new)
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
        ry_sweep_cases_say(run, news);
    }
    free(text);
    free(news);
}

void ry_sweep_cases_end(ry_sweep_run *run, int index, int exit_code, int killed_by,
                        const ry_case_record *record)
{
    ry_case_record *const r = &run->cases[index].record;
    if (exit_code == RY_STOPPED) {
        return;
    }
    if (killed_by == 0 && exit_code == 0 && record != NULL && record->known) {
        *r = *record;
        ry_sweep_cases_count(run, index, 1);
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
        ry_sweep_cases_count(run, index, 1);
        return;
    }
    /* The next case would find the same disk full. */
    run->broken = 1;
    ry_fail(
        run->error, RY_BAD_FILE,
        "%s: what became of case %d can't be written there (disk full?); what is done is kept, and --resume goes on",
        run->store.folder, index + 1);
}

/* --- the queue ---------------------------------------------------------------------------------- */

/* Long cases first, so that no core waits for one at the end. */
static const ry_sweep_case *sorted_cases; /* qsort has no argument for it */

static int by_work(const void *a, const void *b)
{
    const int i = *(const int *)a, k = *(const int *)b;
    const double difference = sorted_cases[k].work - sorted_cases[i].work;
    return difference > 0.0 ? 1 : difference < 0.0 ? -1 : (i > k) - (i < k);
}

static ry_status make_queue(ry_sweep_run *run)
{
    run->queue = calloc((size_t)run->n_cases, sizeof *run->queue);
    if (run->queue == NULL) {
        return ry_no_memory(run->error, (size_t)run->n_cases * sizeof *run->queue);
    }
    for (int k = 0; k < run->n_cases; k++) {
        if (run->cases[k].todo) {
            run->queue[run->n_queue++] = k;
        }
    }
    sorted_cases = run->cases;
    qsort(run->queue, (size_t)run->n_queue, sizeof *run->queue, by_work);
    return RY_OK;
}

int ry_sweep_cases_take(ry_sweep_run *run)
{
    return run->stopping || run->broken || run->head == run->n_queue ? -1 : run->queue[run->head++];
}

void ry_sweep_cases_put_back(ry_sweep_run *run, int index)
{
    run->queue[--run->head] = index;
}

/* --- the processes of the cases ----------------------------------------------------------------- */

static int next_case(void *data)
{
    ry_sweep_run *const run = data;
    const int index = ry_sweep_cases_take(run);
    if (index >= 0) {
        return index;
    }
    return run->farm != NULL && ry_sweep_farm_count(run, NULL, NULL) > 0 ? RY_POOL_WAIT
                                                                         : RY_POOL_END;
}

static void on_end(void *data, int index, int exit_code, int killed_by)
{
    ry_sweep_run *const run = data;
    ry_case_record record = {0};
    if (exit_code == 0 && killed_by == 0) {
        ry_sweep_store_read(&run->store, index, &record, NULL);
    }
    ry_sweep_cases_end(run, index, exit_code, killed_by, &record);
}

static int look(void *data, int n_running, const int *job, const double *share)
{
    ry_sweep_run *const run = data;
    double work = 0.0;
    for (int k = 0; k < n_running; k++) {
        work += share[k] * run->cases[job[k]].work;
    }
    if (run->farm != NULL) {
        ry_sweep_farm_count(run, &n_running, &work);
    }
    return report(run, n_running, work, NULL);
}

static void turn(void *data)
{
    ry_sweep_run *const run = data;
    if (run->farm != NULL) {
        ry_sweep_farm_turn(run);
    }
}

/* More than one core for a case only where cores would idle, and where it pays. */
static int threads_of_cases(const ry_sweep_run *run, int own_cores, int all_cores)
{
    ry_config config;
    if (run->n_queue == 0 || run->n_queue >= all_cores ||
        ry_sweep_case_config(run, run->queue[0], &config, NULL) != RY_OK) {
        return 1;
    }
    const ry_scene_size size = ry_scene_measure(&config);
    const int pays = ry_plan_threads((int)(size.explicit_grains + size.bed + size.floor));
    const int there = all_cores / run->n_queue;
    ry_config_free(&config);
    const int threads = there < pays ? there : pays;
    return threads < own_cores ? threads : own_cores;
}

static ry_status run_queue(ry_sweep_run *run)
{
    const ry_sweep_options *const o = run->options;
    const ry_farm *const wire = o->farm;
    const int own = o->cores > 0 ? o->cores : wire != NULL ? wire->cores : ry_pool_cores();
    const int all = wire == NULL ? own : o->cores > 0 ? o->cores * wire->size : wire->all_cores;
    run->threads = threads_of_cases(run, own, all);
    run->work_before = run->work_ended;
    run->started = ry_clock();
    const int slots = own / run->threads;
    const ry_pool pool = {.workers = run->n_queue < slots ? run->n_queue : slots,
                          .data = run,
                          .next = next_case,
                          .work = ry_sweep_cases_work,
                          .ended = on_end,
                          .look = look,
                          .turn = turn};
    return run->n_queue > 0 && !run->stopping ? ry_pool_run(&pool, run->error) : RY_OK;
}

ry_status ry_sweep_cases_run(ry_sweep_run *run)
{
    RY_TRY(make_queue(run));
    const ry_status status = run_queue(run);
    if (status == RY_OK && !run->broken && run->n_ended < run->n_mine) {
        return RY_STOPPED;
    }
    return run->broken ? RY_BAD_FILE : status;
}
