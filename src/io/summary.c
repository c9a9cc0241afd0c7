/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a run found and what it cost: /observables/flux, /observables/profile and /cost; and the mean
 * of the profiles, made from the file so that they needn't stay in memory. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/result_private.h"
#include "io/series.h"

#define FLUX "observables/flux"
#define COST "cost"

/* Its unit stands under its name with ".unit". */
static int set_quantity(hid_t file, const char *name, double value, const char *unit)
{
    char words[60];
    snprintf(words, sizeof words, "%s.unit", name);
    return ry_h5_set_number(file, FLUX, name, value) == 0 ? ry_h5_set_text(file, FLUX, words, unit) : -1;
}

static int write_flux(hid_t file, const ry_summary *summary)
{
    const char *const method = summary->equilibration_method;
    return ry_h5_make_group(file, FLUX) == 0 &&
                   ry_h5_set_number(file, FLUX, "q_star_mean", summary->q_star_mean) == 0 &&
                   ry_h5_set_number(file, FLUX, "q_star_standard_error",
                                    summary->q_star_standard_error) == 0 &&
                   set_quantity(file, "autocorrelation_time", summary->autocorrelation_time, "s") == 0 &&
                   ry_h5_set_integer(file, FLUX, "samples", summary->samples) == 0 &&
                   ry_h5_set_number(file, FLUX, "effective_samples", summary->effective_samples) == 0 &&
                   set_quantity(file, "equilibration_time", summary->equilibration_time, "s") == 0 &&
                   set_quantity(file, "width", summary->width, "m") == 0 &&
                   (summary->is_dry || (ry_h5_set_number(file, FLUX, "shields", summary->shields) == 0 &&
                                        set_quantity(file, "shear_stress", summary->shear_stress, "Pa") == 0)) &&
                   ry_h5_set_text(file, FLUX, "equilibration_method",
                                  method != NULL ? method : "") == 0 &&
                   ry_h5_set_integer(file, FLUX, "stopped_early", summary->stopped_early) == 0 &&
                   ry_h5_set_text(file, FLUX, "convention",
                                  summary->is_dry ? RY_CONVENTION("") : RY_CONVENTION("(s-1) ")) == 0
               ? 0
               : -1;
}

static int write_row(hid_t file, const char *path, const char *unit, const char *text, int nz,
                     const double *values)
{
    const ry_h5_shape shape = {H5T_NATIVE_DOUBLE, 1, {(hsize_t)nz}};
    return ry_h5_write(file, path, &shape, values) == 0 && ry_h5_set_unit(file, path, unit) == 0 &&
                   ry_h5_set_text(file, path, "description", text) == 0
               ? 0
               : -1;
}

static int write_heights(hid_t file, const char *path, int nz, double dz)
{
    double *const z = ry_array((size_t)nz, sizeof *z);
    if (z == NULL) {
        return -1;
    }
    for (int k = 0; k < nz; ++k) {
        z[k] = (k + 0.5) * dz;
    }
    const int written = write_row(file, path, "m", "height of the centre of the cell", nz, z);
    free(z);
    return written;
}

static int write_profile(hid_t file, const ry_profile *profile, int64_t n_averaged)
{
    if (profile->nz <= 0) {
        return 0;
    }
    if (write_heights(file, "observables/profile/z", profile->nz, profile->dz) != 0) {
        return -1;
    }
#define WRITE(name, unit, text)                                                                  \
    if (write_row(file, "observables/profile/" #name, unit, text, profile->nz, profile->name) != \
        0) {                                                                                     \
        return -1;                                                                               \
    }
    RY_LIST_profile(WRITE);
#undef WRITE
    return ry_h5_set_integer(file, "observables/profile", "frames", n_averaged);
}

static int write_cost(hid_t file, const ry_cost *cost)
{
    int failed =
        ry_h5_make_group(file, COST) != 0 || ry_h5_make_group(file, COST "/stages") != 0 ||
        ry_h5_set_number(file, COST, "wall_seconds", cost->wall_seconds) != 0 ||
        ry_h5_set_number(file, COST, "grain_steps_per_second", cost->grain_steps_per_second) != 0 ||
        ry_h5_set_integer(file, COST, "rebuilds", cost->rebuilds) != 0 ||
        ry_h5_set_integer(file, COST, "threads", cost->threads) != 0 ||
        (!isnan(cost->asleep) && ry_h5_set_number(file, COST, "asleep", cost->asleep) != 0);
    for (int k = 0; k < cost->n_stages && !failed; ++k) {
        failed = ry_h5_set_number(file, COST "/stages", cost->stage_name[k],
                                  cost->stage_seconds[k]) != 0;
    }
    return failed ? -1 : 0;
}

/* --- mean profile --- */

/* Profiles are read in blocks of this many rows. */
enum { BLOCK_ROWS = 256 };

#define COLUMN(name, unit, text) COLUMN_##name,
enum { RY_LIST_profile(COLUMN) };
#undef COLUMN

/* Adds rows to a sum, times the rows of `weight` if there are any, in the order in which they were made, however often
 * the run was interrupted. */
static void add_rows(double *total, int nz, const double *rows, const double *weight, int64_t n)
{
    for (int64_t row = 0; row < n; ++row) {
        for (int k = 0; k < nz; ++k) {
            total[k] += rows[row * nz + k] * (weight != NULL ? weight[row * nz + k] : 1.0);
        }
    }
}

/* The first row in the file behind `time`, and how many rows there are. */
static int find_first(hid_t file, double time, int64_t *first, int64_t *rows)
{
    static const char path[] = "observables/profile_series/phi/time";
    ry_h5_shape shape;
    *first = *rows = 0;
    if (ry_h5_get_shape(file, path, &shape) != 0 || shape.rank != 1 || shape.size[0] == 0) {
        return 0;
    }
    double *const times = ry_array((size_t)shape.size[0], sizeof *times);
    const int failed =
        times == NULL || ry_h5_read(file, path, H5T_NATIVE_DOUBLE, shape.size[0], times) != 0;
    if (!failed) {
        *rows = (int64_t)shape.size[0];
        while (*first < *rows && times[*first] <= time) {
            ++*first;
        }
    }
    free(times);
    return failed ? -1 : 0;
}

static int read_block(hid_t file, const char *element, int64_t row, int64_t n, double *block)
{
    char path[200];
    snprintf(path, sizeof path, "%s/value", element);
    return ry_h5_read_rows(file, path, H5T_NATIVE_DOUBLE, (hsize_t)row, (hsize_t)n, block);
}

/* `weight`: the element whose rows weigh those of `element`; NULL: all weigh the same. */
static int add_from_file(const ry_result *result, hid_t file, const char *element, const char *weight,
                         double time, double *total, int64_t *count)
{
    int64_t first = 0, rows = 0;
    const size_t size = (size_t)result->nz * BLOCK_ROWS;
    double *const block = ry_array(2 * size, sizeof *block);
    int failed = block == NULL || find_first(file, time, &first, &rows) != 0;
    for (int64_t row = first; row < rows && !failed; row += BLOCK_ROWS) {
        const int64_t n = rows - row < BLOCK_ROWS ? rows - row : BLOCK_ROWS;
        failed = read_block(file, element, row, n, block) != 0 ||
                 (weight != NULL && read_block(file, weight, row, n, block + size) != 0);
        if (!failed) {
            add_rows(total, result->nz, block, weight != NULL ? block + size : NULL, n);
            *count += n;
        }
    }
    free(block);
    return failed ? -1 : 0;
}

/* The velocity of the grains is weighted by their volume: frames in which no grain is in a cell don't count there. */
static double *mean_of_column(ry_result *result, hid_t file, int k, double time, int64_t *count)
{
    const ry_table *const table = &result->batch.rows.profiles;
    const ry_table_column *const column = &table->column[k];
    const ry_table_column *const weight = k == COLUMN_u_grain ? &table->column[COLUMN_phi] : NULL;
    const int nz = result->nz;
    double *const total = result->mean + (size_t)k * (size_t)nz;
    memset(total, 0, (size_t)nz * sizeof *total);
    *count = 0;
    if (add_from_file(result, file, column->path, weight != NULL ? weight->path : NULL, time, total, count) != 0) {
        *count = 0;
        return total;
    }
    const double *const phi = result->mean + (size_t)COLUMN_phi * (size_t)nz; /* done before */
    for (int j = 0; j < nz && *count > 0; ++j) {
        const double weights = weight != NULL ? phi[j] * (double)*count : (double)*count;
        total[j] = weights > 0.0 ? total[j] / weights : 0.0;
    }
    return total;
}

/* Of the frames after `time`; nz = 0: there are none. */
static ry_profile mean_profile(ry_result *result, hid_t file, double time, int64_t *count)
{
    ry_profile profile = {0};
    *count = 0;
    if (result->batch.rows.profiles.n_columns == 0) {
        return profile;
    }
    if (result->mean == NULL) {
        result->mean = ry_array(RY_TABLE_COLUMNS * (size_t)result->nz, sizeof(double));
    }
    if (result->mean == NULL) {
        return profile;
    }
    int column = 0;
#define MEAN(name, unit, text) profile.name = mean_of_column(result, file, column++, time, count);
    RY_LIST_profile(MEAN);
#undef MEAN
    profile.dz = result->dz;
    profile.nz = *count > 0 ? result->nz : 0;
    return profile;
}

int ry_result_write_summary(ry_result *result, hid_t file)
{
    const ry_summary *const summary = &result->batch.summary;
    int64_t count = 0;
    ry_profile profile = {0};
    if (summary->has_profile) {
        profile = mean_profile(result, file, summary->profile_from, &count);
    }
    return write_flux(file, summary) == 0 && write_profile(file, &profile, count) == 0 &&
                   write_cost(file, &result->batch.cost) == 0
               ? 0
               : -1;
}

/* --- what a finished run had found --- */

static void read_flux(hid_t file, ry_summary *summary)
{
    int64_t samples = 0, early = 0;
    if (!ry_h5_exists(file, FLUX)) {
        return;
    }
    ry_h5_get_number(file, FLUX, "q_star_mean", &summary->q_star_mean);
    ry_h5_get_number(file, FLUX, "q_star_standard_error", &summary->q_star_standard_error);
    ry_h5_get_number(file, FLUX, "autocorrelation_time", &summary->autocorrelation_time);
    ry_h5_get_number(file, FLUX, "equilibration_time", &summary->equilibration_time);
    ry_h5_get_integer(file, FLUX, "samples", &samples);
    ry_h5_get_integer(file, FLUX, "stopped_early", &early);
    summary->samples = samples;
    summary->stopped_early = (int)early;
}

ry_status ry_result_read_summary(const char *path, ry_summary *summary, unsigned long long *hash,
                                 ry_error *error)
{
    ry_h5 file;
    char *text = NULL;
    *summary = (ry_summary){.q_star_mean = NAN, .q_star_standard_error = NAN};
    *hash = 0;
    RY_TRY(ry_h5_open(&file, path, -1, RY_H5_READ, error));
    const ry_status status = ry_parameters_check_ours(file.id, path, error);
    if (status == RY_OK) {
        read_flux(file.id, summary);
        if (ry_h5_exists(file.id, "checkpoint") &&
            ry_h5_get_text(file.id, "checkpoint", "state_hash", &text) == 0) {
            *hash = strtoull(text, NULL, 16);
        }
    }
    free(text);
    ry_h5_close(&file, 1, "", NULL);
    return status;
}
