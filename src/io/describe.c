/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa info`: what a result file holds. Works on a finished file, on the .part of a run that goes
 * on or was killed, and on one that holds only some of the fields; what isn't there isn't told. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/link.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/result_private.h"
#include "io/series.h"

typedef struct page {
    ry_write_fn *write;
    void *data;
    hid_t file;
} page;

#define say(to, ...) ry_text_say((to)->write, (to)->data, __VA_ARGS__)

/* --- what is read --- */

static double number(const page *of, const char *path, const char *name)
{
    double value = NAN;
    return ry_h5_exists(of->file, path) && ry_h5_get_number(of->file, path, name, &value) == 0
               ? value
               : NAN;
}

static long long integer(const page *of, const char *path, const char *name)
{
    int64_t value = 0;
    return ry_h5_exists(of->file, path) && ry_h5_get_integer(of->file, path, name, &value) == 0
               ? value
               : 0;
}

static int64_t length(const page *of, const char *path)
{
    ry_h5_shape shape;
    return ry_h5_get_shape(of->file, path, &shape) == 0 && shape.rank > 0 ? (int64_t)shape.size[0]
                                                                          : 0;
}

/* All numbers of an array of one direction; NULL if it isn't there or empty. */
static double *numbers(const page *of, const char *path, int64_t *n)
{
    ry_h5_shape shape;
    *n = 0;
    if (ry_h5_get_shape(of->file, path, &shape) != 0 || shape.rank != 1 || shape.size[0] == 0) {
        return NULL;
    }
    double *const values = ry_array((size_t)shape.size[0], sizeof *values);
    if (values == NULL ||
        ry_h5_read(of->file, path, H5T_NATIVE_DOUBLE, shape.size[0], values) != 0) {
        free(values);
        return NULL;
    }
    *n = (int64_t)shape.size[0];
    return values;
}

/* Row `row` of a series, counted from the end if negative; NAN if there is none. */
static double sample(const page *of, const char *path, int64_t row)
{
    char value[200];
    double found = NAN;
    snprintf(value, sizeof value, "%s/value", path);
    const int64_t n = length(of, value), at = row < 0 ? n + row : row;
    return at >= 0 && at < n &&
                   ry_h5_read_rows(of->file, value, H5T_NATIVE_DOUBLE, (hsize_t)at, 1, &found) == 0
               ? found
               : NAN;
}

/* --- what is told --- */

static void tell_text(const page *to, const char *label, const char *path, const char *name)
{
    char *text = NULL;
    if (ry_h5_exists(to->file, path) && ry_h5_get_text(to->file, path, name, &text) == 0 &&
        text[0] != '\0') {
        say(to, "%-14s %s\n", label, text);
    }
    free(text);
}

static void tell_head(const page *to, const char *path)
{
    const int finished = integer(to, "checkpoint", "finished") != 0;
    say(to, "%-14s %s\n", "file", path);
    tell_text(to, "title", "parameters", "title");
    say(to, "%-14s %s\n", "state",
        finished ? "finished"
                 : "not finished: the run goes on, or was interrupted (--resume goes on with it)");
    tell_text(to, "written by", "h5md/creator", "name");
    tell_text(to, "version", "h5md/creator", "version");
    char *scene = NULL;
    if (ry_h5_read_text(to->file, "parameters/scene", &scene) == 0) {
        int lines = scene[0] != '\0';
        for (const char *c = scene; *c != '\0'; ++c) {
            lines += *c == '\n' && c[1] != '\0';
        }
        say(to, "%-14s %d lines, kept in /parameters/scene\n", "scene", lines);
    }
    free(scene);
    tell_text(to, "state hash", "checkpoint", "state_hash");
}

static void tell_range(const page *to, const char *label, const char *path, const char *unit)
{
    int64_t n = 0;
    double *const values = numbers(to, path, &n);
    if (values == NULL) {
        return;
    }
    double low = values[0], high = values[0];
    for (int64_t k = 1; k < n; ++k) {
        low = fmin(low, values[k]);
        high = fmax(high, values[k]);
    }
    free(values);
    if (low == high) {
        say(to, "%-14s %.6g %s\n", label, low, unit);
    } else {
        say(to, "%-14s %.6g to %.6g %s\n", label, low, high, unit);
    }
}

static void tell_grains(const page *to)
{
    int64_t n = 0;
    double *const fixed = numbers(to, "particles/grains/fixed", &n);
    long long still = 0;
    for (int64_t k = 0; k < n; ++k) {
        still += fixed[k] != 0.0;
    }
    free(fixed);
    say(to, "%-14s %lld", "grains", (long long)n);
    say(to, still > 0 ? ", %lld of them fixed\n" : "\n", still);
    tell_range(to, "diameter", "particles/grains/diameter", "m");
    tell_range(to, "density", "particles/grains/density", "kg/m^3");
    double edges[2];
    if (ry_h5_exists(to->file, "particles/grains/box/edges") &&
        ry_h5_read(to->file, "particles/grains/box/edges", H5T_NATIVE_DOUBLE, 2, edges) == 0) {
        say(to, "%-14s %.6g m x %.6g m, %s along x\n", "box", edges[0], edges[1],
            integer(to, "parameters", "domain.periodic") ? "periodic" : "not periodic");
    }
}

static void tell_rows(const page *to, const char *label, const char *path)
{
    char time[200];
    snprintf(time, sizeof time, "%s/time", path);
    int64_t n = 0;
    double *const times = numbers(to, time, &n);
    if (n > 1) {
        say(to, "%-14s %lld, from %.6g s to %.6g s, every %.6g s\n", label, (long long)n, times[0],
            times[n - 1], (times[n - 1] - times[0]) / (double)(n - 1));
    } else if (n == 1) {
        say(to, "%-14s 1, at %.6g s\n", label, times[0]);
    }
    free(times);
}

static void tell_extent(const page *to)
{
    static const char *const slots[] = {"checkpoint/a", "checkpoint/b"};
    const int newest = integer(to, slots[1], "sequence") > integer(to, slots[0], "sequence");
    const double step = number(to, slots[newest], "step");
    if (step >= 0.0) {
        say(to, "%-14s %.6g s, step %.0f of %.0f\n", "simulated", number(to, slots[newest], "time"),
            step,
            rint(number(to, "parameters", "time.end") / number(to, "parameters", "time.step")));
    } else {
        say(to, "%-14s no checkpoint yet\n", "simulated");
    }
    static const char *const frames[] = {"position", "velocity", "spin"};
    for (size_t k = 0; k < sizeof frames / sizeof frames[0]; ++k) {
        char path[60];
        snprintf(path, sizeof path, "particles/grains/%s", frames[k]);
        if (ry_h5_exists(to->file, path)) {
            tell_rows(to, "frames", path);
            break;
        }
    }
    tell_rows(to, "samples",
              ry_h5_exists(to->file, "observables/q_star") ? "observables/q_star"
                                                           : "observables/energy/kinetic");
}

static void tell_flux(const page *to)
{
    static const char path[] = "observables/flux";
    if (ry_h5_exists(to->file, path)) {
        const double mean = number(to, path, "q_star_mean");
        const double error = number(to, path, "q_star_standard_error");
        if (isnan(mean)) {
            say(to, "\nflux\n%-14s not known: the run has no samples with the fluid on\n", "  q*");
        } else {
            say(to, "\nflux\n%-14s %.5g +- %.2g (standard error)\n", "  q*", mean, error);
        }
        tell_text(to, "  convention", path, "convention");
        say(to, "%-14s %lld, autocorrelation time %.3g s, after %.4g s\n", "  samples",
            integer(to, path, "samples"), number(to, path, "autocorrelation_time"),
            number(to, path, "equilibration_time"));
        tell_text(to, "  cut", path, "equilibration_method");
        if (integer(to, path, "stopped_early")) {
            say(to, "%-14s ended early: the flux was known well enough\n", "");
        }
    } else if (!isnan(sample(to, "observables/q_star", -1))) {
        say(to, "\nflux\n%-14s no mean yet; the last sample is %.5g\n", "  q*",
            sample(to, "observables/q_star", -1));
    }
    const double level = sample(to, "observables/bed_level", -1);
    if (!isnan(level)) {
        say(to, "%-14s %.5g m at the last sample\n", "  bed level", level);
    }
}

static double stored(const ry_sample *at)
{
    return at->kinetic_energy + at->gravity_energy + at->elastic_normal + at->elastic_tangential;
}

/* What was gained less what was lost since step 0. */
static double balance(const ry_sample *at)
{
    return at->fluid_work + at->integration - at->loss_impact - at->loss_dashpot -
           at->loss_friction - at->loss_opening;
}

static void tell_closure(const page *to, const ry_sample *first, const ry_sample *last)
{
    const double change = stored(last) - stored(first);
    const double rest = change - (balance(last) - balance(first));
    const double turned = fmax(fabs(change), fabs(last->fluid_work - first->fluid_work));
    say(to,
        "  %-20s %13.6g  what these rows leave unexplained of the change since the first sample\n",
        "closure", rest);
    if (turned > 0.0) {
        say(to, "  %-20s %13.2e  of the larger of that change and the work of the fluid\n", "",
            fabs(rest) / turned);
    }
}

static void tell_energy(const page *to)
{
    if (isnan(sample(to, "observables/energy/kinetic", -1))) {
        return;
    }
    ry_sample first = {0}, last = {0};
    say(to, "\nenergy at the last sample [J]\n");
#define ROW(member, path, unit, field, text) \
    first.member = sample(to, path, 0);      \
    last.member = sample(to, path, -1);      \
    say(to, "  %-20s %13.6g  %s\n", strrchr(path, '/') + 1, last.member, text);
    RY_LIST_energy(ROW);
#undef ROW
    tell_closure(to, &first, &last);
}

static void tell_profile_row(const page *to, double *const *columns, int n_columns, int64_t k)
{
    for (int j = 0; j < n_columns; ++j) {
        say(to, " %14.4g", columns[j] != NULL ? columns[j][k] : NAN);
    }
    say(to, "\n");
}

/* The clear flow above the bed says little: the table ends a little above the highest grains. */
static int64_t cells_with_grains(const double *phi, int64_t n)
{
    int64_t top = n;
    while (top > 0 && phi[top - 1] < 1e-4) {
        --top;
    }
    return top == 0 || top + 2 > n ? n : top + 2;
}

static void tell_profile(const page *to)
{
    enum { COLUMNS = 6, ROWS = 12 };
    double *columns[COLUMNS] = {NULL};
    int64_t n = 0, least = INT64_MAX;
    int used = 0;
    columns[used++] = numbers(to, "observables/profile/z", &least);
#define COLUMN(name, unit, text)                                     \
    columns[used++] = numbers(to, "observables/profile/" #name, &n); \
    least = n < least ? n : least;
    RY_LIST_profile(COLUMN);
#undef COLUMN
    least = least > 0 ? cells_with_grains(columns[1], least) : 0;
    if (least > 0) {
        say(to, "\nmean profile over %lld frames\n ", integer(to, "observables/profile", "frames"));
        say(to, " %14s", "z[m]");
#define HEAD(name, unit, text) say(to, " %14s", unit[0] == '1' ? #name : #name "[" unit "]");
        RY_LIST_profile(HEAD);
#undef HEAD
        say(to, "\n");
        const int64_t rows = least < ROWS ? least : ROWS;
        for (int64_t k = rows - 1; k >= 0; --k) {
            say(to, " ");
            tell_profile_row(to, columns, used, (2 * k + 1) * least / (2 * rows));
        }
    }
    for (int j = 0; j < used; ++j) {
        free(columns[j]);
    }
}

static herr_t tell_stage(hid_t group, const char *name, const H5A_info_t *info, void *data)
{
    const page *const to = data;
    (void)info;
    double seconds = 0.0;
    if (ry_h5_get_number(group, ".", name, &seconds) == 0) {
        say(to, "    %-20s %10.4g s\n", name, seconds);
    }
    return 0;
}

static void tell_cost(page *to)
{
    if (!ry_h5_exists(to->file, "cost")) {
        return;
    }
    say(to, "\ncost\n%-14s %.4g s of steps, %lld threads\n", "  wall time",
        number(to, "cost", "wall_seconds"), integer(to, "cost", "threads"));
    say(to, "%-14s %.4g grain-steps/s, neighbour list rebuilt %lld times\n", "  rate",
        number(to, "cost", "grain_steps_per_second"), integer(to, "cost", "rebuilds"));
    if (ry_h5_exists(to->file, "cost") && H5Aexists_by_name(to->file, "cost", "asleep", H5P_DEFAULT) > 0) {
        say(to, "%-14s %.1f %% of the grains in the mean\n", "  asleep", 100.0 * number(to, "cost", "asleep"));
    }
    const hid_t stages =
        ry_h5_exists(to->file, "cost/stages") ? H5Gopen2(to->file, "cost/stages", H5P_DEFAULT) : -1;
    if (stages >= 0) {
        H5Aiterate2(stages, H5_INDEX_NAME, H5_ITER_INC, NULL, tell_stage, to);
        H5Gclose(stages);
    }
}

static void tell_parameter(const page *to, const ry_parameter *parameter)
{
    char name[100], *word = NULL;
    snprintf(name, sizeof name, "%s.%s", parameter->section, parameter->key);
    const double value = number(to, "parameters", name);
    if (parameter->type == 'c' && ry_h5_get_text(to->file, "parameters", name, &word) == 0) {
        say(to, "  %-24s %s\n", name, word);
    } else if (parameter->type == 'f' && !isnan(value)) {
        say(to, "  %-24s %s\n", name, value != 0.0 ? "true" : "false");
    } else if (parameter->type != 'c' && !isnan(value)) {
        const int plain = parameter->unit == NULL || strcmp(parameter->unit, "1") == 0;
        say(to, "  %-24s %.8g%s%s\n", name, value, plain ? "" : " ", plain ? "" : parameter->unit);
    }
    free(word);
}

/* Those that this scene uses. */
static void tell_parameters(const page *to)
{
    const int has_grains = integer(to, "parameters", "has_grains") != 0;
    char *model = NULL;
    const int dry = ry_h5_get_text(to->file, "parameters", "fluid.model", &model) == 0 &&
                    strcmp(model, "none") == 0;
    free(model);
    ry_config names = ry_config_default(has_grains);
    ry_parameter parameter;
    say(to, "\nparameters (SI)\n");
    for (int k = 0; ry_config_parameter(&names, k, &parameter); ++k) {
        const int unused = (dry && strcmp(parameter.section, "fluid") == 0 &&
                            strcmp(parameter.key, "model") != 0) ||
                           (!has_grains && strcmp(parameter.section, "grains") == 0);
        if (!unused) {
            tell_parameter(to, &parameter);
        }
    }
    ry_config_free(&names);
    tell_text(to, "  output.fields           ", "parameters", "output.fields");
    const int64_t particles = length(to, "parameters/particles");
    if (particles > 0) {
        say(to, "  %-24s %lld, in /parameters/particles\n", "particles", (long long)particles);
    }
}

/* The file of a run that goes on, or was stopped, has another name. */
static ry_status find_part(const char *file, ry_error *error)
{
    char *target = NULL;
    if (access(file, F_OK) == 0 || ry_link_follow(file, &target, NULL) != RY_OK) {
        return RY_OK; /* the file itself will tell */
    }
    char *const part = ry_text_print("%s.part", target);
    const ry_status status =
        part != NULL && access(part, F_OK) == 0
            ? ry_fail(error, RY_BAD_FILE,
                      "%s: is not there, but %s is, of a run that goes on or was stopped; `info %s' tells of it", file, part,
                      part)
            : RY_OK;
    free(part);
    free(target);
    return status;
}

ry_status ry_result_describe(const char *path, ry_write_fn *write, void *data, ry_error *error)
{
    RY_TRY(find_part(path, error));
    ry_h5 file;
    RY_TRY(ry_h5_open(&file, path, -1, RY_H5_READ, error));
    const int is_table = ry_table_is_ours(file.id);
    const ry_status status = is_table ? RY_OK : ry_parameters_check_ours(file.id, path, error);
    if (is_table) {
        ry_table_describe(file.id, path, write, data);
    } else if (status == RY_OK) {
        page to = {write, data, file.id};
        tell_head(&to, path);
        tell_grains(&to);
        tell_extent(&to);
        tell_flux(&to);
        tell_energy(&to);
        tell_profile(&to);
        tell_cost(&to);
        tell_parameters(&to);
    }
    ry_h5_close(&file, 1, "", NULL);
    return status;
}
