/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Small text files, read and written whole. */
#ifndef RY_BASE_TEXT_H
#define RY_BASE_TEXT_H

#include <stddef.h>

#include "ryusa/status.h"

/* The file as a string that the caller frees; NULL on failure. RY_BAD_FILE if it can't be read,
 * RY_BAD_INPUT if it is larger than `largest` bytes or has NUL bytes in it, "not `what`" ("a table"). */
ry_status ry_text_read(const char *path, size_t largest, const char *what, char **text,
                       ry_error *error);

/* Writes under another name, then renames: the file (where a link leads to) holds the old text or the new one. */
ry_status ry_text_write(const char *path, const char *text, ry_error *error);

/* Letters of a name without the ending ".h5", if it has it: for "%.*s". */
int ry_text_stem(const char *path);

/* printf into a string of its own, which the caller frees; NULL without memory. */
char *ry_text_print(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* printf to `write`, of a length without limit; NULL: nobody listens. */
void ry_text_say(void (*write)(void *data, const char *text), void *data, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
