/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Four doubles side by side, and how four such rows become four columns: records that lie anywhere in memory
 * are fetched whole, one load each, and sorted in registers; to gather their members one by one takes
 * several times as long. Eight likewise, in functions marked RY_WIDE, which are called only where ry_is_wide().
 * Moves data only: the same bits on any machine. */
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

/* ---- eight ---------------------------------------------------------------------------------- */

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(RY_ONE_TARGET)
#define RY_WIDE __attribute__((target("arch=x86-64-v4")))
#define RY_HAS_WIDE __builtin_cpu_supports("x86-64-v4")
#define RY_INTRINSICS 1 /* those of AVX-512 may be used in such functions */
#else
#define RY_WIDE
#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__) && defined(__AVX512BW__)
#define RY_HAS_WIDE 1
#define RY_INTRINSICS 1
#else
#define RY_HAS_WIDE 0
#define RY_INTRINSICS 0
#endif
#endif

#if RY_INTRINSICS
#include <immintrin.h>
#endif

RY_INLINE int ry_is_wide(void)
{
    return RY_HAS_WIDE != 0;
}

typedef double ry_eight __attribute__((vector_size(8 * sizeof(double)), aligned(8)));
typedef int64_t ry_eight_index __attribute__((vector_size(8 * sizeof(int64_t))));

#if defined(__clang__) || __GNUC__ >= 12
#define RY_EIGHT_PICK(p, q, a, b, c, d, e, f, g, h) __builtin_shufflevector(p, q, a, b, c, d, e, f, g, h)
#else
#define RY_EIGHT_PICK(p, q, a, b, c, d, e, f, g, h) __builtin_shuffle(p, q, (ry_eight_index){a, b, c, d, e, f, g, h})
#endif

RY_INLINE void ry_eight_load(ry_eight *v, const double *from)
{
    memcpy(v, from, sizeof *v);
}

RY_INLINE void ry_eight_store(double *to, const ry_eight *v)
{
    memcpy(to, v, sizeof *v);
}

/* Of the four couples of each: the first and third of both go to p, the others to q. */
RY_INLINE void ry_eight_sort(ry_eight *p, ry_eight *q)
{
    const ry_eight first = RY_EIGHT_PICK(*p, *q, 0, 1, 4, 5, 8, 9, 12, 13);
    *q = RY_EIGHT_PICK(*p, *q, 2, 3, 6, 7, 10, 11, 14, 15);
    *p = first;
}

/* Rows become columns. */
RY_INLINE void ry_eight_turn(ry_eight *r)
{
    for (int k = 0; k < 8; k += 2) {
        const ry_eight even = RY_EIGHT_PICK(r[k], r[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
        r[k + 1] = RY_EIGHT_PICK(r[k], r[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
        r[k] = even;
    }
    for (int k = 0; k < 8; k += 4) {
        ry_eight_sort(&r[k], &r[k + 2]);
        ry_eight_sort(&r[k + 1], &r[k + 3]);
    }
    for (int k = 0; k < 4; k++) {
        ry_eight_sort(&r[k], &r[k + 4]);
    }
}

#endif
