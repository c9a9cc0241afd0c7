/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a viscous fluid leaves of a restitution, and damping ratios for it.
 *
 * The film between the grains takes part of the approach (Legendre et al. 2005, Phys. Fluids 17, 097105),
 *
 *     e/e_dry = exp(-35/St),   0 for St < 10 (Gondret et al. 2002, Phys. Fluids 14, 643),
 *     St = rho_s d V/(9 mu)    of a sphere on a wall, rho_s its density, mu the fluid's dynamic viscosity.
 *
 * Of a pair St = m_r V/(6 pi mu r_r^2), with the reduced mass and the reduced radius r_i r_j/(r_i + r_j) of the
 * dry grains, V their speed of approach along the line of centres: the same on a wall, and what impacts of two
 * spheres were found to depend on (Yang & Hunt 2006, Phys. Fluids 18, 121506).
 *
 * With the logarithmic loss L = -ln e that is L = L_dry + 35/St: laws that take a damping ratio need no e. */
#ifndef RY_LAW_WET_H
#define RY_LAW_WET_H

#include "base/elementary.h"
#include "law/damping.h"
#include "law/law.h"

#define RY_WET_FILM 35.0
#define RY_WET_LEAST 10.0

/* 35/St; RY_DAMPING_ALL where nothing bounces. */
RY_INLINE double ry_wet_loss(double stokes)
{
    return stokes >= RY_WET_LEAST ? RY_WET_FILM / stokes : RY_DAMPING_ALL;
}

/* St over the approach [s/m]. per_mu = 1/(6 pi mu); im = 1/m_i + 1/m_j, curvature = 1/r_i + 1/r_j, 0 of
 * what can't move and of a wall. */
RY_INLINE double ry_wet_stokes(double per_mu, double im, double curvature)
{
    return per_mu * curvature * curvature / im;
}

RY_INLINE double ry_wet_restitution(double dry, double loss)
{
    return loss < RY_DAMPING_ALL ? dry * ry_exp(-loss) : 0.0;
}

/* The damping ratio that a fluid makes of `dry`, by the usual formula or the exact one for a dashpot that never
 * pulls; never below dry, and not above `most`, which the step bears. */
RY_INLINE double ry_wet_damping(double dry, double loss, double most, int usual)
{
    if (!(most > dry)) {
        return dry;
    }
    const double all = loss + (usual ? ry_damping_usual_loss(dry) : ry_damping_loss(dry));
    if (usual) {
        return ry_max(dry, ry_min(ry_damping_usual(all), most));
    }
    return ry_damping_loss(most) <= all ? most : ry_max(dry, ry_damping_of_loss(all, dry, most));
}

#endif
