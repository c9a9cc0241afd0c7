/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/ledger.h"

#include "stage/four.h"

/* What a block of pairs loses; laid out for the vector loop. */
typedef struct ry_losses {
    double dx[RY_CONTACT_BLOCK], dz[RY_CONTACT_BLOCK], turn[RY_CONTACT_BLOCK]; /* mean velocities: partner less
                                                                                   owner, and sum */
    double dashpot[RY_CONTACT_BLOCK], friction[RY_CONTACT_BLOCK];
} ry_losses;

/* The list goes on, or is filled up, beyond any n. */
RY_CLONES static void fetch_means(const ry_motion *m, const ry_pairs *pairs, int32_t at, int32_t n, ry_losses *out)
{
    const double (*const mean)[RY_MEAN] = (const double (*)[RY_MEAN])m->mean;
    const int32_t *const i = pairs->i + at, *const j = pairs->j + at;
    const ry_four flip = {-1.0, -1.0, 1.0, 1.0};
    for (int32_t k = 0; k < n; k += 4) {
        ry_four rows[4];
        for (int32_t q = 0; q < 4; q++) {
            rows[q] = ry_four_load(mean[j[k + q]]) + flip * ry_four_load(mean[i[k + q]]);
        }
        ry_four_turn(rows);
        ry_four_store(out->dx + k, rows[RY_MEAN_X]);
        ry_four_store(out->dz + k, rows[RY_MEAN_Z]);
        ry_four_store(out->turn + k, rows[RY_MEAN_TURN]);
    }
}

/* Dashpots: -J . mean velocity. Friction: the work of the whole tangential force, less what the spring
 * keeps of it: energy before (et) and after the drift that follows, at the velocity that now results,
 * twice the mean less that before; both at the time of the velocities (ry_contact_measure). Pairs at .. at+n-1;
 * what does not touch loses nothing. */
RY_CLONES static void lose(const ry_contact *c, const ry_pairs *pairs, int32_t at, int32_t n, ry_losses *out)
{
    const double *const t_nx = pairs->t_nx + at, *const t_nz = pairs->t_nz + at;
    const double *const lever = pairs->t_lever + at, *const run = pairs->t_run + at;
    const double *const stored = pairs->slip + at, *const jn = pairs->t_jn + at, *const en = pairs->t_en + at;
    const double *const jt = pairs->t_jt + at, *const et = pairs->t_et + at, *const kt = pairs->t_kt + at;
    const double dt = c->dt;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double nx = t_nx[k], nz = t_nz[k], ux = -out->dx[k], uz = -out->dz[k];
        const double approach = ux * nx + uz * nz;
        const double mean = ux * nz - uz * nx + out->turn[k] * lever[k];
        const double after = 2.0 * mean * dt - run[k], slip = stored[k] + after;
        const double work = -jt[k] * mean;
        const double kept = 0.5 * kt[k] * ry_max(slip * (slip - after), 0.0) - et[k];
        const int slides = et[k] >= 0.0;
        out->dashpot[k] = (en[k] < 0.0 ? -jn[k] * approach : 0.0) + (slides ? 0.0 : work);
        out->friction[k] = slides ? work - kept : 0.0;
    }
}

/* Loss of an impact: the work of its force less what its spring holds of it, before the step (en) and after
 * the drift that follows. Gravity towards an immovable partner, which the law balances over the drift of
 * a touching grain, w' dt, works over the mean: the difference belongs to the law. Zero (rounding) but in
 * the closing step for a pair alone. */
static double lose_in_impact(const ry_contact *c, const ry_motion *m, const ry_grains *g, const ry_pairs *pairs,
                             int32_t p)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double nx = pairs->t_nx[p], nz = pairs->t_nz[p], impulse = pairs->t_jn[p];
    const double dt = c->dt, ims = c->im[i] + c->im[j];
    const double *const mean_i = m->mean[i], *const mean_j = m->mean[j];
    const double mean = (mean_i[RY_MEAN_X] - mean_j[RY_MEAN_X]) * nx + (mean_i[RY_MEAN_Z] - mean_j[RY_MEAN_Z]) * nz;
    const double before = (g->vx[i] - g->vx[j]) * nx + (g->vz[i] - g->vz[j]) * nz;
    const double after = 2.0 * mean - before;
    const ry_gap gap = ry_contact_gap(c, g, pairs, p);
    const double overlap = g->radius[i] + g->radius[j] - gap.distance;
    const double stretch = ry_max(overlap - pairs->rest[p] + after * dt, 0.0);
    const double held = 0.5 * ry_contact_bond(c, i, j).a * stretch * stretch / (ims * dt * dt);
    const double side = (double)ry_contact_rests(c, pairs, i) - (double)ry_contact_rests(c, pairs, j);
    const double fall = impulse != 0.0 ? c->coef.g_dt2 * nz * side : 0.0;
    return -impulse * mean - (held - pairs->t_en[p]) - fall * (mean - after) / (ims * dt);
}

static void book_run(const ry_contact *c, const ry_motion *m, ry_state *state, const ry_pairs *pairs,
                     int32_t from, int32_t end)
{
    ry_losses losses;
    double *const dashpot = state->ledger.loss_dashpot, *const friction = state->ledger.loss_friction;
    double *const impact = state->ledger.loss_impact;
    const double *const en = pairs->t_en;
    for (int32_t at = from; at < end; at += RY_CONTACT_BLOCK) {
        const int32_t left = end - at;
        const int32_t count = left < RY_CONTACT_BLOCK ? left : RY_CONTACT_BLOCK;
        fetch_means(m, pairs, at, count, &losses);
        lose(c, pairs, at, count, &losses);
        int32_t impacts[RY_CONTACT_BLOCK], n = 0;
        for (int32_t k = 0; k < count; k++) {
            const int32_t i = pairs->i[at + k];
            dashpot[i] += losses.dashpot[k];
            friction[i] += losses.friction[k];
            impacts[n] = at + k;
            n += en[at + k] >= 0.0;
        }
        for (int32_t k = 0; k < n; k++) {
            impact[pairs->i[impacts[k]]] += lose_in_impact(c, m, &state->grains, pairs, impacts[k]);
        }
    }
}

/* Grains are done in blocks of this many, which stay in the first cache. */
enum { GRAINS = 256 };

/* Mean velocities of this step, and the fluid's part of their work. Grains begin .. begin+n-1. */
RY_CLONES static void mean_and_fluid(const ry_motion *m, const ry_grains *g, double *restrict fluid_work,
                                     int32_t begin, int32_t n)
{
    const double *const im = m->im + begin, *const cx = m->cx + begin, *const cz = m->cz + begin;
    const double *const ct = m->ct + begin, *const gx = m->gx + begin, *const gz = m->gz + begin;
    const double *const weight = m->weight + begin, *const gain = m->spin_gain + begin;
    const double *const vx = g->vx + begin, *const vz = g->vz + begin;
    const double *const spin = g->spin + begin, *const r = g->radius + begin;
    double mean[RY_MEAN][GRAINS] = {{0.0}};
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const double mass = im[k] > 0.0 ? 1.0 / im[k] : 0.0;
        const double x = vx[k] + 0.5 * (cx[k] * im[k] + gx[k]);
        const double z = vz[k] + 0.5 * (cz[k] * im[k] + gz[k]);
        mean[RY_MEAN_X][k] = x;
        mean[RY_MEAN_Z][k] = z;
        mean[RY_MEAN_TURN][k] = (spin[k] + 0.5 * ct[k] * gain[k]) * r[k];
        fluid_work[begin + k] += mass * (gx[k] * x + (gz[k] - weight[k]) * z);
    }
    for (int32_t k = 0; k < n; k += 4) {
        ry_four rows[4];
        for (int32_t q = 0; q < 4; q++) {
            rows[q] = ry_four_load(mean[q] + k);
        }
        ry_four_turn(rows);
        for (int32_t q = 0; q < 4 && k + q < n; q++) {
            ry_four_store(m->mean[begin + k + q], rows[q]);
        }
    }
}

typedef struct ry_ledger_task {
    const ry_contact *contact;
    const ry_motion *motion;
    ry_state *state;
    const ry_pairs *pairs;
} ry_ledger_task;

static void do_grains(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_ledger_task *const t = context;
    (void)thread;
    for (int32_t k = begin; k < end; k += GRAINS) {
        const int32_t n = end - k < GRAINS ? end - k : GRAINS;
        mean_and_fluid(t->motion, &t->state->grains, t->state->ledger.fluid_work, k, n);
    }
}

static void do_chunks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_ledger_task *const t = context;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        book_run(t->contact, t->motion, t->state, t->pairs, t->pairs->chunk[k], t->pairs->chunk[k + 1]);
    }
}

void ry_ledger_stage(const ry_contact *c, const ry_motion *m, ry_state *state, const ry_pairs *pairs)
{
    ry_ledger_task task = {c, m, state, pairs};
    ry_parallel(c->threads, state->grains.n, do_grains, &task);
    ry_parallel(c->threads, pairs->n_chunks, do_chunks, &task);
    book_run(c, m, state, pairs, pairs->n_inner, pairs->n);
}
