/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The expansions of config.def. A key that stands there needs nothing else in this folder. */
#include "config/keys.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define RY_WORD(value, word) word,
#define RY_WORDS(list) static const char *const words_##list[] = {RY_LIST_##list(RY_WORD) NULL};
RY_WORDS(floor)
RY_WORDS(packing)
RY_WORDS(law)
RY_WORDS(mapping)
RY_WORDS(fluid)
RY_WORDS(drag)
RY_WORDS(mixing)
RY_WORDS(turbulence)
RY_WORDS(start)
RY_WORDS(order)
#undef RY_WORDS
#undef RY_WORD

/* The longest list must fit ry_parameter.words with its NULL. */
static_assert(RY_LAW_COUNT < (int)(sizeof((ry_parameter){0}.words) / sizeof(char *)), "words[]");

#define RY_REAL(section, key, usual, inert, unit, low, high, text) \
    {#section, #key, 'r', usual, inert, unit, low, high, NULL, text},
#define RY_INT(section, key, usual, inert, low, high, text) \
    {#section, #key, 'i', usual, inert, "1", low, high, NULL, text},
#define RY_FLAG(section, key, usual, inert, text) \
    {#section, #key, 'f', usual, inert, "", 0, 1, NULL, text},
#define RY_CHOICE(section, key, list, usual, inert, text) \
    {#section, #key, 'c', usual, inert, "", 0, 0, words_##list, text},
static const ry_key_row rows[RY_KEY_COUNT] = {
#include "ryusa/config.def"
};
#undef RY_REAL
#undef RY_INT
#undef RY_FLAG
#undef RY_CHOICE

const ry_key_row *ry_keys_row(int key)
{
    return &rows[key];
}

/* clang-format off */
#define RY_REAL(section, key, ...) \
    case RY_KEY_##section##_##key: return config->section##_##key;
#define RY_INT(section, key, ...) \
    case RY_KEY_##section##_##key: return config->section##_##key;
#define RY_FLAG(section, key, ...) \
    case RY_KEY_##section##_##key: return config->section##_##key;
#define RY_CHOICE(section, key, ...) \
    case RY_KEY_##section##_##key: return (double)config->section##_##key;
double ry_keys_get(const ry_config *config, int key) {
    switch (key) {
#include "ryusa/config.def"
    default: return NAN;
    }
}
#undef RY_REAL
#undef RY_INT
#undef RY_FLAG
#undef RY_CHOICE

#define RY_REAL(section, key, ...) \
    case RY_KEY_##section##_##key: config->section##_##key = value; break;
#define RY_INT(section, key, ...) \
    case RY_KEY_##section##_##key: config->section##_##key = (int)value; break;
#define RY_FLAG(section, key, ...) \
    case RY_KEY_##section##_##key: config->section##_##key = (int)value; break;
#define RY_CHOICE(section, key, list, ...) \
    case RY_KEY_##section##_##key: config->section##_##key = (ry_##list)(int)value; break;
void ry_keys_set(ry_config *config, int key, double value) {
    switch (key) {
#include "ryusa/config.def"
    default: break;
    }
}
#undef RY_REAL
#undef RY_INT
#undef RY_FLAG
#undef RY_CHOICE
/* clang-format on */

int ry_keys_find(const char *section, const char *key)
{
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        if (strcmp(rows[i].section, section) == 0 && strcmp(rows[i].key, key) == 0) {
            return i;
        }
    }
    return -1;
}

int ry_keys_find_path(const char *text)
{
    char path[120];
    text += strspn(text, " ");
    (void)snprintf(path, sizeof path, "%.*s", (int)strcspn(text, " ="), text);
    char *const dot = strchr(path, '.');
    if (dot == NULL) {
        return -1;
    }
    *dot = '\0';
    return ry_keys_find(path, dot + 1);
}

int ry_keys_rival(int key)
{
    switch (key) {
    case RY_KEY_contact_stiffness: return RY_KEY_contact_alpha_m;
    case RY_KEY_contact_alpha_m: return RY_KEY_contact_stiffness;
    case RY_KEY_fluid_shear_stress: return RY_KEY_fluid_shields;
    case RY_KEY_fluid_shields: return RY_KEY_fluid_shear_stress;
    default: return -1;
    }
}

int ry_keys_section(const char *section)
{
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        if (strcmp(rows[i].section, section) == 0) {
            return i;
        }
    }
    return -1;
}

static void append(char *out, int size, const char *word)
{
    const size_t used = strlen(out);
    (void)snprintf(out + used, (size_t)size - used, "%s%s", used > 0 ? ", " : "", word);
}

void ry_keys_list(const char *section, char *out, int size)
{
    out[0] = '\0';
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        if (section != NULL && strcmp(rows[i].section, section) == 0) {
            append(out, size, rows[i].key);
        } else if (section == NULL && ry_keys_section(rows[i].section) == i) {
            append(out, size, rows[i].section);
        }
    }
    if (section == NULL) {
        append(out, size, "title, particles");
    } else if (strcmp(section, "output") == 0) {
        append(out, size, "fields");
    }
}
