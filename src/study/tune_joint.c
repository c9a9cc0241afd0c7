/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The joint fit: any constants of the scene between bounds, all at once. ln(q/target) at each theta is
 * a quadratic surface over the logarithms of the constants, fitted to simulations: two thirds of them
 * fill the box evenly, the others lie where the first ones leave the optimum possible. A search that
 * follows single runs would follow their noise; the surfaces average it, and know what is left of it.
 * The best constants, their intervals and what the data do not tell come from the surfaces with their
 * errors (analysis/response.h). The best constants are then run themselves. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "config/keys.h"
#include "config/nearest.h"
#include "config/quantity.h"
#include "study/tune_private.h"

enum { SEEDS = 2, BEST_SEEDS = 4, MOST_BUDGET = 390, SPARE = 6, TRIES = 20000 };
enum { DESIGN_SEED = 5899, NEAR_SEED = 5900 };
/* A place is possible if its misfit is above the least by at most this many thresholds of 95 %. */
#define POSSIBLE 2.0

static const char *const usual[] = {"contact.alpha_m=20:80", "contact.alpha_cn=0.3:5", "contact.beta=0.5:4",
                                    "contact.restitution=0.1:0.9", "contact.friction=0.2:0.9"};

/* --- what is varied ------------------------------------------------------------------------------ */

double ry_tune_axis_value(const ry_tune_axis *axis, double x)
{
    const double half = 0.5 * log(axis->high / axis->low);
    return sqrt(axis->low * axis->high) * exp(half * x);
}

static double axis_place(const ry_tune_axis *axis, double value)
{
    return 2.0 * log(value / axis->low) / log(axis->high / axis->low) - 1.0;
}

static ry_status refuse(const char *text, ry_error *error, const char *what)
{
    return ry_fail(error, RY_BAD_INPUT, "--vary %s: %s", text, what);
}

/* Stresses are given by the target; times and output are no constants. */
static int is_constant(const ry_key_row *row, const char *path)
{
    static const char *const sections[] = {"contact", "fluid", "grains"};
    static const char *const others[] = {"contact.stiffness", "fluid.shields", "fluid.shear_stress"};
    int good = 0;
    for (int k = 0; k < 3; k++) {
        good = good || strcmp(row->section, sections[k]) == 0;
    }
    for (int k = 0; k < 3; k++) {
        good = good && strcmp(path, others[k]) != 0;
    }
    return good && row->type == 'r';
}

static ry_status find_key(const char *text, const char *path, ry_tune_axis *axis, ry_error *error)
{
    char section[60] = "", near[80], what[300];
    const char *const dot = strchr(path, '.');
    snprintf(section, sizeof section, "%.*s", dot != NULL ? (int)(dot - path) : 0, path);
    axis->key = dot != NULL ? ry_keys_find(section, dot + 1) : -1;
    if (axis->key < 0) {
        ry_nearest_key(dot != NULL ? section : NULL, dot != NULL ? dot + 1 : path, near, sizeof near);
        snprintf(what, sizeof what, "no key of a scene%s%s%s; give KEY=LOW:HIGH, such as contact.friction=0.2:0.9",
                 near[0] != '\0' ? "; did you mean " : "", near, near[0] != '\0' ? "?" : "");
        return refuse(text, error, what);
    }
    if (!is_constant(ry_keys_row(axis->key), path)) {
        return refuse(text, error, "is not fitted; numbers of contact, fluid and grains are, but for "
                                   "contact.stiffness, fluid.shields and fluid.shear_stress");
    }
    return RY_OK;
}

static ry_status read_bounds(const char *text, const char *words, ry_tune_axis *axis, ry_error *error)
{
    char low[60], problem[300], what[400];
    const ry_key_row *const row = ry_keys_row(axis->key);
    const char *const unit = row->unit[0] != '\0' ? row->unit : "1", *const colon = strchr(words, ':');
    if (colon == NULL) {
        return refuse(text, error, "give two bounds, LOW:HIGH, such as 0.2:0.9");
    }
    snprintf(low, sizeof low, "%.*s", (int)(colon - words), words);
    if (!ry_quantity_read(low, unit, &axis->low, problem, sizeof problem) ||
        !ry_quantity_read(colon + 1, unit, &axis->high, problem, sizeof problem)) {
        return refuse(text, error, problem);
    }
    if (!(axis->low > 0.0 && axis->high > axis->low && axis->low >= row->low && axis->high <= row->high)) {
        snprintf(what, sizeof what, "the bounds are %g and %g; allowed is %g <= LOW < HIGH <= %g, LOW above 0",
                 axis->low, axis->high, row->low, row->high);
        return refuse(text, error, what);
    }
    if (log(axis->high / axis->low) < 1e-3) {
        return refuse(text, error, "the bounds are nearly the same");
    }
    return RY_OK;
}

static ry_status read_axis(ry_tune_joint *j, const char *text, ry_error *error)
{
    const char *const equals = strchr(text, '=');
    if (equals == NULL || equals - text >= (ptrdiff_t)sizeof j->axis[0].path) {
        return refuse(text, error, "give KEY=LOW:HIGH, such as contact.friction=0.2:0.9");
    }
    if (j->n_axes == RY_RESPONSE_INPUTS) {
        return ry_fail(error, RY_BAD_INPUT, "--vary: at most %d constants are fitted together", RY_RESPONSE_INPUTS);
    }
    ry_tune_axis *const axis = &j->axis[j->n_axes];
    snprintf(axis->path, sizeof axis->path, "%.*s", (int)(equals - text), text);
    for (int k = 0; k < j->n_axes; k++) {
        if (strcmp(j->axis[k].path, axis->path) == 0) {
            return refuse(text, error, "is given twice");
        }
    }
    RY_TRY(find_key(text, axis->path, axis, error));
    RY_TRY(read_bounds(text, equals + 1, axis, error));
    j->n_axes++;
    return RY_OK;
}

ry_status ry_tune_joint_read(ry_tune_run *run, ry_error *error)
{
    const ry_tune_options *const wish = run->wish;
    ry_tune_joint *const j = &run->joint;
    const char *const *const list = wish->n_vary > 0 ? wish->vary : usual;
    const int n = wish->n_vary > 0 ? wish->n_vary : (int)(sizeof usual / sizeof *usual);
    if (!wish->joint && wish->n_vary == 0) {
        return wish->budget == 0 ? RY_OK : ry_fail(error, RY_BAD_INPUT, "--budget: is that of --joint; give it as well");
    }
    for (int k = 0; k < n; k++) {
        RY_TRY(read_axis(j, list[k], error));
    }
    const int terms = ry_response_terms(j->n_axes), least = terms + SPARE;
    j->budget = wish->budget > 0 ? wish->budget : (wish->quick ? least : 3 * terms > least ? 3 * terms : least);
    if (j->budget < least || j->budget > MOST_BUDGET) {
        return ry_fail(error, RY_BAD_INPUT, "--budget %d: %d constants take at least %d candidates; allowed are %d to %d",
                       j->budget, j->n_axes, least, least, MOST_BUDGET);
    }
    const int first = 2 * j->budget / 3;
    j->first = first > terms + 3 ? first : terms + 3;
    j->sample = ry_array((size_t)j->budget, sizeof *j->sample);
    return j->sample != NULL ? RY_OK : ry_no_memory(error, (size_t)j->budget * sizeof *j->sample);
}

/* --- runs ---------------------------------------------------------------------------------------- */

static void fill(const ry_tune_run *run, ry_tune_flux *flux, ry_tune_piece *set, const double *x)
{
    const ry_tune_joint *const j = &run->joint;
    flux->piece = set;
    flux->beta = NAN;
    for (int i = 0; i < run->fit.n_theta; i++) {
        for (int s = 0; s < run->fit.seeds; s++) {
            ry_tune_changes c = {.n = 0};
            for (int k = 0; k < j->n_axes; k++) {
                ry_tune_change(&c, j->axis[k].path, ry_tune_axis_value(&j->axis[k], x[k]));
            }
            ry_tune_change(&c, "grains.seed", ry_random_replica(run->base.grains_seed, s));
            ry_tune_make_flux(run, &set[i * run->fit.seeds + s], &c, i);
        }
    }
}

/* Samples from..to-1, whose x are there. */
static ry_status run_samples(ry_tune_run *run, const char *what, int from, int to, ry_error *error)
{
    ry_tune_joint *const j = &run->joint;
    const int per = run->fit.n_theta * run->fit.seeds;
    ry_tune_piece *const set = to > from ? ry_tune_new_pieces(run, (to - from) * per, error) : NULL;
    if (set == NULL) {
        return to > from ? error->status : RY_OK;
    }
    for (int k = from; k < to; k++) {
        fill(run, &j->sample[k].flux, &set[(k - from) * per], j->sample[k].x);
    }
    RY_TRY(ry_tune_run_batch(run, what, set, (to - from) * per, error));
    j->n = to;
    return RY_OK;
}

/* --- surfaces ------------------------------------------------------------------------------------ */

static ry_status take_samples(ry_tune_run *run, ry_error *error)
{
    ry_tune_joint *const j = &run->joint;
    const ry_tune_flux *set[RY_TUNE_SETS];
    for (int k = 0; k < j->n; k++) {
        set[k] = &j->sample[k].flux;
    }
    ry_tune_pool(&run->fit, j->n, set);
    j->good = 0;
    for (int k = 0; k < j->n; k++) {
        ry_tune_take_flux(&run->fit, &j->sample[k].flux);
        j->good += j->sample[k].flux.good;
    }
    ry_tune_find_reach(&run->fit, j->n, set);
    const int least = ry_response_terms(j->n_axes) + 1;
    if (j->good >= least) {
        return RY_OK;
    }
    const char *why = "";
    for (int k = 0; k < j->n; k++) {
        if (!j->sample[k].flux.good) {
            why = ry_tune_reason(j->sample[k].flux.piece, run->fit.n_theta * run->fit.seeds);
        }
    }
    return ry_fail(error, RY_UNPHYSICAL, "only %d of %d candidates could be run, and %d are needed; narrow --vary, or raise "
                   "--budget with --resume; one of the others: %s", j->good, j->n, least, why);
}

static ry_status judge(ry_tune_run *run, ry_error *error)
{
    ry_tune_joint *const j = &run->joint;
    const int n_theta = run->fit.n_theta;
    RY_TRY(take_samples(run, error));
    double *const x = ry_array((size_t)(j->good * (j->n_axes + 2)), sizeof *x);
    if (x == NULL) {
        return ry_no_memory(error, (size_t)j->good * sizeof *x);
    }
    double *const y = x + (ptrdiff_t)j->good * j->n_axes, *const own = y + j->good;
    ry_status status = RY_OK;
    j->aim.inputs = j->n_axes;
    j->aim.outputs = n_theta;
    for (int i = 0; i < n_theta && status == RY_OK; i++) {
        int row = 0;
        for (int k = 0; k < j->n; k++) {
            const ry_tune_flux *const f = &j->sample[k].flux;
            if (f->good) {
                memcpy(x + (ptrdiff_t)row * j->n_axes, j->sample[k].x, (size_t)j->n_axes * sizeof *x);
                y[row] = ry_tune_ratio(f->q[i], run->fit.target[i]);
                own[row++] = ry_tune_ratio_error(&run->fit, f, i);
            }
        }
        status = ry_response_fit(&j->aim.response[i], j->n_axes, row, x, y, own, error);
        j->aim.variance[i] = ry_tune_aim_variance(&run->fit, i);
    }
    free(x);
    return status == RY_OK ? ry_aim_judge(&j->aim, &j->verdict, error) : status;
}

/* The second lot: places that the first surfaces leave possible; where there are few, near the best. */
static void choose_near(ry_tune_joint *j)
{
    const double level = j->verdict.misfit + POSSIBLE * j->verdict.threshold;
    int made = j->n;
    for (int k = 0; k < TRIES && made < j->budget; k++) {
        double *const x = j->sample[made].x;
        for (int i = 0; i < j->n_axes; i++) {
            const uint64_t place = (uint64_t)k * RY_RESPONSE_INPUTS + (uint64_t)i;
            x[i] = 2.0 * ry_random(NEAR_SEED, RY_RANDOM_SAMPLE, place) - 1.0;
        }
        made += ry_aim_misfit(&j->aim, x) <= level;
    }
    for (; made < j->budget; made++) {
        for (int i = 0; i < j->n_axes; i++) {
            const uint64_t place = (uint64_t)(TRIES + made) * RY_RESPONSE_INPUTS + (uint64_t)i;
            const double off = 0.8 * ry_random(NEAR_SEED, RY_RANDOM_SAMPLE, place) - 0.4;
            j->sample[made].x[i] = fmin(fmax(j->verdict.best[i] + off, -1.0), 1.0);
        }
    }
}

/* Three digits are more than is known; what is run and written is what is told. */
static void round_best(ry_tune_joint *j)
{
    for (int k = 0; k < j->n_axes; k++) {
        char text[30];
        const ry_tune_axis *const axis = &j->axis[k];
        snprintf(text, sizeof text, "%.3g", ry_tune_axis_value(axis, j->verdict.best[k]));
        j->best[k] = fmin(fmax(strtod(text, NULL), axis->low), axis->high);
        j->low[k] = j->verdict.low[k] > -1.0 ? ry_tune_axis_value(axis, j->verdict.low[k]) : axis->low;
        j->high[k] = j->verdict.high[k] < 1.0 ? ry_tune_axis_value(axis, j->verdict.high[k]) : axis->high;
    }
}

static ry_status run_best(ry_tune_run *run, ry_error *error)
{
    ry_tune_joint *const j = &run->joint;
    ry_tune_fit *const fit = &run->fit;
    double x[RY_RESPONSE_INPUTS];
    fit->seeds = run->wish->quick ? 1 : BEST_SEEDS;
    ry_tune_piece *const set = ry_tune_new_pieces(run, fit->n_theta * fit->seeds, error);
    if (set == NULL) {
        return error->status;
    }
    round_best(j);
    for (int k = 0; k < j->n_axes; k++) {
        x[k] = axis_place(&j->axis[k], j->best[k]);
    }
    fill(run, &fit->best, set, x);
    RY_TRY(ry_tune_run_batch(run, "joint fit 3 of 3: flux with the best constants", set, fit->n_theta * fit->seeds,
                             error));
    ry_tune_take_flux(fit, &fit->best);
    return fit->best.good ? RY_OK
                          : ry_fail(error, RY_UNPHYSICAL, "the best constants can't be run: %s; narrow --vary",
                                    ry_tune_reason(set, fit->n_theta * fit->seeds));
}

ry_status ry_tune_joint_fit(ry_tune_run *run, ry_error *error)
{
    ry_tune_joint *const j = &run->joint;
    run->fit.seeds = run->wish->quick ? 1 : SEEDS;
    for (int k = 0; k < j->first; k++) {
        ry_design_point(j->n_axes, k, DESIGN_SEED, j->sample[k].x);
    }
    RY_TRY(run_samples(run, "joint fit 1 of 3: all over the bounds", 0, j->first, error));
    RY_TRY(judge(run, error));
    choose_near(j);
    RY_TRY(run_samples(run, "joint fit 2 of 3: where the best may be", j->first, j->budget, error));
    RY_TRY(judge(run, error));
    return run_best(run, error);
}
