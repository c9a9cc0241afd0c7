/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Arrays of a result file. Nothing is compressed. Tried shuffle with deflate 1: trajectories of a bed
 * take half the room but 25 times as long to write, and each flush would rewrite the last chunk at
 * another place of the file; h5repack does it better at the end. */
#include <stdlib.h>
#include <string.h>

#include "io/h5.h"

static hid_t make_dataset(hid_t at, const char *path, hid_t type, hid_t space, hid_t creation)
{
    const hid_t parents = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(parents, 1);
    const hid_t dataset = H5Dcreate2(at, path, type, space, parents, creation, H5P_DEFAULT);
    H5Pclose(parents);
    return dataset;
}

static int write_whole(hid_t dataset, hid_t type, const void *data)
{
    if (dataset < 0) {
        return -1;
    }
    const int written = H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    H5Dclose(dataset);
    return written < 0 ? -1 : 0;
}

static hid_t make_whole(hid_t at, const char *path, const ry_h5_shape *shape)
{
    const hid_t space =
        shape->rank > 0 ? H5Screate_simple(shape->rank, shape->size, NULL) : H5Screate(H5S_SCALAR);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (H5Tis_variable_str(shape->type) <= 0) {
        H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
    }
    const hid_t dataset = make_dataset(at, path, shape->type, space, creation);
    H5Pclose(creation);
    H5Sclose(space);
    return dataset;
}

int ry_h5_write(hid_t at, const char *path, const ry_h5_shape *shape, const void *data)
{
    if (!ry_h5_exists(at, path)) {
        return write_whole(make_whole(at, path, shape), shape->type, data);
    }
    ry_h5_shape found;
    if (ry_h5_get_shape(at, path, &found) != 0 || found.rank != shape->rank ||
        memcmp(found.size, shape->size, (size_t)shape->rank * sizeof shape->size[0]) != 0) {
        return -1;
    }
    return write_whole(H5Dopen2(at, path, H5P_DEFAULT), shape->type, data);
}

int ry_h5_get_shape(hid_t at, const char *path, ry_h5_shape *shape)
{
    *shape = (ry_h5_shape){.type = -1, .rank = -1};
    if (!ry_h5_exists(at, path)) {
        return -1;
    }
    const hid_t dataset = H5Dopen2(at, path, H5P_DEFAULT);
    if (dataset < 0) {
        return -1;
    }
    const hid_t space = H5Dget_space(dataset);
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank >= 0 && rank <= 3) {
        shape->rank = rank;
        H5Sget_simple_extent_dims(space, shape->size, NULL);
    }
    H5Sclose(space);
    H5Dclose(dataset);
    return shape->rank >= 0 ? 0 : -1;
}

int ry_h5_read(hid_t at, const char *path, hid_t type, hsize_t items, void *data)
{
    ry_h5_shape shape;
    if (ry_h5_get_shape(at, path, &shape) != 0) {
        return -1;
    }
    hsize_t found = 1;
    for (int k = 0; k < shape.rank; ++k) {
        found *= shape.size[k];
    }
    if (found != items) {
        return -1;
    }
    const hid_t dataset = H5Dopen2(at, path, H5P_DEFAULT);
    const int read = H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    H5Dclose(dataset);
    return read < 0 ? -1 : 0;
}

static hid_t long_text_type(void)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

int ry_h5_write_text(hid_t at, const char *path, const char *text)
{
    const ry_h5_shape shape = {.type = long_text_type(), .rank = 0};
    const int written = ry_h5_write(at, path, &shape, &text);
    H5Tclose(shape.type);
    return written;
}

int ry_h5_read_text(hid_t at, const char *path, char **text)
{
    char *found = NULL;
    const hid_t type = long_text_type();
    const int read = ry_h5_read(at, path, type, 1, &found);
    H5Tclose(type);
    *text = read == 0 && found != NULL ? strdup(found) : NULL;
    H5free_memory(found);
    return *text != NULL ? 0 : -1;
}

/* --- rows --- */

/* A chunk is read and rewritten as a whole, and HDF5 keeps up to 1 MiB of chunks per array. */
enum { CHUNK_BYTES = 1 << 18 };

static void choose_chunk(const ry_h5_shape *row, hsize_t rows, hsize_t chunk[3])
{
    hsize_t bytes = H5Tget_size(row->type);
    memcpy(chunk, row->size, 3 * sizeof *chunk);
    for (int k = 1; k < row->rank; ++k) {
        bytes *= row->size[k];
    }
    const hsize_t fit = bytes > 0 ? CHUNK_BYTES / bytes : 1;
    chunk[0] = rows < fit ? rows : fit;
    if (chunk[0] == 0) {
        chunk[0] = 1;
    }
    while (bytes > 4 * CHUNK_BYTES && chunk[1] > 1) {
        chunk[1] = (chunk[1] + 1) / 2;
        bytes /= 2;
    }
}

int ry_h5_make_rows(hid_t at, const char *path, const ry_h5_shape *row, hsize_t rows_per_chunk)
{
    hsize_t size[3], most[3], chunk[3];
    memcpy(size, row->size, sizeof size);
    memcpy(most, row->size, sizeof most);
    size[0] = 0;
    most[0] = H5S_UNLIMITED;
    choose_chunk(row, rows_per_chunk, chunk);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    const hid_t space = H5Screate_simple(row->rank, size, most);
    hid_t dataset = -1;
    if (H5Pset_chunk(creation, row->rank, chunk) >= 0) {
        dataset = make_dataset(at, path, row->type, space, creation);
    }
    H5Sclose(space);
    H5Pclose(creation);
    return dataset >= 0 ? H5Dclose(dataset) : -1;
}

/* Moves rows first .. first + rows - 1 between memory and an open array that has them. */
static int move_rows(hid_t dataset, hid_t type, hsize_t first, hsize_t rows, void *to,
                     const void *from)
{
    hsize_t start[3] = {first, 0, 0}, count[3];
    const hid_t space = H5Dget_space(dataset);
    const int rank = H5Sget_simple_extent_dims(space, count, NULL);
    const int inside = rank > 0 && first + rows <= count[0];
    count[0] = rows;
    int moved = -1;
    if (inside && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0) {
        const hid_t memory = H5Screate_simple(rank, count, NULL);
        moved = to != NULL ? H5Dread(dataset, type, memory, space, H5P_DEFAULT, to)
                           : H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, from);
        H5Sclose(memory);
    }
    H5Sclose(space);
    return moved < 0 ? -1 : 0;
}

static int set_rows(hid_t dataset, const ry_h5_shape *shape, hsize_t rows)
{
    hsize_t size[3];
    memcpy(size, shape->size, sizeof size);
    size[0] = rows;
    return H5Dset_extent(dataset, size) < 0 ? -1 : 0;
}

int ry_h5_append(hid_t at, const char *path, hid_t type, hsize_t rows, const void *data)
{
    ry_h5_shape shape;
    if (ry_h5_get_shape(at, path, &shape) != 0 || shape.rank < 1) {
        return -1;
    }
    const hid_t dataset = H5Dopen2(at, path, H5P_DEFAULT);
    int done = set_rows(dataset, &shape, shape.size[0] + rows);
    if (done == 0) {
        done = move_rows(dataset, type, shape.size[0], rows, NULL, data);
    }
    return H5Dclose(dataset) < 0 ? -1 : done;
}

int ry_h5_read_rows(hid_t at, const char *path, hid_t type, hsize_t first, hsize_t rows, void *data)
{
    if (!ry_h5_exists(at, path)) {
        return -1;
    }
    const hid_t dataset = H5Dopen2(at, path, H5P_DEFAULT);
    const int done = dataset >= 0 ? move_rows(dataset, type, first, rows, data, NULL) : -1;
    H5Dclose(dataset);
    return done;
}

int ry_h5_cut(hid_t at, const char *path, hsize_t rows)
{
    ry_h5_shape shape;
    if (ry_h5_get_shape(at, path, &shape) != 0 || shape.rank < 1 || shape.size[0] < rows) {
        return -1;
    }
    if (shape.size[0] == rows) {
        return 0;
    }
    const hid_t dataset = H5Dopen2(at, path, H5P_DEFAULT);
    const int done = set_rows(dataset, &shape, rows);
    return H5Dclose(dataset) < 0 ? -1 : done;
}
