/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What this machine needs at least for a step: the arithmetic on data that lie side by side in the nearest
 * cache, at full vector width, and the moving of what must be read and written, whichever takes longer. */
#ifndef RY_STUDY_BENCH_LIMIT_H
#define RY_STUDY_BENCH_LIMIT_H

#include <stddef.h>

#include "ryusa/config.h"

/* Seconds per contact: geometry, coefficients of two unequal grains, law, friction. */
double ry_limit_contact(ry_law law, int threads);

/* Seconds per grain: kick and drift, and with `fluid` its drag. */
double ry_limit_grain(int fluid, int threads);

/* Seconds per byte that is read or written, all threads together, on `bytes` bytes of data. */
double ry_limit_move(size_t bytes, int threads);

/* Bytes that a step must read and write: of a grain x, z, vx, vz, spin (both) and the radius (read), and
 * of a contact its partners (read), the stretch of its spring and, where the law has them, rest and age (both). */
double ry_limit_bytes(ry_law law, double contacts_per_grain);

#endif
