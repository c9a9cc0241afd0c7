/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Tables as text: cells between commas, blanks and quotes around them ignored, the first line names the columns;
 * empty lines and those that begin with # are skipped. */
#ifndef RY_CONFIG_CSV_H
#define RY_CONFIG_CSV_H

#include <stddef.h>

#include "config/place.h"

enum { RY_CSV_WIDEST = 64 }; /* columns */

typedef struct ry_csv {
    char *cell[RY_CSV_WIDEST]; /* of the current line, in the text */
    int width;                 /* columns, as the first line has them */
    ry_place place;            /* of the current line */
    char *rest;                /* what follows it; NULL: nothing */
} ry_csv;

/* Begins with the names of the columns: `csv->cell`, 0 of them if the text holds no line. `text` is cut to pieces
 * and must live as long as the cells. RY_BAD_INPUT: it is no text (UTF-8), or has too many columns. */
ry_status ry_csv_open(ry_csv *csv, char *text, const char *name, ry_error *error);

/* The next row; *found 0: there is none. RY_BAD_INPUT: it has more or fewer cells than there are columns. */
ry_status ry_csv_next(ry_csv *csv, int *found, ry_error *error);

/* Lines with something in them that follow the current one: no fewer than rows. */
size_t ry_csv_left(const ry_csv *csv);

#endif
