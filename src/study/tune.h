/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Harada, Gotoh & Sakai's way to the constants of a movable bed, automated: alpha_m and alpha_cn
 * from settling lattices, then beta from the flux against a target; or any constants together
 * (docs/tune.md). */
#ifndef RY_STUDY_TUNE_H
#define RY_STUDY_TUNE_H

#include "ryusa/ryusa.h"

/* What is shown while it goes on: the step and how many of its simulations are done. */
typedef struct ry_tune_progress {
    const char *what;
    int done, all;
    double seconds_left; /* of this step; NAN: not known yet */
} ry_tune_progress;

typedef struct ry_tune_options {
    const char *scene;  /* scene file */
    const char *output; /* OUT.h5; the tuned scene goes to OUT.yaml beside it */
    const char *target; /* key of a relation, or a CSV file */
    const char *const *overrides;
    int n_overrides;
    int threads; /* simulations at a time, 0: as many as there are cores */
    int resume, force;
    int quick;                                   /* a few candidates, short runs: to try it out */
    int joint; /* fit constants together instead of in four steps: `vary`, or the usual five */
    const char *const *vary; /* "contact.friction=0.2:0.8" */
    int n_vary;
    int budget; /* candidates of the joint fit; 0: three for each term of its surfaces */
    void (*write)(void *data, const char *text); /* the report, piece by piece */
    void (*progress)(void *data,
                     const ry_tune_progress *progress); /* never from two threads at once */
    int (*stop)(void *data); /* asked from any thread; not 0: save and return RY_STOPPED */
    void *data;
} ry_tune_options;

/* RY_BAD_INPUT: scene or target; RY_BAD_FILE; RY_STOPPED: what is done is kept for `resume`. */
ry_status ry_tune(const ry_tune_options *options, ry_error *error);

#endif
