/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa info: what a result file, or the table of a sweep, holds. */
#include <stdlib.h>

#include "cli/cli.h"

static error_t parse(int key, char *text, struct argp_state *state)
{
    const char **file = state->input;
    switch (key) {
    case ARGP_KEY_ARG: return ry_cli_single(file, text);
    case ARGP_KEY_END: return *file ? 0 : ry_cli_misuse("which result file?");
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    .parser = parse,
    .args_doc = "FILE.h5",
    .doc =
        "Says what a result file, or the table of a sweep, holds, in words and numbers. A FILE.h5.part of a "
        "run that goes on, or was killed, can be read as well.",
};

int ry_cli_info(int argc, char **argv)
{
    const char *file = NULL;
    ry_error error = {0};
    ry_page page = {0};
    const int status = ry_cli_parse("ryusa info", &argp, 0, argc, argv, &file);
    if (status != RY_OK) {
        return status;
    }
    if (ry_describe_file(file, ry_page_write, &page, &error) != RY_OK) {
        free(page.text);
        return ry_cli_report(&error);
    }
    ry_page_print(&page);
    return RY_OK;
}
