/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Which alpha_m, which alpha_cn. Theirs: the candidate whose bed comes to rest soonest. Ours for
 * alpha_m: the softest spring that is still stiff, for in a fixed step it resolves a collision best;
 * for alpha_cn: the least damping that brings the bed to rest as soon as any. The seeds are those of
 * all candidates, so a resampling of seeds tells how sure a choice is. */
#include <math.h>

#include "base/random.h"
#include "study/tune_private.h"

enum { RESAMPLES = 2000, SEED = 5897 };

static double value_of(const ry_tune_candidate *c, int seed, int which)
{
    return c->piece[seed].value[which];
}

static void mean_of(const ry_tune_candidate *c, int seeds, int which, double *mean, double *error)
{
    double sum = 0.0, squares = 0.0;
    for (int s = 0; s < seeds; s++) {
        sum += value_of(c, s, which);
    }
    *mean = sum / seeds;
    for (int s = 0; s < seeds; s++) {
        squares += (value_of(c, s, which) - *mean) * (value_of(c, s, which) - *mean);
    }
    *error = seeds > 1 ? sqrt(squares / (seeds - 1.0) / seeds) : NAN;
}

/* Numbers that are none count as the largest: the median is one if most seeds have none. */
static double median_of(const ry_tune_candidate *c, int seeds, int which)
{
    double sorted[RY_TUNE_SEEDS] = {0};
    for (int s = 0; s < seeds; s++) {
        const double value = value_of(c, s, which);
        int k = s;
        for (; k > 0 && !(sorted[k - 1] <= value) && !isnan(value); k--) {
            sorted[k] = sorted[k - 1];
        }
        sorted[k] = value;
    }
    return 0.5 * (sorted[(seeds - 1) / 2] + sorted[seeds / 2]);
}

static void take_candidate(ry_tune_candidate *c, int seeds)
{
    c->good = 1;
    for (int s = 0; s < seeds; s++) {
        c->good = c->good && c->piece[s].done && c->piece[s].status == RY_OK;
    }
    if (!c->good) {
        return;
    }
    mean_of(c, seeds, RY_TUNE_COARSE, &c->time[0], &c->error[0]);
    mean_of(c, seeds, RY_TUNE_FINE_, &c->time[1], &c->error[1]);
    mean_of(c, seeds, RY_TUNE_HEIGHT, &c->height, &c->height_error);
    mean_of(c, seeds, RY_TUNE_DEEPEST, &c->deepest, &c->deepest_error);
    c->period = median_of(c, seeds, RY_TUNE_PERIOD);
    c->ringing = median_of(c, seeds, RY_TUNE_RINGING);
    c->unrest = 0;
    for (int s = 0; s < seeds; s++) {
        c->unrest += value_of(c, s, RY_TUNE_UNREST) > 0.5;
    }
}

/* A sample of the seeds, with repeats. */
static void draw(int seeds, int round, int *picked)
{
    for (int s = 0; s < seeds; s++) {
        const double u =
            ry_random(SEED, RY_RANDOM_SAMPLE, (uint64_t)round * RY_TUNE_SEEDS + (uint64_t)s);
        picked[s] = (int)(u * seeds);
    }
}

static double mean_over(const ry_tune_candidate *c, int n, const int *picked, int which)
{
    double sum = 0.0;
    for (int s = 0; s < n; s++) {
        sum += value_of(c, picked[s], which);
    }
    return sum / n;
}

static int soonest(const ry_tune_settling *t, const int *picked)
{
    int best = -1;
    double least = INFINITY;
    for (int k = 0; k < t->n; k++) {
        if (t->candidate[k].good) {
            const double time = mean_over(&t->candidate[k], t->seeds, picked, RY_TUNE_FINE_);
            if (time < least) {
                least = time;
                best = k;
            }
        }
    }
    return best;
}

/* The softest one whose deepest overlap is allowed; the stiffest if none is. */
static int softest(const ry_tune_settling *t, const int *picked)
{
    int best = -1;
    for (int k = 0; k < t->n; k++) {
        const ry_tune_candidate *const c = &t->candidate[k];
        if (c->good &&
            (best < 0 || mean_over(c, t->seeds, picked, RY_TUNE_DEEPEST) <= RY_TUNE_OVERLAP)) {
            best = k;
        }
    }
    return best;
}

/* Seed by seed, is this one later than the best by no more than two standard errors? */
static int as_soon(const ry_tune_settling *t, int k, int best, const int *picked)
{
    double sum = 0.0, squares = 0.0;
    const ry_tune_candidate *const c = &t->candidate[k], *const b = &t->candidate[best];
    for (int s = 0; s < t->seeds; s++) {
        const double later =
            value_of(c, picked[s], RY_TUNE_FINE_) - value_of(b, picked[s], RY_TUNE_FINE_);
        sum += later;
        squares += later * later;
    }
    const double mean = sum / t->seeds;
    const double variance = fmax(squares / t->seeds - mean * mean, 0.0) / fmax(t->seeds - 1.0, 1.0);
    return mean <= 2.0 * sqrt(variance);
}

static int least_damping(const ry_tune_settling *t, const int *picked)
{
    const int best = soonest(t, picked);
    for (int k = 0; k < best; k++) {
        if (t->candidate[k].good && as_soon(t, k, best, picked)) {
            return k;
        }
    }
    return best;
}

static int is_stiffness(const ry_tune_settling *t)
{
    return t->key[6] == 'm'; /* alpha_m, alpha_cn */
}

static int our_choice(const ry_tune_settling *t, const int *picked)
{
    return is_stiffness(t) ? softest(t, picked) : least_damping(t, picked);
}

/* The middle 95 % of the choices of the resamples, as candidates. */
static void interval(const ry_tune_settling *t, int ours, double *low, double *high)
{
    int votes[RY_TUNE_CANDIDATES] = {0}, picked[RY_TUNE_SEEDS];
    for (int r = 0; r < RESAMPLES; r++) {
        draw(t->seeds, r, picked);
        votes[ours ? our_choice(t, picked) : soonest(t, picked)]++;
    }
    int below = 0, first = -1, last = 0;
    for (int k = 0; k < t->n; k++) {
        below += votes[k];
        if (first < 0 && below > RESAMPLES / 40) {
            first = k;
        }
        if (votes[k] > 0 && below - votes[k] < RESAMPLES - RESAMPLES / 40) {
            last = k;
        }
    }
    *low = t->candidate[first].value;
    *high = t->candidate[last].value;
}

ry_status ry_tune_choose(ry_tune_settling *t, ry_error *error)
{
    int all[RY_TUNE_SEEDS], good = 0;
    for (int s = 0; s < t->seeds; s++) {
        all[s] = s;
    }
    for (int k = 0; k < t->n; k++) {
        take_candidate(&t->candidate[k], t->seeds);
        good += t->candidate[k].good;
    }
    if (good == 0) {
        return ry_fail(error, RY_UNPHYSICAL, "no %s can be used; the first: %s", t->key,
                       ry_tune_reason(t->candidate[0].piece, t->seeds));
    }
    t->theirs = soonest(t, all);
    t->ours = our_choice(t, all);
    interval(t, 0, &t->theirs_low, &t->theirs_high);
    interval(t, 1, &t->ours_low, &t->ours_high);
    t->clear = 1;
    for (int k = 0; k < t->n; k++) {
        ry_tune_candidate *const c = &t->candidate[k];
        c->as_soon = c->good && as_soon(t, k, t->theirs, all);
        t->clear = t->clear && (k == t->theirs || !c->as_soon);
    }
    return RY_OK;
}
