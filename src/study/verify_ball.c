/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/verify_ball.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static const double pi = 3.14159265358979323846;
static const double radius = 0.5 * RY_PAPER_DIAMETER;
/* A flight is shortened to its last STEPS_LEFT steps if it has more than SHORTEN_FROM. */
enum { SHORTEN_FROM = 2000, STEPS_LEFT = 3, MOST_STEPS = 100000 };

ry_ball ry_ball_of(int variant)
{
    return (ry_ball){.variant = &ry_variants[variant],
                     .a = variant == RY_V_T ? RY_FOUND_HERTZ : RY_FOUND_STEP_RATIO,
                     .dt = RY_PAPER_STEP,
                     .height = RY_PAPER_HEIGHT,
                     .n = 1};
}

/* m_r of a sphere and a wall is the sphere's mass, that of alpha_m: a = (2 pi/alpha_m)^2. */
ry_status ry_ball_scene(const ry_ball *ball, ry_config *config, ry_error *error)
{
    *config = ry_config_default(0);
    config->time_step = ball->dt;
    config->domain_floor = RY_FLOOR_FLAT;
    config->domain_gravity = RY_PAPER_GRAVITY;
    config->contact_law = ball->variant->law;
    config->contact_mapping = ball->variant->mapping;
    config->contact_alpha_m = 2.0 * pi / sqrt(ball->a);
    config->contact_restitution = RY_PAPER_E;
    config->contact_friction = 0.0;
    config->output_fields = 0;
    config->output_interval = ball->dt;
    config->particles = calloc((size_t)ball->n, sizeof *config->particles);
    if (config->particles == NULL) {
        ry_config_free(config);
        return ry_no_memory(error, (size_t)ball->n * sizeof *config->particles);
    }
    config->n_particles = ball->n;
    for (int i = 0; i < ball->n; i++) {
        config->particles[i] = (ry_particle){
            .position = {1.5 * i * RY_PAPER_DIAMETER, radius + ball->height * RY_PAPER_DIAMETER},
            .velocity = {0.0, -ball->down},
            .diameter = RY_PAPER_DIAMETER,
            .density = RY_PAPER_DENSITY};
    }
    const ry_status status = ry_config_resolve(config, error);
    if (status != RY_OK) {
        ry_config_free(config);
    }
    return status;
}

/* --- one simulation after another -------------------------------------------------------------- */

typedef struct ride {
    ry_ball ball; /* as the present simulation began */
    ry_config config;
    ry_sim *sim;
    double z, v; /* now: centre [m], velocity along z [m/s] */
} ride;

static void end_ride(ride *r)
{
    if (r->sim != NULL) {
        ry_sim_free(r->sim);
        ry_config_free(&r->config);
        r->sim = NULL;
    }
}

static ry_status begin_ride(ride *r, double z, double v, ry_error *error)
{
    end_ride(r);
    r->ball.height = (z - radius) / RY_PAPER_DIAMETER;
    r->ball.down = -v;
    RY_TRY(ry_ball_scene(&r->ball, &r->config, error));
    r->sim = ry_sim_create(&r->config, 1, error);
    if (r->sim == NULL) {
        ry_config_free(&r->config);
        return error->status;
    }
    r->z = z;
    r->v = v;
    return RY_OK;
}

static double energy(const ride *r)
{
    return 0.5 * r->v * r->v + RY_PAPER_GRAVITY * (r->z - radius);
}

/* z(n) = z + v n dt - g (n dt)^2/2, which is what the simulator's flight does. */
static ry_status shorten(ride *r, ry_error *error)
{
    const double g = RY_PAPER_GRAVITY, dt = r->ball.dt;
    const double fall = (r->v + sqrt(r->v * r->v + 2.0 * g * fmax(r->z - radius, 0.0))) / g;
    const double n = floor(fall / dt) - STEPS_LEFT;
    if (n < SHORTEN_FROM) {
        return RY_OK;
    }
    const double t = n * dt;
    return begin_ride(r, r->z + r->v * t - 0.5 * g * t * t, r->v - g * t, error);
}

static void record(ry_bounces *out, const ride *r, double d)
{
    if (out->n_points < RY_BALL_POINTS) {
        const int k = out->n_points++;
        out->d[k] = d;
        out->w[k] = -r->v * r->ball.dt / RY_PAPER_DIAMETER;
        out->of[k] = out->n;
    }
}

/* Steps until the next contact is over: RY_OK with *over = 1; 0: it never ends. */
static ry_status next_bounce(ride *r, ry_bounces *out, ry_bounce *bounce, int *over,
                             ry_error *error)
{
    *bounce = (ry_bounce){0};
    *over = 0;
    for (int k = 0; k < MOST_STEPS; k++) {
        RY_TRY(ry_sim_step(r->sim, 1, error));
        const ry_view view = ry_sim_view(r->sim);
        r->z = view.z[0];
        r->v = view.vz[0];
        const double d = (radius - r->z) / RY_PAPER_DIAMETER;
        if (d > 0.0) {
            record(out, r, d);
            bounce->steps++;
            bounce->deepest = fmax(bounce->deepest, d);
        } else if (bounce->steps > 0) {
            *over = 1;
            return RY_OK;
        }
    }
    return RY_OK;
}

static ry_status follow(ride *r, int most, ry_bounces *out, ry_error *error)
{
    while (out->n < most) {
        RY_TRY(shorten(r, error));
        const double before = energy(r);
        ry_bounce *const bounce = &out->bounce[out->n];
        int over;
        RY_TRY(next_bounce(r, out, bounce, &over, error));
        if (!over) {
            snprintf(out->ended, sizeof out->ended, "bounce %d: stays in contact", out->n + 1);
            return RY_OK;
        }
        bounce->kept = energy(r) / before;
        out->n++;
    }
    return RY_OK;
}

ry_status ry_ball_follow(const ry_ball *ball, int most, ry_bounces *out, ry_error *error)
{
    out->n = out->n_points = 0;
    out->ended[0] = '\0';
    ride r = {.ball = *ball};
    ry_error own = {0};
    ry_status status = begin_ride(&r, radius + ball->height * RY_PAPER_DIAMETER, -ball->down, &own);
    const int has_begun = status == RY_OK;
    if (has_begun) {
        status = follow(&r, most < RY_BALL_BOUNCES ? most : RY_BALL_BOUNCES, out, &own);
    }
    end_ride(&r);
    /* A law that throws the ball out faster than the simulator takes it is a result, no failure. */
    if (status == RY_UNPHYSICAL || (status == RY_BAD_INPUT && has_begun)) {
        snprintf(out->ended, sizeof out->ended, "bounce %d: %.370s", out->n + 1, own.text);
        return RY_OK;
    }
    return status == RY_OK ? RY_OK : ry_fail(error, status, "%s", own.text);
}
