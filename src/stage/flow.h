/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The fluid. sample: what it does to each grain, every step. advance: what the grains do to it, every
 * `advance` steps: the column's solid fraction, bed level, velocity and stress.
 *
 * Drag is relaxed implicitly together with gravity, v' = (v + b u + g)/(1 + b), b = rate dt/m, so that
 * it sets no limit to dt and the terminal velocity is exact; contacts act outside of it, unscaled. */
#ifndef RY_STAGE_FLOW_H
#define RY_STAGE_FLOW_H

#include "stage/motion.h"
#include "stage/sets.h"
#include "stage/slices.h"
#include "store/state.h"

/* The order of ry_fluid, ry_drag and ry_mixing in ryusa/config.h. */
typedef enum { RY_FLOW_NONE, RY_FLOW_STRESS, RY_FLOW_LOG, RY_FLOW_BALANCE } ry_flow_model;
typedef enum { RY_FLOW_DALLAVALLE, RY_FLOW_SCHILLER, RY_FLOW_FERGUSON } ry_flow_drag;
typedef enum { RY_FLOW_LI_SAWAMOTO, RY_FLOW_DURAN, RY_FLOW_DURAN_MOVING } ry_flow_mixing;

/* von Karman's constant; the solid fraction at which Li & Sawamoto's mixing length stops growing
 * (Maurin et al. 2015: 0.61). */
#define RY_FLOW_KAPPA 0.41
#define RY_FLOW_PHI_MAX 0.61

/* At a face: mean velocity, stress gradient and factor of the drag for a grain centred there [m/s, Pa/m, 1]; with
 * turbulence the local friction velocity, the root of the Reynolds stress over the density [m/s]. */
enum { RY_FACE_U, RY_FACE_GRADIENT, RY_FACE_HINDER, RY_FACE_STAR, RY_FACE };

/* A run of cells that a sleeper reaches, and its parts in them. */
typedef struct ry_imprint {
    double z; /* where it lay [m]; NAN: never */
    double part[RY_SLICES];
    int32_t first; /* cell */
} ry_imprint;

/* The sleepers, as the column sees them (stage/resting.h). */
typedef struct ry_resting {
    int64_t changes;   /* sets for which it was made; -1: none */
    double *volumes;   /* in the cells, as a row of sums [m^3] */
    double *force, *slope; /* n: what the fluid gives a sleeper, and its derivative by u [N, kg/s] */
    ry_imprint *imprint; /* n x runs, by id */
    int32_t runs;      /* that the largest grain may need */
} ry_resting;

typedef struct ry_flow {
    ry_flow_model model;
    ry_flow_drag drag;
    ry_flow_mixing mixing;
    int threads, advance;        /* steps between advances */
    int64_t step_start, step_boost; /* the fluid starts; its extra start stress ends */
    double tau, tau_start;       /* bed shear stress, and while it starts [Pa] */
    double density, viscosity;   /* [kg/m^3], kinematic [m^2/s] */
    double drag_coefficient, hindrance, lift, roughness;
    double gravity;              /* [m/s^2] */
    double level;                /* where the log profile begins; NAN: at the bed level [m] */
    double d, length, dt;        /* mean diameter = slab width; domain; step [m, m, s] */
    int32_t nz;                  /* cells of the column, and their height [m] */
    double dz;
    int walks;                   /* 1: grains go from eddy to eddy (stage/eddies.h) */
    double eddy_time;            /* how long one lasts; NAN: as the local shear says [s] */
    uint32_t seed;
    double *eddy_x, *eddy_z;     /* n: velocity of the eddy that each grain is in, over the local friction velocity */
    double *viscous;             /* nu/d of each grain [m/s]; drag dallavalle: the root of 24 of it [m^1/2/s^1/2] */

    /* What the grains see, at the nz + 1 faces of the cells: made from the column at each advance. Side by side,
     * because a grain looks at all of it at two faces; the rows are where it is made. */
    double (*face)[RY_FACE];
    double *u, *gradient, *hinder, *star;
    double *reynolds; /* nz: Reynolds stress over the density in the cells; turbulence only [m^2/s^2] */
    /* What an advance sums over the grains: rows of nz, one set per block of grains that are summed at once, then the
     * total. */
    double *sums;
    int32_t at_once;
    ry_resting resting;
    /* The cells valid .. nz-1, clear flow above the grains, are not computed before somebody looks at them: they
     * follow from valid_length, the mixing length below them, and tau_now, the stress [m, Pa]. */
    int32_t clear, valid, faces; /* clear: the first cell of it; faces: of the tables */
    double valid_length, tau_now;
    int level_is_old; /* 1: column->bed_level is that of an earlier phi, as nobody has asked for it */
    int32_t half;  /* cells in a radius, rounded up */
    double *part;  /* 2 half: parts of a mean grain in the cells around its centre [1] */
    double *mix;  /* nz: mixing length at the faces above the cells, as of the last advance [m] */
    int32_t lengths; /* how many of those are still known */
    double *work; /* 5 nz + 2 half + 1: scratch of the column solver */
    int32_t n_bins; /* of the exposure count, model stress */
    double *bin_top;
    int32_t *bin_grain;
} ry_flow;

ry_status ry_flow_create(ry_flow *flow, const ry_state *state, ry_error *error);
void ry_flow_free(ry_flow *flow);

/* The bed shear stress in force at a step [Pa]. */
double ry_flow_stress(const ry_flow *flow, int64_t step);

/* Computes what is not valid yet: before anybody but this stage looks at the column. */
void ry_flow_complete(ry_flow *flow, ry_column *column);

/* The bed level alone. */
void ry_flow_find_level(ry_flow *flow, ry_column *column);

/* Makes sure that grains up to this height find what they need; before sample and advance. */
void ry_flow_reach(ry_flow *flow, ry_column *column, double highest);

/* Fills motion->gx, gz of a block of grains that are awake. */
void ry_flow_sample(const ry_flow *flow, const ry_grains *grains, const ry_motion *motion, int32_t begin, int32_t end,
                    int chunk);

/* The same for those that sleep, the grains from motion->n_awake on; and flow->resting.force and slope. */
void ry_flow_sample_asleep(const ry_flow *flow, const ry_grains *grains, const ry_motion *motion);

/* The grains' part of an advance: phi, and what else the column wants to know of them. */
void ry_flow_look(ry_flow *flow, ry_state *state, ry_motion *motion, const ry_sets *sets);
void ry_flow_advance(ry_flow *flow, ry_state *state, ry_motion *motion, const ry_sets *sets);

/* Height at which the solid fraction, averaged over a diameter, falls to half of its largest [m]. work: nz numbers. */
double ry_flow_bed_level(const double *phi, int32_t nz, double dz, double d, double *work);

/* Fluid stress on the planes through the cell centres, by the closure of model balance [Pa]. */
void ry_flow_shear(const ry_flow *flow, const ry_column *column, double tau, double *out);

#endif
