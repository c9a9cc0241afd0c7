/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The oscillation that a series rings down with: natural frequency and damping ratio. */
#ifndef RY_ANALYSIS_SPECTRUM_H
#define RY_ANALYSIS_SPECTRUM_H

#include <stdint.h>

#include "ryusa/status.h"

typedef struct ry_ringing {
    double frequency;  /* of the highest peak of the spectrum [1/spacing]; NAN: there is none */
    double damping;    /* ratio, from the width of that peak at half its power; NAN: unknown */
    double resolution; /* of the frequency: 1/length of the series [1/spacing] */
} ry_ringing;

/* The series x[0..n-1] less its last value. The peak must stand above its neighbours and fall to half
 * its power, so an approach without oscillation has none. Not from two threads at once.
 * RY_BAD_FILE: no memory. */
ry_status ry_spectrum_ringing(const double *x, int64_t n, ry_ringing *out, ry_error *error);

#endif
