/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The simulations of a tuning: a lattice that settles in the dry, and a flux at one stress. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/spectrum.h"
#include "analysis/statistics.h"
#include "base/memory.h"
#include "sim/sim.h"
#include "study/tune_private.h"

/* The flux is looked at when this time has passed since the boost, then at times this factor apart. */
#define FIRST_LOOK 1.0
#define LOOK_FACTOR 1.4
/* Packings differ by more than this, so more of them are worth more than longer runs. */
#define RELATIVE_GOAL 0.15
#define TOLERANCE_COARSE 1e-3
#define TOLERANCE_FINE 1e-4
/* The settled height is the mean over this last part of the window. */
#define TAIL 0.1
/* Further off than this [d] it still rearranges. */
#define RINGING_FROM 0.02
enum { STEPS_BETWEEN_ASKING = 2000 };

static double mean_height(const ry_sim *sim, double d)
{
    const ry_view v = ry_sim_view(sim);
    double sum = 0.0, mass = 0.0;
    for (int k = 0; k < v.n; k++) {
        if (!v.fixed[k]) {
            const double m = v.density[k] * v.radius[k] * v.radius[k] * v.radius[k];
            sum += m * v.z[k];
            mass += m;
        }
    }
    return mass > 0.0 ? sum / mass / d : 0.0;
}

/* Once per piece, so all pairs will do; of a wide bed only the first grains are looked at. */
static double deepest_overlap(const ry_sim *sim, const ry_derived *q, int is_periodic)
{
    enum { MOST = 4000 };
    const ry_view v = ry_sim_view(sim);
    const int n = v.n < MOST ? v.n : MOST;
    double deepest = 0.0;
    for (int i = 0; i < n; i++) {
        for (int j = i + 1; j < n; j++) {
            double dx = v.x[i] - v.x[j];
            if (is_periodic) {
                dx -= q->length * round(dx / q->length);
            }
            const double gap = hypot(dx, v.z[i] - v.z[j]) - v.radius[i] - v.radius[j];
            if (!(v.fixed[i] && v.fixed[j])) {
                deepest = fmax(deepest, -gap);
            }
        }
    }
    return deepest / q->d;
}

/* When the curve has come within `tolerance` of `end` for good: by its last point outside. */
static double settled_at(const double *curve, int n, double end, double tolerance, double spacing)
{
    int k = n;
    while (k > 0 && fabs(curve[k - 1] - end) <= tolerance) {
        k--;
    }
    return k * spacing;
}

static void read_curve(ry_tune_piece *piece, int n, double spacing)
{
    const double *const curve = piece->value + RY_TUNE_CURVE;
    const int from = n - (int)(TAIL * n) - 1;
    double sum = 0.0, low = INFINITY, high = -INFINITY;
    for (int k = from; k < n; k++) {
        sum += curve[k];
        low = fmin(low, curve[k]);
        high = fmax(high, curve[k]);
    }
    const double end = sum / (n - from);
    piece->value[RY_TUNE_COARSE] = settled_at(curve, n, end, TOLERANCE_COARSE, spacing);
    piece->value[RY_TUNE_FINE_] = settled_at(curve, n, end, TOLERANCE_FINE, spacing);
    piece->value[RY_TUNE_HEIGHT] = end;
    piece->value[RY_TUNE_UNREST] = high - low > TOLERANCE_FINE;
}

/* The bed rings once its grains have found their places, near its settled height. */
static ry_status read_ringing(ry_tune_piece *piece, int n, double spacing, ry_error *error)
{
    const double *const curve = piece->value + RY_TUNE_CURVE;
    int from = n;
    while (from > 0 && fabs(curve[from - 1] - piece->value[RY_TUNE_HEIGHT]) <= RINGING_FROM) {
        from--;
    }
    ry_ringing ringing;
    const ry_status status = ry_spectrum_ringing(curve + from, n - from, &ringing, error);
    piece->value[RY_TUNE_PERIOD] = spacing / ringing.frequency;
    piece->value[RY_TUNE_RINGING] = ringing.damping;
    return status;
}

static ry_status settle(ry_tune_piece *piece, ry_sim *sim, ry_tune_stop *stop, void *data,
                        ry_error *error)
{
    const ry_derived q = ry_config_derive(&piece->config);
    const int n = (int)(q.steps_end / RY_TUNE_CURVE_STEPS) + 1;
    piece->value = ry_array((size_t)(RY_TUNE_CURVE + n), sizeof(double));
    if (piece->value == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof(double));
    }
    piece->n = RY_TUNE_CURVE + n;
    for (int k = 0; k < n; k++) {
        piece->value[RY_TUNE_CURVE + k] = mean_height(sim, q.d);
        if (k + 1 < n) {
            RY_TRY(ry_sim_step(sim, RY_TUNE_CURVE_STEPS, error));
        }
        if (k % (STEPS_BETWEEN_ASKING / RY_TUNE_CURVE_STEPS) == 0 && stop(data)) {
            return RY_STOPPED;
        }
    }
    piece->value[RY_TUNE_DEEPEST] = deepest_overlap(sim, &q, piece->config.domain_periodic);
    read_curve(piece, n, RY_TUNE_CURVE_STEPS * piece->config.time_step);
    return read_ringing(piece, n, RY_TUNE_CURVE_STEPS * piece->config.time_step, error);
}

/* --- flux --- */

static int is_enough(const ry_tune_piece *piece, const ry_series_statistics *s)
{
    const double wanted = fmax(RELATIVE_GOAL * fabs(s->mean), piece->goal * piece->target);
    return s->effective_samples >= RY_SERIES_ENOUGH && s->standard_error < wanted;
}

static ry_status sample_flux(ry_tune_piece *piece, ry_sim *sim, double *series, ry_tune_stop *stop,
                             void *data, ry_error *error)
{
    const ry_derived q = ry_config_derive(&piece->config);
    const double spacing = q.steps_series * piece->config.time_step;
    const int64_t all = (q.steps_end - ry_sim_view(sim).step) / q.steps_series;
    double look = FIRST_LOOK;
    ry_series_statistics s = {0};
    int64_t n = 0;
    while (n < all) {
        RY_TRY(ry_sim_step(sim, q.steps_series, error));
        series[n++] = ry_sim_sample(sim).q_star;
        if (n % 40 == 0 && stop(data)) {
            return RY_STOPPED;
        }
        if ((double)n * spacing >= look || n == all) {
            const int64_t first = ry_series_under_way(series, n);
            RY_TRY(ry_series_equilibrated(series + first, n - first, &s, error));
            look *= LOOK_FACTOR;
            if (is_enough(piece, &s)) {
                break;
            }
        }
    }
    piece->value[RY_TUNE_Q] = s.mean;
    piece->value[RY_TUNE_Q_ERROR] = s.standard_error;
    piece->value[RY_TUNE_TAU] = s.autocorrelation_time * spacing;
    piece->value[RY_TUNE_END] = ry_sim_view(sim).time;
    return RY_OK;
}

static ry_status flux(ry_tune_piece *piece, ry_sim *sim, ry_tune_stop *stop, void *data,
                      ry_error *error)
{
    const ry_derived q = ry_config_derive(&piece->config);
    const long long start = q.steps_settle + llround(RY_TUNE_BOOST / piece->config.time_step);
    double *const series = ry_array((size_t)(q.steps_end / q.steps_series + 1), sizeof(double));
    piece->value = ry_array(RY_TUNE_FLUX_VALUES, sizeof(double));
    piece->n = RY_TUNE_FLUX_VALUES;
    ry_status status = RY_OK;
    if (series == NULL || piece->value == NULL) {
        status = ry_no_memory(error, RY_TUNE_FLUX_VALUES * sizeof(double));
    }
    for (long long step = 0; status == RY_OK && step < start; step += STEPS_BETWEEN_ASKING) {
        const long long left = start - step;
        status = ry_sim_step(sim, left < STEPS_BETWEEN_ASKING ? left : STEPS_BETWEEN_ASKING, error);
        if (status == RY_OK && stop(data)) {
            status = RY_STOPPED;
        }
    }
    if (status == RY_OK) {
        status = sample_flux(piece, sim, series, stop, data, error);
    }
    free(series);
    return status;
}

/* --- both --- */

const char *ry_tune_reason(const ry_tune_piece *piece, int n)
{
    for (int k = 0; k < n; k++) {
        if (piece[k].why[0] != '\0') {
            return piece[k].why;
        }
    }
    return "";
}

void ry_tune_piece_clear(ry_tune_piece *piece)
{
    free(piece->value);
    piece->value = NULL;
    piece->n = 0;
}

/* What the physics refuses is a result of the piece, not a failure of the tuning. */
static ry_status take_failure(ry_tune_piece *piece, ry_status status, const ry_error *own,
                              ry_error *error)
{
    if (status == RY_UNPHYSICAL || status == RY_BAD_INPUT) {
        ry_tune_piece_clear(piece);
        piece->status = status;
        snprintf(piece->why, sizeof piece->why, "%.299s", own->text);
        piece->why[strcspn(piece->why, "\n")] = '\0';
        piece->done = 1;
        return RY_OK;
    }
    ry_tune_piece_clear(piece);
    return status == RY_STOPPED ? RY_STOPPED : ry_fail(error, status, "%s", own->text);
}

ry_status ry_tune_piece_run(ry_tune_piece *piece, ry_tune_stop *stop, void *data, ry_error *error)
{
    ry_error own = {0};
    if (stop(data)) {
        return RY_STOPPED;
    }
    ry_sim *const sim = ry_sim_create(&piece->config, 1, &own);
    ry_status status = sim == NULL ? own.status : RY_OK;
    if (status == RY_OK) {
        status = piece->kind == RY_TUNE_SETTLE ? settle(piece, sim, stop, data, &own)
                                               : flux(piece, sim, stop, data, &own);
    }
    if (status == RY_OK) {
        status = ry_sim_check(sim, &own); /* the last steps, too */
    }
    ry_sim_free(sim);
    piece->done = status == RY_OK;
    return status == RY_OK ? RY_OK : take_failure(piece, status, &own, error);
}
