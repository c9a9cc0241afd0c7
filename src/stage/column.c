/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/column.h"

#include <math.h>
#include <string.h>

#include "base/elementary.h"

/* The column is computed up to so many radii of a mean grain above the highest one, further when grains rise. */
enum { MARGIN = 2 };

/* The column's equations are solved anew until the stresses fit within CLOSE of the largest, TURNS times at most. */
enum { TURNS = 20 };
#define CLOSE 1e-3

/* Of u_star: what moves more slowly does not mix (duran-moving). */
#define STILL_PART 0.02

/* Of tau_b: a smaller Reynolds stress is none. */
#define LEAST_EDDIES 1e-6

/* ---- the fluid's velocity -------------------------------------------------------------------- */

/* Mixing length at the face above cell k, from l at the face below. Li & Sawamoto (1995, J. Coastal
 * Res.): l = kappa int (phi_max - phi)/phi_max dz. Duran et al. (2012, eq. 9):
 * dl/dz = kappa (1 - exp(-sqrt(u l/(7 nu)))), started with l = kappa z in the first cell. In a bed at rest u
 * is what its grains' trembling leaves; summed over a deep bed it makes an l of its own, which grows with the
 * depth. duran-moving takes u above `still` only: the fluid that stands still in the bed makes no eddies. */
static double longer(const ry_flow *f, const ry_column *c, double still, double l, int32_t k)
{
    if (f->mixing == RY_FLOW_LI_SAWAMOTO) {
        const double room = 1.0 - c->phi[k] / RY_FLOW_PHI_MAX;
        return room > 0.0 ? l + RY_FLOW_KAPPA * room * c->dz : l;
    }
    if (c->u[k] <= still) {
        return l; /* what follows, in short: e^0 is 1 */
    }
    const double u = c->u[k] > still ? c->u[k] - still : 0.0;
    const double seed = l > 0.0 ? l : RY_FLOW_KAPPA * c->dz;
    return l + RY_FLOW_KAPPA * c->dz * (1.0 - ry_exp(-sqrt(u * seed / (7.0 * f->viscosity))));
}

static double still_fluid(const ry_flow *f, double tau)
{
    return f->mixing == RY_FLOW_DURAN_MOVING ? STILL_PART * sqrt(tau / f->density) : 0.0;
}

/* At the faces above the cells 0 .. n-1, the first `known` of which are known. */
static void mixing_length(const ry_flow *f, const ry_column *c, double tau, int32_t known, int32_t n, double *out)
{
    const double still = still_fluid(f, tau);
    double l = known > 0 ? out[known - 1] : 0.0;
    for (int32_t k = known; k < n; k++) {
        l = longer(f, c, still, l, k);
        out[k] = l;
    }
}

/* How many of the n faces are still known since stress_gradient of the last advance: u is the same. */
static int32_t known_length(const ry_flow *f, double tau, int32_t n)
{
    const int32_t known = f->tau_now == tau ? f->lengths : 0;
    return known < n ? known : n;
}

/* 1 - phi at the face above cell k. */
static double open_part(const ry_column *c, int32_t k)
{
    const double phi = k + 1 < c->nz ? 0.5 * (c->phi[k] + c->phi[k + 1]) : c->phi[k];
    return 1.0 - (phi < 0.95 ? phi : 0.95);
}

/* Stress at the face above cell k for the velocity gradient s. */
static double closure(const ry_flow *f, double open, double l, double s)
{
    return f->density * open * (f->viscosity + l * l * fabs(s)) * s;
}

/* Each cell waits for the one before, so what it waits for stays in registers. */
static void solve_tridiagonal(int32_t n, const double *low, double *diagonal, const double *high, double *x)
{
    double pivot = diagonal[0], value = x[0];
    for (int32_t k = 1; k < n; k++) {
        const double w = low[k] / pivot;
        diagonal[k] = pivot = diagonal[k] - w * high[k - 1];
        x[k] = value = x[k] - w * value;
    }
    x[n - 1] = value = value / pivot;
    for (int32_t k = n - 2; k >= 0; k--) {
        x[k] = value = (x[k] - high[k] * value) / diagonal[k];
    }
}

/* Cells up to the highest that grains are in, or lately were. */
static int32_t layer_top(const ry_flow *f, const ry_column *c)
{
    const double *const slope = ry_column_sums(f, f->at_once, RY_SUM_SLOPE);
    int32_t top = c->nz;
    while (top > 2 && slope[top - 1] == 0.0 && c->phi[top - 1] < 1e-3) {
        top--;
    }
    return top;
}

/* At the face below cell k of the clear flow, with duran-moving: at least the length above a smooth wall half a cell
 * below, kappa z' (1 - exp(-z' u_star/(26 nu))) (van Driest 1956). When the flow sets in, nothing moves yet and l is 0:
 * above coarse grains, whose cells are much thicker than the viscous layer, that would be laminar water at enormous
 * speed. In a flow that has set in l is no shorter by itself. */
static double at_least_wall(const ry_flow *f, const ry_column *c, double tau, double l, int32_t k)
{
    if (f->mixing != RY_FLOW_DURAN_MOVING) {
        return l;
    }
    const double z = (k - f->clear + 0.5) * c->dz, speed = sqrt(tau / f->density);
    const double wall = RY_FLOW_KAPPA * z * (1.0 - ry_exp(-z * speed / (26.0 * f->viscosity)));
    return l > wall ? l : wall;
}

/* Above the grains nothing takes momentum out: the stress is tau_b and the fluid has long adapted to it
 * (its own spin-up, depth/u_star, would be waiting, not physics of the bed). The closure gives the
 * gradient: nu s + l^2 s^2 = tau/(rho (1-phi)). All follows from what is below, upwards, up to cell `end`. */
static void clear_flow(ry_flow *f, ry_column *c, int32_t end)
{
    const double still = still_fluid(f, f->tau_now);
    double l = f->valid_length;
    for (int32_t k = f->valid; k < end; k++) {
        const double most = at_least_wall(f, c, f->tau_now, l, k);
        const double l2 = most * most;
        const double kinematic = f->tau_now / (f->density * open_part(c, k - 1));
        const double s = 2.0 * kinematic /
                         (f->viscosity + sqrt(f->viscosity * f->viscosity + 4.0 * l2 * kinematic));
        c->u[k] = c->u[k - 1] + s * c->dz;
        c->taken[k] = c->gradient[k] = 0.0;
        l = longer(f, c, still, l, k);
    }
    f->valid = end;
    f->valid_length = l;
}

/* The balance of each cell, over the coming `advance` steps: low u'_(k-1) + diagonal u'_k + high u'_(k+1) = rhs. */
typedef struct ry_equations {
    int32_t n; /* cells */
    double *low, *diagonal, *high, *rhs;
} ry_equations;

/* d tau/ds at the face above cell k. */
static double stiffness(const ry_flow *f, const ry_column *c, double s, int32_t k)
{
    return f->density * open_part(c, k) * (f->viscosity + 2.0 * f->mix[k] * f->mix[k] * fabs(s));
}

/* The closure is linearised about the gradients of `near`: tau' = tau(s) + K (s' - s), K = rho (1-phi)(nu + 2 l^2|s|).
 * The grains will get force + slope (u' - u), where force is what they get now; and what they got in the last steps
 * beyond what was taken for it, or less, is settled now, so that in the sum the fluid loses just what they gain. */
static void lay_equations(const ry_flow *f, const ry_column *c, double tau_top, const double *near, ry_equations *e)
{
    const double dz = c->dz, dt = f->dt * f->advance;
    const double per_cell = 1.0 / (f->length * f->d * dz);
    const double *const got = ry_column_sums(f, f->at_once, RY_SUM_GOT);
    const double *const force = ry_column_sums(f, f->at_once, RY_SUM_FORCE);
    const double *const slope = ry_column_sums(f, f->at_once, RY_SUM_SLOPE);
    /* the face below the first cell is the floor, half a cell away: u = 0, viscous */
    double k_below = f->density * (1.0 - c->phi[0]) * f->viscosity / (0.5 * dz);
    double rest_below = 0.0;
    for (int32_t k = 0; k < e->n; k++) {
        double k_above = 0.0, rest_above = tau_top;
        if (k + 1 < e->n) {
            const double s = (near[k + 1] - near[k]) / dz, stiff = stiffness(f, c, s, k);
            k_above = stiff / dz;
            rest_above = closure(f, open_part(c, k), f->mix[k], s) - stiff * s;
        }
        const double inertia = f->density * (1.0 - (c->phi[k] < 0.95 ? c->phi[k] : 0.95)) * dz / dt;
        const double drag = slope[k] * per_cell * dz;
        const double given = (force[k] + got[k]) * per_cell - c->taken[k];
        e->low[k] = k > 0 ? -k_below : 0.0;
        e->high[k] = -k_above;
        e->diagonal[k] = inertia + drag + k_below + k_above;
        e->rhs[k] = (inertia + drag) * c->u[k] + rest_above - rest_below - given * dz;
        k_below = k_above;
        rest_below = rest_above;
    }
}

/* How far the stress that the equations had for u is from that of the closure, at the worst face, against the largest
 * stress: rho (1-phi) l^2 (|s|s - |s0|s0 - 2 |s0|(s - s0)), s0 the gradient of `near`. */
RY_CLONES static double misfit(const ry_flow *f, const ry_column *c, double tau_top, const double *near,
                               const double *u, int32_t n)
{
    const double *const phi = c->phi, *const length = f->mix;
    const double per_dz = 1.0 / c->dz, density = f->density, viscosity = f->viscosity;
    double worst = 0.0, largest = tau_top;
#pragma omp simd reduction(max : worst, largest)
    for (int32_t k = 0; k < n - 1; k++) {
        const double mean = 0.5 * (phi[k] + phi[k + 1]), open = 1.0 - (mean < 0.95 ? mean : 0.95);
        const double then = (near[k + 1] - near[k]) * per_dz, s = (u[k + 1] - u[k]) * per_dz;
        const double l2 = length[k] * length[k];
        const double bend = fabs(s) * s - fabs(then) * then - 2.0 * fabs(then) * (s - then);
        const double off = fabs(density * open * l2 * bend);
        const double tau = fabs(density * open * (viscosity + l2 * fabs(s)) * s);
        worst = off > worst ? off : worst;
        largest = tau > largest ? tau : largest;
    }
    return worst > 0.0 ? worst / largest : 0.0;
}

/* One implicit step of the balance over `advance` steps, by Newton's method: one turn in a flow that is under way. When
 * it sets in, and in a gas, which has little inertia, the gradients change by more than the closure is linear in. */
static void advance_balance(ry_flow *f, ry_column *c, double tau_top)
{
    const int32_t nz = layer_top(f, c);
    const double per_cell = 1.0 / (f->length * f->d * c->dz);
    const double *const force = ry_column_sums(f, f->at_once, RY_SUM_FORCE);
    const double *const slope = ry_column_sums(f, f->at_once, RY_SUM_SLOPE);
    ry_equations e = {.n = nz, .low = f->work, .diagonal = f->work + c->nz, .high = f->work + 2 * c->nz,
                      .rhs = f->work + 3 * c->nz};
    double *const near = f->work + 4 * c->nz;
    const int32_t known = f->mixing == RY_FLOW_LI_SAWAMOTO ? 0 : known_length(f, tau_top, nz); /* phi has changed */
    mixing_length(f, c, tau_top, known, nz, f->mix);
    memcpy(near, c->u, (size_t)nz * sizeof *near);
    double off = 1.0;
    for (int turn = 0; turn < TURNS && off > CLOSE; turn++) {
        lay_equations(f, c, tau_top, near, &e);
        solve_tridiagonal(nz, e.low, e.diagonal, e.high, e.rhs);
        off = misfit(f, c, tau_top, near, e.rhs, nz);
        memcpy(near, e.rhs, (size_t)nz * sizeof *near);
    }
    for (int32_t k = 0; k < nz; k++) {
        c->taken[k] = (force[k] + slope[k] * (near[k] - c->u[k])) * per_cell;
    }
    memcpy(c->u, near, (size_t)nz * sizeof *c->u);
    f->clear = f->valid = nz;
}

/* d tau/dz in the cells below the clear flow, from the stress at their faces. */
static void stress_gradient(ry_flow *f, ry_column *c, double tau_top)
{
    const int32_t nz = f->valid;
    double *const length = f->mix;
    mixing_length(f, c, tau_top, 0, nz, length);
    f->lengths = nz;
    double below = f->density * (1.0 - c->phi[0]) * f->viscosity * c->u[0] / (0.5 * c->dz);
    for (int32_t k = 0; k < nz; k++) {
        const double above = k + 1 < nz
            ? closure(f, open_part(c, k), length[k], (c->u[k + 1] - c->u[k]) / c->dz) : tau_top;
        c->gradient[k] = (above - below) / c->dz;
        below = above;
    }
    f->valid_length = length[nz - 1];
}

void ry_flow_shear(const ry_flow *f, const ry_column *c, double tau, double *out)
{
    double *const length = f->work;
    const int32_t known = known_length(f, tau, c->nz);
    memcpy(length, f->mix, (size_t)known * sizeof *length);
    mixing_length(f, c, tau, known, c->nz, length);
    for (int32_t k = f->clear > 1 ? f->clear : 1; k < c->nz; k++) {
        length[k - 1] = at_least_wall(f, c, tau, length[k - 1], k);
    }
    double below = f->density * (1.0 - c->phi[0]) * f->viscosity * c->u[0] / (0.5 * c->dz);
    for (int32_t k = 0; k < c->nz; k++) {
        const double above = k + 1 < c->nz
            ? closure(f, open_part(c, k), length[k], (c->u[k + 1] - c->u[k]) / c->dz) : tau;
        out[k] = 0.5 * (below + above);
        below = above;
    }
}

/* u = u_star/kappa ln(30 z'/k_s) above the bed level that was found, or the one given; 0 below z' = k_s/30. */
RY_CLONES static void impose_log(const ry_flow *f, ry_column *c, double tau)
{
    const double speed = sqrt(tau / f->density) / RY_FLOW_KAPPA, dz = c->dz;
    const double bed = isnan(f->level) ? c->bed_level : f->level;
    const double scale = 30.0 / f->roughness;
    double *restrict const u = c->u;
#pragma omp simd
    for (int32_t k = 0; k < c->nz; k++) {
        const double ratio = scale * ((k + 0.5) * dz - bed);
        const double above = ratio > 1.0 ? ratio : 1.0;
        u[k] = speed * ry_log(above);
    }
}

/* ---- advance --------------------------------------------------------------------------------- */

/* Means of a row of cells over a sphere of mean diameter centred at the faces from .. end-1. Below the floor there
 * is nothing; what sticks out at the top sees the topmost cell. */
RY_CLONES static void mean_over_grain(const ry_flow *f, const double *row, int32_t from, int32_t end,
                                      double *restrict padded, double *restrict out)
{
    const int32_t half = f->half, nz = f->nz;
    for (int32_t k = from - half; k < end + half; k++) {
        padded[k - from + half] = k < 0 ? 0.0 : row[k < nz ? k : nz - 1];
    }
    const double *const part = f->part;
    for (int32_t k = from; k < end; k++) {
        out[k] = 0.0;
    }
    for (int32_t m = 0; m < 2 * half; m++) {
        const double weight = part[m];
#pragma omp simd
        for (int32_t k = from; k < end; k++) {
            out[k] += weight * padded[k - from + m];
        }
    }
}

/* How much drag grows where the solid fraction is phi; in place. */
RY_CLONES static void hinder(double hindrance, int32_t from, int32_t end, double *restrict phi)
{
#pragma omp simd
    for (int32_t k = from; k < end; k++) {
        phi[k] = ry_pow(1.0 - (phi[k] < 0.75 ? phi[k] : 0.75), -hindrance);
    }
}

/* Kinematic Reynolds stress at the face above cell k, under the stress tau there [Pa]: what viscosity does not carry.
 * Where that is next to nothing, or the flow is reversed, there are no eddies. */
static double reynolds_at(const ry_flow *f, const ry_column *c, double tau, int32_t k)
{
    const double shear = (c->u[k + 1] - c->u[k]) / c->dz;
    const double stress = tau / (f->density * open_part(c, k)) - f->viscosity * shear;
    return stress > LEAST_EDDIES * f->tau_now / f->density ? stress : 0.0;
}

/* In the cells below `valid`. From the state of the column alone, so that it is the same after a resume: from the top,
 * where the stress is tau_now, downwards. The log profile is turbulent wherever it flows. */
static void find_reynolds(const ry_flow *f, const ry_column *c, double *out)
{
    double tau = f->tau_now, above = 0.0;
    for (int32_t k = f->valid - 1; k >= 0; k--) {
        tau -= c->gradient[k] * c->dz;
        const double below = k > 0 ? reynolds_at(f, c, tau, k - 1) : 0.0;
        out[k] = f->model == RY_FLOW_LOG ? (c->u[k] > 0.0 ? f->tau_now / f->density : 0.0)
                                         : (k + 1 < f->valid ? 0.5 * (below + above) : below);
        above = below;
    }
}

static void find_star(const ry_flow *f, const ry_column *c, int32_t from, int32_t end)
{
    find_reynolds(f, c, f->reynolds);
    mean_over_grain(f, f->reynolds, from, end, f->work, f->star);
    for (int32_t k = from; k < end; k++) {
        f->star[k] = sqrt(f->star[k]);
    }
}

/* The tables at the faces from .. end-1. */
void ry_column_refresh(ry_flow *f, const ry_column *c, int32_t from, int32_t end)
{
    mean_over_grain(f, c->u, from, end, f->work, f->u);
    if (f->model == RY_FLOW_BALANCE) {
        mean_over_grain(f, c->gradient, from, end, f->work, f->gradient);
    }
    if (f->hindrance > 0.0) {
        mean_over_grain(f, c->solid, from, end, f->work, f->hinder);
        hinder(f->hindrance, from, end, f->hinder);
    }
    if (f->walks) {
        find_star(f, c, from, end);
    }
    for (int32_t k = from; k < end; k++) {
        const double face[RY_FACE] = {f->u[k], f->gradient[k], f->hinder[k], f->walks ? f->star[k] : 0.0};
        memcpy(f->face[k], face, sizeof face);
    }
    f->faces = end;
}

/* Faces whose tables need nothing above cell `valid`; the Reynolds stress in a cell needs the next. */
int32_t ry_column_faces(const ry_flow *f)
{
    return f->valid < f->nz ? f->valid - f->half - (f->walks ? 1 : 0) : f->nz + 1;
}

/* ---- for the others ------------------------------------------------------------------------- */

void ry_column_log(ry_flow *f, ry_column *c, double tau)
{
    if (isnan(f->level)) {
        ry_flow_find_level(f, c);
    }
    impose_log(f, c, tau);
    f->tau_now = tau;
}

/* The clear flow, so that there are tables for grains up to that height [cells]. */
static void reach_up_to(ry_flow *f, ry_column *c, double height)
{
    const double cells = height + f->half + MARGIN * f->half;
    const int32_t end = cells < c->nz ? (int32_t)cells : c->nz;
    if (end > f->valid) {
        clear_flow(f, c, end);
    }
}

void ry_column_balance(ry_flow *f, ry_column *c, double tau)
{
    advance_balance(f, c, tau);
    stress_gradient(f, c, tau);
    f->tau_now = tau;
    reach_up_to(f, c, f->valid + 2.0);
}

void ry_flow_complete(ry_flow *f, ry_column *c)
{
    ry_flow_find_level(f, c);
    if (f->valid < f->nz) {
        clear_flow(f, c, f->nz);
    }
}

void ry_flow_reach(ry_flow *f, ry_column *c, double highest)
{
    if (highest + 2.0 * c->dz > f->faces * c->dz && f->faces <= f->nz) {
        reach_up_to(f, c, highest / c->dz + 3.0);
        ry_column_refresh(f, c, f->faces, ry_column_faces(f));
    }
}
