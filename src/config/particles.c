/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The list `particles` of a scene: explicit grains, one map each. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/nearest.h"
#include "config/reader.h"

/* Where explicit grains may be and how fast they may go at the start; all beyond is a slip of
 * units. */
static const double farthest = 1e9, fastest = 1e9, fastest_spin = 1e12;

enum { AT_POSITION, AT_VELOCITY, AT_SPIN, AT_DIAMETER, AT_DENSITY, AT_FIXED, AT_COUNT };
static const char *const names[] = {"position", "velocity", "spin", "diameter",
                                    "density",  "fixed",    NULL};

#define FAIL(reader, node, path, ...) \
    ry_place_fail(ry_yaml_place((reader)->place, node), path, (reader)->error, __VA_ARGS__)

static ry_status read_vector(const ry_reader *reader, const yaml_node_t *node, const char *path,
                             const char *unit, double limit, double out[2])
{
    if (node->type != YAML_SEQUENCE_NODE ||
        node->data.sequence.items.top - node->data.sequence.items.start != 2) {
        return FAIL(reader, node, path, "a list of two values is needed, along x and along z");
    }
    for (int i = 0; i < 2; i++) {
        const yaml_node_t *item =
            yaml_document_get_node(reader->document, node->data.sequence.items.start[i]);
        RY_TRY(ry_reader_real(reader, item, path, unit, -limit, limit, &out[i]));
    }
    return RY_OK;
}

static ry_status read_like(const ry_reader *reader, const yaml_node_t *node, const char *path,
                           int key, double *out)
{
    const ry_key_row *row = ry_keys_row(key);
    return ry_reader_real(reader, node, path, row->unit, row->low, row->high, out);
}

static ry_status read_member(const ry_reader *reader, const yaml_node_t *node, const char *path,
                             int which, ry_particle *grain)
{
    switch (which) {
    case AT_POSITION: return read_vector(reader, node, path, "m", farthest, grain->position);
    case AT_VELOCITY: return read_vector(reader, node, path, "m/s", fastest, grain->velocity);
    case AT_SPIN:
        return ry_reader_real(reader, node, path, "rad/s", -fastest_spin, fastest_spin,
                              &grain->spin);
    case AT_DIAMETER:
        return read_like(reader, node, path, RY_KEY_grains_diameter, &grain->diameter);
    case AT_DENSITY: return read_like(reader, node, path, RY_KEY_grains_density, &grain->density);
    default: break;
    }
    double flag = 0.0;
    RY_TRY(ry_reader_flag(reader, node, path, &flag));
    grain->fixed = flag != 0.0;
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
                "spin, diameter, density, fixed",
                ry_yaml_quote(key).text, near ? "did you mean " : "", near ? near : "",
                near ? "? " : "");
}

static ry_status read_particle(const ry_reader *reader, const yaml_node_t *node, int index,
                               ry_particle *grain)
{
    char path[80];
    const int whole = snprintf(path, sizeof path, "particles[%d]", index);
    if (node->type != YAML_MAPPING_NODE) {
        return FAIL(reader, node, path,
                    "%s stands where a map such as {position: [0, 1 mm]} belongs",
                    ry_yaml_quote(node).text);
    }
    int seen[AT_COUNT] = {0};
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(reader->document, pair->key);
        const int which = find_name(ry_yaml_text(key));
        if (which == AT_COUNT) {
            return unknown(reader, key, path);
        }
        path[whole] = '.'; /* not printed anew: there are many grains */
        strcpy(path + whole + 1, names[which]);
        if (seen[which]++) {
            return FAIL(reader, key, path, "stands here for the second time");
        }
        RY_TRY(read_member(reader, yaml_document_get_node(reader->document, pair->value), path,
                           which, grain));
        path[whole] = '\0';
    }
    return seen[AT_POSITION] ? RY_OK : FAIL(reader, node, path, "has no position: [x, z]");
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
    config->particles = calloc((size_t)n + 1, sizeof *config->particles);
    if (config->particles == NULL) {
        return ry_fail(reader->error, RY_BAD_FILE, "not enough memory for %d particles", n);
    }
    config->n_particles = n;
    for (int i = 0; i < n; i++) {
        const yaml_node_t *node =
            yaml_document_get_node(reader->document, list->data.sequence.items.start[i]);
        config->particles[i] = (ry_particle){.diameter = config->grains_diameter,
                                             .density = config->grains_density,
                                             .line = (int)node->start_mark.line + 1};
        RY_TRY(read_particle(reader, node, i, &config->particles[i]));
    }
    return RY_OK;
}
