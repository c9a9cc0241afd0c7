/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the files of the contact stage share. */
#ifndef RY_STAGE_CONTACT_PRIVATE_H
#define RY_STAGE_CONTACT_PRIVATE_H

#include "stage/contact.h"

RY_INLINE ry_gap ry_contact_wall_gap(const ry_contact *c, ry_wall wall, double x, double z)
{
    const double right = c->wall_length - x;
    ry_gap gap;
    gap.dx = wall == RY_WALL_FLOOR ? 0.0 : (wall == RY_WALL_LEFT ? -x : right);
    gap.dz = wall == RY_WALL_FLOOR ? -z : 0.0;
    gap.distance = wall == RY_WALL_FLOOR ? z : (wall == RY_WALL_LEFT ? x : right);
    return gap;
}

/* Pairs and their memory: a run of the list that fills the vectors, or after which the list is filled up, stays in
 * place; any others, those of near->list[0], are copied. */
void ry_contact_fetch_run(ry_pairs *pairs, int32_t first, int32_t n, ry_near *near);
void ry_contact_fetch_list(ry_pairs *pairs, int32_t n, ry_near *near);

/* What they need of their grains, or wall. */
void ry_contact_fetch_geometry(const ry_contact *contact, const ry_grains *grains, ry_near *near);

#endif
