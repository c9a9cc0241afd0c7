/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Edit distance with swaps of neighbours (optimal string alignment), and the search for the nearest
 * key. A key of the right name in the wrong section counts as one mistake. */
#include "config/nearest.h"

#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "config/keys.h"

enum { LONGEST = 40 }; /* longer words are not mistyped keys */

static int plain(char c)
{
    return c == '-' || c == ' ' ? '_' : tolower((unsigned char)c);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

int ry_nearest_distance(const char *a, const char *b)
{
    const int n = (int)strnlen(a, LONGEST + 1), m = (int)strnlen(b, LONGEST + 1);
    if (n > LONGEST || m > LONGEST) {
        return LONGEST;
    }
    int d[LONGEST + 1][LONGEST + 1];
    for (int i = 0; i <= n; i++) {
        for (int j = 0; j <= m; j++) {
            if (i == 0 || j == 0) {
                d[i][j] = i + j;
                continue;
            }
            const int wrong = plain(a[i - 1]) != plain(b[j - 1]);
            d[i][j] = smaller(smaller(d[i - 1][j], d[i][j - 1]) + 1, d[i - 1][j - 1] + wrong);
            if (i > 1 && j > 1 && plain(a[i - 1]) == plain(b[j - 2]) &&
                plain(a[i - 2]) == plain(b[j - 1])) {
                d[i][j] = smaller(d[i][j], d[i - 2][j - 2] + 1);
            }
        }
    }
    return d[n][m];
}

/* A word and a longer form of it ("step", "stepsize") count as two mistakes. */
static int mistakes(const char *typed, const char *word)
{
    const int distance = ry_nearest_distance(typed, word);
    const size_t n = strlen(typed), m = strlen(word), common = n < m ? n : m;
    return common >= 4 && strncmp(typed, word, common) == 0 ? smaller(distance, 2) : distance;
}

/* The mistakes that a word of this length may have to be recognised. */
static int tolerance(const char *typed)
{
    const int n = (int)strnlen(typed, LONGEST);
    return n <= 3 ? 1 : n <= 5 ? 2 : 3;
}

const char *ry_nearest_word(const char *word, const char *const *words)
{
    const char *best = NULL;
    int least = tolerance(word) + 1;
    for (; *words != NULL; words++) {
        const int distance = mistakes(word, *words);
        if (distance < least) {
            least = distance;
            best = *words;
        }
    }
    return best;
}

/* Keeps the better of the best so far and section.key (or key alone). */
static void offer(int distance, const char *section, const char *key, int *least, char *out,
                  int size)
{
    if (distance < *least) {
        *least = distance;
        (void)snprintf(out, (size_t)size, "%s%s%s", section, section[0] ? "." : "", key);
    }
}

static void offer_key(const char *section, const char *key, const char *in, const char *candidate,
                      int *least, char *out, int size)
{
    int distance = mistakes(key, candidate);
    if (section == NULL || strcmp(section, in) != 0) {
        distance += 1;
    }
    offer(distance, in, candidate, least, out, size);
}

void ry_nearest_key(const char *section, const char *key, char *out, int size)
{
    int least = tolerance(key) + 1;
    out[0] = '\0';
    if (section == NULL) {
        offer(mistakes(key, "title"), "", "title", &least, out, size);
        offer(mistakes(key, "particles"), "", "particles", &least, out, size);
    }
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        const ry_key_row *row = ry_keys_row(i);
        if (section == NULL && ry_keys_section(row->section) == i) {
            offer(mistakes(key, row->section), "", row->section, &least, out, size);
        }
    }
    /* Sections near the one that was typed first: "fluids.density" means fluid, not grains. */
    for (int near = section != NULL; near >= 0; near--) {
        for (int i = 0; i < RY_KEY_COUNT; i++) {
            const ry_key_row *row = ry_keys_row(i);
            if (!near || ry_nearest_distance(section, row->section) <= 2) {
                offer_key(section, key, row->section, row->key, &least, out, size);
            }
        }
    }
    offer_key(section, key, "output", "fields", &least, out, size);
}
