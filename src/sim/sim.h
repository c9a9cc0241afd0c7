/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * One simulation: config, state, plan, and the last state that passed the check. */
#ifndef RY_SIM_SIM_H
#define RY_SIM_SIM_H

#include "ryusa/ryusa.h"
#include "sim/plan.h"

struct ry_sim {
    ry_config config; /* borrowed strings: the caller's config outlives the simulation */
    ry_state state;
    ry_state good;    /* the state at the last check (sim/kept.h); empty where it would cost too much memory */
    int keeps_good;
    int restored;     /* the state is that one again, contacts included: the list knows of others */
    int broken;       /* memory ran out within a step: the list may be half made, so nobody asks it any more */
    ry_plan plan;
    int64_t timed;    /* steps whose stages were timed */
};

/* A simulation that goes on from `state`, whose arrays it takes over. */
ry_sim *ry_sim_adopt(const ry_config *config, ry_state *state, int threads, ry_error *error);

/* Whether the state is still physical; ry_sim_step looks every 256 steps. If not, it is that of the last good check
 * again. */
ry_status ry_sim_check(ry_sim *sim, ry_error *error);

/* Whether that check would find nothing, and no more: for steps that the clock chooses, on which no bit and no failure
 * may depend. */
int ry_sim_is_sound(ry_sim *sim);

/* Brings the contacts of the state up to date; before it is saved or hashed. */
ry_status ry_sim_collect(ry_sim *sim, ry_error *error);

/* ry_sim_sample; without the elastic energies, for which all contacts must be looked at, if not `energies`. */
ry_sample ry_sim_sample_of(ry_sim *sim, int energies);

/* Adds one sample to the profile sums of the plan. */
void ry_sim_profile(ry_sim *sim);

/* From now on the bed shear stress is `tau` [Pa] (once the fluid is on): for studies that change it on
 * the way. It is no part of the state: a checkpoint doesn't know of it. */
void ry_sim_set_stress(ry_sim *sim, double tau);

#endif
