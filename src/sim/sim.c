/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "sim/sim.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "config/laws.h"
#include "scene/scene.h"
#include "sim/kept.h"

enum { CHECK_EVERY = 256 }; /* steps between checks that the state is still physical */
/* Larger simulations keep no second state in memory: after a failure their last checkpoint is left. */
enum { MOST_TO_KEEP = 200000 };

/* ---- order in memory ------------------------------------------------------------------------- */

typedef struct ry_key {
    int last;
    double key;
    int32_t id;
} ry_key;

static int compare_keys(const void *a, const void *b)
{
    const ry_key *const p = a, *const q = b;
    if (p->last != q->last) {
        return p->last - q->last;
    }
    return p->key < q->key ? -1 : (p->key > q->key ? 1 : p->id - q->id);
}

/* Puts the grains of a state, which is in id order, into the order asked for; those that sleep come last. Grains of
 * which there is no bed stay in the order in which they were given. */
static ry_status order_grains(ry_state *state, const ry_config *config, double d, ry_error *error)
{
    ry_grains *const g = &state->grains;
    const uint8_t *const asleep = state->sleepers.asleep;
    const int bed = config->numerics_order == RY_ORDER_BED && config->has_grains;
    const int by_id = !bed && config->numerics_order != RY_ORDER_SHUFFLED;
    if (by_id && asleep == NULL) {
        return RY_OK;
    }
    ry_key *const keys = ry_array((size_t)g->n, sizeof *keys);
    ry_state copy = {0};
    if (keys == NULL || ry_state_create(&copy, g->n, 0, 0, error) != RY_OK) {
        free(keys);
        return ry_no_memory(error, (size_t)g->n * sizeof *keys);
    }
    if (asleep != NULL && ry_state_add_sleepers(&copy, error) != RY_OK) {
        free(keys);
        ry_state_free(&copy);
        return error->status;
    }
    for (int32_t k = 0; k < g->n; k++) {
        keys[k] = (ry_key){asleep != NULL && asleep[k],
                           by_id ? k : bed ? floor(g->x[k] / d)
                               : ry_random((uint32_t)config->grains_seed, RY_RANDOM_ORDER, (uint64_t)g->id[k]), k};
    }
    qsort(keys, (size_t)g->n, sizeof *keys, compare_keys);
    for (int32_t k = 0; k < g->n; k++) {
#define RY_GRAIN_MOVE(type, name, unit, text) copy.grains.name[k] = g->name != NULL ? g->name[keys[k].id] : 0;
        RY_GRAIN_FIELDS(RY_GRAIN_MOVE)
#undef RY_GRAIN_MOVE
#define RY_SLEEP_MOVE(type, name, unit, text) copy.sleepers.name[k] = state->sleepers.name[keys[k].id];
        if (asleep != NULL) {
            RY_SLEEP_FIELDS(RY_SLEEP_MOVE)
        }
#undef RY_SLEEP_MOVE
    }
    const ry_grains grains = state->grains;
    state->grains = copy.grains;
    copy.grains = grains;
    const ry_sleepers sleepers = state->sleepers;
    state->sleepers = copy.sleepers;
    copy.sleepers = sleepers;
    ry_state_free(&copy);
    free(keys);
    return RY_OK;
}

/* ---- making ---------------------------------------------------------------------------------- */

static double total_energy(const ry_sample *s)
{
    return s->kinetic_energy + s->gravity_energy + s->elastic_normal + s->elastic_tangential;
}

static ry_status set_up(ry_sim *sim, int threads, ry_error *error)
{
    const ry_state *const state = &sim->state;
    const int is_new = state->step == 0;
    if (sim->config.contact_sleep > 0.0 && sim->state.sleepers.asleep == NULL) {
        RY_TRY(ry_state_add_sleepers(&sim->state, error));
    }
    RY_TRY(order_grains(&sim->state, &sim->config, ry_config_derive(&sim->config).d, error));
    if (sim->config.fluid_model != RY_FLUID_STRESS && sim->config.fluid_model != RY_FLUID_BALANCE) {
        free(sim->state.grains.push);
        sim->state.grains.push = NULL;
    }
    if (sim->config.fluid_turbulence == RY_TURBULENCE_NONE || sim->config.fluid_model == RY_FLUID_NONE) {
        free(sim->state.grains.met);
        sim->state.grains.met = NULL;
    }
    RY_TRY(ry_plan_create(&sim->plan, &sim->config, &sim->state, threads, error));
    sim->keeps_good = state->grains.n <= MOST_TO_KEEP;
    if (is_new) {
        const ry_sample first = ry_sim_sample(sim);
        sim->state.ledger.energy_start = total_energy(&first);
    }
    if (sim->keeps_good) {
        RY_TRY(ry_kept_create(&sim->good, state, error));
        sim->good.contacts.no_rest = sim->plan.pairs.rest == NULL;
        RY_TRY(ry_contacts_copy(&sim->good.contacts, &state->contacts, error));
    }
    ry_contacts_free(&sim->state.contacts); /* the list has them, until somebody asks */
    return RY_OK;
}

ry_sim *ry_sim_adopt(const ry_config *config, ry_state *state, int threads, ry_error *error)
{
    ry_sim *const sim = ry_array(1, sizeof *sim);
    if (sim == NULL) {
        ry_no_memory(error, sizeof *sim);
        ry_state_free(state);
        return NULL;
    }
    sim->config = *config;
    sim->state = *state;
    *state = (ry_state){0};
    if (set_up(sim, threads, error) != RY_OK) {
        ry_sim_free(sim);
        return NULL;
    }
    return sim;
}

ry_sim *ry_sim_create(const ry_config *config, int threads, ry_error *error)
{
    ry_state state = {0};
    if (ry_scene_build(config, &state, error) != RY_OK) {
        ry_state_free(&state);
        return NULL;
    }
    return ry_sim_adopt(config, &state, threads, error);
}

void ry_sim_set_stress(ry_sim *sim, double tau)
{
    sim->plan.flow.tau = tau;
    sim->plan.flow.tau_start = tau;
}

void ry_sim_free(ry_sim *sim)
{
    if (sim != NULL) {
        ry_plan_free(&sim->plan);
        ry_state_free(&sim->state);
        ry_state_free(&sim->good);
        free(sim);
    }
}

/* ---- keeping a state ------------------------------------------------------------------------- */

static ry_status refuse_broken(const ry_sim *sim, ry_error *error)
{
    return !sim->broken ? RY_OK : ry_fail(error, RY_BAD_FILE, "out of memory in step %lld, from where nothing goes on",
                                          (long long)sim->state.step);
}

/* What nobody has looked at may not be computed yet; it is no less part of the state. */
static void complete_column(const ry_sim *sim)
{
    if (sim->plan.has_fluid && !sim->restored) {
        ry_sim *const own = (ry_sim *)sim;
        ry_flow_complete(&own->plan.flow, &own->state.column);
    }
}

static ry_status export_contacts(ry_sim *sim, ry_contacts *to, ry_error *error)
{
    ry_contact_close(&sim->plan.contact, &sim->state.grains, &sim->plan.pairs);
    RY_TRY(ry_pairs_export(&sim->plan.pairs, sim->state.grains.id, to, error));
    return sim->plan.has_sleep ? ry_sleep_export(&sim->plan.sleep, to, error) : RY_OK;
}

/* ---- stepping -------------------------------------------------------------------------------- */

/* By alpha_m a smaller step makes contacts stiffer: there it helps nobody. */
static const char *what_may_help(const ry_sim *sim, int too_soft)
{
    const ry_config *const c = &sim->config;
    const int by_alpha_m = isnan(c->contact_stiffness), damped = ry_laws[c->contact_law].ratio;
    if (too_soft) {
        return "A smaller time.step or a stiffer contact";
    }
    return by_alpha_m ? (damped ? "A larger contact.alpha_m or less damping" : "A larger contact.alpha_m")
                      : (damped ? "A smaller time.step or less damping" : "A smaller time.step");
}

static ry_status report(const ry_sim *sim, const char *what, const char *help, int32_t k, ry_error *error)
{
    const ry_grains *const g = &sim->state.grains;
    char kept[64] = "the last checkpoint is kept";
    if (sim->keeps_good) {
        snprintf(kept, sizeof kept, "the state of step %lld is kept", (long long)sim->good.step);
    }
    const int steps = sim->plan.has_fluid ? sim->plan.flow.advance : 1;
    return ry_fail(error, RY_UNPHYSICAL,
                   "step %lld (t = %g s): %s: grain %d at x = %g m, z = %g m, v = (%g, %g) m/s; %s. "
                   "%s%s may help",
                   (long long)sim->state.step, sim->state.time, what, (int)g->id[k], g->x[k], g->z[k],
                   g->vx[k], g->vz[k], kept, help, steps > 1 ? ", or a smaller fluid.advance (in a gas)," : "");
}

/* A fast impact at half a diameter per step, which the laws still bear, drives a grain 0.7 of its diameter
 * into its partner; beyond this many radii of the smaller one it has gone through. */
#define DEEPEST 1.9

/* Non-finite numbers, a grain that jumps over its own diameter in a step, or into another. */
static ry_status examine(ry_sim *sim, ry_error *error)
{
    ry_plan *const plan = &sim->plan;
    const ry_measure_sums sums = ry_measure_grains(&sim->state, &plan->motion, ry_plan_sets(plan));
    if (!sums.finite) {
        return report(sim, "a position or velocity is not a number", what_may_help(sim, 0), sums.fastest_grain, error);
    }
    if (sums.fastest > 1.0) {
        return report(sim, "a grain moves further than its diameter in a step", what_may_help(sim, 0), sums.fastest_grain, error);
    }
    const ry_contact_depth deepest = ry_contact_deepest(&plan->contact, &sim->state.grains, &plan->pairs);
    if (deepest.overlap > DEEPEST) {
        return report(sim, "a grain has run into another, or through a wall", what_may_help(sim, 1), deepest.i, error);
    }
    return RY_OK;
}

static ry_status examine_and_keep(ry_sim *sim, ry_error *error)
{
    RY_TRY(examine(sim, error));
    if (!sim->keeps_good) {
        return RY_OK;
    }
    complete_column(sim);
    RY_TRY(export_contacts(sim, &sim->good.contacts, error)); /* which closes the books */
    ry_kept_take(&sim->good, &sim->state);
    return RY_OK;
}

int ry_sim_is_sound(ry_sim *sim)
{
    return examine(sim, NULL) == RY_OK;
}

ry_status ry_sim_check(ry_sim *sim, ry_error *error)
{
    const ry_status status = examine_and_keep(sim, error);
    if (status == RY_UNPHYSICAL && sim->keeps_good) {
        RY_TRY(ry_kept_give(&sim->good, &sim->state, error));
        sim->restored = 1;
        sim->plan.sets.n_awake = sim->state.grains.n; /* who slept then is not known here */
        sim->plan.sets.n_asleep = 0;
    }
    return status;
}

static ry_status step_once(ry_sim *sim, int timed, ry_error *error)
{
    const ry_status status = ry_plan_step(&sim->plan, &sim->state, timed, error);
    sim->broken = status != RY_OK;
    return status;
}

ry_status ry_sim_step(ry_sim *sim, long long n, ry_error *error)
{
    RY_TRY(refuse_broken(sim, error));
    for (long long k = 0; k < n; k++) {
        const int timed = sim->state.step % RY_TIME_EVERY == 0;
        RY_TRY(step_once(sim, timed, error));
        sim->timed += timed;
        if (sim->state.step % CHECK_EVERY == 0) {
            RY_TRY(ry_sim_check(sim, error));
        }
    }
    return RY_OK;
}

/* ---- looking --------------------------------------------------------------------------------- */

ry_view ry_sim_view(const ry_sim *sim)
{
    complete_column(sim);
    const ry_grains *const g = &sim->state.grains;
    return (ry_view){.n = g->n, .step = sim->state.step, .time = sim->state.time, .id = g->id,
                     .image = g->image, .fixed = g->fixed, .x = g->x, .z = g->z, .vx = g->vx,
                     .vz = g->vz, .spin = g->spin, .radius = g->radius, .density = g->density,
                     .nz = sim->state.column.nz, .dz = sim->state.column.dz, .u = sim->state.column.u};
}

ry_status ry_sim_collect(ry_sim *sim, ry_error *error)
{
    RY_TRY(refuse_broken(sim, error));
    if (sim->restored) {
        return RY_OK;
    }
    complete_column(sim);
    return export_contacts(sim, &sim->state.contacts, error);
}

unsigned long long ry_sim_hash(ry_sim *sim)
{
    return ry_sim_collect(sim, NULL) == RY_OK ? ry_state_hash(&sim->state) : 0;
}

static void sample_ledger(ry_sim *sim, ry_sample *s)
{
    const ry_ledger *const ledger = &sim->state.ledger;
    if (!ledger->kept) {
        return;
    }
    if (!sim->restored) {
        ry_contact_close(&sim->plan.contact, &sim->state.grains, &sim->plan.pairs);
    }
#define RY_LEDGER_SUM(name, text) s->name = ry_exact_value(ledger->name, sim->plan.scale);
    RY_LEDGER_TOTALS(RY_LEDGER_SUM)
#undef RY_LEDGER_SUM
    const double lost = s->loss_impact + s->loss_dashpot + s->loss_friction + s->loss_opening;
    s->integration = total_energy(s) - ledger->energy_start - s->fluid_work + lost;
}

ry_sample ry_sim_sample(ry_sim *sim)
{
    return ry_sim_sample_of(sim, 1);
}

ry_sample ry_sim_sample_of(ry_sim *sim, int energies)
{
    ry_plan *const plan = &sim->plan;
    const ry_derived *const q = &plan->derived;
    if (sim->broken) {
        return (ry_sample){0};
    }
    if (plan->has_fluid && !sim->restored) {
        ry_flow_find_level(&plan->flow, &sim->state.column);
    }
    ry_measure_sums sums = ry_measure_grains(&sim->state, &plan->motion, ry_plan_sets(plan));
    ry_contact_sums contacts = {0};
    if (energies) {
        contacts = ry_contact_measure(&plan->contact, &sim->state.grains, &plan->pairs);
    }
    if (energies && plan->has_sleep && !sim->restored) {
        const ry_sleep_sums resting = ry_sleep_measure(&plan->sleep);
        sums.gravity += resting.gravity;
        contacts.elastic_normal += resting.elastic_normal;
        contacts.elastic_tangential += resting.elastic_tangential;
    }
    ry_sample s = {.kinetic_energy = sums.kinetic, .gravity_energy = sums.gravity,
                   .elastic_normal = contacts.elastic_normal,
                   .elastic_tangential = contacts.elastic_tangential,
                   .bed_level = plan->has_fluid ? sim->state.column.bed_level : NAN};
    if (q->length > 0.0) {
        s.q_b = sums.transport / (q->length * q->d);
        s.q_star = q->flux_unit > 0.0 ? s.q_b / q->flux_unit : 0.0;
    }
    sample_ledger(sim, &s);
    return s;
}

void ry_sim_profile(ry_sim *sim)
{
    ry_plan *const plan = &sim->plan;
    if (!plan->has_profile || sim->broken) {
        return;
    }
    complete_column(sim);
    const double tau = plan->has_fluid ? ry_flow_stress(&plan->flow, sim->state.step) : 0.0;
    const int closed = plan->has_fluid && plan->flow.model == RY_FLOW_BALANCE;
    if (closed) {
        ry_flow_shear(&plan->flow, &sim->state.column, tau, plan->tau_fluid);
    }
    ry_measure_add(&plan->measure, &sim->state, &plan->motion, ry_plan_sets(plan),
                   closed ? plan->tau_fluid : NULL, tau);
}

const char *ry_version(void)
{
    return RY_VERSION;
}
