/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A result from its begin on: the head of the file, and rows in memory; flush.c brings them to the disk. */
#include "io/result.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/result_private.h"
#include "io/series.h"

#define GRAINS "particles/grains"

/* --- making and freeing --- */

static void add_frame_columns(ry_result *result)
{
#define ADD(name, type, components, unit, only_periodic, field, text)                            \
    if ((result->fields & field) != 0 && (!(only_periodic) || result->periodic)) {               \
        ry_table_add(&result->rows.frames, GRAINS "/" #name, unit, text, type, components, result->n, \
                     components);                                                                \
    }
    RY_LIST_frame(ADD);
#undef ADD
}

static void add_series_columns(ry_result *result)
{
#define ADD(member, path, unit, field, text)                                         \
    if ((result->fields & field) != 0) {                                             \
        ry_table_add(&result->rows.series, path, unit, text, H5T_NATIVE_DOUBLE, 0, 0, 0); \
    }
    RY_LIST_series(ADD);
#undef ADD
    if ((result->fields & RY_FIELD_FLUX) == 0) {
        ry_table_add(&result->rows.series, RY_HIDDEN_FLUX, "1", "for the mean flux of a resumed run",
                     H5T_NATIVE_DOUBLE, 0, 0, 0);
    }
}

void ry_result_add_profiles(ry_result *result, int32_t nz)
{
    result->nz = nz;
#define ADD(name, unit, text)                                                        \
    ry_table_add(&result->rows.profiles, "observables/profile_series/" #name, unit, text, \
                 H5T_NATIVE_DOUBLE, 1, nz, 0);
    RY_LIST_profile(ADD);
#undef ADD
}

ry_result *ry_result_new(const char *path, const ry_config *config, const ry_state *state,
                         ry_error *error)
{
    ry_result *const result = calloc(1, sizeof *result);
    if (result == NULL) {
        ry_no_memory(error, sizeof *result);
        return NULL;
    }
    const ry_derived derived = ry_config_derive(config);
    *result = (ry_result){.fd = -1,
                          .slot = -1,
                          .fields = config->output_fields,
                          .periodic = config->domain_periodic,
                          .n = state->grains.n};
    result->path = ry_text_print("%s", path);
    result->part = ry_text_print("%s.part", path);
    if (result->path == NULL || result->part == NULL) {
        ry_result_close(result);
        ry_no_memory(error, strlen(path));
        return NULL;
    }
    ry_table_init(&result->rows.frames, derived.steps_end / derived.steps_frame + 1);
    ry_table_init(&result->rows.profiles, derived.steps_end / derived.steps_frame + 1);
    ry_table_init(&result->rows.series, derived.steps_end / derived.steps_series + 1);
    add_frame_columns(result);
    add_series_columns(result);
    return result;
}

static void free_rows(ry_rows *rows)
{
    ry_table_free(&rows->frames);
    ry_table_free(&rows->profiles);
    ry_table_free(&rows->series);
}

void ry_result_close(ry_result *result)
{
    if (result == NULL) {
        return;
    }
    ry_writer_stop(result->writer);
    free_rows(&result->rows);
    free_rows(&result->batch.rows);
    ry_state_free(&result->batch.copy);
    free(result->batch.window);
    free(result->window);
    if (result->fd >= 0) {
        close(result->fd);
    }
    free(result->mean);
    free(result->flux);
    free(result->path);
    free(result->part);
    free(result);
}

/* --- the head of the file --- */

static int write_h5md(hid_t file)
{
    const int version[2] = {1, 1}, units[2] = {1, 0};
    return ry_h5_make_group(file, "h5md/author") == 0 &&
                   ry_h5_make_group(file, "h5md/creator") == 0 &&
                   ry_h5_make_group(file, "h5md/modules/units") == 0 &&
                   ry_h5_set_numbers(file, "h5md", "version", H5T_NATIVE_INT, 2, version) == 0 &&
                   ry_h5_set_text(file, "h5md/author", "name", "unknown") == 0 &&
                   ry_h5_set_text(file, "h5md/creator", "name", "ryusa") == 0 &&
                   ry_h5_set_text(file, "h5md/creator", "version", ry_version()) == 0 &&
                   ry_h5_set_numbers(file, "h5md/modules/units", "version", H5T_NATIVE_INT, 2,
                                     units) == 0 &&
                   ry_h5_set_text(file, "h5md/modules/units", "system", "SI") == 0
               ? 0
               : -1;
}

/* The box is as high as the fluid column; without one, as the grains at the start. */
static double box_height(const ry_state *state)
{
    double height = state->column.nz * state->column.dz;
    for (int32_t k = 0; state->column.nz == 0 && k < state->grains.n; ++k) {
        height = fmax(height, state->grains.z[k] + state->grains.radius[k]);
    }
    return height;
}

static int write_box(hid_t file, const ry_config *config, const ry_state *state)
{
    const char *const path = GRAINS "/box";
    const char *const boundary[2] = {config->domain_periodic ? "periodic" : "none", "none"};
    const double edges[2] = {ry_config_derive(config).length, box_height(state)};
    const ry_h5_shape shape = {H5T_NATIVE_DOUBLE, 1, {2}};
    return ry_h5_make_group(file, path) == 0 &&
                   ry_h5_set_integer(file, path, "dimension", 2) == 0 &&
                   ry_h5_set_texts(file, path, "boundary", 2, boundary) == 0 &&
                   ry_h5_write(file, GRAINS "/box/edges", &shape, edges) == 0 &&
                   ry_h5_set_unit(file, GRAINS "/box/edges", "m") == 0
               ? 0
               : -1;
}

/* What never changes, in id order. */
static int write_fixed(hid_t file, const ry_grains *grains)
{
    const ry_h5_shape real = {H5T_NATIVE_DOUBLE, 1, {(hsize_t)grains->n}};
    const ry_h5_shape whole = {H5T_NATIVE_INT32, 1, {(hsize_t)grains->n}};
    double *const diameter = ry_array((size_t)grains->n, sizeof(double));
    double *const density = ry_array((size_t)grains->n, sizeof(double));
    int32_t *const id = ry_array((size_t)grains->n, sizeof(int32_t));
    int32_t *const fixed = ry_array((size_t)grains->n, sizeof(int32_t));
    int failed = diameter == NULL || density == NULL || id == NULL || fixed == NULL;
    for (int32_t k = 0; !failed && k < grains->n; ++k) {
        const int32_t to = grains->id[k];
        diameter[to] = 2.0 * grains->radius[k];
        density[to] = grains->density[k];
        id[to] = to;
        fixed[to] = grains->fixed[k];
    }
    failed = failed || ry_h5_write(file, GRAINS "/diameter", &real, diameter) != 0 ||
             ry_h5_set_unit(file, GRAINS "/diameter", "m") != 0 ||
             ry_h5_write(file, GRAINS "/density", &real, density) != 0 ||
             ry_h5_set_unit(file, GRAINS "/density", "kg/m^3") != 0 ||
             ry_h5_write(file, GRAINS "/id", &whole, id) != 0 ||
             ry_h5_write(file, GRAINS "/fixed", &whole, fixed) != 0;
    free(diameter);
    free(density);
    free(id);
    free(fixed);
    return failed ? -1 : 0;
}

static int write_head(ry_result *result, const ry_h5 *file, const ry_config *config,
                      const ry_state *state)
{
    return write_h5md(file->id) == 0 && write_box(file->id, config, state) == 0 &&
                   write_fixed(file->id, &state->grains) == 0 &&
                   ry_h5_make_group(file->id, "observables") == 0 &&
                   ry_h5_make_group(file->id, "checkpoint") == 0 &&
                   ry_h5_set_integer(file->id, "checkpoint", "finished", 0) == 0 &&
                   ry_parameters_write(file->id, config) == 0 &&
                   ry_table_append(&result->rows.frames, file) == 0 &&
                   ry_table_append(&result->rows.series, file) == 0
               ? 0
               : -1;
}

/* An interrupted run that --resume could go on with isn't thrown away unasked. */
static ry_status check_leftover(const ry_result *result, int force, ry_error *error)
{
    ry_h5 file;
    if (force || ry_h5_open(&file, result->part, result->fd, RY_H5_READ, NULL) != RY_OK) {
        return RY_OK;
    }
    char *hash = NULL;
    const int resumable = ry_h5_get_text(file.id, "checkpoint", "state_hash", &hash) == 0;
    free(hash);
    ry_h5_close(&file, 1, "", NULL);
    return resumable ? ry_fail(error, RY_BAD_FILE,
                               "%s: holds a run that was interrupted; --resume goes on with it, "
                               "--force starts anew",
                               result->part)
                     : RY_OK;
}

static ry_status begin_file(ry_result *result, const ry_config *config, const ry_state *state,
                            int force, ry_error *error)
{
    RY_TRY(ry_lock_check_path(result->part, error));
    RY_TRY(ry_lock_open(result->part, 1, &result->fd, error));
    RY_TRY(check_leftover(result, force, error));
    ry_atomic_forget_journal(result->part);
    if (ftruncate(result->fd, 0) != 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: %s", result->part, strerror(errno));
    }
    ry_h5 file;
    ry_status status = ry_h5_open(&file, result->part, result->fd, RY_H5_CREATE, error);
    if (status == RY_OK) {
        status = ry_h5_close(&file, write_head(result, &file, config, state), "begin it", error);
    }
    if (status != RY_OK) {
        unlink(result->part);
        ry_atomic_forget_journal(result->part);
    }
    return status;
}

ry_status ry_result_create(ry_result **result, const char *path, const ry_config *config,
                           const ry_state *state, int force, ry_error *error)
{
    *result = NULL;
    RY_TRY(ry_lock_check_path(path, error));
    if (!force && access(path, F_OK) == 0) {
        return ry_fail(error, RY_BAD_FILE, "%s: exists; --force overwrites it", path);
    }
    ry_result *const made = ry_result_new(path, config, state, error);
    if (made == NULL) {
        return RY_BAD_FILE;
    }
    made->replace = force;
    const ry_status status = begin_file(made, config, state, force, error);
    if (status != RY_OK) {
        ry_result_close(made);
        return status;
    }
    ry_table_clear(&made->rows.frames);
    ry_table_clear(&made->rows.series);
    *result = made;
    return RY_OK;
}

/* --- rows --- */

static ry_status flush_if_full(ry_result *result, ry_error *error)
{
    const size_t bytes = ry_table_bytes(&result->rows.frames) + ry_table_bytes(&result->rows.profiles) +
                         ry_table_bytes(&result->rows.series);
    return bytes > RY_RESULT_BYTES ? ry_result_flush(result, NULL, error) : RY_OK;
}

static void fill_position(const ry_grains *grains, int32_t k, double *to)
{
    to[0] = grains->x[k];
    to[1] = grains->z[k];
}

static void fill_image(const ry_grains *grains, int32_t k, int32_t *to)
{
    to[0] = grains->image[k];
    to[1] = 0;
}

static void fill_velocity(const ry_grains *grains, int32_t k, double *to)
{
    to[0] = grains->vx[k];
    to[1] = grains->vz[k];
}

static void fill_spin(const ry_grains *grains, int32_t k, double *to)
{
    to[0] = grains->spin[k];
}

ry_status ry_result_frame(ry_result *result, const ry_state *state, ry_error *error)
{
    if (result->rows.frames.n_columns == 0) {
        return RY_OK;
    }
    const int begun = ry_table_begin(&result->rows.frames, state->step, state->time);
    if (begun <= 0) {
        return begun < 0 ? ry_no_memory(error, 0) : RY_OK;
    }
    const ry_grains *const grains = &state->grains;
    int column = 0;
#define FILL(name, type, components, unit, only_periodic, field, text)                    \
    if ((result->fields & field) != 0 && (!(only_periodic) || result->periodic)) {        \
        const size_t item = (components)*result->rows.frames.column[column].item;         \
        void *const row = ry_table_cell(&result->rows.frames, column++);                  \
        for (int32_t k = 0; k < grains->n; ++k) {                                         \
            fill_##name(grains, k, (void *)((char *)row + (size_t)grains->id[k] * item)); \
        }                                                                                 \
    }
    RY_LIST_frame(FILL);
#undef FILL
    return flush_if_full(result, error);
}

ry_status ry_result_profile(ry_result *result, const ry_state *state, const ry_profile *profile,
                            ry_error *error)
{
    if ((result->fields & RY_FIELD_PROFILE) == 0 || profile->nz <= 0) {
        return RY_OK;
    }
    if (result->rows.profiles.n_columns == 0) {
        RY_TRY(ry_result_wait(result, error)); /* HDF5 tells the size of a number */
        ry_result_add_profiles(result, profile->nz);
        result->dz = profile->dz;
    }
    if (profile->nz != result->nz) {
        return ry_fail(error, RY_BAD_INPUT, "a profile has %d cells, the ones before had %d",
                       profile->nz, result->nz);
    }
    const int begun = ry_table_begin(&result->rows.profiles, state->step, state->time);
    if (begun <= 0) {
        return begun < 0 ? ry_no_memory(error, 0) : RY_OK;
    }
    int column = 0;
#define FILL(name, unit, text)                                        \
    memcpy(ry_table_cell(&result->rows.profiles, column++), profile->name, \
           (size_t)profile->nz * sizeof(double));
    RY_LIST_profile(FILL);
#undef FILL
    return flush_if_full(result, error);
}

ry_status ry_result_sample(ry_result *result, const ry_state *state, const ry_sample *sample,
                           ry_error *error)
{
    if (!ry_result_is_busy(result)) {
        RY_TRY(ry_result_wait(result, error)); /* a failure is told at once */
    }
    const int begun = ry_table_begin(&result->rows.series, state->step, state->time);
    if (begun <= 0) {
        return begun < 0 ? ry_no_memory(error, 0) : RY_OK;
    }
    RY_TRY(ry_array_grow(&result->flux, &result->flux_capacity, result->n_flux, result->n_flux + 1,
                         sizeof(double), error));
    result->flux[result->n_flux++] = sample->q_star;
    int column = 0;
#define FILL(member, path, unit, field, text)                                 \
    if ((result->fields & field) != 0) {                                      \
        *(double *)ry_table_cell(&result->rows.series, column++) = sample->member; \
    }
    RY_LIST_series(FILL);
#undef FILL
    if ((result->fields & RY_FIELD_FLUX) == 0) {
        *(double *)ry_table_cell(&result->rows.series, column) = sample->q_star;
    }
    return flush_if_full(result, error);
}

ry_status ry_result_put_window(ry_result *result, const double *values, int64_t n, ry_error *error)
{
    double *const window = n > 0 ? ry_array((size_t)n, sizeof *window) : NULL;
    if (n > 0 && window == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *window);
    }
    if (n > 0) {
        memcpy(window, values, (size_t)n * sizeof *window);
    }
    free(result->window);
    result->window = window;
    result->n_window = n;
    return RY_OK;
}

const double *ry_result_get_window(const ry_result *result, int64_t *n)
{
    *n = result->n_window;
    return result->window;
}

const double *ry_result_flux_series(const ry_result *result, int64_t *n)
{
    *n = (int64_t)result->n_flux;
    return result->flux;
}
