/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench_maps.h"

#include <stdlib.h>

#include "base/memory.h"

/* Lengths of the runs [steps]. 50000 steps of 20 us are 140 times what a grain takes to fall by its
 * diameter: beds of this size that come to rest at all have by then. */
enum { REST = 50000, SHEAR = 10000, IMPACT = 4000, QUICK = 4 };

static const double step = 20e-6, diameter = 0.5e-3, density = 2650.0, pi = 3.14159265358979323846;

/* --- a bed that settles, and one that is sheared ----------------------------------------------- */

static ry_config bed(ry_law law)
{
    ry_config config = ry_config_default(1);
    config.time_step = step;
    config.grains_columns = 10;
    config.grains_layers = 8;
    config.contact_law = law;
    config.output_fields = RY_FIELD_ENERGY;
    return config;
}

typedef void set_fn(ry_config *config, double x, double y);

static ry_status run_beds(set_fn *set, ry_law law, double x, double y, int quick, ry_stress *out,
                          ry_error *error)
{
    const int part = quick ? QUICK : 1;
    ry_config dry = bed(law);
    dry.fluid_model = RY_FLUID_NONE;
    set(&dry, x, y);
    ry_status status =
        ry_stress_run(&dry, (ry_stress_wish){.steps = REST / part, .must_rest = 1}, out, error);
    ry_config_free(&dry);
    if (status != RY_OK || out->class == RY_STRESS_REFUSED) {
        return status;
    }
    ry_config wet = bed(law);
    wet.fluid_shields = 0.5;
    wet.time_settle = 0.0;
    set(&wet, x, y);
    ry_stress sheared;
    status = ry_stress_run(&wet, (ry_stress_wish){.steps = SHEAR / part}, &sheared, error);
    ry_config_free(&wet);
    if (status == RY_OK) {
        ry_stress_merge(out, &sheared);
    }
    return status;
}

static void set_alpha_cn(ry_config *config, double alpha_m, double alpha_cn)
{
    config->contact_alpha_m = alpha_m;
    config->contact_alpha_cn = alpha_cn;
}

static ry_status run_alpha_cn(ry_law law, double x, double y, int quick, ry_stress *out,
                              ry_error *error)
{
    return run_beds(set_alpha_cn, law, x, y, quick, out, error);
}

static void set_beta(ry_config *config, double alpha_m, double beta)
{
    config->contact_alpha_m = alpha_m;
    config->contact_beta = beta;
}

static ry_status run_beta(ry_law law, double x, double y, int quick, ry_stress *out,
                          ry_error *error)
{
    return run_beds(set_beta, law, x, y, quick, out, error);
}

/* --- explicit grains ---------------------------------------------------------------------------- */

/* A scene of n explicit grains under gravity, on a plane; NULL particles: no memory. */
static ry_config explicit_grains(ry_law law, int n)
{
    ry_config config = ry_config_default(0);
    config.time_step = step;
    config.domain_floor = RY_FLOOR_FLAT;
    config.domain_gravity = 9.81;
    config.contact_law = law;
    config.output_fields = RY_FIELD_ENERGY;
    config.particles = calloc((size_t)n, sizeof *config.particles);
    return config;
}

static void add(ry_config *config, double x, double z, double d)
{
    config->particles[config->n_particles++] =
        (ry_particle){.position = {x, z}, .diameter = d, .density = density};
}

/* A grain strikes a heap of 6 x 4 at 45 degrees. The stiffness is that of alpha_m = 20 at 20 us for
 * every dt: what changes is how well the step resolves the contact, and how deep the grain goes. */
static ry_status run_impact(ry_law law, double speed, double dt, int quick, ry_stress *out,
                            ry_error *error)
{
    enum { ALONG = 6, HIGH = 4 };
    ry_config config = explicit_grains(law, ALONG * HIGH + 1);
    if (config.particles == NULL) {
        return ry_no_memory(error, (ALONG * HIGH + 1) * sizeof *config.particles);
    }
    const double d = diameter, w = 2.0 * pi / (20.0 * step);
    for (int row = 0; row < HIGH; row++) {
        for (int k = 0; k < ALONG; k++) {
            add(&config, (1.001 * k + 0.5 * (row % 2)) * d, (0.501 + 0.87 * row) * d, d);
        }
    }
    add(&config, -1.2 * d, (1.5 + 0.87 * HIGH) * d, d);
    config.particles[ALONG * HIGH].velocity[0] = speed * sqrt(0.5);
    config.particles[ALONG * HIGH].velocity[1] = -speed * sqrt(0.5);
    config.time_step = dt;
    config.contact_stiffness = density * pi / 6.0 * d * d * d * w * w;
    config.contact_restitution = 0.5;
    /* an impact takes some half periods; no more steps than the bed needs to hand it on */
    const long long steps = (quick ? IMPACT / QUICK : IMPACT);
    const ry_status status = ry_stress_run(&config, (ry_stress_wish){.steps = steps}, out, error);
    ry_config_free(&config);
    return status;
}

/* Rows of large and of small grains by turns, so that the weight of large ones goes through small ones,
 * on a row of large ones that are fixed: on a plane a bed may roll on for ever. */
static ry_status run_sizes(ry_law law, double ratio, double layers, int quick, ry_stress *out,
                           ry_error *error)
{
    enum { LARGE = 4 };
    const double small = diameter, large = ratio * small, length = 1.02 * LARGE * large;
    const int rows = (int)layers + 1, per_row = (int)(length / (1.02 * small));
    const int n = rows * (per_row > LARGE ? per_row : LARGE);
    ry_config config = explicit_grains(law, n);
    if (config.particles == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *config.particles);
    }
    config.domain_periodic = 1;
    config.domain_length = length;
    double z = 0.0;
    for (int row = 0; row < rows; row++) {
        const int is_small = row % 2;
        const int along = is_small ? per_row : LARGE;
        const double d = is_small ? small : large, gap = length / along;
        for (int k = 0; k < along; k++) {
            /* a little off the lattice, or grains would stand on their tops for ever */
            add(&config, (k + 0.25 + 0.31 * (row / 2 % 2)) * gap, z + 0.501 * d, d);
        }
        z += 1.001 * d;
    }
    for (int k = 0; k < LARGE; k++) {
        config.particles[k].fixed = 1;
    }
    const ry_stress_wish wish = {.steps = quick ? REST / QUICK : REST, .must_rest = 1};
    const ry_status status = ry_stress_run(&config, wish, out, error);
    ry_config_free(&config);
    return status;
}

const ry_map ry_maps[RY_MAPS] = {
    {"alpha_cn",
     "bed of 10 x 8 grains that settles dry, then one that is sheared (Shields 0.5)",
     {"contact.alpha_m", "1", 12, {2, 3, 5, 7, 10, 14, 20, 40, 80, 160, 400, 1000}},
     {"contact.alpha_cn", "1", 12, {0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.3, 3, 10, 30, 100}},
     run_alpha_cn},
    {"beta",
     "the same beds, alpha_cn = 1.3",
     {"contact.alpha_m", "1", 12, {2, 3, 5, 7, 10, 14, 20, 40, 80, 160, 400, 1000}},
     {"contact.beta", "1", 10, {0.01, 0.1, 0.2, 0.5, 1, 2, 5, 15.8, 50, 1000}},
     run_beta},
    {"impact",
     "a grain strikes a heap of 6 x 4 grains; the stiffness is the same everywhere",
     {"impact speed", "m/s", 10, {0.001, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100}},
     {"time.step", "s", 10, {1e-6, 2e-6, 5e-6, 10e-6, 20e-6, 30e-6, 50e-6, 70e-6, 100e-6, 200e-6}},
     run_impact},
    {"sizes",
     "rows of large and small grains by turns, dry",
     {"size ratio", "1", 8, {1, 1.25, 1.5, 2, 3, 4, 6, 10}},
     {"layers", "1", 6, {1, 2, 3, 5, 10, 20}},
     run_sizes},
};
