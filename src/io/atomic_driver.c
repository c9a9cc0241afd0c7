/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What HDF5 calls to read and write an atomic file: a virtual file driver. */
#include <stdlib.h>
#include <string.h>

#include "io/atomic.h"

/* What HDF5 knows as an open file. */
typedef struct driver_file {
    H5FD_t base; /* must come first */
    ry_atomic *file;
    haddr_t end; /* of what HDF5 has allocated */
} driver_file;

typedef struct driver_info {
    ry_atomic *file;
} driver_info;

static H5FD_t *driver_open(const char *name, unsigned flags, hid_t access, haddr_t last)
{
    (void)name;
    (void)last;
    const driver_info *const info = H5Pget_driver_info(access);
    driver_file *const opened = info != NULL ? calloc(1, sizeof *opened) : NULL;
    if (opened == NULL) {
        return NULL;
    }
    opened->file = info->file;
    if ((flags & H5F_ACC_TRUNC) != 0) {
        ry_atomic_set_size(info->file, 0);
    }
    return &opened->base;
}

static herr_t driver_close(H5FD_t *base)
{
    free(base);
    return 0;
}

static int driver_compare(const H5FD_t *a, const H5FD_t *b)
{
    const ry_atomic *const left = ((const driver_file *)a)->file;
    const ry_atomic *const right = ((const driver_file *)b)->file;
    return (left > right) - (left < right);
}

static herr_t driver_query(const H5FD_t *base, unsigned long *flags)
{
    (void)base;
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

static haddr_t driver_get_end(const H5FD_t *base, H5FD_mem_t type)
{
    (void)type;
    return ((const driver_file *)base)->end;
}

static herr_t driver_set_end(H5FD_t *base, H5FD_mem_t type, haddr_t end)
{
    (void)type;
    ((driver_file *)base)->end = end;
    return 0;
}

static haddr_t driver_get_size(const H5FD_t *base, H5FD_mem_t type)
{
    (void)type;
    return ry_atomic_size(((const driver_file *)base)->file);
}

/* A heap of texts as HDF5 lays it out: 16 bytes of head ("GCOL", version, size), then objects with as much each
 * (number, 0: what is free; size). HDF5 1.10 believes their sizes: it never ends with one of 0, of a lost sector,
 * and reads beyond the heap with one that is too large. Numbers of a result don't begin so. */
static int is_broken_heap(const unsigned char *bytes, size_t size)
{
    enum { HEAD = 16 };
    static const unsigned char begin[8] = {'G', 'C', 'O', 'L', 1};
    uint64_t heap, object;
    uint16_t number;
    if (size < HEAD || memcmp(bytes, begin, sizeof begin) != 0) {
        return 0;
    }
    memcpy(&heap, bytes + 8, sizeof heap); /* little-endian, as is all that we run on */
    for (uint64_t at = HEAD; at + HEAD <= heap && at + HEAD <= size; at += object) {
        memcpy(&number, bytes + at, sizeof number);
        memcpy(&object, bytes + at + 8, sizeof object);
        if (object > heap - at) {
            return 1;
        }
        object = number > 0 ? HEAD + (object + 7) / 8 * 8 : object;
        if (object < HEAD || object > heap - at) {
            return 1;
        }
    }
    return 0;
}

static herr_t driver_read(H5FD_t *base, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t size,
                          void *buffer)
{
    (void)type;
    (void)transfer;
    return ry_atomic_read(((driver_file *)base)->file, buffer, size, at) != 0 || is_broken_heap(buffer, size) ? -1 : 0;
}

static herr_t driver_write(H5FD_t *base, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t size,
                           const void *buffer)
{
    (void)type;
    (void)transfer;
    return ry_atomic_write(((driver_file *)base)->file, buffer, size, at);
}

static herr_t driver_truncate(H5FD_t *base, hid_t transfer, hbool_t closing)
{
    (void)transfer;
    (void)closing;
    driver_file *const opened = (driver_file *)base;
    ry_atomic_set_size(opened->file, opened->end);
    return 0;
}

static const H5FD_class_t driver = {
    .name = "ryusa",
    .maxaddr = (haddr_t)INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(driver_info),
    .open = driver_open,
    .close = driver_close,
    .cmp = driver_compare,
    .query = driver_query,
    .get_eoa = driver_get_end,
    .set_eoa = driver_set_end,
    .get_eof = driver_get_size,
    .read = driver_read,
    .write = driver_write,
    .truncate = driver_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

hid_t ry_atomic_set_access(hid_t access, ry_atomic *file)
{
    /* A driver is registered once per opening: a handle kept in a static variable would dangle after
     * a program's own H5close. */
    const driver_info info = {file};
    const hid_t id = H5FDregister(&driver);
    if (id >= 0 && H5Pset_driver(access, id, &info) < 0) {
        H5FDunregister(id);
        return -1;
    }
    return id;
}
