/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Rows that are collected in memory and appended to the file together: the frames, the profiles and
 * the samples of the series. A column is an H5MD element PATH/{step,time,value}; all columns of a
 * table share one step and one time array (hard links). */
#ifndef RY_IO_TABLE_H
#define RY_IO_TABLE_H

#include "io/h5.h"

enum { RY_TABLE_COLUMNS = 24 };

typedef struct ry_table_column {
    const char *path; /* of the element */
    const char *unit, *text;
    ry_h5_shape row;    /* size[0] unused, then the directions of one row */
    size_t item, width; /* bytes of a number; numbers in a row */
    void *data;         /* the rows not yet in the file */
    size_t capacity;    /* bytes */
} ry_table_column;

typedef struct ry_table {
    ry_table_column column[RY_TABLE_COLUMNS];
    int n_columns;
    int made;      /* its arrays are in the file */
    int64_t *step; /* of the rows not yet in the file */
    double *time;  /* [s] */
    size_t step_capacity, time_capacity;
    int64_t rows;      /* not yet in the file */
    int64_t last_step; /* of the last row; -1: none */
    int64_t expected;  /* rows of the whole run, as far as known */
} ry_table;

void ry_table_init(ry_table *table, int64_t expected);
void ry_table_free(ry_table *table);

/* A column whose row has `rank` (0..2) directions. */
void ry_table_add(ry_table *table, const char *path, const char *unit, const char *text, hid_t type,
                  int rank, int64_t size0, int64_t size1);

/* Begins a row: 1; 0 if there is a row of this step already; -1 without memory. */
int ry_table_begin(ry_table *table, int64_t step, double time);
/* Where the numbers of the row just begun belong. */
void *ry_table_cell(ry_table *table, int column);

size_t ry_table_bytes(const ry_table *table);
/* Appends the rows to the file, making the arrays first; 0 or -1. The rows stay until
 * ry_table_clear, for the commit may fail. */
int ry_table_append(ry_table *table, const ry_h5 *file);
void ry_table_clear(ry_table *table);

/* Gives the rows of a table, not yet in the file, to an empty one that has been made by this call before,
 * or is zero; and takes the memory of its last rows in return. */
void ry_table_hand_over(ry_table *from, ry_table *to);

/* Cuts the rows behind `step` from the file and takes the table up from there; 0 or -1. */
int ry_table_resume(ry_table *table, hid_t file, int64_t step);

#endif
