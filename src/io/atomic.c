/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * See atomic.h. The pages live in a hash table by page number. The journal is
 *
 *     magic, pages, size of the file behind the commit      3 x 8 bytes
 *     page numbers                                          8 bytes each
 *     pages                                                 4096 bytes each
 *     checksum of all that                                  8 bytes
 *
 * in the byte order of the machine: it does not live longer than the moment of a commit or the
 * restart behind a kill. Everything is on disk before the first page is copied (fdatasync), so that
 * it also survives a machine that stops. */
#include "io/atomic.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PAGE = 4096, HEAD_WORDS = 3, MAX_EXPOSED = 64 };
static const uint64_t MAGIC = UINT64_C(0x3130616c61737579);

typedef struct page {
    uint64_t number;
    unsigned char *bytes; /* NULL: a free place in the table */
} page;

struct ry_atomic {
    char *journal; /* its path */
    int fd, owns_fd;
    int failure;   /* first errno */
    uint64_t kept; /* bytes before this may change in pages only; a multiple of PAGE */
    uint64_t size; /* of the file as HDF5 sees it */
    page *table;
    size_t places, used; /* places is a power of 2 */
    struct {
        uint64_t begin, end;
    } exposed[MAX_EXPOSED];
    int n_exposed;
};

/* --- whole reads and writes --- */

static int write_all(int fd, const void *buffer, size_t size, uint64_t at)
{
    const unsigned char *from = buffer;
    while (size > 0) {
        const ssize_t done = pwrite(fd, from, size, (off_t)at);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            return done < 0 ? errno : ENOSPC;
        }
        from += done;
        size -= (size_t)done;
        at += (uint64_t)done;
    }
    return 0;
}

/* Reads; what lies behind the end is zero. */
static int read_all(int fd, void *buffer, size_t size, uint64_t at)
{
    unsigned char *to = buffer;
    while (size > 0) {
        const ssize_t done = pread(fd, to, size, (off_t)at);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done < 0) {
            return errno;
        }
        if (done == 0) {
            memset(to, 0, size);
            return 0;
        }
        to += done;
        size -= (size_t)done;
        at += (uint64_t)done;
    }
    return 0;
}

static void fail(ry_atomic *file, int failure)
{
    if (file->failure == 0) {
        file->failure = failure;
    }
}

/* --- pages --- */

static page *find_place(const ry_atomic *file, uint64_t number)
{
    uint64_t k = number * UINT64_C(0x9e3779b97f4a7c15) >> 20;
    for (;; ++k) {
        page *const place = &file->table[k & (file->places - 1)];
        if (place->bytes == NULL || place->number == number) {
            return place;
        }
    }
}

static int grow_table(ry_atomic *file)
{
    page *const old = file->table;
    const size_t old_places = file->places;
    const size_t places = old_places > 0 ? 2 * old_places : 64;
    page *const table = calloc(places, sizeof *table);
    if (table == NULL) {
        return ENOMEM;
    }
    file->table = table;
    file->places = places;
    for (size_t k = 0; k < old_places; ++k) {
        if (old[k].bytes != NULL) {
            *find_place(file, old[k].number) = old[k];
        }
    }
    free(old);
    return 0;
}

/* The page to change; NULL without memory. */
static unsigned char *own_page(ry_atomic *file, uint64_t number)
{
    if (2 * (file->used + 1) > file->places && grow_table(file) != 0) {
        return NULL;
    }
    page *const place = find_place(file, number);
    if (place->bytes == NULL) {
        unsigned char *const bytes = malloc(PAGE);
        if (bytes == NULL) {
            return NULL;
        }
        fail(file, read_all(file->fd, bytes, PAGE, number * PAGE));
        *place = (page){number, bytes};
        ++file->used;
    }
    return place->bytes;
}

static int write_pages(ry_atomic *file, const unsigned char *from, size_t size, uint64_t at)
{
    while (size > 0) {
        const size_t offset = (size_t)(at % PAGE);
        const size_t part = size < PAGE - offset ? size : PAGE - offset;
        unsigned char *const bytes = own_page(file, at / PAGE);
        if (bytes == NULL) {
            fail(file, ENOMEM);
            return -1;
        }
        memcpy(bytes + offset, from, part);
        from += part;
        size -= part;
        at += part;
    }
    return 0;
}

/* What was written to an exposed place must also come into a page that is changed beside it. */
static void update_pages(const ry_atomic *file, const unsigned char *from, size_t size, uint64_t at)
{
    while (size > 0 && file->used > 0) {
        const size_t offset = (size_t)(at % PAGE);
        const size_t part = size < PAGE - offset ? size : PAGE - offset;
        const page *const place = find_place(file, at / PAGE);
        if (place->bytes != NULL) {
            memcpy(place->bytes + offset, from, part);
        }
        from += part;
        size -= part;
        at += part;
    }
}

static void read_pages(const ry_atomic *file, unsigned char *to, size_t size, uint64_t at)
{
    while (size > 0 && file->used > 0) {
        const size_t offset = (size_t)(at % PAGE);
        const size_t part = size < PAGE - offset ? size : PAGE - offset;
        const page *const place = find_place(file, at / PAGE);
        if (place->bytes != NULL) {
            memcpy(to, place->bytes + offset, part);
        }
        to += part;
        size -= part;
        at += part;
    }
}

static void drop_pages(ry_atomic *file)
{
    for (size_t k = 0; k < file->places; ++k) {
        free(file->table[k].bytes);
    }
    free(file->table);
    file->table = NULL;
    file->places = file->used = 0;
}

/* --- reading and writing of HDF5 --- */

static int is_exposed(const ry_atomic *file, uint64_t at, size_t size)
{
    for (int k = 0; k < file->n_exposed; ++k) {
        if (at >= file->exposed[k].begin && at + size <= file->exposed[k].end) {
            return 1;
        }
    }
    return 0;
}

int ry_atomic_read(ry_atomic *file, void *buffer, size_t size, uint64_t at)
{
    const int failure = read_all(file->fd, buffer, size, at);
    if (failure != 0) {
        fail(file, failure);
        return -1;
    }
    read_pages(file, buffer, size, at);
    return 0;
}

/* How many of the bytes must go into pages; the rest, at the end, goes into the file. */
static size_t count_kept(const ry_atomic *file, size_t size, uint64_t at)
{
    if (file->failure != 0) {
        return size;
    }
    if (at >= file->kept || is_exposed(file, at, size)) {
        return 0;
    }
    return at + size > file->kept ? (size_t)(file->kept - at) : size;
}

int ry_atomic_write(ry_atomic *file, const void *from, size_t size, uint64_t at)
{
    if (at + size > file->size) {
        file->size = at + size;
    }
    const unsigned char *const bytes = from;
    size_t kept = count_kept(file, size, at);
    if (kept < size) {
        const int failure = write_all(file->fd, bytes + kept, size - kept, at + kept);
        if (failure == 0) {
            update_pages(file, bytes + kept, size - kept, at + kept);
        } else {
            fail(file, failure);
            kept = size;
        }
    }
    return write_pages(file, bytes, kept, at);
}

/* --- journal --- */

static uint64_t checksum(uint64_t sum, const void *buffer, size_t words)
{
    const unsigned char *from = buffer;
    for (size_t k = 0; k < words; ++k, from += sizeof(uint64_t)) {
        uint64_t word;
        memcpy(&word, from, sizeof word);
        sum = ((sum ^ word) + 1) * UINT64_C(0xd6e8feb86659fd93);
        sum ^= sum >> 32;
    }
    return sum;
}

static char *journal_path(const char *path)
{
    const size_t length = strlen(path) + sizeof ".journal";
    char *const journal = malloc(length);
    if (journal != NULL) {
        snprintf(journal, length, "%s.journal", path);
    }
    return journal;
}

static void put(FILE *stream, uint64_t *sum, const void *buffer, size_t words)
{
    *sum = checksum(*sum, buffer, words);
    fwrite(buffer, sizeof(uint64_t), words, stream);
}

static void put_journal(const ry_atomic *file, FILE *stream)
{
    const uint64_t head[HEAD_WORDS] = {MAGIC, file->used, file->size};
    uint64_t sum = 0;
    put(stream, &sum, head, HEAD_WORDS);
    for (size_t k = 0; k < file->places; ++k) {
        if (file->table[k].bytes != NULL) {
            put(stream, &sum, &file->table[k].number, 1);
        }
    }
    for (size_t k = 0; k < file->places; ++k) {
        if (file->table[k].bytes != NULL) {
            put(stream, &sum, file->table[k].bytes, PAGE / sizeof(uint64_t));
        }
    }
    fwrite(&sum, sizeof sum, 1, stream);
}

static int write_journal(const ry_atomic *file)
{
    FILE *const stream = fopen(file->journal, "wb");
    if (stream == NULL) {
        return errno;
    }
    errno = 0;
    put_journal(file, stream);
    int failure = ferror(stream) ? errno : 0;
    if (failure == 0 && (fflush(stream) != 0 || fdatasync(fileno(stream)) != 0)) {
        failure = errno != 0 ? errno : EIO;
    }
    if (fclose(stream) != 0 && failure == 0) {
        failure = errno;
    }
    return failure;
}

/* Reads the pages of a journal into memory: 1 if there is a whole one, 0 if not. */
static int get_journal(ry_atomic *file, FILE *stream)
{
    uint64_t head[HEAD_WORDS];
    struct stat info;
    if (fread(head, sizeof head, 1, stream) != 1 || head[0] != MAGIC ||
        fstat(fileno(stream), &info) != 0 ||
        (uint64_t)info.st_size != (HEAD_WORDS + 1 + head[1]) * sizeof(uint64_t) + head[1] * PAGE) {
        return 0;
    }
    uint64_t sum = checksum(0, head, HEAD_WORDS), stored = 0;
    uint64_t *const numbers = calloc((size_t)head[1] + 1, sizeof *numbers);
    int whole =
        numbers != NULL && fread(numbers, sizeof *numbers, (size_t)head[1], stream) == head[1];
    sum = whole ? checksum(sum, numbers, (size_t)head[1]) : sum;
    for (uint64_t k = 0; whole && k < head[1]; ++k) {
        unsigned char *const bytes = own_page(file, numbers[k]);
        whole = bytes != NULL && fread(bytes, PAGE, 1, stream) == 1;
        sum = whole ? checksum(sum, bytes, PAGE / sizeof(uint64_t)) : sum;
    }
    free(numbers);
    whole = whole && fread(&stored, sizeof stored, 1, stream) == 1 && stored == sum;
    file->size = whole ? head[2] : file->size;
    return whole;
}

static int read_journal(ry_atomic *file)
{
    FILE *const stream = fopen(file->journal, "rb");
    if (stream == NULL) {
        return 0;
    }
    const int whole = get_journal(file, stream);
    fclose(stream);
    if (!whole) {
        drop_pages(file);
    }
    return whole;
}

/* Copies the pages into the file. A reader that opens the file in these milliseconds is told that it
 * is locked; one that has it open already holds the lock, and is not waited for. */
static int copy_pages(ry_atomic *file)
{
    int failure = 0;
    const int locked = flock(file->fd, LOCK_EX | LOCK_NB) == 0;
    for (size_t k = 0; k < file->places && failure == 0; ++k) {
        const page *const one = &file->table[k];
        if (one->bytes != NULL) {
            failure = write_all(file->fd, one->bytes, PAGE, one->number * PAGE);
        }
    }
    if (failure == 0 && ftruncate(file->fd, (off_t)file->size) != 0) {
        failure = errno;
    }
    if (locked) {
        flock(file->fd, LOCK_UN);
    }
    if (failure == 0 && fdatasync(file->fd) != 0) {
        failure = errno;
    }
    return failure;
}

static void set_kept(ry_atomic *file)
{
    /* The first page is kept even in a new file: until the commit it holds zeros, by which an unborn
     * file is known. */
    file->kept = (file->size + PAGE - 1) / PAGE * PAGE;
    if (file->kept == 0) {
        file->kept = PAGE;
    }
    file->n_exposed = 0;
}

int ry_atomic_commit(ry_atomic *file)
{
    if (file->failure == 0 &&
        (ftruncate(file->fd, (off_t)(file->size > file->kept ? file->size : file->kept)) != 0 ||
         fdatasync(file->fd) != 0)) {
        fail(file, errno);
    }
    if (file->failure == 0) {
        fail(file, write_journal(file));
        if (file->failure != 0) {
            unlink(file->journal);
        }
    }
    if (file->failure != 0) {
        return file->failure;
    }
    const int failure = copy_pages(file);
    if (failure != 0) {
        fail(file, failure);
        return failure;
    }
    unlink(file->journal);
    drop_pages(file);
    set_kept(file);
    return 0;
}

/* --- opening and closing --- */

static int open_contents(ry_atomic *file)
{
    struct stat info;
    if (file->fd < 0 || fstat(file->fd, &info) != 0) {
        return errno;
    }
    if (!S_ISREG(info.st_mode)) {
        return S_ISDIR(info.st_mode) ? EISDIR : EINVAL;
    }
    file->size = (uint64_t)info.st_size;
    if (read_journal(file) && !file->owns_fd) {
        const int failure = copy_pages(file);
        if (failure != 0) {
            return failure;
        }
        drop_pages(file);
    }
    if (!file->owns_fd) {
        unlink(file->journal);
    }
    set_kept(file);
    return file->failure;
}

ry_atomic *ry_atomic_open(const char *path, int fd)
{
    ry_atomic *const file = calloc(1, sizeof *file);
    if (file == NULL) {
        return NULL;
    }
    file->owns_fd = fd < 0;
    file->fd = fd < 0 ? open(path, O_RDONLY | O_CLOEXEC) : fd;
    file->journal = journal_path(path);
    const int failure = file->journal == NULL ? ENOMEM : open_contents(file);
    if (failure != 0) {
        ry_atomic_close(file);
        errno = failure;
        return NULL;
    }
    return file;
}

void ry_atomic_close(ry_atomic *file)
{
    if (file == NULL) {
        return;
    }
    drop_pages(file);
    if (file->owns_fd && file->fd >= 0) {
        close(file->fd);
    }
    free(file->journal);
    free(file);
}

void ry_atomic_expose(ry_atomic *file, uint64_t begin, uint64_t size)
{
    if (file->n_exposed < MAX_EXPOSED) {
        file->exposed[file->n_exposed].begin = begin;
        file->exposed[file->n_exposed].end = begin + size;
        ++file->n_exposed;
    }
}

uint64_t ry_atomic_size(const ry_atomic *file)
{
    return file->size;
}

void ry_atomic_set_size(ry_atomic *file, uint64_t size)
{
    file->size = size;
}

int ry_atomic_error(const ry_atomic *file)
{
    return file->failure;
}

int ry_atomic_looks_like_hdf5(ry_atomic *file)
{
    static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    static const unsigned char zeros[8] = {0};
    unsigned char head[8];
    if (ry_atomic_read(file, head, sizeof head, 0) != 0) {
        return -1;
    }
    if (memcmp(head, signature, sizeof head) == 0) {
        return 1;
    }
    return memcmp(head, zeros, sizeof head) == 0 ? 0 : -1;
}

void ry_atomic_forget_journal(const char *path)
{
    char *const journal = journal_path(path);
    if (journal != NULL) {
        unlink(journal);
    }
    free(journal);
}
