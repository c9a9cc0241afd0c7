/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Grains that lie in each other at the start. */
#ifndef RY_CONFIG_OVERLAP_H
#define RY_CONFIG_OVERLAP_H

#include "ryusa/status.h"

/* Of the smaller diameter: grains of a bed at rest lie in each other by a thousandth or so, those of one that flows
 * by a few hundredths, and a scene may begin where another ended. */
#define RY_MOST_OVERLAP 0.05

typedef struct ry_disc {
    double x, z, radius; /* [m] */
    int fixed;           /* two that are fixed may overlap */
} ry_disc;

typedef struct ry_overlap {
    int first, second;   /* first < second; -1, -1: none */
    double depth, most;  /* what it is and what would be allowed [m] */
} ry_overlap;

/* Two of the n discs that overlap by more than RY_MOST_OVERLAP. `between` > 0: only of one below that index and one
 * from there on. `length` > 0: x is periodic. Errors: out of memory. */
ry_status ry_overlap_find(const ry_disc *discs, int n, int between, double length, ry_overlap *found, ry_error *error);

#endif
