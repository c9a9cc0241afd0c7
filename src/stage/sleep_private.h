/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What stage/sleep.c asks of stage/sleep_sets.c. */
#ifndef RY_STAGE_SLEEP_PRIVATE_H
#define RY_STAGE_SLEEP_PRIVATE_H

#include "stage/sleep.h"

/* New orders, in places->was, and motion->n_awake with them. Those that woke change places with the first sleepers;
 * or all come back to the order asked for, those awake first. */
void ry_sleep_order_woken(ry_sleep *sleep);
void ry_sleep_order_all(ry_sleep *sleep);

/* The sets, when grains have changed places. */
void ry_sleep_list_sets(ry_sleep *sleep);

/* Of all contacts in the state those of two sleepers; those of the list between grains that now sleep, with their
 * impulses of this step; back to the list those of which a grain has woken. */
ry_status ry_sleep_take_frozen(ry_sleep *sleep, ry_error *error);
ry_status ry_sleep_freeze(ry_sleep *sleep, ry_error *error);
void ry_sleep_thaw(ry_sleep *sleep);

/* What the frozen contacts give each grain. */
void ry_sleep_sum_frozen(ry_sleep *sleep);

#endif
