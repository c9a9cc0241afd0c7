/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * For the tests of the contact laws: two bodies on a line, stepped with a law alone, and random inputs.
 * Lengths are in any unit; velocities are ways per step, as in law/law.h. */
#ifndef RY_TESTS_LAW_BENCH_H
#define RY_TESTS_LAW_BENCH_H

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "law/all.h"
#include "law/bond.h"
#include "ryusa/config.h"

typedef ry_push law_fn(const ry_bond q, const ry_touch t);

#define RY_LAW(name, law, m, q, p, r, h, t) {#name, ry_law_##name, r, t},
static const struct {
    const char *name;
    law_fn *law;
    int rests, pulls; /* columns of laws.def */
} laws[] = {
#include "law/laws.def"
};
#undef RY_LAW

/* ---- random inputs (splitmix64: Steele et al. 2014, OOPSLA) ------------------------------------ */

static uint64_t random_state;

static void set_seed(const char *test, uint64_t seed)
{
    random_state = seed;
    printf("%s: seed %llu\n", test, (unsigned long long)seed);
}

static double evenly(double low, double high)
{
    uint64_t z = (random_state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return low + (high - low) * ((double)((z ^ (z >> 31)) >> 11) * 0x1p-53);
}

static double evenly_log(double low, double high)
{
    return exp(evenly(log(low), log(high)));
}

/* ---- an impact ------------------------------------------------------------------------------- */

/* Damping ratio of a spring and dashpot that may pull: e = exp(-pi zeta/sqrt(1 - zeta^2)), solved. */
static double usual_zeta(double e)
{
    const double loss = -log(e);
    return loss / sqrt(M_PI * M_PI + loss * loss);
}

typedef struct impact {
    double e;       /* speed of parting over speed of approach, as measured */
    double loss;    /* booked as lost by restitution, over the energy of approach */
    double drift;   /* change of momentum over (m_i + m_j) w */
    int steps;      /* steps in touch */
    double deepest; /* largest overlap */
} impact;

typedef struct entry {
    double w, d;       /* approach and overlap when the contact is first seen, 0 < d <= w */
    double im_i, im_j; /* inverse masses; im_j = 0: a wall */
    double centre;     /* common velocity of both */
    int most;          /* steps at which to stop; 0: when they are apart */
} entry;

/* Runs an impact until the bodies are apart, with the memory that stage/contact.c keeps. */
static impact collide(law_fn *law, ry_bond q, entry in)
{
    const double ims = in.im_i + in.im_j;
    double v_i = in.centre + in.w * in.im_i / ims, v_j = in.centre - in.w * in.im_j / ims;
    const double closing = v_i - v_j;
    ry_touch t = {.d = in.d, .split = 1.0};
    impact out = {0};
    const int most = in.most > 0 ? in.most : 50000000;
    while (t.d > 0.0 && out.steps < most) {
        t.w = v_i - v_j;
        const ry_push p = law(q, t);
        v_i += p.f * in.im_i / ims;
        v_j -= p.f * in.im_j / ims;
        out.loss += p.impact;
        out.deepest = fmax(out.deepest, t.d);
        t.d += p.shift + (v_i - v_j);
        t.rest = p.rest;
        t.pushed = p.pushed;
        t.then = v_i - v_j;
        t.age = fmin(t.age + 1.0, RY_AGE_MAX);
        out.steps++;
    }
    out.e = -(v_i - v_j) / closing;
    out.loss /= 0.5 * closing * closing;
    if (in.im_j > 0.0) { /* per m_r w: of order one for any masses */
        const double before = (in.centre + in.w * in.im_i / ims) / in.im_i +
                              (in.centre - in.w * in.im_j / ims) / in.im_j;
        out.drift = (v_i / in.im_i + v_j / in.im_j - before) / (fabs(before) + in.w / ims);
    }
    return out;
}

/* A wall is met at w = 1 with the overlap `phase`, 0 < phase <= 1. */
static impact collide_wall(law_fn *law, ry_bond q, double phase)
{
    return collide(law, q, (entry){.w = 1.0, .d = phase, .im_i = 1.0});
}

#endif
