/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The beta whose q*(theta) comes closest to the target:
 *
 *     misfit(beta) = sum over theta of [ln(q / target)]^2 / (s^2 + t^2)
 *
 * s: standard error of ln q; t: that of the target, 0.25 where it tells none, for a target is met
 * when it is met within 25 %. Below a tenth of the target a bed is at rest, or nearly; whether it
 * moves depends on its packing, and how much tells nothing: it counts as ten times too slow, with
 * s = 1. Between the betas that were run, ln(q / target) is linear in ln beta. */
#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "study/tune_private.h"

enum { RESAMPLES = 2000, SEED = 5898 };
#define LEAST_PART 0.1
#define LARGEST_ERROR 1.0
/* Below this contrast (two standard errors) the misfit is flat. */
#define LEAST_CONTRAST 4.0
/* ... and so it is if this part of the range, in ln beta, is all as good. */
#define WIDEST 0.7
static const double pi = 3.14159265358979323846;

double ry_tune_ratio(double q, double target)
{
    return log(fmax(q / target, LEAST_PART));
}

/* --- means over seeds --- */

static int mean_flux(const ry_tune_fit *fit, ry_tune_flux *f, int i, double *within,
                     double *between)
{
    double sum = 0.0, errors = 0.0, squares = 0.0;
    const ry_tune_piece *const piece = &f->piece[(size_t)i * (size_t)fit->seeds];
    for (int s = 0; s < fit->seeds; s++) {
        if (!piece[s].done || piece[s].status != RY_OK) {
            return 0;
        }
        sum += piece[s].value[RY_TUNE_Q];
        errors += piece[s].value[RY_TUNE_Q_ERROR] * piece[s].value[RY_TUNE_Q_ERROR];
    }
    f->q[i] = sum / fit->seeds;
    for (int s = 0; s < fit->seeds; s++) {
        const double off = piece[s].value[RY_TUNE_Q] - f->q[i];
        squares += off * off;
    }
    *within = errors / fit->seeds / fit->seeds;
    *between = fit->seeds > 1 ? squares / (fit->seeds - 1) : 0.0;
    return 1;
}

/* How much beds differ beyond what their own errors tell, relative; two seeds tell it badly at one
 * point, but well over all of them. The median, for a bed near its threshold may move or not. */
static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double pooled_spread(ry_tune_fit *fit)
{
    double list[RY_TUNE_BETAS * RY_TUNE_THETAS];
    size_t n = 0;
    for (int b = 0; b < fit->n_beta; b++) {
        for (int i = 0; i < fit->n_theta; i++) {
            double within, between;
            ry_tune_flux *const f = &fit->grid[b];
            if (mean_flux(fit, f, i, &within, &between) && f->q[i] > 0.05 * fit->target[i]) {
                list[n++] = fmax(between - within * fit->seeds, 0.0) / (f->q[i] * f->q[i]);
            }
        }
    }
    if (n == 0) {
        return 0.0;
    }
    qsort(list, n, sizeof list[0], compare);
    const double freedom = fmax(fit->seeds - 1.0, 1.0); /* median of chi^2 by Wilson & Hilferty */
    return sqrt(list[n / 2] / pow(1.0 - 2.0 / (9.0 * freedom), 3.0));
}

void ry_tune_take_flux(const ry_tune_fit *fit, ry_tune_flux *f)
{
    f->good = 1;
    for (int i = 0; i < fit->n_theta; i++) {
        double within = 0.0, between = 0.0;
        f->good = mean_flux(fit, f, i, &within, &between) && f->good;
        const double own = fit->spread * f->q[i];
        /* Near its threshold a bed moves or not, and differs by more than usual. */
        f->error[i] = sqrt(fmax(within + own * own / fit->seeds, between / fit->seeds));
    }
}

/* --- misfit --- */

typedef struct curve {
    int n;
    double x[RY_TUNE_BETAS]; /* ln beta */
    double ratio[RY_TUNE_BETAS][RY_TUNE_THETAS], weight[RY_TUNE_BETAS][RY_TUNE_THETAS];
} curve;

/* Standard error of ln(q / target). */
static double error_of(const ry_tune_fit *fit, const ry_tune_flux *f, int i)
{
    return f->q[i] > LEAST_PART * fit->target[i] ? fmin(f->error[i] / f->q[i], LARGEST_ERROR)
                                                 : LARGEST_ERROR;
}

static double weight_of(const ry_tune_fit *fit, const ry_tune_flux *f, int i)
{
    const double s = error_of(fit, f, i);
    const double t = isnan(fit->target_error[i])
                         ? RY_TUNE_GOAL
                         : fmax(fit->target_error[i] / fit->target[i], 0.02);
    return 1.0 / (s * s + t * t);
}

static double misfit_of(const ry_tune_fit *fit, const double *ratio, const double *weight)
{
    double sum = 0.0;
    for (int i = 0; i < fit->n_theta; i++) {
        sum += weight[i] * ratio[i] * ratio[i];
    }
    return sum;
}

static double misfit_at(const ry_tune_fit *fit, const curve *c, double x)
{
    int k = 0;
    while (k + 2 < c->n && c->x[k + 1] <= x) {
        k++;
    }
    const double share = c->n > 1 ? (x - c->x[k]) / (c->x[k + 1] - c->x[k]) : 0.0;
    const int next = c->n > 1 ? k + 1 : k;
    double ratio[RY_TUNE_THETAS], weight[RY_TUNE_THETAS];
    for (int i = 0; i < fit->n_theta; i++) {
        ratio[i] = c->ratio[k][i] + share * (c->ratio[next][i] - c->ratio[k][i]);
        weight[i] = c->weight[k][i] + share * (c->weight[next][i] - c->weight[k][i]);
    }
    return misfit_of(fit, ratio, weight);
}

static double normal(uint64_t index)
{
    const double u = ry_random(SEED, RY_RANDOM_SAMPLE, 2 * index);
    const double v = ry_random(SEED, RY_RANDOM_SAMPLE, 2 * index + 1);
    return sqrt(-2.0 * log(1.0 - u)) * cos(2.0 * pi * v);
}

/* The curve as measured (round 0), or as it might have been within its errors. */
static curve make_curve(const ry_tune_fit *fit, int round)
{
    curve c = {0};
    for (int b = 0; b < fit->n_beta; b++) {
        const ry_tune_flux *const f = &fit->grid[b];
        if (!f->good) {
            continue;
        }
        c.x[c.n] = log(f->beta);
        for (int i = 0; i < fit->n_theta; i++) {
            const uint64_t place = ((uint64_t)round * RY_TUNE_BETAS + (uint64_t)b) * RY_TUNE_THETAS;
            const double off = round > 0 ? error_of(fit, f, i) * normal(place + (uint64_t)i) : 0.0;
            c.ratio[c.n][i] = fmax(ry_tune_ratio(f->q[i], fit->target[i]) + off, log(LEAST_PART));
            c.weight[c.n][i] = weight_of(fit, f, i);
        }
        c.n++;
    }
    return c;
}

static double fine_x(const curve *c, int k)
{
    return c->x[0] + (c->x[c->n - 1] - c->x[0]) * k / (RY_TUNE_FINE - 1);
}

static int best_of(const ry_tune_fit *fit, const curve *c)
{
    int best = 0;
    double least = INFINITY;
    for (int k = 0; k < RY_TUNE_FINE; k++) {
        const double m = misfit_at(fit, c, fine_x(c, k));
        if (m < least) {
            least = m;
            best = k;
        }
    }
    return best;
}

static void find_interval(ry_tune_fit *fit, const curve *measured)
{
    int votes[RY_TUNE_FINE] = {0}, below = 0, first = -1, last = 0;
    for (int r = 1; r <= RESAMPLES; r++) {
        const curve c = make_curve(fit, r);
        votes[best_of(fit, &c)]++;
    }
    for (int k = 0; k < RY_TUNE_FINE; k++) {
        below += votes[k];
        if (first < 0 && below > RESAMPLES / 40) {
            first = k;
        }
        if (votes[k] > 0 && below - votes[k] < RESAMPLES - RESAMPLES / 40) {
            last = k;
        }
    }
    fit->low = exp(fine_x(measured, first));
    fit->high = exp(fine_x(measured, last));
}

/* A target between the least and the most that the betas give, within two standard errors, and with
 * its 25 %, can be met. */
static void find_reach(ry_tune_fit *fit)
{
    for (int i = 0; i < fit->n_theta; i++) {
        double least = INFINITY, most = 0.0;
        for (int b = 0; b < fit->n_beta; b++) {
            if (fit->grid[b].good) {
                least = fmin(least, fit->grid[b].q[i] - 2.0 * fit->grid[b].error[i]);
                most = fmax(most, fit->grid[b].q[i] + 2.0 * fit->grid[b].error[i]);
            }
        }
        fit->reachable[i] = most >= (1.0 - RY_TUNE_GOAL) * fit->target[i] &&
                            least <= (1.0 + RY_TUNE_GOAL) * fit->target[i];
    }
}

ry_status ry_tune_fit_beta(ry_tune_fit *fit, ry_error *error)
{
    fit->spread = pooled_spread(fit);
    for (int b = 0; b < fit->n_beta; b++) {
        ry_tune_take_flux(fit, &fit->grid[b]);
    }
    const curve c = make_curve(fit, 0);
    if (c.n == 0) {
        return ry_fail(error, RY_UNPHYSICAL, "no beta can be run; the first: %s",
                       fit->grid[0].piece[0].why);
    }
    double most = 0.0;
    for (int k = 0; k < RY_TUNE_FINE; k++) {
        fit->fine_beta[k] = exp(fine_x(&c, k));
        fit->fine_misfit[k] = misfit_at(fit, &c, fine_x(&c, k));
        most = fmax(most, fit->fine_misfit[k]);
    }
    for (int b = 0; b < fit->n_beta; b++) {
        fit->grid[b].misfit = fit->grid[b].good ? misfit_at(fit, &c, log(fit->grid[b].beta)) : NAN;
    }
    const int best = best_of(fit, &c);
    fit->beta = fit->fine_beta[best];
    fit->contrast = most - fit->fine_misfit[best];
    find_interval(fit, &c);
    find_reach(fit);
    const double range = c.x[c.n - 1] - c.x[0];
    fit->at_edge = best == 0 || best == RY_TUNE_FINE - 1;
    fit->identifiable = fit->contrast >= LEAST_CONTRAST &&
                        log(fit->high / fit->low) < WIDEST * range && range > 0.0;
    return RY_OK;
}
