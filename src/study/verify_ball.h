/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A sphere that bounces on a floor, as the simulator runs it: bounces counted, contacts recorded. */
#ifndef RY_STUDY_VERIFY_BALL_H
#define RY_STUDY_VERIFY_BALL_H

#include "study/verify_private.h"

enum { RY_BALL_BOUNCES = 16, RY_BALL_POINTS = 2048 };

typedef struct ry_ball {
    const ry_variant *variant;
    double a;      /* k dt^2/m; Hertz: coefficient in units of L */
    double dt;     /* [s] */
    double height; /* of the lowest point at the start [L] */
    double down;   /* speed towards the floor at the start [m/s] */
    int n;         /* spheres, side by side without touching */
} ry_ball;

typedef struct ry_bounce {
    double kept;    /* energy behind over energy before */
    double deepest; /* overlap [L] */
    int steps;      /* in which the contact force was evaluated */
} ry_bounce;

typedef struct ry_bounces {
    int n;
    ry_bounce bounce[RY_BALL_BOUNCES];
    char ended[400]; /* why there are fewer than asked for; "" if there are not */
    int n_points;    /* states in contact: (d, w) [L], and the bounce that they belong to */
    double d[RY_BALL_POINTS], w[RY_BALL_POINTS], of[RY_BALL_POINTS];
} ry_bounces;

/* The sphere of the paper's sections 5.2 and 5.3. Hertz: the coefficient that Table 2 tells. */
ry_ball ry_ball_of(int variant);

/* A resolved scene of the ball; free with ry_config_free. */
ry_status ry_ball_scene(const ry_ball *ball, ry_config *config, ry_error *error);

/* Follows the first `most` bounces. Flights of more than 2000 steps are shortened: flight is a
 * parabola to rounding in the simulator, so the ball is taken on by a whole number of steps and
 * simulated again from a few steps above the floor. */
ry_status ry_ball_follow(const ry_ball *ball, int most, ry_bounces *out, ry_error *error);

#endif
