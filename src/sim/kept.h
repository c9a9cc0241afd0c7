/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The last state that passed the check: of the grains only what can change, in id order, which outlasts any order in
 * memory. */
#ifndef RY_SIM_KEPT_H
#define RY_SIM_KEPT_H

#include "store/state.h"

/* Makes `kept`, and keeps `state`; its contacts are left to the caller. Freed with ry_state_free. */
ry_status ry_kept_create(ry_state *kept, const ry_state *state, ry_error *error);

/* Keeps the state again, but for its contacts. */
void ry_kept_take(ry_state *kept, const ry_state *state);

/* Gives all of it back, contacts included. */
ry_status ry_kept_give(const ry_state *kept, ry_state *state, ry_error *error);

#endif
