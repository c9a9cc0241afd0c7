/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * From the constants of a scene to the coefficients of one pair, and the tangential law. */
#ifndef RY_LAW_BOND_H
#define RY_LAW_BOND_H

#include "law/law.h"

/* A grain in a packing of equal disks has at most six neighbours: the bounds are made for so many at least. */
#define RY_BOND_NEIGHBOURS 6.0

/* Contacts of a grain with fixed ones that the bounds are made for: where these are less than a third as large, as many
 * as fit around it, pi/asin(fixed/(r + fixed)), but no more than `most`. (Small ones that can move resist less.) */
RY_INLINE double ry_bond_around(double r, double fixed, double most)
{
    const double around = 3.1415926535897932 * (1.0 + r / fixed) - 0.3; /* 1 % below: no asin, for the same bits */
    return r > 3.0 * fixed && fixed > 0.0 ? ry_max(RY_BOND_NEIGHBOURS, ry_min(around, most)) : RY_BOND_NEIGHBOURS;
}

typedef struct ry_law_coef {
    double k_dt2;      /* normal stiffness x dt^2 [kg] */
    double eta_dt;     /* normal dashpot x dt [kg] */
    double zeta2;      /* > 0: twice the damping ratio, which then replaces eta: c = zeta2 sqrt(a) */
    double e;          /* restitution of the laws that take it directly */
    double friction;   /* Coulomb's mu */
    double ratio_k;    /* k_t/k */
    double ratio_eta;  /* eta_t/eta */
    double bounded;    /* contacts of a grain that the law bounds stiffness and dashpot for, 0: it does not */
    double hertz, root_hertz; /* Hertz: 1/sqrt(L) and its root; 0: linear spring [m^-1/2, m^-1/4] */
    double g_dt2;      /* gravity, less buoyancy, x dt^2 [m] */
} ry_law_coef;

/* Coefficients of a pair with a damping of its own, zeta2 as in ry_law_coef. im = 1/m_i + 1/m_j;
 * tm = im + r_i^2/I_i + r_j^2/I_j is what the contact point feels of a tangential force (7/2 im for spheres).
 *
 * The bounds k/(1 + k dt^2 b/4) and eta/(1 + eta dt b), b = n im, keep n = q->bounded contacts of one grain
 * together below what an explicit step bears, a + 2 c < 4 of their sum: normals that point all ways count half. All n
 * tangents turn the same grain: there it is k_t/(1 + k_t dt^2 n tm).
 *
 * Tangential: F = -(stretch s + drag w_t), s' = s + w_t'. Between its ends such a step changes
 * w_t^2/2 + stretch s^2/2 by a quadratic form that is never positive if
 * drag^2 - 2 drag + stretch <= 0, so at least 1 - sqrt(1 - stretch) of drag belongs to the scheme; the
 * dashpot comes on top of it, both together at most 1. With a Hertz spring they stay those of k and eta at an overlap
 * of L: at small overlaps the tangent is the stiffer. */
RY_INLINE ry_bond ry_bond_damped(const ry_law_coef *q, double im, double tm, double zeta2)
{
    const double quarter = 0.25 * q->bounded;
    const double a = q->k_dt2 * im;
    const double c = zeta2 > 0.0 ? zeta2 * sqrt(a) : q->eta_dt * im;
    const double stretch = q->ratio_k * q->k_dt2 * tm;
    const double drag_im = q->ratio_eta * c * tm; /* the drag x im */
    const int bounded = q->bounded > 0.0; /* where it is known when compiled that it is not, all this goes */
    const double bound_a = bounded ? 1.0 + quarter * a : 1.0, bound_c = bounded ? 1.0 + q->bounded * c : 1.0;
    const double bound_s = bounded ? 1.0 + q->bounded * stretch : 1.0;
    const double bound_d = bounded ? im + q->bounded * drag_im : im;
    /* one division for the six: it is the slowest thing here */
    const double normal = bound_a * bound_c, tangential = bound_s * bound_d, rest = stretch * im;
    const double inverse = 1.0 / (normal * tangential * rest);
    const double per_normal = tangential * rest * inverse, per_tangential = normal * rest * inverse;
    const double per_rest = normal * tangential * inverse;
    ry_bond b;
    b.a = a * bound_c * per_normal * (q->hertz > 0.0 ? q->hertz : 1.0);
    b.c = c * bound_a * per_normal * (q->hertz > 0.0 ? q->root_hertz : 1.0);
    b.e = q->e;
    b.stretch = ry_min(stretch * bound_d * per_tangential, 1.0);
    b.per_stretch = ry_max(bound_s * im * per_rest, 1.0);
    b.drag = ry_min(1.0 - sqrt(1.0 - b.stretch) + drag_im * bound_s * per_tangential, 1.0);
    b.mass_ratio = tm * stretch * per_rest;
    return b;
}

RY_INLINE ry_bond ry_bond_make(const ry_law_coef *q, double im, double tm)
{
    return ry_bond_damped(q, im, tm, q->zeta2);
}

/* What an explicit tangential spring holds at the time of the velocities, which is half a step before that of the
 * positions: k s^2/2 - dt F.v/2, run = v dt. Together with the kinetic energy that is what such a step keeps; with
 * k s^2/2 each stretching and letting go would seem to change it. Never below 0: a spring gives no more than it has. */
RY_INLINE double ry_spring_energy(double k, double slip, double run)
{
    return 0.5 * k * ry_max(slip * (slip - run), 0.0);
}

typedef struct ry_slide {
    double f;     /* added to the tangential approach w_t [m] */
    double slip;  /* stretch of the spring to keep [m] */
    int slides;   /* the Coulomb limit was reached */
} ry_slide;

/* Spring, dashpot and Coulomb limit along the tangent, which in the plane is one line: a scalar slip,
 * no projection (Cundall & Strack 1979). f: what the normal law added; w: tangential velocity x dt;
 * slip: stretch including the run of the last step. Where the contact slides the spring keeps
 * what the limit can hold, and no more than friction has paid for. rough > 0: no spring; the contact point
 * is stopped by that part of it (of a mass that is shared out over several impacts). */
RY_INLINE ry_slide ry_tangential(const ry_bond q, double mu, double f, double w, double slip, double rough)
{
    const double cap = mu * q.mass_ratio * ry_max(-f, 0.0);
    const double trial = rough > 0.0 ? -rough * w : -(q.stretch * slip + q.drag * w);
    const double bounded = ry_max(ry_min(trial, cap), -cap);
    const int slides = trial > cap || trial < -cap;
    const double after = w + bounded;
    const double hold = cap * q.per_stretch;
    const double held = ry_max(ry_min(slip + after, hold), -hold);
    ry_slide s;
    s.f = bounded;
    s.slip = rough > 0.0 ? -after : (slides ? held - after : slip); /* plus the drift: 0, held */
    s.slides = slides;
    return s;
}

#endif
