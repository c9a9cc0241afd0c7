/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Every value goes through ry_reader_value, from the file as from -s, so both meet the same
 * checks. */
#include "config/reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/nearest.h"
#include "config/quantity.h"

enum { LIST = 600 }; /* room for a list of keys or words */

#define FAIL(reader, node, path, ...) \
    ry_place_fail(ry_yaml_place((reader)->place, node), path, (reader)->error, __VA_ARGS__)

static const char *unit_of(const char *unit)
{
    return strcmp(unit, "1") == 0 ? "" : unit;
}

/* A scalar with something in it; NULL after a failure. */
static const char *scalar(const ry_reader *reader, const yaml_node_t *node, const char *path,
                          const char *wanted)
{
    const char *text = ry_yaml_text(node);
    if (text == NULL || ry_yaml_is_null(node)) {
        FAIL(reader, node, path, "%s stands where %s belongs", ry_yaml_quote(node).text, wanted);
        return NULL;
    }
    return text;
}

ry_status ry_reader_real(const ry_reader *reader, const yaml_node_t *node, const char *path,
                         const char *unit, double low, double high, double *value)
{
    char problem[400];
    const char *text = scalar(reader, node, path, "a number");
    if (text == NULL) {
        return RY_BAD_INPUT;
    }
    if (!ry_quantity_read(text, unit, value, problem, sizeof problem)) {
        return FAIL(reader, node, path, "%s", problem);
    }
    if (*value < low || *value > high) {
        const char *of = unit_of(unit);
        return FAIL(reader, node, path, "%s is out of range; allowed is %g to %g%s%s",
                    ry_place_quote(text).text, low, high, of[0] ? " " : "", of);
    }
    return RY_OK;
}

static ry_status read_integer(const ry_reader *reader, const yaml_node_t *node, const char *path,
                              const ry_key_row *row, double *value)
{
    char problem[400];
    const char *text = scalar(reader, node, path, "a whole number");
    if (text == NULL) {
        return RY_BAD_INPUT;
    }
    if (!ry_quantity_read(text, "1", value, problem, sizeof problem)) {
        return FAIL(reader, node, path, "%s", problem);
    }
    if (*value != floor(*value) || *value < row->low || *value > row->high) {
        return FAIL(reader, node, path, "%s is not allowed; a whole number from %.0f to %.0f is",
                    ry_place_quote(text).text, row->low, row->high);
    }
    return RY_OK;
}

ry_status ry_reader_flag(const ry_reader *reader, const yaml_node_t *node, const char *path,
                         double *value)
{
    static const char *const words[] = {"false", "true", "no", "yes", "off", "on", NULL};
    const char *text = scalar(reader, node, path, "true or false");
    if (text == NULL) {
        return RY_BAD_INPUT;
    }
    for (int i = 0; words[i] != NULL; i++) {
        if (strcmp(text, words[i]) == 0) {
            *value = i % 2;
            return RY_OK;
        }
    }
    return FAIL(reader, node, path, "'%s' is not allowed; true or false is",
                ry_place_quote(text).text);
}

/* "a, b, c" */
static void join(const char *const *words, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (int i = 0; words[i] != NULL && used < size; i++) {
        used += (size_t)snprintf(out + used, size - used, "%s%s", i > 0 ? ", " : "", words[i]);
    }
}

static ry_status read_word(const ry_reader *reader, const yaml_node_t *node, const char *path,
                           const char *const *words, double *value)
{
    char list[LIST], wanted[LIST + 16];
    join(words, list, sizeof list);
    (void)snprintf(wanted, sizeof wanted, "one of: %s", list);
    const char *text = scalar(reader, node, path, wanted);
    if (text == NULL) {
        return RY_BAD_INPUT;
    }
    for (int i = 0; words[i] != NULL; i++) {
        if (strcmp(text, words[i]) == 0) {
            *value = i;
            return RY_OK;
        }
    }
    const char *near = ry_nearest_word(text, words);
    return FAIL(reader, node, path, "'%s' is not known; %s%s%sallowed are: %s",
                ry_place_quote(text).text, near ? "did you mean " : "", near ? near : "",
                near ? "? " : "", list);
}

/* output.fields: a list of words, or one word alone. */
static ry_status read_fields(ry_reader *reader, const yaml_node_t *node)
{
#define RY_FIELD(bit, word, text) word,
    static const char *const words[] = { RY_LIST_field(RY_FIELD) NULL };
#undef RY_FIELD
    const char *path = "output.fields";
    unsigned fields = 0;
    double index;
    if (node->type == YAML_SCALAR_NODE) {
        RY_TRY(read_word(reader, node, path, words, &index));
        fields = 1U << (unsigned)index;
    } else if (node->type == YAML_SEQUENCE_NODE) {
        const yaml_node_item_t *item = node->data.sequence.items.start;
        for (; item < node->data.sequence.items.top; item++) {
            const yaml_node_t *entry = yaml_document_get_node(reader->document, *item);
            RY_TRY(read_word(reader, entry, path, words, &index));
            fields |= 1U << (unsigned)index;
        }
    } else {
        return FAIL(reader, node, path,
                    "a map stands where a list such as [position, flux] belongs");
    }
    reader->config->output_fields = fields;
    return RY_OK;
}

static ry_status read_title(ry_reader *reader, const yaml_node_t *node)
{
    const char *text = ry_yaml_text(node);
    if (text == NULL) {
        return FAIL(reader, node, "title", "%s stands where a text belongs",
                    ry_yaml_quote(node).text);
    }
    char *copy = strdup(text);
    if (copy == NULL) {
        return ry_fail(reader->error, RY_BAD_FILE, "not enough memory");
    }
    free(reader->config->title);
    reader->config->title = copy;
    return RY_OK;
}

static ry_status unknown(const ry_reader *reader, const char *section, const char *key,
                         const yaml_node_t *node)
{
    char path[160], nearest[80], list[LIST];
    const int top = section[0] == '\0';
    (void)snprintf(path, sizeof path, "%s%s%s", ry_place_quote(section).text, top ? "" : ".",
                   ry_place_quote(key).text);
    const int known = !top && ry_keys_section(section) >= 0;
    ry_keys_list(known ? section : NULL, list, sizeof list);
    ry_nearest_key(top ? NULL : section, key, nearest, sizeof nearest);
    if (strcmp(nearest, path) == 0) { /* "domain.length: 1 m" as one word at the top of a file */
        nearest[0] = '\0';
    }
    const ry_place place = node != NULL ? ry_yaml_place(reader->place, node) : reader->place;
    if (top && (strcmp(key, "vary") == 0 || strcmp(key, "scene") == 0)) {
        return ry_place_fail(place, path, reader->error, "is for sweeps: ryusa sweep runs this file");
    }
    return ry_place_fail(place, path, reader->error, "unknown %s; %s%s%s%s: %s",
                         top ? "section" : "key", nearest[0] ? "did you mean " : "", nearest,
                         nearest[0] ? "? " : "",
                         known ? "keys of this section" : "sections of a scene", list);
}

/* The values of one row of config.def. */
static ry_status read_row(const ry_reader *reader, int key, const yaml_node_t *node,
                          const char *path, double *value)
{
    const ry_key_row *row = ry_keys_row(key);
    switch (row->type) {
    case 'r': return ry_reader_real(reader, node, path, row->unit, row->low, row->high, value);
    case 'i': return read_integer(reader, node, path, row, value);
    case 'f': return ry_reader_flag(reader, node, path, value);
    default: return read_word(reader, node, path, row->words, value);
    }
}

static ry_status refuse_twice(const ry_reader *reader, const yaml_node_t *node, const char *path,
                              int *line)
{
    if (reader->origin != RY_FROM_FILE) {
        return RY_OK;
    }
    if (*line > 0) {
        return FAIL(reader, node, path, "stands here for the second time; first in line %d", *line);
    }
    *line = (int)node->start_mark.line + 1;
    return RY_OK;
}

static ry_status read_key(ry_reader *reader, int key, const char *path, const yaml_node_t *key_node,
                          const yaml_node_t *node)
{
    int line = reader->at[key].place.line;
    double value = NAN;
    if (key_node != NULL) {
        RY_TRY(refuse_twice(reader, key_node, path, &line));
    }
    RY_TRY(read_row(reader, key, node, path, &value));
    ry_keys_set(reader->config, key, value);
    reader->at[key].place = ry_yaml_place(reader->place, key_node != NULL ? key_node : node);
    reader->at[key].origin = reader->origin;
    reader->at[key].order = ++reader->given;
    return RY_OK;
}

ry_status ry_reader_value(ry_reader *reader, const char *section, const char *key,
                          const yaml_node_t *key_node, const yaml_node_t *node)
{
    const yaml_node_t *at = key_node != NULL ? key_node : node;
    if (section[0] == '\0' && strcmp(key, "title") == 0) {
        RY_TRY(refuse_twice(reader, at, key, &reader->title_line));
        return read_title(reader, node);
    }
    if (strcmp(section, "output") == 0 && strcmp(key, "fields") == 0) {
        RY_TRY(refuse_twice(reader, at, "output.fields", &reader->fields_line));
        return read_fields(reader, node);
    }
    const int found = ry_keys_find(section, key);
    if (found < 0) {
        return unknown(reader, section, key, at);
    }
    char path[80];
    (void)snprintf(path, sizeof path, "%s.%s", section, key);
    return read_key(reader, found, path, key_node, node);
}

static ry_status read_section(ry_reader *reader, const char *section, const yaml_node_t *node)
{
    if (ry_yaml_is_null(node)) { /* "grains:" alone: present, all defaults */
        return RY_OK;
    }
    if (node->type != YAML_MAPPING_NODE) {
        char list[LIST];
        ry_keys_list(section, list, sizeof list);
        return FAIL(reader, node, section, "%s stands where a section belongs; its keys: %s",
                    ry_yaml_quote(node).text, list);
    }
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(reader->document, pair->key);
        const char *text = scalar(reader, key, section, "a key");
        if (text == NULL) {
            return RY_BAD_INPUT;
        }
        RY_TRY(ry_reader_value(reader, section, text, key,
                               yaml_document_get_node(reader->document, pair->value)));
    }
    return RY_OK;
}

/* One entry at the top of a scene. */
static ry_status read_entry(ry_reader *reader, const yaml_node_t *key, yaml_node_t *value)
{
    const char *text = scalar(reader, key, NULL, "the name of a section");
    if (text == NULL) {
        return RY_BAD_INPUT;
    }
    if (strcmp(text, "title") == 0) {
        return ry_reader_value(reader, "", text, key, value);
    }
    if (strcmp(text, "particles") == 0) {
        if (reader->particles != NULL) {
            return FAIL(reader, key, text, "stands here for the second time");
        }
        reader->particles = value;
        return RY_OK;
    }
    const int section = ry_keys_section(text);
    if (section < 0) {
        return unknown(reader, "", text, key);
    }
    RY_TRY(refuse_twice(reader, key, text, &reader->section_line[section]));
    return read_section(reader, text, value);
}

ry_status ry_reader_scene(ry_reader *reader)
{
    const yaml_node_t *root = yaml_document_get_root_node(reader->document);
    if (root->type != YAML_MAPPING_NODE) {
        char list[LIST];
        ry_keys_list(NULL, list, sizeof list);
        return FAIL(reader, root, NULL, "a scene is a map of sections, not %s; sections: %s",
                    root->type == YAML_SEQUENCE_NODE ? "a list" : "a text", list);
    }
    const yaml_node_pair_t *pair = root->data.mapping.pairs.start;
    for (; pair < root->data.mapping.pairs.top; pair++) {
        RY_TRY(read_entry(reader, yaml_document_get_node(reader->document, pair->key),
                          yaml_document_get_node(reader->document, pair->value)));
    }
    return RY_OK;
}
