/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * gather: each grain adds the impulses of its contacts. integrate: velocities, then positions.
 *
 * One step is   v' = v + (contacts + gravity + fluid) dt/m,   x' = x + shift + v' dt,
 * but a grain that no contact pushes drifts with the mean (v + v')/2: its flight under constant
 * acceleration is then exact, and so is its energy. A grain in contact must use v': with the mean, a
 * grain at rest would have to carry -g dt/2 for ever. Where springs begin to hold a grain, or cease to,
 * gather gives it the half of a kick by gravity that lies between the two. */
#ifndef RY_STAGE_MOTION_H
#define RY_STAGE_MOTION_H

#include "stage/blocks.h"
#include "store/pairs.h"
#include "store/state.h"

/* What a pair needs of a grain, on one cache line of its own: position, radius, speed of the surface by spin [m,
 * m, m, m/s]; velocity, im and tm [m/s, m/s, 1/kg, 1/kg]. Two halves: in each the first two are wanted as
 * differences, the others as sums. */
enum { RY_BODY_X, RY_BODY_Z, RY_BODY_R, RY_BODY_TURN, RY_BODY_VX, RY_BODY_VZ, RY_BODY_IM, RY_BODY_TM, RY_BODY };

/* What a thread has found out while it moved grains. */
typedef struct ry_extent {
    double furthest; /* the largest square of the way since the list was made, less limit2 [m^2] */
    double highest;  /* z of the highest grain [m] */
    ry_exact work;   /* of the fluid */
} ry_extent;

typedef struct ry_motion {
    int threads, periodic, moves, n_walls;
    double dt, length;
    double *im;        /* n + RY_MAX_WALLS: inverse mass with added mass; 0: immovable [1/kg] */
    double *tm;        /* n + RY_MAX_WALLS: im + r^2/I [1/kg] */
    double *spin_gain; /* r/I: angular velocity per tangential impulse [1/(kg m)] */
    double *gx, *gz;   /* velocity change of a step by gravity and fluid [m/s]; without `pushed` NULL and `weight`. With
                          `pushes_kept` of all grains; else as cx (ry_motion_push_at) */
    double *weight;    /* the part of gz that is gravity less buoyancy [m/s] */
    double *cx, *cz, *ct; /* impulses of all contacts of a grain; ct: angular, per radius [N s]. With `kept` of all
                             grains; else of the block that a thread has in hand (ry_motion_at) */
    double *sx, *sz;   /* shift/im of all contacts; NULL unless the law moves [kg m] */
    double (*body)[RY_BODY]; /* n + RY_MAX_WALLS, as of the end of the last step */
    double highest; /* z of the highest grain [m] */
    int32_t n_awake;       /* grains that move, or may: the first ones in storage; n unless others sleep */
    double highest_asleep; /* of the others; else -infinity [m] */
    int marks;         /* the law marks contacts that begin to endure, and cease to */
    int books;         /* the fluid's work is booked */
    int kept, pushed, pushes_kept; /* see cx, gx */
    ry_scale scale;    /* of the ledger */
    ry_extent *extent; /* of each thread */
} ry_motion;

/* moves, kept, pushed, pushes_kept, threads are given. `im`, `tm` and so on are filled by whoever knows the scene; then
 * ry_motion_settle makes the bodies. */
ry_status ry_motion_create(ry_motion *motion, int32_t n, ry_error *error);
void ry_motion_settle(ry_motion *motion, const ry_grains *grains);
void ry_motion_free(ry_motion *motion);

/* Where cx, cz, ct of grain `begin` are, with which a block begins that thread `chunk` has in hand. */
RY_INLINE int32_t ry_motion_at(const ry_motion *motion, int32_t begin, int chunk)
{
    return motion->kept ? begin : chunk * RY_BLOCK;
}

/* Likewise gx, gz. */
RY_INLINE int32_t ry_motion_push_at(const ry_motion *motion, int32_t begin, int chunk)
{
    return motion->pushes_kept ? begin : chunk * RY_BLOCK;
}

/* Of a block of grains. */
void ry_motion_gather(const ry_motion *motion, const ry_pairs *pairs, int32_t begin, int32_t end, ry_way way,
                      int chunk);

/* The impulse of grain k's listed contacts: a slot of ry_pairs. */
void ry_motion_listed(const ry_pairs *pairs, int32_t k, double *slot);

/* Of a block of grains. x0, z0: where the neighbour list was made; they wrap with x. */
void ry_motion_integrate(const ry_motion *motion, ry_grains *grains, double *x0, const double *z0, const float *limit2,
                         int32_t begin, int32_t end, int chunk);

/* Before and after the blocks of a step. Returns whether a grain has gone further than the root of its limit2 since the
 * list was made [m^2]. With `books` the work of the fluid is added to the ledger. */
void ry_motion_begin(ry_motion *motion);
int ry_motion_end(ry_motion *motion, ry_ledger *ledger);

#endif
