/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The number is scanned here (strtod alone would take "0x10", "nan" and the decimal comma of some
 * locales), the unit by udunits2. Its unit table is read once, when the first unit appears, and is
 * the only mutable state that configs share; its parser is not safe for threads, hence the
 * mutex. */
#include "config/quantity.h"

#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <udunits2.h>

#include "config/place.h"

/* How many of a unit make one SI unit is worked out once for each spelling: long lists of particles
 * repeat a few. */
enum { KNOWN = 32, SPELLING = 24 };

static struct {
    pthread_mutex_t mutex;
    ut_system *system;
    struct {
        char from[SPELLING], to[SPELLING];
        double scale;
    } known[KNOWN];
    unsigned next;
} units = {.mutex = PTHREAD_MUTEX_INITIALIZER};

/* What a value with this unit is called in a message. */
static const char *dimension(const char *unit)
{
    static const char *const names[][2] = {
        {"m", "a length such as '0.5 mm'"},
        {"s", "a time such as '20 us'"},
        {"m/s", "a velocity such as '1 cm/s'"},
        {"m/s^2", "an acceleration such as '9.81 m/s^2'"},
        {"kg/m^3", "a density such as '2650 kg/m^3'"},
        {"N/m", "a stiffness such as '100 N/m'"},
        {"Pa", "a stress such as '1.6 Pa'"},
        {"m^2/s", "a kinematic viscosity such as '1e-6 m^2/s'"},
        {"rad/s", "an angular velocity such as '10 rad/s'"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(names[i][0], unit) == 0) {
            return names[i][1];
        }
    }
    return "a quantity";
}

static const char *skip_digits(const char *p)
{
    while (isdigit((unsigned char)*p)) {
        p++;
    }
    return p;
}

/* The end of the decimal number at `p`; NULL if none stands there. */
static const char *number_end(const char *p)
{
    p += *p == '+' || *p == '-';
    const char *whole = p;
    p = skip_digits(p);
    int digits = p > whole;
    if (*p == '.') {
        const char *fraction = p + 1;
        p = skip_digits(fraction);
        digits = digits || p > fraction;
    }
    if (!digits) {
        return NULL;
    }
    if (*p == 'e' || *p == 'E') {
        const char *power = p + 1 + (p[1] == '+' || p[1] == '-');
        if (isdigit((unsigned char)*power)) {
            p = skip_digits(power);
        }
    }
    return p;
}

static struct {
    pthread_once_t once;
    locale_t c;
} locales = {.once = PTHREAD_ONCE_INIT};

static void make_locale(void)
{
    locales.c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

/* strtod in the C locale, whatever the program's locale is. */
static double to_double(const char *text)
{
    (void)pthread_once(&locales.once, make_locale);
    const locale_t old = uselocale(locales.c);
    const double value = strtod(text, NULL);
    (void)uselocale(old);
    return value;
}

/* The scale from one unit to another of the same dimension; NAN if `unit` is of another. A unit and
 * its inverse (s and Hz) are convertible to udunits, not to us; nor are shifted scales (degC). */
static double scale_between(ut_unit *unit, ut_unit *target)
{
    double scale = NAN;
    ut_unit *ratio = ut_divide(unit, target);
    cv_converter *convert = ut_get_converter(unit, target);
    if (ratio != NULL && ut_is_dimensionless(ratio) && convert != NULL) {
        scale = cv_convert_double(convert, 0.0) == 0.0 ? cv_convert_double(convert, 1.0) : NAN;
    }
    cv_free(convert);
    ut_free(ratio);
    return scale;
}

static int parse_scale(const char *from, const char *to, double *scale)
{
    ut_unit *unit = ut_parse(units.system, from, UT_UTF8);
    ut_unit *target = ut_parse(units.system, to, UT_UTF8);
    if (unit != NULL && target != NULL) {
        *scale = scale_between(unit, target);
    }
    const int parsed = unit != NULL;
    ut_free(unit);
    ut_free(target);
    return parsed;
}

/* udunits knows "degree" and its sign, but not the usual "deg". */
static void load_system(void)
{
    (void)ut_set_error_message_handler(ut_ignore);
    units.system = ut_read_xml(NULL);
    if (units.system != NULL) {
        ut_unit *degree = ut_parse(units.system, "degree", UT_UTF8);
        (void)ut_map_name_to_unit("deg", UT_ASCII, degree);
        ut_free(degree);
    }
}

/* Looks the pair of units up or works it out. Returns 0: no table, 1: unknown unit, 2: scale
 * set. */
static int find_scale(const char *from, const char *to, double *scale)
{
    if (strcmp(from, to) == 0) {
        *scale = 1.0;
        return 2;
    }
    for (int i = 0; i < KNOWN; i++) {
        if (strcmp(units.known[i].from, from) == 0 && strcmp(units.known[i].to, to) == 0) {
            *scale = units.known[i].scale;
            return 2;
        }
    }
    if (units.system == NULL) {
        load_system();
    }
    if (units.system == NULL) {
        return 0;
    }
    *scale = NAN;
    if (!parse_scale(from, to, scale)) {
        return 1;
    }
    if (strlen(from) < SPELLING && strlen(to) < SPELLING) {
        const unsigned i = units.next++ % KNOWN;
        (void)snprintf(units.known[i].from, SPELLING, "%s", from);
        (void)snprintf(units.known[i].to, SPELLING, "%s", to);
        units.known[i].scale = *scale;
    }
    return 2;
}

/* "20 us" shall be the same double as 20e-6: dividing by the exact 1e6 rounds once, multiplying by
 * the inexact 1e-6 twice. */
static double times(double value, double scale)
{
    const double inverse = round(1.0 / scale);
    if (scale < 1.0 && inverse < 1e15 && fabs(inverse * scale - 1.0) < 1e-14) {
        return value / inverse;
    }
    return value * scale;
}

/* udunits would read "5 mm" after a number as a fivefold mm, and "mm 2" as the double; digits are for powers, which
 * follow a letter, ^ or **, or a sign behind one. Only "1/s" may begin with one. */
static int has_factor(const char *unit)
{
    if (strchr("+-.,", unit[0]) != NULL) {
        return 1;
    }
    for (size_t i = strncmp(unit, "1/", 2) == 0 ? 1 : 0; unit[i] != '\0'; i++) {
        size_t before = i;
        before -= before > 0;
        before -= before > 0 && strchr("+-", unit[before]) != NULL;
        const int power = before > 0 && strncmp(unit + before - 1, "**", 2) == 0;
        const int begins = i == 0 || strchr(" \t.,*/()", unit[before]) != NULL;
        if (isdigit((unsigned char)unit[i]) && begins && !power) {
            return 1;
        }
    }
    return 0;
}

static int convert(const char *from, const char *to, double *value, char *problem, size_t size)
{
    /* A cycle is no radian, but udunits takes both for nothing. */
    const int refused = has_factor(from) || (strcmp(to, "rad/s") == 0 && strstr(from, "Hz") != NULL);
    double scale = NAN;
    int found = 1;
    if (!refused) {
        (void)pthread_mutex_lock(&units.mutex);
        found = find_scale(from, to, &scale);
        (void)pthread_mutex_unlock(&units.mutex);
    }
    if (found == 0) {
        (void)snprintf(problem, size,
                       "the table of units (udunits2) can't be read; give a bare "
                       "number in %s",
                       to);
    } else if (found == 1) {
        (void)snprintf(problem, size, "'%s' is not a unit; give %s, or a bare number in %s",
                       ry_place_quote(from).text, dimension(to), to);
    } else if (isnan(scale)) {
        (void)snprintf(problem, size, "the unit '%s' does not fit; give %s, or a bare number in %s",
                       ry_place_quote(from).text, dimension(to), to);
    } else {
        *value = times(*value, scale);
        return 1;
    }
    return 0;
}

/* Copies the text after the number without the blanks around it. */
static void trim(const char *text, char *out, size_t size)
{
    text += strspn(text, " \t\r\n");
    (void)snprintf(out, size, "%s", text);
    size_t length = strlen(out);
    while (length > 0 && strchr(" \t\r\n", out[length - 1]) != NULL) {
        out[--length] = '\0';
    }
}

/* A number is named only where there is no doubt which. */
static void say_not_bare(const char *text, const char *rest, double value, char *problem, size_t size)
{
    const ry_quote quote = ry_place_quote(text);
    if (strcmp(rest, "%") == 0) {
        (void)snprintf(problem, size, "'%s' is not a plain number; it takes no unit, write %.9g", quote.text, value / 100.0);
    } else if (rest[0] == ',') {
        (void)snprintf(problem, size, "'%s' is not a plain number; decimals stand behind a point, as in 0.5", quote.text);
    } else {
        (void)snprintf(problem, size, "'%s' is not a plain number such as 0.5 or 1e-3%s", quote.text,
                       isalpha((unsigned char)rest[0]) ? "; it takes no unit" : "");
    }
}

int ry_quantity_read(const char *text, const char *unit, double *value, char *problem, size_t size)
{
    const int bare = strcmp(unit, "1") == 0;
    const char *begin = text + strspn(text, " \t\r\n");
    const char *end = number_end(begin);
    if (end == NULL || ((*end == 'x' || *end == 'X') && end == begin + 1 + (begin[0] == '-'))) {
        (void)snprintf(problem, size, "'%s' is not a number; give %s", ry_place_quote(text).text,
                       bare ? "a plain number" : dimension(unit));
        return 0;
    }
    char rest[128];
    if (strlen(end) >= sizeof rest) {
        (void)snprintf(problem, size, "'%s' is too long for a quantity", ry_place_quote(text).text);
        return 0;
    }
    rest[0] = '\0';
    if (*end != '\0') {
        trim(end, rest, sizeof rest);
    }
    *value = to_double(begin);
    if (rest[0] != '\0' && bare) {
        say_not_bare(text, rest, *value, problem, size);
        return 0;
    }
    if (rest[0] != '\0' && !convert(rest, unit, value, problem, size)) {
        return 0;
    }
    if (!isfinite(*value)) {
        (void)snprintf(problem, size, "'%s' is too large", ry_place_quote(text).text);
        return 0;
    }
    return 1;
}
