/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/parallel.h"

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
