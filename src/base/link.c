/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/link.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"

enum { MOST_LINKS = 40 }; /* as many as the system follows */

static int folder_length(const char *path)
{
    const char *const slash = strrchr(path, '/');
    return slash != NULL ? (int)(slash - path) + 1 : 0;
}

/* What the link at `path` leads to, as seen from where we are; NULL: it is none, or errno is set. */
static char *step(const char *path)
{
    char to[PATH_MAX + 1];
    errno = 0;
    const ssize_t length = readlink(path, to, sizeof to - 1);
    if (length < 0) {
        errno = errno == EINVAL || errno == ENOENT ? 0 : errno;
        return NULL;
    }
    to[length] = '\0';
    return ry_text_print("%.*s%s", to[0] == '/' ? 0 : folder_length(path), path, to);
}

static ry_status check_folder(const char *path, const char *target, ry_error *error)
{
    struct stat info;
    const int length = folder_length(target);
    char *const folder = length > 0 ? ry_text_print("%.*s", length, target) : ry_text_print(".");
    const int failure = folder == NULL ? ENOMEM : stat(folder, &info) != 0 ? errno : 0;
    free(folder);
    return failure == 0 ? RY_OK
                        : ry_fail(error, RY_BAD_FILE, "%s: a link to %s, which can't be made: %s", path, target,
                                  strerror(failure));
}

ry_status ry_link_follow(const char *path, char **target, ry_error *error)
{
    struct stat info;
    *target = strdup(path);
    if (*target == NULL || (stat(path, &info) == 0 && !S_ISREG(info.st_mode))) {
        /* Links of the system's own, as /dev/stdout, lead to no file; who opens it tells. */
        return *target != NULL ? RY_OK : ry_no_memory(error, strlen(path));
    }
    int failure = 0, n = 0;
    for (char *next; failure == 0 && (next = step(*target)) != NULL; n++) {
        free(*target);
        *target = next;
        failure = n == MOST_LINKS ? ELOOP : 0;
    }
    failure = failure == 0 && errno != 0 ? errno : failure;
    ry_status status = failure != 0 && n > 0 ? ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(failure)) : RY_OK;
    if (status == RY_OK && n > 0) {
        status = check_folder(path, *target, error);
    }
    if (status != RY_OK) {
        free(*target);
        *target = NULL;
    }
    return status;
}
