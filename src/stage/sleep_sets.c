/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sleep: the sets in storage, and the contacts of those that sleep. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "stage/measure.h"
#include "stage/sleep_private.h"

/* ---- grains change places -------------------------------------------------------------------- */

/* Those that woke change places with the first sleepers. */
void ry_sleep_order_woken(ry_sleep *s)
{
    const uint8_t *const asleep = s->state->sleepers.asleep;
    int32_t *const was = s->places->was, awake = s->motion->n_awake;
    for (int32_t k = 0; k < s->state->grains.n; k++) {
        was[k] = k;
    }
    for (int32_t k = awake; k < s->state->grains.n; k++) {
        if (!asleep[was[k]]) {
            const int32_t first = was[awake];
            was[awake++] = was[k];
            was[k] = first;
        }
    }
    s->motion->n_awake = awake;
}

/* All come back to the order asked for, those awake before those asleep. */
void ry_sleep_order_all(ry_sleep *s)
{
    const ry_state *const state = s->state;
    int32_t *const was = s->places->was, next = 0;
    for (int asleep = 0; asleep < 2; asleep++) {
        for (int32_t r = 0; r < state->grains.n; r++) {
            const int32_t k = s->pairs->place[s->home[r]];
            if (state->sleepers.asleep[k] == asleep) {
                was[next++] = k;
            }
        }
        s->motion->n_awake = asleep == 0 ? next : s->motion->n_awake;
    }
}

void ry_sleep_list_sets(ry_sleep *s)
{
    const int32_t *const place = s->pairs->place;
    const int32_t n = s->state->grains.n, first = s->motion->n_awake;
    int32_t awake = 0, asleep = 0;
    for (int32_t id = 0; id < n; id++) { /* each has room for one behind its end */
        const int32_t k = place[id];
        s->awake[awake] = s->asleep[asleep] = k;
        awake += k < first;
        asleep += k >= first;
    }
    *s->sets = (ry_sets){place, s->awake, s->asleep, awake, asleep, s->sets->changes + 1};
}

/* ---- frozen contacts ------------------------------------------------------------------------- */

static int sleeps(const ry_sleep *s, int32_t id)
{
    return id >= s->state->grains.n || s->state->sleepers.asleep[s->pairs->place[id]];
}

static void copy_contact(ry_contacts *to, int64_t at, const ry_contacts *from, int64_t c)
{
#define COPY(type, name, unit, text)    \
    if (to->name != NULL && from->name != NULL) { \
        to->name[at] = from->name[c];   \
    }
    RY_CONTACT_FIELDS(COPY)
    RY_WET_FIELDS(COPY)
    RY_FROZEN_FIELDS(COPY)
#undef COPY
}

/* Adds `more` to `all`; both are sorted and have nothing in common. From the end, so that nothing is in the way.
 * `kept`, of all, goes along; NULL: nothing does. */
static ry_status merge(ry_contacts *all, const ry_contacts *more, struct ry_kept *kept, ry_error *error)
{
    int64_t a = all->n - 1, b = more->n - 1, at = all->n + more->n - 1;
    RY_TRY(ry_contacts_reserve(all, at + 1, error));
    all->n = at + 1;
    for (; b >= 0; at--) {
        const int later = a >= 0 && (all->id_i[a] > more->id_i[b] ||
                                     (all->id_i[a] == more->id_i[b] && all->id_j[a] > more->id_j[b]));
        if (kept != NULL) {
            kept[at] = later ? kept[a] : (struct ry_kept){NAN, NAN};
        }
        if (later) {
            copy_contact(all, at, all, a--);
        } else {
            copy_contact(all, at, more, b--);
        }
    }
    return RY_OK;
}

ry_status ry_sleep_export(const ry_sleep *s, ry_contacts *all, ry_error *error)
{
    return merge(all, &s->frozen, NULL, error);
}

static ry_status make_room(ry_sleep *s, size_t n, ry_error *error)
{
    return ry_array_grow(&s->kept, &s->kept_room, (size_t)s->frozen.n, n, sizeof *s->kept, error);
}

/* Of all contacts in the state those of two sleepers. */
ry_status ry_sleep_take_frozen(ry_sleep *s, ry_error *error)
{
    const ry_contacts *const all = &s->state->contacts;
    RY_TRY(ry_contacts_reserve(&s->frozen, all->n, error));
    RY_TRY(make_room(s, (size_t)all->n, error));
    s->frozen.n = 0;
    for (int64_t c = 0; c < all->n; c++) {
        if (sleeps(s, all->id_i[c]) && sleeps(s, all->id_j[c])) {
            s->kept[s->frozen.n] = (struct ry_kept){NAN, NAN};
            copy_contact(&s->frozen, s->frozen.n++, all, c);
        }
    }
    return RY_OK;
}

/* Slot of a contact in the list. */
static int32_t slot_of(const ry_sleep *s, int32_t id_i, int32_t id_j)
{
    const ry_pairs *const pairs = s->pairs;
    const int32_t k = pairs->place[id_i];
    if (id_j >= pairs->n_grains) {
        return pairs->wall_slot[id_j - pairs->n_grains][k];
    }
    int32_t p = pairs->row[k];
    while (pairs->j[p] != pairs->place[id_j]) {
        p++;
    }
    return p;
}

static int touches(const ry_sleep *s, int32_t p)
{
    const double *const radius = s->state->grains.radius;
    const ry_gap gap = ry_contact_gap(s->contact, &s->state->grains, s->pairs, p);
    return gap.distance < radius[s->pairs->i[p]] + radius[s->pairs->j[p]];
}

/* Contacts of the list between grains that now sleep, with their impulses of this step; not those that have parted
 * in it. */
ry_status ry_sleep_freeze(ry_sleep *s, ry_error *error)
{
    ry_contacts *const all = &s->state->contacts;
    RY_TRY(ry_pairs_export(s->pairs, s->state->grains.id, all, error));
    int64_t n = 0;
    for (int64_t c = 0; c < all->n; c++) {
        const int both = sleeps(s, all->id_i[c]) && sleeps(s, all->id_j[c]);
        const int32_t p = both ? slot_of(s, all->id_i[c], all->id_j[c]) : -1;
        if (both && touches(s, p)) {
            const double *const slot = s->pairs->slot[p];
            copy_contact(all, n, all, c);
            all->frozen_x[n] = slot[RY_SLOT_X];
            all->frozen_z[n] = slot[RY_SLOT_Z];
            all->frozen_turn[n++] = slot[RY_SLOT_TURN];
        }
    }
    all->n = n;
    RY_TRY(make_room(s, (size_t)(s->frozen.n + n), error));
    return merge(&s->frozen, all, s->kept, error);
}

/* Contacts one grain of which has woken go back to the list. */
void ry_sleep_thaw(ry_sleep *s)
{
    ry_contacts *const frozen = &s->frozen;
    int64_t kept = 0;
    for (int64_t c = 0; c < frozen->n; c++) {
        if (sleeps(s, frozen->id_i[c]) && sleeps(s, frozen->id_j[c])) {
            if (kept < c) {
                s->kept[kept] = s->kept[c];
                copy_contact(frozen, kept, frozen, c);
            }
            kept++;
        } else {
            ry_pairs_import_one(s->pairs, s->state->grains.id, frozen, c);
        }
    }
    frozen->n = kept;
}

/* What the frozen contacts give each grain; added in ascending id of the partner. */
void ry_sleep_sum_frozen(ry_sleep *s)
{
    const ry_contacts *const c = &s->frozen;
    const int32_t n = s->state->grains.n;
    memset(s->held, 0, (size_t)n * sizeof *s->held);
    memset(s->n_frozen, 0, (size_t)n * sizeof *s->n_frozen);
    for (int64_t m = 0; m < c->n; m++) {
        const int32_t ends[2] = {s->pairs->place[c->id_i[m]], c->id_j[m] < n ? s->pairs->place[c->id_j[m]] : -1};
        for (int e = 0; e < 2 && ends[e] >= 0; e++) {
            double *const held = s->held[ends[e]];
            held[RY_SLOT_X] += e == 0 ? c->frozen_x[m] : -c->frozen_x[m];
            held[RY_SLOT_Z] += e == 0 ? c->frozen_z[m] : -c->frozen_z[m];
            held[RY_SLOT_TURN] += c->frozen_turn[m];
            s->n_frozen[ends[e]]++;
        }
    }
    memcpy(s->felt, s->held, (size_t)n * sizeof *s->felt);
}

/* One frozen contact as a list, as far as measuring needs one. */
static struct ry_kept measure_frozen(const ry_sleep *s, int64_t c)
{
    const ry_contacts *const all = &s->frozen;
    const int32_t n = s->state->grains.n, id_j = all->id_j[c];
    int32_t i = s->pairs->place[all->id_i[c]], j = id_j < n ? s->pairs->place[id_j] : id_j;
    uint8_t age = all->age[c];
    const ry_pairs list = {.n_grains = n, .n = 1, .i = &i, .j = &j, .age = &age, .slip = all->slip + c,
                           .rest = all->rest != NULL ? all->rest + c : NULL};
    const ry_contact_sums sums = ry_contact_measure_run(s->contact, &s->state->grains, &list);
    return (struct ry_kept){sums.elastic_normal, sums.elastic_tangential};
}

ry_sleep_sums ry_sleep_measure(ry_sleep *s)
{
    const ry_sets *const sets = s->sets;
    ry_sleep_sums sums = {0};
    for (int64_t c = 0; c < s->frozen.n; c++) {
        if (isnan(s->kept[c].normal)) {
            s->kept[c] = measure_frozen(s, c);
        }
        sums.elastic_normal += s->kept[c].normal;
        sums.elastic_tangential += s->kept[c].tangential;
    }
    if (s->measured != sets->changes) {
        s->gravity = 0.0;
        for (int32_t rank = 0; rank < sets->n_asleep; rank++) {
            const int32_t k = sets->asleep[rank];
            s->gravity += s->motion->im[k] > 0.0 ? ry_measure_gravity(&s->state->grains, s->motion, k) : 0.0;
        }
        s->measured = sets->changes;
    }
    sums.gravity = s->gravity;
    return sums;
}
