/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#define _GNU_SOURCE
#include "study/sweep_store.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/link.h"
#include "base/memory.h"
#include "base/text.h"

enum { LARGEST = 256 << 20, /* a scene of 64 MiB, with all digits */
       TOLD = 4, /* differences */
       LARGEST_RECORD = 1 << 16, LOCK_TRIES = 100, LOCK_WAIT_US = 100000 };

ry_status ry_sweep_store_init(ry_sweep_store *store, const char *output, int n_cases,
                              ry_error *error)
{
    *store = (ry_sweep_store){.n_cases = n_cases, .digits = 4, .lock = -1};
    RY_TRY(ry_link_follow(output, &store->output, error));
    store->folder = ry_text_print("%.*s.d", ry_text_stem(store->output), store->output);
    for (int n = n_cases; n > 9999; n /= 10) {
        store->digits++;
    }
    if (store->folder == NULL) {
        ry_sweep_store_close(store);
        return ry_no_memory(error, strlen(store->output));
    }
    return RY_OK;
}

void ry_sweep_store_close(ry_sweep_store *store)
{
    if (store->lock >= 0) {
        close(store->lock);
    }
    free(store->output);
    free(store->folder);
    *store = (ry_sweep_store){.lock = -1};
}

char *ry_sweep_store_name(const ry_sweep_store *store, int index, const char *ending,
                          int with_folder)
{
    return ry_text_print("%s%scase-%0*d%s", with_folder ? store->folder : "",
                         with_folder ? "/" : "", store->digits, index + 1, ending);
}

/* --- the description ---------------------------------------------------------------------------- */

static const char *next_line(const char *p)
{
    p += strcspn(p, "\n");
    return p + (*p == '\n');
}

/* The line of `text` that begins with the same "key = " as `line`; NULL: none. It is mostly the one at *next: there may
 * be a line for each grain. */
static const char *line_of_key(const char *text, const char *line, const char **next)
{
    const size_t key = strcspn(line, "=\n") + 1;
    const char *p = *next;
    if (strncmp(p, line, key) != 0) {
        for (p = text; *p != '\0' && strncmp(p, line, key) != 0;) {
            p = next_line(p);
        }
    }
    if (*p == '\0') {
        return NULL;
    }
    *next = next_line(p);
    return p;
}

/* "key was X, is Y" for each line of `a` that is another one in `b`; `a` is the new one unless `old`. */
static int list_differences(const char *a, const char *b, int old, char *out, size_t size,
                            int found)
{
    const char *next = b;
    for (const char *p = a; *p != '\0' && found <= TOLD; p = next_line(p)) {
        const char *const other = line_of_key(b, p, &next);
        const int length = (int)strcspn(p, "\n"), key = (int)strcspn(p, "=\n") - 1;
        const int other_length = other != NULL ? (int)strcspn(other, "\n") : 0;
        if (other != NULL &&
            (old || (length == other_length && strncmp(p, other, (size_t)length) == 0))) {
            continue;
        }
        const size_t used = strlen(out);
        if (++found <= TOLD) {
            const char *const value = p + key + 3;
            const char *const other_value = other != NULL ? other + key + 3 : "";
            const int other_rest = other != NULL ? other_length - key - 3 : 0;
            snprintf(out + used, size - used, "%s%.*s was %.*s%s, is %.*s%s", found > 1 ? "; " : "",
                     key, p, old ? length - key - 3 : other_rest, old ? value : other_value,
                     old || other != NULL ? "" : "not there", old ? 0 : length - key - 3, value,
                     old ? "not there" : "");
        }
    }
    return found;
}

static ry_status compare(const ry_sweep_store *store, const char *now, const char *then,
                         ry_error *error)
{
    char list[1400] = "";
    int found = list_differences(now, then, 0, list, sizeof list, 0);
    found = list_differences(then, now, 1, list, sizeof list, found);
    if (found == 0) {
        return RY_OK;
    }
    const int is_shard = store->shards > 0; /* whose --force is for its own cases; the others keep what is there */
    return ry_fail(error, RY_BAD_INPUT, "%s holds another sweep: %s%s; give another -o, or %s%s%s", store->folder, list,
                   found > TOLD ? "; and more" : "",
                   is_shard ? "to begin anew, remove " : "--force to begin anew", is_shard ? store->folder : "",
                   is_shard ? ", or --force without --shard" : "");
}

static ry_status read_description(const ry_sweep_store *store, char **text, ry_error *error)
{
    *text = NULL;
    char *const path = ry_text_print("%s/sweep.txt", store->folder);
    if (path == NULL) {
        return ry_no_memory(error, 1);
    }
    const ry_status status =
        access(path, F_OK) == 0 || errno != ENOENT
            ? ry_text_read(path, LARGEST, "the description of a sweep", text, error)
            : RY_OK;
    free(path);
    return status;
}

ry_status ry_sweep_store_look(const ry_sweep_store *store, const char *description, ry_error *error)
{
    char *then = NULL;
    RY_TRY(read_description(store, &then, error));
    if (then == NULL) {
        return ry_fail(error, RY_BAD_FILE, "%s: there is no sweep here", store->folder);
    }
    const ry_status status = compare(store, description, then, error);
    free(then);
    return status;
}

/* --- the folder --------------------------------------------------------------------------------- */

/* What a case leaves; behind it what a kill leaves of a file that was being made. The first three tell
 * that a case is there. */
static const char *const endings[] = {".txt", ".h5", ".h5.part", ".h5.part.journal", ".xdmf", ".h5.part.copy",
                                      ".xdmf.part", NULL};
enum { TELLING = 3 };

/* 1: as ry_text_write names it, ".txt.NUMBER.part". */
static int is_half_record(const char *ending)
{
    const size_t digits = strncmp(ending, ".txt.", 5) == 0 ? strspn(ending + 5, "0123456789") : 0;
    return digits > 0 && strcmp(ending + 5 + digits, ".part") == 0;
}

/* The names that a sweep makes in its folder. */
static int is_ours(const char *name)
{
    const size_t digits = strncmp(name, "case-", 5) == 0 ? strspn(name + 5, "0123456789") : 0;
    int k = 0;
    while (endings[k] != NULL && (digits < 4 || strcmp(name + 5 + digits, endings[k]) != 0)) {
        k++;
    }
    return strncmp(name, "sweep.txt", 9) == 0 || endings[k] != NULL ||
           (digits >= 4 && is_half_record(name + 5 + digits));
}

/* Calls unlink for our files whose name begins with `prefix`; returns how many there are. */
static int each_file(const ry_sweep_store *store, const char *prefix, int remove_them, int *others)
{
    int n = 0;
    DIR *const folder = opendir(store->folder);
    for (struct dirent *entry; folder != NULL && (entry = readdir(folder)) != NULL;) {
        const char *const name = entry->d_name;
        if (strcmp(name, ".") == 0 || strcmp(name, "..") == 0) {
            continue;
        }
        if (!is_ours(name) || strncmp(name, prefix, strlen(prefix)) != 0) {
            *others += !is_ours(name);
            continue;
        }
        n++;
        if (remove_them) {
            unlinkat(dirfd(folder), name, 0);
        }
    }
    if (folder != NULL) {
        closedir(folder);
    }
    return n;
}

int ry_sweep_store_has(const ry_sweep_store *store, int index)
{
    int found = 0;
    for (int k = 0; k < TELLING && !found; k++) {
        char *const name = ry_sweep_store_name(store, index, endings[k], 1);
        found = name != NULL && access(name, F_OK) == 0;
        free(name);
    }
    return found;
}

void ry_sweep_store_remove(const ry_sweep_store *store, int index)
{
    for (int k = 0; endings[k] != NULL; k++) {
        char *const name = ry_sweep_store_name(store, index, endings[k], 1);
        if (name != NULL) {
            unlink(name);
        }
        free(name);
    }
}

static ry_status make_folder(const ry_sweep_store *store, ry_error *error)
{
    int others = 0;
    if (mkdir(store->folder, 0777) == 0) {
        return RY_OK;
    }
    if (errno != EEXIST) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be made: %s", store->folder, strerror(errno));
    }
    if (access(store->folder, R_OK | W_OK | X_OK) != 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be written to: %s", store->folder,
                       strerror(errno));
    }
    if (each_file(store, "", 0, &others) == 0 && others > 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: is there and holds no sweep; give another -o",
                       store->folder);
    }
    return RY_OK;
}

/* The lock file is never written; its bytes are what is locked: one for each shard (all of them for a
 * sweep without shards), one for OUT.h5, one for sweep.txt (shared while it holds for somebody, exclusive
 * while it is compared and written), then one for each further process of each shard. */
#define TABLE_BYTE ((off_t)1 << 30)
#define DESCRIPTION_BYTE (TABLE_BYTE + 1)
#define MOST_RANKS ((off_t)1 << 20)

static off_t rank_byte(int shard, int rank)
{
    return rank == 0 ? shard : TABLE_BYTE + 1 + MOST_RANKS * shard + rank;
}

/* 1: the lock is ours, or there are no locks: such a file system can't tell who else is there; that is
 * the user's care. */
static int try_lock(const ry_sweep_store *store, short type, off_t start, off_t length)
{
    struct flock lock = {.l_type = type, .l_whence = SEEK_SET, .l_start = start, .l_len = length};
    return fcntl(store->lock, F_OFD_SETLK, &lock) == 0 || (errno != EAGAIN && errno != EACCES);
}

static void wait_for_lock(const ry_sweep_store *store, short type, off_t byte)
{
    struct flock lock = {.l_type = type, .l_whence = SEEK_SET, .l_start = byte, .l_len = 1};
    while (fcntl(store->lock, F_OFD_SETLKW, &lock) != 0 && errno == EINTR) {}
}

static ry_status open_lock(ry_sweep_store *store, ry_error *error)
{
    if (store->lock >= 0) {
        return RY_OK;
    }
    char *const path = ry_text_print("%s/sweep.txt.lock", store->folder);
    if (path == NULL) {
        return ry_no_memory(error, 1);
    }
    store->lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    const ry_status status =
        store->lock >= 0 ? RY_OK : ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(errno));
    free(path);
    return status;
}

/* 1: no process that an earlier sweep had beside its process 0 is left. */
static int are_others_gone(const ry_sweep_store *store, int shard, int shards)
{
    const off_t first = rank_byte(0, 1);
    const off_t own = rank_byte(shard, 1),
                length = shards > 0 ? MOST_RANKS - 1 : 0; /* 0: to the end */
    return try_lock(store, F_WRLCK, first, length) && try_lock(store, F_UNLCK, first, length) &&
           try_lock(store, F_WRLCK, own, length) && try_lock(store, F_UNLCK, own, length);
}

/* A sweep that was just killed holds its locks until its cases have been saved, so this waits a little. */
static ry_status take_lock(ry_sweep_store *store, int shard, int shards, ry_error *error)
{
    RY_TRY(open_lock(store, error));
    int mine = 0;
    for (int k = 0; k <= LOCK_TRIES; k++) {
        mine =
            mine || try_lock(store, F_WRLCK, shards > 0 ? shard : 0, shards > 0 ? 1 : TABLE_BYTE);
        if (mine && are_others_gone(store, shard, shards)) {
            return RY_OK;
        }
        usleep(LOCK_WAIT_US);
    }
    return ry_fail(error, RY_BAD_FILE, "%s: in use by another sweep", store->folder);
}

ry_status ry_sweep_store_join(ry_sweep_store *store, const char *description, int shard, int rank,
                              ry_error *error)
{
    RY_TRY(ry_sweep_store_look(store, description, error));
    RY_TRY(open_lock(store, error));
    try_lock(store, F_WRLCK, rank_byte(shard, rank), 1);
    return RY_OK;
}

int ry_sweep_store_is_there(const ry_sweep_store *store, int shard, int rank)
{
    struct flock lock = {
        .l_type = F_WRLCK, .l_whence = SEEK_SET, .l_start = rank_byte(shard, rank), .l_len = 1};
    return fcntl(store->lock, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

ry_status ry_sweep_store_lock_table(ry_sweep_store *store, ry_error *error)
{
    RY_TRY(open_lock(store, error));
    wait_for_lock(store, F_WRLCK, TABLE_BYTE);
    return RY_OK;
}

static ry_status describe(const ry_sweep_store *store, const char *description, int sharded,
                          int anew, ry_error *error)
{
    char *then = NULL;
    int others = 0;
    if (!try_lock(store, F_WRLCK, DESCRIPTION_BYTE, 1)) {
        /* Another shard is there, even if it has no case yet. */
        wait_for_lock(store, F_RDLCK, DESCRIPTION_BYTE);
        return ry_sweep_store_look(store, description, error);
    }
    ry_status status = read_description(store, &then, error);
    if (status == RY_OK && anew && !sharded) {
        each_file(store, "case-", 1, &others);
        free(then);
        then = NULL;
    }
    if (status == RY_OK && then != NULL && each_file(store, "case-", 0, &others) > 0) {
        status = compare(store, description, then, error);
    } else if (status == RY_OK) {
        char *const path = ry_text_print("%s/sweep.txt", store->folder);
        status = path != NULL ? ry_text_write(path, description, error) : ry_no_memory(error, 1);
        free(path);
    }
    free(then);
    try_lock(store, F_RDLCK, DESCRIPTION_BYTE, 1);
    return status;
}

ry_status ry_sweep_store_open(ry_sweep_store *store, const char *description, int shard, int shards,
                              int anew, ry_error *error)
{
    store->shards = shards;
    RY_TRY(make_folder(store, error));
    RY_TRY(take_lock(store, shard, shards, error));
    return describe(store, description, shards > 0, anew, error);
}

/* --- records ------------------------------------------------------------------------------------ */

/* Of the status and the message, which are the first and the last line: both, or the record is cut. */
enum { HAS_STATUS = 1, HAS_MESSAGE = 2, HAS_ALL = 3 };

/* 0: the value is not whole. */
static int take_line(ry_case_record *r, const char *key, const char *value, int *has)
{
    char *end = NULL;
    if (strcmp(key, "status") == 0) {
        r->status = (int)strtol(value, &end, 10);
        *has |= HAS_STATUS;
    } else if (strcmp(key, "q_star") == 0) {
        r->q_star = strtod(value, &end);
    } else if (strcmp(key, "q_star_error") == 0) {
        r->q_star_error = strtod(value, &end);
    } else if (strcmp(key, "autocorrelation_time") == 0) {
        r->autocorrelation_time = strtod(value, &end);
    } else if (strcmp(key, "equilibration_time") == 0) {
        r->equilibration_time = strtod(value, &end);
    } else if (strcmp(key, "samples") == 0) {
        r->samples = strtoll(value, &end, 10);
    } else if (strcmp(key, "wall_seconds") == 0) {
        r->wall_seconds = strtod(value, &end);
    } else if (strcmp(key, "stopped_early") == 0) {
        r->stopped_early = (int)strtol(value, &end, 10);
    } else if (strcmp(key, "hash") == 0) {
        r->hash = strtoull(value, &end, 16);
    } else if (strcmp(key, "message") == 0) {
        snprintf(r->message, sizeof r->message, "%s", value);
        *has |= HAS_MESSAGE;
    }
    return end == NULL || (end > value && *end == '\0');
}

/* 1: `text`, which this takes apart, is a whole record. */
static int take_text(ry_case_record *r, char *text)
{
    const size_t length = strlen(text);
    int has = 0, good = length > 0 && text[length - 1] == '\n';
    for (char *rest = text, *line; good && (line = strsep(&rest, "\n")) != NULL;) {
        char *const value = strstr(line, " = ");
        if (value != NULL) {
            *value = '\0';
            good = take_line(r, line, value + 3, &has);
        }
    }
    return good && has == HAS_ALL;
}

ry_status ry_sweep_store_read(const ry_sweep_store *store, int index, ry_case_record *record,
                              ry_error *error)
{
    static const ry_case_record unknown = {.q_star = NAN,
                                           .q_star_error = NAN,
                                           .autocorrelation_time = NAN,
                                           .equilibration_time = NAN,
                                           .wall_seconds = NAN};
    *record = unknown;
    char *const path = ry_sweep_store_name(store, index, ".txt", 1);
    char *text = NULL;
    if (path == NULL) {
        return ry_no_memory(error, 1);
    }
    ry_status status = RY_OK;
    if (access(path, F_OK) == 0) {
        status = ry_text_read(path, LARGEST_RECORD, "the record of a case", &text, error);
    }
    record->known = text != NULL && take_text(record, text);
    if (!record->known) {
        *record = unknown; /* a case with a damaged record is run again */
    }
    free(text);
    free(path);
    return status == RY_BAD_INPUT ? RY_OK : status; /* no text at all: damaged as well */
}

ry_status ry_sweep_store_write(const ry_sweep_store *store, int index, const ry_case_record *r,
                               ry_error *error)
{
    char message[sizeof r->message];
    snprintf(message, sizeof message, "%s", r->message);
    for (char *p = message; *p != '\0'; p++) {
        *p = *p == '\n' || *p == '\r' ? ' ' : *p;
    }
    char *const path = ry_sweep_store_name(store, index, ".txt", 1);
    char *const text = ry_text_print(
        "status = %d\nq_star = %.17g\nq_star_error = %.17g\nautocorrelation_time = %.17g\n"
        "equilibration_time = %.17g\nsamples = %lld\nwall_seconds = %.4g\nstopped_early = %d\nhash = 0x%016llx\n"
        "message = %s\n",
        r->status, r->q_star, r->q_star_error, r->autocorrelation_time, r->equilibration_time,
        r->samples, r->wall_seconds, r->stopped_early, r->hash, message);
    const ry_status status =
        path != NULL && text != NULL ? ry_text_write(path, text, error) : ry_no_memory(error, 1);
    free(path);
    free(text);
    return status;
}
