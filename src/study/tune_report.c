/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The report of a tuning, within 100 columns. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "study/tune_private.h"

static const double pi = 3.14159265358979323846;

#define say ry_tune_say

/* Why something was not run, without the file and line in front. */
static const char *reason(const ry_tune_run *run, const char *why)
{
    const size_t length = strlen(run->base.path);
    if (strncmp(why, run->base.path, length) == 0 && why[length] == ':') {
        why += length + 1;
        why += strspn(why, "0123456789: ");
    }
    return why;
}

static double chosen(const ry_tune_settling *t)
{
    return t->candidate[t->ours].value;
}

/* --- settling --- */

static void settling_row(const ry_tune_run *run, const ry_tune_settling *t, int k, double his)
{
    const ry_tune_candidate *const c = &t->candidate[k];
    const char *const mark = k == t->ours ? " ours" : "";
    const char *const soon = k == t->theirs ? " soonest" : "";
    const char *const note = fabs(c->value - his) < 1e-9 * his ? " theirs" : "";
    if (!c->good) {
        int s = 0;
        while (s + 1 < t->seeds && c->piece[s].status == RY_OK) {
            s++;
        }
        say(run, "  %8.4g  not run: %.300s%s\n", c->value, reason(run, c->piece[s].why), note);
        return;
    }
    say(run, "  %8.4g  %6.3f +- %.3f  %6.3f +- %.3f  %8.4f +- %.4f   %8.5f%s%s%s%s\n", c->value,
        c->time[1], c->error[1], c->time[0], c->error[0], c->height, c->height_error, c->deepest,
        c->unrest > 0 ? " *" : "  ", mark, soon, note);
}

static void settling_table(const ry_tune_run *run, const ry_tune_settling *t, double his)
{
    int unrest = 0;
    say(run, "  %8s  time to 1e-4 d   time to 1e-3 d   settled height/d   deepest\n", t->key);
    say(run, "            s                s                                   overlap/d\n");
    for (int k = 0; k < t->n; k++) {
        settling_row(run, t, k, his);
        unrest += t->candidate[k].unrest;
    }
    if (unrest > 0) {
        say(run, "  * some seeds still move by more than 1e-4 d at the end of the window\n");
    }
}

static void harada_verdict(const ry_tune_run *run, const ry_tune_settling *t, double his)
{
    say(run, "  Harada's criterion (at rest soonest): %s = %.3g, 95 %% %.3g to %.3g; theirs %.3g\n",
        t->key, t->candidate[t->theirs].value, t->theirs_low, t->theirs_high, his);
    if (!t->clear) {
        say(run, "    NOT IDENTIFIABLE by it: within the errors these settle as soon:");
        for (int k = 0; k < t->n; k++) {
            const ry_tune_candidate *const c = &t->candidate[k];
            if (c->as_soon) {
                say(run, " %.3g", c->value);
            }
        }
        say(run, "\n");
    }
}

/* Against a column of N equal grains on its springs: T_bed/T = 1/(2 sin b), damping ratio
 * alpha_cn 2 sin b of its lowest mode, b = pi/(4N + 2). */
static void report_ringing(const ry_tune_run *run)
{
    const ry_tune_settling *const t = &run->stiffness;
    const double mode = 2.0 * sin(pi / (4.0 * run->base.grains_layers + 2.0));
    say(run,
        "  Natural period of the bed, from the spectrum of y_gc, over T; (its damping ratio):\n   ");
    int shown = 0;
    for (int k = 0; k < t->n; k++) {
        const ry_tune_candidate *const c = &t->candidate[k];
        if (c->good && !isnan(c->period)) {
            say(run, "%s %.3g: %.1f (%.2f)", shown > 0 && shown % 5 == 0 ? "\n   " : "", c->value,
                c->period / (c->value * run->base.time_step), c->ringing);
            shown++;
        }
    }
    say(run, "\n    a column of %d such grains on springs and dashpots: %.1f (%.2f)\n",
        run->base.grains_layers, 1.0 / mode, mode * run->base.contact_alpha_cn);
}

static void report_settling(const ry_tune_run *run)
{
    const ry_tune_settling *const m = &run->stiffness, *const cn = &run->damping;
    say(run,
        "\n1. alpha_m: a dry lattice settles for %.3g s, alpha_cn = %.3g, the same %d packings for each\n",
        run->settle_window, run->base.contact_alpha_cn, m->seeds);
    settling_table(run, m, RY_TUNE_HIS_ALPHA_M);
    harada_verdict(run, m, RY_TUNE_HIS_ALPHA_M);
    say(run,
        "  Ours (softest spring that overlaps by no more than %.2g d, so that a collision takes the\n"
        "    most steps): alpha_m = %.3g, 95 %% interval %.3g to %.3g (of the candidates)\n",
        RY_TUNE_OVERLAP, chosen(m), m->ours_low, m->ours_high);
    report_ringing(run);
    say(run, "\n2. alpha_cn: the same at alpha_m = %.3g\n", chosen(m));
    settling_table(run, cn, RY_TUNE_HIS_ALPHA_CN);
    harada_verdict(run, cn, RY_TUNE_HIS_ALPHA_CN);
    say(run,
        "  Ours (least damping that comes to rest as soon as any, within the errors):\n"
        "    alpha_cn = %.3g, 95 %% interval %.3g to %.3g (of the candidates)\n",
        chosen(cn), cn->ours_low, cn->ours_high);
}

/* --- flux --- */

void ry_tune_report_flux(const ry_tune_run *run, const ry_tune_flux *f, const char *name)
{
    if (!f->good) {
        say(run, "  %-8s  not run: %.300s\n", name, reason(run, ry_tune_reason(f->piece, run->fit.n_theta * run->fit.seeds)));
        return;
    }
    say(run, "  %-8s", name);
    for (int i = 0; i < run->fit.n_theta; i++) {
        say(run, "  %9.3g", f->q[i]);
    }
    say(run, "\n  %-8s", "    +-");
    for (int i = 0; i < run->fit.n_theta; i++) {
        say(run, "  %9.2g", f->error[i]);
    }
    say(run, "\n");
}

void ry_tune_report_theta(const ry_tune_run *run)
{
    const ry_tune_fit *const fit = &run->fit;
    say(run, "  theta   ");
    for (int i = 0; i < fit->n_theta; i++) {
        say(run, "  %9.3g", fit->theta[i]);
    }
    say(run, "\n  target  ");
    for (int i = 0; i < fit->n_theta; i++) {
        say(run, "  %9.3g", fit->target[i]);
    }
    say(run, "\n");
}

/* What q* of beds differs by that differ in their packing only. */
void ry_tune_report_spread(const ry_tune_run *run)
{
    say(run, "  packings");
    for (int i = 0; i < run->fit.n_theta; i++) {
        const double spread = run->fit.spread[i]; /* 0: unknown, where some rest whatever the constants */
        if (spread > 0.0) {
            say(run, "  %7.0f %%", 100.0 * spread);
        } else {
            say(run, "%11s", "-");
        }
    }
    say(run, "   (beds differ by)\n");
}

static void flux_table(const ry_tune_run *run)
{
    const ry_tune_fit *const fit = &run->fit;
    char name[30];
    ry_tune_report_theta(run);
    ry_tune_report_spread(run);
    for (int b = 0; b < fit->n_beta; b++) {
        snprintf(name, sizeof name, "b=%.3g", fit->grid[b].beta);
        ry_tune_report_flux(run, &fit->grid[b], name);
    }
    ry_tune_report_flux(run, &fit->best, "best");
    ry_tune_report_flux(run, &fit->his, "Harada's");
}

/* Beds of the best constants that are at rest, or nearly. */
/* A target that no bed reaches makes none of them a bed at rest. */
#define MOST_AT_REST 0.1

static int beds_at_rest(const ry_tune_fit *fit, int i)
{
    int rest = 0;
    for (int s = 0; s < fit->seeds; s++) {
        const ry_tune_piece *const piece = &fit->best.piece[i * fit->seeds + s];
        rest += piece->n > 0 && piece->value[RY_TUNE_Q] < 0.1 * fmin(fit->target[i], MOST_AT_REST);
    }
    return rest;
}

void ry_tune_report_reach(const ry_tune_run *run, const char *what)
{
    const ry_tune_fit *const fit = &run->fit;
    int met = 0;
    for (int i = 0; i < fit->n_theta; i++) {
        const double off = 100.0 * (fit->best.q[i] / fit->target[i] - 1.0);
        const double error = 100.0 * fit->best.error[i] / fit->target[i];
        const int within = fit->best.good && fabs(off) <= 100.0 * RY_TUNE_GOAL;
        met += within;
        if (!within && fit->best.good) {
            say(run, "  theta = %-6.3g %+5.0f %% (+- %.0f) of the target: %s\n", fit->theta[i], off,
                error,
                fit->reachable[i] ? what : "OUT OF REACH of the model, whatever was run");
            const int rest = beds_at_rest(fit, i);
            if (rest > 0) {
                say(run, "                  %d of %d beds rest there: near the threshold the packing decides\n", rest,
                    fit->seeds);
            }
        }
    }
    say(run, "  within 25 %% of the target at %d of %d Shields numbers%s\n", met, fit->n_theta,
        met == fit->n_theta ? "" : "; see above for the others");
}

static void report_beta(const ry_tune_run *run)
{
    const ry_tune_fit *const fit = &run->fit;
    say(run, "\n4. beta: misfit = sum of [ln(q*/target)]^2/V + ln(V/V0), smoothed over beta\n  ");
    for (int b = 0; b < fit->n_beta; b++) {
        if (fit->grid[b].good) {
            say(run, "%.3g: %.1f   ", fit->grid[b].beta, fit->grid[b].misfit);
        }
    }
    say(run,
        "\n  best beta = %.3g, 95 %% %.3g to %.3g; theirs 15.8\n",
        fit->beta, fit->low, fit->high);
    if (!fit->identifiable) {
        say(run,
            "  NOT IDENTIFIABLE: the misfit is flat within its errors (contrast %.1f over all beta)\n",
            fit->contrast);
    }
    if (fit->at_edge) {
        say(run,
            "  it lies at the edge of what was run: the target pulls beyond that, don't trust it\n");
    } else if (fit->identifiable) {
        const int below = fit->low > 1.001 * fit->fine_beta[0];
        const int above = fit->high < 0.999 * fit->fine_beta[RY_TUNE_FINE - 1];
        say(run, "%s", below && above ? ""
                       : above        ? "  bounded from above only: the lower limit is the edge of what was run\n"
                                      : "  bounded from below only: the upper limit is the edge of what was run\n");
    }
    ry_tune_report_reach(run, "another beta meets it, not this one");
}

static void report_confounding(const ry_tune_run *run)
{
    ry_config c = run->base;
    c.contact_alpha_m = chosen(&run->stiffness);
    c.contact_alpha_cn = chosen(&run->damping);
    c.contact_beta = 1.0;
    const ry_derived one = ry_config_derive(&c);
    c.contact_beta = run->fit.beta;
    const ry_derived best = ry_config_derive(&c);
    say(run,
        "\nWhat beta does: with dt fixed it divides k by beta^2 and leaves eta as it is, for eta goes with\n"
        "  alpha_cn beta x sqrt(k). At beta = 1 k = %.3g N/m and eta = %.3g N s/m; at the best\n"
        "  %.3g and %.3g (beta = %.3g).\n"
        "  Softness and damping are confounded: a fit of beta can't tell one from the other.\n",
        one.stiffness, one.damping, best.stiffness, best.damping, run->fit.beta);
}

static void report_difference(const ry_tune_run *run)
{
    ry_parameter p;
    const char *law = "";
    for (int k = 0; ry_config_parameter(&run->base, k, &p); k++) {
        if (strcmp(p.section, "contact") == 0 && strcmp(p.key, "law") == 0) {
            law = p.word;
        }
    }
    /* a + 2c = 4 of an explicit pair: 8 pi^2/x^2 + 16 pi alpha_cn/x = 4 */
    const double half = 2.0 * pi * RY_TUNE_HIS_ALPHA_CN;
    const double least = half + sqrt(half * half + 2.0 * pi * pi);
    say(run, "\nHarada's optimum 20.0, 1.3, 15.8 against ours %.3g, %.3g, %.3g (law %s):\n",
        chosen(&run->stiffness), chosen(&run->damping), run->fit.beta, law);
    say(run,
        "  an explicit spring and dashpot with alpha_cn = 1.3 is stable for a pair from alpha_m = %.3g on\n"
        "  (a + 2c < 4), so 20 is about the stiffest spring that it bears, and softer ones swing longer.\n"
        "  Law `energy' bounds spring and dashpot: every stiff spring comes to rest alike, and settling\n"
        "  time no longer singles one out. His density, drag and how the stress reaches the grains are\n"
        "  not printed; these move q* by more than beta does.\n",
        least);
}

void ry_tune_report_head(const ry_tune_run *run)
{
    say(run, "%s: %s\n", run->base.path, run->base.title);
    if (run->target.relation != NULL) {
        say(run, "target  %s: %s %d\n", run->target.name, run->target.relation->authors,
            run->target.relation->year);
    } else {
        say(run, "target  %s: %d points\n", run->target.name, run->target.n);
    }
    say(run,
        "        theta = tau_b/((rho_s - rho_f) g d); q* = q_b/sqrt((s-1) g d^3), sphere volumes in a\n"
        "        slab of width d\n");
}

void ry_tune_report(const ry_tune_run *run)
{
    const ry_tune_fit *const fit = &run->fit;
    ry_tune_report_head(run);
    report_settling(run);
    say(run, "\n3. flux: q*, from motion, the same %d packing%s for each", fit->seeds,
        fit->seeds == 1 ? "" : "s");
    say(run, "\n");
    flux_table(run);
    report_beta(run);
    report_confounding(run);
    report_difference(run);
    if (run->wish->quick) {
        say(run, "\n--quick: few candidates and short runs; no numbers to rely on\n");
    }
    say(run, "\nresult  %s, scene with the constants %s; %.0f s\n", run->wish->output,
        run->yaml_path, ry_clock() - run->started);
}
