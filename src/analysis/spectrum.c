/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A decaying oscillation exp(-zeta w t) cos(w t) has a Lorentzian power spectrum around f = w/2 pi,
 * whose full width at half power is 2 zeta f (zeta small). The series begins with the oscillation and
 * ends at rest, so it needs no window: what is cut off at its end is zero. It is padded with zeros
 * until the width is resolved. */
#include "analysis/spectrum.h"

#include <complex.h>
#include <fftw3.h>
#include <math.h>

#include "analysis/planner.h"
#include "base/memory.h"

enum { PADDING = 8 };

static double power_at(fftw_complex *spectrum, int64_t k)
{
    const double re = creal(spectrum[k]), im = cimag(spectrum[k]);
    return re * re + im * im;
}

/* The highest local maximum; 0: there is none. */
static int64_t find_peak(fftw_complex *spectrum, int64_t n)
{
    int64_t peak = 0;
    for (int64_t k = 1; k + 1 < n; k++) {
        const double here = power_at(spectrum, k);
        if (here > power_at(spectrum, k - 1) && here >= power_at(spectrum, k + 1) &&
            (peak == 0 || here > power_at(spectrum, peak))) {
            peak = k;
        }
    }
    return peak;
}

/* Where the power has fallen to half, going from the peak in steps of `way`; NAN: it rises first. */
static double half_point(fftw_complex *spectrum, int64_t n, int64_t peak, int way)
{
    const double half = 0.5 * power_at(spectrum, peak);
    for (int64_t k = peak; k > 0 && k + 1 < n; k += way) {
        const double here = power_at(spectrum, k), next = power_at(spectrum, k + way);
        if (next > here) {
            return NAN;
        }
        if (next <= half) {
            return (double)k + way * (here - half) / (here - next);
        }
    }
    return NAN;
}

ry_status ry_spectrum_ringing(const double *x, int64_t n, ry_ringing *out, ry_error *error)
{
    *out = (ry_ringing){NAN, NAN, n > 0 ? 1.0 / (double)n : NAN};
    const int64_t padded = PADDING * n, bins = padded / 2 + 1;
    if (n < 8) {
        return RY_OK;
    }
    double *const value = fftw_alloc_real((size_t)padded);
    fftw_complex *const spectrum = fftw_alloc_complex((size_t)bins);
    ry_status status = RY_OK;
    if (value == NULL || spectrum == NULL) {
        status = ry_no_memory(error, (size_t)padded * sizeof(double));
    } else {
        ry_planner_take();
        const fftw_plan plan = fftw_plan_dft_r2c_1d((int)padded, value, spectrum, FFTW_ESTIMATE);
        ry_planner_leave();
        for (int64_t k = 0; k < padded; k++) {
            value[k] = k < n ? x[k] - x[n - 1] : 0.0;
        }
        fftw_execute(plan);
        ry_planner_take();
        fftw_destroy_plan(plan);
        ry_planner_leave();
        const int64_t peak = find_peak(spectrum, bins);
        if (peak > 0) {
            const double left = half_point(spectrum, bins, peak, -1);
            const double right = half_point(spectrum, bins, peak, 1);
            /* One side is enough: the fall into the trough of lower frequencies may hide the other. */
            const double width = isnan(left) ? 2.0 * (right - (double)peak) : right - left;
            out->damping = width / 2.0 / (double)peak;
            out->frequency = (double)peak / (double)padded;
            if (!(out->damping < 1.0)) { /* wider than itself: it creeps */
                out->frequency = out->damping = NAN;
            }
        }
    }
    fftw_free(value);
    fftw_free(spectrum);
    return status;
}
