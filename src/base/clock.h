/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#ifndef RY_BASE_CLOCK_H
#define RY_BASE_CLOCK_H

/* Seconds of wall time since some fixed moment. */
double ry_clock(void);

#endif
