/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * One run per output. HDF5 has locks of its own (flock), which last only while a file is open and
 * would keep readers out; ours is another kind (an open file description lock, far behind the end)
 * that readers don't see, that is held between flushes and that ends with the process however it
 * ends. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"
#include "io/result_private.h"

ry_status ry_lock_check_name(int fd, const char *path, ry_error *error)
{
    struct stat opened, named;
    return fstat(fd, &opened) == 0 && stat(path, &named) == 0 && opened.st_ino == named.st_ino &&
                   opened.st_dev == named.st_dev
               ? RY_OK
               : ry_fail(error, RY_BAD_FILE, "%s: was moved away or removed meanwhile; nothing more is written", path);
}

/* 1: the lock is ours and `path` is still the file that it is on. */
static int take(int fd, const char *path)
{
    struct flock lock = {
        .l_type = F_WRLCK, .l_whence = SEEK_SET, .l_start = (off_t)1 << 62, .l_len = 1};
    if (fcntl(fd, F_OFD_SETLK, &lock) != 0) {
        /* A file system without locks can't tell; two runs there are the user's care. */
        if (errno == EAGAIN || errno == EACCES) {
            return 0;
        }
    }
    return ry_lock_check_name(fd, path, NULL) == RY_OK;
}

ry_status ry_lock_open(const char *path, int create, int *fd, ry_error *error)
{
    *fd = open(path, O_RDWR | O_CLOEXEC | (create ? O_CREAT : 0), 0666);
    if (*fd < 0) {
        return !create && errno == ENOENT
                   ? RY_OK
                   : ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(errno));
    }
    struct stat info;
    if (fstat(*fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        close(*fd);
        return ry_fail(error, RY_BAD_FILE, "%s: not a regular file", path);
    }
    if (!take(*fd, path)) {
        close(*fd);
        return ry_fail(error, RY_BAD_FILE, "%s: in use by another run", path);
    }
    return RY_OK;
}

static ry_status check_folder(const char *path, ry_error *error)
{
    char *const copy = strdup(path);
    if (copy == NULL) {
        return ry_no_memory(error, strlen(path));
    }
    const char *const folder = dirname(copy);
    struct stat info;
    ry_status status = RY_OK;
    if (stat(folder, &info) != 0) {
        status = ry_fail(error, RY_BAD_FILE, "%s: can't be made in folder %s: %s", path, folder,
                         strerror(errno));
    } else if (!S_ISDIR(info.st_mode)) {
        status = ry_fail(error, RY_BAD_FILE, "%s: %s is not a folder", path, folder);
    } else if (access(folder, W_OK | X_OK) != 0) {
        status = ry_fail(error, RY_BAD_FILE, "%s: folder %s can't be written to: %s", path, folder,
                         strerror(errno));
    }
    free(copy);
    return status;
}

/* Somebody's scene, sweep or table, named by mistake: 1. A result, an empty file or none: 0. */
static int is_something_else(const char *path)
{
    ry_atomic *const file = ry_atomic_open(path, -1);
    const int other = file != NULL && ry_atomic_looks_like_hdf5(file) < 0;
    if (file != NULL) {
        ry_atomic_close(file);
    }
    return other;
}

ry_status ry_lock_check_path(const char *path, ry_error *error)
{
    const size_t length = strlen(path);
    if (length == 0) {
        return ry_fail(error, RY_BAD_FILE, "the name of the output file is empty");
    }
    struct stat info;
    if (path[length - 1] == '/' || (stat(path, &info) == 0 && S_ISDIR(info.st_mode))) {
        return ry_fail(error, RY_BAD_FILE, "%s: is a folder; name a file in it", path);
    }
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        return ry_fail(error, RY_BAD_FILE, "%s: not a regular file", path);
    }
    if (is_something_else(path)) {
        return ry_fail(error, RY_BAD_FILE, "%s: not a result file (HDF5), and not replaced by one; give another name", path);
    }
    return check_folder(path, error);
}
