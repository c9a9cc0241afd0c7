/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "io/table_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/link.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/result_private.h"

struct ry_table_file {
    char *path, *part; /* OUT.h5, OUT.h5.part */
    int fd;            /* of part: holds the lock as long as it is open */
    int replace;       /* OUT.h5 may be overwritten at the end */
    int failed;
    ry_h5 h5;
};

static void release(ry_table_file *file)
{
    if (file->fd >= 0) {
        close(file->fd);
    }
    free(file->path);
    free(file->part);
    free(file);
}

static void remove_part(const ry_table_file *file)
{
    if (ry_lock_check_name(file->fd, file->part, NULL) != RY_OK) {
        return; /* another's by now */
    }
    unlink(file->part);
    ry_atomic_forget_journal(file->part);
}

static ry_status begin(ry_table_file *file, ry_error *error)
{
    RY_TRY(ry_lock_check_path(file->part, error));
    RY_TRY(ry_lock_open(file->part, 1, &file->fd, error));
    ry_atomic_forget_journal(file->part);
    ry_status status = RY_OK;
    if (ftruncate(file->fd, 0) != 0) {
        status = ry_fail(error, RY_BAD_FILE, "%s: %s", file->part, strerror(errno));
    } else {
        status = ry_h5_open(&file->h5, file->part, file->fd, RY_H5_CREATE, error);
    }
    if (status != RY_OK) {
        remove_part(file);
    }
    return status;
}

ry_status ry_table_file_check(const char *path, int force, ry_error *error)
{
    char *target = NULL;
    RY_TRY(ry_link_follow(path, &target, error));
    ry_status status = ry_lock_check_path(target, error);
    if (status == RY_OK && !force && access(target, F_OK) == 0) {
        status = ry_fail(error, RY_BAD_FILE, "%s: exists; --force overwrites it", path);
    }
    free(target);
    return status;
}

ry_status ry_table_file_create(ry_table_file **file, const char *path, const char *program,
                               int force, ry_error *error)
{
    *file = NULL;
    RY_TRY(ry_table_file_check(path, force, error));
    ry_table_file *const made = calloc(1, sizeof *made);
    if (made == NULL) {
        return ry_no_memory(error, sizeof *made);
    }
    *made = (ry_table_file){.fd = -1, .replace = force};
    ry_status status = ry_link_follow(path, &made->path, error);
    if (status == RY_OK) {
        made->part = ry_text_print("%s.part", made->path);
        status = made->part == NULL ? ry_no_memory(error, strlen(path)) : begin(made, error);
    }
    if (status != RY_OK) {
        release(made);
        return status;
    }
    *file = made;
    ry_table_file_set_text(made, "/", "program", program);
    ry_table_file_set_text(made, "/", "version", RY_VERSION);
    return RY_OK;
}

int ry_table_file_says(const char *path, const char *attribute, const char *text)
{
    ry_h5 file;
    char *found = NULL;
    if (ry_h5_open(&file, path, -1, RY_H5_READ, NULL) != RY_OK) {
        return 0;
    }
    const int says = ry_h5_get_text(file.id, "/", attribute, &found) == 0 && strcmp(found, text) == 0;
    free(found);
    ry_h5_close(&file, 1, "", NULL);
    return says;
}

int ry_table_file_is(const char *path, const char *program)
{
    return ry_table_file_says(path, "program", program);
}

/* --- filling it --- */

static void note(ry_table_file *file, int failure)
{
    file->failed = file->failed || failure != 0;
}

void ry_table_file_numbers(ry_table_file *file, const char *path, const char *unit,
                           const char *text, int64_t n, const double *values)
{
    const ry_h5_shape shape = {H5T_NATIVE_DOUBLE, 1, {(hsize_t)n}};
    note(file, ry_h5_write(file->h5.id, path, &shape, values));
    note(file, ry_h5_set_unit(file->h5.id, path, unit));
    note(file, ry_h5_set_text(file->h5.id, path, "description", text));
}

void ry_table_file_texts(ry_table_file *file, const char *path, const char *text, int64_t n,
                         const char *const *values)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    const ry_h5_shape shape = {type, 1, {(hsize_t)n}};
    note(file, ry_h5_write(file->h5.id, path, &shape, values));
    note(file, ry_h5_set_text(file->h5.id, path, "description", text));
    H5Tclose(type);
}

void ry_table_file_link(ry_table_file *file, const char *path, const char *other)
{
    const hid_t list = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(list, 1);
    note(file, H5Lcreate_external(other, "/", file->h5.id, path, list, H5P_DEFAULT) < 0);
    H5Pclose(list);
}

static void need_object(ry_table_file *file, const char *path)
{
    if (strcmp(path, "/") != 0) {
        note(file, ry_h5_make_group(file->h5.id, path));
    }
}

void ry_table_file_set_number(ry_table_file *file, const char *path, const char *name, double value)
{
    need_object(file, path);
    note(file, ry_h5_set_number(file->h5.id, path, name, value));
}

void ry_table_file_set_text(ry_table_file *file, const char *path, const char *name,
                            const char *value)
{
    need_object(file, path);
    note(file, ry_h5_set_text(file->h5.id, path, name, value));
}

/* --- its end --- */

static ry_status rename_part(const ry_table_file *file, ry_error *error)
{
    if (!file->replace && access(file->path, F_OK) == 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: was made by someone else meanwhile", file->path);
    }
    if (rename(file->part, file->path) != 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be renamed to %s: %s", file->part, file->path,
                       strerror(errno));
    }
    return RY_OK;
}

ry_status ry_table_file_finish(ry_table_file *file, ry_error *error)
{
    ry_status status = ry_h5_close(&file->h5, file->failed, "write it", error);
    if (status == RY_OK) {
        status = ry_lock_check_name(file->fd, file->part, error);
    }
    if (status == RY_OK) {
        status = rename_part(file, error);
    }
    if (status != RY_OK) {
        remove_part(file);
    }
    release(file);
    return status;
}

void ry_table_file_discard(ry_table_file *file)
{
    if (file != NULL) {
        ry_h5_close(&file->h5, 1, "", NULL);
        remove_part(file);
        release(file);
    }
}
