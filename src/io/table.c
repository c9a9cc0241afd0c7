/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "io/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

void ry_table_init(ry_table *table, int64_t expected)
{
    *table = (ry_table){.last_step = -1, .expected = expected};
}

void ry_table_free(ry_table *table)
{
    for (int k = 0; k < table->n_columns; ++k) {
        free(table->column[k].data);
    }
    free(table->step);
    free(table->time);
    ry_table_init(table, 0);
}

void ry_table_add(ry_table *table, const char *path, const char *unit, const char *text, hid_t type,
                  int rank, int64_t size0, int64_t size1)
{
    ry_table_column *const column = &table->column[table->n_columns++];
    *column = (ry_table_column){.path = path, .unit = unit, .text = text};
    column->row = (ry_h5_shape){type, rank + 1, {0, (hsize_t)size0, (hsize_t)size1}};
    column->item = H5Tget_size(type);
    column->width = (rank > 0 ? (size_t)size0 : 1) * (rank > 1 ? (size_t)size1 : 1);
}

int ry_table_begin(ry_table *table, int64_t step, double time)
{
    if (step <= table->last_step) {
        return 0;
    }
    const size_t rows = (size_t)table->rows;
    if (ry_array_grow(&table->step, &table->step_capacity, rows, rows + 1, sizeof step, NULL) ||
        ry_array_grow(&table->time, &table->time_capacity, rows, rows + 1, sizeof time, NULL)) {
        return -1;
    }
    for (int k = 0; k < table->n_columns; ++k) {
        ry_table_column *const column = &table->column[k];
        const size_t bytes = column->item * column->width;
        if (ry_array_grow(&column->data, &column->capacity, rows * bytes, (rows + 1) * bytes, 1,
                          NULL) != RY_OK) {
            return -1;
        }
    }
    table->step[rows] = step;
    table->time[rows] = time;
    table->last_step = step;
    ++table->rows;
    return 1;
}

void *ry_table_cell(ry_table *table, int column)
{
    ry_table_column *const of = &table->column[column];
    return (char *)of->data + (size_t)(table->rows - 1) * of->item * of->width;
}

size_t ry_table_bytes(const ry_table *table)
{
    size_t bytes = sizeof(int64_t) + sizeof(double);
    for (int k = 0; k < table->n_columns; ++k) {
        bytes += table->column[k].item * table->column[k].width;
    }
    return bytes * (size_t)table->rows;
}

typedef struct name {
    char text[200];
} name;

static name join(const char *path, const char *last)
{
    name joined;
    snprintf(joined.text, sizeof joined.text, "%s/%s", path, last);
    return joined;
}

/* --- to the file --- */

/* Short series share few chunks with rows to come, long runs don't fill the index. */
static hsize_t rows_per_chunk(const ry_table *table)
{
    const int64_t most = 2048, least = 16;
    const int64_t rows = table->expected < least ? least : table->expected;
    return (hsize_t)(rows > most ? most : rows);
}

static int make_shared(const ry_table *table, hid_t file, const char *last, hid_t type)
{
    const ry_h5_shape row = {type, 1, {0}};
    return ry_h5_make_rows(file, join(table->column[0].path, last).text, &row,
                           rows_per_chunk(table));
}

static int make_column(const ry_table *table, hid_t file, int k)
{
    const ry_table_column *const column = &table->column[k];
    const char *const home = table->column[0].path;
    const name value = join(column->path, "value");
    if (ry_h5_make_rows(file, value.text, &column->row, rows_per_chunk(table)) != 0 ||
        ry_h5_set_unit(file, value.text, column->unit) != 0 ||
        ry_h5_set_text(file, value.text, "description", column->text) != 0) {
        return -1;
    }
    if (k == 0) {
        return 0;
    }
    return ry_h5_link(file, join(home, "step").text, join(column->path, "step").text) != 0 ||
                   ry_h5_link(file, join(home, "time").text, join(column->path, "time").text) != 0
               ? -1
               : 0;
}

static int make_arrays(ry_table *table, hid_t file)
{
    if (make_shared(table, file, "step", H5T_NATIVE_INT64) != 0 ||
        make_shared(table, file, "time", H5T_NATIVE_DOUBLE) != 0 ||
        ry_h5_set_unit(file, join(table->column[0].path, "time").text, "s") != 0) {
        return -1;
    }
    for (int k = 0; k < table->n_columns; ++k) {
        if (make_column(table, file, k) != 0) {
            return -1;
        }
    }
    return 0;
}

int ry_table_append(ry_table *table, const ry_h5 *file)
{
    if (table->n_columns == 0) {
        return 0;
    }
    if (!table->made && make_arrays(table, file->id) != 0) {
        return -1;
    }
    const hsize_t rows = (hsize_t)table->rows;
    const char *const home = table->column[0].path;
    if (rows > 0 && (ry_h5_append(file->id, join(home, "step").text, H5T_NATIVE_INT64, rows,
                                  table->step) != 0 ||
                     ry_h5_append(file->id, join(home, "time").text, H5T_NATIVE_DOUBLE, rows,
                                  table->time) != 0)) {
        return -1;
    }
    for (int k = 0; rows > 0 && k < table->n_columns; ++k) {
        const ry_table_column *const column = &table->column[k];
        if (ry_h5_append(file->id, join(column->path, "value").text, column->row.type, rows,
                         column->data) != 0 ||
            ry_atomic_error(file->atomic) != 0) {
            return -1;
        }
    }
    return 0;
}

void ry_table_clear(ry_table *table)
{
    table->rows = 0;
    table->made = table->n_columns > 0;
}

static void swap_columns(ry_table_column *from, ry_table_column *to)
{
    const ry_table_column given = *from;
    from->data = to->data;
    from->capacity = to->capacity;
    *to = given;
}

void ry_table_hand_over(ry_table *from, ry_table *to)
{
    const ry_table given = *from, taken = *to;
    for (int k = 0; k < from->n_columns; ++k) {
        swap_columns(&from->column[k], &to->column[k]);
    }
    from->step = taken.step;
    from->time = taken.time;
    from->step_capacity = taken.step_capacity;
    from->time_capacity = taken.time_capacity;
    from->rows = 0;
    to->n_columns = given.n_columns;
    to->made = given.made || taken.made;
    to->step = given.step;
    to->time = given.time;
    to->step_capacity = given.step_capacity;
    to->time_capacity = given.time_capacity;
    to->rows = given.rows;
    to->last_step = given.last_step;
    to->expected = given.expected;
}

/* --- back from the file --- */

static int64_t count_until(const int64_t *steps, int64_t n, int64_t step)
{
    int64_t count = 0;
    while (count < n && steps[count] <= step) {
        ++count;
    }
    return count;
}

static int cut_all(const ry_table *table, hid_t file, int64_t rows)
{
    const char *const home = table->column[0].path;
    int failed = ry_h5_cut(file, join(home, "step").text, (hsize_t)rows) != 0 ||
                 ry_h5_cut(file, join(home, "time").text, (hsize_t)rows) != 0;
    for (int k = 0; k < table->n_columns && !failed; ++k) {
        failed = ry_h5_cut(file, join(table->column[k].path, "value").text, (hsize_t)rows) != 0;
    }
    return failed ? -1 : 0;
}

int ry_table_resume(ry_table *table, hid_t file, int64_t step)
{
    ry_h5_shape shape;
    if (table->n_columns == 0) {
        return 0;
    }
    const name steps = join(table->column[0].path, "step");
    if (ry_h5_get_shape(file, steps.text, &shape) != 0 || shape.rank != 1) {
        return -1;
    }
    int64_t *const found = ry_array((size_t)shape.size[0] + 1, sizeof *found);
    int64_t rows = -1;
    if (found != NULL && (shape.size[0] == 0 || ry_h5_read(file, steps.text, H5T_NATIVE_INT64,
                                                           shape.size[0], found) == 0)) {
        rows = count_until(found, (int64_t)shape.size[0], step);
        table->last_step = rows > 0 ? found[rows - 1] : -1;
    }
    free(found);
    table->made = 1;
    return rows >= 0 ? cut_all(table, file, rows) : -1;
}
