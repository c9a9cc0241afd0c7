/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/each.h"

#include <limits.h>
#include <stddef.h>

#ifdef _OPENMP
#include <omp.h>
#endif

static int cores(void)
{
#ifdef _OPENMP
    return omp_get_num_procs();
#else
    return 1;
#endif
}

typedef struct first_failure {
    int index;
    ry_status status;
    ry_error error;
} first_failure;

static void keep(first_failure *first, int index, ry_status status, const ry_error *error)
{
#pragma omp critical
    if (index < first->index) {
        *first = (first_failure){index, status, *error};
    }
}

static int has_failed(const first_failure *first)
{
    int failed;
#pragma omp critical
    failed = first->index != INT_MAX;
    return failed;
}

ry_status ry_each(int n, int threads, ry_each_fn *fn, void *data, ry_error *error)
{
    first_failure first = {.index = INT_MAX, .status = RY_OK};
    const int team = threads > 0 ? threads : cores();
    (void)team; /* without OpenMP there is one thread */
#pragma omp parallel for num_threads(team) schedule(dynamic, 1) if (team > 1)
    for (int k = 0; k < n; k++) {
        ry_error own = {0};
        const ry_status status = has_failed(&first) ? RY_OK : fn(data, k, &own);
        if (status != RY_OK) {
            keep(&first, k, status, &own);
        }
    }
    if (first.status != RY_OK && error != NULL && error->status == RY_OK) {
        *error = first.error;
    }
    return first.status;
}
