/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Time of one evaluation of a contact law: overlap and approach in, force out, nothing else. */
#ifndef RY_STUDY_VERIFY_LAW_TIME_H
#define RY_STUDY_VERIFY_LAW_TIME_H

/* law: as in ryusa/config.h. Best of `rounds` rounds; one contact after another (`one_by_one`), or as
 * the simulator does it, many side by side [s]. */
double ry_verify_law_time(int law, int rounds, int one_by_one);

#endif
