/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * For the tests of contact.sleep. */
#ifndef RY_TESTS_SLEEP_BENCH_H
#define RY_TESTS_SLEEP_BENCH_H

#include "scene_bench.h"
#include "sim/sim.h"

static int movable(const scene *s)
{
    return s->sim->state.grains.n - s->sim->plan.sleep.n_fixed;
}

/* Part of the grains that can move and sleep now. */
static double asleep(const scene *s)
{
    const int sleepers = s->sim->state.grains.n - s->sim->plan.motion.n_awake - s->sim->plan.sleep.n_fixed;
    return (double)sleepers / movable(s);
}

#endif
