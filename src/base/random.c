/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/random.h"

#include <math.h>

#include "base/elementary.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#include <Random123/philox.h>
#pragma GCC diagnostic pop

/* Evenly distributed in [0, 1), from two words. */
static double evenly(uint32_t one, uint32_t other)
{
    const uint64_t high = one >> 5, low = other >> 6; /* 27 + 26 bits */
    return (double)((high << 26) | low) * 0x1p-53;
}

double ry_random(uint32_t seed, ry_random_purpose purpose, uint64_t index)
{
    const philox4x32_ctr_t counter = {{(uint32_t)index, (uint32_t)(index >> 32), 0, 0}};
    const philox4x32_key_t key = {{seed, (uint32_t)purpose}};
    const philox4x32_ctr_t bits = philox4x32(counter, key);
    return evenly(bits.v[0], bits.v[1]);
}

/* The polar method (Marsaglia 1964), which needs no function but log: a point in the unit disc, at the first try in
 * four of five cases. */
void ry_random_normal(uint32_t seed, ry_random_purpose purpose, uint64_t index, uint32_t which, double out[2])
{
    const philox4x32_key_t key = {{seed, (uint32_t)purpose}};
    double x = 0.0, y = 0.0, r2 = 0.0;
    for (uint32_t attempt = 0; !(r2 > 0.0 && r2 < 1.0); attempt++) {
        const philox4x32_ctr_t counter = {{(uint32_t)index, (uint32_t)(index >> 32), which, attempt}};
        const philox4x32_ctr_t bits = philox4x32(counter, key);
        x = 2.0 * evenly(bits.v[0], bits.v[1]) - 1.0;
        y = 2.0 * evenly(bits.v[2], bits.v[3]) - 1.0;
        r2 = x * x + y * y;
    }
    const double scale = sqrt(-2.0 * ry_log(r2) / r2);
    out[0] = scale * x;
    out[1] = scale * y;
}

int ry_random_replica(int seed, int k)
{
    return (int)(((int64_t)seed + k) % ((int64_t)INT32_MAX + 1));
}
