/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * FFTW runs plans in parallel but makes them, and destroys them, one at a time: in between these two. */
#ifndef RY_ANALYSIS_PLANNER_H
#define RY_ANALYSIS_PLANNER_H

void ry_planner_take(void);
void ry_planner_leave(void);

#endif
