/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What several response surfaces that should all be 0 say about their inputs. */
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <math.h>
#include <nlopt.h>
#include <string.h>

#include "analysis/response.h"
#include "base/memory.h"

/* chi^2 with one degree of freedom is below this in 95 % of cases. */
#define CHI2_95 3.841459
enum { STARTS = 200, POLISHED = 6, MOST_CALLS = 4000, WALK = 12, SEED = 11 };

double ry_aim_misfit(const ry_aim *aim, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < aim->outputs; k++) {
        double variance;
        const double y = ry_response_value(&aim->response[k], x, &variance);
        sum += y * y / (aim->variance[k] + variance) + log1p(variance / aim->variance[k]);
    }
    return sum;
}

static double chi2_of(const ry_aim *aim, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < aim->outputs; k++) {
        double variance;
        const double y = ry_response_value(&aim->response[k], x, &variance);
        sum += y * y / (aim->variance[k] + variance);
    }
    return sum;
}

/* --- the least misfit, with one input fixed or none --- */

typedef struct search {
    const ry_aim *aim;
    int fixed; /* -1: none */
    double x[RY_RESPONSE_INPUTS];
} search;

static double objective(unsigned n, const double *free_x, double *gradient, void *data)
{
    search *const s = data;
    (void)n;
    (void)gradient;
    for (int i = 0, k = 0; i < s->aim->inputs; i++) {
        if (i != s->fixed) {
            s->x[i] = free_x[k++];
        }
    }
    return ry_aim_misfit(s->aim, s->x);
}

/* From x, which it moves; returns the misfit there. */
static double polish(const ry_aim *aim, int fixed, double *x)
{
    search s = {.aim = aim, .fixed = fixed};
    double free_x[RY_RESPONSE_INPUTS], least = ry_aim_misfit(aim, x);
    unsigned n = 0;
    memcpy(s.x, x, (size_t)aim->inputs * sizeof *x);
    for (int i = 0; i < aim->inputs; i++) {
        if (i != fixed) {
            free_x[n++] = x[i];
        }
    }
    nlopt_opt opt = n > 0 ? nlopt_create(NLOPT_LN_SBPLX, n) : NULL;
    if (opt == NULL) {
        return least;
    }
    nlopt_set_lower_bounds1(opt, -1.0);
    nlopt_set_upper_bounds1(opt, 1.0);
    nlopt_set_initial_step1(opt, 0.2);
    nlopt_set_min_objective(opt, objective, &s);
    nlopt_set_xtol_abs1(opt, 1e-5);
    nlopt_set_ftol_abs(opt, 1e-8);
    nlopt_set_maxeval(opt, MOST_CALLS);
    double found;
    if (nlopt_optimize(opt, free_x, &found) > 0 && found <= least) {
        least = found;
        for (int i = 0, k = 0; i < aim->inputs; i++) {
            x[i] = i == fixed ? x[i] : free_x[k++];
        }
    }
    nlopt_destroy(opt);
    return least;
}

/* The surfaces may have several valleys: the best of many starts are polished. */
static void find_best(const ry_aim *aim, ry_verdict *v)
{
    double start[POLISHED][RY_RESPONSE_INPUTS], value[POLISHED];
    const size_t size = sizeof start[0];
    for (int k = 0; k < POLISHED; k++) {
        value[k] = INFINITY;
    }
    for (int k = 0; k < STARTS; k++) {
        double x[RY_RESPONSE_INPUTS] = {0};
        if (k > 0) {
            ry_design_point(aim->inputs, k, SEED, x);
        }
        const double misfit = ry_aim_misfit(aim, x);
        int place = POLISHED;
        while (place > 0 && misfit < value[place - 1]) {
            place--;
        }
        for (int m = POLISHED - 1; m > place; m--) {
            value[m] = value[m - 1];
            memcpy(start[m], start[m - 1], size);
        }
        if (place < POLISHED) {
            value[place] = misfit;
            memcpy(start[place], x, size);
        }
    }
    v->misfit = INFINITY;
    for (int k = 0; k < POLISHED; k++) {
        const double misfit = polish(aim, -1, start[k]);
        if (misfit < v->misfit) {
            v->misfit = misfit;
            memcpy(v->best, start[k], size);
        }
    }
}

/* --- intervals --- */

static double place_of(int k)
{
    return -1.0 + 2.0 * k / (RY_RESPONSE_PROFILE - 1);
}

/* From one place to the next, each beginning where the one before ended. Valleys may cross: what a walk
 * from the other side has found lower stays. */
static void walk_profile(const ry_aim *aim, ry_verdict *v, int input, int first, int step, double *x)
{
    for (int k = first; k >= 0 && k < RY_RESPONSE_PROFILE; k += step) {
        x[input] = place_of(k);
        v->profile[input][k] = fmin(v->profile[input][k], polish(aim, input, x));
    }
}

/* Outward from the best x and back again. */
static void find_profile(const ry_aim *aim, ry_verdict *v, int input, int below)
{
    double left[RY_RESPONSE_INPUTS], right[RY_RESPONSE_INPUTS];
    memcpy(left, v->best, sizeof left);
    memcpy(right, v->best, sizeof right);
    for (int k = 0; k < RY_RESPONSE_PROFILE; k++) {
        v->profile[input][k] = INFINITY;
    }
    walk_profile(aim, v, input, below, -1, left);
    walk_profile(aim, v, input, below + 1, 1, right);
    walk_profile(aim, v, input, 0, 1, left);
    walk_profile(aim, v, input, RY_RESPONSE_PROFILE - 1, -1, right);
}

/* Where the profile crosses `level` on the way from the best x outward; the bound if it doesn't. */
static double crossing(const ry_verdict *v, int input, int first, int step, double level)
{
    double before = v->best[input], misfit_before = v->misfit;
    for (int k = first; k >= 0 && k < RY_RESPONSE_PROFILE; k += step) {
        const double here = place_of(k), misfit = v->profile[input][k];
        if (misfit > level) {
            const double rise = misfit - misfit_before;
            return before + (here - before) * (rise > 0.0 ? (level - misfit_before) / rise : 1.0);
        }
        before = here;
        misfit_before = misfit;
    }
    return step > 0 ? 1.0 : -1.0;
}

static void find_intervals(const ry_aim *aim, ry_verdict *v)
{
    for (int i = 0; i < aim->inputs; i++) {
        const int below = (int)floor((v->best[i] + 1.0) / 2.0 * (RY_RESPONSE_PROFILE - 1));
        find_profile(aim, v, i, below);
    }
    for (int i = 0; i < aim->inputs; i++) {
        const int below = (int)floor((v->best[i] + 1.0) / 2.0 * (RY_RESPONSE_PROFILE - 1));
        v->low[i] = crossing(v, i, below, -1, v->misfit + v->threshold);
        v->high[i] = crossing(v, i, below + 1, 1, v->misfit + v->threshold);
    }
}

/* --- directions --- */

/* The place along one direction is fixed, those along the others are free. A bent valley may leave the box at
 * its side: what is outside counts as on the bound, and grows steeply where it is far outside. */
#define FAR_OUTSIDE 0.5
typedef struct valley {
    const ry_aim *aim;
    const ry_verdict *verdict;
    int direction;
    double place;
    double x[RY_RESPONSE_INPUTS];
} valley;

static double valley_misfit(unsigned n, const double *others, double *gradient, void *data)
{
    valley *const w = data;
    const int inputs = w->aim->inputs;
    double outside = 0.0;
    (void)n;
    (void)gradient;
    for (int i = 0; i < inputs; i++) {
        double x = w->verdict->best[i];
        for (int d = 0, k = 0; d < inputs; d++) {
            x += w->verdict->vector[d][i] * (d == w->direction ? w->place : others[k++]);
        }
        w->x[i] = fmin(fmax(x, -1.0), 1.0);
        const double far = fmax(fabs(x - w->x[i]) - FAR_OUTSIDE, 0.0);
        outside += far * far;
    }
    return ry_aim_misfit(w->aim, w->x) + 1e4 * outside;
}

static double least_across(valley *w, double *others)
{
    const unsigned n = (unsigned)w->aim->inputs - 1;
    double least = valley_misfit(n, others, NULL, w);
    nlopt_opt opt = n > 0 ? nlopt_create(NLOPT_LN_SBPLX, n) : NULL;
    if (opt != NULL) {
        nlopt_set_initial_step1(opt, 0.1);
        nlopt_set_min_objective(opt, valley_misfit, w);
        nlopt_set_xtol_abs1(opt, 1e-4);
        nlopt_set_ftol_abs(opt, 1e-5);
        nlopt_set_maxeval(opt, MOST_CALLS / 4);
        nlopt_optimize(opt, others, &least);
        nlopt_destroy(opt);
    }
    return least;
}

/* How much the misfit rises on the way to the bounds along a direction, both ways, the place across it
 * chosen anew at each step: valleys may be bent. */
static double rise_along(const ry_aim *aim, const ry_verdict *v, int direction)
{
    double most = 0.0;
    for (int side = -1; side <= 1; side += 2) {
        double others[RY_RESPONSE_INPUTS] = {0}, reach = INFINITY;
        valley w = {.aim = aim, .verdict = v, .direction = direction};
        for (int i = 0; i < aim->inputs; i++) {
            const double d = side * v->vector[direction][i];
            if (fabs(d) > 1e-2) {
                reach = fmin(reach, ((d > 0.0 ? 1.0 : -1.0) - v->best[i]) / d);
            }
        }
        for (int k = 1; k <= WALK; k++) {
            w.place = side * reach * k / WALK;
            most = fmax(most, least_across(&w, others) - v->misfit);
        }
    }
    return most;
}

static ry_status find_directions(const ry_aim *aim, ry_verdict *v, ry_error *failure)
{
    const size_t n = (size_t)aim->inputs;
    double information[RY_RESPONSE_INPUTS * RY_RESPONSE_INPUTS] = {0};
    for (int k = 0; k < aim->outputs; k++) {
        double slope[RY_RESPONSE_INPUTS], variance;
        ry_response_value(&aim->response[k], v->best, &variance);
        ry_response_slope(&aim->response[k], v->best, slope);
        for (size_t i = 0; i < n; i++) {
            for (size_t j = 0; j < n; j++) {
                information[i * n + j] += slope[i] * slope[j] / (aim->variance[k] + variance);
            }
        }
    }
    gsl_matrix_view matrix = gsl_matrix_view_array(information, n, n);
    gsl_vector *const value = gsl_vector_alloc(n);
    gsl_matrix *const vector = gsl_matrix_alloc(n, n);
    gsl_eigen_symmv_workspace *const work = gsl_eigen_symmv_alloc(n);
    const int good = value && vector && work;
    if (good) {
        gsl_eigen_symmv(&matrix.matrix, value, vector, work);
        gsl_eigen_symmv_sort(value, vector, GSL_EIGEN_SORT_VAL_DESC);
        for (size_t k = 0; k < n; k++) {
            v->value[k] = fmax(gsl_vector_get(value, k), 0.0);
            for (size_t i = 0; i < n; i++) {
                v->vector[k][i] = gsl_matrix_get(vector, i, k);
            }
        }
        for (size_t k = 0; k < n; k++) {
            v->rise[k] = rise_along(aim, v, (int)k);
            v->flat[k] = v->rise[k] < v->threshold;
        }
    }
    gsl_eigen_symmv_free(work);
    gsl_vector_free(value);
    gsl_matrix_free(vector);
    return good ? RY_OK : ry_no_memory(failure, n * n * sizeof(double));
}

ry_status ry_aim_judge(const ry_aim *aim, ry_verdict *verdict, ry_error *failure)
{
    *verdict = (ry_verdict){0};
    gsl_error_handler_t *const old = gsl_set_error_handler_off();
    find_best(aim, verdict);
    verdict->chi2 = chi2_of(aim, verdict->best);
    verdict->threshold = CHI2_95 * fmax(1.0, verdict->chi2 / aim->outputs);
    find_intervals(aim, verdict);
    const ry_status status = find_directions(aim, verdict, failure);
    gsl_set_error_handler(old);
    return status;
}
