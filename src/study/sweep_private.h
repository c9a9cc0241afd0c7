/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What sweep.c, sweep_cases.c, sweep_farm.c and sweep_table.c share. Case k is replica k mod R of point k / R. */
#ifndef RY_STUDY_SWEEP_PRIVATE_H
#define RY_STUDY_SWEEP_PRIVATE_H

#include "study/pool.h"
#include "study/sweep.h"
#include "study/sweep_file.h"
#include "study/sweep_store.h"

/* What makes a table, see ry_table_file_create. */
#define RY_SWEEP_PROGRAM "ryusa sweep"

typedef struct ry_sweep_case {
    int mine; /* of this shard */
    int todo;
    double work; /* grains x steps */
    ry_case_record record;
} ry_sweep_case;

typedef struct ry_sweep_farm ry_sweep_farm;

typedef struct ry_sweep_run {
    const ry_sweep_options *options;
    ry_sweep_result *result;
    ry_error *error;
    ry_sweep_file file;
    ry_sweep_store store;
    ry_config base; /* the scene with what the sweep sets and -s */
    ry_sweep_case *cases;
    int n_cases;
    int *queue; /* cases that are still to be begun, from `head` to n_queue; owned */
    int head, n_queue;
    ry_sweep_farm *farm; /* what process 0 knows of the others; NULL: there are none */
    int threads;         /* of a case */
    int stopping;        /* the user asked for it */
    int broken;          /* a record could not be written */
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

/* --- sweep_cases.c --- */

/* Runs what is to be done, on this process and on the others of its farm. RY_STOPPED: saved. */
ry_status ry_sweep_cases_run(ry_sweep_run *run);

/* In a process of its own: runs a case and leaves its record. `run` is a ry_sweep_run. */
int ry_sweep_cases_work(void *run, int index, ry_pool_worker *worker);

/* The record of a case that would not run. */
ry_case_record ry_sweep_cases_refused(const ry_error *error);

/* The next case of the queue; -1: there is none, or no more are to be begun. */
int ry_sweep_cases_take(ry_sweep_run *run);
/* It has not been done: it is the next one. */
void ry_sweep_cases_put_back(ry_sweep_run *run, int index);

/* A case's process has ended, as in ry_pool; `record`: what it left, if it left one. */
void ry_sweep_cases_end(ry_sweep_run *run, int index, int exit_code, int killed_by,
                        const ry_case_record *record);

/* Counts a case that has ended, and says so if it is new. */
void ry_sweep_cases_count(ry_sweep_run *run, int index, int is_new);

void ry_sweep_cases_say(ry_sweep_run *run, const char *news);

/* --- sweep_farm.c --- */

/* In process 0. Without memory NULL. */
ry_sweep_farm *ry_sweep_farm_create(const ry_farm *wire, int n_cases);
void ry_sweep_farm_free(ry_sweep_farm *farm);
/* Answers what the others have asked, and notices who is gone. */
void ry_sweep_farm_turn(ry_sweep_run *run);
/* Cases that the others have; adds what they run, and its work, to the two. */
int ry_sweep_farm_count(const ry_sweep_run *run, int *running, double *work);
/* Sends all others home, waiting until they have saved; nothing is begun any more. */
void ry_sweep_farm_dismiss(ry_sweep_run *run);

/* In the others: runs cases until it is sent home. `status` and run->error: what became of reading the
 * sweep, which process 0 is told; it reads the same files. */
ry_status ry_sweep_farm_work(ry_sweep_run *run, const char *description, ry_status status);

/* --- sweep_table.c --- */

/* Writes OUT.h5 from the records of all cases. */
ry_status ry_sweep_table_write(const ry_sweep_run *run, ry_error *error);

#endif
