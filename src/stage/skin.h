/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * How far grains may go before the neighbour list is made anew. The further, the fewer lists and the more pairs: where
 * it costs least depends on how many grains move, and how deep the bed is that does not. So it is looked for while the
 * scene runs: the horizon, in steps, goes up or down by a quarter every some lists, and turns round when that has
 * cost more. What counts is pairs and lists, not time, so that a run does the same work each time. */
#ifndef RY_STAGE_SKIN_H
#define RY_STAGE_SKIN_H

#include "stage/neighbor.h"

/* Sets the skins of a neighbour list for grains of mean diameter d, and those that may be tuned to start with. `room`:
 * the most that the domain bears [m]. */
void ry_skin_begin(ry_neighbor *neighbor, double d, double dt, double room);

/* Before a list is made anew: that of `pairs` has served up to this step. */
void ry_skin_tune(ry_neighbor *neighbor, const ry_pairs *pairs, int64_t step);

#endif
