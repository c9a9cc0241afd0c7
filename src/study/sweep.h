/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa sweep`: many runs of one scene with some keys varied. OUT.d/ holds the runs, case-0001.h5 and
 * so on, as `ryusa run` makes them; OUT.h5 the table of them. */
#ifndef RY_STUDY_SWEEP_H
#define RY_STUDY_SWEEP_H

#include "ryusa/ryusa.h"
#include "study/farm.h"

typedef struct ry_sweep_progress {
    int cases, ended, failed, running; /* of this call's share of the cases */
    double share;                      /* of the work, 0..1 */
    double seconds_left;               /* NAN: not known yet */
    const char *news;                  /* a line about a case that has just ended; NULL: none */
    int checked; /* cases, before any is begun, when nothing else is known; 0: this is over */
} ry_sweep_progress;

typedef struct ry_sweep_options {
    const char *sweep;            /* file */
    const char *output;           /* OUT.h5 */
    const char *const *overrides; /* "key=value", over what the sweep sets */
    int n_overrides;
    int cores; /* 0: all that this process may use */
    int resume, force;
    int merge;           /* no runs: makes the table of what is there */
    int shard, shards;   /* 1..shards: every shards-th case; shards 0: all */
    const ry_farm *farm; /* the processes that share the cases; NULL: this one does all */
    /* As in ry_run_options; about ten times a second. */
    int (*progress)(void *data, const ry_sweep_progress *progress);
    void *data;
} ry_sweep_options;

typedef struct ry_sweep_result {
    int cases, done, failed, missing; /* of all; missing: not run yet */
    int shard_cases;                  /* of these were this call's */
    int table;                        /* 1: OUT.h5 was written */
    int gone; /* 1: another process of the farm is, so that all can't take leave of each other */
    double seconds;
    char failure[700]; /* the first case that failed, and why */
} ry_sweep_result;

/* With a farm: called by all of its processes, with the same options. The result and the news are those
 * of process 0; the others return RY_OK when they are sent home, whatever has become of the cases, or
 * RY_STOPPED if process 0 is gone.
 *
 * RY_OK if every case is done (of a shard: its own), RY_UNPHYSICAL if some failed: the others are done
 * and the table is written. RY_STOPPED: saved. */
ry_status ry_sweep(const ry_sweep_options *options, ry_sweep_result *result, ry_error *error);

#endif
