/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/random.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#include <Random123/philox.h>
#pragma GCC diagnostic pop

double ry_random(uint32_t seed, ry_random_purpose purpose, uint64_t index)
{
    const philox4x32_ctr_t counter = {{(uint32_t)index, (uint32_t)(index >> 32), 0, 0}};
    const philox4x32_key_t key = {{seed, (uint32_t)purpose}};
    const philox4x32_ctr_t bits = philox4x32(counter, key);
    const uint64_t high = bits.v[0] >> 5, low = bits.v[1] >> 6; /* 27 + 26 bits */
    return (double)((high << 26) | low) * 0x1p-53;
}

int ry_random_replica(int seed, int k)
{
    return (int)(((int64_t)seed + k) % ((int64_t)INT32_MAX + 1));
}
