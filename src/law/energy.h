/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The default law: exact for two grains, quiet for many.
 *
 * An impact (a contact in its first RY_IMPACT_STEPS steps, of which one partner has no other contact)
 * follows Fujioka & Ushijima's idea: the loss is booked once, in the closing step, and every later step
 * keeps the energy, so that a free binary impact has its restitution to rounding for any step. Five
 * things differ from the paper:
 *
 *  - The grains are not shifted. The spring is: it is relaxed at the overlap `rest` instead of 0, so
 *    that its stretch d - rest is the paper's corrected overlap. The force stays central and nothing
 *    jumps, which keeps angular momentum and leaves the other contacts of a grain alone.
 *  - Where one partner can't move, or rests on others while the second falls, gravity is part of the balance. Free
 *    flight keeps w^2/2 - g d exactly, so the true closing speed is w_c^2 = w^2 - 2 g d, and the energy kept is
 *    w'^2/2 + a (d' - rest)^2/2 - g d'.
 *  - In oblique impacts the line of centres turns while the grains pass each other: between the true contact and the
 *    closing step, and in each step, at the end of which they overlap by less than w' more. Both are reckoned with.
 *  - A grain in several impacts at once gives each of them an equal part of its mass (`split`). Each keeps
 *    the energy of its parts, and putting the parts together again, at their mean velocity, can only
 *    lose: with the whole mass in each of them, two impacts would gain up to two thirds.
 *  - But then the grains have come nearer than the law has reckoned with, or less near, and the spring would hold what
 *    nobody has paid for. So it is as long as the work that was really done pays for (ry_impact_holds).
 *
 * Friction in an impact is that of rough rigid spheres: it stops the contact point or reaches the Coulomb
 * limit (Walton 1993), whatever the number of steps. A spring would see three of them only.
 *
 * Any other contact is enduring, and stays so: a spring with a dashpot that never pulls. The potential is the
 * same, so nothing jumps at the change. Why not the impact law for all: it takes the whole relative velocity at
 * once, and a grain that bounces in the gap between two others never comes to rest. The bounds on stiffness and
 * dashpot (ry_bond_make) keep the enduring law below what an explicit step bears for six contacts and more. */
#ifndef RY_LAW_ENERGY_H
#define RY_LAW_ENERGY_H

#include "law/law.h"

/* What an impact may hold in this step: how the energy is shared between spring and motion. */
typedef struct ry_energy_share {
    double stretch; /* of the spring [m] */
    double motion2; /* square of the approach [m^2] */
    double lost;    /* [m^2] */
} ry_energy_share;

/* The closing step. `energy2` is twice the energy after the loss, counted from the present height and for the present
 * line of centres: e^2 w_c^2 + 2 g d - turned. At the true contact, up to a step ago, the grains passed each other more
 * slowly (free flight keeps D across, D the distance of the centres): across^2 was less by `turned`, and w^2 more. The
 * energy is shared as if spring and motion had both moved since then, 1/s of a step: stretch = w^/s. */
RY_INLINE ry_energy_share ry_energy_close(const ry_bond q, const ry_touch t, double a)
{
    const double bent = t.bend * t.d, all = 1.0 + bent;
    const double turned = t.across * t.across * bent * (2.0 + bent) / (all * all);
    const double speed2 = ry_max(t.w * t.w + turned - 2.0 * t.g * t.d, 0.0);
    const double energy2 = ry_max(q.e * q.e * speed2 + 2.0 * t.g * t.d - turned, 0.0);
    const double reach = ry_max(t.w, t.d); /* s d with s >= 1 */
    ry_energy_share share;
    share.stretch = ry_min(t.d * sqrt(energy2 / (reach * reach + a * t.d * t.d)), t.d);
    share.motion2 = ry_max(energy2 - a * share.stretch * share.stretch, 0.0);
    share.lost = 0.5 * (t.w * t.w - energy2);
    return share;
}

/* The line of centres turns: the overlap after the step is d - h + w'. h [m], and dh/dw'; how the grains pass each
 * other follows from friction, and that from what the impact adds to w. */
typedef struct ry_energy_turn {
    double h, slope;
} ry_energy_turn;

RY_INLINE ry_energy_turn ry_energy_turning(const ry_touch t, double after)
{
    const double added = after - t.w - t.g, grip = t.mu * fabs(added);
    const double held = ry_max(ry_min(t.stick, grip), -grip), across = t.across + t.g_across + held;
    const double slides = grip < fabs(t.stick) ? 1.0 : 0.0;
    const double swing = slides * t.mu * (held * added < 0.0 ? -1.0 : 1.0); /* d across/d after */
    const double ahead = ry_max(1.0 - t.bend * after, 0.1), aside = t.bend * across;
    const double way = sqrt(ahead * ahead + aside * aside);
    ry_energy_turn turn;
    turn.h = across * aside / (way + ahead);
    turn.slope = (aside * swing + t.bend * turn.h) / way;
    return turn;
}

/* One turn of Newton's method for the w' that keeps energy2 = w'^2 + a (stretch - h + w')^2 - 2 g w', the middle term
 * only while the spring is pressed. `most`: more than g +- most no spring could pay for. */
RY_INLINE double ry_energy_refine(const ry_touch t, double a, double stretch, double energy2, double sign, double most,
                                  double after)
{
    const ry_energy_turn turn = ry_energy_turning(t, after);
    const double pressed = ry_max(stretch - turn.h + after, 0.0);
    const double gain = after * (after - 2.0 * t.g) + a * pressed * pressed - energy2;
    const double slope = 2.0 * (after - t.g + a * pressed * (1.0 - turn.slope));
    const int runs = slope * sign > 0.0; /* else there is no energy */
    const double next = after - (runs ? gain / (runs ? slope : 1.0) : 0.0);
    return ry_max(ry_min(next, t.g + most), t.g - most);
}

/* That w'. Where the spring starts, in the closing step, the positive root: keep going in; later, or where the line of
 * centres turns faster than the grains approach, the negative one: turn round, or leave. First with the h of a step
 * without impact; two turns more reach rounding up to a tenth of a diameter a step, three up to half of one. */
RY_INLINE double ry_energy_keep(const ry_energy_share has, const ry_touch t, double a, double per_1a, int starts)
{
    const double free = t.w + t.g, h = ry_energy_turning(t, free).h;
    const double sign = (starts & (free > h)) ? 1.0 : -1.0;
    const double energy2 = has.motion2 + a * has.stretch * has.stretch;
    const double left = has.stretch - h, b = a * left - t.g;
    const double within = has.motion2 + a * h * (has.stretch + left); /* energy2 - a left^2 */
    const double stay = (sign * sqrt(ry_max(b * b + (1.0 + a) * within, 0.0)) - b) * per_1a;
    const double most = sqrt(t.g * t.g + energy2);
    double after = left + stay > 0.0 ? stay : t.g + sign * most;
    after = ry_energy_refine(t, a, has.stretch, energy2, sign, most, after);
    after = ry_energy_refine(t, a, has.stretch, energy2, sign, most, after);
    return ry_energy_refine(t, a, has.stretch, energy2, sign, most, after);
}

/* Spring and dashpot of a contact that is no impact, for a spring relaxed at `rest`. Their approach lies half a step
 * before the overlap, and what such a step keeps is w^2/2 + a stretch (stretch - w)/2. So where it joins an impact,
 * which has both at one time, it begins with half a kick; and where it lets go it gives what takes that energy to
 * w'^2/2, to first order in a and never more: the whole kick would give a stretch (overshoot)/2 too much. */
RY_INLINE ry_push ry_energy_spring(const ry_bond q, const ry_touch t, double rest, int joins)
{
    const double stretch = t.d - rest, spring = q.a * stretch;
    const double whole = joins ? 0.5 * spring : spring;
    const double last = spring * (joins ? stretch : stretch - t.w) / (spring - 2.0 * t.w);
    const double push = stretch + t.w < whole ? last : whole;
    ry_push p = {.rest = rest, .from = RY_IMPACT_STEPS};
    p.f = ry_min(-(push + q.c * t.w), 0.0);
    p.dashpot = p.f + push;
    return p;
}

/* A contact that has become enduring, its spring relaxed at t.rest or where the grains are: a spring that has let go
 * costs nothing and makes the next squeeze start from there. */
RY_INLINE ry_push ry_law_energy_enduring(const ry_bond q, const ry_touch t)
{
    return ry_energy_spring(q, t, ry_min(t.rest, t.d), 0);
}

/* Stretch of the spring of a contact that was an impact until now. Of what it was paid rounding leaves something when
 * it has let go: that is none. */
RY_INLINE double ry_energy_kept(const ry_bond q, const ry_touch t, double holds)
{
    const double stretch = sqrt(ry_max(2.0 * holds / q.a, 0.0));
    const double paid = holds > 1e-13 * fabs(t.rest) ? stretch : 0.0;
    return t.pushed != 0.0 ? paid : ry_max(t.d - t.rest, 0.0);
}

/* What an impact keeps books of; else its spring is as long as the grains have come nearer: of two grains alone that
 * hardly part, for rounding makes of the little that is left a larger part than of the overlap. */
RY_INLINE int ry_energy_is_booked(const ry_touch t, double f, double after)
{
    return (t.busy > 1.0) | (fabs(after) > 0.1 * fabs(f));
}

/* A contact in its first steps, or that has been an impact until now. */
RY_INLINE ry_push ry_law_energy(const ry_bond q, const ry_touch t)
{
    const int alone = t.crowd <= 1.0;
    const int is_new = (t.age == 0.0) & alone, is_impact = (t.age < RY_IMPACT_STEPS) & alone;
    const double a = q.a * t.split; /* of the parts */
    const double inverse = 1.0 / ((1.0 + a) * t.split);
    const double per_split = (1.0 + a) * inverse, per_1a = t.split * inverse;
    /* for the overlap of a contact which is enduring from its first step on nobody has paid */
    const double holds = ry_impact_holds(q.a, t.d, t.rest, t.pushed, t.then);
    const double kept = ry_energy_kept(q, t, holds) * (t.age > 0.0 ? 1.0 : 0.0);
    const ry_energy_share close = ry_energy_close(q, t, a);
    const ry_energy_share has = {is_new ? close.stretch : kept, is_new ? close.motion2 : t.w * t.w, close.lost};

    /* a spring that has let go costs nothing, and starts anew when it is squeezed; grains that pass each other
     * obliquely and part already are let go */
    const int starts = is_new | (kept <= 0.0), parts = starts & (t.w <= 0.0);
    const double after = ry_energy_keep(has, t, a, per_1a, starts);
    const double impact = parts ? 0.0 : (after - t.w - t.g) * per_split;
    const double loss = is_new & !parts ? close.lost * per_split : 0.0;
    const double spring = is_new ? 0.0 : 0.5 * q.a * kept * kept;

    const double rest = ry_max(t.d - (is_new & parts ? 0.0 : has.stretch), 0.0); /* without books, or enduring */
    const double pushed = is_impact & !parts & ry_energy_is_booked(t, impact, after) ? impact - t.g : 0.0;
    const double used = is_impact ? kept : t.d - rest;
    const ry_push lasting = ry_energy_spring(q, t, rest, t.age > 0.0);
    ry_push p;
    p.f = is_impact ? impact : lasting.f;
    p.shift = 0.0;
    p.rest = pushed != 0.0 ? spring - loss - 0.5 * (impact + t.g) * t.w : rest;
    p.pushed = pushed;
    p.impact = loss + (t.age > 0.0 ? holds - 0.5 * q.a * used * used : 0.0);
    p.rough = is_impact ? per_split : 0.0;
    p.from = is_impact ? 0.0 : lasting.from;
    p.dashpot = is_impact ? 0.0 : lasting.dashpot;
    return p;
}

#endif
