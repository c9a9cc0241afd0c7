/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The few things that a result file needs of HDF5: groups, attributes, whole arrays, and arrays that
 * grow by rows. Names are paths below `at`. All calls return 0, or -1 on failure; ids are closed on
 * every way out. Files are opened through io/atomic.h. */
#ifndef RY_IO_H5_H
#define RY_IO_H5_H

#include <hdf5.h>
#include <stdint.h>

#include "io/atomic.h"
#include "ryusa/status.h"

typedef struct ry_h5 {
    hid_t id, driver;
    ry_atomic *atomic;
    const char *path; /* for messages; the caller's */
    H5E_auto2_t
        printer; /* what printed HDF5's own errors before: they are off while a file is open */
    void *printer_data;
} ry_h5;

typedef enum { RY_H5_READ, RY_H5_CHANGE, RY_H5_CREATE } ry_h5_mode;

/* RY_BAD_FILE with path and reason. `fd` as in ry_atomic_open, -1 to read. */
ry_status ry_h5_open(ry_h5 *file, const char *path, int fd, ry_h5_mode mode, ry_error *error);
/* Commits unless `failed`; then, or if the commit fails, reports that `doing` did not work. */
ry_status ry_h5_close(ry_h5 *file, int failed, const char *doing, ry_error *error);

/* An array: number type in the file and in memory, and how many items along each direction. */
typedef struct ry_h5_shape {
    hid_t type;
    int rank;
    hsize_t size[3];
} ry_h5_shape;

int ry_h5_exists(hid_t at, const char *path);
int ry_h5_make_group(hid_t at, const char *path);
int ry_h5_link(hid_t at, const char *from, const char *to);

/* Attributes of the object `path`; an existing one is overwritten. */
int ry_h5_set_number(hid_t at, const char *path, const char *name, double value);
int ry_h5_set_integer(hid_t at, const char *path, const char *name, int64_t value);
int ry_h5_set_text(hid_t at, const char *path, const char *name, const char *value);
/* The attribute `unit`, "kg/m^3" spelled as H5MD wants it: "kg m-3". */
int ry_h5_set_unit(hid_t at, const char *path, const char *unit);
int ry_h5_set_numbers(hid_t at, const char *path, const char *name, hid_t type, int n,
                      const void *values);
int ry_h5_set_texts(hid_t at, const char *path, const char *name, int n, const char *const *values);
int ry_h5_get_number(hid_t at, const char *path, const char *name, double *value);
int ry_h5_get_integer(hid_t at, const char *path, const char *name, int64_t *value);
/* The caller frees *value. */
int ry_h5_get_text(hid_t at, const char *path, const char *name, char **value);

/* Whole arrays, stored in one piece. An existing array must have this shape. */
int ry_h5_write(hid_t at, const char *path, const ry_h5_shape *shape, const void *data);
int ry_h5_read(hid_t at, const char *path, hid_t type, hsize_t items, void *data);
int ry_h5_write_text(hid_t at, const char *path, const char *text);
int ry_h5_read_text(hid_t at, const char *path, char **text);

/* Shape of an array; rank -1 and failure if it isn't there or has more than three directions. */
int ry_h5_get_shape(hid_t at, const char *path, ry_h5_shape *shape);

/* Arrays of rows: size[0] is 0 at first and `rows_per_chunk` tells how they are stored. */
int ry_h5_make_rows(hid_t at, const char *path, const ry_h5_shape *row, hsize_t rows_per_chunk);
int ry_h5_append(hid_t at, const char *path, hid_t type, hsize_t rows, const void *data);
int ry_h5_read_rows(hid_t at, const char *path, hid_t type, hsize_t first, hsize_t rows,
                    void *data);
int ry_h5_cut(hid_t at, const char *path, hsize_t rows);

#endif
