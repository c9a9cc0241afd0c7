/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Random numbers as a function of (seed, purpose, index), not of the order of calls: Philox 4x32-10
 * (Salmon et al. 2011, SC11) from Random123. */
#ifndef RY_BASE_RANDOM_H
#define RY_BASE_RANDOM_H

#include <stdint.h>

/* What a random number is for; a new use gets a new line. */
typedef enum {
    RY_RANDOM_DIAMETER = 1,
    RY_RANDOM_PLACE_X = 2,
    RY_RANDOM_PLACE_Z = 3,
    RY_RANDOM_ORDER = 4,
    RY_RANDOM_SAMPLE = 5,  /* of a sweep */
    RY_RANDOM_STRATUM = 6
} ry_random_purpose;

/* Evenly distributed in [0, 1), 53 bits. */
double ry_random(uint32_t seed, ry_random_purpose purpose, uint64_t index);

/* Seed of replica k of a scene with this grains.seed: the following ones, and 0 after the largest. */
int ry_random_replica(int seed, int k);

#endif
