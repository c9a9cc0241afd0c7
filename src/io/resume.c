/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Going on with a run. OUT.h5.part comes first: it is there because a run was interrupted. Without
 * one, or if it was killed before its first checkpoint, a finished OUT.h5 is copied to OUT.h5.part
 * and continued if its end has moved. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/result_private.h"
#include "io/series.h"

enum { NOTHING = 0, RESUMED = 1, FINISHED = 2 };

/* --- reading what is there --- */

/* Checks that a file is ours and of this scene, and loads its state. *found is NOTHING if it has no
 * checkpoint yet. */
static ry_status load(hid_t file, const char *name, const ry_config *config, ry_state *state,
                      int *slot, int64_t *sequence, int *found, ry_error *error)
{
    *found = NOTHING;
    RY_TRY(ry_parameters_check_ours(file, name, error));
    RY_TRY(ry_parameters_compare(file, name, config, error));
    const int read = ry_checkpoint_read(file, state, slot, sequence);
    const int64_t other = read < 0 ? ry_checkpoint_other_format(file) : 0;
    if (other != 0) {
        return ry_fail(error, RY_BAD_FILE,
                       "%s: its checkpoints are of another version of ryusa (format %lld) and can't be gone on from; go on "
                       "with that version, or begin anew with --force", name, (long long)other);
    }
    if (read < 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: damaged: neither of its checkpoints is whole",
                       name);
    }
    *found = read;
    return RY_OK;
}

/* 1: the file holds this run to its end. Early is an end if the conditions for it are as they were. */
static int is_finished(hid_t file, const ry_config *config, int64_t step)
{
    int64_t finished = 0, early = 0;
    double end = 0.0, stop_error = 0.0, after = 0.0;
    if (ry_h5_get_integer(file, "checkpoint", "finished", &finished) != 0 || !finished) {
        return 0;
    }
    if (step >= ry_config_derive(config).steps_end) {
        return 1;
    }
    return ry_h5_exists(file, "observables/flux") &&
           ry_h5_get_integer(file, "observables/flux", "stopped_early", &early) == 0 && early &&
           ry_h5_get_number(file, "parameters", "time.end", &end) == 0 &&
           ry_h5_get_number(file, "parameters", "stop.flux_error", &stop_error) == 0 &&
           ry_h5_get_number(file, "parameters", "stop.after", &after) == 0 &&
           end == config->time_end && stop_error == config->stop_flux_error &&
           after == config->stop_after;
}

/* --- taking the file up again --- */

static int resume_flux(ry_result *result, hid_t file)
{
    const char *const path = (result->fields & RY_FIELD_FLUX) != 0 ? "observables/q_star/value"
                                                                   : RY_HIDDEN_FLUX "/value";
    ry_h5_shape shape;
    if (ry_h5_get_shape(file, path, &shape) != 0 || shape.rank != 1) {
        return -1;
    }
    result->n_flux = (size_t)shape.size[0];
    return ry_array_grow(&result->flux, &result->flux_capacity, 0, result->n_flux, sizeof(double),
                         NULL) == RY_OK &&
                   (result->n_flux == 0 ||
                    ry_h5_read(file, path, H5T_NATIVE_DOUBLE, shape.size[0], result->flux) == 0)
               ? 0
               : -1;
}

static int resume_profiles(ry_result *result, hid_t file, int64_t step)
{
    ry_h5_shape shape;
    if ((result->fields & RY_FIELD_PROFILE) == 0 ||
        ry_h5_get_shape(file, "observables/profile_series/phi/value", &shape) != 0) {
        return 0;
    }
    if (shape.rank != 2 ||
        ry_h5_get_number(file, "observables/profile_series", "cell_height", &result->dz) != 0) {
        return -1;
    }
    ry_result_add_profiles(result, (int32_t)shape.size[1]);
    return ry_table_resume(&result->rows.profiles, file, step);
}

static int resume_all(ry_result *result, hid_t file, const ry_config *config, int64_t step)
{
    return ry_table_resume(&result->rows.frames, file, step) == 0 &&
                   ry_table_resume(&result->rows.series, file, step) == 0 &&
                   resume_profiles(result, file, step) == 0 && resume_flux(result, file) == 0 &&
                   ry_checkpoint_read_window(file, result->slot, &result->window, &result->n_window) == 0 &&
                   ry_h5_set_integer(file, "checkpoint", "finished", 0) == 0 &&
                   ry_parameters_write(file, config) == 0
               ? 0
               : -1;
}

static ry_status take_up(ry_result **result, const char *path, int *fd, const ry_config *config,
                         const ry_state *state, int slot, int64_t sequence, ry_error *error)
{
    ry_result *const made = ry_result_new(path, config, state, error);
    if (made == NULL) {
        return RY_BAD_FILE;
    }
    made->fd = *fd;
    *fd = -1;
    made->slot = slot;
    made->sequence = sequence;
    made->replace = access(path, F_OK) == 0;
    ry_h5 file;
    ry_status status = ry_h5_open(&file, made->part, made->fd, RY_H5_CHANGE, error);
    if (status == RY_OK) {
        const int failed = resume_all(made, file.id, config, state->step);
        status = ry_h5_close(&file, failed, "go on with it", error);
    }
    if (status == RY_OK) {
        *result = made;
    } else {
        ry_result_close(made);
    }
    return status;
}

/* --- OUT.h5.part --- */

/* An unborn file (killed before its head was committed) is nothing to go on with, and no error. */
static int is_unborn(const char *part, int fd)
{
    ry_atomic *const file = ry_atomic_open(part, fd);
    const int unborn = file != NULL && ry_atomic_looks_like_hdf5(file) == 0;
    ry_atomic_close(file);
    return unborn;
}

static ry_status resume_part(ry_result **result, const char *path, const char *part, int *fd,
                             const ry_config *config, ry_state *state, int *found, ry_error *error)
{
    ry_h5 file;
    int slot = -1;
    int64_t sequence = 0;
    if (is_unborn(part, *fd)) {
        return RY_OK;
    }
    RY_TRY(ry_h5_open(&file, part, *fd, RY_H5_READ, error));
    ry_status status = load(file.id, part, config, state, &slot, &sequence, found, error);
    ry_h5_close(&file, 1, "", NULL);
    if (status == RY_OK && *found == RESUMED) {
        status = take_up(result, path, fd, config, state, slot, sequence, error);
        if (status != RY_OK) {
            ry_state_free(state);
            *found = NOTHING;
        }
    }
    return status;
}

/* --- a finished OUT.h5 --- */

static int copy_bytes(int from, int to)
{
    static const size_t block = 1 << 20;
    char *const buffer = malloc(block);
    int failure = buffer == NULL ? ENOMEM : 0;
    while (failure == 0) {
        const ssize_t got = read(from, buffer, block);
        if (got < 0 && errno != EINTR) {
            failure = errno;
        } else if (got == 0) {
            break;
        }
        for (ssize_t done = 0; failure == 0 && done < got;) {
            const ssize_t put = write(to, buffer + done, (size_t)(got - done));
            if (put < 0 && errno != EINTR) {
                failure = errno;
            }
            done += put > 0 ? put : 0;
        }
    }
    free(buffer);
    return failure;
}

/* Copies under another name first: a half copy must never look like an interrupted run. */
static ry_status copy_to_part(const char *path, const char *part, int *fd, ry_error *error)
{
    char *const copy = ry_text_print("%s.copy", part);
    if (copy == NULL) {
        return ry_no_memory(error, strlen(part));
    }
    const int from = open(path, O_RDONLY | O_CLOEXEC);
    ry_status status = from < 0 ? ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(errno))
                                : ry_lock_open(copy, 1, fd, error);
    if (status == RY_OK) {
        int failure = ftruncate(*fd, 0) == 0 ? copy_bytes(from, *fd) : errno;
        failure = failure == 0 && fdatasync(*fd) != 0 ? errno : failure;
        ry_atomic_forget_journal(part);
        failure = failure == 0 && rename(copy, part) != 0 ? errno : failure;
        if (failure != 0) {
            unlink(copy);
            status = ry_fail(error, RY_BAD_FILE, "%s: can't be copied from %s: %s", part, path,
                             strerror(failure));
        }
    }
    if (from >= 0) {
        close(from);
    }
    free(copy);
    return status;
}

static ry_status look_at_finished(const char *path, const ry_config *config, int *found,
                                  ry_error *error)
{
    ry_h5 file;
    ry_state state = {0};
    int slot = -1;
    int64_t sequence = 0;
    RY_TRY(ry_h5_open(&file, path, -1, RY_H5_READ, error));
    ry_status status = load(file.id, path, config, &state, &slot, &sequence, found, error);
    if (status == RY_OK && *found == NOTHING) {
        status = ry_fail(error, RY_BAD_FILE, "%s: has no checkpoint to go on from", path);
    }
    if (status == RY_OK && is_finished(file.id, config, state.step)) {
        *found = FINISHED;
    }
    ry_state_free(&state);
    ry_h5_close(&file, 1, "", NULL);
    return status;
}

static ry_status resume_finished(ry_result **result, const char *path, const char *part, int *fd,
                                 const ry_config *config, ry_state *state, int *found,
                                 ry_error *error)
{
    RY_TRY(look_at_finished(path, config, found, error));
    if (*found == FINISHED) {
        return ry_xdmf_write(path, 0, error); /* a kill at the very end may have left it out */
    }
    if (*fd >= 0) {
        close(*fd);
        *fd = -1;
    }
    RY_TRY(copy_to_part(path, part, fd, error));
    return resume_part(result, path, part, fd, config, state, found, error);
}

ry_status ry_result_resume(ry_result **result, const char *path, const ry_config *config,
                           ry_state *state, int *found, ry_error *error)
{
    *result = NULL;
    *state = (ry_state){0};
    *found = NOTHING;
    RY_TRY(ry_lock_check_path(path, error));
    char *const part = ry_text_print("%s.part", path);
    if (part == NULL) {
        return ry_no_memory(error, strlen(path));
    }
    int fd = -1;
    ry_status status = ry_lock_open(part, 0, &fd, error);
    if (status == RY_OK && fd >= 0) {
        status = resume_part(result, path, part, &fd, config, state, found, error);
    }
    if (status == RY_OK && *found == NOTHING && access(path, F_OK) == 0) {
        status = resume_finished(result, path, part, &fd, config, state, found, error);
    }
    if (fd >= 0) {
        close(fd);
    }
    free(part);
    return status;
}
