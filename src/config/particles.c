/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The list `particles` of a scene: explicit grains, one map each, or a table of many. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "config/nearest.h"
#include "config/reader.h"

enum { AT_POSITION, AT_VELOCITY, AT_SPIN, AT_DIAMETER, AT_DENSITY, AT_FIXED, AT_FILE, AT_COUNT };
static const char *const names[] = {"position", "velocity", "spin", "diameter",
                                    "density",  "fixed",    "file", NULL};

/* One entry of the list while it is read. */
typedef struct entry {
    char path[80];    /* particles[3] */
    ry_particle like; /* the grain, or what all of a table are like */
    const char *file; /* NULL: a grain */
    int seen[AT_COUNT];
} entry;

#define FAIL(reader, node, path, ...) \
    ry_place_fail(ry_yaml_place((reader)->place, node), path, (reader)->error, __VA_ARGS__)

static ry_status read_number(const ry_reader *reader, const yaml_node_t *node, int which, entry *e)
{
    double low, high, value;
    ry_particle_range(which, &low, &high);
    RY_TRY(ry_reader_real(reader, node, e->path, ry_particle_units[which], low, high, &value));
    ry_particle_set(&e->like, which, value);
    return RY_OK;
}

/* Two numbers, of which `first` is the one along x. */
static ry_status read_vector(const ry_reader *reader, const yaml_node_t *node, int first, entry *e)
{
    if (node->type != YAML_SEQUENCE_NODE ||
        node->data.sequence.items.top - node->data.sequence.items.start != 2) {
        return FAIL(reader, node, e->path, "a list of two values is needed, along x and along z");
    }
    for (int i = 0; i < 2; i++) {
        const yaml_node_t *item =
            yaml_document_get_node(reader->document, node->data.sequence.items.start[i]);
        RY_TRY(read_number(reader, item, first + i, e));
    }
    return RY_OK;
}

static ry_status read_member(const ry_reader *reader, const yaml_node_t *node, int member, entry *e)
{
    switch (member) {
    case AT_POSITION: return read_vector(reader, node, RY_PARTICLE_X, e);
    case AT_VELOCITY: return read_vector(reader, node, RY_PARTICLE_VX, e);
    case AT_SPIN: return read_number(reader, node, RY_PARTICLE_SPIN, e);
    case AT_DIAMETER: return read_number(reader, node, RY_PARTICLE_DIAMETER, e);
    case AT_DENSITY: return read_number(reader, node, RY_PARTICLE_DENSITY, e);
    case AT_FILE:
        e->file = ry_yaml_is_null(node) ? NULL : ry_yaml_text(node);
        return e->file != NULL ? RY_OK
                               : FAIL(reader, node, e->path, "%s stands where the name of a table (CSV) belongs",
                                      ry_yaml_quote(node).text);
    default: break;
    }
    double flag = 0.0;
    RY_TRY(ry_reader_flag(reader, node, e->path, &flag));
    e->like.fixed = flag != 0.0;
    return RY_OK;
}

static int find_name(const char *text)
{
    int which = 0;
    while (which < AT_COUNT && (text == NULL || strcmp(text, names[which]) != 0)) {
        which++;
    }
    return which;
}

static ry_status unknown(const ry_reader *reader, const yaml_node_t *key, const char *path)
{
    const char *text = ry_yaml_text(key);
    const char *near = text != NULL ? ry_nearest_word(text, names) : NULL;
    return FAIL(reader, key, path,
                "unknown key %s; %s%s%skeys of a particle: position, velocity, "
                "spin, diameter, density, fixed; or file, a table of many",
                ry_yaml_quote(key).text, near ? "did you mean " : "", near ? near : "",
                near ? "? " : "");
}

static ry_status read_members(const ry_reader *reader, const yaml_node_t *node, entry *e)
{
    char *const end = e->path + strlen(e->path);
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(reader->document, pair->key);
        const int member = find_name(ry_yaml_text(key));
        if (member == AT_COUNT) {
            return unknown(reader, key, e->path);
        }
        *end = '.'; /* not printed anew: there are many grains */
        strcpy(end + 1, names[member]);
        if (e->seen[member]++) {
            return FAIL(reader, key, e->path, "stands here for the second time");
        }
        RY_TRY(read_member(reader, yaml_document_get_node(reader->document, pair->value), member, e));
        *end = '\0';
    }
    return RY_OK;
}

static ry_status read_entry(const ry_reader *reader, const yaml_node_t *node, int index, size_t *capacity)
{
    ry_config *const config = reader->config;
    entry e = {.like = {.diameter = config->grains_diameter,
                        .density = config->grains_density,
                        .line = (int)node->start_mark.line + 1}};
    (void)snprintf(e.path, sizeof e.path, "particles[%d]", index);
    if (node->type != YAML_MAPPING_NODE) {
        return FAIL(reader, node, e.path,
                    "%s stands where a map such as {position: [0, 1 mm]} belongs",
                    ry_yaml_quote(node).text);
    }
    RY_TRY(read_members(reader, node, &e));
    if (e.file != NULL) {
        return e.seen[AT_POSITION] ? FAIL(reader, node, e.path, "has a file and a position; give only one of the two")
                                   : ry_particle_table_read(reader, e.file, e.like, capacity);
    }
    if (!e.seen[AT_POSITION]) {
        return FAIL(reader, node, e.path, "has no position: [x, z]");
    }
    const size_t n = (size_t)config->n_particles;
    RY_TRY(ry_array_grow(&config->particles, capacity, n, n + 1, sizeof e.like, reader->error));
    config->particles[config->n_particles++] = e.like;
    return RY_OK;
}

ry_status ry_reader_particles(ry_reader *reader)
{
    const yaml_node_t *list = reader->particles;
    if (list == NULL) {
        return RY_OK;
    }
    if (list->type != YAML_SEQUENCE_NODE) {
        return FAIL(reader, list, "particles",
                    "%s stands where a list belongs, one entry "
                    "'- {position: [x, z]}' for each grain",
                    ry_yaml_quote(list).text);
    }
    const int n = (int)(list->data.sequence.items.top - list->data.sequence.items.start);
    ry_config *config = reader->config;
    size_t capacity = 0;
    RY_TRY(ry_array_grow(&config->particles, &capacity, 0, (size_t)n + 1, sizeof *config->particles, reader->error));
    for (int i = 0; i < n; i++) {
        RY_TRY(read_entry(reader, yaml_document_get_node(reader->document, list->data.sequence.items.start[i]), i,
                          &capacity));
    }
    return RY_OK;
}
