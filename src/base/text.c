/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/text.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/link.h"
#include "base/memory.h"

enum { MOST_PARTS = 1000 };

static ry_status read_stream(FILE *file, const char *path, size_t largest, const char *what,
                             char **text, ry_error *error)
{
    struct stat info = {0};
    if (fstat(fileno(file), &info) == 0 && S_ISDIR(info.st_mode)) {
        return ry_fail(error, RY_BAD_FILE, "%s: a folder, not %s", path, what);
    }
    /* What has no size of its own (a pipe) may be as large as is allowed. */
    const int is_small = S_ISREG(info.st_mode) && info.st_size > 0 && (size_t)info.st_size < largest;
    const size_t room = is_small ? (size_t)info.st_size : largest;
    *text = malloc(room + 2);
    if (*text == NULL) {
        return ry_no_memory(error, room);
    }
    const size_t length = fread(*text, 1, room + 1, file);
    if (ferror(file)) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be read: %s", path, strerror(errno));
    }
    if (length > room && is_small) {
        return ry_fail(error, RY_BAD_FILE, "%s: was written to while it was read", path);
    }
    if (length > room) {
        return ry_fail(error, RY_BAD_INPUT, "%s: larger than %zu MiB; not %s", path, largest >> 20,
                       what);
    }
    (*text)[length] = '\0';
    if (strlen(*text) != length) {
        return ry_fail(error, RY_BAD_INPUT, "%s: not a text file (it has NUL bytes); not %s", path,
                       what);
    }
    return RY_OK;
}

ry_status ry_text_read(const char *path, size_t largest, const char *what, char **text,
                       ry_error *error)
{
    *text = NULL;
    FILE *const file = fopen(path, "rb");
    if (file == NULL) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be opened: %s", path, strerror(errno));
    }
    const ry_status status = read_stream(file, path, largest, what, text, error);
    fclose(file);
    if (status != RY_OK) {
        free(*text);
        *text = NULL;
    }
    return status;
}

/* Opens "PATH.NUMBER.part", which nobody else has: not a thread of ours, nor a process of that number on another machine,
 * living or killed. *part is NULL without memory. */
static FILE *open_part(const char *path, char **part)
{
    FILE *file = NULL;
    for (int k = 0; file == NULL && k < MOST_PARTS; k++) {
        *part = k == 0 ? ry_text_print("%s.%ld.part", path, (long)getpid())
                       : ry_text_print("%s.%ld%03d.part", path, (long)getpid(), k);
        file = *part != NULL ? fopen(*part, "wbx") : NULL;
        if (*part == NULL || (file == NULL && errno != EEXIST) || k + 1 == MOST_PARTS) {
            break;
        }
        if (file == NULL) {
            free(*part);
        }
    }
    return file;
}

ry_status ry_text_write(const char *path, const char *text, ry_error *error)
{
    char *target = NULL, *part = NULL;
    ry_status status = ry_link_follow(path, &target, error);
    FILE *const file = status == RY_OK ? open_part(target, &part) : NULL;
    if (part == NULL) {
        free(target);
        return status == RY_OK ? ry_no_memory(error, strlen(path)) : status;
    }
    int failed = file == NULL || fputs(text, file) < 0;
    if (file != NULL) {
        failed = fflush(file) != 0 || fsync(fileno(file)) != 0 || failed;
        failed = fclose(file) != 0 || failed;
    }
    if (failed || rename(part, target) != 0) {
        status = ry_fail(error, RY_BAD_FILE, "%s: can't be written: %s", path, strerror(errno));
        if (file != NULL) {
            unlink(part);
        }
    }
    free(part);
    free(target);
    return status;
}

int ry_text_stem(const char *path)
{
    const size_t length = strlen(path);
    return (int)(length > 3 && strcmp(path + length - 3, ".h5") == 0 ? length - 3 : length);
}

__attribute__((format(printf, 1, 0))) static char *print(const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(NULL, 0, format, arguments);
    char *const text = length >= 0 ? malloc((size_t)length + 1) : NULL;
    if (text != NULL) {
        vsnprintf(text, (size_t)length + 1, format, again);
    }
    va_end(again);
    return text;
}

char *ry_text_print(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    char *const text = print(format, arguments);
    va_end(arguments);
    return text;
}

void ry_text_say(void (*write)(void *data, const char *text), void *data, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    char *const text = write != NULL ? print(format, arguments) : NULL;
    va_end(arguments);
    if (text != NULL) {
        write(data, text);
    }
    free(text);
}
