/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Where a value was given, and messages that begin with it:
 *
 *     flume.yaml:12: grains.diameter: what is wrong; what is allowed
 *     -s domain.length=3 kg: domain.length: what is wrong; what is allowed */
#ifndef RY_CONFIG_PLACE_H
#define RY_CONFIG_PLACE_H

#include "ryusa/status.h"

typedef struct ry_place {
    const char *name;      /* of the scene file; "" if none */
    int line;              /* 0: the file as a whole */
    const char *override_; /* the text after -s; NULL: the file */
} ry_place;

/* Always RY_BAD_INPUT. `key` is the full path of the key, NULL for none. */
ry_status ry_place_fail(ry_place place, const char *key, ry_error *error, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Room for a piece of the user's text in a message. */
typedef struct ry_quote {
    char text[64];
} ry_quote;

/* The text, shortened, without control characters and cut between characters only. */
ry_quote ry_place_quote(const char *text);

#endif
