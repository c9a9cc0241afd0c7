/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa relations`: the bed-load relations and the thresholds of motion, as a table for people and as
 * CSV for programs. */
#ifndef RY_STUDY_CURVES_H
#define RY_STUDY_CURVES_H

#include "ryusa/ryusa.h"

typedef struct ry_curves_options {
    const char *const *names; /* relations or CSV files; none: every relation */
    int n_names;
    const char
        *theta; /* "0.05,0.1,0.2", or "0.05:1:20" (20 values, evenly), "0.05:1:20:log"; NULL: ten */
    const char *diameter, *density, *fluid_density,
        *viscosity;     /* with units; NULL: as in flume.yaml */
    const char *csv;    /* file to export to, "-": to `write` in place of the page; NULL: none */
    int force;          /* replace csv if it is there */
    ry_write_fn *write; /* gets the page, piece by piece */
    void *data;
} ry_curves_options;

/* RY_BAD_INPUT names the option and what is allowed. */
ry_status ry_curves(const ry_curves_options *options, ry_error *error);

#endif
