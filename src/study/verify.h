/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa verify`: section 5 of Fujioka & Ushijima (2005), "the paper", run by the simulator itself and
 * held against exact values and against what the paper prints. docs/verify.md tells the outcome. */
#ifndef RY_STUDY_VERIFY_H
#define RY_STUDY_VERIFY_H

#include "ryusa/ryusa.h"

/* RY_CASE(name in C, "name on the command line", "what it reproduces") */
#define RY_LIST_verify_case(RY_CASE)                                                         \
    RY_CASE(slow_bounce, "slow-bounce", "section 5.2, Fig. 4: energy kept by slow bounces")  \
    RY_CASE(fast_bounce, "fast-bounce", "section 5.3, Fig. 5: energy kept by fast bounces")  \
    RY_CASE(phase_space, "phase-space", "section 5.3, Figs. 6 and 7: tracks in phase space") \
    RY_CASE(cost, "cost", "section 5.4, Table 1: cost of a contact evaluation")              \
    RY_CASE(steps, "steps", "section 5.5, Table 2: steps of a contact against dt")           \
    RY_CASE(three_spheres, "three-spheres", "section 5.6, Figs. 10 and 11: d' and T0 against dt")

#define RY_CASE_ENUM(name, word, text) RY_VERIFY_##name,
enum { RY_LIST_verify_case(RY_CASE_ENUM) RY_VERIFY_CASES };
#undef RY_CASE_ENUM

/* The word of a case, and what it reproduces. */
const char *ry_verify_case_word(int index);
const char *ry_verify_case_text(int index);

typedef struct ry_verify_options {
    unsigned cases;     /* bit RY_VERIFY_...: that case; 0: all */
    const char *output; /* HDF5 file */
    int force;          /* replace it if it is there */
    int quick;          /* fewer time steps and shorter timings */
    int threads;        /* 0: as many as there are cores */
    ry_write_fn *write; /* gets the tables, piece by piece */
    void *data;
} ry_verify_options;

typedef struct ry_verify_summary {
    int ok, differs, failed; /* claims that hold; that don't, for a reason we know; that don't */
    double seconds;
} ry_verify_summary;

/* RY_OK also with failed claims: see summary->failed. */
ry_status ry_verify(const ry_verify_options *options, ry_verify_summary *summary, ry_error *error);

#endif
