/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "analysis/replicas.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

/* A bed that carries less than this part of the mean of all is one that rests, or hardly moves. */
#define RESTS 0.25
/* Points of the same flux are pooled, those of e^0.5 or e^-0.5 times it count 0.6, of twice that way 0.14; the nearest
 * only, for more tell nothing more. */
#define KERNEL 0.5
enum { NEAREST = 100 };

ry_replicas ry_replicas_of(int n, const double *value, const double *error)
{
    ry_replicas r = {.mean = NAN, .within = NAN, .between = NAN, .lowest = NAN};
    double sum = 0.0, own = 0.0, squares = 0.0;
    for (int k = 0; k < n; k++) {
        if (isfinite(value[k])) {
            r.n++;
            r.lowest = fmin(r.lowest, value[k]); /* of NAN and a number the number */
            sum += value[k];
            own += isfinite(error[k]) ? error[k] * error[k] : 0.0;
        }
    }
    if (r.n == 0) {
        return r;
    }
    r.mean = sum / r.n;
    for (int k = 0; k < n; k++) {
        squares += isfinite(value[k]) ? (value[k] - r.mean) * (value[k] - r.mean) : 0.0;
    }
    r.within = sqrt(own) / r.n;
    r.variance = r.n > 1 ? squares / (r.n - 1.0) : 0.0;
    r.between = r.n > 1 ? sqrt(fmax(r.variance - own / r.n, 0.0) / r.n) : 0.0;
    return r;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Do the replicas of a point tell what beds differ by at others, or near its threshold, whether a bed moves? */
static int tells(const ry_replicas *r, double least)
{
    return r->n > 1 && r->mean > least && r->lowest > RESTS * r->mean;
}

double ry_replicas_spread(int n, const ry_replicas *point, double least)
{
    double *const list = calloc(n > 0 ? (size_t)n : 1, sizeof *list);
    size_t used = 0;
    double freedom = 0.0, spread = 0.0;
    for (int k = 0; k < n && list != NULL; k++) {
        if (tells(&point[k], least)) {
            const double part = point[k].between / point[k].mean;
            list[used++] = part * part * point[k].n;
            freedom += point[k].n - 1.0;
        }
    }
    if (used > 0) {
        qsort(list, used, sizeof *list, compare);
        freedom /= (double)used; /* median of chi^2 over its mean, by Wilson & Hilferty */
        const double median = 0.5 * (list[(used - 1) / 2] + list[used / 2]);
        spread = sqrt(median / pow(1.0 - 2.0 / (9.0 * freedom), 3.0));
    }
    free(list);
    return spread;
}

double ry_replicas_error(const ry_replicas *r, double spread)
{
    const double pooled = r->n > 0 ? spread * r->mean / sqrt(r->n) : 0.0;
    /* Near its threshold a bed moves or not, and differs by more than usual. */
    const double between = fmax(pooled, r->between);
    return sqrt(r->within * r->within + between * between);
}

/* --- pooled over points of similar flux ---------------------------------------------------------- */

double ry_student(double share, double freedom)
{
    const double upper = 0.5 + 0.5 * share;
    if (!(freedom > 0.0)) {
        return NAN;
    }
    return isinf(freedom) ? gsl_cdf_ugaussian_Pinv(upper) : gsl_cdf_tdist_Pinv(upper, freedom);
}

/* A point that tells, by its flux. */
typedef struct member {
    double place, mean, own, beyond; /* ln mean; own variance of a replica over the mean; the rest of it */
    double freedom;
    int index;
} member;

static int compare_members(const void *a, const void *b)
{
    const member *const x = a, *const y = b;
    return x->place != y->place ? (x->place > y->place ? 1 : -1) : x->index - y->index;
}

static member member_of(const ry_replicas *r, int index)
{
    const double own = r->within * r->within * r->n;
    return (member){log(r->mean), r->mean, own / r->mean, (r->variance - own) / r->mean, r->n - 1.0, index};
}

/* Variance of a replica over the mean: its own, and what beds differ by. That is a part of q* far from the threshold,
 * and as many grains near it: sqrt(q*) lies between, and over the short way to points of similar flux either is near
 * enough. The weights are those of least variance (second turn); the degrees of freedom Satterthwaite's. */
static double pooled(int n, const member *list, int first, const member *at, double *freedom)
{
    double beyond = 0.0;
    for (int turn = 0; turn < 2; turn++) {
        double weights = 0.0, sum = 0.0, squares = 0.0;
        for (int k = first; k < n && k < first + 2 * NEAREST; k++) {
            const member *const m = &list[k];
            const double off = (m->place - at->place) / KERNEL, all = fmax(beyond, 0.0) + m->own;
            const double part = turn > 0 && all > 0.0 ? (fmax(beyond, 0.0) + at->own) / all : 1.0;
            const double weight = m->freedom * exp(-0.5 * off * off) * part * part;
            weights += weight;
            sum += weight * m->beyond;
            squares += weight * weight * (part > 0.0 ? 1.0 / (part * part) : 0.0) / m->freedom;
        }
        if (!(weights > 0.0)) { /* none is near */
            *freedom = INFINITY;
            return at->own;
        }
        /* in units of the variance that was supposed here, of which each point's is 1/part */
        *freedom = weights * weights / squares;
        beyond = sum / weights;
    }
    return at->own + fmax(beyond, 0.0);
}

static ry_replicas_interval interval_of(int n, double variance, double freedom)
{
    const double error = sqrt(variance / n);
    freedom = fmax(freedom, 1.0);
    return (ry_replicas_interval){ry_student(0.6826895, freedom) * error, ry_student(0.95, freedom) * error, freedom};
}

int ry_replicas_pool(int n, const ry_replicas *point, double least, ry_replicas_interval *out)
{
    member *const list = calloc(n > 0 ? (size_t)n : 1, sizeof *list);
    const int good = list != NULL;
    int used = 0;
    for (int k = 0; k < n && good; k++) {
        if (tells(&point[k], least)) {
            list[used++] = member_of(&point[k], k);
        }
    }
    if (used > 0) {
        qsort(list, (size_t)used, sizeof *list, compare_members);
    }
    for (int k = 0; k < n && good; k++) {
        const ry_replicas *const r = &point[k];
        const double own = r->within * r->within * r->n;
        if (r->n == 0) {
            out[k] = (ry_replicas_interval){NAN, NAN, NAN};
        } else if (r->mean > least && (r->n == 1 || tells(r, least))) {
            const member at = member_of(r, k);
            int first = 0, last = used;
            while (first < last) { /* the first that is not below it */
                const int middle = (first + last) / 2;
                *(list[middle].place < at.place ? &first : &last) = list[middle].place < at.place ? middle + 1 : middle;
            }
            double freedom;
            const double part = pooled(used, list, first > NEAREST ? first - NEAREST : 0, &at, &freedom);
            out[k] = interval_of(r->n, part * r->mean, freedom);
        } else {
            out[k] = interval_of(r->n, fmax(r->variance, own), r->n > 1 ? r->n - 1.0 : INFINITY);
        }
    }
    free(list);
    return good;
}
