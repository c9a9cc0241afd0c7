/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The plan: everything rebuilt from config and state. Its heart is the step table: one row per stage
 * that the scene needs, made once; a feature that the scene lacks has no row, no array, no branch. */
#ifndef RY_SIM_PLAN_H
#define RY_SIM_PLAN_H

#include "ryusa/config.h"
#include "stage/blocks.h"
#include "stage/contact.h"
#include "stage/flow.h"
#include "stage/measure.h"
#include "stage/motion.h"
#include "stage/neighbor.h"
#include "stage/places.h"
#include "stage/sets.h"
#include "stage/sleep.h"
#include "store/pairs.h"
#include "store/state.h"

typedef struct ry_plan ry_plan;

typedef ry_status ry_stage_fn(ry_plan *plan, ry_state *state, ry_error *error);

typedef struct ry_stage {
    const char *name;    /* as in the folder src/stage */
    const char *kernel;  /* what runs in it */
    const char *reads, *writes;
    ry_stage_fn *run;    /* NULL: a pass over the bed, which goes with that of contact */
    int pass;
    double seconds;      /* spent in the steps that were timed, one in RY_TIME_EVERY */
} ry_stage;

enum { RY_MOST_STAGES = 10, RY_TIME_EVERY = 13 };

/* What goes through the bed block by block (stage/blocks.h). */
enum {
    RY_PASS_NONE, RY_PASS_CONTACT, RY_PASS_GATHER, RY_PASS_FLUID, RY_PASS_TALLY, RY_PASS_INTEGRATE, RY_PASSES
};

struct ry_plan {
    ry_derived derived;
    int threads;
    int has_fluid, has_ledger, has_profile, has_sleep;
    int must_rebuild, timed;
    ry_pairs pairs;
    ry_blocks blocks;
    double spent[RY_PASSES]; /* by the first thread in a timed step [s] */
    ry_neighbor neighbor;
    ry_contact contact;
    ry_motion motion;
    ry_flow flow;
    ry_measure measure;
    ry_sleep sleep;
    ry_places places;
    int keeps_order;    /* grains are put in order along the bed again when they have flowed far */
    int64_t ordered_at; /* step */
    ry_sets sets;       /* see ry_plan_sets */
    double *tau_fluid; /* nz, scratch of measuring [Pa] */
    int n_stages;
    ry_stage stage[RY_MOST_STAGES];
    ry_scale scale; /* of the ledger */
    char contact_kernel[80], flow_kernel[80];
};

/* threads 0: as many as pay for this many grains. */
ry_status ry_plan_create(ry_plan *plan, const ry_config *config, ry_state *state, int threads,
                         ry_error *error);
void ry_plan_free(ry_plan *plan);

/* Fills the step table alone, without arrays, for `ryusa show`. */
void ry_plan_outline(ry_plan *plan, const ry_config *config, int sizes_differ);

/* Parts of making it: the step table; the passes over the bed. */
void ry_plan_lay_table(ry_plan *plan, const ry_config *config);
ry_status ry_plan_lay_passes(ry_plan *plan, int32_t n_grains, ry_error *error);

/* One step; timed if asked. */
ry_status ry_plan_step(ry_plan *plan, ry_state *state, int timed, ry_error *error);

/* Who is awake, as of now: the list's array of places is another one each time the list is made. */
const ry_sets *ry_plan_sets(ry_plan *plan);

/* Threads that pay for n grains on this machine. */
int ry_plan_threads(int64_t n);

/* Constants of the law as the kernels want them. */
ry_law_coef ry_plan_law(const ry_config *config, const ry_derived *derived);
ry_film ry_plan_film(const ry_config *config, const ry_derived *derived);

#endif
