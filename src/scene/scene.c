/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "scene/scene.h"

#include <stdlib.h>

#include "base/memory.h"
#include "config/overlap.h"
#include "config/resolve.h"
#include "scene/packing.h"
#include "stage/column.h"

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

/* ---- explicit grains in a bed ----------------------------------------------------------------- */

/* The explicit grains, and of the others those that may reach one of them: near the box around all of them, or where x
 * is periodic between its lower and its upper side. index: which grain a disc is. Returns how many. */
static int find_near(const ry_config *config, const ry_grains *g, ry_disc *discs, int32_t *index)
{
    const int32_t own = config->n_particles;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    int n = 0;
    for (int32_t k = 0; k < g->n; k++) {
        const double at[2] = {g->x[k], g->z[k]}, r = g->radius[k];
        for (int axis = 0; axis < 2 && k < own; axis++) {
            low[axis] = fmin(low[axis], at[axis] - r);
            high[axis] = fmax(high[axis], at[axis] + r);
        }
        const int beside = !config->domain_periodic && (at[0] + r < low[0] || at[0] - r > high[0]);
        if (k < own || !(beside || at[1] + r < low[1] || at[1] - r > high[1])) {
            discs[n] = (ry_disc){at[0], at[1], r, g->fixed[k]};
            index[n++] = k;
        }
    }
    return n;
}

/* Explicit grains must not lie in those of the bed or of the rough floor. */
static ry_status check_explicit(const ry_config *config, const ry_grains *g, const ry_scene_size *size, double length,
                                ry_error *error)
{
    if (size->explicit_grains == 0 || size->bed + size->floor == 0) {
        return RY_OK;
    }
    ry_disc *const discs = ry_array((size_t)g->n, sizeof *discs);
    int32_t *const index = ry_array((size_t)g->n, sizeof *index);
    if (discs == NULL || index == NULL) {
        free(discs);
        free(index);
        return ry_no_memory(error, (size_t)g->n * sizeof *discs);
    }
    ry_overlap found = {-1, -1, 0.0, 0.0};
    const int n = find_near(config, g, discs, index);
    ry_status status =
        ry_overlap_find(discs, n, config->n_particles, config->domain_periodic ? length : 0.0, &found, error);
    if (status == RY_OK && found.first >= 0) {
        const ry_check check = {.config = config, .error = error};
        const int32_t other = index[found.second];
        status = ry_check_fail_particle(&check, found.first, "overlaps a grain of the %s, at x = %.6g m, z = %.6g m, by "
                                        "%.3g m; allowed at the start is %.3g m, a twentieth of the smaller diameter",
                                        other < size->explicit_grains + size->bed ? "bed" : "rough floor", g->x[other],
                                        g->z[other], found.depth, found.most);
    }
    free(discs);
    free(index);
    return status;
}

/* What the grains take of each cell of the fluid's column, added to `taken` [m^3]. */
static void add_volumes(const ry_grains *g, int32_t nz, double dz, double *taken)
{
    for (int32_t k = 0; k < g->n; k++) {
        const double r = g->radius[k], volume = ry_column_volume(r);
        const int32_t first = (int32_t)fmax(floor((g->z[k] - r) / dz), 0.0);
        for (int32_t c = first; c < nz && c * dz < g->z[k] + r; c++) {
            const double foot = (c * dz - g->z[k]) / r, top = ((c + 1) * dz - g->z[k]) / r;
            taken[c] += volume * (ry_slice_below(top) - ry_slice_below(foot));
        }
    }
}

/* Explicit grains may need more room than the fluid has, which is domain.length long (a diameter, where none is given)
 * and a mean diameter wide: a large one, or several beside each other. */
static ry_status check_room(const ry_config *config, const ry_derived *q, const ry_state *state, ry_error *error)
{
    const ry_column *const column = &state->column;
    if (config->fluid_model == RY_FLUID_NONE || config->n_particles == 0) {
        return RY_OK;
    }
    double *const taken = ry_array((size_t)column->nz, sizeof *taken);
    if (taken == NULL) {
        return ry_no_memory(error, (size_t)column->nz * sizeof *taken);
    }
    add_volumes(&state->grains, column->nz, column->dz, taken);
    int32_t fullest = 0;
    for (int32_t c = 1; c < column->nz; c++) {
        fullest = taken[c] > taken[fullest] ? c : fullest;
    }
    const double part = taken[fullest] / ((q->length > 0.0 ? q->length : q->d) * q->d * column->dz);
    free(taken);
    const ry_check check = {.config = config, .error = error};
    return !(part > 1.0)
               ? RY_OK
               : ry_check_fail(&check, RY_KEY_domain_length,
                               "at z = %.3g m the grains take %.3g times the room that the fluid has, which is "
                               "domain.length long%s and as wide as the mean diameter, %g m; give at least %.3g m",
                               (fullest + 0.5) * column->dz, part,
                               q->length > 0.0 ? "" : " (a diameter, for none is given)", q->d,
                               1.1 * part * (q->length > 0.0 ? q->length : q->d));
}

/* ---- all of it -------------------------------------------------------------------------------- */

ry_status ry_scene_build(const ry_config *config, ry_state *state, ry_error *error)
{
    const ry_scene_size size = ry_scene_measure(config);
    const ry_derived derived = ry_config_derive(config);
    const int64_t n = size.explicit_grains + size.bed + size.floor;
    if (n < 1 || n > INT32_MAX / 16) {
        return ry_fail(error, RY_BAD_INPUT, "%s: grains.columns x grains.layers, particles and a rough floor of domain.length "
                       "are %lld grains; 1 to %d are allowed", config->path, (long long)n, INT32_MAX / 16);
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
    RY_TRY(check_explicit(config, &state->grains, &size, derived.length, error));
    return check_room(config, &derived, state, error);
}
