/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Explicit grains from a table: the entry {file: grains.csv} of the list `particles`. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "config/csv.h"
#include "config/nearest.h"
#include "config/quantity.h"
#include "config/reader.h"

enum { LARGEST = 1 << 30 }; /* bytes of a table: some ten million grains */

typedef struct table {
    ry_csv csv;
    ry_error *error;
    int which[RY_CSV_WIDEST];    /* number of a particle in each column */
    double scale[RY_CSV_WIDEST]; /* its unit in SI; 0: each cell may name one */
    double low[RY_PARTICLE_NUMBERS], high[RY_PARTICLE_NUMBERS];
    int seen[RY_PARTICLE_NUMBERS];
} table;

#define FAIL(t, path, ...) ry_place_fail((t)->csv.place, path, (t)->error, __VA_ARGS__)
#define COLUMNS "x and z, and as wanted vx, vz, spin, diameter, density, fixed"

/* --- the first line: x [mm], z [mm], diameter ----------------------------------------------------- */

static int find(const char *name)
{
    int which = 0;
    while (which < RY_PARTICLE_NUMBERS && strcmp(name, ry_particle_names[which]) != 0) {
        which++;
    }
    return which;
}

/* Cuts the unit in brackets off; *unit "": there is none. */
static ry_status split(const table *t, char *cell, const char **unit)
{
    char *const open = strchr(cell, '[');
    *unit = "";
    if (open == NULL) {
        return RY_OK;
    }
    const size_t length = strlen(open);
    if (open[length - 1] != ']' || length < 3) {
        return FAIL(t, NULL, "'%s' is no column; a unit stands in brackets, as in x [mm]", ry_place_quote(cell).text);
    }
    open[length - 1] = '\0';
    *unit = open + 1;
    *open = '\0';
    cell[strcspn(cell, " \t")] = '\0';
    return RY_OK;
}

static ry_status read_column(table *t, int at)
{
    char *const name = t->csv.cell[at];
    const char *unit;
    RY_TRY(split(t, name, &unit));
    const int which = find(name);
    if (which == RY_PARTICLE_NUMBERS) {
        const char *const near = ry_nearest_word(name, ry_particle_names);
        return FAIL(t, NULL, "unknown column '%s'; %s%s%sthe first line names the columns: " COLUMNS,
                    ry_place_quote(name).text, near ? "did you mean " : "", near ? near : "", near ? "? " : "");
    }
    if (t->seen[which]++) {
        return FAIL(t, NULL, "two columns are named %s", name);
    }
    t->which[at] = which;
    if (unit[0] != '\0') {
        char one[100], problem[400];
        (void)snprintf(one, sizeof one, "1 %.90s", unit);
        if (!ry_quantity_read(one, ry_particle_units[which], &t->scale[at], problem, sizeof problem)) {
            return FAIL(t, name, "%s", problem);
        }
    }
    ry_particle_range(which, &t->low[which], &t->high[which]);
    return RY_OK;
}

static ry_status read_header(table *t)
{
    for (int at = 0; at < t->csv.width; at++) {
        RY_TRY(read_column(t, at));
    }
    if (!t->seen[RY_PARTICLE_X] || !t->seen[RY_PARTICLE_Z]) {
        return FAIL(t, NULL, "no column %s; the first line names the columns: " COLUMNS,
                    t->seen[RY_PARTICLE_X] ? "z" : "x");
    }
    return RY_OK;
}

/* --- the rows ------------------------------------------------------------------------------------- */

/* true and false may stand for 1 and 0. */
static const char *as_number(int which, const char *cell)
{
    const int is_word = which == RY_PARTICLE_FIXED && (strcmp(cell, "true") == 0 || strcmp(cell, "false") == 0);
    return !is_word ? cell : cell[0] == 't' ? "1" : "0";
}

static ry_status read_cell(const table *t, int at, ry_particle *grain)
{
    const int which = t->which[at], scaled = t->scale[at] > 0.0;
    const char *const name = ry_particle_names[which], *const unit = ry_particle_units[which];
    const char *const cell = as_number(which, t->csv.cell[at]);
    char problem[400];
    double value;
    if (cell[0] == '\0') {
        return FAIL(t, name, "nothing where a number belongs");
    }
    if (!ry_quantity_read(cell, scaled ? "1" : unit, &value, problem, sizeof problem)) {
        return FAIL(t, name, "%s", problem);
    }
    value *= scaled ? t->scale[at] : 1.0;
    const int is_flag = which == RY_PARTICLE_FIXED;
    if (value < t->low[which] || value > t->high[which] || (is_flag && value != floor(value))) {
        return is_flag ? FAIL(t, name, "%s is not allowed; 0, 1, true or false is", ry_place_quote(cell).text)
                       : FAIL(t, name, "%s is out of range; allowed is %g to %g %s", ry_place_quote(cell).text,
                              t->low[which], t->high[which], unit);
    }
    ry_particle_set(grain, which, value);
    return RY_OK;
}

static ry_status read_rows(table *t, ry_config *config, size_t *capacity, ry_particle like)
{
    int found = 1;
    const int before = config->n_particles;
    const size_t n = (size_t)before;
    RY_TRY(ry_array_grow(&config->particles, capacity, n, n + ry_csv_left(&t->csv), sizeof like, t->error));
    while (found) {
        RY_TRY(ry_csv_next(&t->csv, &found, t->error));
        if (!found) {
            break;
        }
        ry_particle *const grain = &config->particles[config->n_particles++];
        *grain = like;
        grain->line = t->csv.place.line;
        for (int at = 0; at < t->csv.width; at++) {
            RY_TRY(read_cell(t, at, grain));
        }
    }
    return config->n_particles > before ? RY_OK
                                        : FAIL(t, NULL, "no rows; a line with the names of the columns is needed (" COLUMNS
                                                        "), and one for each grain");
}

/* --- the file ------------------------------------------------------------------------------------- */

/* A path that is not absolute begins in the scene's folder. */
static char *beside(const char *scene, const char *path)
{
    const char *const slash = strrchr(scene, '/');
    const int folder = slash != NULL && path[0] != '/' ? (int)(slash - scene) + 1 : 0;
    return ry_text_print("%.*s%s", folder, scene, path);
}

/* Keeps the name for messages; it is tables[like->table - 1] then. */
static ry_status add_name(ry_config *config, const char *path, ry_particle *like, ry_error *error)
{
    char **const grown = realloc(config->tables, ((size_t)config->n_tables + 1) * sizeof *grown);
    if (grown == NULL) {
        return ry_no_memory(error, sizeof *grown);
    }
    config->tables = grown;
    grown[config->n_tables] = beside(config->path, path);
    if (grown[config->n_tables] == NULL) {
        return ry_no_memory(error, strlen(path));
    }
    like->table = ++config->n_tables;
    return RY_OK;
}

ry_status ry_particle_table_read(const ry_reader *reader, const char *path, ry_particle like, size_t *capacity)
{
    ry_config *const config = reader->config;
    RY_TRY(add_name(config, path, &like, reader->error));
    const char *const name = config->tables[like.table - 1];
    char *text = NULL;
    ry_error own = {0};
    if (ry_text_read(name, LARGEST, "a table of particles", &text, &own) != RY_OK) {
        return ry_fail(reader->error, own.status, "%.300s:%d: particles: %s", config->path, like.line, own.text);
    }
    table t = {.error = reader->error};
    ry_status status = ry_csv_open(&t.csv, text, name, reader->error);
    if (status == RY_OK) {
        status = read_header(&t);
    }
    if (status == RY_OK) {
        status = read_rows(&t, config, capacity, like);
    }
    free(text);
    return status;
}
