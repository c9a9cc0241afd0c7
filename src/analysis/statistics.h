/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Statistics of a correlated, stationary-in-the-end series. The only module that knows FFTW, with
 * analysis/spectrum.c. Errors of memory are RY_BAD_FILE as everywhere. */
#ifndef RY_ANALYSIS_STATISTICS_H
#define RY_ANALYSIS_STATISTICS_H

#include <stdint.h>

#include "ryusa/status.h"

/* Fewer effective samples do not tell how well a mean is known: a run that is to end when its error is small enough
 * then ends when the error is underestimated most. */
#define RY_SERIES_ENOUGH 20.0

typedef struct ry_series_statistics {
    double mean;
    double standard_error;       /* of the mean, from the integrated autocorrelation time */
    double autocorrelation_time; /* integrated, tau_int = 1/2 + sum rho_k, in samples; 0.5 = uncorrelated */
    int64_t first;               /* samples before this one were cut */
    int64_t samples;             /* behind the cut */
    double effective_samples;    /* samples / (2 tau_int) */
} ry_series_statistics;

/* How many samples of a flux, at most half of them, come before it is under way. One that begins above the mean of its
 * second half, as behind the push of a start from motion, has come down to it; one that begins at rest has gone up to
 * it, and come down again from what is more (only if it never falls below half of that mean later: what moves now and
 * then begins at rest each time). The cut below does not see such a beginning where it is short beside the time in
 * which the series changes. */
int64_t ry_series_under_way(const double *x, int64_t n);

/* Mean and standard error of x[0..n-1] without a cut. */
ry_status ry_series_mean(const double *x, int64_t n, ry_series_statistics *out, ry_error *error);

/* The same behind an equilibration cut that is found: the one which leaves the most effective samples
 * (Chodera 2016, J. Chem. Theory Comput. 12, 1799), never more than half of the series. The error counts that such a
 * cut is chosen by the same noise. */
ry_status ry_series_equilibrated(const double *x, int64_t n, ry_series_statistics *out, ry_error *error);

#endif
