/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench_stress.h"

#include <stdio.h>
#include <string.h>

/* Steps between looks at the energies, and how many parts the time has for the judgement of rest. */
enum { LOOK_EVERY = 32, PARTS = 4 };

typedef struct watch {
    int n_free;
    double unit;   /* m g' d of the mean grain, or where nothing has weight 0 [J] */
    double first;  /* kinetic energy at the start [J] */
    double lowest; /* of energy less work, so far [J] */
    double rise;   /* largest rise above it [J] */
    double sum[PARTS];
    int looks[PARTS];
    ry_sample last;
} watch;

static double energy_less_work(const ry_sample *s)
{
    return s->kinetic_energy + s->gravity_energy + s->elastic_normal + s->elastic_tangential -
           s->fluid_work;
}

static void begin(watch *w, const ry_config *config, ry_sim *sim)
{
    const ry_derived q = ry_config_derive(config);
    const ry_view view = ry_sim_view(sim);
    *w = (watch){.unit = q.mass * q.buoyant_gravity * q.d, .last = ry_sim_sample(sim)};
    for (int k = 0; k < view.n; k++) {
        w->n_free += !view.fixed[k];
    }
    w->first = w->last.kinetic_energy;
    w->lowest = energy_less_work(&w->last);
}

static void look(watch *w, ry_sim *sim, int part)
{
    const ry_sample s = ry_sim_sample(sim);
    const double energy = energy_less_work(&s);
    if (!isfinite(energy)) {
        return; /* the next check of the simulator stops it */
    }
    w->lowest = fmin(w->lowest, energy);
    w->rise = fmax(w->rise, energy - w->lowest);
    w->sum[part] += s.kinetic_energy;
    w->looks[part]++;
    w->last = s;
}

static ry_status run(watch *w, ry_sim *sim, long long steps, ry_error *error)
{
    for (long long step = 0; step < steps; step += LOOK_EVERY) {
        RY_TRY(ry_sim_step(sim, LOOK_EVERY, error));
        look(w, sim, (int)(step * PARTS / steps));
    }
    return RY_OK;
}

/* The yardstick for gains: what was lost; in scenes that lose little, what there was to lose. */
static double scale_of(const watch *w)
{
    const ry_sample *const s = &w->last;
    const double lost = s->loss_impact + s->loss_dashpot + s->loss_friction + s->loss_opening;
    return fmax(fmax(lost, w->first), w->n_free * w->unit);
}

static ry_stress_class judge_rest(const watch *w, const ry_stress *out)
{
    if (out->kinetic <= RY_STRESS_QUIET_ENERGY) {
        return RY_STRESS_QUIET;
    }
    const double before = w->sum[PARTS - 2] / fmax(w->looks[PARTS - 2], 1.0);
    const double after = w->sum[PARTS - 1] / fmax(w->looks[PARTS - 1], 1.0);
    return after <= 0.5 * before ? RY_STRESS_SETTLES : RY_STRESS_JITTERS;
}

static ry_stress_class judge(const watch *w, const ry_stress_wish *wish, const ry_stress *out)
{
    if (out->integration > 1.0) {
        return RY_STRESS_EXPLODES;
    }
    if (out->integration > RY_STRESS_TOLERANCE) {
        return RY_STRESS_GAINS;
    }
    if (out->integration < -RY_STRESS_TOLERANCE) {
        return RY_STRESS_LEAKS;
    }
    return wish->must_rest ? judge_rest(w, out) : RY_STRESS_QUIET;
}

/* The check of the simulator stopped it: grains overlap too much, or move too far in a step. Without a
 * gain of energy that tells of a contact that is too soft for the load, not of the time stepping. */
static ry_stress_class judge_stop(const ry_stress *out)
{
    const int is_overlap = strstr(out->message, "overlap by more") != NULL;
    const int has_gained = fmax(out->integration, out->rise) > RY_STRESS_SOFT;
    return is_overlap && !has_gained ? RY_STRESS_PRESSED : RY_STRESS_EXPLODES;
}

static ry_status observe(const ry_config *config, ry_stress_wish wish, ry_stress *out,
                         ry_error *error)
{
    ry_sim *const sim = ry_sim_create(config, 1, error);
    if (sim == NULL) {
        return error->status;
    }
    watch w;
    begin(&w, config, sim);
    const ry_status status = run(&w, sim, wish.steps, error);
    ry_sim_free(sim);
    const double scale = scale_of(&w);
    out->integration = scale > 0.0 ? w.last.integration / scale : 0.0;
    out->rise = scale > 0.0 ? w.rise / scale : 0.0;
    if (status == RY_UNPHYSICAL) {
        snprintf(out->message, sizeof out->message, "%.199s", error->text);
        out->class = judge_stop(out);
        return RY_OK;
    }
    if (wish.must_rest && w.n_free * w.unit > 0.0) {
        const double looks = fmax(w.looks[PARTS - 1], 1.0);
        out->kinetic = w.sum[PARTS - 1] / looks / (w.n_free * w.unit);
    }
    out->class = judge(&w, &wish, out);
    return status;
}

ry_status ry_stress_run(ry_config *config, ry_stress_wish wish, ry_stress *out, ry_error *error)
{
    *out = (ry_stress){.kinetic = NAN, .integration = NAN, .rise = NAN};
    ry_error own = {0};
    ry_status status = ry_config_resolve(config, &own);
    if (status == RY_BAD_INPUT) {
        out->class = RY_STRESS_REFUSED;
        snprintf(out->message, sizeof out->message, "%.199s", own.text);
        return RY_OK;
    }
    if (status == RY_OK) {
        status = observe(config, wish, out, &own);
    }
    return status == RY_OK ? RY_OK : ry_fail(error, status, "%s", own.text);
}

void ry_stress_merge(ry_stress *one, const ry_stress *other)
{
    if (other->class > one->class) {
        one->class = other->class;
    }
    one->kinetic = isnan(one->kinetic) ? other->kinetic : fmax(one->kinetic, other->kinetic);
    if (isnan(one->integration) || fabs(other->integration) > fabs(one->integration)) {
        one->integration = other->integration;
    }
    one->rise = isnan(one->rise) ? other->rise : fmax(one->rise, other->rise);
    if (!*one->message) {
        memcpy(one->message, other->message, sizeof one->message);
    }
}
