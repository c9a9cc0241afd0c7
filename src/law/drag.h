/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Drag of a sphere, F = rate (u - v), rate = pi/8 rho d^2 (C_d |u - v|). What the functions give is C_d |u - v| [m/s]:
 * with the speed multiplied in, rest is no special case. nu_d is nu/d, the grain's own [m/s]. */
#ifndef RY_LAW_DRAG_H
#define RY_LAW_DRAG_H

#include <math.h>

#include "base/elementary.h"
#include "base/parallel.h"

/* C_d = (sqrt(C) + sqrt(24/Re))^2, Re = speed d/nu (Dallavalle's form, (0.63 + 4.8/sqrt(Re))^2; Duran, Andreotti &
 * Claudin 2012, Phys. Fluids 24, 103306, with C = 0.5). Maurin et al. 2015 (Phys. Fluids 27, 113302) give the name to
 * 0.4 + 24.4/Re, which is less by the mixed term: 2.8 for 4.8 at Re = 10. root_viscous = sqrt(24 nu/d), which is the
 * grain's own. */
RY_INLINE double ry_drag_dallavalle(double speed, double root_viscous, double c)
{
    const double root = sqrt(c * speed) + root_viscous;
    return root * root;
}

/* d ln(rate)/d ln(speed) of each law: 0 of a drag that is linear in the speed, 1 of a quadratic one. */
RY_INLINE double ry_drag_dallavalle_power(double speed, double root_viscous, double c)
{
    const double root = sqrt(c * speed);
    return root / (root + root_viscous);
}

/* C_d = 24/Re (1 + 0.15 Re^0.687), not below C (Schiller & Naumann 1935). nu_d = nu/d. */
RY_INLINE double ry_drag_schiller(double speed, double nu_d, double c)
{
    const double re = speed / nu_d;
    const double inertial = re > 1e-30 ? 0.15 * ry_pow(re > 1e-30 ? re : 1.0, 0.687) : 0.0;
    const double viscous = 24.0 * nu_d * (1.0 + inertial);
    return viscous > c * speed ? viscous : c * speed;
}

RY_INLINE double ry_drag_schiller_power(double speed, double nu_d, double c)
{
    const double viscous = 24.0 * nu_d, rate = ry_drag_schiller(speed, nu_d, c);
    return rate > c * speed ? 0.687 * (rate - viscous) / rate : 1.0;
}

/* The drag law whose settling velocity is w = R g d^2/(18 nu + sqrt(0.75 C R g d^3)) (Ferguson & Church
 * 2004, J. Sediment. Res. 74, 933): sqrt(C_d) = (sqrt(C) + sqrt(C + 96/Re))/2. */
RY_INLINE double ry_drag_ferguson(double speed, double nu_d, double c)
{
    const double root = 0.5 * (sqrt(c * speed) + sqrt(c * speed + 96.0 * nu_d));
    return root * root;
}

RY_INLINE double ry_drag_ferguson_power(double speed, double nu_d, double c)
{
    return sqrt(c * speed / (c * speed + 96.0 * nu_d));
}

#endif
