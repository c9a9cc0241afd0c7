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
    RY_RANDOM_STRATUM = 6,
    RY_RANDOM_EDDY = 7     /* with who meets it, and the step at which */
} ry_random_purpose;

/* Evenly distributed in [0, 1), 53 bits. */
double ry_random(uint32_t seed, ry_random_purpose purpose, uint64_t index);

/* Two independent numbers with mean 0 and standard deviation 1, normally distributed, of entry `which` of a purpose. */
void ry_random_normal(uint32_t seed, ry_random_purpose purpose, uint64_t index, uint32_t which, double out[2]);

/* Seed of replica k of a scene with this grains.seed: the following ones, and 0 after the largest. */
int ry_random_replica(int seed, int k);

#endif
