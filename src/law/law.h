/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What every contact law takes and gives. All quantities of a pair are lengths: velocities are
 * multiplied by dt, forces by dt^2/m_r, so that a step is
 *
 *     w' = w + f + g,    d' = d + shift + w'
 *
 *   d      overlap, > 0: touching [m]
 *   w      approach per step, > 0: approaching [m]
 *   g      what gravity adds to w in a step; only where one partner can't move [m]
 *   a      k dt^2/m_r [1]           c   eta dt/m_r [1]      (Hertz: with a length, tanaka.h)
 *   f      what the law adds to w; f < 0 pushes apart [m]
 *
 * Energies are per m_r/dt^2: a grain pair holds w^2/2 + a d^2/2 (Hertz: 2/5 a d^(5/2)). Letters as in Fujioka &
 * Ushijima (2005), where all lengths are divided by one more that cancels. */
#ifndef RY_LAW_LAW_H
#define RY_LAW_LAW_H

#include <math.h>

#include "base/parallel.h"

/* A contact stays an impact for its first steps: a free binary impact is over in three. */
#define RY_IMPACT_STEPS 4.0
/* age counts no further than this; of laws that tell impacts from enduring contacts, it means an enduring one that
 * has not pushed yet. */
#define RY_AGE_MAX 255.0

/* Coefficients of one pair; the same for all pairs of equal grains. */
typedef struct ry_bond {
    double a;           /* k dt^2/m_r, bounded if the law asks for it */
    double c;           /* eta dt/m_r of the normal dashpot, bounded likewise */
    double e;           /* restitution of a binary impact */
    double stretch;     /* k_t dt^2/m_t: tangential stiffness, m_t the mass that the contact point feels */
    double per_stretch; /* 1/stretch */
    double drag;        /* eta_t dt/m_t and what the scheme needs, see ry_bond_damped */
    double mass_ratio;  /* m_r/m_t */
} ry_bond;

/* State of one contact as the law sees it. */
typedef struct ry_touch {
    double d, w, g;
    /* overlap at which the spring is relaxed [m]; in an impact of a law with `parts` see ry_impact_holds [m^2] */
    double rest;
    double age;    /* steps in touch before this one; 0: the contact is new */
    double crowd;  /* contacts in this step of the partner that has fewer of the two; this one counts */
    double split;  /* 1/m_r over the true one, >= 1, of masses shared out over a grain's impacts */
    double bend;   /* 1/distance of the centres, 0: the partner is a wall [1/m] */
    double across; /* what the centres pass each other by in a step [m] */
    double g_across; /* what gravity adds to that, as g [m] */
    double stick;  /* what friction must add to `across` to stop the contact point [m] */
    double mu;     /* Coulomb's */
    double busy;   /* as crowd, of that which has more */
    double pushed; /* in an impact, see ry_impact_holds [m] */
    double then;   /* w along the line of centres of the step before [m] */
} ry_touch;

typedef struct ry_push {
    double f;      /* added to w [m] */
    double shift;  /* added to d at once [m] */
    double rest;   /* new value of the contact's rest */
    double pushed; /* and of its pushed */
    double impact; /* energy lost by restitution [m^2] */
    double rough;   /* > 0: friction holds without a spring, see ry_tangential */
    double from;    /* age counts from this at least */
    double dashpot; /* the part of f that the dashpot gives [m] */
} ry_push;

/* What the spring of an impact holds after a step [m^2], of laws that do impacts apart: what was really paid into it.
 * The work of f (and of g, which the law reckons over the drift w', over the mean) is known when w' is there, the
 * approach after the step along the line of centres of that step, with all that other contacts have added. Till then
 * `rest` is what does not wait for w' [m^2], and `pushed` is f - g [m]. pushed = 0: no such books, the spring is as
 * long as the overlap d says. */
RY_INLINE double ry_impact_holds(double a, double d, double rest, double pushed, double then)
{
    const double stretch = d > rest ? d - rest : 0.0;
    return pushed != 0.0 ? rest - 0.5 * pushed * then : 0.5 * a * stretch * stretch;
}

RY_INLINE double ry_max(double p, double q)
{
    return p > q ? p : q;
}

RY_INLINE double ry_min(double p, double q)
{
    return p < q ? p : q;
}

#endif
