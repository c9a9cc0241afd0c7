/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * T: Hertz spring with the dashpot that gives one restitution at every speed (Tanaka, Ishida & Tsuji
 * 1991, Trans. JSME B 57, 456). The coefficient is Antypov & Elliott's (2011, EPL 94, 50004), for the
 * reduced mass; Tsuji's polynomial is for the mass of one of two equal spheres. */
#ifndef RY_LAW_TANAKA_H
#define RY_LAW_TANAKA_H

#include "law/law.h"

/* f = -(a d^3/2 + c d^1/4 w), never pulling. Here a and c carry the length that a Hertz spring needs:
 * a = k dt^2/(m_r sqrt(L)), c = alpha sqrt(a), alpha = sqrt(5) zeta, L the mean diameter, so that the force at d = L
 * is that of the linear spring k. With x = d^(5/4), w dw/dx = -(4/5)(a x + c w) is that of a linear spring and dashpot
 * with the damping ratio zeta = alpha/sqrt(5): so is the restitution, at every speed. */
RY_INLINE ry_push ry_law_tanaka(const ry_bond q, const ry_touch t)
{
    ry_push p = {0};
    const double root = sqrt(t.d);
    const double spring = q.a * t.d * root;
    p.f = ry_min(-(spring + q.c * sqrt(root) * t.w), 0.0);
    p.dashpot = p.f + spring;
    return p;
}

#endif
