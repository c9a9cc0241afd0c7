/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Explicit grains may touch at the start but not overlap, each other or a plane. Sweep: grains
 * sorted by their near edge along the longer side of the scene; partners of one begin before its
 * far edge. */
#include <stdlib.h>

#include "config/resolve.h"

static const double tolerance = 1e-9; /* of the smaller diameter: rounding in a scene's numbers */

typedef struct disc {
    double edge, along, across, radius;
    int index; /* in config->particles */
} disc;

static int by_edge(const void *a, const void *b)
{
    const disc *one = a, *other = b;
    if (one->edge != other->edge) {
        return one->edge < other->edge ? -1 : 1;
    }
    return one->index - other->index;
}

static disc make_disc(const ry_particle *p, int index, double shift, int axis)
{
    const double at[2] = {p->position[0] + shift, p->position[1]};
    const double radius = 0.5 * p->diameter;
    return (disc){at[axis] - radius, at[axis], at[1 - axis], radius, index};
}

/* The axis along which the grains extend farther. */
static int longer_axis(const ry_config *config)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < config->n_particles; i++) {
        for (int j = 0; j < 2; j++) {
            low[j] = fmin(low[j], config->particles[i].position[j]);
            high[j] = fmax(high[j], config->particles[i].position[j]);
        }
    }
    return high[1] - low[1] > high[0] - low[0];
}

/* All grains and, where x is periodic, copies beyond the right end of those near the left one. */
static int make_discs(const ry_check *check, disc *discs)
{
    const ry_config *config = check->config;
    const int axis = longer_axis(config);
    int n = 0;
    for (int i = 0; i < config->n_particles; i++) {
        const ry_particle *p = &config->particles[i];
        discs[n++] = make_disc(p, i, 0.0, axis);
        if (config->domain_periodic && p->position[0] <= check->d_max) {
            discs[n++] = make_disc(p, i, check->derived.length, axis);
        }
    }
    return n;
}

static ry_status check_pair(const ry_check *check, const disc *a, const disc *b)
{
    const ry_particle *p = check->config->particles;
    if (a->index == b->index || (p[a->index].fixed && p[b->index].fixed)) {
        return RY_OK;
    }
    const double along = a->along - b->along, across = a->across - b->across;
    const double touching = a->radius + b->radius;
    if (fabs(across) > touching) { /* most */
        return RY_OK;
    }
    const double overlap = touching - hypot(along, across);
    if (!(overlap > tolerance * 2.0 * fmin(a->radius, b->radius))) {
        return RY_OK;
    }
    const int first = a->index < b->index ? a->index : b->index;
    const int second = a->index < b->index ? b->index : a->index;
    return ry_check_fail_particle(check, second,
                                  "overlaps another grain, %s, by %.3g m; grains may "
                                  "touch at the start, but not overlap",
                                  ry_check_name(check, first).text, overlap);
}

static ry_status sweep(const ry_check *check, const disc *discs, int n)
{
    for (int i = 0; i < n; i++) {
        const double far = discs[i].along + discs[i].radius;
        for (int j = i + 1; j < n && discs[j].edge < far; j++) {
            RY_TRY(check_pair(check, &discs[i], &discs[j]));
        }
    }
    return RY_OK;
}

static ry_status check_pairs(const ry_check *check)
{
    disc *discs = malloc(((size_t)check->config->n_particles * 2 + 1) * sizeof *discs);
    if (discs == NULL) {
        return ry_fail(check->error, RY_BAD_FILE, "not enough memory to check the particles");
    }
    const int n = make_discs(check, discs);
    qsort(discs, (size_t)n, sizeof *discs, by_edge);
    const ry_status status = sweep(check, discs, n);
    free(discs);
    return status;
}

static ry_status check_planes(const ry_check *check, int index)
{
    const ry_config *config = check->config;
    const ry_particle *p = &config->particles[index];
    const double radius = 0.5 * p->diameter, allowed = tolerance * p->diameter;
    const double below = radius - p->position[1];
    const double left = radius - p->position[0];
    const double right = p->position[0] + radius - check->derived.length;
    if (p->fixed) {
        return RY_OK;
    }
    if (config->domain_floor == RY_FLOOR_FLAT && below > allowed) {
        return ry_check_fail_particle(check, index,
                                      "overlaps the floor z = 0 by %.3g m; allowed is "
                                      "z of at least %.9g m",
                                      below, radius);
    }
    if (config->domain_walls && (left > allowed || right > allowed)) {
        return ry_check_fail_particle(check, index,
                                      "overlaps a side wall by %.3g m; allowed is x "
                                      "from %.9g to %.9g m",
                                      fmax(left, right), radius, check->derived.length - radius);
    }
    return RY_OK;
}

ry_status ry_check_overlap(const ry_check *check)
{
    for (int i = 0; i < check->config->n_particles; i++) {
        RY_TRY(check_planes(check, i));
    }
    return check_pairs(check);
}
