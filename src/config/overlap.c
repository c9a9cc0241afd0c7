/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sweep: discs in rows as high as the largest is wide, sorted in each by their left edge. Partners of one lie in its
 * row or the next, and begin before its right edge. */
#include "config/overlap.h"

#include <stdlib.h>

#include "config/resolve.h"

typedef struct entry {
    double row, left, x, z, radius;
    int index, fixed;
} entry;

typedef struct sorted {
    entry *entries;
    int n, between;
    double largest; /* diameter */
} sorted;

static int by_row_and_edge(const void *a, const void *b)
{
    const entry *one = a, *other = b;
    if (one->row != other->row) {
        return one->row < other->row ? -1 : 1;
    }
    if (one->left != other->left) {
        return one->left < other->left ? -1 : 1;
    }
    return one->index - other->index;
}

static entry make_entry(const ry_disc *d, int index, double shift, double height)
{
    const double x = d->x + shift;
    return (entry){floor(d->z / height), x - d->radius, x, d->z, d->radius, index, d->fixed};
}

/* All discs and, where x is periodic, copies beyond the right end of those near the left one. */
static void make_entries(const ry_disc *discs, int n, double length, sorted *all)
{
    for (int i = 0; i < n; i++) {
        all->largest = fmax(all->largest, 2.0 * discs[i].radius);
    }
    for (int i = 0; i < n; i++) {
        all->entries[all->n++] = make_entry(&discs[i], i, 0.0, all->largest);
        if (length > 0.0 && discs[i].x <= all->largest) {
            all->entries[all->n++] = make_entry(&discs[i], i, length, all->largest);
        }
    }
    qsort(all->entries, (size_t)all->n, sizeof *all->entries, by_row_and_edge);
}

static ry_overlap overlap_of(const entry *a, const entry *b, int between)
{
    const int first = a->index < b->index ? a->index : b->index, second = a->index < b->index ? b->index : a->index;
    const double touching = a->radius + b->radius, x = a->x - b->x, z = a->z - b->z;
    const int looked_at = between <= 0 || (first < between && second >= between);
    ry_overlap found = {-1, -1, 0.0, RY_MOST_OVERLAP * 2.0 * fmin(a->radius, b->radius)};
    if (fabs(z) > touching || first == second || (a->fixed && b->fixed) || !looked_at) { /* most */
        return found;
    }
    found.depth = touching - hypot(x, z);
    if (found.depth > found.most) {
        found.first = first;
        found.second = second;
    }
    return found;
}

/* Partners of entry i from entry `from` on, in the row of that. */
static ry_overlap look(const sorted *all, int i, int from)
{
    const entry *const e = all->entries;
    const double right = e[i].x + e[i].radius;
    ry_overlap found = {-1, -1, 0.0, 0.0};
    for (int j = from; found.first < 0 && j < all->n && e[j].row == e[from].row && e[j].left < right; j++) {
        found = overlap_of(&e[i], &e[j], all->between);
    }
    return found;
}

static ry_overlap sweep(const sorted *all)
{
    const entry *const e = all->entries;
    ry_overlap found = {-1, -1, 0.0, 0.0};
    int above = 0; /* the first of the next row that may reach entry i */
    for (int i = 0; found.first < 0 && i < all->n; i++) {
        while (above < all->n && (e[above].row < e[i].row + 1.0 ||
                                  (e[above].row == e[i].row + 1.0 && e[above].left < e[i].left - all->largest))) {
            above++;
        }
        found = i + 1 < all->n && e[i + 1].row == e[i].row ? look(all, i, i + 1) : found;
        found = found.first < 0 && above < all->n && e[above].row == e[i].row + 1.0 ? look(all, i, above) : found;
    }
    return found;
}

ry_status ry_overlap_find(const ry_disc *discs, int n, int between, double length, ry_overlap *found, ry_error *error)
{
    sorted all = {.entries = malloc(((size_t)n * 2 + 1) * sizeof *all.entries), .between = between};
    if (all.entries == NULL) {
        return ry_fail(error, RY_BAD_FILE, "not enough memory to look for grains that overlap");
    }
    make_entries(discs, n, length, &all);
    *found = sweep(&all);
    free(all.entries);
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
