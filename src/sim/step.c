/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A step: the table of its stages, of which one goes through the bed and has several passes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "config/laws.h"
#include "sim/plan.h"
#include "stage/skin.h"

/* ---- stages before ---------------------------------------------------------------------------- */

/* Grains that have flowed lie far in memory from those around them, and their blocks are late: they are put in order
 * along the bed again, if many blocks are and the last time is some while ago. */
enum { ORDER_EVERY = 1000, FEW_FAR = 16 };

static int is_out_of_order(const ry_plan *plan, const ry_state *state)
{
    const ry_blocks *const b = &plan->blocks;
    return plan->keeps_order && !b->apart && plan->contact.large && b->n_far > b->n / FEW_FAR &&
           state->step >= plan->ordered_at + ORDER_EVERY;
}

static ry_status put_in_order(ry_plan *plan, ry_state *state, ry_error *error)
{
    ry_places *const o = &plan->places;
    const ry_grains *const g = &state->grains;
    ry_status status = ry_places_make_room(o, g->n, error);
    if (status == RY_OK) {
        status = ry_places_along_bed(o, g, plan->pairs.place, plan->derived.d, error);
    }
    if (status == RY_OK) {
        ry_places_change(o, &plan->pairs);
        ry_motion_settle(&plan->motion, g);
        plan->neighbor.was = o->was;
        status = ry_neighbor_rebuild(&plan->neighbor, g, &plan->pairs, error);
        plan->neighbor.was = NULL;
    }
    ry_places_give_back(o);
    plan->ordered_at = state->step;
    return status;
}

static ry_status run_neighbor(ry_plan *plan, ry_state *state, ry_error *error)
{
    if (plan->must_rebuild) {
        ry_contact_close_list(&plan->contact, &state->grains, &plan->pairs);
        ry_skin_tune(&plan->neighbor, &plan->pairs, state->step);
        RY_TRY(is_out_of_order(plan, state)
                   ? put_in_order(plan, state, error)
                   : ry_neighbor_rebuild(&plan->neighbor, &state->grains, &plan->pairs, error));
        plan->must_rebuild = 0;
    }
    return RY_OK;
}

static ry_status run_column(ry_plan *plan, ry_state *state, ry_error *error)
{
    (void)error;
    const double highest = plan->motion.highest + plan->neighbor.radius_max;
    ry_flow_reach(&plan->flow, &state->column, highest);
    if (state->step % plan->flow.advance == 0) {
        ry_flow_advance(&plan->flow, state, &plan->motion, ry_plan_sets(plan));
        ry_flow_reach(&plan->flow, &state->column, highest); /* who flies above the column is in no cell of it */
    }
    return RY_OK;
}

/* ---- passes over the bed ---------------------------------------------------------------------- */

typedef struct ry_bed {
    ry_plan *plan;
    ry_state *state;
} ry_bed;

static void run_contact(void *context, int32_t first, int32_t end, int chunk)
{
    const ry_bed *const bed = context;
    ry_contact_push(&bed->plan->contact, &bed->state->grains, &bed->plan->pairs, first, end, chunk);
}

static void run_young(void *context, int32_t begin, int32_t end, ry_way way, int chunk)
{
    const ry_bed *const bed = context;
    const ry_contact *const c = &bed->plan->contact;
    const ry_grains *const g = &bed->state->grains;
    ry_pairs *const pairs = &bed->plan->pairs;
    (void)way;
    ry_contact_push_young(c, g, pairs, pairs->row[begin], pairs->row[end], chunk);
    if (end == g->n) {
        ry_contact_push_young(c, g, pairs, pairs->n_inner, pairs->n, pairs->n_chunks);
    }
}

static void run_gather(void *context, int32_t begin, int32_t end, ry_way way, int chunk)
{
    const ry_bed *const bed = context;
    const ry_motion *const m = &bed->plan->motion;
    const int32_t awake = end < m->n_awake ? end : m->n_awake;
    if (begin < awake) {
        ry_motion_gather(m, &bed->plan->pairs, begin, awake, way, chunk);
    }
}

static void run_fluid(void *context, int32_t begin, int32_t end, ry_way way, int chunk)
{
    const ry_bed *const bed = context;
    const ry_motion *const m = &bed->plan->motion;
    const int32_t awake = end < m->n_awake ? end : m->n_awake;
    (void)way;
    if (begin < awake) {
        ry_flow_sample(&bed->plan->flow, &bed->state->grains, m, begin, awake, chunk);
    }
}

static void run_tally(void *context, int32_t begin, int32_t end, ry_way way, int chunk)
{
    const ry_bed *const bed = context;
    (void)way;
    ry_measure_tally(&bed->plan->measure, &bed->plan->motion, begin, end, chunk);
}

static void run_integrate(void *context, int32_t begin, int32_t end, ry_way way, int chunk)
{
    const ry_bed *const bed = context;
    const ry_motion *const m = &bed->plan->motion;
    const ry_neighbor *const b = &bed->plan->neighbor;
    const int32_t awake = end < m->n_awake ? end : m->n_awake;
    (void)way;
    if (begin < awake) {
        ry_motion_integrate(m, &bed->state->grains, b->x0, b->z0, b->limit2, begin, awake, chunk);
    }
}

static void add_pass(ry_plan *plan, ry_pass_fn *run, int around, int any_length, int pass)
{
    ry_blocks *const b = &plan->blocks;
    b->pass[b->n_passes++] =
        (ry_pass){.run = run, .around = around, .any_length = any_length, .seconds = &plan->spent[pass]};
}

ry_status ry_plan_lay_passes(ry_plan *plan, int32_t n_grains, ry_error *error)
{
    ry_blocks *const b = &plan->blocks;
    const int young = plan->contact.young != NULL;
    *b = (ry_blocks){.threads = plan->threads, .apart = plan->has_sleep || plan->neighbor.n_walls > 0,
                     .push = run_contact, .push_seconds = &plan->spent[RY_PASS_CONTACT]};
    if (young) {
        add_pass(plan, run_young, 1, 1, RY_PASS_CONTACT);
    }
    add_pass(plan, run_gather, young, 0, RY_PASS_GATHER);
    if (plan->has_fluid) {
        add_pass(plan, run_fluid, 0, 0, RY_PASS_FLUID);
    }
    if (plan->has_profile) {
        add_pass(plan, run_tally, 0, 0, RY_PASS_TALLY);
    }
    add_pass(plan, run_integrate, 0, 0, RY_PASS_INTEGRATE);
    return ry_blocks_create(b, n_grains, error);
}

static ry_status go_through_bed(ry_plan *plan, ry_state *state, ry_error *error)
{
    ry_bed bed = {plan, state};
    (void)error;
    if (plan->has_profile) {
        ry_measure_begin(&plan->measure, state);
    }
    ry_motion_begin(&plan->motion);
    ry_contact_begin(&plan->contact, &state->grains, &plan->pairs);
    ry_blocks_run(&plan->blocks, &plan->pairs, &bed, plan->timed);
    ry_contact_end(&plan->contact, &plan->pairs);
    plan->must_rebuild = ry_motion_end(&plan->motion, &state->ledger);
    return RY_OK;
}

/* ---- the last stage --------------------------------------------------------------------------- */

static ry_status run_sleep(ry_plan *plan, ry_state *state, ry_error *error)
{
    (void)state;
    const int64_t before = plan->neighbor.rebuilds;
    RY_TRY(ry_sleep_stage(&plan->sleep, error));
    plan->must_rebuild = plan->must_rebuild && plan->neighbor.rebuilds == before;
    return RY_OK;
}

/* ---- the table -------------------------------------------------------------------------------- */

static void add_stage(ry_plan *plan, const char *name, const char *kernel, const char *reads, const char *writes,
                      ry_stage_fn *run)
{
    plan->stage[plan->n_stages++] = (ry_stage){name, kernel, reads, writes, run, RY_PASS_NONE, 0.0};
}

/* Contacts are the stage that goes through the bed, with all other passes; these have rows of their own. */
static void add_row(ry_plan *plan, int pass, const char *name, const char *kernel, const char *reads,
                    const char *writes)
{
    add_stage(plan, name, kernel, reads, writes, pass == RY_PASS_CONTACT ? go_through_bed : NULL);
    plan->stage[plan->n_stages - 1].pass = pass;
}

static void name_kernels(ry_plan *plan, const ry_config *config)
{
    const int f = plan->contact.features;
    snprintf(plan->contact_kernel, sizeof plan->contact_kernel, "%s%s%s%s%s",
             ry_laws[config->contact_law].word, f & RY_CONTACT_FRICTION ? " + friction" : "",
             f & RY_CONTACT_SIZES ? " + sizes" : "", config->contact_wet ? " + wet" : "",
             f & RY_CONTACT_LEDGER ? " + ledger" : "");
#define RY_NAME(value, word) word,
    static const char *const models[] = {RY_LIST_fluid(RY_NAME)};
    static const char *const drags[] = {RY_LIST_drag(RY_NAME)};
#undef RY_NAME
    snprintf(plan->flow_kernel, sizeof plan->flow_kernel, "%s, %s%s%s", models[config->fluid_model],
             drags[config->fluid_drag], config->fluid_lift > 0.0 ? " + lift" : "", plan->flow.walks ? " + eddies" : "");
}

void ry_plan_lay_table(ry_plan *plan, const ry_config *config)
{
    name_kernels(plan, config);
    plan->n_stages = 0;
    add_stage(plan, "neighbor", "cells + Verlet list, when due", "positions", "pairs, their memory", run_neighbor);
    if (plan->has_fluid) {
        add_stage(plan, "column", plan->flow_kernel, "grains", "fluid column", run_column);
    }
    add_row(plan, RY_PASS_CONTACT, "contact", plan->contact_kernel, "pairs, grains", "impulses and memory per pair");
    add_row(plan, RY_PASS_GATHER, "gather", plan->motion.moves ? "impulses + shifts" : "impulses", "pairs",
            "impulse per grain");
    if (plan->has_fluid) {
        add_row(plan, RY_PASS_FLUID, "fluid", plan->flow_kernel, "grains, fluid column", "gravity + fluid per grain");
    }
    if (plan->has_profile) {
        add_row(plan, RY_PASS_TALLY, "tally", "contact stress", "impulses", "impulse since the last sample");
    }
    add_row(plan, RY_PASS_INTEGRATE, "integrate", "kick, drift",
            plan->has_fluid ? "impulses, gravity + fluid" : "impulses, gravity", "velocities, positions");
    if (plan->has_sleep) {
        add_stage(plan, "sleep", "wakes by force, sleeps at rest", "impulses, gravity + fluid", "who is skipped",
                  run_sleep);
    }
}

/* ---- a step ----------------------------------------------------------------------------------- */

/* Time spent in the bed goes to the passes' rows, as the first thread has spent it. */
static void share_time(ry_plan *plan, double seconds)
{
    double all = 1e-12;
    for (int p = 0; p < RY_PASSES; p++) {
        all += plan->spent[p];
    }
    for (int s = 0; s < plan->n_stages; s++) {
        plan->stage[s].seconds += plan->spent[plan->stage[s].pass] * seconds / all;
    }
    memset(plan->spent, 0, sizeof plan->spent);
}

/* Lists are made in few steps, which may be none of those that are timed, or all of them: each list is timed, and
 * counts as its share of a timed step. */
ry_status ry_plan_step(ry_plan *plan, ry_state *state, int timed, ry_error *error)
{
    const int lists = plan->must_rebuild;
    double before = timed || lists ? ry_clock() : 0.0;
    plan->timed = timed;
    for (int s = 0; s < plan->n_stages; s++) {
        ry_stage *const row = &plan->stage[s];
        if (row->run == NULL) {
            continue;
        }
        RY_TRY(row->run(plan, state, error));
        const int makes_lists = row->run == run_neighbor;
        if (timed || (lists && makes_lists)) {
            const double now = ry_clock();
            if (makes_lists) {
                row->seconds += (now - before) / RY_TIME_EVERY;
            } else if (row->pass == RY_PASS_NONE) {
                row->seconds += now - before;
            } else {
                share_time(plan, now - before);
            }
            before = now;
        }
    }
    state->step++;
    state->time = (double)state->step * plan->motion.dt;
    return RY_OK;
}
