/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a study leaves: one HDF5 file of named arrays in groups, with attributes. It is OUT.h5.part
 * until it is finished, and appears as OUT.h5 whole or not at all. The calls that fill it return
 * nothing: the first failure is kept and reported by ry_table_file_finish. */
#ifndef RY_IO_TABLE_FILE_H
#define RY_IO_TABLE_FILE_H

#include <stdint.h>

#include "ryusa/status.h"

typedef struct ry_table_file ry_table_file;

/* `program`: what makes it ("ryusa verify"), an attribute of the file beside its version. RY_BAD_FILE
 * if OUT.h5 can't be made, is being made by another process, or exists and `force` is 0. */
ry_status ry_table_file_create(ry_table_file **file, const char *path, const char *program,
                               int force, ry_error *error);

/* Only checks that OUT.h5 could be made, and that it isn't there unless `force`: before long work. */
ry_status ry_table_file_check(const char *path, int force, ry_error *error);

/* 1: the file is there and `program` has made it. _says: and this attribute of its root is this text. */
int ry_table_file_is(const char *path, const char *program);
int ry_table_file_says(const char *path, const char *attribute, const char *text);

/* Arrays; `path` is GROUP/.../NAME below the root, groups are made as they are named. unit as in a
 * scene file, "1" for a number; text: what it is. */
void ry_table_file_numbers(ry_table_file *file, const char *path, const char *unit,
                           const char *text, int64_t n, const double *values);
void ry_table_file_texts(ry_table_file *file, const char *path, const char *text, int64_t n,
                         const char *const *values);

/* Attributes of the array or group `path` ("/": the file); a group is made if it isn't there. */
void ry_table_file_set_number(ry_table_file *file, const char *path, const char *name,
                              double value);
void ry_table_file_set_text(ry_table_file *file, const char *path, const char *name,
                            const char *value);

/* `path` in this file becomes the root of the file `other`, named as seen from this file's folder. */
void ry_table_file_link(ry_table_file *file, const char *path, const char *other);

/* Renames to OUT.h5 and frees; on failure OUT.h5 is as it was before. */
ry_status ry_table_file_finish(ry_table_file *file, ry_error *error);
/* Frees, and leaves nothing behind. */
void ry_table_file_discard(ry_table_file *file);

#endif
