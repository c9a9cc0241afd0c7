/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/sweep_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "config/nearest.h"
#include "config/quantity.h"
#include "config/reader.h"

enum { LARGEST = 16 << 20 };

static const char *const sampling_words[] = {
#define RY_WORD(value, word) word,
    RY_LIST_sampling(RY_WORD) NULL
#undef RY_WORD
};
enum { K_TITLE, K_SCENE, K_SET, K_VARY, K_SAMPLE, K_SAMPLES, K_REPLICAS, K_SEED, KEYS };
static const char *const words[] = {"title",   "scene",    "set",  "vary", "sample",
                                    "samples", "replicas", "seed", NULL};

/* Values go through the reader of scenes, into a config that nobody looks at. */
typedef struct parser {
    ry_sweep_file *file;
    ry_error *error;
    ry_reader reader;
    ry_config scratch;
    int line[KEYS]; /* where a key stands; 0: nowhere */
} parser;

#define FAIL(p, node, path, ...) \
    ry_place_fail(ry_yaml_place((p)->reader.place, node), path, (p)->error, __VA_ARGS__)

static yaml_node_t *node_at(parser *p, int index)
{
    return yaml_document_get_node(p->reader.document, index);
}

static ry_status no_memory(parser *p)
{
    return ry_no_memory(p->error, strlen(p->file->text));
}

/* --- keys and values of the scene --------------------------------------------------------------- */

/* Splits "section.key" and checks that `value` may stand there; errors name line and key. */
static ry_status check_value(parser *p, const char *path, const yaml_node_t *key_node,
                             const yaml_node_t *value)
{
    char section[80] = "";
    const char *const dot = strchr(path, '.');
    if (dot != NULL) {
        snprintf(section, sizeof section, "%.*s", (int)(dot - path), path);
    }
    const char *const key = dot != NULL ? dot + 1 : path;
    /* Unknown keys are reported where they stand, not where their value does. */
    const int known = ry_keys_find(section, key) >= 0 || strcmp(path, "output.fields") == 0;
    return ry_reader_value(&p->reader, section, key, known ? NULL : key_node, value);
}

static ry_status take_path(parser *p, const yaml_node_t *node, const char **path)
{
    *path = ry_yaml_text(node);
    if (*path == NULL || strlen(*path) >= sizeof((ry_axis){0}.path)) {
        return FAIL(p, node, NULL, "%s stands where a key such as fluid.shields belongs",
                    ry_yaml_quote(node).text);
    }
    if (strcmp(*path, "title") == 0 || strncmp(*path, "particles", 9) == 0) {
        return FAIL(p, node, *path, "can't be changed by a sweep; edit the scene");
    }
    return RY_OK;
}

static ry_status refuse_twice(parser *p, const yaml_node_t *map, const yaml_node_pair_t *pair)
{
    const char *const own = ry_yaml_text(node_at(p, pair->key));
    for (const yaml_node_pair_t *other = map->data.mapping.pairs.start; own != NULL && other < pair;
         other++) {
        const yaml_node_t *const key = node_at(p, other->key);
        const char *const text = ry_yaml_text(key);
        if (text != NULL && strcmp(text, own) == 0) {
            return FAIL(p, node_at(p, pair->key), own,
                        "stands here for the second time; first in line %d",
                        (int)key->start_mark.line + 1);
        }
    }
    return RY_OK;
}

/* --- set ---------------------------------------------------------------------------------------- */

/* A list of words (output.fields) as YAML in one line. */
static char *print_override(parser *p, const char *path, const yaml_node_t *value)
{
    if (value->type != YAML_SEQUENCE_NODE) {
        return ry_text_print("%s=%s", path, ry_yaml_text(value));
    }
    char *text = ry_text_print("%s=[", path);
    const yaml_node_item_t *item = value->data.sequence.items.start;
    for (; item < value->data.sequence.items.top && text != NULL; item++) {
        char *const longer =
            ry_text_print("%s%s%s", text, item > value->data.sequence.items.start ? ", " : "",
                          ry_yaml_text(node_at(p, *item)));
        free(text);
        text = longer;
    }
    char *const whole = text != NULL ? ry_text_print("%s]", text) : NULL;
    free(text);
    return whole;
}

static ry_status read_set(parser *p, const yaml_node_t *node)
{
    if (ry_yaml_is_null(node)) {
        return RY_OK;
    }
    if (node->type != YAML_MAPPING_NODE) {
        return FAIL(p, node, "set",
                    "%s stands where a map of keys and values belongs, as in {time.end: 5 s}",
                    ry_yaml_quote(node).text);
    }
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    const size_t n = (size_t)(node->data.mapping.pairs.top - pair);
    p->file->set = calloc(n + 1, sizeof *p->file->set);
    if (p->file->set == NULL) {
        return no_memory(p);
    }
    for (; pair < node->data.mapping.pairs.top; pair++) {
        const char *path;
        RY_TRY(refuse_twice(p, node, pair));
        RY_TRY(take_path(p, node_at(p, pair->key), &path));
        RY_TRY(check_value(p, path, node_at(p, pair->key), node_at(p, pair->value)));
        char *const text = print_override(p, path, node_at(p, pair->value));
        if (text == NULL) {
            return no_memory(p);
        }
        p->file->set[p->file->n_set++] = text;
    }
    return RY_OK;
}

/* --- vary --------------------------------------------------------------------------------------- */

static ry_status read_bound(parser *p, const ry_axis *axis, const yaml_node_t *node, double *value)
{
    const ry_key_row *const row = ry_keys_row(axis->key);
    RY_TRY(check_value(p, axis->path, node, node));
    return ry_reader_real(&p->reader, node, axis->path, row->unit, row->low, row->high, value);
}

static ry_status read_steps(parser *p, const ry_axis *axis, const yaml_node_t *node, int *steps)
{
    double value;
    RY_TRY(ry_reader_real(&p->reader, node, axis->path, "1", 1, RY_SWEEP_MOST_CASES, &value));
    *steps = (int)value;
    return *steps == value ? RY_OK
                           : FAIL(p, node, axis->path, "steps: %g is not a whole number", value);
}

static ry_status read_range_key(parser *p, ry_axis *axis, const yaml_node_t *key,
                                const yaml_node_t *value, unsigned *given)
{
    static const char *const keys[] = {"from", "to", "steps", "scale", NULL};
    const char *const text = ry_yaml_text(key);
    int k = 0;
    while (keys[k] != NULL && (text == NULL || strcmp(text, keys[k]) != 0)) {
        k++;
    }
    *given |= 1u << k;
    switch (k) {
    case 0: return read_bound(p, axis, value, &axis->from);
    case 1: return read_bound(p, axis, value, &axis->to);
    case 2: return read_steps(p, axis, value, &axis->steps);
    case 3: {
        const char *const scale = ry_yaml_text(value);
        axis->logarithmic = scale != NULL && strcmp(scale, "log") == 0;
        return axis->logarithmic || (scale != NULL && strcmp(scale, "linear") == 0)
                   ? RY_OK
                   : FAIL(p, value, axis->path, "scale: %s is not known; linear and log are",
                          ry_yaml_quote(value).text);
    }
    default:
        return FAIL(p, key, axis->path,
                    "%s is no part of a range; allowed are: from, to, steps, scale",
                    ry_yaml_quote(key).text);
    }
}

static ry_status read_range(parser *p, ry_axis *axis, const yaml_node_t *node)
{
    const char type = ry_keys_row(axis->key)->type;
    unsigned given = 0;
    if (type != 'r' && type != 'i') {
        return FAIL(p, node, axis->path, "takes words, which have no range; give a list of them");
    }
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++) {
        RY_TRY(refuse_twice(p, node, pair));
        RY_TRY(read_range_key(p, axis, node_at(p, pair->key), node_at(p, pair->value), &given));
    }
    if ((given & 3u) != 3u) {
        return FAIL(p, node, axis->path,
                    "the range has no '%s'; write {from: 0.1, to: 1, steps: 10}",
                    given & 1u ? "to" : "from");
    }
    if (axis->from == axis->to && axis->steps != 1) {
        return FAIL(p, node, axis->path,
                    "the range ends where it begins; 'from' and 'to' must differ");
    }
    if (axis->from != axis->to && axis->steps == 1) {
        return FAIL(p, node, axis->path, "steps: 1 leaves out 'to'; at least 2 where 'from' and 'to' differ");
    }
    if (axis->logarithmic && !(axis->from > 0.0 && axis->to > 0.0)) {
        return FAIL(p, node, axis->path, "scale: log needs 'from' and 'to' above 0");
    }
    axis->is_range = 1;
    return RY_OK;
}

static ry_status read_list(parser *p, ry_axis *axis, const yaml_node_t *node)
{
    const yaml_node_item_t *item = node->data.sequence.items.start;
    const size_t n = (size_t)(node->data.sequence.items.top - item);
    if (n == 0) {
        return FAIL(p, node, axis->path, "an empty list; give at least one value");
    }
    axis->value = calloc(n, sizeof *axis->value);
    if (axis->value == NULL) {
        return no_memory(p);
    }
    for (; item < node->data.sequence.items.top; item++) {
        const yaml_node_t *const value = node_at(p, *item);
        RY_TRY(check_value(p, axis->path, value, value));
        char *const copy = strdup(ry_yaml_text(value));
        if (copy == NULL) {
            return no_memory(p);
        }
        axis->value[axis->n++] = copy;
    }
    return RY_OK;
}

static ry_status read_axis(parser *p, const yaml_node_t *key, const yaml_node_t *value)
{
    ry_axis *const axis = &p->file->axis[p->file->n_axes];
    const char *path;
    RY_TRY(take_path(p, key, &path));
    snprintf(axis->path, sizeof axis->path, "%s", path);
    axis->line = (int)key->start_mark.line + 1;
    axis->key = ry_keys_find_path(path);
    if (strcmp(path, "output.fields") == 0) {
        return FAIL(p, key, path, "can't be varied; put it under 'set'");
    }
    if (axis->key < 0) {
        return check_value(p, path, key, value);
    }
    p->file->n_axes++;
    if (value->type == YAML_MAPPING_NODE) {
        return read_range(p, axis, value);
    }
    if (value->type == YAML_SEQUENCE_NODE) {
        return read_list(p, axis, value);
    }
    return FAIL(
        p, value, path,
        "%s stands where a list or a range belongs: [0.1, 0.2] or {from: 0.1, to: 1, steps: 10}%s",
        ry_yaml_quote(value).text,
        ry_yaml_is_null(value) ? "" : "; one value for all cases stands under 'set'");
}

static ry_status read_vary(parser *p, const yaml_node_t *node)
{
    if (ry_yaml_is_null(node)) {
        return RY_OK;
    }
    if (node->type != YAML_MAPPING_NODE) {
        return FAIL(p, node, "vary",
                    "%s stands where a map of keys belongs, as in {fluid.shields: [0.1, 0.2]}",
                    ry_yaml_quote(node).text);
    }
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    p->file->axis =
        calloc((size_t)(node->data.mapping.pairs.top - pair) + 1, sizeof *p->file->axis);
    if (p->file->axis == NULL) {
        return no_memory(p);
    }
    for (; pair < node->data.mapping.pairs.top; pair++) {
        RY_TRY(refuse_twice(p, node, pair));
        RY_TRY(read_axis(p, node_at(p, pair->key), node_at(p, pair->value)));
    }
    return RY_OK;
}

/* --- the rest ----------------------------------------------------------------------------------- */

static ry_status read_count(parser *p, const yaml_node_t *node, const char *key, double low,
                            double high, int *count)
{
    double value;
    RY_TRY(ry_reader_real(&p->reader, node, key, "1", low, high, &value));
    *count = (int)value;
    return *count == value ? RY_OK : FAIL(p, node, key, "%g is not a whole number", value);
}

/* The scene is named as seen from the sweep file. */
static ry_status read_scene(parser *p, const yaml_node_t *node)
{
    const char *const name = ry_yaml_text(node);
    if (name == NULL || name[0] == '\0' || ry_yaml_is_null(node)) {
        return FAIL(p, node, "scene", "%s stands where the name of a scene file belongs",
                    ry_yaml_quote(node).text);
    }
    const char *const slash = name[0] != '/' ? strrchr(p->file->path, '/') : NULL;
    const int folder = slash != NULL ? (int)(slash - p->file->path) + 1 : 0;
    p->file->scene = ry_text_print("%.*s%s", folder, p->file->path, name);
    if (p->file->scene == NULL) {
        return no_memory(p);
    }
    if (access(p->file->scene, R_OK) != 0) {
        return ry_fail(p->error, RY_BAD_FILE, "%s:%d: scene: %s: can't be opened: %s",
                       p->file->path, ry_yaml_place(p->reader.place, node).line, p->file->scene,
                       strerror(errno));
    }
    return RY_OK;
}

static ry_status read_sampling(parser *p, const yaml_node_t *node)
{
    const char *const text = ry_yaml_text(node);
    for (int k = 0; text != NULL && sampling_words[k] != NULL; k++) {
        if (strcmp(text, sampling_words[k]) == 0) {
            p->file->sampling = (ry_sampling)k;
            return RY_OK;
        }
    }
    return FAIL(p, node, "sample",
                "%s is not known; allowed are: grid, list, random, latin-hypercube",
                ry_yaml_quote(node).text);
}

static ry_status read_entry(parser *p, const yaml_node_t *key, const yaml_node_t *value)
{
    const char *const text = ry_yaml_text(key);
    int k = 0;
    while (words[k] != NULL && (text == NULL || strcmp(text, words[k]) != 0)) {
        k++;
    }
    if (k == KEYS) {
        const char *const near = text != NULL ? ry_nearest_word(text, words) : NULL;
        return FAIL(p, key, NULL,
                    "%s is not a key of a sweep; %s%s%sallowed are: title, scene, set, vary, "
                    "sample, samples, replicas, seed",
                    ry_yaml_quote(key).text, near != NULL ? "did you mean " : "",
                    near != NULL ? near : "", near != NULL ? "? " : "");
    }
    p->line[k] = (int)key->start_mark.line + 1;
    switch (k) {
    case K_TITLE:
        RY_TRY(check_value(p, "title", key, value));
        p->file->title = strdup(ry_yaml_text(value));
        return p->file->title != NULL ? RY_OK : no_memory(p);
    case K_SCENE: return read_scene(p, value);
    case K_SET: return read_set(p, value);
    case K_VARY: return read_vary(p, value);
    case K_SAMPLE: return read_sampling(p, value);
    case K_SAMPLES: return read_count(p, value, text, 1, RY_SWEEP_MOST_CASES, &p->file->samples);
    case K_REPLICAS: return read_count(p, value, text, 1, RY_SWEEP_MOST_CASES, &p->file->replicas);
    default: return read_count(p, value, text, 0, 2147483647, &p->file->seed);
    }
}

static ry_status at_line(parser *p, int line, const char *key, const char *what)
{
    return ry_place_fail((ry_place){.name = p->file->path, .line = line}, key, p->error, "%s",
                         what);
}

/* What is varied would replace it without a word. */
static ry_status check_set(parser *p, const ry_axis *axis)
{
    for (int k = 0; k < p->file->n_set; k++) {
        char what[160];
        const int key = ry_keys_find_path(p->file->set[k]);
        const int length = (int)strcspn(p->file->set[k], "=");
        if (key >= 0 && (key == axis->key || key == ry_keys_rival(axis->key))) {
            snprintf(what, sizeof what, "contradicts %.*s under 'set'; give only one of the two", length, p->file->set[k]);
            return at_line(p, axis->line, axis->path, what);
        }
    }
    return RY_OK;
}

/* What fits together; sampling decides whether `samples`, `seed` and `steps` mean anything. */
static ry_status check_all(parser *p)
{
    const ry_sweep_file *const f = p->file;
    const int drawn = f->sampling == RY_SAMPLING_RANDOM || f->sampling == RY_SAMPLING_LATIN;
    if (f->scene == NULL) {
        return at_line(p, 0, "scene", "not given; name the scene file, as in scene: flume.yaml");
    }
    if (f->n_axes == 0 && f->replicas < 2) {
        return at_line(p, p->line[K_VARY], "vary",
                       "nothing to vary; name at least one key and its values, as in "
                       "vary: {fluid.shields: [0.1, 0.2]}");
    }
    if (drawn != (p->line[K_SAMPLES] > 0) || (f->n_axes == 0 && drawn)) {
        return at_line(
            p, p->line[drawn ? K_SAMPLE : K_SAMPLES], "samples",
            drawn ? "how many? sample: random and latin-hypercube need it, and a key to vary"
                  : "only sample: random and latin-hypercube have a number of samples");
    }
    if (!drawn && p->line[K_SEED] > 0) {
        return at_line(p, p->line[K_SEED], "seed",
                       "only for sample: random and latin-hypercube; the seed of the "
                       "grains is grains.seed of the scene");
    }
    for (int k = 0; k < f->n_axes; k++) {
        const ry_axis *const axis = &f->axis[k];
        if (axis->is_range && drawn != (axis->steps == 0)) {
            return at_line(p, axis->line, axis->path,
                           drawn ? "'steps' means nothing here: 'samples' values are drawn"
                                 : "the range needs 'steps'");
        }
        if (strcmp(axis->path, "grains.seed") == 0 && f->replicas > 1) {
            return at_line(p, axis->line, axis->path,
                           "can't be varied while 'replicas' gives each case its own");
        }
        RY_TRY(check_set(p, axis));
    }
    return RY_OK;
}

static ry_status read_document(parser *p)
{
    const yaml_node_t *const root = yaml_document_get_root_node(p->reader.document);
    if (root->type != YAML_MAPPING_NODE) {
        return FAIL(p, root, NULL,
                    "a sweep is a map, not %s; keys: scene, vary, sample, samples, replicas, set",
                    root->type == YAML_SEQUENCE_NODE ? "a list" : "a text");
    }
    const yaml_node_pair_t *pair = root->data.mapping.pairs.start;
    for (; pair < root->data.mapping.pairs.top; pair++) {
        RY_TRY(refuse_twice(p, root, pair));
        RY_TRY(read_entry(p, node_at(p, pair->key), node_at(p, pair->value)));
    }
    return check_all(p);
}

static ry_status parse(ry_sweep_file *file, ry_error *error)
{
    yaml_document_t document;
    const ry_place place = {.name = file->path};
    if (!ry_yaml_is_utf8(file->text)) {
        return ry_place_fail(place, NULL, error, "not a text file (UTF-8); a sweep is YAML text");
    }
    RY_TRY(ry_yaml_load(&document, file->text, place, error));
    parser *const p = calloc(1, sizeof *p);
    ry_status status = RY_BAD_FILE;
    if (p == NULL) {
        status = ry_no_memory(error, sizeof *p);
    } else {
        *p = (parser){.file = file, .error = error, .scratch = ry_config_default(1)};
        p->reader = (ry_reader){.config = &p->scratch,
                                .error = error,
                                .origin = RY_FROM_COMMAND,
                                .place = place,
                                .document = &document};
        status = read_document(p);
        ry_config_free(&p->scratch);
    }
    free(p);
    yaml_document_delete(&document);
    return status;
}

ry_status ry_sweep_file_load(ry_sweep_file *file, const char *path, ry_error *error)
{
    *file = (ry_sweep_file){.replicas = 1, .seed = 1, .path = strdup(path)};
    ry_status status = file->path != NULL
                           ? ry_text_read(path, LARGEST, "a sweep", &file->text, error)
                           : ry_no_memory(error, strlen(path));
    if (status == RY_OK) {
        status = parse(file, error);
    }
    if (status == RY_OK) {
        status = ry_sweep_points_make(file, error);
    }
    if (status != RY_OK) {
        ry_sweep_file_free(file);
    }
    return status;
}

void ry_sweep_file_free(ry_sweep_file *file)
{
    for (int k = 0; k < file->n_axes; k++) {
        for (int i = 0; i < file->axis[k].n; i++) {
            free(file->axis[k].value[i]);
        }
        free(file->axis[k].value);
    }
    for (int k = 0; k < file->n_set; k++) {
        free(file->set[k]);
    }
    for (int k = 0; file->value != NULL && k < file->n_points * file->n_axes; k++) {
        free(file->value[k]);
    }
    free(file->value);
    free(file->axis);
    free(file->set);
    free(file->title);
    free(file->scene);
    free(file->text);
    free(file->path);
    *file = (ry_sweep_file){0};
}

const char *ry_sweep_file_value(const ry_sweep_file *file, int point, int axis)
{
    return file->value[point * file->n_axes + axis];
}

const char *ry_sweep_file_sampling(const ry_sweep_file *file)
{
    return sampling_words[file->sampling];
}
