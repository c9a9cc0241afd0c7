/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The energy ledger: what dashpots and friction take and what the fluid gives in a step. Work is impulse
 * times the mean of the velocities before and after the kick, with all forces on both grains in it:
 * exact for the kinetic energy. Runs after gather, before integrate. */
#ifndef RY_STAGE_LEDGER_H
#define RY_STAGE_LEDGER_H

#include "stage/contact.h"
#include "stage/motion.h"

void ry_ledger_stage(const ry_contact *contact, const ry_motion *motion, ry_state *state,
                     const ry_pairs *pairs);

#endif
