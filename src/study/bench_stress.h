/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * One case of the stability maps: a scene, how it is run, and how its behaviour is classed. */
#ifndef RY_STUDY_BENCH_STRESS_H
#define RY_STUDY_BENCH_STRESS_H

#include "study/bench_private.h"

/* From harmless to worst; a case that consists of several scenes has the worst of their classes.
 * RY_CLASS(name, "word", "when") */
#define RY_LIST_stress_class(RY_CLASS)                                                             \
    RY_CLASS(REFUSED, "refused", "the scene is refused before it is run, with the limit")          \
    RY_CLASS(QUIET, "quiet", "kinetic energy per grain at most 1e-9 m g' d in the end")            \
    RY_CLASS(SETTLES, "settles", "not yet quiet, but it fell by half or more in the last quarter") \
    RY_CLASS(JITTERS, "jitters", "kinetic energy per grain above 1e-9 m g' d, and not falling")    \
    RY_CLASS(LEAKS, "leaks", "the time stepping loses more than 1 % of what is lost otherwise")    \
    RY_CLASS(GAINS, "gains", "the time stepping gains more than 1 % of what is lost otherwise")    \
    RY_CLASS(                                                                                      \
        PRESSED, "pressed through",                                                                \
        "stopped: contacts too soft for the load, grains within each other; no energy gained")     \
    RY_CLASS(EXPLODES, "explodes", "stopped as unphysical, or gains more than all losses")

#define RY_CLASS_ENUM(name, word, text) RY_STRESS_##name,
typedef enum { RY_LIST_stress_class(RY_CLASS_ENUM) RY_STRESS_COUNT } ry_stress_class;
#undef RY_CLASS_ENUM

#define RY_STRESS_QUIET_ENERGY 1e-9 /* of a grain [m g' d] */
#define RY_STRESS_TOLERANCE 0.01    /* of the losses */
#define RY_STRESS_SOFT 0.1          /* of the losses: less is no gain, in a run that was stopped */

typedef struct ry_stress {
    ry_stress_class class;
    double kinetic; /* per grain, mean of the last quarter of the time [m g' d]; NAN: not judged */
    double integration; /* row of the ledger at the end, over `scale` */
    double rise;        /* largest rise of the energy, less the fluid's work, over `scale` */
    char message[200];  /* of a scene that was refused or stopped */
} ry_stress;

typedef struct ry_stress_wish {
    long long steps;
    int must_rest; /* a scene without a drive: it should come to rest */
} ry_stress_wish;

/* Resolves `config` and runs it on one thread. Only failures of memory are failures. */
ry_status ry_stress_run(ry_config *config, ry_stress_wish wish, ry_stress *out, ry_error *error);

/* Takes over what is worse in `other`. */
void ry_stress_merge(ry_stress *one, const ry_stress *other);

#endif
