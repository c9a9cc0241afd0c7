/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa show`: a scene in words and numbers, before it is run. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/text.h"
#include "config/keys.h"
#include "config/laws.h"
#include "config/resolve.h"
#include "io/result.h"
#include "law/drag.h"
#include "scene/scene.h"
#include "sim/sim.h"
#include "stage/eddies.h"

typedef struct ry_writer {
    ry_write_fn *write;
    void *data;
} ry_writer;

#define say(to, ...) ry_text_say((to)->write, (to)->data, __VA_ARGS__)

static void say_parameters(const ry_writer *w, const ry_config *config)
{
    ry_parameter p;
    const char *section = "";
    say(w, "PARAMETERS\n");
    for (int k = 0; ry_config_parameter(config, k, &p); k++) {
        char value[64];
        if (p.type == 'c') {
            snprintf(value, sizeof value, "%s", p.word);
        } else if (p.type == 'f') {
            snprintf(value, sizeof value, "%s", p.number != 0.0 ? "true" : "false");
        } else if (isnan(p.number)) {
            snprintf(value, sizeof value, "-");
        } else {
            snprintf(value, sizeof value, "%.10g %s", p.number, p.type == 'r' && strcmp(p.unit, "1") ? p.unit : "");
        }
        if (strcmp(section, p.section) != 0) {
            say(w, "  %s\n", p.section);
            section = p.section;
        }
        const char *const idle = ry_keys_idle(config, k);
        say(w, "    %-16s %-22s %s%s%s\n", p.key, value, idle != NULL ? "(not used: " : "", idle != NULL ? idle : p.text,
            idle != NULL ? ")" : "");
    }
}

static void say_contact(const ry_writer *w, const ry_config *config, const ry_derived *q)
{
    const ry_law_coef law = ry_plan_law(config, q);
    const double dt = config->time_step;
    const double im = q->step_ratio / (2.0 * q->stiffness * dt * dt); /* 1/m of the mean grain, wet */
    const ry_bond pair = ry_bond_make(&law, 2.0 * im, 7.0 * im), wall = ry_bond_make(&law, im, 3.5 * im);
    const double weight = q->mass * im * q->buoyant_gravity * dt * dt; /* what the spring holds, as a stretch */
    say(w, "\nCONTACT of two mean grains, d = %.6g m, m = %.6g kg\n", q->d, q->mass);
    const ry_law_kind kind = ry_laws[config->contact_law];
    const int normal = kind.ratio || kind.parts, asked = !isnan(q->zeta_impact); /* for a restitution */
    const double c = law.zeta2 > 0.0 ? law.zeta2 * sqrt(q->step_ratio) : law.eta_dt * 2.0 * im;
    const char *const hertz = kind.hertz ? " (of a Hertz spring: at an overlap of d)" : "";
    say(w, "  stiffness k              %.8g N/m%s\n", q->stiffness, hertz);
    say(w, "  damping eta              %.8g N s/m%s\n", c / (2.0 * im * dt),
        normal ? hertz : " (of the tangential dashpot alone)");
    say(w, "  tangential stiffness k_t %.8g N/m\n", q->stiffness_t);
    say(w, "  a = k dt^2/m_r           %.8g", q->step_ratio);
    say(w, law.bounded > 0.0 ? " (bounded by the law to %.8g)\n" : "\n", pair.a);
    if (normal) {
        say(w, "  eta dt/m_r               %.8g", c);
        say(w, law.bounded > 0.0 ? " (bounded by the law to %.8g)\n" : "\n", pair.c);
        say(w, "  damping ratio zeta       %.8g (%s)\n", asked ? q->zeta_impact : q->zeta_pair,
            asked && q->zeta_impact != q->zeta_pair ? "by contact.mapping from the restitution asked for"
                                                    : "alpha_cn beta on the reduced mass");
    }
    say(w, "  restitution e            %.8g between two grains, %.8g at a wall or fixed grain", q->restitution,
        q->restitution_wall);
    const double e = config->contact_restitution;
    say(w, !isnan(e) && fabs(e - q->restitution) > 1e-9 ? "; %.8g was asked for\n" : "\n", e);
    if (config->domain_floor != RY_FLOOR_NONE && weight > 0.0) {
        say(w, "  static overlap           %.4g d on the floor, under the grain's own weight\n",
            pow(weight / wall.a, law.hertz > 0.0 ? 2.0 / 3.0 : 1.0) / q->d);
    }
}

/* ---- contacts in a viscous fluid ------------------------------------------------------------- */

/* Speed at which the mean grain falls in still water: drag = buoyant weight, by bisection. */
static double settling_velocity(const ry_config *config, const ry_derived *q)
{
    const double per_area = q->mass * q->buoyant_gravity / (0.125 * M_PI * config->fluid_density * q->d * q->d);
    const double viscous = config->fluid_viscosity / q->d, c = config->fluid_drag_coefficient;
    const double root_viscous = sqrt(24.0 * viscous);
    double low = 0.0, high = INFINITY;
    for (int k = 0; k < 200; k++) {
        const double v = isfinite(high) ? 0.5 * (low + high) : (low > 0.0 ? 2.0 * low : 1.0);
        const double drag = v * (config->fluid_drag == RY_DRAG_DALLAVALLE  ? ry_drag_dallavalle(v, root_viscous, c)
                                 : config->fluid_drag == RY_DRAG_SCHILLER ? ry_drag_schiller(v, viscous, c)
                                                                          : ry_drag_ferguson(v, viscous, c));
        if (drag < per_area) {
            low = v;
        } else {
            high = v;
        }
    }
    return high;
}

/* Restitution of two mean grains, or of one at a wall, that close with a Stokes number. */
static double wet_restitution(const ry_film *film, const ry_law_coef *law, double im, double stokes)
{
    const double a = law->k_dt2 * im;
    const double c = law->zeta2 > 0.0 ? law->zeta2 * sqrt(a) : law->eta_dt * im;
    const double own = ry_contact_wet(film, law, a, c, ry_wet_loss(stokes));
    if (!film->damps) {
        return own;
    }
    const double zeta = own / film->unit;
    return ry_wet_restitution(1.0, film->pulls ? ry_damping_usual_loss(zeta) : ry_damping_loss(zeta));
}

/* Stokes numbers and restitution over the speed of approach. */
static void say_wet(const ry_writer *w, const ry_config *config, const ry_derived *q)
{
    const ry_film film = ry_plan_film(config, q);
    const ry_law_coef law = ry_plan_law(config, q);
    const double dt = config->time_step, r = 0.5 * q->d;
    const double im = q->step_ratio / (2.0 * q->stiffness * dt * dt); /* with added mass */
    const double pair = ry_wet_stokes(film.per_mu, 2.0 / q->mass, 2.0 / r);
    const double wall = ry_wet_stokes(film.per_mu, 1.0 / q->mass, 1.0 / r);
    const double fall = settling_velocity(config, q);
    const double stokes[] = {10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 10000.0};
    say(w, "\nWET CONTACTS, St = m_r V/(6 pi mu r_r^2), e = e_dry exp(-35/St), 0 below St = 10\n");
    say(w, "  %-26s %-12s %-10s %-10s %-10s %s\n", "approach V", "[m/s]", "St, pair", "e", "St, wall", "e");
    for (int k = -2; k < 8; k++) {
        const double v = k == -2 ? fall : (k == -1 ? q->friction_velocity : stokes[k] / pair);
        say(w, "  %-26s %-12.4g %-10.4g %-10.4g %-10.4g %.4g\n",
            k == -2 ? "settling velocity" : (k == -1 ? "friction velocity u*" : ""), v, pair * v,
            wet_restitution(&film, &law, 2.0 * im, pair * v), wall * v,
            wet_restitution(&film, &law, im, wall * v));
    }
    if (film.damps) {
        say(w, "  a dashpot cannot give less than e = %.4g (pair), %.4g (wall) at this step\n",
            wet_restitution(&film, &law, 2.0 * im, 0.0), wet_restitution(&film, &law, im, 0.0));
    }
}

/* Largest time step: see config/stability.c. */
static void say_step(const ry_writer *w, const ry_config *config, const ry_derived *q)
{
    const double dt = config->time_step, a = q->step_ratio;
    const ry_law_coef law = ry_plan_law(config, q);
    const double c = law.zeta2 > 0.0 ? law.zeta2 * sqrt(a) : law.eta_dt * a / law.k_dt2;
    say(w, "\nTIME STEP %.6g s, %lld steps to the end, frames every %d, samples every %d\n", dt,
        q->steps_end, q->steps_frame, q->steps_series);
    const double period = 2.0 * M_PI * sqrt(q->mass / q->stiffness);
    say(w, "  period of a grain        %.6g s = %.4g steps\n", period, period / dt);
    if (ry_is_linear_dashpot(config)) {
        say(w, q->is_bed ? "  3 a + 6 c < 4 in a bed   %.4g\n" : "  a + 2 c < 4 for a pair   %.4g\n",
            (q->is_bed ? 3.0 : 1.0) * (a + 2.0 * c));
    } else if (isfinite(ry_stability_limit(config, q->is_bed))) {
        say(w, "  a = k dt^2/m_r           %.4g of the mean pair; of the lightest at most %g\n", a,
            ry_stability_limit(config, q->is_bed));
    }
}

static void say_fluid(const ry_writer *w, const ry_config *config, const ry_derived *q)
{
    if (config->fluid_model == RY_FLUID_NONE) {
        say(w, "\nFLUID none\n");
        return;
    }
    say(w, "\nFLUID\n  Shields number           %.6g\n  bed shear stress         %.6g Pa\n", q->shields, q->shear_stress);
    say(w, "  friction velocity        %.6g m/s\n", q->friction_velocity);
    say(w, "  grain Reynolds number    %.6g\n", q->friction_velocity * q->d / config->fluid_viscosity);
    const double mass = q->mass * (1.0 + config->fluid_added_mass * config->fluid_density / q->density);
    const double b = 3.0 * M_PI * config->fluid_viscosity * config->fluid_density * q->d * config->time_step / mass;
    say(w, "  drag over a step, b      %.4g at rest, %.4g where phi is 0.6 (a grain at rest loads others with\n"
           "                           1/(1 + b) of its weight; smaller with time.step)\n",
        b, b * pow(0.4, -config->fluid_hindrance));
    if (config->fluid_turbulence == RY_TURBULENCE_WALK) {
        const int given = !isnan(config->fluid_eddy_time);
        say(w, "  eddies                   random walk; each lasts %.4g s%s\n",
            given ? config->fluid_eddy_time : RY_EDDY_TURN * RY_FLOW_KAPPA * q->d / fmax(q->friction_velocity, 1e-300),
            given ? "" : " a diameter above the bed");
    }
    say(w, "  flux: q_b = q* x %.6g m^2/s (sphere volumes over a slab of width d)\n", q->flux_unit);
}

/* Bytes per grain of the arrays: state, motion, neighbour list, and 2.5 listed pairs; their slots and coefficients, but
 * in long beds; what is kept of the last good state, but of very long ones. */
static double memory_of(const ry_scene_size *size)
{
    const double grains = (double)(size->explicit_grains + size->bed + size->floor);
    const double slots = grains <= 20000.0 ? 2.5 * (32.0 + 48.0) : 0.0, kept = grains <= 200000.0 ? 80.0 : 0.0;
    return grains * (72.0 + 140.0 + 45.0 + 2.5 * 32.0 + slots + kept) + (double)size->nz * 400.0;
}

/* Bytes of a frame in the result file, profile included. */
static double frame_of(const ry_config *config, const ry_scene_size *size)
{
    const double grains = (double)(size->explicit_grains + size->bed + size->floor);
    const unsigned fields = config->output_fields;
    return grains * ((fields & RY_FIELD_POSITION ? 16.0 + (config->domain_periodic ? 4.0 * 2.0 : 0.0) : 0.0) +
                     (fields & RY_FIELD_VELOCITY ? 16.0 : 0.0) + (fields & RY_FIELD_SPIN ? 8.0 : 0.0)) +
           (fields & RY_FIELD_PROFILE ? 40.0 * size->nz : 0.0);
}

/* Bytes on their way to the file: rows being collected and rows being written, and the state that the last
 * checkpoint was written from. */
static double output_of(const ry_config *config, const ry_scene_size *size)
{
    const ry_derived q = ry_config_derive(config);
    const double grains = (double)(size->explicit_grains + size->bed + size->floor);
    const double frame = frame_of(config, size), all = frame * (1.0 + (double)q.steps_end / q.steps_frame);
    return 2.0 * fmin(all, frame + RY_RESULT_BYTES) + grains * (77.0 + 1.7 * 32.0);
}

static void say_table(const ry_writer *w, const ry_plan *plan)
{
    say(w, "\nSTEP TABLE\n  %-2s %-10s %-40s %-26s -> %s\n", "#", "stage", "kernel", "reads", "writes");
    for (int s = 0; s < plan->n_stages; s++) {
        const ry_stage *const row = &plan->stage[s];
        say(w, "  %-2d %-10s %-40s %-26s -> %s\n", s + 1, row->name, row->kernel, row->reads, row->writes);
    }
}

/* Expected run time: a few steps are run for half a second at the most. */
static ry_status say_cost(const ry_writer *w, const ry_config *config, const ry_scene_size *size, ry_error *error)
{
    const ry_derived q = ry_config_derive(config);
    ry_sim *const sim = ry_sim_create(config, 0, error);
    if (sim == NULL) {
        return error->status;
    }
    const double started = ry_clock();
    int64_t steps = 0;
    ry_status status = RY_OK;
    while (ry_clock() - started < 0.5 && steps < q.steps_end && status == RY_OK) {
        status = ry_sim_step(sim, 8, NULL);
        steps += 8;
    }
    const double per_step = (ry_clock() - started) / fmax((double)steps, 1.0);
    const int64_t n = size->explicit_grains + size->bed + size->floor;
    say(w, "\nSIZE AND COST\n  grains                   %lld explicit + %lld of the bed + %lld of the floor\n",
        (long long)size->explicit_grains, (long long)size->bed, (long long)size->floor);
    say(w, "  fluid column             %d cells of %.4g m", (int)size->nz, size->dz);
    say(w, size->dz > 0.17 * q.d ? ", %.3g diameters each: too high for finer ones; bed and flow are as coarse\n" : "\n",
        size->dz / q.d);
    say(w, "  memory                   about %.3g MiB, and up to %.3g MiB of output on its way to the file\n",
        memory_of(size) / 1048576.0, output_of(config, size) / 1048576.0);
    say(w, "  threads                  %d\n", sim->plan.threads);
    say(w, "  expected run time        about %.3g s (%.3g million grain-steps per second, measured now)\n",
        per_step * (double)q.steps_end, 1e-6 * (double)n / per_step);
    ry_sim_free(sim);
    return RY_OK;
}

ry_status ry_describe_scene(const ry_config *config, ry_write_fn *write, void *data, ry_error *error)
{
    const ry_writer w = {write, data};
    ry_error own = {0};
    const ry_derived q = ry_config_derive(config);
    const ry_scene_size size = ry_scene_measure(config);
    ry_plan plan;
    ry_plan_outline(&plan, config, config->has_grains && config->grains_spread > 0.0);
    say(&w, "%s%s%s\n", config->path, config->title[0] ? ": " : "", config->title);
    say_parameters(&w, config);
    say_contact(&w, config, &q);
    if (config->contact_wet) {
        say_wet(&w, config, &q);
    }
    say_step(&w, config, &q);
    say_fluid(&w, config, &q);
    say_table(&w, &plan);
    return say_cost(&w, config, &size, error != NULL ? error : &own);
}

ry_status ry_describe_file(const char *path, ry_write_fn *write, void *data, ry_error *error)
{
    return ry_result_describe(path, write, data, error);
}
