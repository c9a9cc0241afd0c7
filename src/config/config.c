/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ry_config as an object: made with defaults, walked through, freed. */
#include <stdlib.h>
#include <string.h>

#include "config/guard.h"
#include "config/keys.h"

static char *empty_text(void)
{
    return calloc(1, 1);
}

ry_config ry_config_default(int has_grains)
{
    ry_config config = {0};
    for (int i = 0; i < RY_KEY_COUNT; i++) {
        const ry_key_row *row = ry_keys_row(i);
        ry_keys_set(&config, i, has_grains ? row->usual : row->inert);
    }
    config.output_fields = RY_FIELD_ALL;
    config.has_grains = has_grains != 0;
    config.title = empty_text();
    config.text = empty_text();
    config.path = empty_text();
    config.guard = RY_CONFIG_GUARD;
    return config;
}

void ry_config_free(ry_config *config)
{
    if (config == NULL) {
        return;
    }
    free(config->particles);
    for (int k = 0; k < config->n_tables; k++) {
        free(config->tables[k]);
    }
    free(config->tables);
    free(config->title);
    free(config->text);
    free(config->path);
    memset(config, 0, sizeof *config);
}

/* Words outside the list (a config that was filled in by hand) have no name. */
static void fill_words(const ry_key_row *row, ry_parameter *out)
{
    int n = 0;
    for (; row->words[n] != NULL; n++) {
        out->words[n] = row->words[n];
    }
    out->high = n - 1;
    const int index = (int)out->number;
    out->word = index >= 0 && index < n ? row->words[index] : "";
}

int ry_config_parameter(const ry_config *config, int index, ry_parameter *out)
{
    if (index < 0 || index >= RY_KEY_COUNT) {
        return 0;
    }
    const ry_key_row *row = ry_keys_row(index);
    *out = (ry_parameter){.section = row->section,
                          .key = row->key,
                          .unit = row->unit,
                          .text = row->text,
                          .type = row->type,
                          .low = row->low,
                          .high = row->high,
                          .number = ry_keys_get(config, index)};
    if (row->type == 'c') {
        fill_words(row, out);
    }
    return 1;
}
