/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sums over the grains, for the series and profiles. Nothing here changes the state. */
#ifndef RY_STAGE_MEASURE_H
#define RY_STAGE_MEASURE_H

#include "stage/motion.h"
#include "stage/sets.h"
#include "store/state.h"

/* Running sums of profiles since ry_measure_clear; rows of nz. */
typedef struct ry_measure {
    int32_t n, nz;            /* grains, cells */
    int32_t at_once; /* blocks of grains whose sums are kept side by side */
    double dz, length, d; /* [m] */
    int threads;
    int64_t samples;
    double *phi;         /* solid fraction, all grains */
    double *moving;      /* solid fraction of the grains that can move */
    double *transport;   /* moving x velocity [m/s] */
    double *tau_grain;   /* [Pa] */
    double *u_fluid;     /* [m/s] */
    double *tau_fluid;   /* [Pa] */
    double *impulse;     /* of each grain's contacts along x since the last sample [N s] */
    double *middle;      /* height of each grain halfway since then [m] */
    int32_t window;      /* steps between samples, as planned */
    int32_t tallied;     /* steps since the last sample, as it came */
    double *still;       /* volumes of the fixed grains in the cells [m^3] */
    double *asleep;      /* and of the sleepers that are not fixed, as of `changes` of the sets [m^3] */
    int64_t changes;
    double *sums;        /* scratch */
} ry_measure;

ry_status ry_measure_create(ry_measure *measure, const ry_state *state, double length, double d,
                            int threads, int window, ry_error *error);
void ry_measure_free(ry_measure *measure);
/* Forgets what has been summed up. */
void ry_measure_clear(ry_measure *measure);

/* Adds one sample. Stresses of a cell are the means of those on the planes at its foot and top. The stress
 * of the grains on the plane at z is exact, not binned: with A_i(z) the part of grain i above z and w_i
 * its slice at z,
 *
 *     tau_g(z) = -1/(L d) sum_i [ A_i F_i + m_i u_i w_i ],
 *
 * F_i the sum of the grain's contact forces along x. Impacts are short: F_i is the mean of all steps
 * since the last sample (ry_measure_tally), taken where the grain was halfway. Momentum above z then
 * changes by nothing but tau_g and the fluid's force on the slices above (method of planes, Todd, Evans
 * & Daivis 1995, with each grain's mass spread over its volume). m_i includes the added mass.
 * tau_fluid: nz values at the cell centres; NULL: balance of the forces on the grains below tau_b. */
void ry_measure_add(ry_measure *measure, const ry_state *state, const ry_motion *motion, const ry_sets *sets,
                    const double *tau_fluid, double tau_bed);

/* The sums as numbers, in id order, to go on from them in another process. ry_measure_saved: how many numbers;
 * 0: nothing has been measured since ry_measure_clear. ry_measure_load: 0, or -1 if they aren't of such a
 * scene. */
int64_t ry_measure_saved(const ry_measure *measure);
void ry_measure_save(const ry_measure *measure, const int32_t *place, double *to);
int ry_measure_load(ry_measure *measure, const int32_t *place, const double *from, int64_t count);

/* Every step, after gather: adds the contacts' impulses up. */
void ry_measure_tally(const ry_measure *measure, const ry_motion *motion, int32_t begin, int32_t end, int chunk);

/* Before the blocks of a step are tallied. */
void ry_measure_begin(ry_measure *measure, const ry_state *state);

/* sum of V u over the grains that can move [m^4/s], and their kinetic and gravity energy [J]; of those awake. */
typedef struct ry_measure_sums {
    double transport, kinetic, gravity;
    int finite; /* 0: some position or velocity is not a number */
    double fastest; /* largest way of a grain in a step, in its own diameters */
    int32_t fastest_grain; /* storage index */
} ry_measure_sums;
ry_measure_sums ry_measure_grains(const ry_state *state, const ry_motion *motion, const ry_sets *sets);

/* Gravity energy of a grain [J]. */
RY_INLINE double ry_measure_gravity(const ry_grains *g, const ry_motion *m, int32_t k)
{
    return -m->weight[k] / (m->im[k] * m->dt) * g->z[k];
}

#endif
