/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What there is to say of one explicit grain, as numbers with names: the columns of a table of particles, and of
 * /parameters/particles in a result. */
#ifndef RY_CONFIG_PARTICLE_H
#define RY_CONFIG_PARTICLE_H

#include "ryusa/config.h"

enum {
    RY_PARTICLE_X, RY_PARTICLE_Z, RY_PARTICLE_VX, RY_PARTICLE_VZ, RY_PARTICLE_SPIN, RY_PARTICLE_DIAMETER,
    RY_PARTICLE_DENSITY, RY_PARTICLE_FIXED, RY_PARTICLE_NUMBERS
};

extern const char *const ry_particle_names[RY_PARTICLE_NUMBERS + 1]; /* NULL after the last */
extern const char *const ry_particle_units[RY_PARTICLE_NUMBERS];

double ry_particle_get(const ry_particle *grain, int which);
void ry_particle_set(ry_particle *grain, int which, double value);

/* `hash` and all numbers of n grains as one word. */
uint64_t ry_particle_hash(uint64_t hash, const ry_particle *grains, int n);

/* The allowed range, both included. Of places and speeds: all beyond is a slip of units. */
void ry_particle_range(int which, double *low, double *high);

#endif
