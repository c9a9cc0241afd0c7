/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa show: what a scene means. */
#include <stdlib.h>

#include "cli/cli.h"

typedef struct arguments {
    const char *scene;
    ry_overrides overrides;
    int parameters;
} arguments;

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 's': return ry_cli_override(state, &a->overrides, text);
    case 'P': a->parameters = 1; return 0;
    case ARGP_KEY_ARG: return ry_cli_single(&a->scene, text);
    case ARGP_KEY_END: return a->scene || a->parameters ? 0 : ry_cli_misuse("which scene file?");
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"set", 's', "KEY=VALUE", 0,
     "replace a value of the scene, such as contact.friction=0.4; may be repeated, of one key the last counts", 0},
    {"parameters", 'P', NULL, 0, "instead of a scene: every key that a scene may have, in Markdown",
     0},
    {0},
};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "SCENE.yaml",
    .doc = "Shows the resolved parameters of a scene and what follows from them.",
};

static int show(const arguments *a)
{
    ry_error error = {0};
    ry_config config;
    ry_page page = {0};
    if (ry_config_load(&config, a->scene, a->overrides.text, a->overrides.n, &error) != RY_OK) {
        return ry_cli_report(&error);
    }
    const ry_status status = ry_describe_scene(&config, ry_page_write, &page, &error);
    ry_config_free(&config);
    if (status != RY_OK) {
        free(page.text);
        return ry_cli_report(&error);
    }
    ry_page_print(&page);
    return RY_OK;
}

int ry_cli_show(int argc, char **argv)
{
    arguments a = {0};
    int status = ry_cli_parse("ryusa show", &argp, 0, argc, argv, &a);
    if (status == RY_OK && a.parameters) {
        ry_cli_print_parameters();
    } else if (status == RY_OK) {
        status = show(&a);
    }
    free(a.overrides.text);
    return status;
}
