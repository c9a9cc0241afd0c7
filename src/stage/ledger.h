/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The energy ledger. Work is impulse times the mean of the velocities before and after the kick, with all forces on
 * both grains in it: exact for the kinetic energy. The pair loop books what dashpots and friction take, integrate
 * what the fluid gives; here are the impacts of laws that balance their energy, few at a time. Runs after gather,
 * before integrate. */
#ifndef RY_STAGE_LEDGER_H
#define RY_STAGE_LEDGER_H

#include "stage/contact.h"
#include "stage/motion.h"

void ry_ledger_stage(const ry_contact *contact, const ry_motion *motion, ry_state *state,
                     const ry_pairs *pairs);

#endif
