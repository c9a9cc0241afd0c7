/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A result on its way to the disk, by a thread that writes while the run goes on. Rows change hands, the state
 * is copied: so much memory is the price. Every change of the file is one ry_h5_open .. ry_h5_close, which
 * happens as a whole or not at all. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/result_private.h"

/* --- what the writer does --- */

static int append_profiles(const ry_result *result, ry_table *profiles, const ry_h5 *file)
{
    if (profiles->n_columns == 0) {
        return 0;
    }
    return ry_table_append(profiles, file) == 0 &&
                   ry_h5_set_number(file->id, "observables/profile_series", "cell_height",
                                    result->dz) == 0
               ? 0
               : -1;
}

static int write_checkpoint(const ry_result *result, const ry_h5 *file)
{
    const ry_batch *const b = &result->batch;
    const int slot = result->slot == 0;
    return b->checkpoint == NULL ||
                   (ry_checkpoint_write(file, slot, result->sequence + 1, b->checkpoint) == 0 &&
                    ry_checkpoint_write_window(file, slot, b->window, b->n_window) == 0)
               ? 0
               : -1;
}

static int append_all(ry_result *result, const ry_h5 *file)
{
    ry_batch *const b = &result->batch;
    return ry_table_append(&b->rows.frames, file) == 0 &&
                   append_profiles(result, &b->rows.profiles, file) == 0 &&
                   ry_table_append(&b->rows.series, file) == 0 && write_checkpoint(result, file) == 0 &&
                   (!b->has_summary || ry_result_write_summary(result, file->id) == 0) &&
                   (!b->finished || ry_h5_set_integer(file->id, "checkpoint", "finished", 1) == 0)
               ? 0
               : -1;
}

static ry_status open_to_change(ry_result *result, ry_h5 *file, ry_error *error)
{
    if (result->broken) {
        return ry_fail(error, RY_BAD_FILE, "%s: writing failed before", result->part);
    }
    ry_status status = ry_lock_check_name(result->fd, result->part, error);
    status = status == RY_OK ? ry_h5_open(file, result->part, result->fd, RY_H5_CHANGE, error) : status;
    result->broken = status != RY_OK;
    return status;
}

static ry_status write_batch(void *data, ry_error *error)
{
    ry_result *const result = data;
    ry_batch *const b = &result->batch;
    ry_h5 file;
    RY_TRY(open_to_change(result, &file, error));
    const int failed = append_all(result, &file);
    const ry_status status = ry_h5_close(&file, failed, "append to it", error);
    if (status != RY_OK) {
        result->broken = 1;
        return status;
    }
    ry_table_clear(&b->rows.frames);
    ry_table_clear(&b->rows.profiles);
    ry_table_clear(&b->rows.series);
    if (b->checkpoint != NULL) {
        result->slot = result->slot == 0;
        ++result->sequence;
        ry_state_free(&b->copy); /* it is as large as the simulation's, and the next one is far */
    }
    return RY_OK;
}

/* --- what the run does --- */

int ry_result_is_busy(const ry_result *result)
{
    return result->writer != NULL && ry_writer_is_busy(result->writer);
}

ry_status ry_result_wait(ry_result *result, ry_error *error)
{
    return result->writer != NULL ? ry_writer_wait(result->writer, error) : RY_OK;
}

void ry_result_summary(ry_result *result, const ry_summary *summary, const ry_cost *cost)
{
    result->has_summary = 1;
    result->summary = *summary;
    result->cost = *cost;
}

static void hand_over(ry_result *result, const ry_state *checkpoint)
{
    ry_batch *const b = &result->batch;
    ry_table_hand_over(&result->rows.frames, &b->rows.frames);
    ry_table_hand_over(&result->rows.profiles, &b->rows.profiles);
    ry_table_hand_over(&result->rows.series, &b->rows.series);
    b->checkpoint = checkpoint;
    b->has_summary = result->has_summary;
    b->summary = result->summary;
    b->cost = result->cost;
    result->has_summary = 0;
    if (checkpoint != NULL) {
        free(b->window);
        b->window = result->window;
        b->n_window = result->n_window;
        result->window = NULL;
        result->n_window = 0;
    }
}

/* The run changes its state while it is written. */
static ry_status copy_checkpoint(ry_batch *b)
{
    const ry_state *const from = b->checkpoint;
    if (from == NULL) {
        return RY_OK;
    }
    if (b->copy.grains.x == NULL) {
        RY_TRY(ry_state_create(&b->copy, from->grains.n, from->column.nz, 0, NULL));
    }
    RY_TRY(ry_state_copy(&b->copy, from, NULL));
    b->checkpoint = &b->copy;
    return RY_OK;
}

ry_status ry_result_flush(ry_result *result, const ry_state *checkpoint, ry_error *error)
{
    RY_TRY(ry_result_wait(result, error));
    hand_over(result, checkpoint);
    if (result->writer == NULL) {
        result->writer = ry_writer_start();
    }
    if (result->writer == NULL || copy_checkpoint(&result->batch) != RY_OK) {
        return write_batch(result, error); /* no thread or no memory for it: the run waits */
    }
    ry_writer_begin(result->writer, write_batch, result);
    return RY_OK;
}

/* --- the end --- */

static ry_status finish(ry_result *result, const ry_state *state, ry_error *error)
{
    RY_TRY(ry_result_wait(result, error));
    hand_over(result, state);
    result->batch.finished = 1;
    RY_TRY(write_batch(result, error));
    RY_TRY(ry_lock_check_name(result->fd, result->part, error));
    if (!result->replace && access(result->path, F_OK) == 0) {
        return ry_fail(error, RY_BAD_FILE,
                       "%s: was made by someone else meanwhile; the result is in %s", result->path,
                       result->part);
    }
    if (rename(result->part, result->path) != 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be renamed to %s: %s", result->part,
                       result->path, strerror(errno));
    }
    return ry_xdmf_write(result->path, 1, error);
}

ry_status ry_result_finish(ry_result *result, const ry_state *state, ry_error *error)
{
    const ry_status status = finish(result, state, error);
    ry_result_close(result);
    return status;
}
