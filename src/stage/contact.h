/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The contact stage: pairs + grains -> impulse, angular impulse, shift and new memory of each pair
 * that touches. Pairs write their own slot only. */
#ifndef RY_STAGE_CONTACT_H
#define RY_STAGE_CONTACT_H

#include "base/memory.h"
#include "law/bond.h"
#include "law/wet.h"
#include "stage/motion.h"
#include "stage/neighbor.h"
#include "store/pairs.h"

/* Features that change the inner loop; everything else is a stage of its own. */
enum {
    RY_CONTACT_FRICTION = 1, /* tangential force */
    RY_CONTACT_SIZES = 2,    /* grains of different mass: coefficients are made per pair */
    RY_CONTACT_LEDGER = 4,   /* losses are booked */
    RY_CONTACT_KEPT = 8,     /* which are kept (ry_pairs): with SIZES only */
    RY_CONTACT_STAMPS = 16
};

/* Pairs are worked on in blocks of this many, which stay in the first cache. */
enum { RY_CONTACT_BLOCK = 128 };

/* See ry_contact.ahead. */
enum { RY_MOST_AHEAD = 24 };

/* What a pair has lost in the last step, and by an impact in this one. */
enum { RY_LOST_DASHPOT, RY_LOST_FRICTION, RY_LOST_IMPACT, RY_LOST };

/* A block of pairs, their members side by side, each from a cache line on: else every second load of the widest vectors
 * straddles two. Differences are partner less owner. */
typedef struct ry_near {
    int32_t n, n_padded; /* n filled up to a multiple of RY_LANES */
    const int32_t *i, *j; /* storage indices */
    int opens, young; /* a pair may have parted in this step; a contact be in its first steps */
    /* in: */
    _Alignas(RY_ALIGNMENT) double dx[RY_CONTACT_BLOCK], dz[RY_CONTACT_BLOCK], distance[RY_CONTACT_BLOCK]; /* [m] */
    double dvx[RY_CONTACT_BLOCK], dvz[RY_CONTACT_BLOCK]; /* [m/s] */
    double radii[RY_CONTACT_BLOCK], turn[RY_CONTACT_BLOCK]; /* sums of r [m], of spin x r [m/s] */
    double im[RY_CONTACT_BLOCK], tm[RY_CONTACT_BLOCK]; /* sums of the inverse masses [1/kg] */
    double per_all[RY_CONTACT_BLOCK]; /* 1/(distance im tm radii), one division for four */
    /* of young contacts: three as in ry_touch; side: 1 if the owner rests (can't move, or has other contacts) less 1 if
     * the partner does; share: the sum of inverse mass x young contacts of both grains [1/kg] */
    double crowd[RY_CONTACT_BLOCK], busy[RY_CONTACT_BLOCK], bend[RY_CONTACT_BLOCK];
    double side[RY_CONTACT_BLOCK], share[RY_CONTACT_BLOCK];
    double firm[RY_CONTACT_BLOCK]; /* of young contacts: 1 where one of the two can't move */
    /* in and out: */
    double age[RY_CONTACT_BLOCK];
    double *slip, *rest, *wet; /* those of ry_pairs themselves, or copies in `spare` */
#define RY_BOND_NEAR(name) const double *b_##name; /* NULL unless kept */
    RY_BOND_FIELDS(RY_BOND_NEAR)
#undef RY_BOND_NEAR
    const double *own; /* e, or zeta2 of laws with a damping ratio, of each contact */
    /* out: */
    _Alignas(RY_ALIGNMENT) double px[RY_CONTACT_BLOCK], pz[RY_CONTACT_BLOCK]; /* a slot of ry_pairs */
    double pt[RY_CONTACT_BLOCK], mark[RY_CONTACT_BLOCK];
    double sx[RY_CONTACT_BLOCK], sz[RY_CONTACT_BLOCK]; /* as in ry_pairs */
    _Alignas(RY_ALIGNMENT) double lost[RY_LOST][RY_CONTACT_BLOCK]; /* [J] */
    ry_ledger *books; /* to which it is added */
#define RY_TOUCH_NEAR(name, unit, text) double *t_##name; /* as slip */
    RY_TOUCH_FIELDS(RY_TOUCH_NEAR)
#undef RY_TOUCH_NEAR
#define RY_TOUCH_ONE(name, unit, text) +1
#define RY_BOND_ONE(name) +1
    _Alignas(RY_ALIGNMENT) double spare[3 RY_TOUCH_FIELDS(RY_TOUCH_ONE) RY_BOND_FIELDS(RY_BOND_ONE)][RY_CONTACT_BLOCK];
    int32_t list[3][RY_CONTACT_BLOCK]; /* pairs, owners, partners of a block that is not a run of the list */
} ry_near;

typedef struct ry_contact ry_contact;
typedef void ry_contact_fn(const ry_contact *contact, ry_near *near);

/* The film of fluid between grains that close, see law/wet.h. */
typedef struct ry_film {
    int on;
    int damps;      /* the law takes a damping ratio, not a restitution */
    int usual;      /* its ratio follows from the loss by the usual formula, not the exact one */
    int pulls;      /* its dashpot pulls until the overlap ends */
    double unit;    /* its zeta2 over the ratio: 2, of Hertz sqrt 5 */
    double many;    /* the step bears many x (a + 2c) < 4: 1, in a bed 3 */
    double per_mu;  /* 1/(6 pi mu) [m s/kg] */
} ry_film;

struct ry_contact {
    ry_contact_fn *kernel;
    ry_contact_fn *young; /* for contacts in their first steps, if the law treats those apart; else NULL */
    ry_film film;
    _Alignas(RY_ALIGNMENT) double dry[RY_CONTACT_BLOCK]; /* without film: ry_near.own of any contact */
    ry_law_coef coef;
    ry_bond bond[2];  /* of equal grains: both free to move; one immovable */
    double im_lone;   /* inverse mass of a grain, where all are equal [1/kg] */
    const double (*body)[RY_BODY]; /* what a pair needs of a grain, see ry_motion */
    double dt, length, half; /* half = length/2; infinite where x is not periodic */
    int n_walls;
    ry_wall wall[RY_MAX_WALLS];
    double wall_length; /* where the right wall stands [m] */
    int moves, features, threads;
    int large; /* so many grains that they don't stay in the cache */
    const double *ahead[RY_MOST_AHEAD]; /* arrays of the grains that the passes behind this one go through, asked for
                                           along with its grains: none if these stay in the cache */
    int n_ahead;
    double most_around; /* 1.5 x the fixed grains that are so small (ry_bond_around); 0: none, or another law */
    int impacts; /* the law has impacts, and does them with all other contacts */
    int explicit_spring; /* normal spring: its kick precedes the drift; all but the laws of Fujioka & Ushijima */
    const double *im; /* inverse masses, walls included: 0 [1/kg] */
    const double *tm_grain; /* im + r^2/I [1/kg] */
    ry_scale scale; /* of the ledger */
    ry_ledger *books; /* of each thread, n_chunks + 1, empty between steps; NULL without ledger */
    ry_ledger *ledger; /* of the state */
    ry_contact_fn *close;
    const int32_t *frozen; /* contacts of a sleeping grain that are not listed, see stage/sleep.h; NULL: all are */
};

/* The kernels of a law (the order of ryusa/config.h) with RY_CONTACT_ features. */
ry_contact_fn *ry_contact_select(int law, int features);
ry_contact_fn *ry_contact_select_young(int law, int features);
ry_contact_fn *ry_contact_select_close(int features); /* with RY_CONTACT_LEDGER, see ry_contact_close */

/* What the film makes of a contact of two grains that close [e, or zeta2]: a, c as in law/law.h of the dry
 * pair, `loss` = 35/St. */
double ry_contact_wet(const ry_film *film, const ry_law_coef *coef, double a, double c, double loss);

/* Decides for the contacts of a fetched block that close, and forgets for those that don't touch: near->wet. */
void ry_contact_film(const ry_contact *contact, const ry_grains *grains, ry_near *near);

/* The largest overlap, over the radius of the smaller of the two grains, and the grain that has it. */
typedef struct ry_contact_depth {
    double overlap;
    int32_t i;
} ry_contact_depth;
ry_contact_depth ry_contact_deepest(const ry_contact *contact, const ry_grains *grains, const ry_pairs *pairs);

/* A step: begin (which does the pairs with walls), the pairs of grains by at most RY_CONTACT_BLOCK of a chunk; when all
 * contacts of their grains are known those among them that are young, if the law treats those apart; end. */
void ry_contact_begin(const ry_contact *contact, const ry_grains *grains, ry_pairs *pairs);
void ry_contact_push(const ry_contact *contact, const ry_grains *grains, ry_pairs *pairs, int32_t first, int32_t end,
                     int chunk);
void ry_contact_push_young(const ry_contact *contact, const ry_grains *grains, ry_pairs *pairs, int32_t first,
                           int32_t end, int chunk);
void ry_contact_end(const ry_contact *contact, ry_pairs *pairs);

/* Books what is left of the last step, which the next would do in passing: before somebody reads the ledger, or
 * the velocities change between steps. Makes no difference to any later bit. */
void ry_contact_close(const ry_contact *contact, const ry_grains *grains, ry_pairs *pairs);

/* The same before the list is made anew, with the grains where they are then: also books what contacts hold that
 * have parted, for they may have gone so far that they are not listed any more. */
void ry_contact_close_list(const ry_contact *contact, const ry_grains *grains, ry_pairs *pairs);

/* For measuring. */
typedef struct ry_contact_sums {
    double elastic_normal, elastic_tangential; /* [J] */
    int64_t touching;
} ry_contact_sums;

/* Approach along the line of centres of the step before, which the grains have left by u since: u approach, d from the
 * owner to its partner. That of a wall does not turn, and its distance has a sign. */
RY_INLINE double ry_contact_then(double dx, double dz, double distance, double ux, double uz, int turns)
{
    const double x = turns ? dx + ux : dx, z = turns ? dz + uz : dz;
    return (ux * x + uz * z) / (turns ? sqrt(x * x + z * z) : distance);
}

/* From the owner of a pair to its partner; signed distance for a wall [m]. */
typedef struct ry_gap {
    double dx, dz, distance;
} ry_gap;

/* Coefficients of a pair. */
ry_bond ry_contact_bond(const ry_contact *contact, const ry_pairs *pairs, int32_t pair);

/* The contact is an impact, with its own ways; all else is an explicit spring. Energy of its tangential spring [J]. */
int ry_contact_in_impact(const ry_contact *contact, const ry_pairs *pairs, int32_t pair);
double ry_contact_tangential(const ry_contact *contact, const ry_grains *grains, const ry_pairs *pairs, int32_t pair,
                             ry_gap gap, double stretch);

/* Of an impact: energy of its spring [J], see ry_impact_holds. */
double ry_contact_held(const ry_contact *contact, const ry_grains *grains, const ry_pairs *pairs, int32_t pair,
                       ry_gap gap);

/* Contacts of grain k in this step. */
int ry_contact_count(const ry_contact *contact, const ry_pairs *pairs, int32_t k);

ry_gap ry_contact_gap(const ry_contact *contact, const ry_grains *grains, const ry_pairs *pairs, int32_t pair);

ry_contact_sums ry_contact_measure(const ry_contact *contact, const ry_grains *grains,
                                   const ry_pairs *pairs);

/* Of the pairs 0 .. n-1 alone, in that order, touching or not; only i, j and their memory are looked at. */
ry_contact_sums ry_contact_measure_run(const ry_contact *contact, const ry_grains *grains, const ry_pairs *pairs);

#endif
