/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Blocks of listed pairs are fetched (fetch.c), put through the law's kernel and put away, each where it lies. Laws
 * that treat contacts in their first steps apart list those on the way, and do them when it is known who touches
 * whom. */
#include "stage/contact_private.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "stage/four.h"

/* ---- who touches ---------------------------------------------------------------------------- */

ry_gap ry_contact_gap(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    if (j >= g->n) {
        return ry_contact_wall_gap(c, c->wall[j - g->n], g->x[i], g->z[i]);
    }
    ry_gap gap;
    gap.dx = ry_nearest(g->x[j] - g->x[i], c->length, c->half);
    gap.dz = g->z[j] - g->z[i];
    gap.distance = sqrt(gap.dx * gap.dx + gap.dz * gap.dz);
    return gap;
}

/* Tangential velocity of the contact point of i against that of j. */
static double slip_velocity(const ry_grains *g, int32_t i, int32_t j, ry_gap gap)
{
    const double nx = gap.dx / gap.distance, nz = gap.dz / gap.distance;
    const double lever = gap.distance / (g->radius[i] + g->radius[j]);
    return (g->vx[i] - g->vx[j]) * nz - (g->vz[i] - g->vz[j]) * nx +
           (g->spin[i] * g->radius[i] + g->spin[j] * g->radius[j]) * lever;
}

ry_bond ry_contact_bond(const ry_contact *c, const ry_pairs *pairs, int32_t p)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    if (pairs->b_a != NULL && pairs->bonds_made) {
#define BOND_OF(name) .name = pairs->b_##name[p],
        return (ry_bond){RY_BOND_FIELDS(BOND_OF).e = c->coef.e};
#undef BOND_OF
    }
    return ry_bond_make(&c->coef, c->im[i] + c->im[j], c->tm_grain[i] + c->tm_grain[j]);
}

/* The contact is an impact, with its own ways; all else is an explicit spring. */
int ry_contact_in_impact(const ry_contact *c, const ry_pairs *pairs, int32_t p)
{
    return c->young != NULL && pairs->age[p] <= (int)RY_IMPACT_STEPS;
}

double ry_contact_held(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p, ry_gap gap)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double ux = (g->vx[i] - g->vx[j]) * c->dt, uz = (g->vz[i] - g->vz[j]) * c->dt;
    const double then = ry_contact_then(gap.dx, gap.dz, gap.distance, ux, uz, j < pairs->n_grains);
    const double a = ry_contact_bond(c, pairs, p).a, overlap = g->radius[i] + g->radius[j] - gap.distance;
    return ry_impact_holds(a, overlap, pairs->rest[p], pairs->slip[p], then) / ((c->im[i] + c->im[j]) * c->dt * c->dt);
}

double ry_contact_tangential(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs,
                                int32_t p, ry_gap gap, double stretch)
{
    const int32_t i = pairs->i[p], j = pairs->j[p];
    const double run = slip_velocity(g, i, j, gap) * c->dt, slip = pairs->slip[p] + run;
    const double energy = ry_spring_energy(stretch, slip, run);
    return ry_contact_in_impact(c, pairs, p) ? 0.0 : energy / ((c->tm_grain[i] + c->tm_grain[j]) * c->dt * c->dt);
}

/* ---- a block: put away ---------------------------------------------------------------------- */

RY_CLONES static void put_slots(const ry_near *near, double (*restrict slot)[RY_SLOT], uint8_t *restrict age)
{
    for (int32_t k = 0; k < near->n; k++) {
        age[k] = (uint8_t)(int)near->age[k];
    }
    for (int32_t k = 0; k < near->n; k += 4) {
        ry_four rows[4] = {ry_four_load(near->px + k), ry_four_load(near->pz + k), ry_four_load(near->pt + k),
                           ry_four_load(near->mark + k)};
        ry_four_turn(rows);
        for (int32_t m = 0; m < 4; m++) {
            ry_four_store(slot[k + m], rows[m]);
        }
    }
}

static void put_run(const ry_contact *c, ry_pairs *pairs, int32_t first, int chunk, const ry_near *near)
{
    put_slots(near, pairs->slot + ry_shelf_slot(&pairs->shelf[chunk], first), pairs->age + first);
    if (c->moves) {
        memcpy(pairs->sx + first, near->sx, (size_t)near->n * sizeof *near->sx);
        memcpy(pairs->sz + first, near->sz, (size_t)near->n * sizeof *near->sz);
    }
}

/* All but the age, by which others may be counting. */
static void put_list(const ry_contact *c, ry_pairs *pairs, int chunk, const ry_near *near)
{
    for (int32_t k = 0; k < near->n; k++) {
        const int32_t p = near->list[0][k];
        const double slot[RY_SLOT] = {near->px[k], near->pz[k], near->pt[k], near->mark[k]};
        memcpy(pairs->slot[ry_shelf_slot(&pairs->shelf[chunk], p)], slot, sizeof slot);
        pairs->slip[p] = near->slip[k];
        if (pairs->rest != NULL) {
            pairs->rest[p] = near->rest[k];
        }
        if (near->wet != NULL) {
            pairs->wet[p] = near->wet[k];
        }
        if (c->moves) {
            pairs->sx[p] = near->sx[k];
            pairs->sz[p] = near->sz[k];
        }
#define RY_TOUCH_PUT(name, unit, text) pairs->t_##name[p] = near->t_##name[k];
        if (c->features & RY_CONTACT_LEDGER) {
            RY_TOUCH_FIELDS(RY_TOUCH_PUT)
        }
#undef RY_TOUCH_PUT
    }
}

/* ---- all pairs ------------------------------------------------------------------------------ */

enum { EIGHT = 8 };

RY_INLINE uint64_t eight_bytes(const uint8_t *from)
{
    uint64_t word;
    memcpy(&word, from, sizeof word);
    return word;
}

RY_CLONES static void mark_openings(const ry_near *near, uint8_t *restrict opens)
{
    for (int32_t k = 0; k < near->n_padded; k++) {
        opens[k] = !(near->distance[k] < near->radii[k]) & (near->age[k] != 0.0);
    }
}

static void book_opening(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t p, int32_t k,
                         const ry_near *near)
{
    const ry_gap gap = {near->dx[k], near->dz[k], near->distance[k]};
    if (ry_contact_in_impact(c, pairs, p)) {
        const double energy = ry_contact_held(c, g, pairs, p, gap);
        ry_exact_add(&near->books->loss_impact, c->scale, &energy, 1);
    } else {
        const double stretch = ry_contact_bond(c, pairs, p).stretch;
        const double energy = ry_contact_tangential(c, g, pairs, p, gap, stretch);
        ry_exact_add(&near->books->loss_opening, c->scale, &energy, 1);
    }
}

/* A contact may hold energy when it has parted. */
static int holds_energy(const ry_contact *c)
{
    return (c->features & RY_CONTACT_FRICTION) != 0 || c->young != NULL;
}

/* Books what the contacts that have opened still hold. */
static void book_openings(const ry_contact *c, const ry_grains *g, const ry_pairs *pairs, int32_t first,
                          const ry_near *near)
{
    uint8_t opens[RY_CONTACT_BLOCK];
    mark_openings(near, opens);
    for (int32_t eight = 0; eight < near->n_padded; eight += EIGHT) {
        for (int32_t k = eight; eight_bytes(opens + eight) != 0 && k < eight + EIGHT; k++) {
            if (opens[k] && k < near->n) {
                book_opening(c, g, pairs, first + k, k, near);
            }
        }
    }
}

static ry_ledger *books_of(const ry_contact *c, int32_t chunk)
{
    return c->books != NULL ? c->books + chunk : NULL;
}

/* All that the last step has lost, and what this one does in impacts. */
static void book_losses(const ry_contact *c, const ry_near *near, int impacts)
{
    ry_ledger *const books = near->books;
    ry_exact_add(&books->loss_dashpot, c->scale, near->lost[RY_LOST_DASHPOT], near->n);
    ry_exact_add(&books->loss_friction, c->scale, near->lost[RY_LOST_FRICTION], near->n);
    if (impacts) {
        ry_exact_add(&books->loss_impact, c->scale, near->lost[RY_LOST_IMPACT], near->n);
    }
}

/* One of eight ages is 1 to RY_IMPACT_STEPS + 1, which is 5: in one word, whose bytes are looked at one by one. */
RY_INLINE int any_young(const uint8_t *age)
{
    const uint64_t ages = eight_bytes(age);
    const uint64_t ones = UINT64_C(0x0101010101010101);
    const uint64_t old = ((ages & 0x7f * ones) + 0x7a * ones) | ages; /* top bit of a byte: 6 and more */
    const uint64_t some = (ages | (ages >> 1) | (ages >> 2)) << 7;    /* top bit: 1 to 7, and others */
    return (~old & some & 0x80 * ones) != 0;
}

/* Appends the contacts of a block that are in their first steps, or were until now, to `young`; returns how many. */
static int32_t list_young(const uint8_t *age, int32_t first, int32_t n, int32_t *young)
{
    int32_t found = 0, k = 0;
    for (; k < n; k++) {
        if (k % EIGHT == 0 && k + EIGHT <= n && !any_young(age + k)) {
            k += EIGHT - 1;
            continue;
        }
        young[found] = first + k;
        found += (uint8_t)(age[k] - 1) < (int)RY_IMPACT_STEPS + 1;
    }
    return found;
}

/* Returns whether the block is worked on in place. */
static int fetch_block(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t first, int32_t n,
                       ry_near *near)
{
    const int32_t end = first + n;
    const int whole = n % RY_LANES == 0 || end == pairs->row[g->n] || end == pairs->n;
    if (whole) {
        ry_contact_fetch_run(pairs, first, n, near);
    } else {
        for (int32_t k = 0; k < n; k++) {
            near->list[0][k] = first + k;
        }
        ry_contact_fetch_list(pairs, n, near);
    }
    ry_contact_fetch_geometry(c, g, near);
    return whole;
}

/* What the law needs of these pairs, while their grains are fetched. */
static void ask_for_memory(const ry_pairs *pairs, int32_t first, int32_t end)
{
    enum { LINE = RY_ALIGNMENT / sizeof(double) };
    for (int32_t p = first; p < end; p += LINE) {
        __builtin_prefetch(pairs->slip + p, 1);
    }
    for (int32_t p = first; pairs->rest != NULL && p < end; p += LINE) {
        __builtin_prefetch(pairs->rest + p, 1);
    }
#define RY_TOUCH_ASK(name, unit, text) __builtin_prefetch(pairs->t_##name + p, 1);
    for (int32_t p = first; pairs->t_nx != NULL && p < end; p += LINE) {
        RY_TOUCH_FIELDS(RY_TOUCH_ASK)
    }
#undef RY_TOUCH_ASK
}

void ry_contact_push(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t first, int32_t end, int chunk)
{
    ry_near near;
    near.books = books_of(c, chunk);
    if (c->large) {
        ask_for_memory(pairs, first, end);
    }
    const int whole = fetch_block(c, g, pairs, first, end - first, &near);
    if (near.opens && (c->features & RY_CONTACT_LEDGER) && holds_energy(c)) {
        book_openings(c, g, pairs, first, &near);
    }
    if (c->film.on) {
        ry_contact_film(c, g, &near);
    }
    near.own = c->film.on ? near.wet : c->dry;
    c->kernel(c, &near);
    if (c->features & RY_CONTACT_LEDGER) {
        book_losses(c, &near, c->impacts);
    }
    if (whole) {
        put_run(c, pairs, first, chunk, &near);
    } else {
        put_list(c, pairs, chunk, &near);
        for (int32_t k = 0; k < near.n; k++) {
            pairs->age[first + k] = (uint8_t)near.age[k];
        }
    }
    if (near.young && c->young != NULL) {
        const int32_t from = chunk < pairs->n_chunks ? pairs->chunk[chunk] : pairs->n_inner;
        int32_t *const young = pairs->young + from + pairs->n_young[chunk];
        pairs->n_young[chunk] += list_young(pairs->age + first, first, end - first, young);
    }
}

/* ---- young contacts ------------------------------------------------------------------------- */

/* Contacts of a grain in this step, and those of them that are young. */
typedef struct ry_crowd {
    int all, young;
} ry_crowd;

RY_INLINE void count(ry_crowd *crowd, uint8_t age)
{
    crowd->all += age != 0;
    crowd->young += (uint8_t)(age - 1) < (int)RY_IMPACT_STEPS;
}

static ry_crowd crowd_of(const ry_contact *c, const ry_pairs *pairs, int32_t k)
{
    ry_crowd crowd = {0, 0};
    for (int32_t p = pairs->row[k]; p < pairs->row[k + 1]; p++) {
        count(&crowd, pairs->age[p]);
    }
    for (int32_t b = pairs->below_start[k]; b < pairs->below_start[k + 1]; b++) {
        count(&crowd, pairs->age[pairs->below[b]]);
    }
    for (int w = 0; w < c->n_walls; w++) {
        if (pairs->wall_slot[w][k] >= 0) {
            count(&crowd, pairs->age[pairs->wall_slot[w][k]]);
        }
    }
    return crowd;
}

int ry_contact_count(const ry_contact *c, const ry_pairs *pairs, int32_t k)
{
    return crowd_of(c, pairs, k).all + (c->frozen != NULL && k < pairs->n_grains ? c->frozen[k] : 0);
}

/* What a young contact is told of those of its grains that can move. Ages are set back to those before the step. */
RY_INLINE void crowds(const ry_contact *c, const ry_pairs *pairs, const int32_t *frozen, ry_near *near)
{
    for (int32_t k = 0; k < near->n_padded; k++) {
        const int32_t ends[2] = {near->i[k], near->j[k]};
        double crowd = INFINITY, busy = 0.0, share = 0.0, side = 0.0, firm = 0.0;
        for (int e = 0; e < 2; e++) {
            const double im = c->im[ends[e]];
            if (im > 0.0) {
                ry_crowd here = crowd_of(c, pairs, ends[e]);
                here.all += frozen != NULL ? frozen[ends[e]] : 0;
                crowd = ry_min(crowd, here.all);
                busy = ry_max(busy, here.all);
                share += here.young * im;
                side += here.all > 1 ? (e == 0 ? 1.0 : -1.0) : 0.0;
            } else {
                side += e == 0 ? 1.0 : -1.0;
                firm = 1.0;
            }
        }
        near->crowd[k] = crowd;
        near->busy[k] = busy;
        near->share[k] = share;
        near->bend[k] = near->j[k] < pairs->n_grains ? 1.0 / near->distance[k] : 0.0;
        near->side[k] = side;
        near->firm[k] = firm;
        near->age[k] -= 1.0;
    }
}

static void fetch_crowds(const ry_contact *c, const ry_pairs *pairs, ry_near *near)
{
    if (c->frozen != NULL) {
        crowds(c, pairs, c->frozen, near);
    } else {
        crowds(c, pairs, NULL, near);
    }
}

void ry_contact_push_young(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t first, int32_t end,
                           int chunk)
{
    const ry_entries listed = ry_pairs_young(pairs, first, end, chunk);
    const int32_t from = listed.begin, n = listed.end - listed.begin;
    const int32_t *const young = pairs->young + from;
    uint8_t *const young_age = pairs->young_age + from;
    ry_near near;
    near.books = books_of(c, chunk);
    for (int32_t at = 0; at < n; at += RY_CONTACT_BLOCK) {
        const int32_t count = n - at < RY_CONTACT_BLOCK ? n - at : RY_CONTACT_BLOCK;
        memcpy(near.list[0], young + at, (size_t)count * sizeof *young);
        ry_contact_fetch_list(pairs, count, &near);
        ry_contact_fetch_geometry(c, g, &near);
        fetch_crowds(c, pairs, &near);
        near.own = c->film.on ? near.wet : c->dry;
        c->young(c, &near);
        for (int32_t k = 0; k < count; k++) { /* put where it belongs when all have counted: put_ages */
            young_age[at + k] = (uint8_t)near.age[k];
        }
        put_list(c, pairs, chunk, &near);
        if (c->features & RY_CONTACT_LEDGER) {
            ry_exact_add(&near.books->loss_impact, c->scale, near.lost[RY_LOST_IMPACT], count);
        }
    }
}

static void put_ages(ry_pairs *pairs, int32_t from, int32_t n)
{
    for (int32_t k = from; k < from + n; k++) {
        pairs->age[pairs->young[k]] = pairs->young_age[k];
    }
}

/* ---- before and after ----------------------------------------------------------------------- */

/* What the threads have booked goes to the ledger: in any order, the sums are exact. */
static void join_books(const ry_contact *c, int32_t n_chunks)
{
    for (int32_t k = 0; c->books != NULL && k <= n_chunks; k++) {
#define RY_LEDGER_JOIN(name, text) ry_exact_join(&c->ledger->name, c->books[k].name);
        RY_LEDGER_TOTALS(RY_LEDGER_JOIN)
#undef RY_LEDGER_JOIN
        c->books[k] = (ry_ledger){0};
    }
}

/* Of all pairs, those that fill the list up too, which make no sense but do no harm. */
RY_CLONES static void make_bonds(const ry_contact *c, const ry_pairs *pairs)
{
    const ry_law_coef coef = c->coef;
    const double *const im = c->im, *const tm = c->tm_grain, most = c->most_around;
    const double (*const body)[RY_BODY] = c->body;
    const int32_t *const i = pairs->i, *const j = pairs->j, n = ry_pairs_fill(pairs->n);
#define BOND_TO(name) double *restrict const to_##name = pairs->b_##name;
    RY_BOND_FIELDS(BOND_TO)
#undef BOND_TO
#pragma omp simd
    for (int32_t p = 0; p < n; p++) {
        const double ri = body[i[p]][RY_BODY_R], rj = body[j[p]][RY_BODY_R];
        const double around = im[j[p]] == 0.0 ? ry_bond_around(ri, rj, most) : ry_bond_around(rj, ri, most);
        const int one_fixed = (im[i[p]] == 0.0) | (im[j[p]] == 0.0);
        ry_law_coef pair = coef;
        pair.bounded = (one_fixed & (coef.bounded > 0.0)) ? around : coef.bounded;
        const ry_bond bond = ry_bond_make(&pair, im[i[p]] + im[j[p]], tm[i[p]] + tm[j[p]]);
#define BOND_PUT(name) to_##name[p] = bond.name;
        RY_BOND_FIELDS(BOND_PUT)
#undef BOND_PUT
    }
}

void ry_contact_begin(const ry_contact *c, const ry_grains *g, ry_pairs *pairs)
{
    if (pairs->b_a != NULL && !pairs->bonds_made) {
        make_bonds(c, pairs);
        pairs->bonds_made = 1;
    }
    for (int32_t k = 0; k <= pairs->n_chunks; k++) {
        pairs->n_young[k] = 0;
    }
    for (int32_t p = pairs->n_inner; p < pairs->n; p += RY_CONTACT_BLOCK) {
        const int32_t end = pairs->n - p < RY_CONTACT_BLOCK ? pairs->n : p + RY_CONTACT_BLOCK;
        ry_contact_push(c, g, pairs, p, end, pairs->n_chunks);
    }
}

void ry_contact_end(const ry_contact *c, ry_pairs *pairs)
{
    for (int32_t k = 0; c->young != NULL && k <= pairs->n_chunks; k++) {
        put_ages(pairs, k < pairs->n_chunks ? pairs->chunk[k] : pairs->n_inner, pairs->n_young[k]);
    }
    join_books(c, pairs->n_chunks);
}

/* ---- the books ------------------------------------------------------------------------------ */

/* Contacts that have parted hold nothing any more. */
static void forget_parted(const ry_near *near, double *slip, double *rest)
{
    for (int32_t k = 0; k < near->n; k++) {
        const int touches = near->distance[k] < near->radii[k];
        slip[k] = touches ? slip[k] : 0.0;
        if (rest != NULL) {
            rest[k] = touches ? rest[k] : 0.0;
        }
    }
}

static void close_range(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int32_t first, int32_t end,
                        int32_t chunk, int parted)
{
    const int holds = parted && holds_energy(c);
    ry_near near;
    near.books = books_of(c, chunk);
    for (int32_t p = first; p < end; p += RY_CONTACT_BLOCK) {
        const int32_t n = end - p < RY_CONTACT_BLOCK ? end - p : RY_CONTACT_BLOCK;
        fetch_block(c, g, pairs, p, n, &near);
        c->close(c, &near);
        book_losses(c, &near, 0);
        if (holds && near.opens) {
            book_openings(c, g, pairs, p, &near);
            forget_parted(&near, pairs->slip + p, pairs->rest != NULL ? pairs->rest + p : NULL);
        }
        for (int32_t k = p; k < p + n; k++) {
            pairs->t_jn[k] = pairs->t_jt[k] = pairs->t_dashpot[k] = pairs->t_sliding[k] = 0.0;
            pairs->t_kt[k] = -1.0;
        }
    }
}

typedef struct ry_contact_task {
    const ry_contact *contact;
    const ry_grains *grains;
    ry_pairs *pairs;
    int parted;
} ry_contact_task;

static void close_chunks(void *context, int32_t begin, int32_t end, int thread)
{
    const ry_contact_task *const t = context;
    const int32_t *const chunk = t->pairs->chunk;
    (void)thread;
    for (int32_t k = begin; k < end; k++) {
        close_range(t->contact, t->grains, t->pairs, chunk[k], chunk[k + 1], k, t->parted);
    }
}

static void close_books(const ry_contact *c, const ry_grains *g, ry_pairs *pairs, int parted)
{
    if (c->books == NULL) {
        return;
    }
    ry_contact_task task = {c, g, pairs, parted};
    ry_parallel(c->threads, pairs->n_chunks, close_chunks, &task);
    close_range(c, g, pairs, pairs->n_inner, pairs->n, pairs->n_chunks, parted);
    join_books(c, pairs->n_chunks);
}

void ry_contact_close(const ry_contact *c, const ry_grains *g, ry_pairs *pairs)
{
    close_books(c, g, pairs, 0);
}

void ry_contact_close_list(const ry_contact *c, const ry_grains *g, ry_pairs *pairs)
{
    close_books(c, g, pairs, 1);
}
