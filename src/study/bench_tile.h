/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Long beds from short ones: a million grains that already lie, or move, as in a bed that has run. */
#ifndef RY_STUDY_BENCH_TILE_H
#define RY_STUDY_BENCH_TILE_H

#include "store/state.h"

/* `tiles` copies of a periodic state side by side, each `length` [m] long. The ids of the grains that can
 * move are the lower ones in both; the contacts of `base` are up to date. No ledger, no walls. */
ry_status ry_bench_tile(ry_state *state, const ry_state *base, double length, int tiles, ry_error *error);

#endif
