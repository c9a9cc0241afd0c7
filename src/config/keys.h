/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * config.def as a table: every parameter has a number RY_KEY_section_key, a row that describes it
 * and a value that can be read and set as a double (flags 0 or 1, choices by index, integers
 * exactly). */
#ifndef RY_CONFIG_KEYS_H
#define RY_CONFIG_KEYS_H

#include "ryusa/config.h"

#define RY_REAL(section, key, ...) RY_KEY_##section##_##key,
#define RY_INT(section, key, ...) RY_KEY_##section##_##key,
#define RY_FLAG(section, key, ...) RY_KEY_##section##_##key,
#define RY_CHOICE(section, key, ...) RY_KEY_##section##_##key,
enum {
#include "ryusa/config.def"
    RY_KEY_COUNT
};
#undef RY_REAL
#undef RY_INT
#undef RY_FLAG
#undef RY_CHOICE

typedef struct ry_key_row {
    const char *section, *key;
    char type;           /* as in ry_parameter */
    double usual, inert; /* defaults with and without `grains`; NAN: derived */
    const char *unit;
    double low, high;         /* allowed range, both included */
    const char *const *words; /* of a choice, NULL after the last */
    const char *text;
} ry_key_row;

const ry_key_row *ry_keys_row(int key);
double ry_keys_get(const ry_config *config, int key);
void ry_keys_set(ry_config *config, int key, double value);

/* The number of section.key; -1: there is none. */
int ry_keys_find(const char *section, const char *key);

/* The same of a text that begins with "section.key", or "section.key=". */
int ry_keys_find_path(const char *text);

/* The key that replaces this one and that it replaces, so that both together contradict each other; -1:
 * there is none. */
int ry_keys_rival(int key);

/* The number of the first key of a section, its identity; -1: there is no such section. */
int ry_keys_section(const char *section);

/* Writes "a, b, c": the keys of a section, or (NULL) the sections of a scene file. */
void ry_keys_list(const char *section, char *out, int size);

/* Why the scene has no use for a parameter; NULL: it has one. */
const char *ry_keys_idle(const ry_config *config, int key);

#endif
