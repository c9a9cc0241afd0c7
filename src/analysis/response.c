/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The surfaces themselves: weighted least squares. What is off beyond the errors given is found as the
 * extra variance with which chi^2 is as large as the degrees of freedom. */
#include "analysis/response.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit.h>
#include <gsl/gsl_qrng.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"

int ry_response_terms(int inputs)
{
    return 1 + inputs + inputs * (inputs + 1) / 2;
}

static void terms_of(int inputs, const double *x, double *term)
{
    int k = 0;
    term[k++] = 1.0;
    for (int i = 0; i < inputs; i++) {
        term[k++] = x[i];
    }
    for (int i = 0; i < inputs; i++) {
        for (int j = i; j < inputs; j++) {
            term[k++] = x[i] * x[j];
        }
    }
}

/* --- fit ---------------------------------------------------------------------------------------- */

typedef struct fit {
    size_t n, p;
    gsl_matrix *terms, *covariance;
    gsl_vector *y, *weight, *coefficient;
    gsl_multifit_linear_workspace *work;
    const double *error;
} fit;

static void release(fit *f)
{
    gsl_multifit_linear_free(f->work);
    gsl_matrix_free(f->terms);
    gsl_matrix_free(f->covariance);
    gsl_vector_free(f->y);
    gsl_vector_free(f->weight);
    gsl_vector_free(f->coefficient);
}

static int reserve(fit *f)
{
    f->terms = gsl_matrix_alloc(f->n, f->p);
    f->covariance = gsl_matrix_alloc(f->p, f->p);
    f->y = gsl_vector_alloc(f->n);
    f->weight = gsl_vector_alloc(f->n);
    f->coefficient = gsl_vector_alloc(f->p);
    f->work = gsl_multifit_linear_alloc(f->n, f->p);
    return f->terms && f->covariance && f->y && f->weight && f->coefficient && f->work;
}

/* chi^2 with so much variance beyond the errors; negative: the terms are not spanned. */
static double solve(fit *f, double extra)
{
    double chi2;
    size_t rank;
    for (size_t k = 0; k < f->n; k++) {
        gsl_vector_set(f->weight, k, 1.0 / (f->error[k] * f->error[k] + extra));
    }
    const int status = gsl_multifit_wlinear_tsvd(f->terms, f->weight, f->y, 1e-10, f->coefficient, f->covariance,
                                                 &chi2, &rank, f->work);
    return status == GSL_SUCCESS && rank == f->p ? chi2 : -1.0;
}

static double find_extra(fit *f)
{
    const double freedom = (double)(f->n - f->p);
    double low = 0.0, high = 1e-8;
    if (solve(f, 0.0) <= freedom) {
        return 0.0;
    }
    while (solve(f, high) > freedom && high < 1e6) {
        low = high;
        high *= 4.0;
    }
    for (int k = 0; k < 40; k++) {
        const double middle = 0.5 * (low + high);
        *(solve(f, middle) > freedom ? &low : &high) = middle;
    }
    return high;
}

/* Without point k the surface is off there by r/(1 - h), h = w t' C t. */
static double left_out(const fit *f, const ry_response *r)
{
    double sum = 0.0;
    for (size_t k = 0; k < f->n; k++) {
        double value = 0.0, h = 0.0;
        for (size_t i = 0; i < f->p; i++) {
            const double t = gsl_matrix_get(f->terms, k, i);
            value += r->coefficient[i] * t;
            for (size_t j = 0; j < f->p; j++) {
                h += t * r->covariance[i][j] * gsl_matrix_get(f->terms, k, j);
            }
        }
        const double off =
            (gsl_vector_get(f->y, k) - value) / fmax(1.0 - h * gsl_vector_get(f->weight, k), 1e-3);
        sum += off * off;
    }
    return sqrt(sum / (double)f->n);
}

static ry_status fit_terms(fit *f, ry_response *r, int n, const double *x, const double *y, ry_error *failure)
{
    for (int k = 0; k < n; k++) {
        double term[RY_RESPONSE_TERMS];
        terms_of(r->inputs, x + (ptrdiff_t)k * r->inputs, term);
        for (size_t i = 0; i < f->p; i++) {
            gsl_matrix_set(f->terms, (size_t)k, i, term[i]);
        }
        gsl_vector_set(f->y, (size_t)k, y[k]);
    }
    if (solve(f, 0.0) < 0.0) {
        return ry_fail(failure, RY_BAD_INPUT, "%d points do not tell the %d terms of a quadratic surface", n,
                       r->terms);
    }
    const double extra = find_extra(f);
    solve(f, extra);
    r->unfit = sqrt(extra);
    for (size_t i = 0; i < f->p; i++) {
        r->coefficient[i] = gsl_vector_get(f->coefficient, i);
        for (size_t j = 0; j < f->p; j++) {
            r->covariance[i][j] = gsl_matrix_get(f->covariance, i, j);
        }
    }
    r->cross = left_out(f, r);
    return RY_OK;
}

ry_status ry_response_fit(ry_response *r, int inputs, int n, const double *x, const double *y,
                          const double *error, ry_error *failure)
{
    *r = (ry_response){.inputs = inputs, .terms = ry_response_terms(inputs)};
    if (n < r->terms + 1) {
        return ry_fail(failure, RY_BAD_INPUT, "%d points are too few for a quadratic surface of %d terms; it takes %d",
                       n, r->terms, r->terms + 1);
    }
    gsl_error_handler_t *const old = gsl_set_error_handler_off();
    fit f = {.n = (size_t)n, .p = (size_t)r->terms, .error = error};
    const ry_status status =
        reserve(&f) ? fit_terms(&f, r, n, x, y, failure) : ry_no_memory(failure, (size_t)n * sizeof(double));
    release(&f);
    gsl_set_error_handler(old);
    return status;
}

/* --- values ------------------------------------------------------------------------------------- */

double ry_response_value(const ry_response *r, const double *x, double *variance)
{
    double term[RY_RESPONSE_TERMS], value = 0.0, spread = 0.0;
    terms_of(r->inputs, x, term);
    for (int i = 0; i < r->terms; i++) {
        value += r->coefficient[i] * term[i];
    }
    if (variance != NULL) {
        for (int i = 0; i < r->terms; i++) {
            double row = 0.0;
            for (int j = 0; j < r->terms; j++) {
                row += r->covariance[i][j] * term[j];
            }
            spread += term[i] * row;
        }
        *variance = fmax(spread, 0.0) + r->unfit * r->unfit;
    }
    return value;
}

void ry_response_slope(const ry_response *r, const double *x, double *slope)
{
    int k = 1 + r->inputs;
    memcpy(slope, r->coefficient + 1, (size_t)r->inputs * sizeof *slope);
    for (int i = 0; i < r->inputs; i++) {
        for (int j = i; j < r->inputs; j++, k++) {
            slope[i] += r->coefficient[k] * x[j];
            slope[j] += r->coefficient[k] * x[i];
        }
    }
}

/* --- where to run ------------------------------------------------------------------------------- */

void ry_design_point(int inputs, int index, unsigned seed, double *x)
{
    double point[RY_RESPONSE_INPUTS] = {0};
    gsl_qrng *const sobol = gsl_qrng_alloc(gsl_qrng_sobol, (unsigned)inputs);
    for (int k = 0; k <= index && sobol != NULL; k++) {
        gsl_qrng_get(sobol, point);
    }
    gsl_qrng_free(sobol);
    for (int i = 0; i < inputs; i++) {
        const double shifted = point[i] + ry_random(seed, RY_RANDOM_SAMPLE, (uint64_t)i);
        x[i] = 2.0 * (shifted - floor(shifted)) - 1.0;
    }
}
