/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * C: linear spring and dashpot (Cundall & Strack 1979, Geotechnique 29, 47). */
#ifndef RY_LAW_CUNDALL_H
#define RY_LAW_CUNDALL_H

#include "law/law.h"

/* f = -(a d + c w). The dashpot pulls while the grains part faster than the spring pushes. */
RY_INLINE ry_push ry_law_cundall_tension(const ry_bond q, const ry_touch t)
{
    ry_push p = {0};
    p.f = -(q.a * t.d + q.c * t.w);
    p.dashpot = -q.c * t.w;
    return p;
}

/* The same, but never pulling: f <= 0. */
RY_INLINE ry_push ry_law_cundall(const ry_bond q, const ry_touch t)
{
    ry_push p = {0};
    p.f = ry_min(-(q.a * t.d + q.c * t.w), 0.0);
    p.dashpot = p.f + q.a * t.d;
    return p;
}

#endif
