/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Bed-load relations q*(theta) and thresholds of motion theta_c(D*) from the literature. One table
 * each; the curves in postprocess/relations.csv are made from it.
 *
 * A relation is only as good as its convention: theta here is tau_b/((rho_s - rho_f) g d) with the
 * stress that acts on the grains, and q* = q_b/sqrt((s - 1) g d^3) counts grain volume without pores. */
#ifndef RY_ANALYSIS_RELATIONS_H
#define RY_ANALYSIS_RELATIONS_H

#include "ryusa/status.h"

/* What a relation may ask beside theta. */
typedef struct ry_relation_input {
    double theta;   /* Shields number */
    double theta_c; /* its threshold */
    double s;       /* density of the grains over that of the fluid */
    double d_star;  /* D* = d ((s - 1) g/nu^2)^(1/3) */
} ry_relation_input;

typedef struct ry_relation ry_relation;
struct ry_relation {
    const char *key;     /* the word in scene files, options and tables */
    const char *authors;
    const char *formula;
    int year;
    double theta_c;      /* its own threshold: q* is 0 up to it; 0: none */
    double a, b;         /* coefficients that `flux` uses */
    double (*flux)(const ry_relation *relation, const ry_relation_input *input);
};

int ry_relation_count(void);
const ry_relation *ry_relation_at(int index);
/* NULL if there is none of that key. */
const ry_relation *ry_relation_find(const char *key);

/* q* with the relation's own threshold, for coarse quartz in water (s = 2.65, D* = 150; only
 * einstein-brown and yalin look at these). 0 at and below the threshold. */
double ry_relation_flux(const ry_relation *relation, double theta);
/* The same for other grains, and with another threshold unless input->theta_c is not a number. */
double ry_relation_flux_of(const ry_relation *relation, const ry_relation_input *input);

/* D* of a grain; its particle Reynolds number sqrt((s - 1) g d) d/nu is D*^1.5. */
double ry_relation_d_star(double diameter, double s, double gravity, double viscosity);

typedef struct ry_threshold {
    const char *key, *authors, *formula;
    int year;
    double (*theta_c)(double d_star);
} ry_threshold;

int ry_threshold_count(void);
const ry_threshold *ry_threshold_at(int index);
const ry_threshold *ry_threshold_find(const char *key);

#endif
