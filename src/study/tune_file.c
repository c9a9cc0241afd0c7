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
    ry_table_file_set_text(w->file, group, "failure", f->good ? "" : f->piece[0].why);
}

static void write_fit(const writer *w)
{
    const ry_tune_fit *const fit = &w->run->fit;
    double reachable[RY_TUNE_THETAS];
    char group[40];
    for (int i = 0; i < fit->n_theta; i++) {
        reachable[i] = fit->reachable[i];
    }
    numbers(w, "flux", "theta", "1", "Shields number tau_b/((rho_s - rho_f) g d)", fit->n_theta,
            fit->theta);
    numbers(w, "flux", "target", "1", "q* of the target", fit->n_theta, fit->target);
    numbers(w, "flux", "reachable", "1", "1: some beta comes within 25 % of the target",
            fit->n_theta, reachable);
    numbers(w, "misfit", "beta", "1", "", RY_TUNE_FINE, fit->fine_beta);
    numbers(w, "misfit", "misfit", "1", "sum of [ln(q*/target)]^2 over its variance", RY_TUNE_FINE,
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
    ry_table_file_set_number(w->file, "flux", "spread_between_seeds", fit->spread);
}

ry_status ry_tune_write_file(const ry_tune_run *run, ry_error *error)
{
    writer w = {.run = run};
    RY_TRY(ry_table_file_create(&w.file, run->wish->output, "ryusa tune", run->wish->force, error));
    ry_table_file_set_text(w.file, "/", "title", run->base.title);
    ry_table_file_set_text(w.file, "/", "target", run->target.name);
    ry_table_file_set_text(w.file, "/", "scene_text", run->base.text);
    ry_table_file_set_number(w.file, "/", "alpha_m",
                             run->stiffness.candidate[run->stiffness.ours].value);
    ry_table_file_set_number(w.file, "/", "alpha_cn",
                             run->damping.candidate[run->damping.ours].value);
    ry_table_file_set_number(w.file, "/", "beta", run->fit.beta);
    ry_table_file_set_number(w.file, "/", "quick", run->wish->quick);
    write_settling(&w, &run->stiffness);
    write_settling(&w, &run->damping);
    write_fit(&w);
    return ry_table_file_finish(w.file, error);
}

/* The user's own text; what replaces the constants stands behind it as lines that the reader of scenes
 * knows ("# -s key=value"). */
ry_status ry_tune_write_scene(const ry_tune_run *run, ry_error *error)
{
    char alpha_m[60], alpha_cn[60], beta[60];
    snprintf(alpha_m, sizeof alpha_m, "contact.alpha_m=%.6g",
             run->stiffness.candidate[run->stiffness.ours].value);
    snprintf(alpha_cn, sizeof alpha_cn, "contact.alpha_cn=%.6g",
             run->damping.candidate[run->damping.ours].value);
    snprintf(beta, sizeof beta, "contact.beta=%.6g", run->fit.beta);
    const char *const changes[] = {alpha_m, alpha_cn, beta};
    ry_config tuned;
    RY_TRY(ry_config_parse(&tuned, run->base.text, run->base.path, changes, 3, error));
    char *const text =
        ry_text_print("# Tuned against %s%s; the constants are in the last lines.\n%s\n",
                      run->target.name, run->wish->quick ? " (--quick)" : "", tuned.text);
    const ry_status status = text != NULL ? ry_text_write(run->yaml_path, text, error)
                                          : ry_no_memory(error, strlen(tuned.text));
    free(text);
    ry_config_free(&tuned);
    return status;
}
