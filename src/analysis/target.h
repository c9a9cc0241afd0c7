/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a flux q*(theta) is held against: a relation of the literature, or the user's own curve or
 * measured points from a CSV file with the columns theta and q_star, and error if there is one:
 *
 *     # comments and empty lines are skipped
 *     theta, q_star, error
 *     0.10,  0.046,  0.005
 *     0.20,  0.23,   0.01
 *
 * Other columns are ignored. theta grows from row to row. */
#ifndef RY_ANALYSIS_TARGET_H
#define RY_ANALYSIS_TARGET_H

#include "analysis/relations.h"

typedef struct ry_target {
    char *name;                  /* key of the relation, or path of the file; owned */
    const ry_relation *relation; /* NULL: the points below */
    int n;                       /* points */
    double *theta, *q_star;      /* owned */
    double *error;               /* standard errors; NULL: the file has none; owned */
} ry_target;

/* `name`: a key of relations.h, else a CSV file. RY_BAD_INPUT with "file:line: what is wrong; what is
 * allowed", or with the relation that was probably meant; RY_BAD_FILE if it can't be read. On failure
 * the target is zeroed. */
ry_status ry_target_open(ry_target *target, const char *name, ry_error *error);

/* The same from text in memory; `name` is used in messages. */
ry_status ry_target_parse(ry_target *target, const char *text, const char *name, ry_error *error);

void ry_target_free(ry_target *target);

/* q* at theta. Between points: a power law where both are above 0, else a straight line; NAN outside
 * of the points. */
double ry_target_flux(const ry_target *target, double theta);

/* Its standard error, between points along a straight line; NAN where it has none. */
double ry_target_error(const ry_target *target, double theta);

/* The range of theta that it covers: 0 to infinity for a relation. */
void ry_target_range(const ry_target *target, double *low, double *high);

#endif
