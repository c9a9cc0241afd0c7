/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa threshold`: the Shields numbers at which a bed at rest begins to move, and at which a moving
 * one XX at some Shields number if its mean q* over the second half of the time with the fluid on
 * is at least `criterion`. A trial ends early when that is certain, or when a stretch of a tenth of the
 * time (at least 0.5 s) had a mean |q*| below a tenth of the criterion: the bed is at rest. */
#ifndef RY_STUDY_THRESHOLD_H
#define RY_STUDY_THRESHOLD_H

#include "ryusa/ryusa.h"

enum { RY_THRESHOLD_REST, RY_THRESHOLD_MOTION, RY_THRESHOLD_STARTS };

typedef struct ry_threshold_options {
    const char *scene;
    const char *const *overrides;
    int n_overrides;
    const char *output; /* HDF5 file; NULL: none */
    int force;
    int cores;        /* 0: all that this process may use */
    int replicas;     /* beds for each start, with consecutive grains.seed */
    double low, high; /* Shields numbers between which the threshold lies */
    double tolerance; /* width of the last bracket */
    double criterion; /* q* */
    int fresh; /* from rest without the push: the bed as it has settled from its lattice */
    /* Now and then, from any thread, one at a time. A return other than 0 asks to stop. */
    int (*progress)(void *data, int trials, int most_trials);
    void *data;
} ry_threshold_options;

/* 0.01 to 0.4 within 0.002, four replicas, q* of 1e-4. */
ry_threshold_options ry_threshold_options_default(void);

typedef struct ry_threshold_side {
    double mean, standard_error;
    double low, high; /* 95 % confidence interval; NAN with one replica */
} ry_threshold_side;

typedef struct ry_threshold_result {
    ry_threshold_side side[RY_THRESHOLD_STARTS];
    ry_threshold_side difference; /* from rest minus from motion, over the same beds */
    int trials;
    double d_star, seconds;
    double literature[8]; /* thresholds of analysis/relations.h at this D*, in its order */
    const char *literature_name[8];
    int n_literature;
} ry_threshold_result;

/* RY_BAD_INPUT: no fluid, options out of range, or the threshold is not between low and high. */
ry_status ry_threshold_find_motion(const ry_threshold_options *options, ry_threshold_result *result,
                                   ry_error *error);

#endif
