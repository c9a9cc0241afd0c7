/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a tuning leaves: OUT.h5 with every curve, and the scene with the constants found. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/table_file.h"
#include "study/tune_private.h"

typedef struct writer {
    ry_table_file *file;
    const ry_tune_run *run;
} writer;

static void numbers(const writer *w, const char *group, const char *name, const char *unit,
                    const char *text, int n, const double *values)
{
    char path[120];
    snprintf(path, sizeof path, "%s/%s", group, name);
    ry_table_file_numbers(w->file, path, unit, text, n, values);
}

/* --- settling --- */

enum {
    ALPHA,
    FINE,
    FINE_ERROR,
    COARSE,
    COARSE_ERROR,
    HEIGHT,
    HEIGHT_ERROR,
    DEEPEST,
    DEEPEST_ERROR,
    PERIOD,
    RINGING,
    UNREST,
    STATUS,
    COLUMNS
};
static const struct {
    const char *name, *unit, *text;
} column[COLUMNS] = {
    {"value", "1", "the candidate"},
    {"settling_time", "s", "last time off the settled height by more than 1e-4 d, mean over seeds"},
    {"settling_time_error", "s", "its standard error"},
    {"settling_time_coarse", "s", "the same for 1e-3 d"},
    {"settling_time_coarse_error", "s", "its standard error"},
    {"height", "1", "settled mean height over d, mean over seeds"},
    {"height_error", "1", "its standard error"},
    {"deepest_overlap", "1", "largest overlap of the settled bed over d, mean over seeds"},
    {"deepest_overlap_error", "1", "its standard error"},
    {"bed_period", "s", "of the bed's ringing, from the spectrum of y_gc, median over seeds"},
    {"bed_damping", "1", "damping ratio of that ringing, median over seeds"},
    {"unrest", "1", "seeds still moving by more than 1e-4 d at the end"},
    {"status", "1", "0 done, 2 refused, 3 unphysical"},
};

static void candidate_row(const ry_tune_settling *t, int k, double row[COLUMNS])
{
    const ry_tune_candidate *const c = &t->candidate[k];
    const double all[COLUMNS] = {
        c->value,   c->time[1],      c->error[1], c->time[0],       c->error[0],
        c->height,  c->height_error, c->deepest,  c->deepest_error, c->period,
        c->ringing, c->unrest,       0.0};
    for (int i = 0; i < COLUMNS; i++) {
        row[i] = c->good || i == ALPHA ? all[i] : NAN;
    }
    for (int s = t->seeds - 1; s >= 0; s--) {
        if (c->piece[s].status != RY_OK) {
            row[STATUS] = (double)c->piece[s].status;
        }
    }
}

static void write_curves(const writer *w, const ry_tune_settling *t, const char *group)
{
    char name[80];
    for (int k = 0; k < t->n; k++) {
        for (int s = 0; s < t->seeds; s++) {
            const ry_tune_piece *const piece = &t->candidate[k].piece[s];
            if (piece->n > RY_TUNE_CURVE) {
                snprintf(name, sizeof name, "curve/%02d-seed-%d", k, s + 1);
                numbers(w, group, name, "1", "mean height of the grains over d",
                        piece->n - RY_TUNE_CURVE, piece->value + RY_TUNE_CURVE);
            }
        }
    }
}

static void write_settling(const writer *w, const ry_tune_settling *t)
{
    char group[40];
    double row[RY_TUNE_CANDIDATES][COLUMNS], values[RY_TUNE_CANDIDATES];
    snprintf(group, sizeof group, "settling/%s", t->key);
    for (int k = 0; k < t->n; k++) {
        candidate_row(t, k, row[k]);
    }
    for (int i = 0; i < COLUMNS; i++) {
        for (int k = 0; k < t->n; k++) {
            values[k] = row[k][i];
        }
        numbers(w, group, column[i].name, column[i].unit, column[i].text, t->n, values);
    }
    write_curves(w, t, group);
    ry_table_file_set_number(w->file, group, "curve_spacing_s",
                             RY_TUNE_CURVE_STEPS * w->run->base.time_step);
    ry_table_file_set_number(w->file, group, "soonest", t->candidate[t->theirs].value);
    ry_table_file_set_number(w->file, group, "soonest_low", t->theirs_low);
    ry_table_file_set_number(w->file, group, "soonest_high", t->theirs_high);
    ry_table_file_set_number(w->file, group, "soonest_is_clear", t->clear);
    ry_table_file_set_number(w->file, group, "ours", t->candidate[t->ours].value);
    ry_table_file_set_number(w->file, group, "ours_low", t->ours_low);
    ry_table_file_set_number(w->file, group, "ours_high", t->ours_high);
}

/* --- flux --- */

static void write_flux(const writer *w, const ry_tune_flux *f, const char *group, const char *what)
{
    const ry_tune_fit *const fit = &w->run->fit;
    double values[RY_TUNE_THETAS * RY_TUNE_SEEDS], errors[RY_TUNE_THETAS * RY_TUNE_SEEDS];
    double ends[RY_TUNE_THETAS * RY_TUNE_SEEDS];
    const int n = fit->n_theta * fit->seeds;
    for (int k = 0; k < n; k++) {
        const int good = f->piece[k].n == RY_TUNE_FLUX_VALUES;
        values[k] = good ? f->piece[k].value[RY_TUNE_Q] : NAN;
        errors[k] = good ? f->piece[k].value[RY_TUNE_Q_ERROR] : NAN;
        ends[k] = good ? f->piece[k].value[RY_TUNE_END] : NAN;
    }
    double q[RY_TUNE_THETAS], error[RY_TUNE_THETAS];
    for (int i = 0; i < fit->n_theta; i++) {
        q[i] = f->good ? f->q[i] : NAN;
        error[i] = f->good ? f->error[i] : NAN;
    }
    numbers(w, group, "q_star", "1", "mean over seeds", fit->n_theta, q);
    numbers(w, group, "q_star_standard_error", "1", "its standard error, seeds included",
            fit->n_theta, error);
    numbers(w, group, "runs_q_star", "1", "of each run; the seed changes fastest", n, values);
    numbers(w, group, "runs_standard_error", "1", "from its own autocorrelation", n, errors);
    numbers(w, group, "runs_end", "s", "when each run ended", n, ends);
    ry_table_file_set_text(w->file, group, "what", what);
    ry_table_file_set_number(w->file, group, "beta", f->beta);
    ry_table_file_set_number(w->file, group, "misfit", f->misfit);
    ry_table_file_set_text(w->file, group, "failure", f->good ? "" : ry_tune_reason(f->piece, w->run->fit.n_theta * w->run->fit.seeds));
}

static void write_target(const writer *w)
{
    const ry_tune_fit *const fit = &w->run->fit;
    double reachable[RY_TUNE_THETAS];
    for (int i = 0; i < fit->n_theta; i++) {
        reachable[i] = fit->reachable[i];
    }
    numbers(w, "flux", "theta", "1", "Shields number tau_b/((rho_s - rho_f) g d)", fit->n_theta,
            fit->theta);
    numbers(w, "flux", "target", "1", "q* of the target", fit->n_theta, fit->target);
    numbers(w, "flux", "reachable", "1", "1: something that was run comes within 25 % of the target",
            fit->n_theta, reachable);
    numbers(w, "flux", "spread_between_packings", "1", "standard deviation of q* between packings, over q*",
            fit->n_theta, fit->spread);
}

static void write_fit(const writer *w)
{
    const ry_tune_fit *const fit = &w->run->fit;
    char group[40];
    write_target(w);
    numbers(w, "misfit", "beta", "1", "", RY_TUNE_FINE, fit->fine_beta);
    numbers(w, "misfit", "misfit", "1", "sum of [ln(q*/target)]^2/V + ln(V/V0), smoothed", RY_TUNE_FINE,
            fit->fine_misfit);
    for (int b = 0; b < fit->n_beta; b++) {
        snprintf(group, sizeof group, "flux/beta-%d", b);
        write_flux(w, &fit->grid[b], group, "our alpha_m and alpha_cn");
    }
    write_flux(w, &fit->best, "flux/best", "our alpha_m and alpha_cn, best beta");
    write_flux(w, &fit->his, "flux/his", "alpha_m 20.0, alpha_cn 1.3, beta 15.8 of Harada et al.");
    ry_table_file_set_number(w->file, "misfit", "best", fit->beta);
    ry_table_file_set_number(w->file, "misfit", "low", fit->low);
    ry_table_file_set_number(w->file, "misfit", "high", fit->high);
    ry_table_file_set_number(w->file, "misfit", "identifiable", fit->identifiable);
    ry_table_file_set_number(w->file, "misfit", "contrast", fit->contrast);
}

/* --- the joint fit --- */

static void write_samples(const writer *w, int axis_or_theta, int is_axis, int is_error, double *values)
{
    const ry_tune_joint *const j = &w->run->joint;
    for (int k = 0; k < j->n; k++) {
        const ry_tune_flux *const f = &j->sample[k].flux;
        values[k] = is_axis     ? ry_tune_axis_value(&j->axis[axis_or_theta], j->sample[k].x[axis_or_theta])
                    : !f->good  ? NAN
                    : is_error ? f->error[axis_or_theta]
                                : f->q[axis_or_theta];
    }
}

static void write_profiles(const writer *w)
{
    const ry_tune_joint *const j = &w->run->joint;
    const ry_verdict *const v = &j->verdict;
    double values[RY_TUNE_SETS], rise[RY_RESPONSE_PROFILE];
    for (int a = 0; a < j->n_axes; a++) {
        char group[100];
        snprintf(group, sizeof group, "joint/%s", j->axis[a].path);
        write_samples(w, a, 1, 0, values);
        numbers(w, group, "candidates", "1", "its value in each candidate, SI", j->n, values);
        for (int k = 0; k < RY_RESPONSE_PROFILE; k++) {
            values[k] = ry_tune_axis_value(&j->axis[a], -1.0 + 2.0 * k / (RY_RESPONSE_PROFILE - 1));
            rise[k] = v->profile[a][k] - v->misfit;
        }
        numbers(w, group, "value", "1", "where the profile is taken, SI", RY_RESPONSE_PROFILE, values);
        numbers(w, group, "profile", "1", "least misfit with this value, over the least of all", RY_RESPONSE_PROFILE,
                rise);
        ry_table_file_set_number(w->file, group, "lower_bound", j->axis[a].low);
        ry_table_file_set_number(w->file, group, "upper_bound", j->axis[a].high);
        ry_table_file_set_number(w->file, group, "best", j->best[a]);
        ry_table_file_set_number(w->file, group, "low", j->low[a]);
        ry_table_file_set_number(w->file, group, "high", j->high[a]);
    }
}

static void write_joint(const writer *w)
{
    const ry_tune_joint *const j = &w->run->joint;
    const ry_verdict *const v = &j->verdict;
    double values[RY_TUNE_SETS], flat[RY_RESPONSE_INPUTS], cross[RY_RESPONSE_OUTPUTS], unfit[RY_RESPONSE_OUTPUTS];
    char group[40];
    write_profiles(w);
    for (int i = 0; i < w->run->fit.n_theta; i++) {
        snprintf(group, sizeof group, "joint/theta-%d", i);
        write_samples(w, i, 0, 0, values);
        numbers(w, group, "q_star", "1", "of each candidate, mean over seeds; NAN: it could not be run", j->n, values);
        write_samples(w, i, 0, 1, values);
        numbers(w, group, "q_star_standard_error", "1", "its standard error, seeds included", j->n, values);
        numbers(w, group, "surface", "1", "coefficients of ln(q*/target): 1, x_i, x_i x_j with i <= j",
                j->aim.response[i].terms, j->aim.response[i].coefficient);
        cross[i] = j->aim.response[i].cross;
        unfit[i] = j->aim.response[i].unfit;
    }
    numbers(w, "joint", "left_out", "1", "rms of what left-out candidates are off the surface, for each theta",
            w->run->fit.n_theta, cross);
    numbers(w, "joint", "unfit", "1", "what candidates are off the surface beyond their errors", w->run->fit.n_theta,
            unfit);
    for (int d = 0; d < j->n_axes; d++) {
        snprintf(group, sizeof group, "joint/direction-%d", d);
        numbers(w, group, "vector", "1", "unit vector in x: ln of each constant, -1 to 1 between its bounds", j->n_axes,
                v->vector[d]);
        flat[d] = v->flat[d];
    }
    numbers(w, "joint", "information", "1", "eigenvalues of the Fisher information in x, of each direction", j->n_axes,
            v->value);
    numbers(w, "joint", "rise", "1", "of the misfit along each direction, within the bounds", j->n_axes, v->rise);
    numbers(w, "joint", "flat", "1", "1: the direction is not identifiable", j->n_axes, flat);
    ry_table_file_set_number(w->file, "joint", "threshold", v->threshold);
    ry_table_file_set_number(w->file, "joint", "chi2", v->chi2);
    ry_table_file_set_number(w->file, "joint", "candidates", j->n);
    ry_table_file_set_number(w->file, "joint", "candidates_of_use", j->good);
}

static void write_joint_flux(const writer *w)
{
    char keys[400] = "";
    for (int k = 0; k < w->run->joint.n_axes; k++) {
        const size_t used = strlen(keys);
        snprintf(keys + used, sizeof keys - used, "%s%s", k > 0 ? "," : "", w->run->joint.axis[k].path);
    }
    ry_table_file_set_text(w->file, "/", "varied", keys);
    write_target(w);
    write_flux(w, &w->run->fit.best, "flux/best", "the best constants");
}

ry_status ry_tune_write_file(const ry_tune_run *run, ry_error *error)
{
    writer w = {.run = run};
    RY_TRY(ry_table_file_create(&w.file, run->output, "ryusa tune", run->wish->force, error));
    ry_table_file_set_text(w.file, "/", "title", run->base.title);
    ry_table_file_set_text(w.file, "/", "target", run->target.name);
    ry_table_file_set_text(w.file, "/", "scene_text", run->base.text);
    ry_table_file_set_text(w.file, "/", "mark", run->mark);
    ry_table_file_set_number(w.file, "/", "quick", run->wish->quick);
    if (run->joint.n_axes > 0) {
        write_joint_flux(&w);
        write_joint(&w);
        return ry_table_file_finish(w.file, error);
    }
    ry_table_file_set_number(w.file, "/", "alpha_m",
                             run->stiffness.candidate[run->stiffness.ours].value);
    ry_table_file_set_number(w.file, "/", "alpha_cn",
                             run->damping.candidate[run->damping.ours].value);
    ry_table_file_set_number(w.file, "/", "beta", run->fit.beta);
    write_settling(&w, &run->stiffness);
    write_settling(&w, &run->damping);
    write_fit(&w);
    return ry_table_file_finish(w.file, error);
}

/* The user's own text; what replaces the constants stands behind it as lines that the reader of scenes
 * knows ("# -s key=value"). */
ry_status ry_tune_write_scene(const ry_tune_run *run, ry_error *error)
{
    ry_tune_changes c = {.n = 0};
    for (int k = 0; k < run->joint.n_axes; k++) {
        ry_tune_change(&c, run->joint.axis[k].path, run->joint.best[k]);
    }
    if (run->joint.n_axes == 0) {
        ry_tune_change(&c, "contact.alpha_m", run->stiffness.candidate[run->stiffness.ours].value);
        ry_tune_change(&c, "contact.alpha_cn", run->damping.candidate[run->damping.ours].value);
        ry_tune_change(&c, "contact.beta", run->fit.beta);
    }
    ry_config tuned;
    RY_TRY(ry_config_parse(&tuned, run->base.text, run->base.path, c.list, c.n, error));
    char *const text =
        ry_text_print(RY_TUNE_SCENE_HEAD "%s%s; the constants are in the last lines.\n%s\n",
                      run->target.name, run->wish->quick ? " (--quick)" : "", tuned.text);
    const ry_status status = text != NULL ? ry_text_write(run->yaml_path, text, error)
                                          : ry_no_memory(error, strlen(tuned.text));
    free(text);
    ry_config_free(&tuned);
    return status;
}
