/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the sleepers are to the fluid column. They lie still: which cells they reach, and how much of each lies in
 * them, is worked out when the sets change; an advance adds up what the fluid gives them. */
#ifndef RY_STAGE_RESTING_H
#define RY_STAGE_RESTING_H

#include "stage/flow.h"
#include "stage/sets.h"

/* Makes room, where there may be sleepers; of a flow that has been created. */
ry_status ry_resting_create(ry_flow *flow, const ry_grains *grains, ry_error *error);
void ry_resting_free(ry_flow *flow);

/* Before sums are made: brings flow->resting up to date. */
void ry_resting_update(ry_flow *flow, const ry_grains *grains, const ry_sets *sets);

/* Adds up the forces of the sleepers first .. end-1 of the sets, to rows of sums. */
void ry_resting_sum(const ry_flow *flow, const ry_grains *grains, const ry_sets *sets, int32_t first, int32_t end,
                    double *gots, double *forces, double *slopes);

#endif
