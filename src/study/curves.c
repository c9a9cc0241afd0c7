/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/curves.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "analysis/target.h"
#include "base/memory.h"
#include "base/text.h"
#include "config/place.h"
#include "config/quantity.h"

enum { MOST_THETAS = 10000, PER_BLOCK = 8 };

typedef struct curves {
    const ry_curves_options *options;
    ry_error *error;
    ry_target *target;
    int n_targets;
    double *theta;
    int n_thetas;
    double s, d_star; /* of the grains; d_star NAN: no diameter was given */
    double diameter, density, fluid_density, viscosity;
    FILE *csv;
} curves;

#define say(to, ...) ry_text_say((to)->options->write, (to)->options->data, __VA_ARGS__)

/* Text and then blanks up to `width` characters; bytes 10xxxxxx go on with a character. */
static void say_padded(const curves *c, const char *text, int width)
{
    for (const char *p = text; *p != '\0'; p++) {
        width -= ((unsigned char)*p & 0xC0) != 0x80;
    }
    say(c, "%s%*s", text, width > 0 ? width : 0, "");
}

/* --- what was asked ----------------------------------------------------------------------------- */

static ry_status read_number(const curves *c, const char *option, const char *text,
                             const char *unit, double *value)
{
    char problem[400];
    if (!ry_quantity_read(text, unit, value, problem, sizeof problem)) {
        return ry_fail(c->error, RY_BAD_INPUT, "%s: %s", option, problem);
    }
    if (!(*value > 0.0)) {
        return ry_fail(c->error, RY_BAD_INPUT, "%s: %s is not allowed; a number above 0 is", option,
                       ry_place_quote(text).text);
    }
    return RY_OK;
}

static ry_status read_grains(curves *c)
{
    const ry_curves_options *const o = c->options;
    c->density = 2650.0;
    c->fluid_density = 1000.0;
    c->viscosity = 1e-6;
    c->d_star = NAN;
    if (o->density != NULL) {
        RY_TRY(read_number(c, "--density", o->density, "kg/m^3", &c->density));
    }
    if (o->fluid_density != NULL) {
        RY_TRY(read_number(c, "--fluid-density", o->fluid_density, "kg/m^3", &c->fluid_density));
    }
    if (o->viscosity != NULL) {
        RY_TRY(read_number(c, "--viscosity", o->viscosity, "m^2/s", &c->viscosity));
    }
    c->s = c->density / c->fluid_density;
    if (c->s <= 1.0) {
        return ry_fail(c->error, RY_BAD_INPUT,
                       "--density: %g kg/m^3 is not above the density of the fluid, %g", c->density,
                       c->fluid_density);
    }
    if (o->diameter != NULL) {
        RY_TRY(read_number(c, "--diameter", o->diameter, "m", &c->diameter));
        c->d_star = ry_relation_d_star(c->diameter, c->s, 9.81, c->viscosity);
    }
    return RY_OK;
}

static ry_status bad_theta(const curves *c, const char *what)
{
    return ry_fail(c->error, RY_BAD_INPUT,
                   "--theta %s: %s; give a list (0.05,0.1,0.2) or a range FROM:TO:STEPS, as in "
                   "0.05:1:20, or 0.05:1:20:log with even steps of the logarithm",
                   ry_place_quote(c->options->theta).text, what);
}

/* The next part of the list up to one of `ends`; NULL: too long. */
static const char *take_part(const char *text, char end, char part[60])
{
    const char *const stop = strchr(text, end);
    const size_t length = stop != NULL ? (size_t)(stop - text) : strlen(text);
    if (length >= 60) {
        part[0] = '\0';
    } else {
        memcpy(part, text, length);
        part[length] = '\0';
    }
    return stop != NULL ? stop + 1 : NULL;
}

static ry_status read_range(curves *c)
{
    char part[4][60] = {"", "", "", ""}, problem[400];
    double value[3];
    int n = 0;
    for (const char *rest = c->options->theta; rest != NULL; n++) {
        rest = n < 4 ? take_part(rest, ':', part[n]) : NULL;
    }
    if (n < 3 || n > 4 ||
        (n == 4 && strcmp(part[3], "log") != 0 && strcmp(part[3], "linear") != 0)) {
        return bad_theta(c, "not a range");
    }
    for (int k = 0; k < 3; k++) {
        if (!ry_quantity_read(part[k], "1", &value[k], problem, sizeof problem)) {
            return bad_theta(c, problem);
        }
    }
    if (!(value[0] > 0.0 && value[1] > value[0] && value[2] >= 2.0 && value[2] <= MOST_THETAS &&
          value[2] == floor(value[2]))) {
        return bad_theta(c, "0 < FROM < TO and a whole number of 2 to 10000 STEPS are allowed");
    }
    c->n_thetas = (int)value[2];
    for (int k = 0; k < c->n_thetas; k++) {
        const double way = (double)k / (c->n_thetas - 1);
        c->theta[k] = strcmp(part[3], "log") == 0 ? value[0] * pow(value[1] / value[0], way)
                                                  : value[0] + (value[1] - value[0]) * way;
    }
    return RY_OK;
}

static ry_status read_thetas(curves *c)
{
    static const double usual[] = {0.05, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0};
    char part[60], problem[400];
    c->theta = calloc(MOST_THETAS, sizeof *c->theta);
    if (c->theta == NULL) {
        return ry_no_memory(c->error, MOST_THETAS * sizeof *c->theta);
    }
    if (c->options->theta == NULL) {
        c->n_thetas = sizeof usual / sizeof *usual;
        memcpy(c->theta, usual, sizeof usual);
        return RY_OK;
    }
    if (strchr(c->options->theta, ':') != NULL) {
        return read_range(c);
    }
    for (const char *rest = c->options->theta; rest != NULL; c->n_thetas++) {
        rest = take_part(rest, ',', part);
        double *const value = &c->theta[c->n_thetas];
        if (!ry_quantity_read(part, "1", value, problem, sizeof problem)) {
            return bad_theta(c, problem);
        }
        if (!(*value > 0.0) || c->n_thetas == MOST_THETAS - 1) {
            return bad_theta(c, *value > 0.0 ? "too many values" : "a number above 0 is allowed");
        }
    }
    return RY_OK;
}

static ry_status read_names(curves *c)
{
    const int n = c->options->n_names > 0 ? c->options->n_names : ry_relation_count();
    c->target = calloc((size_t)n, sizeof *c->target);
    if (c->target == NULL) {
        return ry_no_memory(c->error, (size_t)n * sizeof *c->target);
    }
    for (; c->n_targets < n; c->n_targets++) {
        const char *const name = c->options->n_names > 0 ? c->options->names[c->n_targets]
                                                         : ry_relation_at(c->n_targets)->key;
        RY_TRY(ry_target_open(&c->target[c->n_targets], name, c->error));
    }
    return RY_OK;
}

/* --- the page ----------------------------------------------------------------------------------- */

static double flux(const curves *c, const ry_target *target, double theta)
{
    if (target->relation == NULL) {
        return ry_target_flux(target, theta);
    }
    const ry_relation_input in = {
        .theta = theta, .theta_c = NAN, .s = c->s, .d_star = isnan(c->d_star) ? 150.0 : c->d_star};
    return ry_relation_flux_of(target->relation, &in);
}

static void say_formulas(const curves *c)
{
    char text[200];
    say_padded(c, "RELATION", 26);
    say_padded(c, "SOURCE", 32);
    say(c, "THRESHOLD  FORMULA\n");
    for (int k = 0; k < c->n_targets; k++) {
        const ry_target *const t = &c->target[k];
        say_padded(c, t->name, 26);
        if (t->relation == NULL) {
            say(c, "%d points, theta %g to %g%s\n", t->n, t->theta[0], t->theta[t->n - 1],
                t->error != NULL ? ", with errors" : "");
            continue;
        }
        snprintf(text, sizeof text, "%s %d", t->relation->authors, t->relation->year);
        say_padded(c, text, 32);
        snprintf(text, sizeof text, t->relation->theta_c > 0.0 ? "%g" : "-", t->relation->theta_c);
        say_padded(c, text, 11);
        say(c, "%s\n", t->relation->formula);
    }
}

static void say_values(const curves *c)
{
    for (int first = 0; first < c->n_thetas; first += PER_BLOCK) {
        const int last = first + PER_BLOCK < c->n_thetas ? first + PER_BLOCK : c->n_thetas;
        say(c, "\n");
        say_padded(c, first == 0 ? "q* AT SHIELDS NUMBER θ =" : "θ =", 26);
        for (int i = first; i < last; i++) {
            say(c, " %9.4g", c->theta[i]);
        }
        say(c, "\n");
        for (int k = 0; k < c->n_targets; k++) {
            say_padded(c, c->target[k].name, 26);
            for (int i = first; i < last; i++) {
                const double q = flux(c, &c->target[k], c->theta[i]);
                isnan(q) ? say(c, " %9s", "-") : say(c, " %9.4g", q);
            }
            say(c, "\n");
        }
    }
}

static void say_thresholds(const curves *c)
{
    say(c, "\n");
    say_padded(c, "THRESHOLD OF MOTION", 26);
    say_padded(c, "SOURCE", 32);
    isnan(c->d_star) ? say(c, "FORMULA\n") : say(c, "at D* = %.4g\n", c->d_star);
    for (int k = 0; k < ry_threshold_count(); k++) {
        const ry_threshold *const t = ry_threshold_at(k);
        char text[200];
        snprintf(text, sizeof text, "%s %d", t->authors, t->year);
        say_padded(c, t->key, 26);
        say_padded(c, text, 32);
        isnan(c->d_star) ? say(c, "%s\n", t->formula) : say(c, "%.4g\n", t->theta_c(c->d_star));
    }
    if (isnan(c->d_star)) {
        say(c,
            "\nD* = d ((s - 1) g/ν²)^(1/3); with -d DIAMETER the thresholds become numbers. einstein-brown "
            "stands for D* = 150,\nyalin for s = %.4g.\n",
            c->s);
    } else {
        say(c,
            "\nD* of d = %.4g m, %.5g kg/m^3 in a fluid of %.5g kg/m^3 and %.4g m^2/s, g = 9.81 m/s^2.\n",
            c->diameter, c->density, c->fluid_density, c->viscosity);
    }
    say(c, "θ = τ_b/((ρ_s - ρ_f) g d); q* = q_b/√((s - 1) g d³) of grain volume without pores.\n");
}

/* --- CSV ---------------------------------------------------------------------------------------- */

__attribute__((format(printf, 2, 3))) static void export(const curves *c, const char *format, ...)
{
    char text[2000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (c->csv != NULL) {
        fputs(text, c->csv);
    } else {
        c->options->write(c->options->data, text);
    }
}

/* A row for each theta. One curve alone is called q_star: such a file is a target again. */
static void export_rows(const curves *c)
{
    for (int k = 0; k < c->n_targets; k++) {
        const ry_relation *const r = c->target[k].relation;
        r != NULL ? export(c, "# %s: %s %d, q* = %s\n", r->key, r->authors, r->year, r->formula)
                  : export(c, "# %s\n", c->target[k].name);
    }
    export(c, "# s = %.6g, D* = %.6g\ntheta", c->s, isnan(c->d_star) ? 150.0 : c->d_star);
    for (int k = 0; k < c->n_targets; k++) {
        export(c, ",%s", c->n_targets == 1 ? "q_star" : c->target[k].name);
    }
    export(c, "\n");
    for (int i = 0; i < c->n_thetas; i++) {
        export(c, "%.6g", c->theta[i]);
        for (int k = 0; k < c->n_targets; k++) {
            const double q = flux(c, &c->target[k], c->theta[i]);
            isnan(q) ? export(c, ",") : export(c, ",%.6g", q);
        }
        export(c, "\n");
    }
}

static ry_status export_file(curves *c)
{
    const char *const path = c->options->csv;
    size_t length = 0;
    char *text = NULL;
    if (!c->options->force && access(path, F_OK) == 0) {
        return ry_fail(c->error, RY_BAD_FILE, "%s: exists; --force overwrites it", path);
    }
    c->csv = open_memstream(&text, &length);
    if (c->csv == NULL) {
        return ry_no_memory(c->error, 1);
    }
    export_rows(c);
    const ry_status status =
        fclose(c->csv) == 0 ? ry_text_write(path, text, c->error) : ry_no_memory(c->error, length);
    free(text);
    return status;
}

static ry_status make(curves *c)
{
    const int to_page = c->options->csv != NULL && strcmp(c->options->csv, "-") == 0;
    RY_TRY(read_grains(c));
    RY_TRY(read_thetas(c));
    RY_TRY(read_names(c));
    if (to_page) {
        export_rows(c);
        return RY_OK;
    }
    if (c->options->csv != NULL) {
        RY_TRY(export_file(c));
    }
    say_formulas(c);
    say_values(c);
    say_thresholds(c);
    return RY_OK;
}

ry_status ry_curves(const ry_curves_options *options, ry_error *error)
{
    ry_error own = {0};
    curves c = {.options = options, .error = error != NULL ? error : &own};
    const ry_status status = make(&c);
    for (int k = 0; k < c.n_targets; k++) {
        ry_target_free(&c.target[k]);
    }
    free(c.target);
    free(c.theta);
    return status;
}
