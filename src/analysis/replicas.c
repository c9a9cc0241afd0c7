/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "analysis/replicas.h"

#include <math.h>
#include <stdlib.h>

/* A bed that carries less than this part of the mean of all is one that rests, or hardly moves. */
#define RESTS 0.25

ry_replicas ry_replicas_of(int n, const double *value, const double *error)
{
    ry_replicas r = {0, NAN, NAN, NAN, NAN};
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
    r.between = r.n > 1 ? sqrt(fmax(squares / (r.n - 1.0) - own / r.n, 0.0) / r.n) : 0.0;
    return r;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

double ry_replicas_spread(int n, const ry_replicas *point, double least)
{
    double *const list = calloc(n > 0 ? (size_t)n : 1, sizeof *list);
    size_t used = 0;
    double freedom = 0.0, spread = 0.0;
    for (int k = 0; k < n && list != NULL; k++) {
        const int rests = !(point[k].lowest > RESTS * point[k].mean);
        if (point[k].n > 1 && point[k].mean > least && !rests) {
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
