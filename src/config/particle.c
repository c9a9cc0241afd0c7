/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "config/particle.h"

#include <stddef.h>

#include "base/hash.h"
#include "config/keys.h"

const char *const ry_particle_names[RY_PARTICLE_NUMBERS + 1] = {"x",    "z",        "vx",      "vz",
                                                                "spin", "diameter", "density", "fixed", NULL};
const char *const ry_particle_units[RY_PARTICLE_NUMBERS] = {"m", "m", "m/s", "m/s", "rad/s", "m", "kg/m^3", "1"};

static double *number(ry_particle *grain, int which)
{
    switch (which) {
    case RY_PARTICLE_X: return &grain->position[0];
    case RY_PARTICLE_Z: return &grain->position[1];
    case RY_PARTICLE_VX: return &grain->velocity[0];
    case RY_PARTICLE_VZ: return &grain->velocity[1];
    case RY_PARTICLE_SPIN: return &grain->spin;
    case RY_PARTICLE_DIAMETER: return &grain->diameter;
    default: return &grain->density;
    }
}

double ry_particle_get(const ry_particle *grain, int which)
{
    ry_particle copy = *grain;
    return which == RY_PARTICLE_FIXED ? (double)grain->fixed : *number(&copy, which);
}

void ry_particle_set(ry_particle *grain, int which, double value)
{
    if (which == RY_PARTICLE_FIXED) {
        grain->fixed = value != 0.0;
    } else {
        *number(grain, which) = value;
    }
}

uint64_t ry_particle_hash(uint64_t hash, const ry_particle *grains, int n)
{
    for (int k = 0; k < n; k++) {
        for (int which = 0; which < RY_PARTICLE_NUMBERS; which++) {
            const double number = ry_particle_get(&grains[k], which);
            hash = ry_hash_mix(hash, &number, sizeof number);
        }
    }
    return hash;
}

void ry_particle_range(int which, double *low, double *high)
{
    const double farthest = 1e9, fastest = 1e9, fastest_spin = 1e12;
    const ry_key_row *const row = ry_keys_row(which == RY_PARTICLE_DENSITY ? RY_KEY_grains_density
                                                                           : RY_KEY_grains_diameter);
    *high = which <= RY_PARTICLE_Z ? farthest : which <= RY_PARTICLE_VZ ? fastest : fastest_spin;
    *low = -*high;
    if (which == RY_PARTICLE_DIAMETER || which == RY_PARTICLE_DENSITY) {
        *low = row->low;
        *high = row->high;
    } else if (which == RY_PARTICLE_FIXED) {
        *low = 0.0;
        *high = 1.0;
    }
}
