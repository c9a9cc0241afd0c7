/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The contact stage: pairs + grains -> impulse, angular impulse, shift and new memory of each pair
 * that touches. Pairs write their own slot only. */
#ifndef RY_STAGE_CONTACT_H
#define RY_STAGE_CONTACT_H

#include "law/bond.h"
#include "law/wet.h"
#include "stage/neighbor.h"
#include "store/pairs.h"

/* Features that change the inner loop; everything else is a stage of its own. */
enum {
    RY_CONTACT_FRICTION = 1, /* tangential force */
    RY_CONTACT_SIZES = 2,    /* grains of different mass: coefficients are made per pair */
    RY_CONTACT_LEDGER = 4,   /* losses are booked; the rest of that is stage/ledger.c */
    RY_CONTACT_STAMPS = 8
};

/* Listed pairs are looked at in blocks of this many; what touches of them stays in the first cache. */
enum { RY_CONTACT_BLOCK = 128 };

/* Lanes of the widest vectors: the kernel's loop runs over a multiple of it, the last touching pair
 * repeated, because the leftover loop would cost a quarter of the whole. */
enum { RY_CONTACT_LANES = 8 };

typedef struct ry_near {
    int32_t n, n_padded;
    int32_t pair[RY_CONTACT_BLOCK], i[RY_CONTACT_BLOCK], j[RY_CONTACT_BLOCK];
    /* The fields of ry_pairs of the same names: there themselves, or where the block does not fill the
     * vectors, in `spare`, copied to and fro. */
#define RY_GAP_NEAR(name) double *t_##name;
    RY_GAP_FIELDS(RY_GAP_NEAR)
#undef RY_GAP_NEAR
    double crowd[RY_CONTACT_BLOCK], young_i[RY_CONTACT_BLOCK], young_j[RY_CONTACT_BLOCK];
    double slip[RY_CONTACT_BLOCK], rest[RY_CONTACT_BLOCK], age[RY_CONTACT_BLOCK]; /* in and out */
    double wet[RY_CONTACT_BLOCK]; /* in and out */
    const double *own; /* e, or zeta2 of laws with a damping ratio, of each contact */
    double px[RY_CONTACT_BLOCK], pz[RY_CONTACT_BLOCK], pt[RY_CONTACT_BLOCK];
    double sx[RY_CONTACT_BLOCK], sz[RY_CONTACT_BLOCK];
    double impact[RY_CONTACT_BLOCK]; /* lost [J] */
#define RY_TOUCH_NEAR(name, unit, text) double *t_##name;
    RY_TOUCH_FIELDS(RY_TOUCH_NEAR)
#undef RY_TOUCH_NEAR
#define RY_GAP_ONE(name) +1
#define RY_TOUCH_ONE(name, unit, text) +1
    double spare[0 RY_GAP_FIELDS(RY_GAP_ONE) RY_TOUCH_FIELDS(RY_TOUCH_ONE)][RY_CONTACT_BLOCK];
} ry_near;

typedef struct ry_contact ry_contact;
typedef void ry_contact_fn(const ry_contact *contact, const ry_grains *grains, ry_near *near);

/* The film of fluid between grains that close, see law/wet.h. */
typedef struct ry_film {
    int on;
    int damps;      /* the law takes a damping ratio, not a restitution */
    int usual;      /* its ratio follows from the loss by the usual formula, not the exact one */
    int pulls;      /* its dashpot pulls until the overlap ends */
    double unit;    /* its zeta2 over the ratio: 2, of tanaka sqrt 5 */
    double many;    /* the step bears many x (a + 2c) < 4: 1, in a bed 3 */
    double per_mu;  /* 1/(6 pi mu) [m s/kg] */
} ry_film;

struct ry_contact {
    ry_contact_fn *kernel;
    ry_film film;
    double dry[RY_CONTACT_BLOCK]; /* without film: ry_near.own of any contact */
    ry_law_coef coef;
    ry_bond bond[2];  /* of equal grains: both free to move; one immovable */
    double tm[2];     /* their tm, see ry_bond_make [1/kg] */
    double dt, length, half; /* half = length/2; infinite where x is not periodic */
    int n_walls;
    ry_wall wall[RY_MAX_WALLS];
    double wall_length; /* where the right wall stands [m] */
    int moves, features, threads;
    int counts; /* the law wants to know how crowded grains are: energy */
    const double *im; /* inverse masses, walls included: 0 [1/kg] */
    const double *tm_grain; /* im + r^2/I [1/kg] */
    double *loss_impact, *loss_opening; /* per grain; with ledger [J] */
};

/* The kernel of a law (the order of ryusa/config.h) with RY_CONTACT_ features, and its name. */
ry_contact_fn *ry_contact_select(int law, int features);
const char *ry_contact_law_name(int law);
int ry_contact_law_moves(int law);
int ry_contact_law_damps(int law); /* it takes a damping ratio */

/* What the film makes of a contact of two grains that close [e, or zeta2]: a, c as in law/law.h of the dry
 * pair, `loss` = 35/St. */
double ry_contact_wet(const ry_film *film, const ry_law_coef *coef, double a, double c, double loss);

void ry_contact_stage(const ry_contact *contact, const ry_grains *grains, ry_pairs *pairs);

/* Elastic energy and the largest overlap, for measuring. */
typedef struct ry_contact_sums {
    double elastic_normal, elastic_tangential; /* [J] */
    double worst_overlap; /* of the smaller radius [1] */
    int32_t worst_i, worst_j; /* storage indices; -1: none */
    int64_t touching;
} ry_contact_sums;
/* From the owner of a pair to its partner; signed distance for a wall [m]. */
typedef struct ry_gap {
    double dx, dz, distance;
} ry_gap;

/* dx, or the nearest of its periodic images. */
RY_INLINE double ry_contact_nearest(double dx, double length, double half)
{
    return dx > half ? dx - length : (dx < -half ? dx + length : dx);
}

/* Coefficients of the pair of grains i and j, or of a grain and a wall. */
ry_bond ry_contact_bond(const ry_contact *contact, int32_t i, int32_t j);

ry_gap ry_contact_gap(const ry_contact *contact, const ry_grains *grains, const ry_pairs *pairs, int32_t pair);

ry_contact_sums ry_contact_measure(const ry_contact *contact, const ry_grains *grains,
                                   const ry_pairs *pairs);

#endif
