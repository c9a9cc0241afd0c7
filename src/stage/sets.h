/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Who is awake and who sleeps, in an order that does not depend on where they lie in storage. */
#ifndef RY_STAGE_SETS_H
#define RY_STAGE_SETS_H

#include <stdint.h>

/* Storage indices in ascending id. */
typedef struct ry_sets {
    const int32_t *place;  /* all grains */
    const int32_t *awake;  /* where nobody sleeps: all */
    const int32_t *asleep; /* the others; they lie still while `changes` is the same */
    int32_t n_awake, n_asleep;
    int64_t changes; /* of the sets, or of where they lie */
} ry_sets;

#endif
