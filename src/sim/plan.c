/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "sim/plan.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "base/memory.h"
#include "config/laws.h"
#include "stage/resting.h"
#include "stage/skin.h"

/* A thread has to have this many grains before a second one pays. */
enum { GRAINS_PER_THREAD = 4000 };
/* Grains that the caches hold, about. */
enum { CACHED_GRAINS = 20000 };
/* Start from motion: this long at so many times the stress, but not above that Shields number. */
#define BOOST_TIME 0.25
#define BOOST_FACTOR 4.0
#define BOOST_SHIELDS 0.6

int ry_plan_threads(int64_t n)
{
#ifdef _OPENMP
    const int64_t most = omp_get_num_procs();
#else
    const int64_t most = 1;
#endif
    const int64_t pays = n / GRAINS_PER_THREAD;
    return (int)(pays < 1 ? 1 : (pays < most ? pays : most));
}

/* ---- constants of the law -------------------------------------------------------------------- */

ry_law_coef ry_plan_law(const ry_config *config, const ry_derived *derived)
{
    const double dt = config->time_step;
    const double ratio = 1.0 / (2.0 * (1.0 + config->contact_poisson));
    ry_law_coef q = {.k_dt2 = derived->stiffness * dt * dt, .eta_dt = derived->damping * dt,
                     .e = config->contact_restitution, .friction = config->contact_friction,
                     .ratio_k = ratio, .ratio_eta = sqrt(ratio)};
    if (ry_laws[config->contact_law].parts) {
        q.bounded = RY_BOND_NEIGHBOURS;
    } else if (ry_laws[config->contact_law].hertz) {
        q.hertz = 1.0 / sqrt(derived->d); /* the tangential spring stays linear */
        q.root_hertz = sqrt(q.hertz);
        q.eta_dt = 0.0;
        q.zeta2 = sqrt(5.0) * derived->zeta_impact;
    } else if (!isnan(derived->zeta_impact)) {
        q.zeta2 = 2.0 * derived->zeta_impact;
        q.eta_dt = 0.0; /* restitution rules; with e = 1 there is no damping at all */
    }
    return q;
}

/* Mass that a grain moves with: its own and what it drags along of the fluid. */
static double inertial_mass(const ry_config *config, double volume, double density)
{
    const double added = config->fluid_model == RY_FLUID_NONE
                             ? 0.0 : config->fluid_added_mass * config->fluid_density;
    return volume * (density + added);
}

static void fill_motion(ry_motion *m, const ry_config *config, const ry_grains *g)
{
    const double rho = config->fluid_model == RY_FLUID_NONE ? 0.0 : config->fluid_density;
    for (int32_t k = 0; k < g->n; k++) {
        if (g->fixed[k]) {
            continue; /* all zero */
        }
        const double r = g->radius[k], volume = 4.0 / 3.0 * M_PI * r * r * r;
        const double inertia = 0.4 * volume * g->density[k] * r * r;
        m->im[k] = 1.0 / inertial_mass(config, volume, g->density[k]);
        m->tm[k] = m->im[k] + r * r / inertia;
        m->spin_gain[k] = r / inertia;
        m->weight[k] = -config->domain_gravity * volume * (g->density[k] - rho) * m->im[k] * config->time_step;
        if (m->pushes_kept) {
            m->gz[k] = m->weight[k];
        }
    }
}

/* ---- making it ------------------------------------------------------------------------------- */

static int grains_differ(const ry_grains *g, const double *im)
{
    double first = 0.0, first_r = 0.0;
    for (int32_t k = 0; k < g->n; k++) {
        if (im[k] == 0.0) {
            continue;
        }
        if (first == 0.0) {
            first = im[k];
            first_r = g->radius[k];
        }
        if (im[k] != first || g->radius[k] != first_r) {
            return 1;
        }
    }
    return 0;
}

/* See ry_contact: one and a half times as many as there are, for they may all lie on one side of the grain. */
static double most_around(const ry_config *config, const ry_grains *g, const double *im)
{
    double largest = 0.0;
    int32_t small = 0;
    for (int32_t k = 0; k < g->n; k++) {
        largest = im[k] > 0.0 ? fmax(largest, g->radius[k]) : largest;
    }
    for (int32_t k = 0; k < g->n; k++) {
        small += im[k] == 0.0 && largest > 3.0 * g->radius[k];
    }
    return ry_laws[config->contact_law].parts ? 1.5 * small : 0.0;
}

static void set_features(ry_plan *plan, const ry_config *config, int sizes_differ)
{
    plan->has_fluid = config->fluid_model != RY_FLUID_NONE;
    plan->has_profile = (config->output_fields & RY_FIELD_PROFILE) != 0 && plan->derived.length > 0.0 &&
                        (plan->has_fluid || config->has_grains);
    plan->has_ledger = (config->output_fields & RY_FIELD_ENERGY) != 0;
    plan->has_sleep = config->contact_sleep > 0.0;
    plan->motion.moves = ry_laws[config->contact_law].moves;
    plan->contact.moves = plan->motion.moves;
    plan->contact.features = (config->contact_friction > 0.0 ? RY_CONTACT_FRICTION : 0) |
                             (sizes_differ || config->contact_wet ? RY_CONTACT_SIZES : 0) |
                             (plan->has_ledger ? RY_CONTACT_LEDGER : 0);
}

void ry_plan_outline(ry_plan *plan, const ry_config *config, int sizes_differ)
{
    *plan = (ry_plan){.derived = ry_config_derive(config)};
    set_features(plan, config, sizes_differ);
    ry_plan_lay_table(plan, config);
}

static void set_skins(ry_neighbor *b, const ry_config *config, const ry_derived *q)
{
    if (!isnan(config->numerics_skin)) {
        b->skin_least = b->skin_most = 0.5 * config->numerics_skin * q->d;
        return;
    }
    const double room = config->domain_periodic ? 0.5 * (q->length / 2.5 - 2.0 * b->radius_max) : INFINITY;
    ry_skin_begin(b, q->d, config->time_step, room);
}

static void set_walls(ry_plan *plan, const ry_config *config)
{
    ry_neighbor *const b = &plan->neighbor;
    if (config->domain_floor == RY_FLOOR_FLAT) {
        b->wall[b->n_walls++] = RY_WALL_FLOOR;
    }
    if (config->domain_walls && !config->domain_periodic) {
        b->wall[b->n_walls++] = RY_WALL_LEFT;
        b->wall[b->n_walls++] = RY_WALL_RIGHT;
    }
}

/* Grains of different density fall differently in a fluid: then gravity stays out of the impact's balance. */
static int fall_alike(const ry_motion *m, int32_t n, double weight)
{
    for (int32_t k = 0; k < n; k++) {
        if (m->im[k] != 0.0 && fabs(m->weight[k] - weight) > 1e-9 * fabs(weight)) {
            return 0;
        }
    }
    return 1;
}

ry_film ry_plan_film(const ry_config *config, const ry_derived *derived)
{
    if (!config->contact_wet) {
        return (ry_film){0};
    }
    const ry_law_kind law = ry_laws[config->contact_law];
    const int asked = !isnan(derived->zeta_impact) && derived->zeta_impact != derived->zeta_pair;
    const int usual = asked && config->contact_mapping == RY_MAPPING_USUAL;
    return (ry_film){.on = 1, .damps = law.ratio, .usual = usual || law.pulls, .pulls = law.pulls,
                     .unit = law.hertz ? sqrt(5.0) : 2.0, .many = derived->is_bed ? 3.0 : 1.0,
                     .per_mu = 1.0 / (6.0 * M_PI * config->fluid_density * config->fluid_viscosity)};
}

/* No contact loses more in a step, and no grain gets more, than that of the heaviest grain when it moves by two
 * diameters in it: half of that is not physical any more. */
static ry_scale ledger_scale(const ry_motion *m, const ry_grains *g)
{
    double largest = 1e-300;
    for (int32_t k = 0; k < g->n; k++) {
        const double speed = 4.0 * g->radius[k] / m->dt;
        largest = m->im[k] > 0.0 ? fmax(largest, 0.5 * speed * speed / m->im[k]) : largest;
    }
    return ry_scale_make(largest);
}

static ry_status set_books(ry_plan *plan, ry_state *state, ry_error *error)
{
    ry_contact *const c = &plan->contact;
    plan->scale = ledger_scale(&plan->motion, &state->grains);
    plan->motion.books = plan->has_ledger;
    plan->motion.scale = c->scale = plan->scale;
    if (!plan->has_ledger) {
        return RY_OK;
    }
    c->ledger = &state->ledger;
    c->close = ry_contact_select_close(c->features);
    c->books = ry_array((size_t)plan->threads + 1, sizeof *c->books);
    return c->books != NULL ? RY_OK : ry_no_memory(error, (size_t)plan->threads * sizeof *c->books);
}

static void set_contact(ry_plan *plan, const ry_config *config, const ry_state *state)
{
    ry_contact *const c = &plan->contact;
    const ry_motion *const m = &plan->motion;
    const double length = plan->derived.length;
    const ry_law_kind law = ry_laws[config->contact_law];
    c->coef = ry_plan_law(config, &plan->derived);
    c->film = ry_plan_film(config, &plan->derived);
    for (int k = 0; k < RY_CONTACT_BLOCK; k++) {
        c->dry[k] = law.ratio ? c->coef.zeta2 : c->coef.e;
    }
    c->explicit_spring = law.parts || law.ratio;
    c->kernel = ry_contact_select((int)config->contact_law, c->features);
    c->young = ry_contact_select_young((int)config->contact_law, c->features);
    c->impacts = !law.parts && !law.ratio;
    plan->motion.marks = c->young != NULL;
    c->body = (const double (*)[RY_BODY])m->body;
    c->dt = config->time_step;
    c->threads = plan->threads;
    c->large = state->grains.n > CACHED_GRAINS;
    c->length = config->domain_periodic ? length : 0.0;
    c->half = config->domain_periodic ? 0.5 * length : INFINITY;
    c->wall_length = length;
    c->n_walls = plan->neighbor.n_walls;
    for (int w = 0; w < c->n_walls; w++) {
        c->wall[w] = plan->neighbor.wall[w];
    }
    c->im = m->im;
    c->tm_grain = m->tm;
    int32_t first = -1; /* of those that can move, by id: no bit may depend on the order in memory */
    for (int32_t k = 0; k < state->grains.n; k++) {
        if (m->im[k] != 0.0 && (first < 0 || state->grains.id[k] < state->grains.id[first])) {
            first = k;
        }
    }
    if (first >= 0) { /* where grains differ, tm and bond are not used */
        c->coef.g_dt2 = fall_alike(m, state->grains.n, m->weight[first]) ? -m->weight[first] * c->dt : 0.0;
        c->im_lone = m->im[first];
        c->bond[0] = ry_bond_make(&c->coef, 2.0 * m->im[first], 2.0 * m->tm[first]);
        c->bond[1] = ry_bond_make(&c->coef, m->im[first], m->tm[first]);
    }
}

static void set_flow(ry_plan *plan, const ry_config *config)
{
    const ry_derived *const q = &plan->derived;
    const double boosted = fmin(BOOST_FACTOR, BOOST_SHIELDS / fmax(q->shields, 1e-12));
    const double factor = config->fluid_start == RY_START_MOTION ? fmax(1.0, boosted) : 1.0;
    plan->flow = (ry_flow){
        .model = (ry_flow_model)config->fluid_model, .drag = (ry_flow_drag)config->fluid_drag,
        .mixing = (ry_flow_mixing)config->fluid_mixing_length, .threads = plan->threads,
        .advance = config->fluid_advance, .step_start = q->steps_settle,
        .step_boost = q->steps_settle + llround(BOOST_TIME / config->time_step),
        .tau = q->shear_stress, .tau_start = q->shear_stress * factor,
        .density = config->fluid_density, .viscosity = config->fluid_viscosity,
        .drag_coefficient = config->fluid_drag_coefficient, .hindrance = config->fluid_hindrance,
        .walks = config->fluid_turbulence == RY_TURBULENCE_WALK, .eddy_time = config->fluid_eddy_time,
        .seed = (uint32_t)config->grains_seed,
        .lift = config->fluid_lift, .roughness = config->fluid_roughness,
        .gravity = config->domain_gravity, .level = config->fluid_level, .d = q->d,
        .length = q->length > 0.0 ? q->length : q->d, .dt = config->time_step};
}

static ry_status start_sleep(ry_plan *plan, const ry_config *config, ry_state *state, ry_error *error)
{
    const ry_derived *const q = &plan->derived;
    ry_sleep *const s = &plan->sleep;
    ry_sleep_scale(s, config->contact_sleep, q->d, q->buoyant_gravity, 2.0 * M_PI * sqrt(q->mass / q->stiffness),
                   config->time_step);
    s->state = state;
    s->neighbor = &plan->neighbor;
    s->contact = &plan->contact;
    s->motion = &plan->motion;
    s->pairs = &plan->pairs;
    s->sets = &plan->sets;
    s->flow = plan->has_fluid ? &plan->flow : NULL;
    if (plan->has_fluid) {
        RY_TRY(ry_resting_create(&plan->flow, &state->grains, error));
    }
    s->places = &plan->places;
    RY_TRY(ry_places_make_room(&plan->places, state->grains.n, error));
    return ry_sleep_create(s, error);
}

/* Everything that stands in storage order and outlasts a step. */
static void carry_all(ry_plan *plan, const ry_state *state)
{
    ry_places *const o = &plan->places;
    const ry_motion *const m = &plan->motion;
    const int pushes = m->pushed && m->pushes_kept;
    double *const arrays[] = {m->im, m->tm, m->spin_gain, m->weight, pushes ? m->gx : NULL, pushes ? m->gz : NULL};
    double *const sums[] = {m->cx, m->cz, m->ct, plan->measure.impulse, plan->measure.middle, plan->flow.viscous};
    ry_places_carry_grains(o, &state->grains);
    ry_places_carry(o, plan->flow.eddy_x, sizeof(double));
    ry_places_carry(o, plan->flow.eddy_z, sizeof(double));
    for (size_t a = 0; a < sizeof arrays / sizeof *arrays; a++) {
        ry_places_carry(o, arrays[a], sizeof(double));
    }
    for (size_t a = m->kept ? 0 : 3; a < sizeof sums / sizeof *sums; a++) {
        ry_places_carry(o, sums[a], sizeof(double));
    }
}

/* Each pass goes through ten arrays and more at a time, which are too many for a processor to foresee. */
static void ask_ahead(ry_plan *plan, const ry_grains *g)
{
    ry_contact *const c = &plan->contact;
    const ry_motion *const m = &plan->motion;
    const ry_neighbor *const b = &plan->neighbor;
    const int pushes = m->pushed && m->pushes_kept;
    const double *const arrays[] = {g->x, g->z, g->vx, g->vz, g->spin, g->radius, b->x0, b->z0,
                                    m->im, m->tm, m->spin_gain, m->weight, plan->flow.viscous, g->push,
                                    pushes ? m->gx : NULL, pushes ? m->gz : NULL, m->kept ? m->cx : NULL,
                                    m->kept ? m->cz : NULL, m->kept ? m->ct : NULL, plan->measure.impulse};
    for (size_t a = 0; c->large && a < sizeof arrays / sizeof *arrays; a++) {
        if (arrays[a] != NULL) {
            c->ahead[c->n_ahead++] = arrays[a];
        }
    }
}

/* Coefficients of pairs take 48 bytes: while these stay in the cache, to make them in each step takes longer. Those of
 * wet contacts change. Where small grains are fixed a pair's are not made of sums. */
static int keeps_bonds(const ry_plan *plan, const ry_config *config, int32_t n)
{
    return (plan->contact.features & RY_CONTACT_SIZES) &&
           (plan->contact.most_around > 0.0 || (!config->contact_wet && n <= CACHED_GRAINS));
}

ry_status ry_plan_create(ry_plan *plan, const ry_config *config, ry_state *state, int threads,
                         ry_error *error)
{
    const ry_grains *const g = &state->grains;
    *plan = (ry_plan){.derived = ry_config_derive(config), .must_rebuild = 1};
    plan->threads = threads > 0 ? threads : ry_plan_threads(g->n);
    plan->threads = plan->threads < RY_MOST_THREADS ? plan->threads : RY_MOST_THREADS;
    set_features(plan, config, 0);
    plan->keeps_order = config->numerics_order == RY_ORDER_BED && config->has_grains;
    set_walls(plan, config);
    ry_motion *const m = &plan->motion;
    m->threads = plan->threads;
    m->kept = plan->has_sleep;
    m->pushed = plan->has_fluid || plan->has_ledger || plan->has_profile || plan->has_sleep;
    m->pushes_kept = m->kept || plan->has_profile || !plan->has_fluid; /* without fluid they are made once */
    RY_TRY(ry_motion_create(m, g->n, error));
    m->periodic = config->domain_periodic;
    m->length = plan->derived.length;
    m->dt = config->time_step;
    fill_motion(m, config, g);
    ry_motion_settle(m, g);
    plan->contact.most_around = most_around(config, g, m->im);
    set_features(plan, config, grains_differ(g, m->im) || plan->contact.most_around > 0.0);
    plan->contact.features |= keeps_bonds(plan, config, g->n) ? RY_CONTACT_KEPT : 0;
    set_contact(plan, config, state);
    RY_TRY(set_books(plan, state, error));

    ry_neighbor *const b = &plan->neighbor;
    b->length = plan->derived.length;
    b->periodic = config->domain_periodic;
    b->step = config->time_step;
    RY_TRY(ry_neighbor_create(b, g, plan->threads, error));
    RY_TRY(ry_plan_lay_passes(plan, g->n, error));
    b->blocks = &plan->blocks;
    if (plan->has_sleep) {
        b->still = state->sleepers.asleep;
        b->has_sleepers = 1;
    }
    set_skins(b, config, &plan->derived);
    const unsigned wants = (m->moves ? RY_PAIRS_SHIFTS : 0) | (plan->has_ledger ? RY_PAIRS_LEDGER : 0) |
                           (config->contact_wet ? RY_PAIRS_WET : 0) |
                           (ry_laws[config->contact_law].rests ? RY_PAIRS_RESTS : 0) |
                           (plan->contact.features & RY_CONTACT_KEPT ? RY_PAIRS_BONDS : 0) |
                           (plan->contact.young != NULL ? RY_PAIRS_YOUNG : 0);
    RY_TRY(ry_pairs_create(&plan->pairs, g->n, b->n_walls, wants, error));
    RY_TRY(ry_neighbor_rebuild(b, g, &plan->pairs, error));
    plan->must_rebuild = 0;
    ry_pairs_import(&plan->pairs, state);
    plan->sets.n_awake = g->n;
    if (plan->has_fluid) {
        set_flow(plan, config);
        RY_TRY(ry_flow_create(&plan->flow, state, error));
    }
    if (plan->has_profile) {
        RY_TRY(ry_measure_create(&plan->measure, state, plan->derived.length, plan->derived.d,
                                 plan->threads, plan->derived.steps_series, error));
        plan->tau_fluid = ry_array((size_t)state->column.nz, sizeof(double));
        if (plan->tau_fluid == NULL) {
            return ry_no_memory(error, (size_t)state->column.nz * sizeof(double));
        }
    }
    carry_all(plan, state);
    ask_ahead(plan, g);
    if (plan->has_sleep) {
        RY_TRY(start_sleep(plan, config, state, error));
    }
    if (plan->has_fluid && state->step == 0) { /* for who looks at the column before the first advance */
        ry_flow_look(&plan->flow, state, &plan->motion, ry_plan_sets(plan));
    }
    ry_plan_lay_table(plan, config);
    return RY_OK;
}

const ry_sets *ry_plan_sets(ry_plan *plan)
{
    ry_sets *const sets = &plan->sets;
    sets->place = plan->pairs.place;
    sets->awake = sets->n_asleep > 0 ? sets->awake : sets->place;
    return sets;
}

void ry_plan_free(ry_plan *plan)
{
    ry_sleep_free(&plan->sleep);
    ry_places_give_back(&plan->places);
    ry_neighbor_free(&plan->neighbor);
    ry_blocks_free(&plan->blocks);
    ry_pairs_free(&plan->pairs);
    ry_motion_free(&plan->motion);
    ry_flow_free(&plan->flow);
    ry_measure_free(&plan->measure);
    free(plan->tau_fluid);
    free(plan->contact.books);
    *plan = (ry_plan){0};
}
