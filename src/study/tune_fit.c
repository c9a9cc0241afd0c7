/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The beta whose q*(theta) comes closest to the target. At each theta y = ln(q/target) over ln beta is
 * smoothed by local quadratics (Cleveland 1979, with a Gaussian kernel), which tell their variance s^2:
 *
 *     misfit(beta) = sum over theta of y^2/V + ln(V/V0),   V = V0 + s^2,   V0 = t^2 + p^2
 *
 * t: error of ln target, 0.25 where it tells none, for a target is met when it is met within 25 %; p: by
 * how much the beds that all betas share may be off together. V0 does not depend on beta, so a noisy beta
 * is not judged more mildly. Below a tenth of the target a bed is at rest, or nearly; whether it moves
 * depends on its packing, and how much tells nothing: it counts as ten times too slow, with s = 1. */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <math.h>

#include "study/tune_private.h"

#define LEAST_PART 0.1
#define LARGEST_ERROR 1.0
#define LEAST_ERROR 0.02
/* Width of the kernel, in ln beta: that of the grid's steps. */
#define KERNEL 0.7
#define CHI2_95 3.841459
/* The misfit is flat if this part of the range, in ln beta, is all as good. */
#define WIDEST 0.7
enum { FEWEST = 4 };

double ry_tune_ratio(double q, double target)
{
    return log(fmax(q / target, LEAST_PART));
}

/* --- means over seeds --- */

static int replicas_of(const ry_tune_fit *fit, const ry_tune_flux *f, int i, ry_replicas *r)
{
    double q[RY_TUNE_SEEDS], error[RY_TUNE_SEEDS];
    const ry_tune_piece *const piece = &f->piece[(size_t)i * (size_t)fit->seeds];
    for (int s = 0; s < fit->seeds; s++) {
        if (!piece[s].done || piece[s].status != RY_OK) {
            return 0;
        }
        q[s] = piece[s].value[RY_TUNE_Q];
        error[s] = piece[s].value[RY_TUNE_Q_ERROR];
    }
    *r = ry_replicas_of(fit->seeds, q, error);
    return 1;
}

void ry_tune_pool(ry_tune_fit *fit, int n, const ry_tune_flux *const *set)
{
    for (int i = 0; i < fit->n_theta; i++) {
        ry_replicas at[RY_TUNE_SETS];
        int found = 0;
        for (int k = 0; k < n; k++) {
            found += replicas_of(fit, set[k], i, &at[found]);
        }
        fit->spread[i] = ry_replicas_spread(found, at, 0.05 * fit->target[i]);
    }
}

void ry_tune_take_flux(const ry_tune_fit *fit, ry_tune_flux *f)
{
    f->good = 1;
    for (int i = 0; i < fit->n_theta; i++) {
        ry_replicas r;
        if (!replicas_of(fit, f, i, &r)) {
            f->good = 0;
            return;
        }
        f->q[i] = r.mean;
        f->error[i] = ry_replicas_error(&r, fit->spread[i]);
    }
}

/* --- what goes into a misfit --- */

double ry_tune_ratio_error(const ry_tune_fit *fit, const ry_tune_flux *f, int i)
{
    return f->q[i] > LEAST_PART * fit->target[i]
               ? fmin(fmax(f->error[i] / f->q[i], LEAST_ERROR), LARGEST_ERROR)
               : LARGEST_ERROR;
}

double ry_tune_aim_variance(const ry_tune_fit *fit, int i)
{
    const double t = isnan(fit->target_error[i]) ? RY_TUNE_GOAL
                                                 : fmax(fit->target_error[i] / fit->target[i], LEAST_ERROR);
    return t * t + fit->spread[i] * fit->spread[i] / fit->seeds;
}

/* A target between the least and the most that the sets give, within two standard errors, and with its
 * 25 %, can be met. */
void ry_tune_find_reach(ry_tune_fit *fit, int n, const ry_tune_flux *const *set)
{
    for (int i = 0; i < fit->n_theta; i++) {
        double least = INFINITY, most = 0.0;
        for (int k = 0; k < n; k++) {
            if (set[k]->good) {
                least = fmin(least, set[k]->q[i] - 2.0 * set[k]->error[i]);
                most = fmax(most, set[k]->q[i] + 2.0 * set[k]->error[i]);
            }
        }
        fit->reachable[i] = most >= (1.0 - RY_TUNE_GOAL) * fit->target[i] &&
                            least <= (1.0 + RY_TUNE_GOAL) * fit->target[i];
    }
}

/* --- misfit over beta --- */

/* y at one theta, smoothed at x = ln beta; with too few betas, that of the nearest. */
static double smoothed(const ry_tune_fit *fit, int i, double x, double *variance)
{
    double at[RY_TUNE_BETAS], y[RY_TUNE_BETAS], error[RY_TUNE_BETAS];
    int n = 0, nearest = 0;
    for (int b = 0; b < fit->n_beta; b++) {
        const ry_tune_flux *const f = &fit->grid[b];
        if (f->good) {
            const double off = (log(f->beta) - x) / KERNEL;
            at[n] = off;
            y[n] = ry_tune_ratio(f->q[i], fit->target[i]);
            error[n] = ry_tune_ratio_error(fit, f, i) * exp(0.25 * fmin(off * off, 60.0));
            nearest = fabs(off) < fabs(at[nearest]) ? n : nearest;
            n++;
        }
    }
    ry_response r;
    if (n < FEWEST || ry_response_fit(&r, 1, n, at, y, error, NULL) != RY_OK) {
        *variance = error[nearest] * error[nearest];
        return y[nearest];
    }
    const double zero = 0.0;
    return ry_response_value(&r, &zero, variance);
}

static double misfit_of(const ry_tune_fit *fit, double x, double *chi2)
{
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < fit->n_theta; i++) {
        double variance;
        const double y = smoothed(fit, i, x, &variance), own = ry_tune_aim_variance(fit, i);
        squares += y * y / (own + variance);
        sum += log1p(variance / own);
    }
    if (chi2 != NULL) {
        *chi2 = squares;
    }
    return sum + squares;
}

static double misfit_at(double x, void *data)
{
    return misfit_of(data, x, NULL);
}

/* The least misfit between its two neighbours in the table, by Brent's method. */
static double refine(ry_tune_fit *fit, int k)
{
    const double x = log(fit->fine_beta[k]);
    if (k == 0 || k == RY_TUNE_FINE - 1) {
        return x;
    }
    gsl_error_handler_t *const old = gsl_set_error_handler_off();
    gsl_function f = {.function = misfit_at, .params = fit};
    gsl_min_fminimizer *const m = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
    double best = x;
    if (m != NULL &&
        gsl_min_fminimizer_set(m, &f, x, log(fit->fine_beta[k - 1]), log(fit->fine_beta[k + 1])) == GSL_SUCCESS) {
        for (int turn = 0; turn < 12 && gsl_min_fminimizer_iterate(m) == GSL_SUCCESS; turn++) {
        }
        best = gsl_min_fminimizer_x_minimum(m);
    }
    gsl_min_fminimizer_free(m);
    gsl_set_error_handler(old);
    return best;
}

/* Outward from the best, to where the misfit is larger by `rise` for good; the end if it never is. */
static double limit_of(const ry_tune_fit *fit, double level, int step)
{
    int k = step > 0 ? RY_TUNE_FINE - 1 : 0;
    if (fit->fine_misfit[k] <= level) {
        return fit->fine_beta[k];
    }
    while (fit->fine_misfit[k - step] > level) {
        k -= step;
    }
    const double share = (level - fit->fine_misfit[k - step]) / (fit->fine_misfit[k] - fit->fine_misfit[k - step]);
    return fit->fine_beta[k - step] * pow(fit->fine_beta[k] / fit->fine_beta[k - step], share);
}

int ry_tune_best_of_grid(const ry_tune_fit *fit)
{
    int best = -1;
    for (int b = 0; b < fit->n_beta; b++) {
        if (fit->grid[b].good && (best < 0 || fit->grid[b].misfit < fit->grid[best].misfit)) {
            best = b;
        }
    }
    return best;
}

static int tabulate(ry_tune_fit *fit, double *most)
{
    double low = INFINITY, high = -INFINITY;
    int best = 0;
    for (int b = 0; b < fit->n_beta; b++) {
        if (fit->grid[b].good) {
            low = fmin(low, log(fit->grid[b].beta));
            high = fmax(high, log(fit->grid[b].beta));
        }
    }
    *most = -INFINITY;
    for (int k = 0; k < RY_TUNE_FINE; k++) {
        const double x = low + (high - low) * k / (RY_TUNE_FINE - 1);
        fit->fine_beta[k] = exp(x);
        fit->fine_misfit[k] = misfit_of(fit, x, NULL);
        *most = fmax(*most, fit->fine_misfit[k]);
        best = fit->fine_misfit[k] < fit->fine_misfit[best] ? k : best;
    }
    return best;
}

ry_status ry_tune_fit_beta(ry_tune_fit *fit, ry_error *error)
{
    const ry_tune_flux *set[RY_TUNE_BETAS];
    for (int b = 0; b < fit->n_beta; b++) {
        set[b] = &fit->grid[b];
    }
    ry_tune_pool(fit, fit->n_beta, set);
    for (int b = 0; b < fit->n_beta; b++) {
        ry_tune_take_flux(fit, &fit->grid[b]);
    }
    for (int b = 0; b < fit->n_beta; b++) {
        fit->grid[b].misfit = fit->grid[b].good ? misfit_of(fit, log(fit->grid[b].beta), NULL) : NAN;
    }
    if (ry_tune_best_of_grid(fit) < 0) {
        return ry_fail(error, RY_UNPHYSICAL, "no beta can be run; the first: %s",
                       ry_tune_reason(fit->grid[0].piece, fit->n_theta * fit->seeds));
    }
    double most, chi2;
    const int best = tabulate(fit, &most);
    const double x = refine(fit, best), least = misfit_of(fit, x, &chi2);
    const double threshold = CHI2_95 * fmax(1.0, chi2 / fit->n_theta);
    fit->beta = exp(x);
    fit->contrast = most - least;
    fit->low = fmin(limit_of(fit, least + threshold, -1), fit->beta);
    fit->high = fmax(limit_of(fit, least + threshold, 1), fit->beta);
    ry_tune_find_reach(fit, fit->n_beta, set);
    const double range = log(fit->fine_beta[RY_TUNE_FINE - 1] / fit->fine_beta[0]);
    fit->at_edge = best == 0 || best == RY_TUNE_FINE - 1;
    fit->identifiable = fit->contrast >= threshold && range > 0.0 &&
                        log(fit->high / fit->low) < WIDEST * range;
    return RY_OK;
}
