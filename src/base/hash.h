/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A word for bytes by which a text or numbers are known again (FNV-1a). */
#ifndef RY_BASE_HASH_H
#define RY_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define RY_HASH_START 1469598103934665603u

static inline uint64_t ry_hash_mix(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *const bytes = data;
    for (size_t k = 0; k < size; k++) {
        hash = (hash ^ bytes[k]) * 1099511628211u;
    }
    return hash;
}

#endif
