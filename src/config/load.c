/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Scene file + overrides -> a resolved config. The text that a config keeps is the scene as it was
 * read and then a line "# -s key=value" for each override. Such lines at the end of a scene are
 * overrides, so the kept text alone makes the same config again (a resumed run relies on it). */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/reader.h"
#include "config/resolve.h"

enum { LARGEST = 64 << 20 }; /* bytes of a scene: some 500 000 explicit grains */
static const char mark[] = "# -s ";

/* The overrides at the end of a text: a copy of each line without its mark. */
typedef struct stored_lines {
    char **lines;
    int n;
} stored_lines;

static void stored_free(stored_lines *list)
{
    for (int i = 0; i < list->n; i++) {
        free(list->lines[i]);
    }
    free(list->lines);
}

static size_t without_blanks(const char *text, size_t end)
{
    while (end > 0 && strchr(" \t\r\n", text[end - 1]) != NULL) {
        end--;
    }
    return end;
}

static int stored_add(stored_lines *list, const char *line, size_t length)
{
    char **grown = realloc(list->lines, ((size_t)list->n + 1) * sizeof *grown);
    if (grown == NULL) {
        return 0;
    }
    list->lines = grown;
    char *copy = strndup(line, length);
    if (copy != NULL) {
        grown[list->n++] = copy;
    }
    return copy != NULL;
}

/* Walks up from the end of the text as long as lines begin with the mark; the last comes first. */
static int stored_find(stored_lines *list, const char *text)
{
    size_t end = without_blanks(text, strlen(text));
    while (end > 0) {
        size_t begin = end;
        while (begin > 0 && text[begin - 1] != '\n') {
            begin--;
        }
        const size_t skip = sizeof mark - 1;
        if (end - begin <= skip || strncmp(text + begin, mark, skip) != 0) {
            break;
        }
        if (!stored_add(list, text + begin + skip, end - begin - skip)) {
            return 0;
        }
        end = without_blanks(text, begin);
    }
    return 1;
}

static int is_particles(const char *text)
{
    const size_t n = strlen("particles");
    text += strspn(text, " ");
    return strncmp(text, "particles", n) == 0 && strchr(".=[ ", text[n]) != NULL;
}

/* Splits "section.key=value" (or "title=value"); the value begins at *value. */
static ry_status split(const char *text, ry_place place, char section[40], char key[80],
                       const char **value, ry_error *error)
{
    const char *equals = strchr(text, '=');
    if (is_particles(text)) {
        return ry_place_fail(place, NULL, error,
                             "particles can't be set by -s; edit the scene file");
    }
    if (equals == NULL || equals == text + strspn(text, " ") || strpbrk(text, "\r\n") != NULL ||
        !ry_yaml_is_utf8(text)) {
        return ry_place_fail(place, NULL, error,
                             "not an override; write section.key=value in one line");
    }
    text += strspn(text, " ");
    const char *dot = memchr(text, '.', (size_t)(equals - text));
    const char *name = dot != NULL ? dot + 1 : text;
    const int in = dot != NULL ? (int)(dot - text) : 0;
    const int length = (int)without_blanks(name, (size_t)(equals - name));
    (void)snprintf(section, 40, "%.*s", in < 39 ? in : 39, text);
    (void)snprintf(key, 80, "%.*s", length < 79 ? length : 79, name);
    *value = equals + 1;
    return RY_OK;
}

static ry_status apply_parts(ry_reader *reader, const char *section, const char *key,
                             const char *value)
{
    if (section[0] == '\0' && ry_keys_section(key) >= 0) {
        char list[600];
        ry_keys_list(key, list, sizeof list);
        return ry_place_fail(reader->place, key, reader->error,
                             "a section; set one of its keys, as in -s %s.key=value; its keys: %s",
                             key, list);
    }
    yaml_document_t document;
    RY_TRY(ry_yaml_load(&document, value, reader->place, reader->error));
    yaml_document_t *scene = reader->document;
    reader->document = &document;
    const ry_status status =
        ry_reader_value(reader, section, key, NULL, yaml_document_get_root_node(&document));
    reader->document = scene;
    yaml_document_delete(&document);
    return status;
}

static ry_status apply(ry_reader *reader, const char *text, ry_origin origin)
{
    char section[40], key[80];
    const char *value = NULL;
    const ry_place scene = reader->place;
    reader->place = (ry_place){.name = scene.name, .override_ = text};
    reader->origin = origin;
    ry_status status = split(text, reader->place, section, key, &value, reader->error);
    if (status == RY_OK) {
        status = apply_parts(reader, section, key, value);
    }
    reader->place = scene;
    reader->origin = RY_FROM_FILE;
    return status;
}

/* Two keys of which one replaces the other. Together in one file they contradict each other; an
 * override of either replaces what the file says. `loser`, if it is derived, is forgotten. */
static ry_status either(ry_reader *reader, int a, int b)
{
    const int order_a = reader->at[a].order, order_b = reader->at[b].order;
    if (order_a == 0 || order_b == 0) {
        return RY_OK;
    }
    const int first = order_a < order_b ? a : b, last = order_a < order_b ? b : a;
    const ry_origin origin = reader->at[last].origin;
    if (origin == reader->at[first].origin && origin != RY_FROM_STORED) {
        char path[80], where[40] = "";
        const ry_key_row *one = ry_keys_row(last), *other = ry_keys_row(first);
        (void)snprintf(path, sizeof path, "%s.%s", one->section, one->key);
        if (origin == RY_FROM_FILE) {
            (void)snprintf(where, sizeof where, " in line %d", reader->at[first].place.line);
        }
        return ry_place_fail(reader->at[last].place, path, reader->error,
                             "contradicts %s.%s%s; give only one of the two", other->section,
                             other->key, where);
    }
    if (isnan(ry_keys_row(first)->usual)) {
        ry_keys_set(reader->config, first, NAN);
    }
    reader->at[first].order = 0;
    return RY_OK;
}

static ry_status read_all(ry_reader *reader, const stored_lines *stored,
                          const char *const *overrides, int n_overrides)
{
    RY_TRY(ry_reader_scene(reader));
    for (int i = stored->n - 1; i >= 0; i--) {
        RY_TRY(apply(reader, stored->lines[i], RY_FROM_STORED));
    }
    for (int i = 0; i < n_overrides; i++) {
        RY_TRY(apply(reader, overrides[i], RY_FROM_COMMAND));
    }
    for (int key = 0; key < RY_KEY_COUNT; key++) {
        if (ry_keys_rival(key) > key) {
            RY_TRY(either(reader, key, ry_keys_rival(key)));
        }
    }
    RY_TRY(ry_reader_particles(reader));
    ry_place places[RY_KEY_COUNT];
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        places[i] = reader->at[i].order > 0 ? reader->at[i].place : reader->place;
    }
    return ry_resolve_at(reader->config, places, reader->error);
}

static int names_grains(const char *override_)
{
    return strncmp(override_ + strspn(override_, " "), "grains.", strlen("grains.")) == 0;
}

/* Whether the scene has a section `grains`, or gets one by an override. */
static int has_grains(yaml_document_t *document, const stored_lines *stored,
                      const char *const *overrides, int n_overrides)
{
    int found = 0;
    for (int i = 0; i < stored->n; i++) {
        found |= names_grains(stored->lines[i]);
    }
    for (int i = 0; i < n_overrides; i++) {
        found |= names_grains(overrides[i]);
    }
    const yaml_node_t *root = yaml_document_get_root_node(document);
    if (root->type != YAML_MAPPING_NODE) {
        return found;
    }
    const yaml_node_pair_t *pair = root->data.mapping.pairs.start;
    for (; pair < root->data.mapping.pairs.top; pair++) {
        const char *key = ry_yaml_text(yaml_document_get_node(document, pair->key));
        found |= key != NULL && strcmp(key, "grains") == 0;
    }
    return found;
}

/* The scene and the overrides as the lines that stored_find reads again. */
static char *whole_text(const char *text, const char *const *overrides, int n_overrides)
{
    size_t size = strlen(text) + 1;
    for (int i = 0; i < n_overrides; i++) {
        size += strlen(overrides[i]) + sizeof mark + 1;
    }
    char *whole = malloc(size);
    if (whole == NULL) {
        return NULL;
    }
    char *end = stpcpy(whole, text);
    for (int i = 0; i < n_overrides; i++) {
        end = stpcpy(stpcpy(stpcpy(end, "\n"), mark), overrides[i]);
    }
    return whole;
}

static ry_status keep_texts(ry_config *config, const char *text, const char *name,
                            const char *const *overrides, int n_overrides, ry_error *error)
{
    free(config->text);
    free(config->path);
    config->text = whole_text(text, overrides, n_overrides);
    config->path = strdup(name);
    if (config->text == NULL || config->path == NULL || config->title == NULL) {
        return ry_fail(error, RY_BAD_FILE, "not enough memory to read %s", name);
    }
    return RY_OK;
}

static ry_status read_document(ry_config *config, yaml_document_t *document, const char *text,
                               const char *name, const stored_lines *stored,
                               const char *const *overrides, int n_overrides, ry_error *error)
{
    *config = ry_config_default(has_grains(document, stored, overrides, n_overrides));
    RY_TRY(keep_texts(config, text, name, overrides, n_overrides, error));
    ry_reader *reader = calloc(1, sizeof *reader);
    if (reader == NULL) {
        return ry_fail(error, RY_BAD_FILE, "not enough memory to read %s", name);
    }
    reader->config = config;
    reader->error = error;
    reader->origin = RY_FROM_FILE;
    reader->place = (ry_place){.name = config->path};
    reader->document = document;
    const ry_status status = read_all(reader, stored, overrides, n_overrides);
    free(reader);
    return status;
}

static ry_status parse(ry_config *config, const char *text, const char *name,
                       const char *const *overrides, int n_overrides, ry_error *error)
{
    static const char order_mark[] = "\xEF\xBB\xBF"; /* which some editors put in front */
    const ry_place place = {.name = name};
    text += strncmp(text, order_mark, strlen(order_mark)) == 0 ? strlen(order_mark) : 0;
    if (strlen(text) > LARGEST) {
        return ry_place_fail(place, NULL, error, "larger than %d MiB; not a scene", LARGEST >> 20);
    }
    if (!ry_yaml_is_utf8(text)) {
        return ry_place_fail(place, NULL, error, "not a text file (UTF-8); a scene is YAML text");
    }
    stored_lines stored = {0};
    yaml_document_t document;
    ry_status status = stored_find(&stored, text)
                           ? ry_yaml_load(&document, text, place, error)
                           : ry_fail(error, RY_BAD_FILE, "not enough memory to read %s", name);
    if (status == RY_OK) {
        status =
            read_document(config, &document, text, name, &stored, overrides, n_overrides, error);
        yaml_document_delete(&document);
    }
    stored_free(&stored);
    return status;
}

ry_status ry_config_parse(ry_config *config, const char *text, const char *name,
                          const char *const *overrides, int n_overrides, ry_error *error)
{
    memset(config, 0, sizeof *config);
    const ry_status status = parse(config, text != NULL ? text : "", name != NULL ? name : "",
                                   overrides, n_overrides, error);
    if (status != RY_OK) {
        ry_config_free(config);
    }
    return status;
}

/* Reads to the end rather than asking for the size: a pipe has none. */
static ry_status read_stream(FILE *file, const char *path, char **text, size_t *length,
                             ry_error *error)
{
    size_t room = 1 << 16;
    *length = 0;
    *text = malloc(room + 1);
    while (*text != NULL) {
        *length += fread(*text + *length, 1, room - *length, file);
        if (*length < room || room > LARGEST) {
            break;
        }
        room *= 2;
        char *grown = realloc(*text, room + 1);
        if (grown == NULL) {
            free(*text);
        }
        *text = grown;
    }
    if (*text == NULL) {
        return ry_fail(error, RY_BAD_FILE, "%s: not enough memory to read it", path);
    }
    if (ferror(file)) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be read: %s", path, strerror(errno));
    }
    (*text)[*length] = '\0';
    return RY_OK;
}

static ry_status refuse_binary(const char *text, size_t length, const char *path, ry_error *error)
{
    const ry_place place = {.name = path};
    if (length > LARGEST) {
        return ry_place_fail(place, NULL, error, "larger than %d MiB; not a scene", LARGEST >> 20);
    }
    if (strncmp(text, "\x89HDF", 4) == 0) {
        return ry_place_fail(place, NULL, error,
                             "an HDF5 file, not a scene; 'ryusa info' tells what it holds");
    }
    if (strlen(text) != length) {
        return ry_place_fail(place, NULL, error,
                             "not a text file (it has NUL bytes); a scene is "
                             "YAML text");
    }
    return RY_OK;
}

ry_status ry_config_load(ry_config *config, const char *path, const char *const *overrides,
                         int n_overrides, ry_error *error)
{
    memset(config, 0, sizeof *config);
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return ry_fail(error, RY_BAD_FILE, "%s: can't be opened: %s", path, strerror(errno));
    }
    char *text = NULL;
    size_t length = 0;
    ry_status status = read_stream(file, path, &text, &length, error);
    (void)fclose(file);
    if (status == RY_OK) {
        status = refuse_binary(text, length, path, error);
    }
    if (status == RY_OK) {
        status = ry_config_parse(config, text, path, overrides, n_overrides, error);
    }
    free(text);
    return status;
}
