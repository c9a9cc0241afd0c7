/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The group /parameters: every resolved parameter as an attribute "section.key" (SI), its unit under
 * the same name in /parameters/units, the explicit grains, the text of the scene. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "config/particle.h"
#include "io/result_private.h"

#define GROUP "parameters"
#define UNITS "parameters/units"
#define PARTICLES "parameters/particles"
#define SCENE "parameters/scene"

typedef struct key {
    char text[80];
} key;

static key key_of(const ry_parameter *parameter)
{
    key joined;
    snprintf(joined.text, sizeof joined.text, "%s.%s", parameter->section, parameter->key);
    return joined;
}

/* The words of output.fields, in order. */
static void field_words(unsigned fields, char *text, size_t size)
{
    text[0] = '\0';
#define ADD(bit, word, about)                                                      \
    if ((fields & bit) != 0) {                                                     \
        strncat(text, text[0] != '\0' ? " " word : word, size - strlen(text) - 1); \
    }
    RY_LIST_field(ADD);
#undef ADD
}

/* --- writing --- */

static int write_parameter(hid_t file, const ry_parameter *parameter)
{
    const key name = key_of(parameter);
    int set = -1;
    if (parameter->type == 'c') {
        set = ry_h5_set_text(file, GROUP, name.text, parameter->word);
    } else if (parameter->type == 'r') {
        set = ry_h5_set_number(file, GROUP, name.text, parameter->number);
    } else {
        set = ry_h5_set_integer(file, GROUP, name.text, (int64_t)parameter->number);
    }
    return set == 0 && parameter->unit != NULL && parameter->unit[0] != '\0'
               ? ry_h5_set_text(file, UNITS, name.text, parameter->unit)
               : set;
}

static double *particle_numbers(const ry_config *config)
{
    double *const numbers = ry_array((size_t)config->n_particles, sizeof(double[RY_PARTICLE_NUMBERS]));
    for (int k = 0; numbers != NULL && k < config->n_particles; ++k) {
        for (int j = 0; j < RY_PARTICLE_NUMBERS; ++j) {
            numbers[k * RY_PARTICLE_NUMBERS + j] = ry_particle_get(&config->particles[k], j);
        }
    }
    return numbers;
}

static int write_particles(hid_t file, const ry_config *config)
{
    if (config->n_particles == 0) {
        return 0;
    }
    double *const numbers = particle_numbers(config);
    const ry_h5_shape shape = {
        H5T_NATIVE_DOUBLE, 2, {(hsize_t)config->n_particles, RY_PARTICLE_NUMBERS}};
    const int failed =
        numbers == NULL || ry_h5_write(file, PARTICLES, &shape, numbers) != 0 ||
        ry_h5_set_texts(file, PARTICLES, "columns", RY_PARTICLE_NUMBERS, ry_particle_names) != 0 ||
        ry_h5_set_texts(file, PARTICLES, "units", RY_PARTICLE_NUMBERS, ry_particle_units) != 0;
    free(numbers);
    return failed ? -1 : 0;
}

static int write_words(hid_t file, const ry_config *config)
{
    char fields[200];
    field_words(config->output_fields, fields, sizeof fields);
    char *old = NULL;
    const char *const text = config->text != NULL ? config->text : "";
    const int same = ry_h5_read_text(file, SCENE, &old) == 0 && strcmp(old, text) == 0;
    free(old);
    return (same || ry_h5_write_text(file, SCENE, text) == 0) &&
                   ry_h5_set_text(file, GROUP, "title",
                                  config->title != NULL ? config->title : "") == 0 &&
                   ry_h5_set_text(file, GROUP, "program", "ryusa") == 0 &&
                   ry_h5_set_text(file, GROUP, "version", ry_version()) == 0 &&
                   ry_h5_set_text(file, GROUP, "output.fields", fields) == 0 &&
                   ry_h5_set_integer(file, GROUP, "has_grains", config->has_grains) == 0 &&
                   ry_h5_set_integer(file, GROUP, "format", RY_FILE_FORMAT) == 0
               ? 0
               : -1;
}

int ry_parameters_write(hid_t file, const ry_config *config)
{
    if (ry_h5_make_group(file, GROUP) != 0 || ry_h5_make_group(file, UNITS) != 0) {
        return -1;
    }
    ry_parameter parameter;
    for (int k = 0; ry_config_parameter(config, k, &parameter); ++k) {
        if (write_parameter(file, &parameter) != 0) {
            return -1;
        }
    }
    return write_words(file, config) == 0 ? write_particles(file, config) : -1;
}

/* --- comparing --- */

/* What a run may change when it goes on: nothing of it changes a step that was taken. */
static int may_differ(const ry_parameter *parameter)
{
    return (strcmp(parameter->section, "time") == 0 && strcmp(parameter->key, "end") == 0) ||
           (strcmp(parameter->section, "output") == 0 &&
            strcmp(parameter->key, "checkpoint") == 0) ||
           strcmp(parameter->section, "stop") == 0 || strcmp(parameter->section, "numerics") == 0;
}

typedef struct differences {
    int count;
    char text[1500];
} differences;

enum { MOST_LISTED = 8 };

__attribute__((format(printf, 2, 3))) static void add_difference(differences *list,
                                                                 const char *format, ...)
{
    if (list->count++ >= MOST_LISTED) {
        return;
    }
    const size_t used = strlen(list->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(list->text + used, sizeof list->text - used, format, arguments);
    va_end(arguments);
}

static int same_number(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || a == b || (isnan(a) && isnan(b));
}

typedef struct digits {
    char text[40];
} digits;

/* As few digits as tell the number from every other. */
static digits shortest(double value)
{
    digits out;
    for (int precision = 6; precision <= 17; ++precision) {
        snprintf(out.text, sizeof out.text, "%.*g", precision, value);
        if (same_number(strtod(out.text, NULL), value)) {
            break;
        }
    }
    return out;
}

static void compare_number(hid_t file, const char *name, double now, differences *list)
{
    double then = NAN;
    if (ry_h5_get_number(file, GROUP, name, &then) != 0) {
        add_difference(list, "\n  %s: not in the file, now %s", name, shortest(now).text);
    } else if (!same_number(then, now)) {
        add_difference(list, "\n  %s: %s in the file, now %s", name, shortest(then).text,
                       shortest(now).text);
    }
}

static void compare_word(hid_t file, const char *name, const char *now, differences *list)
{
    char *then = NULL;
    if (ry_h5_get_text(file, GROUP, name, &then) != 0) {
        add_difference(list, "\n  %s: not in the file, now %s", name, now);
    } else if (strcmp(then, now) != 0) {
        add_difference(list, "\n  %s: %.100s in the file, now %.100s", name, then, now);
    }
    free(then);
}

static void compare_particle(int k, const double *then, const double *now, differences *list)
{
    for (int j = 0; j < RY_PARTICLE_NUMBERS; ++j) {
        if (!same_number(then[j], now[j])) {
            add_difference(list, "\n  particles[%d].%s: %s in the file, now %s", k,
                           ry_particle_names[j], shortest(then[j]).text, shortest(now[j]).text);
        }
    }
}

static void compare_particles(hid_t file, const ry_config *config, differences *list)
{
    ry_h5_shape shape = {.rank = 0};
    const int found =
        ry_h5_exists(file, PARTICLES) && ry_h5_get_shape(file, PARTICLES, &shape) == 0;
    const int n = found ? (int)shape.size[0] : 0;
    if (n != config->n_particles) {
        add_difference(list, "\n  particles: %d in the file, now %d", n, config->n_particles);
        return;
    }
    const size_t numbers = (size_t)n * RY_PARTICLE_NUMBERS;
    double *const now = particle_numbers(config);
    double *const then = ry_array(numbers, sizeof *then);
    if (n > 0 && now != NULL && then != NULL &&
        ry_h5_read(file, PARTICLES, H5T_NATIVE_DOUBLE, numbers, then) == 0) {
        for (int k = 0; k < n; ++k) {
            compare_particle(k, then + k * RY_PARTICLE_NUMBERS, now + k * RY_PARTICLE_NUMBERS, list);
        }
    } else if (n > 0) {
        add_difference(list, "\n  particles: those in the file can't be read");
    }
    free(now);
    free(then);
}

ry_status ry_parameters_compare(hid_t file, const char *name, const ry_config *config,
                                ry_error *error)
{
    differences list = {0};
    ry_parameter parameter;
    for (int k = 0; ry_config_parameter(config, k, &parameter); ++k) {
        const key full = key_of(&parameter);
        if (may_differ(&parameter)) {
            continue;
        }
        if (parameter.type == 'c') {
            compare_word(file, full.text, parameter.word, &list);
        } else {
            compare_number(file, full.text, parameter.number, &list);
        }
    }
    char fields[200];
    field_words(config->output_fields, fields, sizeof fields);
    compare_word(file, "output.fields", fields, &list);
    compare_particles(file, config, &list);
    if (list.count == 0) {
        return RY_OK;
    }
    char more[60] = "";
    if (list.count > MOST_LISTED) {
        snprintf(more, sizeof more, "\n  and %d more", list.count - MOST_LISTED);
    }
    return ry_fail(error, RY_BAD_INPUT,
                   "%s: this run can't go on, for its scene was another one:%s%s\n"
                   "Only time.end, output.checkpoint, stop and numerics may differ.",
                   name, list.text, more);
}

ry_status ry_parameters_check_ours(hid_t file, const char *name, ry_error *error)
{
    static const char *const needed[] = {"h5md", GROUP, SCENE};
    for (size_t k = 0; k < sizeof needed / sizeof needed[0]; ++k) {
        if (!ry_h5_exists(file, needed[k])) {
            return ry_fail(error, RY_BAD_FILE,
                           "%s: an HDF5 file, but not a result of ryusa: it has no /%s", name,
                           needed[k]);
        }
    }
    char *program = NULL;
    const int ours =
        ry_h5_get_text(file, GROUP, "program", &program) == 0 && strcmp(program, "ryusa") == 0;
    free(program);
    if (!ours) {
        return ry_fail(error, RY_BAD_FILE,
                       "%s: an HDF5 file, but not a result of ryusa: /%s does not name it", name,
                       GROUP);
    }
    int64_t format = 0;
    if (ry_h5_get_integer(file, GROUP, "format", &format) != 0 || format != RY_FILE_FORMAT) {
        return ry_fail(error, RY_BAD_FILE,
                       "%s: written in format %lld; this program knows format %d", name,
                       (long long)format, RY_FILE_FORMAT);
    }
    return RY_OK;
}
