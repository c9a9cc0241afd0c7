/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench_problems.h"

#include <stdio.h>
#include <stdlib.h>

#include "analysis/statistics.h"
#include "base/clock.h"
#include "base/memory.h"

/* Of all problems but the three spheres: grains of sand, with the stiffness that alpha_m = 20 gives at
 * a step of 20 us. The step alone changes along a curve. */
static const double pi = 3.14159265358979323846, diameter = 0.5e-3, density = 2650.0;
static const double period = 20.0 * 20e-6; /* of a grain on its spring [s] */

static double stiffness(void)
{
    const double w = 2.0 * pi / period;
    return density * pi / 6.0 * diameter * diameter * diameter * w * w;
}

/* --- running ------------------------------------------------------------------------------------ */

ry_config ry_problem_config(const ry_attempt *attempt, int has_grains)
{
    ry_config config = ry_config_default(has_grains);
    config.time_step = attempt->dt;
    config.contact_law = attempt->law;
    config.contact_mapping = attempt->law == RY_LAW_CUNDALL ? RY_MAPPING_EXACT : RY_MAPPING_USUAL;
    config.contact_stiffness = stiffness();
    config.output_fields = 0;
    config.output_interval = attempt->dt;
    return config;
}

static ry_status start(ry_attempt *attempt, ry_config *config, ry_sim **sim, ry_error *error)
{
    ry_error own = {0};
    *sim = NULL;
    if (ry_config_resolve(config, &own) != RY_OK) {
        snprintf(attempt->message, sizeof attempt->message, "%.199s", own.text);
        return own.status == RY_BAD_INPUT ? RY_OK : ry_fail(error, own.status, "%s", own.text);
    }
    *sim = ry_sim_create(config, 1, error);
    return *sim == NULL ? error->status : RY_OK;
}

ry_status ry_problem_run(ry_attempt *attempt, ry_config *config, long long steps, ry_sim **sim,
                         ry_error *error)
{
    enum { MOST_TRIES = 5 };
    static const double enough = 0.05; /* of a time, to be measured once only [s] */
    attempt->steps = steps;
    for (int k = 0; k < MOST_TRIES; k++) {
        RY_TRY(start(attempt, config, sim, error));
        if (*sim == NULL) {
            return RY_OK;
        }
        ry_error own = {0};
        const double begun = ry_clock();
        const ry_status status = ry_sim_step(*sim, steps, &own);
        const double seconds = ry_clock() - begun;
        if (status == RY_UNPHYSICAL) {
            snprintf(attempt->message, sizeof attempt->message, "%.199s", own.text);
            ry_sim_free(*sim);
            *sim = NULL;
            return RY_OK;
        }
        attempt->seconds = k == 0 ? seconds : fmin(attempt->seconds, seconds);
        if (status != RY_OK || k == MOST_TRIES - 1 || seconds > enough) {
            attempt->has_run = status == RY_OK;
            return status == RY_OK ? RY_OK : ry_fail(error, status, "%s", own.text);
        }
        ry_sim_free(*sim);
    }
    return RY_OK;
}

static ry_status make_particles(ry_config *config, int n, ry_error *error)
{
    config->particles = calloc((size_t)n, sizeof *config->particles);
    config->n_particles = config->particles == NULL ? 0 : n;
    return config->particles == NULL ? ry_no_memory(error, (size_t)n * sizeof *config->particles)
                                     : RY_OK;
}

/* --- two grains --------------------------------------------------------------------------------- */

enum { PAIRS = RY_PROBLEM_VALUES, TOGETHER = 4, LASTS = 8 };
static const double binary_e = 0.5;

/* The moment within a step at which pair k touches: evenly spread, in no order (golden section). */
static double phase(int k)
{
    const double x = 0.6180339887498949 * (k + 1);
    return x - floor(x);
}

/* Steps of LASTS half periods of a contact with this mass. */
static long long contact_steps(const ry_attempt *attempt, double mass_ratio)
{
    const double half = 0.5 * period * sqrt(mass_ratio);
    return (long long)ceil(LASTS * half / attempt->dt) + 4;
}

/* Pairs first .. first+TOGETHER-1: grains that a moving one hits; the overlap reaches about 1 % of the diameter. */
static ry_status collide(ry_attempt *attempt, int first, ry_error *error)
{
    ry_config config = ry_problem_config(attempt, 0);
    RY_TRY(make_particles(&config, 2 * TOGETHER, error));
    const double d = diameter, speed = 0.01 * d * 2.0 * pi / period * sqrt(2.0);
    for (int k = 0; k < TOGETHER; k++) {
        const double gap = speed * attempt->dt * (0.5 + phase(first + k)), z = 4.0 * d * k;
        config.particles[2 * k] = (ry_particle){
            .position = {0.0, z}, .velocity = {speed, 0.0}, .diameter = d, .density = density};
        config.particles[2 * k + 1] =
            (ry_particle){.position = {d + gap, z}, .diameter = d, .density = density};
    }
    config.contact_restitution = binary_e;
    config.contact_friction = 0.0;
    ry_sim *sim;
    const ry_status status =
        ry_problem_run(attempt, &config, contact_steps(attempt, 0.5), &sim, error);
    if (sim != NULL) {
        const ry_view v = ry_sim_view(sim);
        attempt->n = PAIRS;
        for (int k = 0; k < TOGETHER; k++) {
            attempt->value[first + k] = (v.vx[2 * k + 1] - v.vx[2 * k]) / speed;
        }
        ry_sim_free(sim);
    }
    ry_config_free(&config);
    return status;
}

/* In scenes of a few pairs: more grains would count as a bed, which bears smaller steps only. */
ry_status ry_problem_binary(ry_attempt *attempt, ry_error *error)
{
    double seconds = 0.0;
    for (int first = 0; first < PAIRS; first += TOGETHER) {
        RY_TRY(collide(attempt, first, error));
        if (!attempt->has_run) {
            return RY_OK;
        }
        seconds += attempt->seconds;
    }
    attempt->seconds = seconds;
    return RY_OK;
}

double ry_problem_binary_exact(int k)
{
    (void)k;
    return binary_e;
}

/* --- oblique impacts on a plane ------------------------------------------------------------------ */

enum { ANGLES = 4, PHASES = 8 };
static const double oblique_e = 0.7, oblique_mu = 0.3;

/* ANGLES x PHASES grains; tangent[a]: of the angle to the normal. */
static ry_status strike(ry_attempt *attempt, const double tangent[ANGLES],
                        double (*measure)(const ry_view *v, int k, double speed, double along),
                        ry_error *error)
{
    ry_config config = ry_problem_config(attempt, 0);
    RY_TRY(make_particles(&config, ANGLES * PHASES, error));
    const double d = diameter, speed = 0.01 * d * 2.0 * pi / period;
    for (int k = 0; k < ANGLES * PHASES; k++) {
        const double gap = speed * attempt->dt * (0.5 + phase(k));
        config.particles[k] = (ry_particle){.position = {30.0 * d * k, 0.5 * d + gap},
                                            .velocity = {speed * tangent[k / PHASES], -speed},
                                            .diameter = d,
                                            .density = density};
    }
    config.domain_floor = RY_FLOOR_FLAT;
    config.contact_restitution = oblique_e;
    config.contact_friction = oblique_mu;
    ry_sim *sim;
    const ry_status status =
        ry_problem_run(attempt, &config, contact_steps(attempt, 1.0), &sim, error);
    if (sim != NULL) {
        const ry_view v = ry_sim_view(sim);
        attempt->n = ANGLES * PHASES;
        for (int k = 0; k < attempt->n; k++) {
            attempt->value[k] = measure(&v, k, speed, speed * tangent[k / PHASES]);
        }
        ry_sim_free(sim);
    }
    ry_config_free(&config);
    return status;
}

/* Over mu (1 + e) v_n, the change that a plane gives to a grain that slides on it throughout. */
static double lost_along(const ry_view *v, int k, double speed, double along)
{
    return (along - v->vx[k]) / (oblique_mu * (1.0 + oblique_e) * speed);
}

static double energy_kept(const ry_view *v, int k, double speed, double along)
{
    const double turn = v->spin[k] * v->radius[k];
    return (v->vx[k] * v->vx[k] + v->vz[k] * v->vz[k] + 0.4 * turn * turn) /
           (speed * speed + along * along);
}

ry_status ry_problem_sliding(ry_attempt *attempt, ry_error *error)
{
    /* beyond 7/2 mu (1 + e) = 1.785 a sphere slides until it leaves */
    static const double tangent[ANGLES] = {2.2, 3.0, 4.5, 8.0};
    return strike(attempt, tangent, lost_along, error);
}

double ry_problem_sliding_exact(int k)
{
    (void)k;
    return 1.0;
}

ry_status ry_problem_sticking(ry_attempt *attempt, ry_error *error)
{
    static const double tangent[ANGLES] = {0.1, 0.3, 0.6, 1.0};
    return strike(attempt, tangent, energy_kept, error);
}

/* --- three spheres ------------------------------------------------------------------------------- */

static const double r0 = 0.02, paper_gravity = 9.8; /* Fujioka & Ushijima (2005), section 5.6 */

/* Stiffness follows the step here (alpha_m), as in the paper. */
ry_status ry_problem_three(ry_attempt *attempt, ry_error *error)
{
    ry_config config = ry_problem_config(attempt, 0);
    RY_TRY(make_particles(&config, 3, error));
    const double x[3] = {-r0, r0, 0.0}, z[3] = {r0, r0, r0 + sqrt(3.0) * r0};
    for (int k = 0; k < 3; k++) {
        config.particles[k] =
            (ry_particle){.position = {x[k], z[k]}, .diameter = 2.0 * r0, .density = density};
    }
    config.contact_stiffness = RY_DERIVED;
    config.contact_alpha_m = 20.0;
    config.contact_restitution = 0.7;
    config.contact_friction = 0.0;
    config.domain_floor = RY_FLOOR_FLAT;
    config.domain_gravity = paper_gravity;
    ry_sim *sim;
    const ry_status status =
        ry_problem_run(attempt, &config, llround(0.125 / attempt->dt), &sim, error);
    if (sim != NULL) {
        attempt->n = 1;
        attempt->value[0] = ry_sim_view(sim).vx[1] / sqrt(4.0 * paper_gravity * r0);
        ry_sim_free(sim);
    }
    ry_config_free(&config);
    return status;
}

/* d' of eqs. 28 and 29: they part at h = 2 r0 k with k^3 + 3 k = sqrt(3). */
double ry_problem_three_exact(int index)
{
    (void)index;
    const double k = cbrt(0.5 * (sqrt(3.0) + sqrt(7.0))) + cbrt(0.5 * (sqrt(3.0) - sqrt(7.0)));
    return sqrt((0.5 * sqrt(3.0) - k) * k * k / (1.0 + k * k));
}

/* --- beds ---------------------------------------------------------------------------------------- */

/* Mean height of the grains of a dry bed [d]. Equal grains keep their lattice, so that the height is a
 * matter of springs, not of which grain fell into which gap. */
ry_status ry_problem_settle(ry_attempt *attempt, ry_error *error)
{
    ry_config config = ry_problem_config(attempt, 1);
    config.grains_columns = 10;
    config.grains_layers = 6;
    config.grains_spread = 0.0;
    config.fluid_model = RY_FLUID_NONE;
    config.contact_alpha_cn = 0.1; /* as much as cundall bears in a bed at the larger steps */
    ry_sim *sim;
    const double end = attempt->quick ? 0.02 : 0.1;
    const ry_status status =
        ry_problem_run(attempt, &config, llround(end / attempt->dt), &sim, error);
    if (sim != NULL) {
        const ry_view v = ry_sim_view(sim);
        double sum = 0.0;
        int n = 0;
        for (int k = 0; k < v.n; k++) {
            sum += v.fixed[k] ? 0.0 : v.z[k];
            n += !v.fixed[k];
        }
        attempt->n = 1;
        attempt->value[0] = sum / n / diameter;
        ry_sim_free(sim);
    }
    ry_config_free(&config);
    return status;
}

/* Samples of q* while `sim` runs; the first `cut` seconds, while the bed gets going, are left out. */
static ry_status follow_flux(ry_attempt *attempt, ry_sim *sim, double end, double cut,
                             ry_error *error)
{
    static const double every = 2e-3; /* [s] */
    const long long stride = llround(every / attempt->dt);
    const int n = (int)(end / every), first = (int)(cut / every);
    double *const q = ry_array((size_t)n, sizeof *q);
    if (q == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *q);
    }
    ry_series_statistics flux = {0};
    ry_status status = RY_OK;
    attempt->steps = n * stride;
    for (int k = 0; k < n && status == RY_OK; k++) {
        const double begun = ry_clock();
        status = ry_sim_step(sim, stride, error);
        attempt->seconds += ry_clock() - begun;
        q[k] = ry_sim_sample(sim).q_star;
    }
    if (status == RY_OK) {
        status = ry_series_equilibrated(q + first, n - first, &flux, error);
    }
    attempt->has_run = status == RY_OK;
    attempt->n = 1;
    attempt->value[0] = flux.mean;
    attempt->bar = flux.standard_error;
    free(q);
    return status;
}

/* q* of a small bed that is sheared. */
ry_status ry_problem_flux(ry_attempt *attempt, ry_error *error)
{
    ry_config config = ry_problem_config(attempt, 1);
    config.grains_columns = 16;
    config.grains_layers = 6;
    config.contact_alpha_cn = 0.1;
    config.fluid_shields = 0.5;
    config.time_settle = 0.0;
    ry_sim *sim;
    RY_TRY(start(attempt, &config, &sim, error));
    if (sim == NULL) {
        return RY_OK;
    }
    ry_error own = {0};
    const double end = attempt->quick ? 0.2 : 5.0, cut = attempt->quick ? 0.05 : 0.5;
    const ry_status status = follow_flux(attempt, sim, end, cut, &own);
    ry_sim_free(sim);
    if (status == RY_UNPHYSICAL) {
        snprintf(attempt->message, sizeof attempt->message, "%.199s", own.text);
        return RY_OK;
    }
    return status == RY_OK ? RY_OK : ry_fail(error, status, "%s", own.text);
}

/* --- the list ------------------------------------------------------------------------------------ */

const ry_problem ry_problems[RY_PROBLEMS] = {
    {"binary", "two grains collide: restitution 0.5, no gravity, 32 moments within a step",
     "worst error of the restitution", 144e-6, 1.4142135623730951, 22, 5, 0, 0.0, ry_problem_binary,
     ry_problem_binary_exact, 1.0},
    {"sliding", "a grain strikes a plane at 66 to 83 degrees, friction 0.3: it slides throughout",
     "worst error of the friction impulse, over its exact value", 144e-6, 1.4142135623730951, 20, 5,
     0, 0.0, ry_problem_sliding, ry_problem_sliding_exact, 1.0},
    {"sticking", "a grain strikes a plane at 6 to 45 degrees, friction 0.3: it sticks in between",
     "worst error of the energy kept, against its own converged value", 144e-6, 1.4142135623730951,
     18, 5, 1, 8.0, ry_problem_sticking, NULL, 1.0},
    {"three-spheres", "a sphere drives two others apart (Fujioka and Ushijima 2005, 5.6)",
     "relative error of the final speed d'", 1e-3, 2.1544346900318838, 10, 5, 0, 0.0,
     ry_problem_three, ry_problem_three_exact, 0.271463},
    {"settling", "a dry bed of 10 x 6 equal grains settles",
     "error of the mean height [d], against its own converged value", 80e-6, 2.0, 6, 3, 1, 2.0,
     ry_problem_settle, NULL, 1.0},
    {"flux", "a bed of 16 x 6 grains is sheared at Shields number 0.5",
     "relative error of q*, against its own value at the smallest step", 80e-6, 2.0, 4, 2, 1, 2.0,
     ry_problem_flux, NULL, 0.0},
};
