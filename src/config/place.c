/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Messages about a scene file or an override, all of one form. */
#include "config/place.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* The end of a path counts. */
enum { LONGEST_NAME = 500 };

/* "file:12", "file" or "-s key=value". */
static void describe(ry_place place, char *out, size_t size)
{
    const char *const name = place.name != NULL ? place.name : "";
    const size_t length = strlen(name);
    const int is_long = length > LONGEST_NAME;
    const char *const cut = is_long ? "..." : "", *const shown = is_long ? name + length - LONGEST_NAME : name;
    if (place.override_ != NULL) {
        (void)snprintf(out, size, "-s %s: ", ry_place_quote(place.override_).text);
    } else if (place.line > 0) {
        (void)snprintf(out, size, "%s%s:%d: ", cut, name[0] ? shown : "scene", place.line);
    } else if (name[0] != '\0') {
        (void)snprintf(out, size, "%s%s: ", cut, shown);
    } else {
        out[0] = '\0';
    }
}

ry_status ry_place_fail(ry_place place, const char *key, ry_error *error, const char *format, ...)
{
    char where[600], what[1300];
    describe(place, where, sizeof where);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return ry_fail(error, RY_BAD_INPUT, "%s%s%s%s", where, key != NULL ? key : "",
                   key != NULL ? ": " : "", what);
}

ry_quote ry_place_quote(const char *text)
{
    ry_quote quote;
    const size_t room = sizeof quote.text - 4;
    size_t length = strlen(text);
    const int cut = length > room;
    if (cut) {
        length = room;
        while (length > 0 && ((unsigned char)text[length] & 0xC0) == 0x80) {
            length--;
        }
    }
    for (size_t i = 0; i < length; i++) {
        const unsigned char c = (unsigned char)text[i];
        quote.text[i] = c < 0x20 || c == 0x7F ? '?' : text[i];
    }
    memcpy(quote.text + length, cut ? "..." : "", cut ? 4 : 1);
    return quote;
}
