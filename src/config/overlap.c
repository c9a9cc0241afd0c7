/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sweep: discs sorted by their near edge along the longer side of the scene; partners of one begin before its far
 * edge. */
#include "config/overlap.h"

#include <stdlib.h>

#include "config/resolve.h"

typedef struct entry {
    double edge, along, across, radius;
    int index, fixed;
} entry;

static int by_edge(const void *a, const void *b)
{
    const entry *one = a, *other = b;
    if (one->edge != other->edge) {
        return one->edge < other->edge ? -1 : 1;
    }
    return one->index - other->index;
}

static entry make_entry(const ry_disc *d, int index, double shift, int upright)
{
    const double x = d->x + shift, along = upright ? d->z : x, across = upright ? x : d->z;
    return (entry){along - d->radius, along, across, d->radius, index, d->fixed};
}

/* The scene extends farther along z. */
static int is_upright(const ry_disc *discs, int n)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < n; i++) {
        low[0] = fmin(low[0], discs[i].x);
        high[0] = fmax(high[0], discs[i].x);
        low[1] = fmin(low[1], discs[i].z);
        high[1] = fmax(high[1], discs[i].z);
    }
    return high[1] - low[1] > high[0] - low[0];
}

/* All discs and, where x is periodic, copies beyond the right end of those near the left one. */
static int make_entries(const ry_disc *discs, int n, double length, entry *entries)
{
    const int upright = is_upright(discs, n);
    double largest = 0.0;
    int made = 0;
    for (int i = 0; i < n; i++) {
        largest = fmax(largest, 2.0 * discs[i].radius);
    }
    for (int i = 0; i < n; i++) {
        entries[made++] = make_entry(&discs[i], i, 0.0, upright);
        if (length > 0.0 && discs[i].x <= largest) {
            entries[made++] = make_entry(&discs[i], i, length, upright);
        }
    }
    return made;
}

static ry_overlap overlap_of(const entry *a, const entry *b, int between)
{
    const int first = a->index < b->index ? a->index : b->index, second = a->index < b->index ? b->index : a->index;
    const double touching = a->radius + b->radius, along = a->along - b->along, across = a->across - b->across;
    const int looked_at = between <= 0 || (first < between && second >= between);
    ry_overlap found = {-1, -1, 0.0, RY_MOST_OVERLAP * 2.0 * fmin(a->radius, b->radius)};
    if (fabs(across) > touching || first == second || (a->fixed && b->fixed) || !looked_at) { /* most */
        return found;
    }
    found.depth = touching - hypot(along, across);
    if (found.depth > found.most) {
        found.first = first;
        found.second = second;
    }
    return found;
}

static ry_overlap sweep(const entry *entries, int n, int between)
{
    for (int i = 0; i < n; i++) {
        const double far = entries[i].along + entries[i].radius;
        for (int j = i + 1; j < n && entries[j].edge < far; j++) {
            const ry_overlap found = overlap_of(&entries[i], &entries[j], between);
            if (found.first >= 0) {
                return found;
            }
        }
    }
    return (ry_overlap){-1, -1, 0.0, 0.0};
}

ry_status ry_overlap_find(const ry_disc *discs, int n, int between, double length, ry_overlap *found, ry_error *error)
{
    entry *const entries = malloc(((size_t)n * 2 + 1) * sizeof *entries);
    if (entries == NULL) {
        return ry_fail(error, RY_BAD_FILE, "not enough memory to look for grains that overlap");
    }
    const int made = make_entries(discs, n, length, entries);
    qsort(entries, (size_t)made, sizeof *entries, by_edge);
    *found = sweep(entries, made, between);
    free(entries);
    return RY_OK;
}

/* ---- explicit grains -------------------------------------------------------------------------- */

static ry_status check_pairs(const ry_check *check)
{
    const ry_config *const config = check->config;
    const int n = config->n_particles;
    ry_disc *const discs = malloc(((size_t)n + 1) * sizeof *discs);
    if (discs == NULL) {
        return ry_fail(check->error, RY_BAD_FILE, "not enough memory to check the particles");
    }
    for (int i = 0; i < n; i++) {
        const ry_particle *const p = &config->particles[i];
        discs[i] = (ry_disc){p->position[0], p->position[1], 0.5 * p->diameter, p->fixed};
    }
    ry_overlap found = {-1, -1, 0.0, 0.0};
    const double length = config->domain_periodic ? check->derived.length : 0.0;
    ry_status status = ry_overlap_find(discs, n, 0, length, &found, check->error);
    free(discs);
    if (status == RY_OK && found.first >= 0) {
        status = ry_check_fail_particle(check, found.second, "overlaps another grain, %s, by %.3g m; allowed at the "
                                        "start is %.3g m, a twentieth of the smaller diameter",
                                        ry_check_name(check, found.first).text, found.depth, found.most);
    }
    return status;
}

static ry_status check_planes(const ry_check *check, int index)
{
    const ry_config *config = check->config;
    const ry_particle *p = &config->particles[index];
    const double radius = 0.5 * p->diameter, length = check->derived.length, allowed = RY_MOST_OVERLAP * p->diameter;
    const double below = radius - p->position[1];
    const double left = radius - p->position[0];
    const double right = p->position[0] + radius - length;
    if (p->fixed) {
        return RY_OK;
    }
    if (config->domain_floor == RY_FLOOR_FLAT && below > allowed) {
        return ry_check_fail_particle(check, index,
                                      "overlaps the floor z = 0 by %.3g m; it touches it at z = %.9g m, and allowed "
                                      "is an overlap of %.3g m, a twentieth of its diameter",
                                      below, radius, allowed);
    }
    if (config->domain_walls && p->diameter > length) {
        return ry_check_fail_particle(check, index, "a diameter of %g m does not fit between side walls %g m apart",
                                      p->diameter, length);
    }
    if (config->domain_walls && (left > allowed || right > allowed)) {
        return ry_check_fail_particle(check, index,
                                      "overlaps a side wall by %.3g m; it touches none with x from %.9g to %.9g m, and "
                                      "allowed is an overlap of %.3g m, a twentieth of its diameter",
                                      fmax(left, right), radius, length - radius, allowed);
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
