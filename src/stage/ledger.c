/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "stage/ledger.h"

/* What a block of touching pairs loses; laid out for the vector loop. */
typedef struct ry_losses {
    double dashpot[RY_CONTACT_BLOCK], friction[RY_CONTACT_BLOCK];
} ry_losses;

/* Dashpots: -J . mean velocity. Friction: the work of the whole tangential force, less what the spring
 * keeps of it: energy before (et) and after the drift that follows, at the velocity that now results. */
RY_CLONES static void lose(const ry_contact *c, const ry_motion *m, const ry_grains *g,
                           const ry_pairs *pairs, const int32_t *pair, int32_t n, ry_losses *out)
{
    const double *const x = g->x, *const z = g->z, *const vx = g->vx, *const vz = g->vz;
    const double *const spin = g->spin, *const r = g->radius;
    const double *const kick_x = m->kick_x, *const kick_z = m->kick_z, *const kick_spin = m->kick_spin;
    const double *const jn = pairs->jn, *const jt = pairs->jt, *const et = pairs->et, *const kt = pairs->kt;
    const double *const stored = pairs->slip;
    const int32_t *const owner = pairs->i, *const partner = pairs->j;
    const double length = c->length, half = c->half, dt = c->dt;
#pragma omp simd
    for (int32_t k = 0; k < n; k++) {
        const int32_t p = pair[k], i = owner[p], j = partner[p];
        const double dx = ry_contact_nearest(x[j] - x[i], length, half);
        const double dz = z[j] - z[i];
        const double distance = sqrt(dx * dx + dz * dz);
        const double nx = dx / distance, nz = dz / distance;
        const double lever = distance / (r[i] + r[j]);
        const double ux = vx[i] - vx[j], uz = vz[i] - vz[j];
        const double hx = 0.5 * (kick_x[i] - kick_x[j]), hz = 0.5 * (kick_z[i] - kick_z[j]);
        const double turn = (spin[i] * r[i] + spin[j] * r[j]) * lever;
        const double half_turn = 0.5 * (kick_spin[i] * r[i] + kick_spin[j] * r[j]) * lever;
        const double approach = (ux + hx) * nx + (uz + hz) * nz;
        const double mean = (ux + hx) * nz - (uz + hz) * nx + turn + half_turn;
        const double end = mean + hx * nz - hz * nx + half_turn;
        const double slip = stored[p] + end * dt;
        const double work = -jt[p] * mean;
        const double kept = 0.5 * kt[p] * slip * slip - et[p];
        const int slides = et[p] >= 0.0;
        out->dashpot[k] = -jn[p] * approach + (slides ? 0.0 : work);
        out->friction[k] = slides ? work - kept : 0.0;
    }
}

/* The few pairs with walls, whose partner stands where the wall is nearest. */
static void lose_at_wall(const ry_contact *c, const ry_motion *m, const ry_grains *g, const ry_pairs *pairs,
                         int32_t p, double *dashpot, double *friction)
{
    const int32_t i = pairs->i[p];
    const ry_gap gap = ry_contact_gap(c, g, pairs, p);
    const double nx = gap.dx / gap.distance, nz = gap.dz / gap.distance;
    const double lever = gap.distance;
    const double approach = (g->vx[i] + 0.5 * m->kick_x[i]) * nx + (g->vz[i] + 0.5 * m->kick_z[i]) * nz;
    const double start = g->vx[i] * nz - g->vz[i] * nx + g->spin[i] * lever;
    const double gain = m->kick_x[i] * nz - m->kick_z[i] * nx + m->kick_spin[i] * lever;
    const double work = -pairs->jt[p] * (start + 0.5 * gain);
    const double slip = pairs->slip[p] + (start + gain) * c->dt;
    const int slides = pairs->et[p] >= 0.0;
    *dashpot = -pairs->jn[p] * approach + (slides ? 0.0 : work);
    *friction = slides ? work - (0.5 * pairs->kt[p] * slip * slip - pairs->et[p]) : 0.0;
}

static void book_chunk(const ry_contact *c, const ry_motion *m, ry_state *state, const ry_pairs *pairs,
                       const int32_t *pair, int32_t n)
{
    ry_losses losses;
    for (int32_t first = 0; first < n; first += RY_CONTACT_BLOCK) {
        const int32_t count = n - first < RY_CONTACT_BLOCK ? n - first : RY_CONTACT_BLOCK;
        lose(c, m, &state->grains, pairs, pair + first, count, &losses);
        for (int32_t k = 0; k < count; k++) {
            const int32_t i = pairs->i[pair[first + k]];
            state->ledger.loss_dashpot[i] += losses.dashpot[k];
            state->ledger.loss_friction[i] += losses.friction[k];
        }
    }
}

static void book_walls(const ry_contact *c, const ry_motion *m, ry_state *state, const ry_pairs *pairs)
{
    for (int32_t k = 0; k < pairs->n_touching[pairs->n_chunks]; k++) {
        const int32_t p = pairs->touching[pairs->n_inner + k];
        double dashpot, friction;
        lose_at_wall(c, m, &state->grains, pairs, p, &dashpot, &friction);
        state->ledger.loss_dashpot[pairs->i[p]] += dashpot;
        state->ledger.loss_friction[pairs->i[p]] += friction;
    }
}

/* Velocity changes of this step, and the fluid's part of their work. */
static void kick_and_fluid(const ry_motion *m, const ry_grains *g, double *restrict fluid_work,
                           int32_t begin, int32_t end)
{
    for (int32_t k = begin; k < end; k++) {
        m->kick_x[k] = m->cx[k] * m->im[k] + m->gx[k];
        m->kick_z[k] = m->cz[k] * m->im[k] + m->gz[k];
        m->kick_spin[k] = m->ct[k] * m->spin_gain[k];
        const double mass = m->im[k] > 0.0 ? 1.0 / m->im[k] : 0.0;
        fluid_work[k] += mass * (m->gx[k] * (g->vx[k] + 0.5 * m->kick_x[k]) +
                                 (m->gz[k] - m->weight[k]) * (g->vz[k] + 0.5 * m->kick_z[k]));
    }
}

void ry_ledger_stage(const ry_contact *c, const ry_motion *m, ry_state *state, const ry_pairs *pairs)
{
    const int threads = c->threads;
    const int32_t n = state->grains.n;
#pragma omp parallel for num_threads(threads) schedule(static, 1) if (threads > 1)
    for (int t = 0; t < threads; t++) {
        kick_and_fluid(m, &state->grains, state->ledger.fluid_work, (int32_t)((int64_t)n * t / threads),
                       (int32_t)((int64_t)n * (t + 1) / threads));
    }
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1)
    for (int32_t k = 0; k < pairs->n_chunks; k++) {
        book_chunk(c, m, state, pairs, pairs->touching + pairs->chunk[k], pairs->n_touching[k]);
    }
    book_walls(c, m, state, pairs);
}
