/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The loops are stamped from laws.def, as the pair loop of the simulator is. */
#include "study/verify_law_time.h"

#include <math.h>

#include "base/clock.h"
#include "law/all.h"

enum { CONTACTS = 128, REPEATS = 500 };

typedef struct touches {
    ry_bond bond;
    double d[CONTACTS], w[CONTACTS], age[CONTACTS], f[CONTACTS], shift[CONTACTS];
} touches;

typedef void evaluate_fn(touches *t);

/* Empty, but the compiler can't know: memory may have changed. */
#define FENCE(pointer) __asm__ volatile("" : : "r"(pointer) : "memory")

#define EVALUATE(name)                                                                   \
    const ry_touch touch = {.d = t->d[k], .w = t->w[k], .age = t->age[k], .split = 1.0}; \
    const ry_push push = ry_law_##name(t->bond, touch);                                  \
    t->f[k] = push.f;                                                                    \
    t->shift[k] = push.shift

#define RY_LAW(name, law, ...)                     \
    RY_CLONES static void together_##name(touches *t) \
    {                                                 \
        for (int k = 0; k < CONTACTS; k++) {          \
            EVALUATE(name);                           \
        }                                             \
    }                                                 \
    static void alone_##name(touches *t)              \
    {                                                 \
        for (int k = 0; k < CONTACTS; k++) {          \
            EVALUATE(name);                           \
            FENCE(t);                                 \
        }                                             \
    }
#include "law/laws.def"
#undef RY_LAW

static evaluate_fn *const evaluate[][2] = {
#define RY_LAW(name, law, ...) {together_##name, alone_##name},
#include "law/laws.def"
#undef RY_LAW
};

/* States of all modes: s from -2 to 2. */
static void fill(touches *t)
{
    t->bond = (ry_bond){
        .a = 0.104, .c = 0.0728, .e = 0.7, .stretch = 0.1, .drag = 0.1, .mass_ratio = 1.0};
    for (int k = 0; k < CONTACTS; k++) {
        const double s = 4.0 * ((k * 37) % CONTACTS) / CONTACTS - 2.0;
        t->d[k] = 1e-3 * (1.0 + k % 7);
        t->w[k] = s * t->d[k];
        t->age[k] = s >= 1.0 ? 0.0 : 1.0 + k % 3;
    }
}

double ry_verify_law_time(int law, int rounds, int one_by_one)
{
    touches t;
    double best = INFINITY;
    fill(&t);
    for (int r = 0; r < rounds; r++) {
        const double start = ry_clock();
        for (int n = 0; n < REPEATS; n++) {
            evaluate[law][one_by_one](&t);
            FENCE(&t);
        }
        best = fmin(best, ry_clock() - start);
    }
    return best / ((double)REPEATS * CONTACTS);
}
