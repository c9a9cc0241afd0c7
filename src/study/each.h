/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Many independent pieces of work, such as simulations, spread over threads. */
#ifndef RY_STUDY_EACH_H
#define RY_STUDY_EACH_H

#include "ryusa/status.h"

/* Does piece `index`. Must touch nothing that another piece touches. */
typedef ry_status ry_each_fn(void *data, int index, ry_error *error);

/* Calls fn(data, 0..n-1) on `threads` threads (0: as many as there are cores), the next index to
 * whichever is free. Returns the failure of the lowest index; after one, no new piece is begun. */
ry_status ry_each(int n, int threads, ry_each_fn *fn, void *data, ry_error *error);

#endif
