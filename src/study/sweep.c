/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A sweep from its file to its table. A case is one ry_run in a process of its own, which leaves
 * case-0001.h5 and the record of how it ended. Whatever happens to this process or to the machine, the
 * records and the files tell what is still to be done. */
#include "study/sweep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/text.h"
#include "config/keys.h"
#include "io/table_file.h"
#include "scene/scene.h"
#include "study/sweep_private.h"

static double work_of(const ry_config *config)
{
    const ry_scene_size size = ry_scene_measure(config);
    return (double)(size.explicit_grains + size.bed + size.floor) *
           (double)ry_config_derive(config).steps_end;
}

/* 1: the user asks to stop. */
static int look(const ry_sweep_run *run, int checked, double *looked)
{
    static const double EVERY = 0.1;
    const ry_sweep_options *const o = run->options;
    const ry_sweep_progress p = {.cases = run->n_cases, .checked = checked};
    if (o->progress == NULL || ry_clock() - *looked < EVERY) {
        return 0;
    }
    *looked = ry_clock();
    return o->progress(o->data, &p);
}

/* Before anything is made: which cases are refused. All of them: the sweep is wrong. */
static ry_status check_cases(ry_sweep_run *run)
{
    ry_error first = {0};
    int refused = 0;
    double looked = ry_clock();
    for (int k = 0; k < run->n_cases; k++) {
        if (look(run, k, &looked)) {
            return RY_STOPPED;
        }
        ry_error error = {0};
        ry_config config;
        ry_sweep_case *const c = &run->cases[k];
        if (ry_sweep_case_config(run, k, &config, &error) == RY_OK) {
            c->work = work_of(&config);
            ry_config_free(&config);
            continue;
        }
        c->record = ry_sweep_cases_refused(&error);
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
            ry_sweep_cases_count(run, k, 1);
            continue;
        }
        RY_TRY(ry_sweep_store_read(&run->store, k, &c->record, run->error));
        c->todo = !is_ended(run, k, &c->record);
        if (!c->todo) {
            ry_sweep_cases_count(run, k, 0);
        }
    }
    return RY_OK;
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

/* 1: what is at OUT.h5 was made by something else. */
static int is_foreign(const ry_sweep_run *run)
{
    const char *const output = run->store.output;
    return !run->options->force && access(output, F_OK) == 0 && !ry_table_file_is(output, RY_SWEEP_PROGRAM);
}

static ry_status finish(ry_sweep_run *run, const char *description)
{
    RY_TRY(count_all(run));
    if (run->result->missing == 0 || run->options->merge) {
        /* Shards that end together take turns; without locks the folder may be another's by now. */
        RY_TRY(ry_sweep_store_lock_table(&run->store, run->error));
        RY_TRY(ry_sweep_store_look(&run->store, description, run->error));
        if (is_foreign(run)) {
            return ry_fail(run->error, RY_BAD_FILE,
                           "%s: not the result of a sweep; move it away, or --merge --force replaces it (what is in %s "
                           "stays)",
                           run->store.output, run->store.folder);
        }
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
    return finish(run, description);
}

static ry_status work(ry_sweep_run *run, const char *description)
{
    const ry_sweep_options *const o = run->options;
    const int anew = o->force && o->shards == 0;
    const int exists = access(run->store.output, F_OK) == 0;
    if (!o->force && !o->resume && exists) {
        return ry_fail(run->error, RY_BAD_FILE,
                       "%s: exists; --resume goes on with it, --force begins anew",
                       run->store.output);
    }
    RY_TRY(ry_table_file_check(run->store.output, 1, run->error));
    if (is_foreign(run)) {
        return ry_fail(run->error, RY_BAD_FILE, "%s: not the result of a sweep; give another -o, or --force replaces it",
                       run->store.output);
    }
    RY_TRY(check_cases(run));
    RY_TRY(ry_sweep_store_open(&run->store, description, o->shard, o->shards, anew, run->error));
    if (anew) {
        unlink(run->store.output); /* its cases are gone */
    }
    RY_TRY(choose(run));
    RY_TRY(ry_sweep_cases_run(run));
    return finish(run, description);
}

/* A key that is varied, or one that it replaces, can't be set by -s as well. */
static ry_status check_overrides(const ry_sweep_run *run)
{
    const ry_sweep_file *const f = &run->file;
    const ry_sweep_options *const o = run->options;
    for (int k = 0; k < o->n_overrides; k++) {
        const int key = ry_keys_find_path(o->overrides[k]);
        for (int i = 0; i < f->n_axes && key >= 0; i++) {
            if (key == f->axis[i].key || key == ry_keys_rival(f->axis[i].key)) {
                return ry_fail(run->error, RY_BAD_INPUT, "-s %s: the sweep varies %s, in line %d of %s",
                               o->overrides[k], key == f->axis[i].key ? "this key" : f->axis[i].path,
                               f->axis[i].line, f->path);
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

static ry_status load(ry_sweep_run *run, char **description)
{
    RY_TRY(ry_sweep_file_load(&run->file, run->options->sweep, run->error));
    RY_TRY(load_base(run));
    run->n_cases = run->file.n_points * run->file.replicas;
    run->cases = calloc((size_t)run->n_cases, sizeof *run->cases);
    *description = ry_sweep_describe(run);
    if (run->cases == NULL || *description == NULL) {
        return ry_no_memory(run->error, (size_t)run->n_cases * sizeof *run->cases);
    }
    return ry_sweep_store_init(&run->store, run->options->output, run->n_cases, run->error);
}

static ry_status sweep(ry_sweep_run *run)
{
    const ry_farm *const wire = run->options->farm;
    char *description = NULL;
    ry_status status = load(run, &description);
    if (wire != NULL && wire->rank > 0) {
        status = ry_sweep_farm_work(run, description, status);
        free(description);
        return status;
    }
    if (wire != NULL) {
        run->farm = ry_sweep_farm_create(wire, run->n_cases);
        if (run->farm == NULL && status == RY_OK) {
            status = ry_no_memory(run->error, (size_t)run->n_cases * sizeof(int));
        }
    }
    if (status == RY_OK) {
        status = run->options->merge ? merge(run, description) : work(run, description);
    }
    if (run->farm != NULL) {
        ry_sweep_farm_dismiss(run);
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
    if (status == RY_STOPPED && run.n_mine > 0) {
        count_all(&run);
    }
    ry_sweep_store_close(&run.store);
    ry_sweep_file_free(&run.file);
    ry_config_free(&run.base);
    ry_sweep_farm_free(run.farm);
    free(run.queue);
    free(run.cases);
    return status;
}
