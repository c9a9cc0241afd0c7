/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Jobs in processes of their own, a few at a time. A job that crashes takes nothing else with it, and
 * HDF5, which is not made for threads, is never shared. The caller must not have used OpenMP before. */
#ifndef RY_STUDY_POOL_H
#define RY_STUDY_POOL_H

#include "ryusa/status.h"

/* What a job sees of the pool: it tells how far it is, 0..1, and is asked to stop. */
typedef struct ry_pool_worker ry_pool_worker;
void ry_pool_tell(ry_pool_worker *worker, double share);
int ry_pool_must_stop(void);

/* What `next` returns when there is no job: ask again, or there will be none any more. */
enum { RY_POOL_WAIT = -1, RY_POOL_END = -2 };

typedef struct ry_pool {
    int workers; /* jobs at a time */
    void *data;
    /* In the parent, for a worker that is idle: the job that is to be begun, 0 or above. */
    int (*next)(void *data);
    /* In the child: does the job; the return is the child's exit code, 0..255. */
    int (*work)(void *data, int job, ry_pool_worker *worker);
    /* In the parent, when a child has ended: its exit code, or the signal (above 0) that killed it. */
    void (*ended)(void *data, int job, int exit_code, int killed_by);
    /* In the parent, about ten times a second: jobs that run and the shares that they told. A return
     * other than 0 asks all of them to stop; `next` must see to it that no more are begun. */
    int (*look)(void *data, int n_running, const int *job, const double *share);
    /* In the parent, about a hundred times a second; NULL: nothing. */
    void (*turn)(void *data);
} ry_pool;

/* RY_OK when `next` has no more and all have ended, RY_BAD_FILE if no process can be made,
 * or if nobody tells how one has ended (SIGCHLD is ignored): its job is RY_STOPPED. Children that lose
 * their parent are asked to stop as well. */
ry_status ry_pool_run(const ry_pool *pool, ry_error *error);

/* Cores that this process may use: of its affinity, at most SLURM_CPUS_PER_TASK. */
int ry_pool_cores(void);

#endif
