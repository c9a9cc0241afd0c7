/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "analysis/planner.h"

#include <pthread.h>

static pthread_mutex_t planner = PTHREAD_MUTEX_INITIALIZER;

void ry_planner_take(void)
{
    pthread_mutex_lock(&planner);
}

void ry_planner_leave(void)
{
    pthread_mutex_unlock(&planner);
}
