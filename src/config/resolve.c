/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Completes a config and checks what no single range can. Derived values that stay NAN afterwards,
 * because another parameter rules or the program chooses: contact.stiffness, fluid.shear_stress,
 * stop.flux_error (off), numerics.skin, and domain.length of an unbounded scene. */
#include "config/resolve.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "config/guard.h"

static const double pi = 3.14159265358979323846;
static const double most_steps = 1e15; /* of a run; counted in long long, converted to double */

static ry_place place_of(const ry_check *check, int key)
{
    if (check->places != NULL) {
        return check->places[key];
    }
    return (ry_place){.name = check->config->path};
}

ry_status ry_check_fail(const ry_check *check, int key, const char *format, ...)
{
    char what[1000], path[80];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    const ry_key_row *row = ry_keys_row(key);
    (void)snprintf(path, sizeof path, "%s.%s", row->section, row->key);
    return ry_place_fail(place_of(check, key), path, check->error, "%s", what);
}

static ry_place particle_place(const ry_config *config, int index)
{
    const ry_particle *const p = &config->particles[index];
    return (ry_place){.name = p->table > 0 ? config->tables[p->table - 1] : config->path, .line = p->line};
}

ry_status ry_check_fail_particle(const ry_check *check, int index, const char *format, ...)
{
    char what[1000], path[80];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    (void)snprintf(path, sizeof path, "particles[%d]", index);
    return ry_place_fail(particle_place(check->config, index), path, check->error, "%s", what);
}

ry_quote ry_check_name(const ry_check *check, int index)
{
    ry_quote name;
    const ry_place place = particle_place(check->config, index);
    const ry_quote file = ry_place_quote(place.name);
    if (place.line > 0 && check->config->particles[index].table > 0) {
        (void)snprintf(name.text, sizeof name.text, "line %d of %.40s", place.line, file.text);
    } else if (place.line > 0) {
        (void)snprintf(name.text, sizeof name.text, "the one of line %d", place.line);
    } else {
        (void)snprintf(name.text, sizeof name.text, "particles[%d]", index);
    }
    return name;
}

/* Values assigned by a program have not passed the reader. */
static ry_status check_ranges(const ry_check *check)
{
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        ry_parameter p;
        (void)ry_config_parameter(check->config, i, &p);
        if (isnan(p.number) && isnan(ry_keys_row(i)->usual)) {
            continue;
        }
        if (!(p.number >= p.low && p.number <= p.high)) {
            return ry_check_fail(check, i, "%g is out of range; allowed is %g to %g", p.number,
                                 p.low, p.high);
        }
    }
    return RY_OK;
}

static ry_status check_particle_values(const ry_check *check)
{
    const ry_key_row *diameter = ry_keys_row(RY_KEY_grains_diameter);
    const ry_key_row *density = ry_keys_row(RY_KEY_grains_density);
    for (int i = 0; i < check->config->n_particles; i++) {
        const ry_particle *p = &check->config->particles[i];
        if (!isfinite(p->position[0] + p->position[1] + p->velocity[0] + p->velocity[1] +
                      p->spin)) {
            return ry_check_fail_particle(check, i, "position, velocity and spin must be finite");
        }
        if (!(p->diameter >= diameter->low && p->diameter <= diameter->high) ||
            !(p->density >= density->low && p->density <= density->high)) {
            return ry_check_fail_particle(check, i,
                                          "diameter %g m or density %g kg/m^3 is out of "
                                          "range; allowed are %g to %g and %g to %g",
                                          p->diameter, p->density, diameter->low, diameter->high,
                                          density->low, density->high);
        }
    }
    return RY_OK;
}

static ry_status check_presence(const ry_check *check)
{
    const ry_config *config = check->config;
    if (!config->has_grains && config->n_particles == 0) {
        return ry_place_fail((ry_place){.name = config->path}, NULL, check->error,
                             "no grains; the scene needs 'grains:' (a bed) or 'particles:'");
    }
    if (config->has_grains && config->grains_columns < 1) {
        return ry_check_fail(check, RY_KEY_grains_columns, "a bed needs at least 1 column");
    }
    if (config->has_grains && config->grains_layers < 1) {
        return ry_check_fail(check, RY_KEY_grains_layers, "a bed needs at least 1 layer");
    }
    if ((long long)config->grains_columns * config->grains_layers > 100000000 &&
        config->has_grains) {
        return ry_check_fail(check, RY_KEY_grains_layers,
                             "columns x layers = %lld; allowed are at "
                             "most 1e8 grains",
                             (long long)config->grains_columns * config->grains_layers);
    }
    return RY_OK;
}

static ry_status check_steps(const ry_check *check)
{
    const ry_config *config = check->config;
    const double dt = config->time_step;
    if (fmax(config->time_end, config->time_settle) / dt > most_steps) {
        return ry_check_fail(check, RY_KEY_time_end, "%.3g steps of %g s; allowed are at most %g",
                             fmax(config->time_end, config->time_settle) / dt, dt, most_steps);
    }
    if (config->output_interval / dt > 1e9) {
        return ry_check_fail(check, RY_KEY_output_interval,
                             "%.3g steps of %g s between frames; "
                             "allowed are at most 1e9",
                             config->output_interval / dt, dt);
    }
    return RY_OK;
}

/* Fills in what is still derived. Explicit grains beyond the ends of a periodic x are wrapped. */
static void complete(ry_config *config)
{
    if (isnan(config->domain_length) && config->has_grains) {
        config->domain_length = config->grains_columns * config->grains_diameter;
    }
    const ry_derived derived = ry_config_derive(config);
    if (isnan(config->contact_restitution)) {
        config->contact_restitution = ry_restitution_from_damping(derived.zeta_pair);
    }
    if (isnan(config->fluid_roughness)) {
        config->fluid_roughness = 2.5 * derived.d;
    }
    if (config->fluid_model != RY_FLUID_NONE && !isnan(config->fluid_shear_stress)) {
        config->fluid_shields = derived.shields;
    } else if (isnan(config->fluid_shields)) {
        config->fluid_shields = 0.2;
    }
    config->output_interval = derived.steps_frame * config->time_step;
    for (int i = 0; i < config->n_particles && config->domain_periodic; i++) {
        double *x = &config->particles[i].position[0];
        const double length = config->domain_length;
        if (length > 0.0 && !(*x >= 0.0 && *x < length)) {
            *x -= length * floor(*x / length);
            *x = *x < length ? fmax(*x, 0.0) : 0.0;
        }
    }
}

static void add_inverse_mass(ry_check *check, double mass)
{
    const double inverse = 1.0 / mass;
    if (inverse > check->inverse[0]) {
        check->inverse[1] = check->inverse[0];
        check->inverse[0] = inverse;
    } else if (inverse > check->inverse[1]) {
        check->inverse[1] = inverse;
    }
}

/* Mass of a sphere with its added mass. */
static double wet_mass(const ry_config *config, double diameter, double density)
{
    const double added = config->fluid_model == RY_FLUID_NONE
                             ? 0.0
                             : config->fluid_added_mass * config->fluid_density;
    return (density + added) * (pi / 6.0) * diameter * diameter * diameter;
}

/* Sizes and the lightest grains of the scene. */
static void survey(ry_check *check)
{
    const ry_config *config = check->config;
    check->derived = ry_config_derive(config);
    check->d_min = INFINITY;
    if (config->has_grains) {
        check->d_min = config->grains_diameter * (1.0 - config->grains_spread);
        check->d_max = config->grains_diameter * (1.0 + config->grains_spread);
        add_inverse_mass(check, wet_mass(config, check->d_min, config->grains_density));
        add_inverse_mass(check, wet_mass(config, check->d_min, config->grains_density));
    }
    for (int i = 0; i < config->n_particles; i++) {
        const ry_particle *p = &config->particles[i];
        check->d_min = fmin(check->d_min, p->diameter);
        check->d_max = fmax(check->d_max, p->diameter);
        if (!p->fixed) {
            add_inverse_mass(check, wet_mass(config, p->diameter, p->density));
        }
    }
}

static ry_status check_domain(const ry_check *check)
{
    const ry_config *config = check->config;
    const double length = check->derived.length;
    if (config->domain_walls && config->domain_periodic) {
        return ry_check_fail(check, RY_KEY_domain_walls, "side walls need domain.periodic: false");
    }
    if (length == 0.0 && (config->domain_periodic || config->domain_walls ||
                          config->domain_floor == RY_FLOOR_ROUGH)) {
        return ry_check_fail(check, RY_KEY_domain_length,
                             "is needed by %s; give a length such as "
                             "'10 mm'",
                             config->domain_periodic ? "domain.periodic: true"
                             : config->domain_walls  ? "domain.walls: true"
                                                     : "domain.floor: rough");
    }
    if (config->has_grains && config->domain_floor == RY_FLOOR_NONE && config->domain_gravity > 0.0) {
        return ry_check_fail(check, RY_KEY_domain_floor, "none: a bed falls for ever; allowed are flat and rough, or none "
                                                         "with domain.gravity 0");
    }
    const double skin = isnan(config->numerics_skin) ? 0.3 : config->numerics_skin;
    const double least = 2.5 * (check->d_max + skin * check->derived.d);
    if (config->domain_periodic && length <= least && config->has_grains &&
        length == config->grains_columns * config->grains_diameter) { /* nobody has given one */
        return ry_check_fail(check, RY_KEY_grains_columns,
                             "%d make a periodic scene %g m long; more than 2.5 x (largest diameter + skin) = %g m is "
                             "needed, at least %.0f columns",
                             config->grains_columns, length, least, floor(least / config->grains_diameter) + 1.0);
    }
    if (config->domain_periodic && length <= least) {
        return ry_check_fail(check, RY_KEY_domain_length,
                             "%g m is too short for a periodic scene; "
                             "more than 2.5 x (largest diameter + skin) = %g m is needed",
                             length, least);
    }
    const double bed = config->grains_columns * config->grains_diameter;
    if (config->has_grains && length < bed * (1.0 - 1e-9)) {
        return ry_check_fail(check, RY_KEY_domain_length,
                             "%g m is too short for %d columns of %g "
                             "m; at least %g m is needed",
                             length, config->grains_columns, config->grains_diameter, bed);
    }
    const double largest = config->grains_diameter * (1.0 + config->grains_spread);
    if (config->has_grains && config->domain_walls && length < largest) {
        return ry_check_fail(check, RY_KEY_domain_length,
                             "%g m between side walls is too short for grains of up to %g m; at least that is needed",
                             length, largest);
    }
    return RY_OK;
}

static ry_status check_turbulence(const ry_check *check)
{
    const ry_config *const config = check->config;
    const int walks = config->fluid_turbulence == RY_TURBULENCE_WALK;
    if (config->fluid_model == RY_FLUID_NONE) { /* no key of the fluid counts */
        return RY_OK;
    }
    if (walks && config->fluid_model == RY_FLUID_STRESS) {
        return ry_check_fail(check, RY_KEY_fluid_turbulence,
                             "walk needs a flow with a profile; allowed is fluid.model: log or balance");
    }
    if (!walks && !isnan(config->fluid_eddy_time)) {
        return ry_check_fail(check, RY_KEY_fluid_eddy_time, "%g s has no use without fluid.turbulence: walk",
                             config->fluid_eddy_time);
    }
    return RY_OK;
}

static ry_status check_fluid(const ry_check *check)
{
    const ry_config *config = check->config;
    RY_TRY(check_turbulence(check));
    if (config->fluid_model == RY_FLUID_NONE) {
        return !config->contact_wet ? RY_OK
                                    : ry_check_fail(check, RY_KEY_contact_wet,
                                                    "true needs a fluid, whose viscosity takes from the "
                                                    "restitution; allowed is fluid.model: stress, log or balance "
                                                    "(still water: stress with fluid.shields: 0)");
    }
    if (!(config->fluid_density > 0.0)) {
        return ry_check_fail(check, RY_KEY_fluid_density,
                             "a fluid needs a density above 0; for "
                             "none set fluid.model: none");
    }
    if (!(check->derived.density > config->fluid_density)) {
        return ry_check_fail(check, RY_KEY_fluid_density,
                             "%g kg/m^3 is not below the density of "
                             "the grains, %g kg/m^3; they would float",
                             config->fluid_density, check->derived.density);
    }
    if (config->domain_gravity == 0.0 && isnan(config->fluid_shear_stress) && config->fluid_shields > 0.0) {
        return ry_check_fail(check, RY_KEY_fluid_shields,
                             "%g makes no stress, for there is no gravity; give domain.gravity, or "
                             "fluid.shear_stress, or 0 for a fluid at rest", config->fluid_shields);
    }
    if (check->derived.shields > ry_keys_row(RY_KEY_fluid_shields)->high) {
        return ry_check_fail(check, RY_KEY_fluid_shear_stress,
                             "makes a Shields number of %g; "
                             "allowed is at most %g",
                             check->derived.shields, ry_keys_row(RY_KEY_fluid_shields)->high);
    }
    return RY_OK;
}

ry_status ry_resolve_at(ry_config *config, const ry_place *places, ry_error *error)
{
    if (config->guard != RY_CONFIG_GUARD) {
        return ry_fail(error, RY_BAD_INPUT, "this config was not made by ry_config_default");
    }
    ry_check check = {.config = config, .places = places, .error = error};
    RY_TRY(check_ranges(&check));
    RY_TRY(check_particle_values(&check));
    RY_TRY(check_presence(&check));
    RY_TRY(check_steps(&check));
    complete(config);
    survey(&check);
    RY_TRY(check_domain(&check));
    RY_TRY(check_fluid(&check));
    RY_TRY(ry_check_stability(&check));
    return ry_check_overlap(&check);
}

ry_status ry_config_resolve(ry_config *config, ry_error *error)
{
    return ry_resolve_at(config, NULL, error);
}
