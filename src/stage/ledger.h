/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The energy ledger. Work is impulse times the mean of the velocities before and after the kick, with all forces on
 * both grains in it: exact for the kinetic energy. The pair loop books what dashpots and friction take, integrate
 * what the fluid gives; here are the impacts of laws that balance their energy, few at a time. A pass after gather,
 * before integrate. */
#ifndef RY_STAGE_LEDGER_H
#define RY_STAGE_LEDGER_H

#include "stage/contact.h"
#include "stage/motion.h"

/* Those among the pairs first .. end-1 of a chunk, into its books. */
void ry_ledger_impacts(const ry_contact *contact, const ry_motion *motion, const ry_grains *grains,
                       const ry_pairs *pairs, int32_t first, int32_t end, int chunk);

#endif
