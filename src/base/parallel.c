/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

void ry_parallel(int threads, int32_t n, ry_range_fn *task, void *context)
{
    if (threads <= 1) {
        task(context, 0, n, 0);
        return;
    }
#pragma omp parallel for num_threads(threads) schedule(static, 1)
    for (int t = 0; t < threads; t++) {
        task(context, (int32_t)((int64_t)n * t / threads), (int32_t)((int64_t)n * (t + 1) / threads), t);
    }
}

static void all_parts(int parts, int phases, ry_phase_fn *task, void *context)
{
    for (int phase = 0; phase < phases; phase++) {
        for (int part = 0; part < parts; part++) {
            task(context, phase, part);
        }
    }
}

void ry_phases(int parts, int phases, ry_phase_fn *task, void *context)
{
#ifdef _OPENMP
    if (parts > 1) {
#pragma omp parallel num_threads(parts)
        for (int phase = 0; phase < phases; phase++) {
            for (int part = omp_get_thread_num(); part < parts; part += omp_get_num_threads()) {
                task(context, phase, part); /* there may be fewer threads than were asked for */
            }
#pragma omp barrier
        }
        return;
    }
#endif
    all_parts(parts, phases, task, context);
}
