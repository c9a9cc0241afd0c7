/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What follows from a config: the constants of Harada et al. (eqs. 4 and 5), the fluid's scales,
 * the numbers of steps. Letters as in their paper: alpha_m, alpha_cn, beta, k, eta, m. */
#include "config/keys.h"
#include "config/laws.h"

static const double pi = 3.14159265358979323846;

/* d, density and mass of the mean grain: of `grains`, or else of the explicit grains that can move
 * (of all, if all are fixed). */
static void mean_grain(const ry_config *config, ry_derived *out)
{
    out->is_bed = config->has_grains;
    out->d = config->grains_diameter;
    out->density = config->grains_density;
    if (!config->has_grains && config->n_particles > 0) {
        int movable = 0;
        for (int i = 0; i < config->n_particles; i++) {
            movable += !config->particles[i].fixed;
        }
        out->is_bed = movable > 8;
        double n = 0.0, diameters = 0.0, volumes = 0.0, masses = 0.0;
        for (int i = 0; i < config->n_particles; i++) {
            const ry_particle *grain = &config->particles[i];
            if (movable == 0 || !grain->fixed) {
                const double volume = grain->diameter * grain->diameter * grain->diameter;
                n += 1.0;
                diameters += grain->diameter;
                volumes += volume;
                masses += grain->density * volume;
            }
        }
        out->d = diameters / n;
        out->density = masses / volumes;
    }
    out->mass = out->density * (pi / 6.0) * out->d * out->d * out->d;
}

static double usual_damping(double e)
{
    if (e <= 0.0) {
        return 1.0;
    }
    const double loss = -log(e);
    return loss / sqrt(pi * pi + loss * loss);
}

/* Restitution of a spring and dashpot that may pull, released where the overlap ends. */
static double tension_restitution(double zeta)
{
    return zeta < 1.0 ? exp(-pi * zeta / sqrt(1.0 - zeta * zeta)) : 0.0;
}

/* What an impact really gives back. Only the laws with a dashpot miss the value asked for: where
 * alpha_cn rules, their damping ratio is that of eta for this partner; else `mapping` sets it. With
 * x = overlap^5/4 the equation of motion of Hertz is that of the linear spring and dashpot, so the same
 * holds for it, but one damping ratio for all pairs. */
static void derive_impact(const ry_config *config, double zeta_wall, ry_derived *out)
{
    const double follows = ry_restitution_from_damping(out->zeta_pair);
    const double e = isnan(config->contact_restitution) ? follows : config->contact_restitution;
    const ry_law_kind law = ry_laws[config->contact_law];
    const int tension = law.pulls;
    out->restitution = out->restitution_wall = e;
    if (!law.ratio) {
        return;
    }
    double pair = out->zeta_pair, wall = zeta_wall;
    if (e != follows) {
        const int exact = !tension && config->contact_mapping == RY_MAPPING_EXACT;
        out->zeta_impact = exact ? ry_damping_from_restitution(e) : usual_damping(e);
        pair = wall = out->zeta_impact;
    } else if (law.hertz) {
        wall = out->zeta_impact = pair;
    }
    out->restitution = tension ? tension_restitution(pair) : ry_restitution_from_damping(pair);
    out->restitution_wall = tension ? tension_restitution(wall) : ry_restitution_from_damping(wall);
}

static void derive_contact(const ry_config *config, ry_derived *out)
{
    const double dt = config->time_step, beta = config->contact_beta;
    const double rate = 2.0 * pi / (config->contact_alpha_m * beta * dt);
    const double added = config->fluid_model == RY_FLUID_NONE
                             ? 0.0
                             : config->fluid_added_mass * config->fluid_density / out->density;
    const double wet = out->mass * (1.0 + added);
    out->stiffness =
        isnan(config->contact_stiffness) ? out->mass * rate * rate : config->contact_stiffness;
    out->damping = config->contact_alpha_cn * beta * 2.0 * sqrt(out->mass * out->stiffness);
    out->stiffness_t = out->stiffness / (2.0 * (1.0 + config->contact_poisson));
    out->step_ratio = out->stiffness * dt * dt * 2.0 / wet;
    out->zeta_pair = config->contact_alpha_cn * beta * sqrt(2.0 / (1.0 + added));
    derive_impact(config, config->contact_alpha_cn * beta / sqrt(1.0 + added), out);
}

/* Without a fluid all of its scales are zero and the unit of flux is that of a dry flow. */
static void derive_fluid(const ry_config *config, ry_derived *out)
{
    const double g = config->domain_gravity;
    if (config->fluid_model == RY_FLUID_NONE || !(config->fluid_density > 0.0)) {
        out->buoyant_gravity = g;
        out->flux_unit = sqrt(g * out->d * out->d * out->d);
        return;
    }
    const double excess = out->density - config->fluid_density;
    const double scale = excess * g * out->d;
    out->buoyant_gravity = excess / out->density * g;
    if (isnan(config->fluid_shear_stress)) {
        out->shields = isnan(config->fluid_shields) ? 0.2 : config->fluid_shields;
        out->shear_stress = out->shields * scale;
    } else {
        out->shear_stress = config->fluid_shear_stress;
        out->shields = scale > 0.0 ? out->shear_stress / scale : 0.0;
    }
    const double s = out->density / config->fluid_density;
    out->friction_velocity = sqrt(fmax(out->shear_stress, 0.0) / config->fluid_density);
    out->flux_unit = s > 1.0 ? sqrt((s - 1.0) * g * out->d * out->d * out->d) : 0.0;
}

/* |log(divisor/50)| of a is less than that of b; exact, in integers. */
static int nearer_to_50(int a, int b)
{
    const long long above_a = a < 50 ? 50 : a, below_a = a < 50 ? a : 50;
    const long long above_b = b < 50 ? 50 : b, below_b = b < 50 ? b : 50;
    const long long left = above_a * below_b, right = above_b * below_a;
    return left < right || (left == right && a < b);
}

/* The divisor of n nearest to 50, but none below 20 where n is more: 2503 is a prime, and a sample in each step would
 * cost more than the step. */
static int series_steps(int n)
{
    const int least = n < 20 ? 1 : 20;
    int best = n;
    for (int i = 1; (long long)i * i <= n; i++) {
        if (n % i == 0) {
            best = i >= least && nearer_to_50(i, best) ? i : best;
            best = n / i >= least && nearer_to_50(n / i, best) ? n / i : best;
        }
    }
    return best;
}

static void derive_steps(const ry_config *config, ry_derived *out)
{
    const double dt = config->time_step;
    const double frame = round(config->output_interval / dt);
    out->steps_settle = llround(config->time_settle / dt);
    out->steps_end = llround(config->time_end / dt);
    out->steps_frame = (int)fmin(fmax(frame, 1.0), INT32_MAX);
    out->steps_series = series_steps(out->steps_frame);
}

ry_derived ry_config_derive(const ry_config *config)
{
    ry_derived out = {.zeta_impact = NAN};
    mean_grain(config, &out);
    derive_contact(config, &out);
    derive_fluid(config, &out);
    derive_steps(config, &out);
    out.length = isnan(config->domain_length) ? 0.0 : config->domain_length;
    if (isnan(config->domain_length) && config->has_grains) {
        out.length = config->grains_columns * config->grains_diameter;
    }
    return out;
}
