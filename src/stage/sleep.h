/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sleep: grains that rest among others that rest are skipped, and woken by a change of the force on them.
 *
 * A sleeper lies still, its velocity and spin are 0. For others it is a partner like any. Two sleepers make no
 * pair; what their contact remembers, and its last impulse, is kept aside (`frozen`). So the list of pairs, and
 * all that runs over it, has pairs of awake grains only, and those between them and the sleepers around them; and
 * what runs over grains runs over the first motion->n_awake: the awake ones come first in storage, whose order may
 * be any.
 *
 * Who sleeps is decided by the state and the number of the step alone, never by the list, whose making nobody
 * should see.
 *
 * Falling asleep, at a look every LOOK sqrt(d/g'), g' the gravity less buoyancy: a grain that has gone less than
 * STILL d since the last one, has two contacts or more, is too slow to rise by STILL d, and all of whose
 * neighbours nearer than QUIET d are as quiet; and whom the flow reaches never does: the fluid's force along x is
 * at most SWEPT of its weight. What falls asleep was slower than STILL/LOOK sqrt(g' d) = 1.4e-3 sqrt(g' d): a
 * layer of such grains carries a flux q* of 8e-4 at the most.
 *
 * Waking: by a change of the force of its contacts, in the mean over a natural period of a grain on its springs
 * (what is shorter shakes a grain elastically; so it is looked at twice in a period), or of the fluid's force,
 * larger than contact.sleep x the mean load of the grains around it; by one so violent that a single step brings
 * the mean there, at once; and where the fluid's force is more than twice SWEPT of the weight. Sleepers nearer
 * than AROUND d wake with it. In the step in which it wakes a grain moves by the change of the force alone: the
 * rest balances. So it does for who measures: the contacts of a sleeper give it just what the fluid takes. */
#ifndef RY_STAGE_SLEEP_H
#define RY_STAGE_SLEEP_H

#include "stage/contact.h"
#include "stage/flow.h"
#include "stage/motion.h"
#include "stage/neighbor.h"
#include "stage/places.h"

typedef struct ry_sleep {
    double tolerance; /* contact.sleep; 0: nobody sleeps, and nothing below is used */
    int64_t look_every;  /* steps; 0: never, without gravity */
    int64_t check_every; /* steps between comparisons of the mean change with what a sleeper bears */
    double still, slow2; /* way between looks, and square of the speed, of a grain at rest [m, m^2/s^2] */
    double quiet, around; /* gaps between surfaces [m] */
    double part;          /* of a step in the running mean [1] */
    ry_state *state;
    ry_neighbor *neighbor;
    ry_contact *contact;
    ry_motion *motion;
    ry_pairs *pairs;
    ry_places *places;      /* with room */
    ry_flow *flow;        /* NULL: no fluid */
    ry_sets *sets;
    int32_t *awake, *asleep; /* n: those of the sets */

    ry_contacts frozen;   /* of two sleepers, sorted */
    struct ry_kept { double normal, tangential; } *kept; /* energies of those; normal NAN: not known yet [J] */
    size_t kept_room;
    double (*held)[RY_SLOT]; /* n: what they give each grain [N s] */
    double (*felt)[RY_SLOT]; /* n: what all contacts give each sleeper in this step [N s] */
    uint8_t *restless;    /* n: 1: a sleeper whose mean change of force is not 0, or will not stay so */
    int32_t *n_frozen;    /* n: how many each has */
    int32_t *watch, n_watch; /* sleepers whose force may change */
    int64_t watched;      /* rebuild for which they were listed */
    int32_t *woken, n_woken; /* in this step */
    int32_t *home;        /* ids in the order asked for */
    int32_t *struck;      /* n: scratch */
    uint8_t *mark;
    double *own_load;
    double gravity;       /* energy of the sleepers, as of `measured` of the sets [J] */
    int64_t measured;
    int32_t n_fixed;
    double slept;         /* sum over the steps of the part of the grains that slept */
    int64_t steps;
} ry_sleep;

/* `sleep` has its numbers, the parts of the plan and the arrays of the plan to be carried; the list is made and the
 * contacts of the state are imported into it. Grains asleep come last in storage. */
ry_status ry_sleep_create(ry_sleep *sleep, ry_error *error);
void ry_sleep_free(ry_sleep *sleep);

/* Who wakes, and at a look who falls asleep; after integrate. */
ry_status ry_sleep_stage(ry_sleep *sleep, ry_error *error);

/* Adds the frozen contacts to those exported from the list. */
ry_status ry_sleep_export(const ry_sleep *sleep, ry_contacts *all, ry_error *error);

/* Elastic energies of the frozen contacts, and what gravity holds of the sleepers [J]. */
typedef struct ry_sleep_sums {
    double elastic_normal, elastic_tangential, gravity;
} ry_sleep_sums;
ry_sleep_sums ry_sleep_measure(ry_sleep *sleep);

/* Sets the numbers: d, g', the period on the springs and dt [m, m/s^2, s, s]. */
void ry_sleep_scale(ry_sleep *sleep, double tolerance, double d, double gravity, double period, double dt);

#endif
