/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * P and F: laws that choose the force so that the energy after the step is the right one (Fujioka &
 * Ushijima 2005, "the paper"). s = w/d tells the phase of a contact: s >= 1 only in the step in which
 * it closes, because d - w <= 0 was the gap before. Grains that pass obliquely close with any s, even
 * s < 0, because the normal turns; so a new contact is closing, too, or its overlap would be energy for
 * nothing (up to a/2 of the impact's). */
#ifndef RY_LAW_FUJIOKA_H
#define RY_LAW_FUJIOKA_H

#include "law/law.h"

/* Approach after a step that keeps w^2/2 + a d^2/2. With q = sqrt(a^2 + (1+a) s^2):
 *   q <  1: w' = -d (a + q)/(1 + a)      stays in touch (eq. 21, the negative root)
 *   q >= 1: w' = -sqrt(w^2 + a d^2)      leaves, the spring's energy returned (eq. 23)
 * The paper divides this into modes 2, 3 and 4 and always takes the first form in mode 2 (0 < s < 1),
 * which for s > sqrt(1-a) puts the grains apart while the energy of the spring stays booked: lost. */
RY_INLINE double ry_fujioka_rebound(double a, double d, double w)
{
    const double qd = sqrt(a * a * d * d + (1.0 + a) * w * w);
    const double stay = -(a * d + qd) / (1.0 + a);
    const double leave = -sqrt(w * w + a * d * d);
    return qd < d ? stay : leave;
}

/* The same as printed: mode 2 stays, mode 3 stays, mode 4 (s < -sqrt(1-a), or s < 0 if a > 1) leaves. */
RY_INLINE double ry_fujioka_rebound_printed(double a, double d, double w)
{
    const double qd = sqrt(a * a * d * d + (1.0 + a) * w * w);
    const double stay = -(a * d + qd) / (1.0 + a);
    const double leave = -sqrt(w * w + a * d * d);
    const double edge = sqrt(ry_max(1.0 - a, 0.0));
    return w >= -edge * d && (w > 0.0 || a <= 1.0) ? stay : leave;
}

/* The closing step (eqs. 13-20): the overlap is thrown away and set to what the grains would have
 * run since the true moment of contact, 1/s of a step ago, with their speed after the loss:
 * w^ = e s w/sqrt(s^2 + a), d^ = w^/s; then one step in, keeping energy (positive root). Written with
 * w and d, so that e = 0 and d -> 0 need no case: s w/sqrt(s^2 + a) = w^2/sqrt(w^2 + a d^2). Grains that
 * part already (s < 0) are let go: the overlap is thrown away, nothing else. */
RY_INLINE ry_push ry_fujioka_close(const ry_bond q, const ry_touch t)
{
    ry_push p = {0};
    const double scale = q.e * ry_max(t.w, 0.0) / sqrt(t.w * t.w + q.a * t.d * t.d);
    const double w_hat = scale * t.w;
    const double d_hat = scale * t.d;
    const double root = sqrt(q.a * q.a * d_hat * d_hat + (1.0 + q.a) * w_hat * w_hat);
    const double after = (root - q.a * d_hat) / (1.0 + q.a);
    p.f = t.w > 0.0 ? after - t.w : 0.0;
    p.shift = d_hat - t.d;
    p.impact = t.w > 0.0 ? 0.5 * (1.0 - q.e * q.e) * t.w * t.w : 0.0;
    return p;
}

RY_INLINE ry_push ry_law_fujioka2(const ry_bond q, const ry_touch t)
{
    const ry_push close = ry_fujioka_close(q, t);
    const double rebound = ry_fujioka_rebound(q.a, t.d, t.w);
    const int closing = (t.w >= t.d) | (t.age == 0.0);
    ry_push p = {0};
    p.f = closing ? close.f : rebound - t.w;
    p.shift = closing ? close.shift : 0.0;
    p.impact = closing ? close.impact : 0.0;
    return p;
}

RY_INLINE ry_push ry_law_fujioka2_printed(const ry_bond q, const ry_touch t)
{
    const ry_push close = ry_fujioka_close(q, t);
    const double rebound = ry_fujioka_rebound_printed(q.a, t.d, t.w);
    const int closing = (t.w >= t.d) | (t.age == 0.0);
    ry_push p = {0};
    p.f = closing ? close.f : rebound - t.w;
    p.shift = closing ? close.shift : 0.0;
    p.impact = closing ? close.impact : 0.0;
    return p;
}

/* F keeps the overlap of the closing step. s > 1/e: the pair leaves at once with w' = -e w; else the
 * energy after the step is e^2 w^2/2 = w'^2/2 + a (d + w')^2/2, negative root. The root exists only
 * if e^2 s^2 >= a/(1+a); where grains that pass obliquely have less, the spring is relaxed at an overlap
 * `rest` that leaves it what they can pay for. Those that part already are let go. */
RY_INLINE ry_push ry_law_fujioka1(const ry_bond q, const ry_touch t)
{
    const int is_new = t.age == 0.0;
    const int closing = (t.w >= t.d) | is_new;
    const double kept = q.e * ry_max(t.w, 0.0);
    const double most = kept * sqrt((1.0 + q.a) / q.a); /* the stretch whose root is 0 */
    const double rest = is_new ? ry_max(t.d - most, 0.0) : ry_min(t.rest, t.d);
    const double stretch = t.d - rest;
    const double root = sqrt(ry_max((1.0 + q.a) * kept * kept - q.a * stretch * stretch, 0.0));
    const double close = kept > t.d ? -kept : -(q.a * stretch + root) / (1.0 + q.a);
    const double rebound = ry_fujioka_rebound(q.a, stretch, t.w);
    const int lets_go = is_new & (t.w <= 0.0);
    ry_push p = {0};
    p.f = lets_go ? 0.0 : (closing ? close : rebound) - t.w;
    p.rest = rest;
    p.impact = (closing & !lets_go) ? 0.5 * (1.0 - q.e * q.e) * t.w * t.w : 0.0;
    return p;
}

#endif
