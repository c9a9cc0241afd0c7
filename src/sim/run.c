/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A whole run: steps, series, profiles, frames, checkpoints, and the statistics of the flux. What is
 * due at a step depends on the step alone, never on the clock; only writing to disk does. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/statistics.h"
#include "base/clock.h"
#include "base/link.h"
#include "base/memory.h"
#include "io/result.h"
#include "sim/sim.h"

/* Seconds of wall time between looks at the clock by progress, and between flushes. */
#define PROGRESS_EVERY 0.1
#define FLUSH_EVERY 2.0
/* Looks at stop.flux_error are so many frames apart at least, and a fifth of the time: each is another chance to end
 * the run by an error that is too small, and the spectrum of a long series is not free. */
enum { FRAMES_PER_LOOK = 10, FEWEST_SAMPLES = 16 };

typedef struct ry_runner {
    ry_sim *sim;
    ry_result *file;
    const ry_run_options *options;
    char *output; /* options->output, or where it leads to; NULL: none */
    ry_run_result *result;
    int64_t first, last; /* step at the start of this call, step to end at */
    double started, shown, flushed, saved; /* wall clock [s] */
    char doubt[150]; /* what is to be said of the last summary's q*; "": nothing */
    int stop_asked;
} ry_runner;

/* ---- statistics ------------------------------------------------------------------------------ */

/* The step at which the start from motion is over, of a run that has one. */
static int64_t end_of_start(const ry_plan *plan)
{
    const int boosted = plan->has_fluid && plan->flow.tau_start > plan->flow.tau;
    return boosted ? plan->flow.step_boost : plan->derived.steps_settle;
}

/* Samples before this one belong to settling and to the start from motion. Of a run that ends soon after that, those
 * from the start of the fluid on are taken; before it there is no flux to be known. */
static int64_t first_honest_sample(const ry_runner *r, int64_t n)
{
    const ry_plan *const plan = &r->sim->plan;
    const int every = plan->derived.steps_series;
    const int64_t start = (plan->derived.steps_settle + every - 1) / every;
    const int64_t honest = (end_of_start(plan) + every - 1) / every;
    const int64_t first = n - honest >= FEWEST_SAMPLES ? honest : start;
    return plan->has_fluid || n - first >= FEWEST_SAMPLES ? first : 0;
}

/* Of a run that has broken down those that its last good state has behind it, and none that are no numbers: a check
 * may be due only later. */
static int64_t count_sound(const ry_runner *r, const double *series, int64_t n)
{
    const int64_t good = r->sim->state.step / r->sim->plan.derived.steps_series + 1;
    n = r->sim->restored && good < n ? good : n;
    while (n > 0 && !isfinite(series[n - 1])) {
        n--;
    }
    return n;
}

/* Behind the push of a start from motion the flow is faster than it will be, without one it begins at
 * rest; a run that ended within the push has neither. */
static int64_t first_under_way(const ry_runner *r, const double *series, int64_t first, int64_t n)
{
    const ry_plan *const plan = &r->sim->plan;
    const int flows = plan->has_fluid && first * plan->derived.steps_series >= end_of_start(plan);
    return flows ? first + ry_series_under_way(series + first, n - first) : first;
}

static ry_status flux_statistics(ry_runner *r, ry_series_statistics *out, ry_error *error)
{
    int64_t n = 0;
    const double *const series = ry_result_flux_series(r->file, &n);
    n = count_sound(r, series, n);
    const int64_t cut = first_under_way(r, series, first_honest_sample(r, n), n);
    *out = (ry_series_statistics){0};
    if (n - cut < 2) { /* the first is that of the start */
        return RY_OK;
    }
    RY_TRY(ry_series_equilibrated(series + cut, n - cut, out, error));
    out->first += cut;
    return RY_OK;
}

#define CUT "those before the cut that leaves the most effectively independent samples (Chodera 2016)"
static const char under_way[] = "samples before the flow is under way are left out, then " CUT;
static const char at_the_start[] =
    "the run ended with the start (fluid.start: motion), at a higher stress than asked for, or soon after; samples before "
    "the fluid starts are left out, then " CUT;

static ry_cost cost_of(const ry_runner *r)
{
    const ry_plan *const plan = &r->sim->plan;
    const double steps = (double)(r->sim->state.step - r->first);
    const double loop = r->result->wall_seconds; /* known when it is over */
    ry_cost cost = {.wall_seconds = loop > 0.0 ? loop : ry_clock() - r->started, .rebuilds = plan->neighbor.rebuilds,
                    .threads = plan->threads, .n_stages = plan->n_stages};
    cost.asleep = plan->has_sleep ? plan->sleep.slept / fmax((double)plan->sleep.steps, 1.0) : NAN;
    cost.grain_steps_per_second = steps * r->sim->state.grains.n / fmax(cost.wall_seconds, 1e-9);
    for (int s = 0; s < plan->n_stages; s++) {
        cost.stage_name[s] = plan->stage[s].name;
        cost.stage_seconds[s] = plan->stage[s].seconds * steps / fmax((double)r->sim->timed, 1.0);
    }
    return cost;
}

/* A flow of fewer times sqrt(d/g) has not shown how slowly a bed changes. */
#define FEW_TIMES 100.0

static void doubt(ry_runner *r, const ry_series_statistics *flux, int early)
{
    const ry_plan *const plan = &r->sim->plan;
    const double dt = r->sim->config.time_step, seconds = (double)(flux->samples * plan->derived.steps_series) * dt;
    const double times = seconds * sqrt(plan->derived.buoyant_gravity / plan->derived.d);
    r->doubt[0] = '\0';
    if (!plan->has_fluid || flux->samples == 0) {
        return;
    }
    if (early) {
        snprintf(r->doubt, sizeof r->doubt,
                 "q* is of the start from motion, at a higher stress (fluid.start), which ends at t = %.4g s",
                 (double)end_of_start(plan) * dt);
    } else if (flux->effective_samples < RY_SERIES_ENOUGH) {
        snprintf(r->doubt, sizeof r->doubt,
                 "q* is as good as %.2g independent samples; with fewer than %g its error is itself uncertain",
                 flux->effective_samples, RY_SERIES_ENOUGH);
    } else if (times < FEW_TIMES && flux->mean > 0.0) {
        snprintf(r->doubt, sizeof r->doubt, "q* is of %.2g s; beds change more slowly, which its error does not know",
                 seconds);
    }
}

/* It goes into the file with the next flush. */
static ry_status take_summary(ry_runner *r, ry_error *error)
{
    const ry_derived *const q = &r->sim->plan.derived;
    const double dt = r->sim->config.time_step;
    ry_series_statistics flux;
    RY_TRY(flux_statistics(r, &flux, error));
    const double equilibration = (double)flux.first * q->steps_series * dt;
    const int early = flux.samples > 0 && flux.first * q->steps_series < end_of_start(&r->sim->plan);
    doubt(r, &flux, early);
    const int known = flux.samples > 0;
    ry_summary summary = {.q_star_mean = known ? flux.mean : NAN,
                          .q_star_standard_error = known ? flux.standard_error : NAN,
                          .autocorrelation_time = flux.autocorrelation_time * q->steps_series * dt,
                          .equilibration_time = equilibration, .samples = flux.samples,
                          .effective_samples = known ? flux.effective_samples : 0.0,
                          .shields = q->shields, .shear_stress = q->shear_stress, .width = q->d,
                          .equilibration_method = early ? at_the_start : under_way,
                          .stopped_early = r->result->stopped_early, .is_dry = !r->sim->plan.has_fluid};
    if (r->sim->plan.has_profile && (r->sim->config.output_fields & RY_FIELD_PROFILE)) {
        summary.has_profile = 1;
        summary.profile_from = equilibration;
    }
    r->result->q_star = summary.q_star_mean;
    r->result->q_star_error = summary.q_star_standard_error;
    r->result->autocorrelation_time = summary.autocorrelation_time;
    r->result->equilibration = equilibration;
    r->result->samples = summary.samples;
    const ry_cost cost = cost_of(r);
    ry_result_summary(r->file, &summary, &cost);
    return RY_OK;
}

/* ---- what is due at a step ------------------------------------------------------------------- */

static ry_status take_profile(ry_runner *r, ry_error *error)
{
    ry_measure *const m = &r->sim->plan.measure;
    if (m->samples == 0) {
        return RY_OK;
    }
    const double per = 1.0 / (double)m->samples;
    for (int32_t k = 0; k < m->nz; k++) {
        m->transport[k] = m->moving[k] > 0.0 ? m->transport[k] / m->moving[k] : 0.0;
        m->phi[k] *= per;
        m->u_fluid[k] *= per;
        m->tau_fluid[k] *= per;
        m->tau_grain[k] *= per;
    }
    const ry_profile profile = {.nz = m->nz, .dz = m->dz, .phi = m->phi, .u_grain = m->transport,
                                .u_fluid = m->u_fluid, .tau_fluid = m->tau_fluid, .tau_grain = m->tau_grain};
    const ry_status status = ry_result_profile(r->file, &r->sim->state, &profile, error);
    ry_measure_clear(m);
    return status;
}

static int is_due(int64_t step, int every)
{
    return step % every == 0;
}

static ry_status take_measures(ry_runner *r, ry_error *error)
{
    ry_sim *const sim = r->sim;
    const ry_derived *const q = &sim->plan.derived;
    const unsigned fields = sim->config.output_fields;
    const int64_t step = sim->state.step;
    if (r->file == NULL) {
        return RY_OK;
    }
    if (is_due(step, q->steps_series)) {
        const ry_sample sample = ry_sim_sample_of(sim, (fields & RY_FIELD_ENERGY) != 0);
        RY_TRY(ry_result_sample(r->file, &sim->state, &sample, error));
        if ((fields & RY_FIELD_PROFILE) && step > 0) {
            ry_sim_profile(sim);
        }
    }
    if (is_due(step, q->steps_frame)) {
        RY_TRY(ry_result_frame(r->file, &sim->state, error));
        if (fields & RY_FIELD_PROFILE) {
            RY_TRY(take_profile(r, error));
        }
    }
    return RY_OK;
}

/* The first is due when stop.after is over. By step, so that a run ends at the same step always. */
static int is_look(const ry_sim *sim)
{
    const int64_t every = (int64_t)sim->plan.derived.steps_frame * FRAMES_PER_LOOK, now = sim->state.step / every;
    int64_t look = (int64_t)ceil(sim->config.stop_after / sim->config.time_step / (double)every);
    while (look < now) {
        look += look / 5 + 1;
    }
    return sim->state.step % every == 0 && look == now;
}

/* The flux is known well enough. */
static ry_status look_at_flux(ry_runner *r, int *enough, ry_error *error)
{
    const ry_sim *const sim = r->sim;
    const ry_config *const c = &sim->config;
    *enough = 0;
    if (r->file == NULL || isnan(c->stop_flux_error) || sim->state.time < c->stop_after || !is_look(sim)) {
        return RY_OK;
    }
    ry_series_statistics flux;
    RY_TRY(flux_statistics(r, &flux, error));
    *enough = flux.samples >= FEWEST_SAMPLES && flux.effective_samples >= RY_SERIES_ENOUGH && flux.mean > 0.0 &&
              flux.standard_error < c->stop_flux_error * flux.mean;
    return RY_OK;
}

static int has_profile(const ry_runner *r)
{
    return r->sim->plan.has_profile && (r->sim->config.output_fields & RY_FIELD_PROFILE) != 0;
}

/* The state, and the sums of a profile that isn't finished. */
static ry_status take_checkpoint(ry_runner *r, ry_error *error)
{
    const ry_measure *const m = &r->sim->plan.measure;
    const int64_t n = has_profile(r) ? ry_measure_saved(m) : 0;
    RY_TRY(ry_sim_collect(r->sim, error));
    double *const window = ry_array((size_t)n, sizeof *window);
    if (window == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *window);
    }
    if (n > 0) {
        ry_measure_save(m, r->sim->plan.pairs.place, window);
    }
    const ry_status status = ry_result_put_window(r->file, window, n, error);
    free(window);
    return status;
}

static ry_status flush(ry_runner *r, int with_checkpoint, ry_error *error)
{
    if (with_checkpoint) {
        RY_TRY(take_checkpoint(r, error));
        r->saved = ry_clock();
    }
    RY_TRY(take_summary(r, error));
    RY_TRY(ry_result_flush(r->file, with_checkpoint ? &r->sim->state : NULL, error));
    if (!r->sim->restored) { /* the list has them */
        ry_contacts_free(&r->sim->state.contacts);
    }
    r->flushed = ry_clock();
    return RY_OK;
}

static ry_status flush_when_due(ry_runner *r, ry_error *error)
{
    const double now = ry_clock();
    if (r->file == NULL || !is_due(r->sim->state.step, r->sim->plan.derived.steps_frame)) {
        return RY_OK;
    }
    if (now - r->saved >= r->sim->config.output_checkpoint && ry_sim_is_sound(r->sim)) {
        return flush(r, 1, error);
    }
    /* A checkpoint is worth waiting for a slow disk, the rest has time. */
    return now - r->flushed >= FLUSH_EVERY && !ry_result_is_busy(r->file) ? flush(r, 0, error) : RY_OK;
}

static void show_progress(ry_runner *r)
{
    const double now = ry_clock();
    if (r->options->progress == NULL || now - r->shown < PROGRESS_EVERY) {
        return;
    }
    const double rate = (double)(r->sim->state.step - r->first) / fmax(now - r->started, 1e-9);
    r->shown = now;
    r->stop_asked = r->stop_asked ||
                    r->options->progress(r->options->data, r->sim->state.step, r->last, rate) != 0;
}

/* ---- the loop -------------------------------------------------------------------------------- */

static int64_t next_due(const ry_runner *r)
{
    const int64_t step = r->sim->state.step;
    const int every = r->sim->plan.derived.steps_series;
    const int64_t due = (step / every + 1) * every;
    return due < r->last ? due : r->last;
}

/* Somebody has asked for it, and the state is one to go on from; else soon, or its next check says what is wrong. */
static int may_stop(const ry_runner *r)
{
    return r->stop_asked && ry_sim_is_sound(r->sim);
}

/* To the next sample, looking at the clock on the way: a step of a million grains takes its time. */
static ry_status advance(ry_runner *r, ry_error *error)
{
    const int64_t due = next_due(r);
    const int64_t chunk = 2000000 / r->sim->state.grains.n + 1;
    while (r->sim->state.step < due && !may_stop(r)) {
        const int64_t left = due - r->sim->state.step;
        RY_TRY(ry_sim_step(r->sim, left < chunk ? left : chunk, error));
        show_progress(r);
    }
    return RY_OK;
}

static ry_status loop(ry_runner *r, ry_error *error)
{
    int enough = 0;
    RY_TRY(look_at_flux(r, &enough, error)); /* as the run did that ended here, if it is taken up again */
    while (!enough && r->sim->state.step < r->last) {
        RY_TRY(advance(r, error));
        RY_TRY(take_measures(r, error));
        RY_TRY(look_at_flux(r, &enough, error));
        if (!enough && may_stop(r)) {
            return r->sim->state.step < r->last ? RY_STOPPED : RY_OK;
        }
        RY_TRY(enough ? RY_OK : flush_when_due(r, error));
    }
    r->result->stopped_early = enough;
    return RY_OK;
}

/* ---- beginning and end ----------------------------------------------------------------------- */

/* The run was finished already: what it had found. */
static ry_status recall(ry_run_result *result, const char *path, ry_error *error)
{
    ry_summary summary;
    RY_TRY(ry_result_read_summary(path, &summary, &result->hash, error));
    result->q_star = summary.q_star_mean;
    result->q_star_error = summary.q_star_standard_error;
    result->autocorrelation_time = summary.autocorrelation_time;
    result->equilibration = summary.equilibration_time;
    result->samples = summary.samples;
    result->stopped_early = summary.stopped_early;
    snprintf(result->note, sizeof result->note, "%s was finished already", path);
    return RY_OK;
}

/* Goes on with the profile that wasn't finished when the state was saved. */
static ry_status take_up_profile(ry_runner *r, ry_error *error)
{
    int64_t n = 0;
    const double *const window = ry_result_get_window(r->file, &n);
    if (n > 0 && has_profile(r) &&
        ry_measure_load(&r->sim->plan.measure, r->sim->plan.pairs.place, window, n) != 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: damaged: the sums of its profile are of another scene",
                       r->output);
    }
    return RY_OK;
}

static ry_status open_run(ry_runner *r, const ry_config *config, int *finished, ry_error *error)
{
    const ry_run_options *const o = r->options;
    ry_state state = {0};
    int found = 0;
    *finished = 0;
    if (o->output != NULL) {
        RY_TRY(ry_link_follow(o->output, &r->output, error));
    }
    if (o->output != NULL && o->resume) {
        RY_TRY(ry_result_resume(&r->file, r->output, config, &state, &found, error));
    }
    if (found == 2) {
        *finished = 1;
        return recall(r->result, r->output, error);
    }
    if (found == 1) {
        r->sim = ry_sim_adopt(config, &state, o->threads, error);
        if (r->sim == NULL) {
            return error->status;
        }
        return take_up_profile(r, error);
    }
    if (o->resume) {
        snprintf(r->result->note, sizeof r->result->note,
                 "there was no checkpoint to go on from: the run was started anew");
    }
    r->sim = ry_sim_create(config, o->threads, error);
    if (r->sim == NULL) {
        return error->status;
    }
    if (o->output != NULL) {
        RY_TRY(ry_result_create(&r->file, r->output, config, &r->sim->state, o->force || o->resume, error));
    }
    return take_measures(r, error);
}

/* Leaves the file so that the run can go on: after Ctrl-C, and with the last good state after a
 * failure of the physics. */
static ry_status leave(ry_runner *r, ry_status status, ry_error *error)
{
    if (r->file != NULL) {
        if (status == RY_STOPPED || status == RY_UNPHYSICAL) {
            ry_error later = {0};
            if (status == RY_UNPHYSICAL && has_profile(r)) {
                ry_measure_clear(&r->sim->plan.measure); /* the good state is older than these sums */
            }
            if (flush(r, status == RY_STOPPED || r->sim->keeps_good, &later) != RY_OK ||
                ry_result_wait(r->file, &later) != RY_OK) {
                status = later.status;
                *error = error->status == RY_OK ? later : *error;
            }
        }
        ry_result_close(r->file);
        r->file = NULL;
    }
    return status;
}

static ry_status run(ry_runner *r, const ry_config *config, ry_error *error)
{
    int finished = 0;
    RY_TRY(open_run(r, config, &finished, error));
    if (finished) {
        return RY_OK;
    }
    r->first = r->sim->state.step;
    r->last = r->sim->plan.derived.steps_end;
    if (r->first > r->last) {
        snprintf(r->result->note, sizeof r->result->note,
                 "it had come to t = %.9g s, beyond time.end = %.9g s: no step was taken, the result ends where it stood",
                 r->sim->state.time, config->time_end);
    }
    r->started = r->shown = r->flushed = r->saved = ry_clock();
    const ry_status status = loop(r, error);
    RY_TRY(status);
    RY_TRY(ry_sim_check(r->sim, error)); /* nobody has looked at the last steps */
    r->result->wall_seconds = ry_clock() - r->started;
    r->result->steps = r->sim->state.step - r->first;
    if (r->file != NULL) {
        RY_TRY(take_checkpoint(r, error));
        RY_TRY(take_summary(r, error));
        ry_result *const file = r->file;
        r->file = NULL;
        RY_TRY(ry_result_finish(file, &r->sim->state, error));
    }
    char *const note = r->result->note;
    const size_t used = strlen(note);
    snprintf(note + used, sizeof r->result->note - used, "%s%s", used > 0 && r->doubt[0] != '\0' ? "; " : "", r->doubt);
    return RY_OK;
}

ry_status ry_run(const ry_config *config, const ry_run_options *options, ry_run_result *result,
                 ry_error *error)
{
    ry_error own = {0};
    ry_error *const text = error != NULL ? error : &own;
    ry_run_result unused;
    ry_runner r = {.options = options, .result = result != NULL ? result : &unused};
    *r.result = (ry_run_result){0};
    const ry_status status = leave(&r, run(&r, config, text), text);
    if (r.sim != NULL) {
        r.result->steps = r.sim->state.step - r.first;
        r.result->hash = ry_sim_hash(r.sim);
    }
    ry_sim_free(r.sim);
    free(r.output);
    return status;
}
