/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The points of a sweep. Every value becomes a text, as it would stand behind -s; computed ones have
 * twelve digits, so that they can be read. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/text.h"
#include "config/keys.h"
#include "config/place.h"
#include "study/sweep_file.h"

static ry_status fail(const ry_sweep_file *file, const ry_axis *axis, ry_error *error,
                      const char *what)
{
    const ry_place place = {.name = file->path, .line = axis != NULL ? axis->line : 0};
    return ry_place_fail(place, axis != NULL ? axis->path : NULL, error, "%s", what);
}

/* The value that lies the share `way`, 0..1, along the range. */
static char *value_along(const ry_axis *axis, double way)
{
    double value = axis->logarithmic ? axis->from * pow(axis->to / axis->from, way)
                                     : axis->from + (axis->to - axis->from) * way;
    if (ry_keys_row(axis->key)->type == 'i') {
        value = round(value);
    }
    value = fmax(fmin(axis->from, axis->to), fmin(fmax(axis->from, axis->to), value));
    return ry_text_print("%.12g", value);
}

/* A range with steps becomes a list of values. */
static ry_status list_range(ry_axis *axis, ry_error *error)
{
    axis->value = calloc((size_t)axis->steps, sizeof *axis->value);
    for (; axis->value != NULL && axis->n < axis->steps; axis->n++) {
        const double way = axis->steps > 1 ? (double)axis->n / (axis->steps - 1) : 0.0;
        axis->value[axis->n] = value_along(axis, way);
        if (axis->value[axis->n] == NULL) {
            break;
        }
    }
    return axis->n == axis->steps ? RY_OK : ry_no_memory(error, (size_t)axis->steps);
}

/* 0.1, 0.10 and 1e-1 are; of 0.5 mm and 500 um nobody knows here. */
static int are_equal(const char *a, const char *b)
{
    char *rest_a, *rest_b;
    const double one = strtod(a, &rest_a), other = strtod(b, &rest_b);
    return strcmp(a, b) == 0 || (rest_a != a && rest_b != b && one == other && strcmp(rest_a, rest_b) == 0);
}

static ry_status refuse_equal(const ry_sweep_file *file, const ry_axis *axis, ry_error *error)
{
    if (axis->n > 2000) { /* nobody writes such a list by hand, and this takes n^2 */
        return RY_OK;
    }
    for (int k = 1; k < axis->n; k++) {
        for (int i = 0; i < k; i++) {
            if (are_equal(axis->value[i], axis->value[k])) {
                char what[120];
                snprintf(what, sizeof what, "the value %.60s stands there twice", axis->value[k]);
                return fail(file, axis, error, what);
            }
        }
    }
    return RY_OK;
}

static ry_status count_points(ry_sweep_file *file, ry_error *error)
{
    double n = file->sampling == RY_SAMPLING_LIST && file->n_axes > 0 ? file->axis[0].n : 1.0;
    for (int k = 0; k < file->n_axes; k++) {
        const ry_axis *const axis = &file->axis[k];
        if (file->sampling == RY_SAMPLING_GRID) {
            RY_TRY(refuse_equal(file, axis, error));
            n *= axis->n;
        } else if (file->sampling == RY_SAMPLING_LIST && axis->n != file->axis[0].n) {
            char what[200];
            snprintf(what, sizeof what,
                     "%d values, but %s has %d; sample: list takes the first of each, then the "
                     "second of each, ...",
                     axis->n, file->axis[0].path, file->axis[0].n);
            return fail(file, axis, error, what);
        }
    }
    n = file->samples > 0 ? file->samples : n;
    if (n * file->replicas > RY_SWEEP_MOST_CASES) {
        char what[120];
        snprintf(what, sizeof what, "%.6g cases; at most %d are allowed", n * file->replicas,
                 RY_SWEEP_MOST_CASES);
        return fail(file, NULL, error, what);
    }
    file->n_points = (int)n;
    return RY_OK;
}

static uint64_t number_of(int axis, int sample)
{
    return (uint64_t)axis << 32 | (uint32_t)sample;
}

/* Sample k of an axis lies in stratum order[k]: a permutation (Fisher & Yates). */
static void shuffle(const ry_sweep_file *file, int axis, int *order)
{
    for (int k = 0; k < file->samples; k++) {
        const double u = ry_random((uint32_t)file->seed, RY_RANDOM_STRATUM, number_of(axis, k));
        const int other = (int)(u * (k + 1));
        order[k] = order[other];
        order[other] = k;
    }
}

static char *draw(const ry_sweep_file *file, int axis, int sample, const int *order)
{
    const ry_axis *const a = &file->axis[axis];
    double u = ry_random((uint32_t)file->seed, RY_RANDOM_SAMPLE, number_of(axis, sample));
    if (file->sampling == RY_SAMPLING_LATIN) {
        u = (order[sample] + u) / file->samples;
    }
    return a->is_range ? value_along(a, u) : strdup(a->value[(int)(u * a->n)]);
}

static int fill_drawn(ry_sweep_file *file)
{
    int *const order = calloc((size_t)file->samples, sizeof *order);
    int good = order != NULL;
    for (int axis = 0; axis < file->n_axes && good; axis++) {
        shuffle(file, axis, order);
        for (int k = 0; k < file->samples && good; k++) {
            char *const text = draw(file, axis, k, order);
            file->value[k * file->n_axes + axis] = text;
            good = text != NULL;
        }
    }
    free(order);
    return good;
}

/* The last key changes fastest. */
static int fill_listed(ry_sweep_file *file)
{
    for (int point = 0; point < file->n_points; point++) {
        int rest = point;
        for (int axis = file->n_axes - 1; axis >= 0; axis--) {
            const ry_axis *const a = &file->axis[axis];
            const int k = file->sampling == RY_SAMPLING_LIST ? point : rest % a->n;
            rest /= a->n;
            char *const text = strdup(a->value[k]);
            file->value[point * file->n_axes + axis] = text;
            if (text == NULL) {
                return 0;
            }
        }
    }
    return 1;
}

ry_status ry_sweep_points_make(ry_sweep_file *file, ry_error *error)
{
    for (int k = 0; k < file->n_axes; k++) {
        if (file->axis[k].is_range && file->axis[k].steps > 0) {
            RY_TRY(list_range(&file->axis[k], error));
        }
    }
    RY_TRY(count_points(file, error));
    const size_t n = (size_t)file->n_points * (size_t)file->n_axes;
    file->value = calloc(n + 1, sizeof *file->value);
    if (file->value == NULL || !(file->samples > 0 ? fill_drawn(file) : fill_listed(file))) {
        return ry_no_memory(error, n * sizeof *file->value);
    }
    return RY_OK;
}

char *ry_sweep_points_describe(const ry_axis *axis)
{
    if (axis->is_range) {
        return ry_text_print("%.12g to %.12g, %d steps, %s", axis->from, axis->to, axis->steps,
                             axis->logarithmic ? "log" : "linear");
    }
    char *text = strdup("");
    for (int k = 0; k < axis->n && text != NULL; k++) {
        char *const longer = ry_text_print("%s%s%s", text, k > 0 ? ", " : "", axis->value[k]);
        free(text);
        text = longer;
    }
    return text;
}
