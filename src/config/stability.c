/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Time steps beyond what a law bears are refused before the run, with the limit. For the lightest
 * pair of grains let a = k dt^2 (1/m1 + 1/m2) and c = eta dt (1/m1 + 1/m2). The explicit
 * spring-dashpot step
 *
 *     v' = v - a x - c v,   x' = x + v'        is stable for   a + 2c < 4.
 *
 * In a bed the fastest mode is that of the triangular lattice, omega^2 = 6 k/m = 3 k (2/m), hence
 * 3a + 6c < 4. The authors' laws and `energy` bound themselves; their step must only resolve a
 * contact at all: a <= 10 for a pair, a <= 1.5 in a bed, beyond which beds were measured not to come to
 * rest (alpha_m below 8). */
#include "config/laws.h"
#include "config/resolve.h"

/* The dashpot is that of alpha_cn, no restitution was given. */
static int dashpot_rules(const ry_check *check)
{
    const double zeta = check->derived.zeta_impact;
    return ry_laws[check->config->contact_law].ratio && (isnan(zeta) || zeta == check->derived.zeta_pair);
}

/* Refuses with what makes dt/T smaller by `factor`. */
static ry_status refuse(const ry_check *check, const char *rule, double value, double limit,
                        double factor)
{
    const ry_config *config = check->config;
    const char *law = ry_laws[config->contact_law].word;
    const double alpha_m = config->contact_alpha_m / factor * 1.001;
    const int by_beta = config->contact_beta != 1.0;
    if (isnan(config->contact_stiffness) && alpha_m > ry_keys_row(RY_KEY_contact_alpha_m)->high) {
        return ry_check_fail(check, RY_KEY_contact_alpha_m,
                             "too few steps for a contact of law %s: %s = %.4g, the limit is %g; the lightest grain is "
                             "too light for a stiffness by alpha_m; give contact.stiffness, at most %.4g N/m with this time.step",
                             law, rule, value, limit, check->derived.stiffness * factor * factor * 0.999);
    }
    if (isnan(config->contact_stiffness)) {
        return ry_check_fail(check, RY_KEY_contact_alpha_m,
                             "too few steps for a contact of law %s: %s = %.4g, the limit is %g; "
                             "allowed is contact.alpha_m%s of at least %.4g%s",
                             law, rule, value, limit, by_beta ? " x contact.beta" : "",
                             by_beta ? alpha_m * config->contact_beta : alpha_m,
                             dashpot_rules(check) ? ", or less damping (contact.alpha_cn)" : "");
    }
    return ry_check_fail(
        check, RY_KEY_contact_stiffness,
        "too stiff for law %s: %s = %.4g, the limit is %g; allowed is at most %.4g "
        "N/m, or time.step of at most %.4g s",
        law, rule, value, limit, check->derived.stiffness * factor * factor * 0.999,
        config->time_step * factor * 0.999);
}

static ry_status check_linear(const ry_check *check, double a, double inverse)
{
    const double many = check->derived.is_bed ? 3.0 : 1.0;
    const double c = dashpot_rules(check) ? check->derived.damping * check->config->time_step * inverse
                                          : 2.0 * check->derived.zeta_impact * sqrt(a);
    const double value = many * (a + 2.0 * c);
    if (value < 4.0) {
        return RY_OK;
    }
    /* a grows with dt^2 and c with dt: the factor on dt at which the sum is 4. */
    const double factor = 4.0 / (many * (c + sqrt(c * c + 4.0 * a / many)));
    return refuse(check, check->derived.is_bed ? "3a + 6c" : "a + 2c", value, 4.0, factor);
}

/* Impacts of fujioka-1 at s = 1 need e^2 >= a/(1 + a), or there is no next step with the energy
 * wanted. */
static ry_status check_fujioka1(const ry_check *check, double a)
{
    const double e = check->config->contact_restitution, least = sqrt(a / (1.0 + a));
    if (e >= least) {
        return RY_OK;
    }
    return ry_check_fail(check, RY_KEY_contact_restitution,
                         "%.4g is beyond law fujioka-1 with this "
                         "step, which can't keep the energy of an impact; allowed is at least %.4g "
                         "(above sqrt(a/(1 + a))), or a %s",
                         e, least * 1.0002,
                         isnan(check->config->contact_stiffness) ? "larger contact.alpha_m"
                                                                 : "smaller contact.stiffness or time.step");
}

/* A Hertz dashpot c d^1/4 with c = sqrt(5) zeta sqrt(a) at an overlap of the mean diameter; grains that bear others
 * overlap by 1e-4 of it at least, where it is a tenth. Beds of 20 x 10 grains with alpha_m 20, 40 and 60 came to rest
 * with alpha_cn up to 4.5, 10 and 14, and broke down with 5, 12 and 17; this refuses them, for their lightest pair,
 * from 4.1, 8.3 and 12.4 on. */
static ry_status check_hertz(const ry_check *check, double a)
{
    const double many = check->derived.is_bed ? 3.0 : 1.0;
    const double value = many * 0.2 * sqrt(5.0 * a) * check->derived.zeta_impact;
    return value < 4.0 ? RY_OK
                       : refuse(check, check->derived.is_bed ? "6c at 1e-4 d" : "2c at 1e-4 d", value, 4.0, 4.0 / value);
}

static ry_status check_dashpot(const ry_check *check)
{
    return check->derived.zeta_impact < INFINITY || isnan(check->derived.zeta_impact)
               ? RY_OK
               : ry_check_fail(check, RY_KEY_contact_restitution,
                               "0 needs an infinite dashpot in law %s with contact.mapping: exact; give more than 0",
                               ry_laws[check->config->contact_law].word);
}

double ry_stability_limit(const ry_config *config, int is_bed)
{
    const ry_law_kind law = ry_laws[config->contact_law];
    if (law.ratio && !(law.hertz && is_bed)) {
        return INFINITY;
    }
    return law.hertz ? 1.0 : (is_bed ? 1.5 : 10.0);
}

static ry_status check_law(const ry_check *check)
{
    const ry_config *config = check->config;
    const double inverse = check->inverse[0] + check->inverse[1];
    const double dt = config->time_step, a = check->derived.stiffness * dt * dt * inverse;
    RY_TRY(check_dashpot(check));
    if (ry_is_linear_dashpot(config)) {
        return check_linear(check, a, inverse);
    }
    const double limit = ry_stability_limit(config, check->derived.is_bed);
    if (a > limit) {
        return refuse(check, "a = k dt^2 (1/m1 + 1/m2)", a, limit, sqrt(limit / a));
    }
    if (ry_laws[config->contact_law].hertz) {
        return check_hertz(check, a);
    }
    return config->contact_law == RY_LAW_FUJIOKA1 ? check_fujioka1(check, a) : RY_OK;
}

/* How far the lowest grains of the bed, or one explicit grain on the floor, are pressed in [m], and `part`: by which
 * factor 1/k must be smaller for that to be `limit`. Law `energy` softens k to k/(1 + 1.5 a) on lasting
 * contacts; the force of a Hertz spring is k L (overlap/L)^1.5. */
static double static_overlap(const ry_check *check, double limit, double *part)
{
    const ry_config *config = check->config;
    const ry_derived *q = &check->derived;
    const ry_law_kind law = ry_laws[config->contact_law];
    const double weight = (config->has_grains ? config->grains_layers : 1) * q->mass * q->buoyant_gravity;
    const double linear = weight / q->stiffness, dt = config->time_step;
    if (law.hertz) {
        const double overlap = q->d * pow(linear / q->d, 2.0 / 3.0);
        *part = pow(limit / overlap, 1.5);
        return overlap;
    }
    const double soft = law.parts
                            ? weight * 1.5 * dt * dt * (check->inverse[0] + check->inverse[1])
                            : 0.0;
    *part = (limit - soft) / linear;
    return linear + soft;
}

static ry_status check_load(const ry_check *check)
{
    const ry_config *config = check->config;
    /* A bed that falls into place presses twice as hard, and grains pass each other at 0.95 of the smaller diameter;
     * some of unequal ones bear several of the largest. */
    const double d = check->derived.d, least = (1.0 - config->grains_spread) / 0.7;
    const double limit = 0.3 * d * fmin(1.0, least * least);
    double part;
    if (!config->has_grains && config->domain_floor == RY_FLOOR_NONE) {
        return RY_OK;
    }
    const double overlap = static_overlap(check, limit, &part);
    if (!(overlap > limit)) {
        return RY_OK;
    }
    if (!config->has_grains) {
        const int key = isnan(config->contact_stiffness) ? RY_KEY_contact_alpha_m : RY_KEY_contact_stiffness;
        return ry_check_fail(check, key,
                             "too soft: a grain's own weight presses it %.2g diameters into the floor, the limit is %.2g; "
                             "allowed is a stiffness of at least %.4g N/m", overlap / d, limit / d,
                             check->derived.stiffness / fmax(part, 1e-300) * 1.001);
    }
    if (part > 0.0 && !isnan(config->contact_stiffness)) {
        return ry_check_fail(check, RY_KEY_contact_stiffness,
                             "the bed is too soft: its %d layers "
                             "press the lowest grains %.2g diameters into each other, the limit is "
                             "%.2g; allowed is at least %.4g N/m",
                             config->grains_layers, overlap / d, limit / d,
                             check->derived.stiffness / part * 1.001);
    }
    const double factor = ry_laws[config->contact_law].hertz ? sqrt(part) : sqrt(limit / overlap);
    return ry_check_fail(check, RY_KEY_time_step,
                         "the bed is too soft: its %d layers press the "
                         "lowest grains %.2g diameters into each other, the limit is %.2g; allowed "
                         "is time.step of at most %.4g s%s",
                         config->grains_layers, overlap / d, limit / d, config->time_step * factor * 0.999,
                         isnan(config->contact_stiffness) ? ", or a smaller contact.alpha_m or contact.beta" : "");
}

static ry_status check_motion(const ry_check *check)
{
    const ry_config *config = check->config;
    const double dt = config->time_step, g = config->domain_gravity;
    if (!(g * dt * dt < 0.1 * check->d_min)) {
        return ry_check_fail(check, RY_KEY_time_step,
                             "a grain falls %.2g diameters in its first step, "
                             "the limit is 0.1; allowed is at most %.4g s",
                             g * dt * dt / check->d_min, sqrt(0.1 * check->d_min / g) * 0.999);
    }
    for (int i = 0; i < config->n_particles; i++) {
        const double *v = config->particles[i].velocity;
        const double speed = hypot(v[0], v[1]);
        if (!(speed * dt < 0.5 * check->d_min)) {
            return ry_check_fail_particle(
                check, i,
                "moves %.2g times the smallest diameter in one "
                "step, the limit is 0.5; allowed is time.step of at most %.4g s",
                speed * dt / check->d_min, 0.5 * check->d_min / speed * 0.999);
        }
    }
    return RY_OK;
}

ry_status ry_check_stability(const ry_check *check)
{
    RY_TRY(check_motion(check));
    RY_TRY(check_law(check));
    return check_load(check);
}
