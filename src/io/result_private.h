/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the files of a result share among themselves: the open result, and the parts of the file that
 * have a source file of their own. Calls that return int return 0, or -1 on failure. */
#ifndef RY_IO_RESULT_PRIVATE_H
#define RY_IO_RESULT_PRIVATE_H

#include "io/h5.h"
#include "io/result.h"
#include "io/table.h"
#include "io/writer.h"

/* Raised when a file written before can't be understood any more. */
enum { RY_FILE_FORMAT = 1 };

typedef struct ry_rows {
    ry_table frames, profiles, series;
} ry_rows;

/* What is on its way to the file. The writer's while it is busy. */
typedef struct ry_batch {
    ry_rows rows;
    const ry_state *checkpoint; /* NULL: none is written; mostly `copy` */
    ry_state copy;
    double *window; /* see ry_result_put_window */
    int64_t n_window;
    int has_summary, finished;
    ry_summary summary;
    ry_cost cost;
} ry_batch;

/* Of what a batch needs, the writer may look at what never changes, and has for itself: mean, slot, sequence,
 * broken. */
struct ry_result {
    char *path, *part; /* OUT.h5, OUT.h5.part */
    int fd;            /* of part: holds the lock as long as it is open */
    int replace;       /* OUT.h5 may be overwritten at the end */
    int broken;        /* a flush failed: nothing more is written */
    unsigned fields;   /* RY_FIELD_... */
    int periodic;
    int32_t n;  /* grains */
    int32_t nz; /* cells of the profiles, 0: none so far */
    double dz;  /* their height [m] */
    ry_rows rows;      /* being collected */
    ry_batch batch;
    ry_writer *writer; /* NULL: none was needed so far, or no thread can be had */
    int has_summary;   /* for the next batch */
    ry_summary summary;
    ry_cost cost;
    double *window;    /* for the next checkpoint */
    int64_t n_window;
    double *mean; /* the mean profiles */
    double *flux; /* q_star of all samples */
    size_t n_flux, flux_capacity;
    int slot;         /* checkpoint that is whole: 0 a, 1 b, -1 none */
    int64_t sequence; /* its number */
};

/* result.c */
ry_result *ry_result_new(const char *path, const ry_config *config, const ry_state *state,
                         ry_error *error);
void ry_result_add_profiles(ry_result *result, int32_t nz);
/* summary.c: writes summary and cost of the batch. */
int ry_result_write_summary(ry_result *result, hid_t file);

/* lock.c: opens OUT.h5.part with an exclusive lock that dies with the process. `create`: makes the
 * file if it isn't there. *fd is -1 if it isn't there. RY_BAD_FILE "in use by another run". */
ry_status ry_lock_open(const char *path, int create, int *fd, ry_error *error);
/* RY_BAD_FILE unless `path` still names the file behind `fd`: what has that name by now may be another run's. */
ry_status ry_lock_check_name(int fd, const char *path, ry_error *error);
/* OUT.h5 can be made: not a directory, its folder there and writable. */
ry_status ry_lock_check_path(const char *path, ry_error *error);

/* Of a file that ry_table_file has made (describe_table.c): whether it is one, and what it holds. */
int ry_table_is_ours(hid_t file);
void ry_table_describe(hid_t file, const char *path, ry_write_fn *write, void *data);

/* parameters.c */
int ry_parameters_write(hid_t file, const ry_config *config);
/* Fails with RY_BAD_INPUT and the list of keys unless the file's scene is `config`, but for what may
 * differ. `name` is the file's. */
ry_status ry_parameters_compare(hid_t file, const char *name, const ry_config *config,
                                ry_error *error);
/* RY_BAD_FILE and what is missing unless the file is a result of this program. */
ry_status ry_parameters_check_ours(hid_t file, const char *name, ry_error *error);

/* checkpoint.c */
int ry_checkpoint_write(const ry_h5 *file, int slot, int64_t sequence, const ry_state *state);
/* Numbers that belong to the checkpoint in this slot; n = 0: none. */
int ry_checkpoint_write_window(const ry_h5 *file, int slot, const double *values, int64_t n);
int ry_checkpoint_read_window(hid_t file, int slot, double **values, int64_t *n);
/* The newest whole checkpoint: 1 found, 0 there is none, -1 there are only damaged ones. */
int ry_checkpoint_read(hid_t file, ry_state *state, int *slot, int64_t *sequence);
/* The format of its checkpoints, where that is another than ours; else 0. */
int64_t ry_checkpoint_other_format(hid_t file);

/* xdmf.c: writes OUT.xdmf for a finished OUT.h5, if it has positions; an existing one stays unless
 * `anew`. */
ry_status ry_xdmf_write(const char *h5_path, int anew, ry_error *error);

#endif
