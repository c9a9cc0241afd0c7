/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A sweep file: a scene and what is varied in it (docs/sweep.md). It is read like a scene: units,
 * ranges, words, nearest keys, messages with file and line. */
#ifndef RY_STUDY_SWEEP_FILE_H
#define RY_STUDY_SWEEP_FILE_H

#include "ryusa/config.h"

/* RY_NAME(enum value, "word in a sweep file") */
#define RY_LIST_sampling(RY_NAME)     \
    RY_NAME(RY_SAMPLING_GRID, "grid") \
    RY_NAME(RY_SAMPLING_LIST, "list") \
    RY_NAME(RY_SAMPLING_RANDOM, "random") RY_NAME(RY_SAMPLING_LATIN, "latin-hypercube")
#define RY_NAME_ENUM(value, word) value,
typedef enum { RY_LIST_sampling(RY_NAME_ENUM) RY_SAMPLING_COUNT } ry_sampling;
#undef RY_NAME_ENUM

/* One varied key: values, or a range from..to in the unit of the key. */
typedef struct ry_axis {
    char path[80]; /* section.key */
    int key;       /* its number in config/keys.h */
    int line;      /* in the sweep file */
    char **value;  /* as texts; owned */
    int n;         /* values; 0: a range that is sampled */
    int is_range;
    double from, to;
    int steps; /* of a range; 0: not given */
    int logarithmic;
} ry_axis;

typedef struct ry_sweep_file {
    char *path, *text, *scene; /* the file, what stands in it, the scene it names; owned */
    char *title;               /* NULL: none; owned */
    char **set;                /* "key=value" for every case; owned */
    int n_set;
    ry_axis *axis;
    int n_axes;
    ry_sampling sampling;
    int samples, replicas, seed;
    int n_points; /* cases without their replicas */
    char **value; /* n_points rows of n_axes texts; owned, each */
} ry_sweep_file;

/* On failure the file is zeroed. */
ry_status ry_sweep_file_load(ry_sweep_file *file, const char *path, ry_error *error);
void ry_sweep_file_free(ry_sweep_file *file);

/* The value of a varied key in a point, as text. */
const char *ry_sweep_file_value(const ry_sweep_file *file, int point, int axis);

const char *ry_sweep_file_sampling(const ry_sweep_file *file);

/* sweep_points.c: makes the points of the axes; RY_BAD_INPUT if there are none or too many. */
ry_status ry_sweep_points_make(ry_sweep_file *file, ry_error *error);

/* "fluid.shields" = "0.1, 0.2" or "0.1 to 1 in 10 steps, log": what an axis says, for comparisons; the
 * caller frees it. */
char *ry_sweep_points_describe(const ry_axis *axis);

enum { RY_SWEEP_MOST_CASES = 100000 };

#endif
