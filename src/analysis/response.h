/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Response surfaces: what noisy simulations say about y(x) between the points that were run,
 *
 *     y = b0 + sum b_i x_i + sum b_ij x_i x_j,     x in [-1, 1]^n,
 *
 * with the error of that (Box & Draper 2007). And what several such y, which should all be 0, say about
 * x: the best x, an interval for each x_i by profile likelihood, and the directions that the y do not
 * see. Uses GSL (least squares, eigenvalues) and NLopt (bounded minimisation). */
#ifndef RY_ANALYSIS_RESPONSE_H
#define RY_ANALYSIS_RESPONSE_H

#include "ryusa/status.h"

enum {
    RY_RESPONSE_INPUTS = 6,
    RY_RESPONSE_TERMS = 28, /* of a quadratic in so many inputs */
    RY_RESPONSE_OUTPUTS = 8,
    RY_RESPONSE_PROFILE = 41
};

typedef struct ry_response {
    int inputs, terms;
    double coefficient[RY_RESPONSE_TERMS]; /* 1, x_i, then x_i x_j with i <= j, j fastest */
    double covariance[RY_RESPONSE_TERMS][RY_RESPONSE_TERMS];
    double unfit; /* what the points are off beyond their errors: noise not told, or no quadratic */
    double cross; /* rms off by points that were left out of the fit one at a time */
} ry_response;

/* Terms of a quadratic in so many inputs. */
int ry_response_terms(int inputs);

/* x: n rows of `inputs`; error: standard errors, above 0. RY_BAD_INPUT with fewer points than terms + 1
 * or points that don't span the terms. */
ry_status ry_response_fit(ry_response *r, int inputs, int n, const double *x, const double *y,
                          const double *error, ry_error *failure);

/* y at x; *variance (NULL: not asked): of the surface there, `unfit` included. */
double ry_response_value(const ry_response *r, const double *x, double *variance);
void ry_response_slope(const ry_response *r, const double *x, double *slope);

/* Several y, each measured with response[k], known to be 0 with variance[k] (that of the target). */
typedef struct ry_aim {
    int inputs, outputs;
    ry_response response[RY_RESPONSE_OUTPUTS];
    double variance[RY_RESPONSE_OUTPUTS]; /* above 0 */
} ry_aim;

/* -2 ln likelihood of x: sum of y^2/V + ln(V/variance), V = variance + that of the surface. */
double ry_aim_misfit(const ry_aim *aim, const double *x);

typedef struct ry_verdict {
    double best[RY_RESPONSE_INPUTS], misfit;
    double chi2;      /* sum of y^2/V there */
    double threshold; /* of 95 %: 3.84, times chi2 per output where that is above 1 */
    /* For each input the least misfit with it fixed at evenly spaced values from -1 to 1. */
    double profile[RY_RESPONSE_INPUTS][RY_RESPONSE_PROFILE];
    double low[RY_RESPONSE_INPUTS], high[RY_RESPONSE_INPUTS]; /* 95 %; -1, 1 where not bounded */
    /* Eigenvalues (descending) and unit vectors of the Fisher information at the best x; how much the
     * misfit rises along each, within the bounds; flat: by less than the threshold. */
    double value[RY_RESPONSE_INPUTS], vector[RY_RESPONSE_INPUTS][RY_RESPONSE_INPUTS];
    double rise[RY_RESPONSE_INPUTS];
    int flat[RY_RESPONSE_INPUTS];
} ry_verdict;

ry_status ry_aim_judge(const ry_aim *aim, ry_verdict *verdict, ry_error *failure);

/* Point `index` of a sequence that fills [-1, 1]^inputs evenly however many points are taken (Sobol's,
 * shifted by `seed`). */
void ry_design_point(int inputs, int index, unsigned seed, double *x);

#endif
