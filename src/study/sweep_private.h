/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What sweep.c and sweep_table.c share. Case k is replica k mod R of point k / R. */
#ifndef RY_STUDY_SWEEP_PRIVATE_H
#define RY_STUDY_SWEEP_PRIVATE_H

#include "study/sweep.h"
#include "study/sweep_file.h"
#include "study/sweep_store.h"

typedef struct ry_sweep_case {
    int mine; /* of this shard */
    int todo;
    double work; /* grains x steps */
    ry_case_record record;
} ry_sweep_case;

typedef struct ry_sweep_run {
    const ry_sweep_options *options;
    ry_sweep_result *result;
    ry_error *error;
    ry_sweep_file file;
    ry_sweep_store store;
    ry_config base; /* the scene with what the sweep sets and -s */
    ry_sweep_case *cases;
    int n_cases;
    int threads;  /* of a case */
    int stopping; /* the user asked for it */
    int broken;   /* a record could not be written */
    double started, work_all, work_before, work_ended;
    int n_mine, n_ended, n_failed;
} ry_sweep_run;

/* "fluid.shields=0.2, grains.seed=1"; the caller frees it. NULL without memory. */
char *ry_sweep_case_text(const ry_sweep_run *run, int index);

/* The scene of a case. RY_BAD_INPUT if it is refused. */
ry_status ry_sweep_case_config(const ry_sweep_run *run, int index, ry_config *config,
                               ry_error *error);

/* The sweep as lines "key = value", to be compared at --resume; the caller frees it. NULL without memory. */
char *ry_sweep_describe(const ry_sweep_run *run);

/* Writes OUT.h5 from the records of all cases. */
ry_status ry_sweep_table_write(const ry_sweep_run *run, ry_error *error);

#endif
