/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Opening and closing, groups and attributes; arrays are in h5_array.c. The file format is the oldest
 * that HDF5 writes (its default), which every reader knows. Texts have variable length and are UTF-8:
 * h5py hands them out as str. */
#include "io/h5.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static void silence(ry_h5 *file)
{
    H5open();
    H5Eget_auto2(H5E_DEFAULT, &file->printer, &file->printer_data);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

static void unsilence(const ry_h5 *file)
{
    H5Eclear2(H5E_DEFAULT);
    H5Eset_auto2(H5E_DEFAULT, file->printer, file->printer_data);
}

static hid_t open_hdf5(ry_h5 *file, ry_h5_mode mode)
{
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    hid_t id = -1;
    file->driver = access >= 0 ? ry_atomic_set_access(access, file->atomic) : -1;
    if (file->driver >= 0 && H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) >= 0) {
        id =
            mode == RY_H5_CREATE
                ? H5Fcreate(file->path, H5F_ACC_TRUNC, H5P_DEFAULT, access)
                : H5Fopen(file->path, mode == RY_H5_CHANGE ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access);
    }
    H5Pclose(access);
    return id;
}

static void forget_driver(ry_h5 *file)
{
    if (file->driver >= 0) {
        H5FDunregister(file->driver);
        file->driver = -1;
    }
}

ry_status ry_h5_open(ry_h5 *file, const char *path, int fd, ry_h5_mode mode, ry_error *error)
{
    *file = (ry_h5){.id = -1, .driver = -1, .path = path};
    file->atomic = ry_atomic_open(path, fd);
    if (file->atomic == NULL) {
        return ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(errno));
    }
    if (mode != RY_H5_CREATE && ry_atomic_looks_like_hdf5(file->atomic) != 1) {
        const int unborn = ry_atomic_looks_like_hdf5(file->atomic) == 0;
        ry_atomic_close(file->atomic);
        return ry_fail(error, RY_BAD_FILE, unborn ? "%s: empty" : "%s: not an HDF5 file", path);
    }
    silence(file);
    file->id = open_hdf5(file, mode);
    if (file->id >= 0) {
        return RY_OK;
    }
    const int failure = ry_atomic_error(file->atomic);
    forget_driver(file);
    unsilence(file);
    ry_atomic_close(file->atomic);
    return ry_fail(error, RY_BAD_FILE, "%s: %s", path,
                   failure != 0 ? strerror(failure) : "damaged: HDF5 can't open it");
}

ry_status ry_h5_close(ry_h5 *file, int failed, const char *doing, ry_error *error)
{
    failed = H5Fclose(file->id) < 0 || failed != 0;
    forget_driver(file);
    unsilence(file);
    int failure = ry_atomic_error(file->atomic);
    if (!failed && failure == 0) {
        failure = ry_atomic_commit(file->atomic);
    }
    ry_atomic_close(file->atomic);
    file->id = -1;
    if (!failed && failure == 0) {
        return RY_OK;
    }
    return ry_fail(error, RY_BAD_FILE, "%s: can't %s: %s", file->path, doing,
                   failure != 0 ? strerror(failure)
                                : "the file is damaged, something is missing in it, or memory ran out");
}

/* --- groups --- */

int ry_h5_exists(hid_t at, const char *path)
{
    /* H5Lexists wants every step of a path to exist. */
    char head[256];
    for (size_t k = 1; k < sizeof head; ++k) {
        if (path[k] == '/' || path[k] == '\0') {
            memcpy(head, path, k);
            head[k] = '\0';
            if (H5Lexists(at, head, H5P_DEFAULT) <= 0) {
                return 0;
            }
        }
        if (path[k] == '\0') {
            return 1;
        }
    }
    return 0;
}

static hid_t with_parents(void)
{
    const hid_t list = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(list, 1);
    return list;
}

int ry_h5_make_group(hid_t at, const char *path)
{
    if (ry_h5_exists(at, path)) {
        return 0;
    }
    const hid_t list = with_parents();
    const hid_t group = H5Gcreate2(at, path, list, H5P_DEFAULT, H5P_DEFAULT);
    H5Pclose(list);
    return group >= 0 ? H5Gclose(group) : -1;
}

int ry_h5_link(hid_t at, const char *from, const char *to)
{
    const hid_t list = with_parents();
    const int made = H5Lcreate_hard(at, from, at, to, list, H5P_DEFAULT);
    H5Pclose(list);
    return made < 0 ? -1 : 0;
}

/* --- attributes --- */

static hid_t text_type(void)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

/* Through the object: HDF5 1.10 can't write an attribute that H5Aopen_by_name has opened. */
static hid_t make_attribute(hid_t at, const char *path, const char *name, hid_t type, hid_t space)
{
    const hid_t object = H5Oopen(at, path, H5P_DEFAULT);
    if (object < 0) {
        return -1;
    }
    const hid_t attribute = H5Aexists(object, name) > 0
                                ? H5Aopen(object, name, H5P_DEFAULT)
                                : H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Oclose(object);
    return attribute;
}

/* n = 0: a scalar. */
static int set_attribute(hid_t at, const char *path, const char *name, hid_t type, int n,
                         const void *values)
{
    const hsize_t size = (hsize_t)n;
    const hid_t space = n > 0 ? H5Screate_simple(1, &size, NULL) : H5Screate(H5S_SCALAR);
    const hid_t attribute = make_attribute(at, path, name, type, space);
    H5Sclose(space);
    if (attribute < 0) {
        return -1;
    }
    const int written = H5Awrite(attribute, type, values);
    H5Aclose(attribute);
    return written < 0 ? -1 : 0;
}

int ry_h5_set_number(hid_t at, const char *path, const char *name, double value)
{
    return set_attribute(at, path, name, H5T_NATIVE_DOUBLE, 0, &value);
}

int ry_h5_set_integer(hid_t at, const char *path, const char *name, int64_t value)
{
    return set_attribute(at, path, name, H5T_NATIVE_INT64, 0, &value);
}

int ry_h5_set_numbers(hid_t at, const char *path, const char *name, hid_t type, int n,
                      const void *values)
{
    return set_attribute(at, path, name, type, n, values);
}

int ry_h5_set_texts(hid_t at, const char *path, const char *name, int n, const char *const *values)
{
    const hid_t type = text_type();
    const int set = set_attribute(at, path, name, type, n, values);
    H5Tclose(type);
    return set;
}

int ry_h5_set_text(hid_t at, const char *path, const char *name, const char *value)
{
    /* HDF5 never reuses the room of a text, so an equal one is left alone. */
    char *old = NULL;
    if (ry_h5_get_text(at, path, name, &old) == 0) {
        const int same = strcmp(old, value) == 0;
        free(old);
        if (same) {
            return 0;
        }
    }
    return ry_h5_set_texts(at, path, name, 0, &value);
}

int ry_h5_set_unit(hid_t at, const char *path, const char *unit)
{
    char text[40];
    size_t used = 0;
    int inverse = 0, power = 0;
    for (const char *from = unit; used + 4 < sizeof text; ++from) {
        if (inverse && !power && (*from == '\0' || *from == ' ' || *from == '^')) {
            text[used++] = '-';
            if (*from != '^') {
                text[used++] = '1';
            }
        }
        power = power || *from == '^';
        if (*from == '/' || *from == ' ') {
            inverse = *from == '/';
            power = 0;
            text[used++] = ' ';
        } else if (*from != '^') {
            text[used++] = *from;
        }
        if (*from == '\0') {
            return ry_h5_set_text(at, path, "unit", text);
        }
    }
    return -1;
}

static int get_attribute(hid_t at, const char *path, const char *name, hid_t type, void *value)
{
    if (H5Aexists_by_name(at, path, name, H5P_DEFAULT) <= 0) {
        return -1;
    }
    const hid_t attribute = H5Aopen_by_name(at, path, name, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0) {
        return -1;
    }
    const hid_t space = H5Aget_space(attribute);
    const int one = H5Sget_simple_extent_npoints(space) == 1;
    H5Sclose(space);
    const int read = one ? H5Aread(attribute, type, value) : -1;
    H5Aclose(attribute);
    return read < 0 ? -1 : 0;
}

int ry_h5_get_number(hid_t at, const char *path, const char *name, double *value)
{
    return get_attribute(at, path, name, H5T_NATIVE_DOUBLE, value);
}

int ry_h5_get_integer(hid_t at, const char *path, const char *name, int64_t *value)
{
    return get_attribute(at, path, name, H5T_NATIVE_INT64, value);
}

int ry_h5_get_text(hid_t at, const char *path, const char *name, char **value)
{
    char *text = NULL;
    const hid_t type = text_type();
    const int read = get_attribute(at, path, name, type, &text);
    H5Tclose(type);
    *value = read == 0 && text != NULL ? strdup(text) : NULL;
    H5free_memory(text);
    return *value != NULL ? 0 : -1;
}
