/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The result file (H5MD 1.1), written while a run goes on. The file is OUT.h5.part until
 * ry_result_finish renames it to OUT.h5. Frames and samples are collected in memory and appended by
 * ry_result_flush, which opens, appends and closes, so that at any other moment the file on disk is
 * whole and any reader can open it. HDF5 is used by one thread at a time: by the writer, or, when it is
 * idle, by the caller. The only module that knows HDF5, with io/checkpoint.c. */
#ifndef RY_IO_RESULT_H
#define RY_IO_RESULT_H

#include "ryusa/config.h"
#include "ryusa/ryusa.h"
#include "store/state.h"

typedef struct ry_result ry_result;

/* More rows in memory than this are written without being asked [bytes]. As much may be on its way to the file. */
enum { RY_RESULT_BYTES = 8 << 20 };

/* Profiles over height, averaged over the steps since the last frame; every array nz long. tau_* are
 * the stresses on the horizontal planes through the cell centres. */
typedef struct ry_profile {
    int nz;
    double dz;
    double *phi, *u_grain, *u_fluid, *tau_fluid, *tau_grain;
} ry_profile;

/* What the head of the file tells about the flux; /observables/flux and /observables/profile. */
typedef struct ry_summary {
    double q_star_mean, q_star_standard_error, autocorrelation_time, equilibration_time;
    long long samples;
    double effective_samples;         /* independent ones */
    const char *equilibration_method; /* one sentence */
    double shields, shear_stress;     /* asked for [1, Pa] */
    double width;                     /* of the slab that the grains fill, the mean diameter of those that move [m] */
    int stopped_early;
    int is_dry;          /* the unit of q* is that without a fluid */
    int has_profile;     /* with the mean of the profiles of the frames after `profile_from` [s] */
    double profile_from;
} ry_summary;

/* What a run cost; /cost. */
typedef struct ry_cost {
    double wall_seconds, grain_steps_per_second;
    double asleep; /* mean part of the grains that can move; NAN: nobody may sleep */
    long long rebuilds;
    int threads;
    int n_stages;
    const char *stage_name[24];
    double stage_seconds[24];
} ry_cost;

/* Begins OUT.h5.part. Checks first that OUT.h5 can be made: not a directory, folder writable, not
 * there already unless `force`; the old OUT.h5 stays until ry_result_finish. RY_BAD_FILE otherwise. */
ry_status ry_result_create(ry_result **result, const char *path, const ry_config *config,
                           const ry_state *state, int force, ry_error *error);

/* Goes on with OUT.h5.part, or with a finished OUT.h5 whose time.end has grown (it is copied to
 * OUT.h5.part first). Fills `state` from the newest whole checkpoint and cuts the series and frames
 * behind it. `*found`: 0 there is nothing to resume from (no file, or killed before its first
 * checkpoint: start anew), 1 resumed, 2 finished already. Errors: RY_BAD_FILE if it is not ours or damaged;
 * RY_BAD_INPUT if its scene differs from `config` (the keys that differ, both values; time.end,
 * output.checkpoint, stop.*, numerics.* may differ). */
ry_status ry_result_resume(ry_result **result, const char *path, const ry_config *config,
                           ry_state *state, int *found, ry_error *error);

/* Buffers. A frame is taken when step is a multiple of steps_frame, a sample of steps_series. */
ry_status ry_result_frame(ry_result *result, const ry_state *state, ry_error *error);
ry_status ry_result_profile(ry_result *result, const ry_state *state, const ry_profile *profile, ry_error *error);
ry_status ry_result_sample(ry_result *result, const ry_state *state, const ry_sample *sample, ry_error *error);

/* The buffered q_star series from the start of the run (also what was read at resume), for the analysis. */
const double *ry_result_flux_series(const ry_result *result, int64_t *n);

/* Summary and cost go into the file with the next flush. */
void ry_result_summary(ry_result *result, const ry_summary *summary, const ry_cost *cost);

/* Numbers that the next checkpoint shall hold beside the state (n = 0: none), and those of the checkpoint that was
 * resumed from: what is measured over a while, and not finished. */
ry_status ry_result_put_window(ry_result *result, const double *values, int64_t n, ry_error *error);
const double *ry_result_get_window(const ry_result *result, int64_t *n);

/* Appends the buffers to the file. With `checkpoint` also writes a copy of the state, into the older of two
 * slots, so that a kill at any moment leaves one whole. A thread of its own does it, while the caller goes
 * on: what came of it is told by the next call, or by ry_result_wait. Waits if the last flush goes on still. */
ry_status ry_result_flush(ry_result *result, const ry_state *checkpoint, ry_error *error);
int ry_result_is_busy(const ry_result *result);
ry_status ry_result_wait(ry_result *result, ry_error *error);

/* Flushes with a checkpoint, renames to OUT.h5, writes OUT.xdmf beside it, frees. */
ry_status ry_result_finish(ry_result *result, const ry_state *state, ry_error *error);
/* Frees without renaming: OUT.h5.part stays as it was last flushed. */
void ry_result_close(ry_result *result);

/* Writes what the file at `path` holds, in words and numbers. */
ry_status ry_result_describe(const char *path, ry_write_fn *write, void *data, ry_error *error);

/* Numbers of /observables/flux (NAN and 0 where the file has none; no profile, no method) and the hash
 * of the last state saved: what a run that was finished already had found. */
ry_status ry_result_read_summary(const char *path, ry_summary *summary, unsigned long long *hash,
                                 ry_error *error);

#endif
