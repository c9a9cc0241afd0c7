/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "config/csv.h"

#include <string.h>

#include "config/yaml.h"

static int is_around(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '"';
}

/* Cuts the cell that ends before `end` out of the text. */
static char *cut(char *begin, char *end)
{
    while (begin < end && is_around(*begin)) {
        begin++;
    }
    while (end > begin && is_around(end[-1])) {
        end--;
    }
    *end = '\0';
    return begin;
}

/* How many cells the line has; those beyond the widest row are counted only. */
static int cut_line(ry_csv *csv, char *line)
{
    int n = 0;
    for (char *comma = line; comma != NULL; n++) {
        comma = strchr(line, ',');
        char *const end = comma != NULL ? comma : line + strlen(line);
        if (n < RY_CSV_WIDEST) {
            csv->cell[n] = cut(line, end);
        }
        line = end + 1;
    }
    return n;
}

/* The next line with something in it; NULL: there is none. */
static char *next_line(ry_csv *csv)
{
    while (csv->rest != NULL) {
        char *const line = csv->rest, *const end = strchr(line, '\n');
        csv->rest = end != NULL ? end + 1 : NULL;
        csv->place.line++;
        if (end != NULL) {
            *end = '\0';
        }
        const char first = line[strspn(line, " \t\r")];
        if (first != '\0' && first != '#') {
            return line;
        }
    }
    csv->place.line = 0; /* the file as a whole */
    return NULL;
}

ry_status ry_csv_open(ry_csv *csv, char *text, const char *name, ry_error *error)
{
    *csv = (ry_csv){.place = {.name = name}, .rest = text};
    if (strncmp(text, "\xEF\xBB\xBF", 3) == 0) { /* spreadsheets begin so */
        csv->rest += 3;
    }
    if (!ry_yaml_is_utf8(text)) {
        return ry_place_fail(csv->place, NULL, error, "not a text file (UTF-8); a table is CSV text");
    }
    char *const line = next_line(csv);
    csv->width = line != NULL ? cut_line(csv, line) : 0;
    if (csv->width > RY_CSV_WIDEST) {
        return ry_place_fail(csv->place, NULL, error, "%d columns; at most %d are allowed", csv->width, RY_CSV_WIDEST);
    }
    return RY_OK;
}

ry_status ry_csv_next(ry_csv *csv, int *found, ry_error *error)
{
    char *const line = next_line(csv);
    *found = line != NULL;
    const int width = line != NULL ? cut_line(csv, line) : csv->width;
    if (width != csv->width) {
        return ry_place_fail(csv->place, NULL, error, "%d columns, but the header has %d", width, csv->width);
    }
    return RY_OK;
}

size_t ry_csv_left(const ry_csv *csv)
{
    size_t lines = 0;
    for (const char *line = csv->rest; line != NULL;) {
        const char *const end = strchr(line, '\n');
        lines += end != line;
        line = end != NULL ? end + 1 : NULL;
    }
    return lines;
}
