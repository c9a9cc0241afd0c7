/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The only file that drives libyaml's parser. */
#include "config/yaml.h"

#include <stdio.h>
#include <string.h>

/* The line in which byte `offset` of the text stands, from 1. */
static int line_of(const char *text, size_t offset)
{
    int line = 1;
    for (size_t i = 0; i < offset && text[i] != '\0'; i++) {
        line += text[i] == '\n';
    }
    return line;
}

static ry_status syntax_error(const yaml_parser_t *parser, const char *text, ry_place place,
                              ry_error *error)
{
    if (parser->error == YAML_MEMORY_ERROR) {
        return ry_fail(error, RY_BAD_FILE, "not enough memory to read %s", place.name);
    }
    const char *problem = parser->problem != NULL ? parser->problem : "can't be understood";
    if (place.override_ == NULL) {
        place.line = parser->error == YAML_READER_ERROR ? line_of(text, parser->problem_offset)
                                                        : (int)parser->problem_mark.line + 1;
    }
    const size_t at = parser->problem_mark.index;
    if (parser->error == YAML_SCANNER_ERROR && at < strlen(text) && text[at] == '\t') {
        problem = "a tab; indent by blanks,";
    }
    const int with_context = parser->context != NULL && parser->error != YAML_READER_ERROR;
    return ry_place_fail(place, NULL, error, "not valid YAML: %s%s%s", problem,
                         with_context ? " " : "", with_context ? parser->context : "");
}

/* A second document after the first would be silently unused. */
static ry_status refuse_second(yaml_parser_t *parser, const char *text, ry_place place,
                               ry_error *error)
{
    yaml_document_t second;
    if (!yaml_parser_load(parser, &second)) {
        return syntax_error(parser, text, place, error);
    }
    const yaml_node_t *root = yaml_document_get_root_node(&second);
    ry_status status = RY_OK;
    if (root != NULL) {
        status = ry_place_fail(ry_yaml_place(place, root), NULL, error,
                               "a second document begins here; a scene is one document");
    }
    yaml_document_delete(&second);
    return status;
}

/* libyaml needs time that grows with the square of the depth; a scene is five levels deep. Brackets
 * in texts count too, and do no harm: they mostly close. */
static int too_deep(const char *text)
{
    int depth = 0;
    for (char before = '\n'; *text != '\0' && depth < 1000; before = *text++) {
        if (*text == '#' && strchr(" \t\r\n", before) != NULL) { /* a comment */
            text += strcspn(text, "\n");
            text -= *text == '\0';
            continue;
        }
        depth += (*text == '[' || *text == '{') - (*text == ']' || *text == '}');
        depth = depth > 0 ? depth : 0;
    }
    return depth >= 1000;
}

ry_status ry_yaml_load(yaml_document_t *document, const char *text, ry_place place, ry_error *error)
{
    yaml_parser_t parser;
    if (too_deep(text)) {
        return ry_place_fail(place, NULL, error, "not valid YAML for a scene: nested too deeply");
    }
    if (!yaml_parser_initialize(&parser)) {
        return ry_fail(error, RY_BAD_FILE, "not enough memory to read %s", place.name);
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, strlen(text));
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    ry_status status;
    if (!yaml_parser_load(&parser, document)) {
        status = syntax_error(&parser, text, place, error);
    } else {
        if (yaml_document_get_root_node(document) == NULL) {
            status = ry_place_fail(
                place, NULL, error,
                place.override_ != NULL
                    ? "no value; write section.key=value"
                    : "the scene is empty; it needs at least 'grains:' or 'particles:'");
        } else {
            status = refuse_second(&parser, text, place, error);
        }
        if (status != RY_OK) {
            yaml_document_delete(document);
        }
    }
    yaml_parser_delete(&parser);
    return status;
}

const char *ry_yaml_text(const yaml_node_t *node)
{
    if (node->type != YAML_SCALAR_NODE) {
        return NULL;
    }
    const char *text = (const char *)node->data.scalar.value;
    return strlen(text) == node->data.scalar.length ? text : NULL;
}

int ry_yaml_is_null(const yaml_node_t *node)
{
    const char *text = ry_yaml_text(node);
    return text != NULL && node->data.scalar.style == YAML_PLAIN_SCALAR_STYLE &&
           (text[0] == '\0' || strcmp(text, "~") == 0 || strcmp(text, "null") == 0);
}

ry_quote ry_yaml_quote(const yaml_node_t *node)
{
    const char *text = ry_yaml_text(node);
    if (node->type == YAML_SEQUENCE_NODE) {
        return (ry_quote){"a list"};
    }
    if (node->type == YAML_MAPPING_NODE) {
        return (ry_quote){"a map"};
    }
    if (text == NULL) {
        return (ry_quote){"a text with a NUL character"};
    }
    if (text[0] == '\0') {
        return (ry_quote){"nothing"};
    }
    ry_quote inner = ry_place_quote(text), quote;
    inner.text[sizeof inner.text - 3] = '\0';
    (void)snprintf(quote.text, sizeof quote.text, "'%.61s'", inner.text);
    return quote;
}

ry_place ry_yaml_place(ry_place place, const yaml_node_t *node)
{
    if (place.override_ == NULL) {
        place.line = (int)node->start_mark.line + 1;
    }
    return place;
}

/* How many bytes follow a first byte; -1: it can't be one. */
static int followers(unsigned char c)
{
    return c < 0x80 ? 0 : c < 0xC2 ? -1 : c < 0xE0 ? 1 : c < 0xF0 ? 2 : c < 0xF5 ? 3 : -1;
}

int ry_yaml_is_utf8(const char *text)
{
    for (const unsigned char *p = (const unsigned char *)text; *p != 0;) {
        const int n = followers(*p++);
        if (n < 0) {
            return 0;
        }
        for (int i = 0; i < n; i++) {
            if ((*p++ & 0xC0) != 0x80) {
                return 0;
            }
        }
    }
    return 1;
}
