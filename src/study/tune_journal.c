/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * OUT.h5.pieces: text, a line for each finished piece, numbers in hexadecimal so that they come back
 * to the bit. A line that a kill has cut short is dropped. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "study/tune_private.h"

struct ry_tune_journal {
    char *path, *text; /* text: what was there when it was opened, "" if nothing */
    FILE *file;
};

enum { LARGEST = 1 << 30 };

static ry_status refuse(const ry_tune_journal *j, const char *what, ry_error *error)
{
    return ry_fail(error, RY_BAD_FILE, "%s: %s", j->path, what);
}

/* Keeps the whole lines that are there; 0: they belong to something else. */
static int take_text(ry_tune_journal *j, const char *mark)
{
    char *const last = strrchr(j->text, '\n');
    if (last == NULL) {
        j->text[0] = '\0';
        return 1;
    }
    last[1] = '\0';
    const size_t length = strlen(mark);
    return strncmp(j->text, mark, length) == 0 && j->text[length] == '\n';
}

static ry_status read_old(ry_tune_journal *j, off_t size, const char *mark, int resume, int force,
                          ry_error *error)
{
    if (size > 0 && !force && !resume) {
        return refuse(j, "is left from a tuning that was stopped; --resume goes on, --force begins anew", error);
    }
    if (size == 0 || !resume) {
        j->text = strdup("");
        return j->text != NULL ? RY_OK : ry_no_memory(error, 1);
    }
    RY_TRY(ry_text_read(j->path, LARGEST, "a list of pieces", &j->text, error));
    if (!take_text(j, mark)) {
        return ry_fail(
            error, RY_BAD_INPUT,
            "%s: the scene, the target, --vary, --quick or the program has changed since; give them as they "
            "were, or --force begins anew",
            j->path);
    }
    return RY_OK;
}

/* 1: the lock is ours, and the file is still there: who had it may have removed it at its end. */
static int take_lock(const ry_tune_journal *j, int fd, struct stat *opened)
{
    struct stat named;
    return (flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) && fstat(fd, opened) == 0 &&
           stat(j->path, &named) == 0 && opened->st_ino == named.st_ino && opened->st_dev == named.st_dev;
}

/* Reads under the lock, so that no piece of another process that is just ending is missed and cut off. */
static ry_status begin(ry_tune_journal *j, const char *mark, int resume, int force, ry_error *error)
{
    struct stat info;
    const int fd = open(j->path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0) {
        return refuse(j, strerror(errno), error);
    }
    ry_status status = take_lock(j, fd, &info) ? read_old(j, info.st_size, mark, resume, force, error)
                                               : refuse(j, "is in use by another process", error);
    if (status == RY_OK && (ftruncate(fd, (off_t)strlen(j->text)) != 0 || lseek(fd, 0, SEEK_END) < 0 ||
                            (j->file = fdopen(fd, "a")) == NULL)) {
        status = refuse(j, strerror(errno), error);
    }
    if (status != RY_OK) {
        close(fd);
        return status;
    }
    if (j->text[0] == '\0' && (fprintf(j->file, "%s\n", mark) < 0 || fflush(j->file) != 0)) {
        return refuse(j, strerror(errno), error);
    }
    return RY_OK;
}

ry_status ry_tune_journal_open(ry_tune_journal **journal, const char *path, const char *mark,
                               int resume, int force, ry_error *error)
{
    *journal = NULL;
    ry_tune_journal *const j = calloc(1, sizeof *j);
    if (j == NULL) {
        return ry_no_memory(error, sizeof *j);
    }
    j->path = ry_text_print("%s.pieces", path);
    const ry_status status =
        j->path == NULL ? ry_no_memory(error, strlen(path)) : begin(j, mark, resume, force, error);
    if (status != RY_OK) {
        ry_tune_journal_close(j, 0);
        return status;
    }
    *journal = j;
    return RY_OK;
}

/* words|status|n v v v|why */
static int read_line(const char *line, ry_tune_piece *piece)
{
    char *end;
    const long status = strtol(line, &end, 10);
    const long n = *end == '|' ? strtol(end + 1, &end, 10) : -1;
    if (n < 0 || n > 100000000) {
        return 0;
    }
    double *const value = ry_array((size_t)n + 1, sizeof *value);
    for (long k = 0; value != NULL && k < n; k++) {
        value[k] = strtod(end, &end);
    }
    if (value == NULL || *end != '|') {
        free(value);
        return 0;
    }
    piece->status = (ry_status)status;
    piece->n = (int)n;
    piece->value = value;
    snprintf(piece->why, sizeof piece->why, "%.*s", (int)strcspn(end + 1, "\n"), end + 1);
    piece->done = 1;
    return 1;
}

int ry_tune_journal_find(const ry_tune_journal *journal, ry_tune_piece *piece)
{
    const size_t length = strlen(piece->words);
    for (const char *line = journal->text; *line != '\0';) {
        if (strncmp(line, piece->words, length) == 0 && line[length] == '|') {
            return read_line(line + length + 1, piece);
        }
        const char *const end = strchr(line, '\n');
        line = end != NULL ? end + 1 : line + strlen(line);
    }
    return 0;
}

ry_status ry_tune_journal_add(ry_tune_journal *journal, const ry_tune_piece *piece, ry_error *error)
{
    FILE *const f = journal->file;
    fprintf(f, "%s|%d|%d", piece->words, (int)piece->status, piece->n);
    for (int k = 0; k < piece->n; k++) {
        fprintf(f, " %a", piece->value[k]);
    }
    fprintf(f, "|%s\n", piece->why);
    if (fflush(f) != 0 || ferror(f) || (fdatasync(fileno(f)) != 0 && errno != EINVAL)) {
        return refuse(journal, "can't be written (disk full?)", error);
    }
    return RY_OK;
}

void ry_tune_journal_close(ry_tune_journal *journal, int remove_it)
{
    if (journal == NULL) {
        return;
    }
    if (remove_it) {
        unlink(journal->path);
    }
    if (journal->file != NULL) {
        (void)fclose(journal->file);
    }
    free(journal->path);
    free(journal->text);
    free(journal);
}
