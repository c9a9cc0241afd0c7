/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "analysis/target.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/memory.h"
#include "base/text.h"
#include "config/csv.h"
#include "config/nearest.h"
#include "config/quantity.h"

enum { LARGEST = 16 << 20, MOST_RELATIONS = 64 };
enum { THETA, Q_STAR, ERROR_, COLUMNS };
static const char *const column_words[COLUMNS] = {"theta", "q_star", "error"};

typedef struct table {
    ry_target *target;
    ry_error *error;
    ry_csv csv;
    int column[COLUMNS]; /* where each stands in a row; -1: nowhere */
    size_t capacity[COLUMNS];
} table;

static ry_status read_header(table *t)
{
    for (int c = 0; c < t->csv.width; c++) {
        for (int k = 0; k < COLUMNS; k++) {
            if (strcmp(t->csv.cell[c], column_words[k]) != 0) {
                continue;
            }
            if (t->column[k] >= 0) {
                return ry_place_fail(t->csv.place, NULL, t->error, "two columns are named %s",
                                     column_words[k]);
            }
            t->column[k] = c;
        }
    }
    if (t->csv.width > 0 && (t->column[THETA] < 0 || t->column[Q_STAR] < 0)) {
        return ry_place_fail(t->csv.place, NULL, t->error,
                             "no column %s; the first line names the columns: theta,q_star or "
                             "theta,q_star,error",
                             column_words[t->column[THETA] < 0 ? THETA : Q_STAR]);
    }
    return RY_OK;
}

static ry_status read_number(const table *t, int k, const char *cell, double *value)
{
    char problem[400];
    if (cell[0] == '\0') {
        return ry_place_fail(t->csv.place, column_words[k], t->error, "nothing where a number belongs");
    }
    if (!ry_quantity_read(cell, "1", value, problem, sizeof problem)) {
        return ry_place_fail(t->csv.place, column_words[k], t->error, "%s", problem);
    }
    if (*value < 0.0 || (k == THETA && *value == 0.0)) {
        return ry_place_fail(t->csv.place, column_words[k], t->error, "%s is not allowed; %s is", cell,
                             k == THETA ? "a number above 0" : "0 or more");
    }
    return RY_OK;
}

static ry_status keep_row(table *t, const double value[COLUMNS])
{
    ry_target *const g = t->target;
    double **const array[COLUMNS] = {&g->theta, &g->q_star, &g->error};
    const size_t n = (size_t)g->n;
    if (n > 0 && value[THETA] <= g->theta[n - 1]) {
        return ry_place_fail(t->csv.place, "theta", t->error,
                             "%g does not lie above %g of the row before; sort the rows by theta, "
                             "and give each theta once",
                             value[THETA], g->theta[n - 1]);
    }
    for (int k = 0; k < COLUMNS; k++) {
        if (t->column[k] >= 0) {
            RY_TRY(ry_array_grow(array[k], &t->capacity[k], n, n + 1, sizeof(double), t->error));
            (*array[k])[n] = value[k];
        }
    }
    g->n++;
    return RY_OK;
}

static ry_status read_row(table *t)
{
    double value[COLUMNS] = {0};
    for (int k = 0; k < COLUMNS; k++) {
        if (t->column[k] >= 0) {
            RY_TRY(read_number(t, k, t->csv.cell[t->column[k]], &value[k]));
        }
    }
    return keep_row(t, value);
}

static ry_status read_table(table *t, char *text)
{
    int found = 1;
    RY_TRY(ry_csv_open(&t->csv, text, t->target->name, t->error));
    RY_TRY(read_header(t));
    while (found) {
        RY_TRY(ry_csv_next(&t->csv, &found, t->error));
        RY_TRY(found ? read_row(t) : RY_OK);
    }
    return t->target->n > 0 ? RY_OK
                            : ry_place_fail(t->csv.place, NULL, t->error,
                                            "no points; it needs a header theta,q_star and at least one row");
}

ry_status ry_target_parse(ry_target *target, const char *text, const char *name, ry_error *error)
{
    *target = (ry_target){.name = strdup(name)};
    table t = {.target = target, .error = error, .column = {-1, -1, -1}};
    char *const copy = strdup(text);
    const ry_status status =
        copy == NULL || target->name == NULL ? ry_no_memory(error, strlen(text)) : read_table(&t, copy);
    free(copy);
    if (status != RY_OK) {
        ry_target_free(target);
    }
    return status;
}

static ry_status unknown(const char *name, ry_error *error)
{
    const char *keys[MOST_RELATIONS + 1] = {0};
    char list[1000] = "";
    for (int k = 0; k < ry_relation_count() && k < MOST_RELATIONS; k++) {
        const size_t used = strlen(list);
        keys[k] = ry_relation_at(k)->key;
        snprintf(list + used, sizeof list - used, "%s%s", k > 0 ? ", " : "", keys[k]);
    }
    const char *const near = ry_nearest_word(name, keys);
    return ry_fail(error, RY_BAD_INPUT,
                   "'%s' is no relation and no file; %s%s%srelations: %s; or a CSV file with the "
                   "columns theta,q_star",
                   ry_place_quote(name).text, near != NULL ? "did you mean " : "",
                   near != NULL ? near : "", near != NULL ? "? " : "", list);
}

ry_status ry_target_open(ry_target *target, const char *name, ry_error *error)
{
    const ry_relation *const relation = ry_relation_find(name);
    struct stat info;
    *target = (ry_target){0};
    if (relation != NULL) {
        *target = (ry_target){.name = strdup(name), .relation = relation};
        return target->name != NULL ? RY_OK : ry_no_memory(error, strlen(name));
    }
    if (stat(name, &info) != 0 && errno == ENOENT && strchr(name, '/') == NULL &&
        strstr(name, ".csv") == NULL) {
        return unknown(name, error);
    }
    char *text = NULL;
    ry_status status = ry_text_read(name, LARGEST, "a table", &text, error);
    if (status == RY_OK) {
        status = ry_target_parse(target, text, name, error);
    }
    free(text);
    return status;
}

void ry_target_free(ry_target *target)
{
    free(target->name);
    free(target->theta);
    free(target->q_star);
    free(target->error);
    *target = (ry_target){0};
}

/* --- values ------------------------------------------------------------------------------------- */

/* The point at or below theta, and how far theta is on the way to the next one; 0: outside. */
static int locate(const ry_target *target, double theta, int *point, double *share)
{
    const int last = target->n - 1;
    if (!(theta >= target->theta[0] && theta <= target->theta[last])) {
        return 0;
    }
    int k = 0;
    while (k < last && target->theta[k + 1] <= theta) {
        k++;
    }
    *point = k;
    *share =
        k < last ? (theta - target->theta[k]) / (target->theta[k + 1] - target->theta[k]) : 0.0;
    return 1;
}

double ry_target_flux(const ry_target *target, double theta)
{
    int k;
    double share;
    if (target->relation != NULL) {
        return ry_relation_flux(target->relation, theta);
    }
    if (!locate(target, theta, &k, &share)) {
        return NAN;
    }
    const double q0 = target->q_star[k];
    if (share == 0.0) {
        return q0;
    }
    const double q1 = target->q_star[k + 1];
    if (q0 > 0.0 && q1 > 0.0) {
        const double way =
            log(theta / target->theta[k]) / log(target->theta[k + 1] / target->theta[k]);
        return q0 * pow(q1 / q0, way);
    }
    return q0 + share * (q1 - q0);
}

double ry_target_error(const ry_target *target, double theta)
{
    int k;
    double share;
    if (target->relation != NULL || target->error == NULL || !locate(target, theta, &k, &share)) {
        return NAN;
    }
    const double next = share > 0.0 ? target->error[k + 1] : target->error[k];
    return target->error[k] + share * (next - target->error[k]);
}

void ry_target_range(const ry_target *target, double *low, double *high)
{
    *low = target->relation != NULL ? 0.0 : target->theta[0];
    *high = target->relation != NULL ? INFINITY : target->theta[target->n - 1];
}
