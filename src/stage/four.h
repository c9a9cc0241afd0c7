/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Four doubles side by side, and how four such rows become four columns: records that lie anywhere in memory
 * are fetched whole, one load each, and sorted in registers; to gather their members one by one takes
 * several times as long. Moves data only: the same bits on any machine. */
#ifndef RY_STAGE_FOUR_H
#define RY_STAGE_FOUR_H

#include <stdint.h>
#include <string.h>

#include "base/parallel.h"

#ifdef __GNUC__ /* how such vectors are passed to functions does not matter: these are all inlined */
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

typedef double ry_four __attribute__((vector_size(4 * sizeof(double)), aligned(8)));
typedef int64_t ry_four_index __attribute__((vector_size(4 * sizeof(int64_t))));

#if defined(__clang__) || __GNUC__ >= 12
#define RY_FOUR_PICK(p, q, a, b, c, d) __builtin_shufflevector(p, q, a, b, c, d)
#else
#define RY_FOUR_PICK(p, q, a, b, c, d) __builtin_shuffle(p, q, (ry_four_index){a, b, c, d})
#endif

RY_INLINE ry_four ry_four_load(const double *from)
{
    ry_four v;
    memcpy(&v, from, sizeof v);
    return v;
}

RY_INLINE void ry_four_store(double *to, ry_four v)
{
    memcpy(to, &v, sizeof v);
}

/* a where the mask is -1, b where it is 0. */
RY_INLINE ry_four ry_four_select(ry_four_index mask, ry_four a, ry_four b)
{
    return (ry_four)((mask & (ry_four_index)a) | (~mask & (ry_four_index)b));
}

/* Rows become columns. */
RY_INLINE void ry_four_turn(ry_four *r)
{
    const ry_four even_low = RY_FOUR_PICK(r[0], r[1], 0, 4, 2, 6), odd_low = RY_FOUR_PICK(r[0], r[1], 1, 5, 3, 7);
    const ry_four even_high = RY_FOUR_PICK(r[2], r[3], 0, 4, 2, 6), odd_high = RY_FOUR_PICK(r[2], r[3], 1, 5, 3, 7);
    r[0] = RY_FOUR_PICK(even_low, even_high, 0, 1, 4, 5);
    r[1] = RY_FOUR_PICK(odd_low, odd_high, 0, 1, 4, 5);
    r[2] = RY_FOUR_PICK(even_low, even_high, 2, 3, 6, 7);
    r[3] = RY_FOUR_PICK(odd_low, odd_high, 2, 3, 6, 7);
}

#endif
