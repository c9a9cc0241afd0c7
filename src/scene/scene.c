/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "scene/scene.h"

#include <stdlib.h>

#include "base/memory.h"
#include "scene/packing.h"

/* The column has six cells to a diameter and ends 24 diameters above the highest grain; very high
 * scenes get coarser cells. */
#define CELLS_PER_DIAMETER 6.0
#define AIR 24.0
#define MOST_CELLS 8192.0

static double highest(const ry_config *config, double length)
{
    double top = 0.0;
    if (config->has_grains) {
        const ry_places places = ry_packing_plan(config, length);
        top = places.base + (double)places.rows * places.pitch_z;
    }
    for (int k = 0; k < config->n_particles; k++) {
        top = fmax(top, config->particles[k].position[1] + 0.5 * config->particles[k].diameter);
    }
    return top;
}

ry_scene_size ry_scene_measure(const ry_config *config)
{
    const ry_derived derived = ry_config_derive(config);
    ry_scene_size size = {.explicit_grains = config->n_particles};
    if (config->has_grains) {
        size.bed = ry_packing_plan(config, derived.length).n;
    }
    if (config->domain_floor == RY_FLOOR_ROUGH && derived.length > 0.0) {
        size.floor = (int64_t)ceil(derived.length / derived.d - 1e-9);
    }
    if (config->fluid_model != RY_FLUID_NONE || config->has_grains) {
        const double height = highest(config, derived.length) + AIR * derived.d;
        const double cells = fmin(ceil(height * CELLS_PER_DIAMETER / derived.d), MOST_CELLS);
        size.nz = (int32_t)cells;
        size.dz = fmax(height / cells, derived.d / CELLS_PER_DIAMETER);
    }
    return size;
}

static void put(ry_grains *g, int64_t k, double x, double z, double diameter, double density)
{
    g->x[k] = x;
    g->z[k] = z;
    g->radius[k] = 0.5 * diameter;
    g->density[k] = density;
}

static void put_particles(const ry_config *config, ry_grains *g)
{
    for (int k = 0; k < config->n_particles; k++) {
        const ry_particle *const p = &config->particles[k];
        put(g, k, p->position[0], p->position[1], p->diameter, p->density);
        g->fixed[k] = p->fixed != 0;
        if (!p->fixed) {
            g->vx[k] = p->velocity[0];
            g->vz[k] = p->velocity[1];
            g->spin[k] = p->spin;
        }
    }
}

static ry_status put_bed(const ry_config *config, double length, ry_grains *g, int64_t first, int64_t n,
                         ry_error *error)
{
    if (n == 0) {
        return RY_OK;
    }
    ry_placed *const placed = ry_array((size_t)n, sizeof *placed);
    if (placed == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *placed);
    }
    const ry_places places = ry_packing_plan(config, length);
    ry_packing_fill(config, &places, placed);
    for (int64_t k = 0; k < n; k++) {
        put(g, first + k, placed[k].x, placed[k].z, placed[k].diameter, config->grains_density);
    }
    free(placed);
    return RY_OK;
}

/* A row of fixed grains of mean diameter, centres on z = 0, close enough that nothing falls through. */
static void put_floor(const ry_derived *derived, ry_grains *g, int64_t first, int64_t n)
{
    const double pitch = derived->length / (double)n;
    for (int64_t k = 0; k < n; k++) {
        put(g, first + k, ((double)k + 0.5) * pitch, 0.0, derived->d, derived->density);
        g->fixed[first + k] = 1;
    }
}

static void wrap(ry_grains *g, double length)
{
    for (int32_t k = 0; k < g->n; k++) {
        g->x[k] -= g->x[k] >= length ? length : 0.0;
        g->x[k] += g->x[k] < 0.0 ? length : 0.0;
    }
}

ry_status ry_scene_build(const ry_config *config, ry_state *state, ry_error *error)
{
    const ry_scene_size size = ry_scene_measure(config);
    const ry_derived derived = ry_config_derive(config);
    const int64_t n = size.explicit_grains + size.bed + size.floor;
    if (n < 1 || n > INT32_MAX / 16) {
        return ry_fail(error, RY_BAD_INPUT, "%s: the scene has %lld grains; 1 to %d are allowed",
                       config->path, (long long)n, INT32_MAX / 16);
    }
    const int ledger = (config->output_fields & RY_FIELD_ENERGY) != 0;
    RY_TRY(ry_state_create(state, (int32_t)n, size.nz, ledger, error));
    state->column.dz = size.dz;
    put_particles(config, &state->grains);
    RY_TRY(put_bed(config, derived.length, &state->grains, size.explicit_grains, size.bed, error));
    put_floor(&derived, &state->grains, size.explicit_grains + size.bed, size.floor);
    if (config->domain_periodic) {
        wrap(&state->grains, derived.length);
    }
    return RY_OK;
}
