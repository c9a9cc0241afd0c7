/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a mistyped key or word was probably meant to be. */
#ifndef RY_CONFIG_NEAREST_H
#define RY_CONFIG_NEAREST_H

/* Inserted, missing, wrong and swapped characters between two words; case and -, _ do not count. */
int ry_nearest_distance(const char *a, const char *b);

/* The nearest of the words (NULL after the last); NULL: none is near. */
const char *ry_nearest_word(const char *word, const char *const *words);

/* The nearest key to section.key, written in full ("grains.diameter"), from all sections; section
 * NULL: `key` stands at the top of the file. "": none is near. */
void ry_nearest_key(const char *section, const char *key, char *out, int size);

#endif
