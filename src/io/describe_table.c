/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa info` of what ry_table_file writes: the cases of a sweep in words, of the other commands' files
 * each array with its range. What isn't there isn't told. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/result_private.h"

enum { MOST_FAILURES = 10, MOST_POINTS = 40, MOST_WORDS = 20 };

typedef struct page {
    ry_write_fn *write;
    void *data;
    hid_t file;
} page;

#define say(to, ...) ry_text_say((to)->write, (to)->data, __VA_ARGS__)

/* --- what is read --- */

static int length(const page *of, const char *path)
{
    ry_h5_shape shape;
    return ry_h5_exists(of->file, path) && ry_h5_get_shape(of->file, path, &shape) == 0 &&
                   shape.rank == 1
               ? (int)shape.size[0]
               : 0;
}

/* n numbers; NULL if they aren't there. The caller frees them. */
static double *numbers(const page *of, const char *path, int n)
{
    double *const value = n > 0 && length(of, path) == n ? calloc((size_t)n, sizeof *value) : NULL;
    if (value != NULL && ry_h5_read(of->file, path, H5T_NATIVE_DOUBLE, (hsize_t)n, value) != 0) {
        free(value);
        return NULL;
    }
    return value;
}

static void free_texts(char **text, int n)
{
    for (int k = 0; k < n && text != NULL; k++) {
        H5free_memory(text[k]);
    }
    free(text);
}

/* n texts; NULL if they aren't there. */
static char **texts(const page *of, const char *path, int n)
{
    char **const value = n > 0 && length(of, path) == n ? calloc((size_t)n, sizeof *value) : NULL;
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    const int bad = value != NULL && ry_h5_read(of->file, path, type, (hsize_t)n, value) != 0;
    H5Tclose(type);
    if (bad) {
        free(value);
        return NULL;
    }
    return value;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the numbers that are finite to the front, without repetitions; how many these are. */
static int sort_distinct(double *value, int n)
{
    int finite = 0, distinct = 0;
    for (int k = 0; k < n; k++) {
        if (isfinite(value[k])) {
            value[finite++] = value[k];
        }
    }
    qsort(value, (size_t)finite, sizeof *value, compare);
    for (int k = 0; k < finite; k++) {
        if (k == 0 || value[k] != value[distinct - 1]) {
            value[distinct++] = value[k];
        }
    }
    return distinct;
}

/* --- what is told --- */

static void tell_text(const page *to, const char *label, const char *name)
{
    char *text = NULL;
    if (ry_h5_get_text(to->file, "/", name, &text) == 0 && text[0] != '\0') {
        say(to, "%-14s %s\n", label, text);
    }
    free(text);
}

static void tell_cases(const page *to, const double *status, int n)
{
    int done = 0, failed = 0, missing = 0;
    for (int k = 0; k < n; k++) {
        done += status[k] == 0.0;
        failed += status[k] > 0.0;
        missing += status[k] < 0.0;
    }
    say(to, "%-14s %d: %d done, %d failed, %d missing\n", "cases", n, done, failed, missing);
}

static void tell_words(const page *to, const char *key, char *const *word, int n)
{
    int distinct = 0;
    say(to, "  %-22s", key);
    for (int k = 0; k < n; k++) {
        int is_new = word[k] != NULL && word[k][0] != '\0';
        for (int i = 0; i < k && is_new; i++) {
            is_new = word[i] == NULL || strcmp(word[i], word[k]) != 0;
        }
        distinct += is_new;
        if (is_new && distinct <= MOST_WORDS) {
            say(to, "%s %s", distinct > 1 ? "," : "", word[k]);
        }
    }
    say(to, distinct > MOST_WORDS ? ", and more\n" : "\n");
}

static void tell_numbers(const page *to, const char *key, const char *path, double *value, int n)
{
    char *unit = NULL;
    const int distinct = sort_distinct(value, n);
    const int has_unit =
        ry_h5_get_text(to->file, path, "unit", &unit) == 0 && strcmp(unit, "1") != 0;
    if (distinct > 0) {
        say(to, "  %-22s %.6g to %.6g%s%s, %d values\n", key, value[0], value[distinct - 1],
            has_unit ? " " : "", has_unit ? unit : "", distinct);
    }
    free(unit);
}

/* Each key that was varied, in the order of the sweep file. */
static void tell_inputs(const page *to, int n)
{
    char *keys = NULL;
    if (ry_h5_get_text(to->file, "/", "varied", &keys) != 0) {
        return;
    }
    say(to, "varied\n");
    for (char *rest = keys, *key; (key = strsep(&rest, ",")) != NULL;) {
        char path[160];
        snprintf(path, sizeof path, "inputs/%s", key);
        double *const value = numbers(to, path, n);
        char **const word = value == NULL ? texts(to, path, n) : NULL;
        if (value != NULL) {
            tell_numbers(to, key, path, value, n);
        } else if (word != NULL) {
            tell_words(to, key, word, n);
        }
        free(value);
        free_texts(word, n);
    }
    free(keys);
}

/* Of the cases that are done. */
static void tell_range(const page *to, const char *label, const char *path, const double *status,
                       int n, const char *unit)
{
    double *const value = numbers(to, path, n);
    for (int k = 0; k < n && value != NULL; k++) {
        value[k] = status[k] == 0.0 ? value[k] : NAN;
    }
    const int distinct = value != NULL ? sort_distinct(value, n) : 0;
    if (distinct > 0) {
        say(to, "%-14s %.4g to %.4g%s\n", label, value[0], value[distinct - 1], unit);
    }
    free(value);
}

static void tell_cost(const page *to, int n)
{
    double *const wall = numbers(to, "cases/wall_seconds", n);
    double sum = 0.0;
    for (int k = 0; k < n && wall != NULL; k++) {
        sum += isfinite(wall[k]) ? wall[k] : 0.0;
    }
    if (wall != NULL) {
        say(to, "%-14s %.4g s of wall time, all cases together\n", "cost", sum);
    }
    free(wall);
}

static void tell_points(const page *to)
{
    const int n = length(to, "points/q_star");
    double *const theta = numbers(to, "points/shields", n);
    double *const q = numbers(to, "points/q_star", n);
    double *const error = numbers(to, "points/q_star_standard_error", n);
    double *const first = numbers(to, "points/first_case", n);
    double *const done = numbers(to, "points/replicas", n);
    if (theta != NULL && q != NULL && error != NULL && first != NULL && done != NULL) {
        say(to, "\npoints\n  %10s %10s %12s %12s %10s\n", "first case", "theta", "q*", "+-",
            "replicas");
        for (int k = 0; k < n && k < MOST_POINTS; k++) {
            say(to, "  %10.0f %10.4g %12.4g %12.2g %10.0f\n", first[k], theta[k], q[k], error[k],
                done[k]);
        }
        if (n > MOST_POINTS) {
            say(to, "  ... and %d more\n", n - MOST_POINTS);
        }
    }
    free(theta);
    free(q);
    free(error);
    free(first);
    free(done);
}

static void tell_failures(const page *to, const double *status, int n)
{
    char **const changes = texts(to, "cases/changes", n);
    char **const message = texts(to, "cases/message", n);
    int failed = 0;
    for (int k = 0; k < n; k++) {
        if (status[k] <= 0.0 || ++failed > MOST_FAILURES) {
            continue;
        }
        say(to, "%s  case %d (%.150s), status %.0f: %.500s\n", failed == 1 ? "\nfailed\n" : "",
            k + 1, changes != NULL ? changes[k] : "", status[k], message != NULL ? message[k] : "");
    }
    if (failed > MOST_FAILURES) {
        say(to, "  ... and %d more, in /cases/message\n", failed - MOST_FAILURES);
    }
    free_texts(changes, n);
    free_texts(message, n);
}

static void tell_sweep(const page *to, double *status, int n)
{
    double replicas = 1.0;
    ry_h5_get_number(to->file, "/", "replicas", &replicas);
    tell_cases(to, status, n);
    say(to, "%-14s %d, each with %.0f replica%s\n", "points", length(to, "points/q_star"), replicas,
        replicas > 1.0 ? "s" : "");
    tell_text(to, "sample", "sample");
    tell_inputs(to, n);
    tell_range(to, "q*", "cases/q_star", status, n, "");
    tell_range(to, "  its error", "cases/q_star_standard_error", status, n, "");
    tell_cost(to, n);
    tell_points(to);
    tell_failures(to, status, n);
}

/* Of a file that isn't a sweep's: an array a line. */
static herr_t tell_array(hid_t file, const char *path, const H5L_info_t *info, void *data)
{
    const page *const to = data;
    const int n = info->type == H5L_TYPE_HARD ? length(to, path) : 0;
    double *const value = numbers(to, path, n);
    char *text = NULL, *unit = NULL;
    if (n > 0) {
        const int distinct = value != NULL ? sort_distinct(value, n) : 0;
        ry_h5_get_text(file, path, "description", &text);
        ry_h5_get_text(file, path, "unit", &unit);
        say(to, "  %-36s %5d", path, n);
        if (distinct > 0) {
            say(to, "  %.5g to %.5g%s%s", value[0], value[distinct - 1],
                unit != NULL && strcmp(unit, "1") != 0 ? " " : "",
                unit != NULL && strcmp(unit, "1") != 0 ? unit : "");
        }
        say(to, "%s%s\n", text != NULL ? "  " : "", text != NULL ? text : "");
    }
    free(value);
    free(text);
    free(unit);
    return 0;
}

int ry_table_is_ours(hid_t file)
{
    char *program = NULL;
    const int ours =
        ry_h5_get_text(file, "/", "program", &program) == 0 && strncmp(program, "ryusa ", 6) == 0;
    free(program);
    return ours;
}

void ry_table_describe(hid_t file, const char *path, ry_write_fn *write, void *data)
{
    page to = {write, data, file};
    say(&to, "%-14s %s\n", "file", path);
    tell_text(&to, "table of", "program");
    tell_text(&to, "version", "version");
    tell_text(&to, "title", "title");
    const int n = length(&to, "cases/status");
    double *const status = numbers(&to, "cases/status", n);
    if (status != NULL && ry_h5_exists(file, "points")) {
        tell_sweep(&to, status, n);
    } else {
        say(&to, "arrays\n");
        H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, tell_array, &to);
    }
    free(status);
}
