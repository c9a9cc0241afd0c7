/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The neighbour list: pairs of grains near enough to touch before the next rebuild, and the live
 * memory of their contacts. Plan, not state: the list may be rebuilt at any moment without changing
 * a bit, because each pair writes only its own slot, each grain adds its slots in ascending id of the
 * partner, and a pair that doesn't touch adds exact zeros.
 *
 * A pair belongs to the grain with the lower id, its owner; the pairs of an owner are contiguous, in
 * ascending id of the partner. Pairs with walls follow behind all pairs of grains. */
#ifndef RY_STORE_PAIRS_H
#define RY_STORE_PAIRS_H

#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "store/state.h"

enum { RY_SLOT_X, RY_SLOT_Z, RY_SLOT_TURN, RY_SLOT_MARK, RY_SLOT };

/* RY_SLOT_MARK, of laws that tell impacts from enduring contacts: RY_MARK_HOLDS if its spring holds in this step, plus
 * 1 if it begins to, -1 if its contact has opened. A grain's sum tells how many hold it, and held it before: of
 * a large grain among small ones that may be dozens. */
enum { RY_MARK_HOLDS = 4096 };

/* Where the slots of a chunk's pairs lie, which it fills one after the other. Those of its first `head` pairs and of
 * those from `tail` on are kept until the step is over; the others take turns in a ring of mask + 1 slots, pair & mask,
 * because their grains are through before the next need the place (stage/blocks.h). head and tail count from the
 * chunk's first pair. */
typedef struct ry_shelf {
    int32_t first; /* the chunk's first pair */
    int32_t base;  /* and its slot */
    int32_t head, tail, mask;
} ry_shelf;

RY_INLINE int32_t ry_shelf_slot(const ry_shelf *s, int32_t pair)
{
    const int32_t q = pair - s->first, ring = s->head + (pair & s->mask);
    const int32_t behind = q - (s->tail - s->head - s->mask - 1);
    return s->base + (q < s->head ? q : (q < s->tail ? ring : behind));
}

typedef struct ry_pairs {
    int32_t n_grains; /* grains the list was made for */
    int32_t *place;   /* n_grains: storage index of an id */
    int32_t n_inner;  /* pairs of two grains, filled up */
    int32_t n;        /* all pairs, walls included */
    size_t capacity;

    int32_t *i, *j;   /* storage index of the owner and its partner; n_grains + w for wall w */
    double *slip;     /* as in ry_contacts; likewise: */
    double *rest;     /* NULL unless the law has it */
    uint8_t *age;     /* steps in touch so far, up to 255; 0: did not touch in the last step */
    /* What the last step gives: impulse along x and z on the owner (the partner gets the opposite),
     * angular impulse per radius (the same on both) [N s]; marks. Side by side, because a grain
     * fetches all of a pair that may lie anywhere. */
    double (*slot)[RY_SLOT];
    double *wet;      /* as in ry_contacts; NULL unless contacts are wet */
    double *sx, *sz;  /* shift x reduced mass, on the owner; NULL unless the law moves [kg m] */

    int32_t *row;         /* n_grains + 1: pairs row[k] .. row[k+1]-1 belong to owner k */
    int32_t *below_start; /* n_grains + 1 */
    int32_t *below;       /* n_inner: the slots in which a grain is the partner, ascending owner id */
    int32_t *wall_slot[RY_MAX_WALLS]; /* n_grains each: slot of the grain's pair with the wall, or -1 */

    int32_t *young;       /* n: of each chunk, from its start, the contacts in their first steps, and those that were
                             until now; the walls' last; NULL, as young_…, unless the law does those apart */
    uint8_t *young_age;   /* what their ages become when all of them are done */
    int32_t *n_young;     /* n_chunks + 1: how many; the last for the walls */
    int32_t *young_next;  /* n_chunks + 1: the next of them that a pass will ask for, as a rule */
    /* What the ledger still has to book of the last step, when the velocities after it are known; NULL without
     * ledger. */
#define RY_TOUCH_FIELDS(RY_TOUCH_FIELD)                                                              \
    RY_TOUCH_FIELD(nx, "1", "normal from the owner to its partner, along x")                         \
    RY_TOUCH_FIELD(nz, "1", "and along z")                                                           \
    RY_TOUCH_FIELD(lever, "1", "distance over the sum of the radii")                                 \
    RY_TOUCH_FIELD(jn, "N s", "normal impulse of the dashpot")                                       \
    RY_TOUCH_FIELD(jt, "N s", "tangential impulse: of the dashpot, or all of it where it slides")    \
    RY_TOUCH_FIELD(kt, "N/m", "tangential stiffness of a contact that slides; -1: does not")         \
    RY_TOUCH_FIELD(dashpot, "J", "the half of its dashpots' loss that is known")                     \
    RY_TOUCH_FIELD(sliding, "J", "and that of its sliding")
#define RY_TOUCH_POINTER(name, unit, text) double *t_##name;
    RY_TOUCH_FIELDS(RY_TOUCH_POINTER)
#undef RY_TOUCH_POINTER
    /* Coefficients of a pair of unequal grains, as in ry_bond; NULL if they are made anew in each step: where memory is
     * dearer than arithmetic. */
#define RY_BOND_FIELDS(RY_BOND_FIELD) \
    RY_BOND_FIELD(a) RY_BOND_FIELD(c) RY_BOND_FIELD(stretch) RY_BOND_FIELD(per_stretch) RY_BOND_FIELD(drag) \
    RY_BOND_FIELD(mass_ratio)
#define RY_BOND_POINTER(name) double *b_##name;
    RY_BOND_FIELDS(RY_BOND_POINTER)
#undef RY_BOND_POINTER
    int bonds_made;       /* 1: of this list */
    int32_t n_chunks;     /* row-aligned ranges of pairs, one a thread */
    int32_t *chunk;       /* n_chunks + 1 */
    ry_shelf *shelf;      /* n_chunks + 1: their slots; the last those of the walls */
    size_t n_slots;       /* room */
} ry_pairs;

/* Lanes of the widest vectors. The pairs of grains, and those with walls, are filled up to a multiple of it with
 * pairs that belong to nobody and never touch, so that loops over all of them have no rest. */
enum { RY_LANES = 8 };

RY_INLINE int32_t ry_pairs_fill(int32_t n)
{
    return (n + RY_LANES - 1) / RY_LANES * RY_LANES;
}

/* What of a pair is wanted beyond what every law needs. */
enum { RY_PAIRS_SHIFTS = 1, RY_PAIRS_LEDGER = 2, RY_PAIRS_WET = 4, RY_PAIRS_RESTS = 8, RY_PAIRS_YOUNG = 16,
       RY_PAIRS_BONDS = 32 };

ry_status ry_pairs_create(ry_pairs *pairs, int32_t n_grains, int n_walls, unsigned wants, ry_error *error);
void ry_pairs_free(ry_pairs *pairs);

/* Room for n pairs; what is there is lost. */
ry_status ry_pairs_reserve(ry_pairs *pairs, size_t n, ry_error *error);

/* Room for n slots. */
ry_status ry_pairs_reserve_slots(ry_pairs *pairs, size_t n, ry_error *error);

/* The slot of a pair. */
const double *ry_pairs_slot(const ry_pairs *pairs, int32_t pair);

typedef struct ry_entries {
    int32_t begin, end;
} ry_entries;

/* The entries of `young` that are among the pairs first .. end-1, all of this chunk. */
ry_entries ry_pairs_young(const ry_pairs *pairs, int32_t first, int32_t end, int chunk);

/* Gives the contacts of the state back to a fresh list. */
void ry_pairs_import(ry_pairs *pairs, const ry_state *state);

/* One of them: what it remembers. `id`: of each grain in storage order. */
void ry_pairs_import_one(ry_pairs *pairs, const int32_t *id, const ry_contacts *from, int64_t c);

/* Collects the memory of all touching contacts, sorted by (id_i, id_j). */
ry_status ry_pairs_export(const ry_pairs *pairs, const int32_t *id, ry_contacts *out, ry_error *error);

#endif
