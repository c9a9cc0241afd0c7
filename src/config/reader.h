/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * YAML nodes -> ry_config: types, units, ranges, words; remembers where every parameter was
 * given. */
#ifndef RY_CONFIG_READER_H
#define RY_CONFIG_READER_H

#include "config/keys.h"
#include "config/particle.h"
#include "config/yaml.h"

/* Where a value came from; later ones replace earlier ones. */
typedef enum { RY_FROM_DEFAULT, RY_FROM_FILE, RY_FROM_STORED, RY_FROM_COMMAND } ry_origin;

typedef struct ry_reader {
    ry_config *config;
    ry_error *error;
    ry_origin origin;          /* of what is being read */
    ry_place place;            /* of the file or override being read */
    yaml_document_t *document; /* being read */
    int given;                 /* values read so far */
    struct {
        ry_place place;
        ry_origin origin;
        int order; /* 1, 2, ...: as given; 0: not given */
    } at[RY_KEY_COUNT];
    int section_line[RY_KEY_COUNT], title_line, fields_line; /* 0: not seen yet */
    yaml_node_t *particles;                                  /* the list in the file; NULL: none */
} ry_reader;

/* Reads a whole scene but the list of particles, which waits for the defaults in `grains`. */
ry_status ry_reader_scene(ry_reader *reader);

/* Reads one value for section.key (section "" for title). `key_node` NULL: an override. */
ry_status ry_reader_value(ry_reader *reader, const char *section, const char *key,
                          const yaml_node_t *key_node, const yaml_node_t *node);

/* Reads reader->particles into the config. */
ry_status ry_reader_particles(ry_reader *reader);

/* Appends the grains of a table (CSV) to the config's; `like` says what it has no column for. `capacity` is that of
 * config->particles. */
ry_status ry_particle_table_read(const ry_reader *reader, const char *path, ry_particle like, size_t *capacity);

/* A real within a range at `node`, for parameters and particles alike. */
ry_status ry_reader_real(const ry_reader *reader, const yaml_node_t *node, const char *path,
                         const char *unit, double low, double high, double *value);
ry_status ry_reader_flag(const ry_reader *reader, const yaml_node_t *node, const char *path,
                         double *value);

#endif
