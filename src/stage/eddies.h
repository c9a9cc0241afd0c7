/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Turbulence as a discrete random walk (Maurin et al. 2015, Phys. Fluids 27, 113302): a grain is in an eddy for some
 * time, then in another. Each has a velocity of its own beside the mean flow's,
 *
 *     u' = s (b - a),  w' = s a,   a, b normal, mean 0, standard deviation 1;  s^2 = Reynolds stress/rho at the grain,
 *
 * so that <u'w'> = -s^2, <u'^2> = 2 s^2, <w'^2> = s^2 (Nezu & Nakagawa 1993 measured 1.8 to 2.3 and 1.1 to 1.3 times
 * u_star in place of 1.4 and 1). a and b are drawn when it meets the eddy, s goes with the grain. */
#ifndef RY_STAGE_EDDIES_H
#define RY_STAGE_EDDIES_H

#include "stage/flow.h"

/* An eddy lasts this part of the inverse of the mean flow's shear: in a log profile 0.33 kappa z/u_star, a tenth of
 * k/epsilon there. */
#define RY_EDDY_TURN 0.33

/* Draws the eddy that grain k has met, as grains->met says; of one that has met none there is none. */
void ry_eddies_meet(const ry_flow *flow, const ry_grains *grains, int32_t k);

/* At an advance: new eddies for those whose time is over, to the nearest advance. */
void ry_eddies_renew(const ry_flow *flow, ry_grains *grains, int64_t step);

#endif
