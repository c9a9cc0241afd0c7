/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/sleep_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "stage/four.h"

/* See sleep.h. In units of sqrt(d/g'), d, d, d, weights. */
#define LOOK 2.5
#define STILL 0.0035
#define QUIET 1.0
#define AROUND 0.5
#define SWEPT 0.02
/* Marks of grains while sets are formed. */
enum { MARK_QUIET = 1, MARK_NEW = 2 };

void ry_sleep_scale(ry_sleep *s, double tolerance, double d, double gravity, double period, double dt)
{
    s->tolerance = tolerance;
    s->look_every = gravity > 0.0 ? (int64_t)ceil(LOOK * sqrt(d / gravity) / dt) : 0;
    s->still = STILL * d;
    s->slow2 = 2.0 * gravity * STILL * d;
    s->quiet = QUIET * d;
    s->around = AROUND * d;
    s->part = dt < period ? dt / period : 1.0;
    s->check_every = (int64_t)ceil(0.5 / s->part);
}

/* ---- the force on sleepers ------------------------------------------------------------------- */

static int is_listed(const ry_pairs *pairs, int32_t k)
{
    return (pairs->row[k] < pairs->row[k + 1]) | (pairs->below_start[k] < pairs->below_start[k + 1]);
}

static int is_restless(const ry_sleep *s, int32_t k)
{
    const ry_sleepers *const q = &s->state->sleepers;
    const double *const felt = s->felt[k];
    const int differs = (felt[RY_SLOT_X] != q->rest_x[k]) | (felt[RY_SLOT_Z] != q->rest_z[k]) |
                        (felt[RY_SLOT_TURN] != q->rest_turn[k]);
    return !s->state->grains.fixed[k] && (differs | (q->more_x[k] != 0.0) | (q->more_z[k] != 0.0) |
                                          (q->more_turn[k] != 0.0));
}

/* The others' force cannot change, and its mean neither: with a change of 0 it stays 0. */
static void list_watch(ry_sleep *s)
{
    for (int32_t w = 0; w < s->n_watch; w++) {
        s->restless[s->watch[w]] = (uint8_t)is_restless(s, s->watch[w]);
    }
    s->n_watch = 0;
    for (int32_t k = s->motion->n_awake; k < s->state->grains.n; k++) {
        s->watch[s->n_watch] = k;
        s->n_watch += (s->restless[k] | is_listed(s->pairs, k)) & (s->state->grains.fixed[k] == 0);
    }
    s->watched = s->neighbor->rebuilds;
}

/* The same when sets, or what sleepers rest on, have changed. */
static void watch_anew(ry_sleep *s)
{
    for (int32_t k = s->motion->n_awake; k < s->state->grains.n; k++) {
        s->restless[k] = (uint8_t)is_restless(s, k);
    }
    s->n_watch = 0;
    list_watch(s);
}

static double length2(double x, double z, double turn)
{
    return x * x + z * z + turn * turn;
}

/* What its listed contacts give a sleeper, in ascending id of the partner; those with walls are frozen. */
RY_INLINE ry_four sum_listed(const ry_pairs *pairs, int32_t k)
{
    const double (*const slot)[RY_SLOT] = (const double (*)[RY_SLOT])pairs->slot;
    const ry_four opposite = {-1.0, -1.0, 1.0, 1.0};
    ry_four sum = {0.0, 0.0, 0.0, 0.0};
    for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
        sum += opposite * ry_four_load(slot[pairs->below[b]]);
    }
    for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
        sum += ry_four_load(slot[p]);
    }
    return sum;
}

/* The contacts of the watched in this step: their sum, how it differs from that at rest, the mean of that. Lists those
 * whom this step alone wakes. */
RY_CLONES static int32_t feel(const ry_sleep *s, int32_t *restrict struck)
{
    const ry_sleepers q = s->state->sleepers;
    const double part = s->part;
    int32_t n = 0;
    for (int32_t w = 0; w < s->n_watch; w++) {
        const int32_t k = s->watch[w];
        const ry_four felt = sum_listed(s->pairs, k) + ry_four_load(s->held[k]);
        const double dx = felt[RY_SLOT_X] - q.rest_x[k], dz = felt[RY_SLOT_Z] - q.rest_z[k];
        const double dt = felt[RY_SLOT_TURN] - q.rest_turn[k];
        ry_four_store(s->felt[k], felt);
        q.more_x[k] += part * (dx - q.more_x[k]);
        q.more_z[k] += part * (dz - q.more_z[k]);
        q.more_turn[k] += part * (dt - q.more_turn[k]);
        struck[n] = k;
        n += length2(dx, dz, dt) * part * part > q.bears[k] * q.bears[k];
    }
    return n;
}

/* The fluid's force along x is more than this part of a grain's weight. Whom the flow reaches does not sleep: near the
 * threshold it moves such grains little by little, by a force that changes by less than others load them with. */
static int is_swept(const ry_motion *m, int32_t k, double part)
{
    return fabs(m->gx[k]) > part * fabs(m->weight[k]);
}

/* The flow has come to a sleeper; or the mean change of the contacts' force and that of the fluid's are more than it
 * bears. */
static int is_moved(const ry_sleep *s, int32_t k)
{
    const ry_sleepers *const q = &s->state->sleepers;
    const ry_motion *const m = s->motion;
    const double im = m->im[k], most = q->bears[k] * im; /* as velocities, to save the division */
    const double x = q->more_x[k] * im + m->gx[k] - q->rest_gx[k];
    const double z = q->more_z[k] * im + m->gz[k] - q->rest_gz[k];
    return !s->state->grains.fixed[k] &&
           (is_swept(m, k, 2.0 * SWEPT) || length2(x, z, q->more_turn[k] * im) > most * most);
}

/* Whether the fluid alone moves anybody: a first look, for all at once. Fixed grains bear nothing, and get nothing. */
RY_CLONES static int any_swept(const ry_sleep *s)
{
    const ry_sleepers q = s->state->sleepers;
    const ry_motion m = *s->motion;
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int32_t k = m.n_awake; k < s->state->grains.n; k++) {
        const double most = q.bears[k] * m.im[k], x = m.gx[k] - q.rest_gx[k], z = m.gz[k] - q.rest_gz[k];
        any |= (x * x + z * z > most * most) | is_swept(&m, k, 2.0 * SWEPT);
    }
    return any;
}

static void add_woken(ry_sleep *s, int32_t k)
{
    if (s->state->sleepers.asleep[k] && !s->state->grains.fixed[k]) {
        s->state->sleepers.asleep[k] = 0;
        s->woken[s->n_woken++] = k;
    }
}

/* The fluid's force on those that sleep, and the contacts' that balances it along x. */
static void sample_asleep(const ry_sleep *s)
{
    const ry_motion *const m = s->motion;
    if (s->flow != NULL) {
        ry_flow_sample_asleep(s->flow, &s->state->grains, s->motion);
    }
    for (int32_t k = m->n_awake; k < s->state->grains.n; k++) {
        m->cx[k] = s->flow != NULL ? -s->flow->resting.force[k] * m->dt : 0.0;
    }
}

/* Lists those whom this step wakes. Who is not watched has a mean change of 0: the fluid alone can move it. That one is
 * swept is a reason to compare the watched with what they bear, too, before their time. */
static void find_woken(ry_sleep *s)
{
    const int64_t step = s->state->step;
    const int advanced = s->flow != NULL && step % s->flow->advance == 0;
    const int32_t n_struck = feel(s, s->struck);
    s->n_woken = 0;
    for (int32_t m = 0; m < n_struck; m++) {
        add_woken(s, s->struck[m]);
    }
    if (advanced) {
        sample_asleep(s);
    }
    for (int32_t w = 0; step % s->check_every == 0 && w < s->n_watch; w++) {
        if (is_moved(s, s->watch[w])) {
            add_woken(s, s->watch[w]);
        }
    }
    if (advanced && any_swept(s)) {
        for (int32_t k = s->motion->n_awake; k < s->state->grains.n; k++) {
            if (is_moved(s, k)) {
                add_woken(s, k);
            }
        }
    }
}

/* ---- waking ---------------------------------------------------------------------------------- */

/* The change of the forces in this step, and no more, moves it. */
static void push_woken(const ry_sleep *s, int32_t k)
{
    ry_grains *const g = &s->state->grains;
    const ry_sleepers *const q = &s->state->sleepers;
    const ry_motion *const m = s->motion;
    const double *const felt = s->felt[k];
    const double length = m->periodic ? m->length : 0.0;
    g->vx[k] = (felt[RY_SLOT_X] - q->rest_x[k]) * m->im[k] + m->gx[k] - q->rest_gx[k];
    g->vz[k] = (felt[RY_SLOT_Z] - q->rest_z[k]) * m->im[k] + m->gz[k] - q->rest_gz[k];
    g->spin[k] = (felt[RY_SLOT_TURN] - q->rest_turn[k]) * m->spin_gain[k];
    g->x[k] += g->vx[k] * m->dt;
    g->z[k] += g->vz[k] * m->dt;
    const int out = m->periodic ? (g->x[k] >= length) - (g->x[k] < 0.0) : 0;
    g->x[k] -= out * length;
    g->image[k] += out;
}

/* Nothing of its sleep is left. */
static void forget_sleep(const ry_sleep *s, int32_t k)
{
    ry_grains *const g = &s->state->grains;
    const ry_sleepers *const q = &s->state->sleepers;
#define FORGET(type, name, unit, text) q->name[k] = 0;
    RY_SLEEP_FIELDS(FORGET)
#undef FORGET
    q->from_x[k] = g->x[k];
    q->from_z[k] = g->z[k];
    if (s->flow != NULL && s->flow->model == RY_FLOW_BALANCE) { /* so much since the last advance */
        g->push[k] = s->flow->resting.force[k] * (double)(s->state->step % s->flow->advance + 1);
    }
}

/* With the sets of places->was: places, bodies, list, frozen contacts. */
static ry_status reform(ry_sleep *s, ry_error *error)
{
    const ry_grains *const g = &s->state->grains;
    ry_motion *const m = s->motion;
    if (s->contact->books != NULL) { /* what has parted, now that those who wake have been pushed */
        ry_motion_settle(m, g);
        ry_contact_close_list(s->contact, g, s->pairs);
    }
    ry_places_change(s->places, s->pairs);
    ry_motion_settle(m, g);
    m->highest_asleep = -INFINITY;
    for (int32_t k = m->n_awake; k < g->n; k++) {
        m->highest_asleep = g->z[k] > m->highest_asleep ? g->z[k] : m->highest_asleep;
    }
    s->neighbor->was = s->places->was;
    RY_TRY(ry_neighbor_rebuild(s->neighbor, g, s->pairs, error));
    s->neighbor->was = NULL;
    ry_sleep_list_sets(s);
    ry_sleep_thaw(s);
    ry_sleep_sum_frozen(s);
    watch_anew(s);
    return RY_OK;
}

static ry_status wake(ry_sleep *s, ry_error *error)
{
    const int32_t first = s->n_woken;
    const double strayed = ry_neighbor_strayed(s->neighbor, &s->state->grains);
    for (int32_t w = 0; w < first; w++) {
        const int32_t *near;
        int32_t n;
        RY_TRY(ry_neighbor_around(s->neighbor, &s->state->grains, s->woken[w], s->around, strayed, &near, &n, error));
        for (int32_t m = 0; m < n; m++) {
            add_woken(s, near[m]);
        }
    }
    for (int32_t w = 0; w < s->n_woken; w++) {
        if (w < first) {
            push_woken(s, s->woken[w]);
        }
        forget_sleep(s, s->woken[w]);
    }
    return RY_OK;
}

/* ---- falling asleep -------------------------------------------------------------------------- */

static int rests(const ry_sleep *s, int32_t k)
{
    const ry_grains *const g = &s->state->grains;
    const ry_sleepers *const q = &s->state->sleepers;
    const double dx = ry_nearest(g->x[k] - q->from_x[k], s->contact->length, s->contact->half);
    const double dz = g->z[k] - q->from_z[k], v2 = g->vx[k] * g->vx[k] + g->vz[k] * g->vz[k];
    return dx * dx + dz * dz < s->still * s->still && v2 < s->slow2 && !is_swept(s->motion, k, SWEPT) &&
           ry_contact_count(s->contact, s->pairs, k) > 1;
}

static double slot_length(const double *slot)
{
    return sqrt(slot[RY_SLOT_X] * slot[RY_SLOT_X] + slot[RY_SLOT_Z] * slot[RY_SLOT_Z]);
}

/* Half the sum of what its contacts give a grain, or its weight. */
static double load_of(const ry_sleep *s, int32_t k)
{
    const ry_pairs *const pairs = s->pairs;
    double sum = 0.0;
    for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
        sum += slot_length(pairs->slot[pairs->below[b]]);
    }
    for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
        sum += slot_length(pairs->slot[p]);
    }
    for (int w = 0; w < RY_MAX_WALLS && pairs->wall_slot[w] != NULL; w++) {
        sum += pairs->wall_slot[w][k] >= 0 ? slot_length(pairs->slot[pairs->wall_slot[w][k]]) : 0.0;
    }
    return fmax(0.5 * sum, fabs(s->motion->weight[k]) / s->motion->im[k]);
}

/* Grain k may fall asleep: everybody around is quiet. Fills the mean load there. */
static ry_status ask_neighbours(ry_sleep *s, int32_t k, double strayed, int *all_quiet, double *load,
                                ry_error *error)
{
    const ry_grains *const g = &s->state->grains;
    const int32_t *near;
    int32_t n;
    RY_TRY(ry_neighbor_around(s->neighbor, g, k, s->quiet, strayed, &near, &n, error));
    double sum = 0.0;
    int32_t count = 0, quiet = 1;
    for (int32_t m = 0; m < n; m++) {
        quiet &= s->mark[near[m]];
        if (!g->fixed[near[m]]) {
            sum += s->own_load[near[m]];
            count++;
        }
    }
    *all_quiet = quiet & MARK_QUIET;
    *load = sum / count;
    return RY_OK;
}

static void lay_down(const ry_sleep *s, int32_t k)
{
    ry_grains *const g = &s->state->grains;
    const ry_sleepers *const q = &s->state->sleepers;
    double sum[RY_SLOT];
    ry_motion_listed(s->pairs, k, sum);
    q->asleep[k] = 1;
    q->rest_x[k] = sum[RY_SLOT_X];
    q->rest_z[k] = sum[RY_SLOT_Z];
    q->rest_turn[k] = sum[RY_SLOT_TURN];
    q->load[k] = s->own_load[k];
    g->vx[k] = g->vz[k] = g->spin[k] = 0.0;
}

/* Sleepers among sleepers only: what has come to rest around them is what they rest on now. */
static void rest_anew(const ry_sleep *s)
{
    const ry_sleepers *const q = &s->state->sleepers;
    for (int32_t k = s->motion->n_awake; k < s->state->grains.n; k++) {
        if (ry_contact_count(s->contact, s->pairs, k) == s->n_frozen[k]) {
            q->rest_x[k] = s->felt[k][RY_SLOT_X];
            q->rest_z[k] = s->felt[k][RY_SLOT_Z];
            q->rest_turn[k] = s->felt[k][RY_SLOT_TURN];
            q->more_x[k] = q->more_z[k] = q->more_turn[k] = 0.0;
        }
    }
}

/* The fluid's force on those that have just fallen asleep. */
static void sample_new(const ry_sleep *s)
{
    const ry_sleepers *const q = &s->state->sleepers;
    sample_asleep(s);
    for (int32_t k = s->motion->n_awake; k < s->state->grains.n; k++) {
        if (s->mark[k] & MARK_NEW) {
            q->rest_gx[k] = s->motion->gx[k];
            q->rest_gz[k] = s->motion->gz[k];
        }
    }
}

/* Those who wake in this step are not quiet. */
static void find_quiet(ry_sleep *s)
{
    const ry_sleepers *const q = &s->state->sleepers;
    for (int32_t k = 0; k < s->state->grains.n; k++) {
        const int was_awake = k < s->motion->n_awake;
        s->mark[k] = q->asleep[k] || (was_awake && rests(s, k)) ? MARK_QUIET : 0;
        s->own_load[k] = was_awake ? load_of(s, k) : q->load[k];
    }
}

/* *n_new do. */
static ry_status fall_asleep(ry_sleep *s, int32_t *n_new, ry_error *error)
{
    const ry_grains *const g = &s->state->grains;
    const ry_sleepers *const q = &s->state->sleepers;
    find_quiet(s);
    const double strayed = ry_neighbor_strayed(s->neighbor, g);
    for (int32_t k = 0; k < s->motion->n_awake; k++) {
        int all_quiet = 0;
        double load = 0.0;
        if (s->mark[k] & MARK_QUIET) {
            RY_TRY(ask_neighbours(s, k, strayed, &all_quiet, &load, error));
        }
        if (all_quiet) {
            s->mark[k] |= MARK_NEW;
            q->bears[k] = s->tolerance * load;
            (*n_new)++;
        }
        q->from_x[k] = g->x[k];
        q->from_z[k] = g->z[k];
    }
    for (int32_t k = 0; k < s->motion->n_awake; k++) {
        if (s->mark[k] & MARK_NEW) {
            lay_down(s, k);
        }
    }
    return *n_new > 0 ? ry_sleep_freeze(s, error) : RY_OK;
}

/* ---- the stage ------------------------------------------------------------------------------- */

/* Who wakes and who falls asleep is found by the impulses of this step, which stand in the list: the sets are formed
 * anew, and the list with them, when both are known. */
static ry_status change_sets(ry_sleep *s, int looks, ry_error *error)
{
    int32_t n_new = 0;
    ry_contact_close(s->contact, &s->state->grains, s->pairs); /* while its grains still move */
    if (s->n_woken > 0) {
        RY_TRY(wake(s, error));
    }
    if (looks) {
        RY_TRY(fall_asleep(s, &n_new, error));
    }
    if (s->n_woken > 0 || n_new > 0) {
        (n_new > 0 ? ry_sleep_order_all : ry_sleep_order_woken)(s);
        RY_TRY(reform(s, error));
    }
    if (looks) {
        rest_anew(s);
        sample_new(s);
        watch_anew(s);
    }
    return RY_OK;
}

ry_status ry_sleep_stage(ry_sleep *s, ry_error *error)
{
    const int32_t n = s->state->grains.n;
    const int looks = s->look_every > 0 && (s->state->step + 1) % s->look_every == 0;
    s->slept += (double)(n - s->motion->n_awake - s->n_fixed) / fmax(n - s->n_fixed, 1);
    s->steps++;
    if (s->watched != s->neighbor->rebuilds) {
        list_watch(s);
    }
    find_woken(s);
    return s->n_woken > 0 || looks ? change_sets(s, looks, error) : RY_OK;
}

/* ---- making it ------------------------------------------------------------------------------- */

/* What of sleep stands in storage order and outlasts a step. */
static void carry_state(ry_sleep *s)
{
    ry_state *const state = s->state;
#define CARRY(type, name, unit, text) ry_places_carry(s->places, state->sleepers.name, sizeof(type));
    RY_SLEEP_FIELDS(CARRY)
#undef CARRY
    if (s->flow != NULL) {
        ry_places_carry(s->places, s->flow->resting.force, sizeof(double));
        ry_places_carry(s->places, s->flow->resting.slope, sizeof(double));
    }
    ry_places_carry(s->places, s->mark, sizeof *s->mark);
}

static ry_status make_arrays(ry_sleep *s, ry_error *error)
{
    const size_t n = (size_t)s->state->grains.n + RY_MAX_WALLS;
    s->held = ry_array(n, sizeof *s->held);
    s->felt = ry_array(n, sizeof *s->felt);
    s->n_frozen = ry_array(n, sizeof *s->n_frozen);
    s->awake = ry_array(n, sizeof *s->awake);
    s->asleep = ry_array(n, sizeof *s->asleep);
    s->watch = ry_array(n, sizeof *s->watch);
    s->woken = ry_array(n, sizeof *s->woken);
    s->home = ry_array(n, sizeof *s->home);
    s->struck = ry_array(n, sizeof *s->struck);
    s->mark = ry_array(n, sizeof *s->mark);
    s->restless = ry_array(n, sizeof *s->restless);
    s->own_load = ry_array(n, sizeof *s->own_load);
    return s->held && s->felt && s->n_frozen && s->watch && s->woken && s->home && s->struck &&
                   s->mark && s->own_load && s->awake && s->asleep && s->restless
               ? RY_OK
               : ry_no_memory(error, n * 100);
}

ry_status ry_sleep_create(ry_sleep *s, ry_error *error)
{
    const ry_grains *const g = &s->state->grains;
    ry_motion *const m = s->motion;
    RY_TRY(make_arrays(s, error));
    carry_state(s);
    s->frozen.is_wet = s->pairs->wet != NULL;
    s->frozen.no_rest = s->pairs->rest == NULL;
    s->frozen.sleeps = 1;
    s->contact->frozen = s->n_frozen;
    for (int32_t k = 0; k < g->n; k++) {
        s->home[k] = g->id[k];
        s->n_fixed += g->fixed[k];
    }
    m->n_awake = 0;
    while (m->n_awake < g->n && !s->state->sleepers.asleep[m->n_awake]) {
        m->n_awake++;
    }
    for (int32_t k = m->n_awake; k < g->n; k++) {
        m->highest_asleep = g->z[k] > m->highest_asleep ? g->z[k] : m->highest_asleep;
    }
    s->measured = -1;
    ry_sleep_list_sets(s);
    RY_TRY(ry_sleep_take_frozen(s, error));
    sample_asleep(s);
    ry_sleep_sum_frozen(s);
    watch_anew(s);
    return RY_OK;
}

void ry_sleep_free(ry_sleep *s)
{
    void *const arrays[] = {s->held, s->felt,  s->n_frozen, s->watch,   s->woken, s->home,
                            s->struck, s->mark, s->own_load, s->awake, s->asleep, s->restless, s->kept};
    for (size_t a = 0; a < sizeof arrays / sizeof *arrays; a++) {
        free(arrays[a]);
    }
    ry_contacts_free(&s->frozen);
    *s = (ry_sleep){0};
}
