/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The fluid column by itself: what stage/flow.c, which knows the grains, asks of it. */
#ifndef RY_STAGE_COLUMN_H
#define RY_STAGE_COLUMN_H

#include "stage/flow.h"
#include "stage/slices.h"

/* Rows of flow->sums: solid volume; the force that the grains got, mean of the steps since the last advance; the force
 * at the moment, and its derivative by the fluid's velocity. */
enum { RY_SUM_VOLUME, RY_SUM_GOT, RY_SUM_FORCE, RY_SUM_SLOPE, RY_SUM_COUNT };

/* A row has room for a last run of slices beyond the column. */
RY_INLINE size_t ry_column_row_length(const ry_flow *f)
{
    return (size_t)f->nz + RY_SLICES;
}

RY_INLINE double *ry_column_sums(const ry_flow *f, int32_t block, int row)
{
    return f->sums + ((size_t)block * RY_SUM_COUNT + (size_t)row) * ry_column_row_length(f);
}

/* Between which two faces a height lies, and how far from the lower one. */
typedef struct ry_spot {
    int32_t cell;
    double part;
} ry_spot;

RY_INLINE ry_spot ry_column_spot(const ry_flow *f, double z)
{
    const double height = z * (1.0 / f->dz);
    const double inside = height > 0.0 ? (height < f->nz ? height : f->nz) : 0.0;
    const int32_t whole = (int32_t)inside;
    const int32_t cell = whole < f->nz ? whole : f->nz - 1;
    return (ry_spot){cell, inside - cell};
}

RY_INLINE double ry_column_volume(double r)
{
    const double d = 2.0 * r;
    return M_PI / 6.0 * d * d * d;
}

/* One advance of model balance under the bed shear stress tau, from the total sums [Pa]. */
void ry_column_balance(ry_flow *flow, ry_column *column, double tau);

/* u = u_star/kappa ln(30 z'/k_s) above the bed level that was found, 0 below z' = k_s/30. */
void ry_column_log(ry_flow *flow, ry_column *column, double tau);

/* Makes the tables for the grains at the faces from .. end-1; ry_column_faces: how many need nothing of the clear
 * flow that is not computed yet. */
void ry_column_refresh(ry_flow *flow, const ry_column *column, int32_t from, int32_t end);
int32_t ry_column_faces(const ry_flow *flow);

#endif
