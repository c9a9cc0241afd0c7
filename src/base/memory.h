/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Arrays that start on a cache line, so that a vector load never straddles two. */
#ifndef RY_BASE_MEMORY_H
#define RY_BASE_MEMORY_H

#include <stddef.h>

#include "ryusa/status.h"

enum { RY_ALIGNMENT = 64 };

/* `count` zeroed elements of `size` bytes; NULL if there is no memory. Freed with free(). */
void *ry_array(size_t count, size_t size);

/* Grows *array (of *capacity elements, the first `used` of which are kept) to at least `wanted`
 * elements. New elements are zero. */
ry_status ry_array_grow(void *array, size_t *capacity, size_t used, size_t wanted, size_t size,
                        ry_error *error);

/* The failure that every allocation reports. */
ry_status ry_no_memory(ry_error *error, size_t bytes);

#endif
