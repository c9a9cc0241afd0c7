/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a measured time belongs to. */
#ifndef RY_STUDY_BENCH_MACHINE_H
#define RY_STUDY_BENCH_MACHINE_H

typedef struct ry_machine {
    char processor[120], compiler[120];
    int cores;
    double load; /* of the last minute: what else was going on */
} ry_machine;

ry_machine ry_machine_describe(void);

/* Bytes that are allocated now; 0 where the C library does not tell. */
double ry_machine_heap(void);

#endif
