/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/skin.h"

#include <math.h>

/* A grain at rest may go this far, any other so much further for each step of the horizon at the most, in mean
 * diameters. */
#define LEAST 0.05
#define A_STEP 0.0125
/* The horizon at first, and its bounds, in steps; by how much it changes, and after how many lists. */
#define FIRST 80.0
#define SHORTEST 10.0
#define LONGEST 160.0
#define CHANGE 1.25
enum { LISTS = 8 };
/* What a list costs of a grain, in pairs that are looked at once. Measured: docs/performance.md. */
#define LIST_COST 22.0

static void set_skins(ry_neighbor *b)
{
    const ry_skin *const s = &b->skin;
    b->skin_most = fmin((LEAST + A_STEP * s->steps) * s->d, s->room);
    b->skin_least = fmin(LEAST * s->d, b->skin_most);
    b->horizon = s->steps * s->dt;
}

void ry_skin_begin(ry_neighbor *b, double d, double dt, double room)
{
    b->skin = (ry_skin){.on = 1, .d = d, .dt = dt, .room = room, .steps = FIRST, .change = CHANGE, .cost = INFINITY,
                        .began = -1};
    set_skins(b);
}

/* The last lists are over: was it worth it? */
static void turn(ry_skin *s, double cost)
{
    s->change = cost > s->cost ? 1.0 / s->change : s->change;
    s->steps = fmin(fmax(s->steps * s->change, SHORTEST), LONGEST);
    s->cost = cost;
}

void ry_skin_tune(ry_neighbor *b, const ry_pairs *pairs, int64_t step)
{
    ry_skin *const s = &b->skin;
    const int made = (int)(b->rebuilds - s->rebuilds); /* one; or more, where grains sleep and wake */
    s->rebuilds = b->rebuilds;
    if (!s->on || s->began < 0) { /* who knows how long the first list has served */
        s->began = s->last = step;
        return;
    }
    s->looked += (double)pairs->n * (double)(step - s->last);
    s->looked += LIST_COST * (double)pairs->n_grains * made;
    s->last = step;
    s->lists += made;
    if (s->lists >= LISTS) {
        turn(s, s->looked / (double)(step - s->began));
        set_skins(b);
        s->lists = 0;
        s->looked = 0.0;
        s->began = step;
    }
}
