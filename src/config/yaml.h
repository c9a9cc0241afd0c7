/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * libyaml's documents, with the checks that every use here wants. */
#ifndef RY_CONFIG_YAML_H
#define RY_CONFIG_YAML_H

#include <yaml.h>

#include "config/place.h"

/* Reads one document. One without content is an error, as are several. On success `document` is to
 * be freed with yaml_document_delete. */
ry_status ry_yaml_load(yaml_document_t *document, const char *text, ry_place place,
                       ry_error *error);

/* The node's text; NULL: not a scalar, or with a NUL character in it. */
const char *ry_yaml_text(const yaml_node_t *node);

/* Nothing stands behind the colon ("grains:"), or ~ or null. */
int ry_yaml_is_null(const yaml_node_t *node);

/* "a list", "a map" or the quoted text, for messages. */
ry_quote ry_yaml_quote(const yaml_node_t *node);

/* `place` with the line of the node, if it is in a file. */
ry_place ry_yaml_place(ry_place place, const yaml_node_t *node);

/* 1: valid UTF-8. */
int ry_yaml_is_utf8(const char *text);

#endif
