/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ry_config_resolve with places for its messages, and the checks that it is made of. */
#ifndef RY_CONFIG_RESOLVE_H
#define RY_CONFIG_RESOLVE_H

#include "config/keys.h"
#include "config/place.h"

/* `places` says where each of the RY_KEY_COUNT parameters was given; NULL: not from a file. */
ry_status ry_resolve_at(ry_config *config, const ry_place *places, ry_error *error);

/* What the checks need to know of a config and where to complain. */
typedef struct ry_check {
    const ry_config *config;
    const ry_place *places;
    ry_error *error;
    ry_derived derived;
    double d_min, d_max; /* smallest and largest diameter [m] */
    double inverse[2];   /* the two largest inverse masses of grains that can move, wet [1/kg] */
} ry_check;

/* A failure about a parameter; always RY_BAD_INPUT. */
ry_status ry_check_fail(const ry_check *check, int key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A failure about the explicit grain with this index. */
ry_status ry_check_fail_particle(const ry_check *check, int index, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* "line 12" or, without a file, "particles[3]". */
ry_quote ry_check_name(const ry_check *check, int index);

ry_status ry_check_overlap(const ry_check *check);   /* explicit grains, floor, walls */
ry_status ry_check_stability(const ry_check *check); /* the time step */

/* Largest a = k dt^2 (1/m1 + 1/m2) that a law bears: see stability.c. INFINITY: the rule is another. */
double ry_stability_limit(const ry_config *config, int is_bed);

#endif
