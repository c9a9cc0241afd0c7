/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Processes that share one sweep, on one machine or on many, as mpirun starts them. They all see the
 * same folder; process 0 hands out the cases. What carries their messages is not known here
 * (cli/mpi.h): whole messages, in order between any two processes, none lost while both live. */
#ifndef RY_STUDY_FARM_H
#define RY_STUDY_FARM_H

typedef struct ry_farm {
    int rank, size;
    int cores;     /* that this process may use */
    int all_cores; /* that all of them may use */
    void *data;
    /* Returns at once; the bytes are copied. A receiver that is gone is no failure. */
    void (*send)(void *data, int to, const void *bytes, int n);
    /* The next message that has arrived, its sender, and its length: 0 if there is none. */
    int (*receive)(void *data, int *from, void *bytes, int capacity);
} ry_farm;

#endif
