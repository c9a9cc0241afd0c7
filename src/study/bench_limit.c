/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench_limit.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "law/bond.h"
#include "law/cundall.h"
#include "law/drag.h"
#include "law/energy.h"

/* A block of arrays lies in the first cache: BLOCK x FIELDS doubles are 30 kB. */
enum { BLOCK = 256, FIELDS = 15, PASSES = 400, TRIALS = 7 };

typedef struct block {
    _Alignas(RY_ALIGNMENT) double v[FIELDS][BLOCK];
} block;

typedef ry_push law_fn(const ry_bond q, const ry_touch t);
typedef void pass_fn(block *b);

/* Of a grain of 0.5 mm at 20 us, alpha_m = 20, restitution 0.5. */
#define MASS 1.7e-7
#define DT 2e-5
#define RADIUS 2.5e-4
static const ry_law_coef coef = {.k_dt2 = 42.8 * DT * DT, .zeta2 = 0.43, .e = 0.5, .friction = 0.5,
                                 .ratio_k = 0.385, .ratio_eta = 0.62};

/* ---- arithmetic ------------------------------------------------------------------------------ */

enum { DX, DZ, UX, UZ, TURN, SUM, IM, TM, SLIP, REST, AGE, PX, PZ, PT };

RY_INLINE void contacts_body(block *b, law_fn *law, const int ages)
{
    const ry_law_coef q = coef;
    const double per_dt = 1.0 / DT;
#pragma omp simd
    for (int k = 0; k < BLOCK; k++) {
        const double dx = b->v[DX][k], dz = b->v[DZ][k], ux = b->v[UX][k], uz = b->v[UZ][k];
        const double im = b->v[IM][k], tm = b->v[TM][k], sum = b->v[SUM][k];
        const double distance = sqrt(dx * dx + dz * dz);
        const ry_bond bond = ry_bond_make(&q, im, tm);
        const double per_all = 1.0 / (distance * im * tm * sum);
        const double inverse = im * tm * sum * per_all;
        const double nx = dx * inverse, nz = dz * inverse;
        const double lever = distance * distance * (im * tm * per_all);
        ry_touch t = {.d = sum - distance, .w = ux * nx + uz * nz, .crowd = 2.0, .split = 1.0};
        if (ages) {
            t.rest = b->v[REST][k];
            t.age = b->v[AGE][k];
        }
        const ry_push p = law(bond, t);
        const double normal = p.f * (per_dt * (distance * tm * sum * per_all));
        const double w = ux * nz - uz * nx + b->v[TURN][k] * lever;
        const ry_slide s = ry_tangential(bond, q.friction, p.f, w, b->v[SLIP][k] + w, p.rough);
        const double along = s.f * (per_dt * (distance * im * sum * per_all));
        b->v[PX][k] = normal * nx + along * nz;
        b->v[PZ][k] = normal * nz - along * nx;
        b->v[PT][k] = along * lever;
        b->v[SLIP][k] = s.slip;
        if (ages) {
            b->v[REST][k] = p.rest;
            b->v[AGE][k] = ry_min(t.age + 1.0, RY_AGE_MAX);
        }
    }
}

RY_CLONES static void contacts_cundall(block *b)
{
    contacts_body(b, ry_law_cundall, 0);
}

RY_CLONES static void contacts_energy(block *b)
{
    contacts_body(b, ry_law_energy, 1);
}

/* The first eight as of a grain: its motion, what acts on it, its inverse mass. */
enum { X, Z, VX, VZ, SPIN, CX, CZ, CT, INVERSE, GX, GZ, FLUID };

RY_CLONES static void grains_move(block *b)
{
#pragma omp simd
    for (int k = 0; k < BLOCK; k++) {
        const double im = b->v[INVERSE][k], cx = b->v[CX][k], cz = b->v[CZ][k];
        const double vx = b->v[VX][k], vz = b->v[VZ][k];
        const double ux = vx + cx * im + b->v[GX][k], uz = vz + cz * im + b->v[GZ][k];
        const int touched = (cx != 0.0) | (cz != 0.0);
        b->v[X][k] += (touched ? ux : 0.5 * (vx + ux)) * DT;
        b->v[Z][k] += (touched ? uz : 0.5 * (vz + uz)) * DT;
        b->v[VX][k] = ux;
        b->v[VZ][k] = uz;
        b->v[SPIN][k] += b->v[CT][k] * im;
    }
}

RY_CLONES static void grains_feel(block *b)
{
#pragma omp simd
    for (int k = 0; k < BLOCK; k++) {
        const double rx = b->v[FLUID][k] - b->v[VX][k], vz = b->v[VZ][k];
        const double rate = 1e-4 * ry_drag_dallavalle(sqrt(rx * rx + vz * vz), 0.22, 0.4);
        const double part = rate * DT * b->v[INVERSE][k], share = 1.0 / (1.0 + part);
        b->v[GX][k] = part * rx * share;
        b->v[GZ][k] = (1e-4 - part * vz) * share;
    }
}

typedef struct job {
    pass_fn *pass;
    int contacts;
} job;

/* Two grains that touch: overlap 1e-4 of a diameter, hardly any motion. */
static void fill(block *b, int contacts)
{
    for (int k = 0; k < BLOCK; k++) {
        const double turn = 0.1 * k;
        for (int f = 0; f < FIELDS; f++) {
            b->v[f][k] = 1e-9 * (f + 1);
        }
        if (contacts) {
            b->v[SUM][k] = 2.0 * RADIUS;
            b->v[DX][k] = 1.9998 * RADIUS * cos(turn);
            b->v[DZ][k] = 1.9998 * RADIUS * sin(turn);
            b->v[IM][k] = 2.0 / MASS;
            b->v[TM][k] = 7.0 / MASS;
            b->v[AGE][k] = 10.0;
        } else {
            b->v[INVERSE][k] = 1.0 / MASS;
        }
    }
}

static void run_job(void *context, int32_t begin, int32_t end, int thread)
{
    const job *const j = context;
    _Alignas(64) block b;
    (void)begin, (void)end, (void)thread;
    fill(&b, j->contacts);
    for (int pass = 0; pass < PASSES; pass++) {
        j->pass(&b);
    }
}

/* Seconds per element of a block. */
static double time_pass(pass_fn *pass, int contacts, int threads)
{
    job j = {pass, contacts};
    double best = INFINITY;
    for (int trial = 0; trial < TRIALS; trial++) {
        const double begun = ry_clock();
        ry_parallel(threads, threads, run_job, &j);
        best = fmin(best, ry_clock() - begun);
    }
    return best / ((double)threads * PASSES * BLOCK);
}

double ry_limit_contact(ry_law law, int threads)
{
    return time_pass(law == RY_LAW_ENERGY ? contacts_energy : contacts_cundall, 1, threads);
}

double ry_limit_grain(int fluid, int threads)
{
    return time_pass(grains_move, 0, threads) + (fluid ? time_pass(grains_feel, 0, threads) : 0.0);
}

/* ---- moving ---------------------------------------------------------------------------------- */

typedef struct stretch {
    double *a;
    int passes;
} stretch;

/* In place, as a step changes positions and springs: each number is read once and written once. */
RY_CLONES static void scale(double *a, int32_t begin, int32_t end)
{
#pragma omp simd
    for (int32_t k = begin; k < end; k++) {
        a[k] = 1.0 - a[k];
    }
}

static void run_stretch(void *context, int32_t begin, int32_t end, int thread)
{
    const stretch *const s = context;
    (void)thread;
    for (int pass = 0; pass < s->passes; pass++) {
        scale(s->a, begin, end);
    }
}

double ry_limit_move(size_t bytes, int threads)
{
    const size_t n = bytes / (2 * sizeof(double)) + 1;
    stretch s = {.a = ry_array(n, sizeof(double)), .passes = (int)(1e6 / (double)n) + 1};
    double best = INFINITY;
    if (s.a == NULL || n > INT32_MAX) {
        free(s.a);
        return 0.0; /* no limit from here */
    }
    for (int trial = 0; trial < TRIALS; trial++) {
        const double begun = ry_clock();
        ry_parallel(threads, (int32_t)n, run_stretch, &s);
        best = fmin(best, ry_clock() - begun);
    }
    free(s.a);
    return best / (2.0 * sizeof(double) * (double)n * s.passes);
}

double ry_limit_bytes(ry_law law, double contacts_per_grain)
{
    const double both = 2.0 * sizeof(double);
    const double grain = 5.0 * both + sizeof(double);
    const double memory = both + (law == RY_LAW_ENERGY ? both + 2.0 : 0.0);
    return grain + contacts_per_grain * (2.0 * sizeof(int32_t) + memory);
}
