/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/threshold.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/relations.h"
#include "analysis/replicas.h"
#include "base/clock.h"
#include "base/link.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/text.h"
#include "io/table_file.h"
#include "sim/sim.h"
#include "study/each.h"
#include "study/pool.h"

enum { MOST_TRIALS = 64, MOST_REPLICAS = 1000 };

#define REPORT_EVERY 0.1 /* seconds of wall time */
/* The push before a trial, and the still fluid after it in which the bed comes to rest. */
#define PUSH_SHIELDS 0.6
#define PUSH_TIME 0.5 /* s */
#define STILL_TIME 0.5

static const char *const start_words[RY_THRESHOLD_STARTS] = {"rest", "motion"};

typedef struct trial {
    double shields, q_star, time; /* mean q* behind the first half of the time it ran */
    int moves;
} trial;

/* One bed from one start. */
typedef struct bed {
    int start, seed;
    double low, high; /* the bracket in the end */
    int n;
    trial trial[MOST_TRIALS];
} bed;

typedef struct search {
    const ry_threshold_options *options;
    char *output; /* options->output, or where it leads to; NULL: none */
    ry_config base;
    bed *beds; /* replicas from rest, then as many from motion */
    int n_beds, most_trials;
    atomic_int trials, stopping;
} search;

ry_threshold_options ry_threshold_options_default(void)
{
    return (ry_threshold_options){
        .replicas = 4, .low = 0.01, .high = 0.4, .tolerance = 0.002, .criterion = 1e-4};
}

/* --- one trial ---------------------------------------------------------------------------------- */

/* Sums of q* over time, as they come in. */
typedef struct watch {
    double begin, half, end; /* of the time that counts: [begin, end] [s] */
    double stretch;          /* a stretch this long decides that the bed rests [s] */
    double criterion;
    double sum, block_sum; /* of q* behind half; of |q*| in this stretch */
    long long n, n_half, block_n;
    double block_begin;
} watch;

enum { UNDECIDED, RESTS, MOVES };

static int watch_sample(watch *w, double time, double interval, double q_star)
{
    if (time < w->begin) {
        w->block_begin = w->begin;
        return UNDECIDED;
    }
    w->block_sum += fabs(q_star);
    w->block_n++;
    if (time >= w->half) {
        w->sum += q_star;
        w->n_half++;
    }
    if (time - w->block_begin >= w->stretch) {
        const int rests = w->block_sum < 0.1 * w->criterion * (double)w->block_n;
        w->block_sum = 0.0;
        w->block_n = 0;
        w->block_begin = time;
        if (rests) {
            return RESTS;
        }
    }
    /* More than can be undone: grains hardly ever move upstream. */
    const double all = (w->end - w->half) / interval;
    return w->sum > 2.0 * w->criterion * all && time - w->half > 0.1 * (w->end - w->half)
               ? MOVES
               : UNDECIDED;
}

/* Tells how far the search is; 1: it is to stop. */
static int report(search *s, int done)
{
#pragma omp critical
    if (s->options->progress != NULL &&
        s->options->progress(s->options->data, done, s->most_trials)) {
        atomic_store(&s->stopping, 1);
    }
    return atomic_load(&s->stopping);
}

/* A run that may be asked to stop, whose clock begins anew with each stress. */
typedef struct course {
    search *search;
    ry_sim *sim;
    const ry_config *config;
    ry_derived derived;
    double reported;
} course;

/* Takes steps up to `duration` [s], and shows q* to the watch (NULL: none) until it decides. */
static ry_status follow(course *c, double duration, watch *w, int *verdict, double *time, ry_error *error)
{
    const double interval = c->derived.steps_series * c->config->time_step;
    *verdict = UNDECIDED;
    *time = 0.0;
    for (long long n = 1; *time < duration - 0.5 * interval && *verdict == UNDECIDED; n++) {
        RY_TRY(ry_sim_step(c->sim, c->derived.steps_series, error));
        *time = (double)n * interval;
        if (w != NULL) {
            *verdict = watch_sample(w, *time, interval, ry_sim_sample(c->sim).q_star);
        }
        if (ry_clock() - c->reported > REPORT_EVERY) {
            c->reported = ry_clock();
            if (report(c->search, atomic_load(&c->search->trials))) {
                return RY_STOPPED;
            }
        }
    }
    return ry_sim_check(c->sim, error); /* the last steps, too */
}

/* The bed as the trial finds it: settled, pushed, and, from rest, at rest again. */
static ry_status make_bed(course *c, int start, double stress_unit, ry_error *error)
{
    int verdict;
    double time;
    const int pushed = start == RY_THRESHOLD_MOTION || !c->search->options->fresh;
    RY_TRY(follow(c, (double)c->derived.steps_settle * c->config->time_step, NULL, &verdict, &time, error));
    if (pushed) {
        ry_sim_set_stress(c->sim, PUSH_SHIELDS * stress_unit);
        RY_TRY(follow(c, PUSH_TIME, NULL, &verdict, &time, error));
    }
    if (pushed && start == RY_THRESHOLD_REST) {
        ry_sim_set_stress(c->sim, 0.0);
        RY_TRY(follow(c, STILL_TIME, NULL, &verdict, &time, error));
    }
    return RY_OK;
}

static ry_status watch_run(search *s, ry_sim *sim, const ry_config *config, int start, trial *out,
                           ry_error *error)
{
    course c = {s, sim, config, ry_config_derive(config), ry_clock()};
    const double stress_unit = (c.derived.density - config->fluid_density) * config->domain_gravity * c.derived.d;
    const double end = (double)(c.derived.steps_end - c.derived.steps_settle) * config->time_step;
    watch w = {.begin = fmin(0.3, 0.2 * end), .end = end, .criterion = s->options->criterion};
    w.half = 0.5 * (w.begin + end);
    w.stretch = fmax(0.5, 0.1 * (end - w.begin));
    int verdict;
    RY_TRY(make_bed(&c, start, stress_unit, error));
    ry_sim_set_stress(sim, out->shields * stress_unit);
    RY_TRY(follow(&c, end, &w, &verdict, &out->time, error));
    out->q_star = w.n_half > 0 ? w.sum / (double)w.n_half : 0.0;
    out->moves = verdict == MOVES || (verdict == UNDECIDED && out->q_star >= s->options->criterion);
    return RY_OK;
}

static ry_status try_shields(search *s, bed *b, double shields, int *moves, ry_error *error)
{
    char seed[40];
    snprintf(seed, sizeof seed, "grains.seed=%d", b->seed);
    const char *const overrides[] = {"fluid.start=rest", seed};
    ry_config config;
    RY_TRY(ry_config_parse(&config, s->base.text, s->base.path, overrides,
                           s->base.has_grains ? 2 : 1, error));
    trial *const t = &b->trial[b->n];
    *t = (trial){.shields = shields};
    ry_sim *const sim = ry_sim_create(&config, 1, error);
    const ry_status status =
        sim != NULL ? watch_run(s, sim, &config, b->start, t, error) : error->status;
    ry_sim_free(sim);
    ry_config_free(&config);
    if (status == RY_OK) {
        *moves = t->moves;
        b->n++;
        const int done = atomic_fetch_add(&s->trials, 1) + 1;
        return report(s, done) ? RY_STOPPED : RY_OK;
    }
    return status;
}

/* --- bisection of one bed ----------------------------------------------------------------------- */

static ry_status bisect(void *data, int index, ry_error *error)
{
    search *const s = data;
    const ry_threshold_options *const o = s->options;
    bed *const b = &s->beds[index];
    int moves = 0;
    b->low = o->low;
    b->high = o->high;
    RY_TRY(try_shields(s, b, b->high, &moves, error));
    if (!moves) {
        return ry_fail(
            error, RY_BAD_INPUT,
            "from %s, grains.seed=%d: the bed rests at Shields number %g (q* %.3g, below %g); raise --high, "
            "or time.end",
            start_words[b->start], b->seed, b->high, b->trial[0].q_star, o->criterion);
    }
    RY_TRY(try_shields(s, b, b->low, &moves, error));
    if (moves) {
        return ry_fail(
            error, RY_BAD_INPUT,
            "from %s, grains.seed=%d: the bed moves at Shields number %g already (q* %.3g); lower --low",
            start_words[b->start], b->seed, b->low, b->trial[1].q_star);
    }
    while (b->high - b->low > o->tolerance * 1.000001 && b->n < MOST_TRIALS) {
        const double middle = 0.5 * (b->low + b->high);
        RY_TRY(try_shields(s, b, middle, &moves, error));
        *(moves ? &b->high : &b->low) = middle;
    }
    return RY_OK;
}

/* --- what comes out ----------------------------------------------------------------------------- */

static double middle_of(const bed *b)
{
    return 0.5 * (b->low + b->high);
}

/* Mean of n values and its errors; what lies within a bracket is not known, and may be the same for
 * all, so width^2/12 does not shrink with n. */
static ry_threshold_side average(int n, const double *value, double width)
{
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < n; k++) {
        sum += value[k];
    }
    const double mean = sum / n;
    for (int k = 0; k < n; k++) {
        squares += (value[k] - mean) * (value[k] - mean);
    }
    const double error = n > 1 ? sqrt(squares / (n * (n - 1.0)) + width * width / 12.0) : NAN;
    const double far = ry_student(0.95, n - 1.0) * error;
    return (ry_threshold_side){mean, error, mean - far, mean + far};
}

static void summarize(const search *s, ry_threshold_result *r)
{
    const int n = s->options->replicas;
    const double width = s->beds[0].high - s->beds[0].low;
    double value[RY_THRESHOLD_STARTS][MOST_REPLICAS], difference[MOST_REPLICAS];
    for (int k = 0; k < n; k++) {
        value[RY_THRESHOLD_REST][k] = middle_of(&s->beds[k]);
        value[RY_THRESHOLD_MOTION][k] = middle_of(&s->beds[n + k]);
        difference[k] = value[RY_THRESHOLD_REST][k] - value[RY_THRESHOLD_MOTION][k];
    }
    for (int start = 0; start < RY_THRESHOLD_STARTS; start++) {
        ry_threshold_side *const side = &r->side[start];
        *side = average(n, value[start], width);
        side->low = side->low < 0.0 ? 0.0 : side->low; /* not fmax, which would hide a NAN */
    }
    r->difference = average(n, difference, width * 1.41421356);
    const ry_derived q = ry_config_derive(&s->base);
    r->d_star = ry_relation_d_star(q.d, q.density / s->base.fluid_density, s->base.domain_gravity,
                                   s->base.fluid_viscosity);
    r->n_literature = ry_threshold_count() < 8 ? ry_threshold_count() : 8;
    for (int k = 0; k < r->n_literature; k++) {
        r->literature[k] = ry_threshold_at(k)->theta_c(r->d_star);
        r->literature_name[k] = ry_threshold_at(k)->key;
    }
    r->trials = s->trials;
}

/* The columns of /trials. */
typedef struct columns {
    double *seed, *shields, *q_star, *time, *moves;
    const char **start;
} columns;

static void write_trials(const search *s, ry_table_file *f, const columns *t)
{
    int n = 0;
    for (int k = 0; k < s->n_beds; k++) {
        for (int i = 0; i < s->beds[k].n; i++, n++) {
            const trial *const one = &s->beds[k].trial[i];
            t->start[n] = start_words[s->beds[k].start];
            t->seed[n] = s->beds[k].seed;
            t->shields[n] = one->shields;
            t->q_star[n] = one->q_star;
            t->time[n] = one->time;
            t->moves[n] = one->moves;
        }
    }
    ry_table_file_texts(f, "trials/start", "from rest or from motion", n, t->start);
    ry_table_file_numbers(f, "trials/seed", "1", "grains.seed", n, t->seed);
    ry_table_file_numbers(f, "trials/shields", "1", "Shields number", n, t->shields);
    ry_table_file_numbers(f, "trials/q_star", "1", "mean over the second half of the time it ran",
                          n, t->q_star);
    ry_table_file_numbers(f, "trials/time", "s", "of this stress, when it was decided", n, t->time);
    ry_table_file_numbers(f, "trials/moves", "1", "1: the bed moves", n, t->moves);
}

static void write_side(const search *s, const ry_threshold_result *r, int start, ry_table_file *f,
                       const columns *t)
{
    const int n = s->options->replicas;
    const ry_threshold_side *const side = &r->side[start];
    const bed *const beds = &s->beds[start * n];
    char path[40];
    for (int k = 0; k < n; k++) {
        t->seed[k] = beds[k].seed;
        t->shields[k] = middle_of(&beds[k]);
        t->q_star[k] = beds[k].low;
        t->time[k] = beds[k].high;
    }
    const struct {
        const char *name, *text;
        const double *value;
    } column[] = {{"seed", "grains.seed", t->seed},
                  {"threshold", "middle of the bracket", t->shields},
                  {"low", "rests", t->q_star},
                  {"high", "moves", t->time}};
    for (int c = 0; c < 4; c++) {
        snprintf(path, sizeof path, "%s/%s", start_words[start], column[c].name);
        ry_table_file_numbers(f, path, "1", column[c].text, n, column[c].value);
    }
    ry_table_file_set_number(f, start_words[start], "mean", side->mean);
    ry_table_file_set_number(f, start_words[start], "standard_error", side->standard_error);
    ry_table_file_set_number(f, start_words[start], "confidence_95_low", side->low);
    ry_table_file_set_number(f, start_words[start], "confidence_95_high", side->high);
}

static ry_status write_file(const search *s, const ry_threshold_result *r, ry_error *error)
{
    const size_t n = (size_t)s->n_beds * MOST_TRIALS;
    const columns t = {calloc(n, sizeof(double)), calloc(n, sizeof(double)),
                       calloc(n, sizeof(double)), calloc(n, sizeof(double)),
                       calloc(n, sizeof(double)), calloc(n, sizeof(char *))};
    ry_table_file *f = NULL;
    ry_status status = t.seed && t.shields && t.q_star && t.time && t.moves && t.start
                           ? ry_table_file_create(&f, s->output, "ryusa threshold",
                                                  s->options->force, error)
                           : ry_no_memory(error, n);
    if (status == RY_OK) {
        const char *const scene = s->base.text;
        ry_table_file_texts(f, "scene_text", "the scene", 1, &scene);
        ry_table_file_set_number(f, "/", "criterion", s->options->criterion);
        ry_table_file_set_number(f, "/", "tolerance", s->options->tolerance);
        ry_table_file_set_number(f, "/", "fresh", s->options->fresh);
        ry_table_file_set_number(f, "/", "d_star", r->d_star);
        for (int start = 0; start < RY_THRESHOLD_STARTS; start++) {
            write_side(s, r, start, f, &t);
        }
        write_trials(s, f, &t);
        for (int k = 0; k < r->n_literature; k++) {
            ry_table_file_set_number(f, "literature", r->literature_name[k], r->literature[k]);
        }
        status = ry_table_file_finish(f, error);
    }
    free(t.seed);
    free(t.shields);
    free(t.q_star);
    free(t.time);
    free(t.moves);
    free((void *)t.start);
    return status;
}

/* --- all ---------------------------------------------------------------------------------------- */

static ry_status check_options(const ry_threshold_options *o, ry_error *error)
{
    if (!(o->low >= 0.0 && o->high > o->low && o->high <= 100.0)) {
        return ry_fail(error, RY_BAD_INPUT, "--low %g --high %g: 0 <= low < high <= 100 is allowed",
                       o->low, o->high);
    }
    if (!(o->tolerance >= 1e-6 && o->tolerance < o->high - o->low)) {
        return ry_fail(error, RY_BAD_INPUT,
                       "--tolerance %g: 1e-6 to below high - low, %g, is allowed", o->tolerance,
                       o->high - o->low);
    }
    if (!(o->criterion > 0.0 && o->criterion <= 1.0)) {
        return ry_fail(error, RY_BAD_INPUT, "--criterion %g: q* above 0, at most 1, is allowed",
                       o->criterion);
    }
    if (o->replicas < 1 || o->replicas > MOST_REPLICAS) {
        return ry_fail(error, RY_BAD_INPUT, "--replicas %d: 1 to %d is allowed", o->replicas,
                       MOST_REPLICAS);
    }
    return RY_OK;
}

static ry_status check_scene(const search *s, ry_error *error)
{
    const ry_config *const c = &s->base;
    if (c->fluid_model == RY_FLUID_NONE) {
        return ry_fail(error, RY_BAD_INPUT,
                       "%s: fluid.model: none moves no grain; allowed are stress, log and balance",
                       c->path);
    }
    if (!(ry_config_derive(c).flux_unit > 0.0) || !(ry_config_derive(c).length > 0.0)) {
        return ry_fail(error, RY_BAD_INPUT,
                       "%s: q* is not defined here; it needs gravity, grains denser than the fluid "
                       "and a domain.length",
                       c->path);
    }
    if (c->time_end - c->time_settle < 1.0) {
        return ry_fail(
            error, RY_BAD_INPUT,
            "%s: time.end: %g s with the fluid on is too short to tell rest from motion; allowed is at least 1 s "
            "after time.settle",
            c->path, c->time_end - c->time_settle);
    }
    if (s->options->replicas > 1 && !c->has_grains) {
        return ry_fail(error, RY_BAD_INPUT,
                       "--replicas %d: without 'grains:' in the scene all would be equal; give 1",
                       s->options->replicas);
    }
    return RY_OK;
}

static ry_status find(search *s, ry_threshold_result *result, ry_error *error)
{
    const ry_threshold_options *const o = s->options;
    RY_TRY(check_options(o, error));
    RY_TRY(ry_config_load(&s->base, o->scene, o->overrides, o->n_overrides, error));
    RY_TRY(check_scene(s, error));
    if (o->output != NULL) {
        RY_TRY(ry_link_follow(o->output, &s->output, error));
        RY_TRY(ry_table_file_check(s->output, o->force, error));
    }
    s->n_beds = RY_THRESHOLD_STARTS * o->replicas;
    s->beds = calloc((size_t)s->n_beds, sizeof *s->beds);
    if (s->beds == NULL) {
        return ry_no_memory(error, (size_t)s->n_beds * sizeof *s->beds);
    }
    for (int k = 0; k < s->n_beds; k++) {
        s->beds[k].start = k / o->replicas;
        s->beds[k].seed = ry_random_replica(s->base.grains_seed, k % o->replicas);
    }
    const double halvings = ceil(log2((o->high - o->low) / (o->tolerance * 1.000001)));
    s->most_trials = s->n_beds * (2 + (halvings > 0.0 ? (int)halvings : 0));
    RY_TRY(ry_each(s->n_beds, o->cores > 0 ? o->cores : ry_pool_cores(), bisect, s, error));
    summarize(s, result);
    return o->output != NULL ? write_file(s, result, error) : RY_OK;
}

ry_status ry_threshold_find_motion(const ry_threshold_options *options, ry_threshold_result *result,
                                   ry_error *error)
{
    ry_error own = {0};
    search s = {.options = options};
    const double start = ry_clock();
    *result = (ry_threshold_result){0};
    const ry_status status = find(&s, result, error != NULL ? error : &own);
    result->seconds = ry_clock() - start;
    ry_config_free(&s.base);
    free(s.beds);
    free(s.output);
    return status;
}
