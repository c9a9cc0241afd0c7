/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The mean of replicas: results of the same kind from beds with other packings, each with a standard
 * error of its own. The error of their mean is sqrt(within^2 + between^2): what the runs' own errors
 * give, and what the beds differ by beyond these (a random-effects model, as DerSimonian & Laird 1986). */
#ifndef RY_ANALYSIS_REPLICAS_H
#define RY_ANALYSIS_REPLICAS_H

typedef struct ry_replicas {
    int n;
    double mean;
    double within;  /* standard error of the mean by the replicas' own errors */
    double between; /* by what they differ beyond these; 0 where n < 2 */
    double lowest;
    double variance; /* of the replicas, their own errors included; 0 where n < 2 */
} ry_replicas;

/* An error of a mean, and how often it holds: +- standard_error 68.3 %, +- confidence_95 95 %, by Student's t. */
typedef struct ry_replicas_interval {
    double standard_error, confidence_95;
    double freedom; /* degrees of freedom; infinite: no replicas tell it */
} ry_replicas_interval;

/* Results that are no numbers are left out; an own error that is none counts as 0. */
ry_replicas ry_replicas_of(int n, const double *value, const double *error);

/* What beds differ by, as a part of their mean, pooled over points: few replicas tell it badly at one
 * point, and well over many. The median. Points with a mean of `least` or below, with fewer than two replicas, or with
 * one below a quarter of their mean are left out, for near its threshold a bed moves or not, and that tells nothing of
 * the other points; 0 if none is left. */
double ry_replicas_spread(int n, const ry_replicas *point, double least);

/* The errors of the means of n points. What beds differ by is small far from their threshold and large near it,
 * so it is pooled over points of similar flux only, each with as many degrees of freedom as that leaves; which
 * points are pooled is as for the spread. 0: no memory. */
int ry_replicas_pool(int n, const ry_replicas *point, double least, ry_replicas_interval *out);

/* Student's t with so many degrees of freedom: the middle `share` lies within +- this. */
double ry_student(double share, double freedom);

/* Standard error of the mean; `spread` is that of ry_replicas_spread, 0 where there is none. */
double ry_replicas_error(const ry_replicas *r, double spread);

#endif
