/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa relations: the bed-load relations and what they give. */
#include <errno.h>
#include <stdlib.h>

#include "cli/cli.h"
#include "study/curves.h"

enum { DENSITY = 256, FLUID_DENSITY, VISCOSITY };

typedef struct arguments {
    ry_curves_options wish;
    const char **names;
} arguments;

static error_t add_name(arguments *a, const struct argp_state *state, const char *text)
{
    if (a->names == NULL) {
        a->names = calloc((size_t)state->argc, sizeof *a->names);
        if (a->names == NULL) {
            return ENOMEM;
        }
        a->wish.names = a->names;
    }
    a->names[a->wish.n_names++] = text;
    return 0;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 't': a->wish.theta = text; return 0;
    case 'c': a->wish.csv = text; return 0;
    case 'f': a->wish.force = 1; return 0;
    case 'd': a->wish.diameter = text; return 0;
    case DENSITY: a->wish.density = text; return 0;
    case FLUID_DENSITY: a->wish.fluid_density = text; return 0;
    case VISCOSITY: a->wish.viscosity = text; return 0;
    case ARGP_KEY_ARG: return add_name(a, state, text);
    case ARGP_KEY_END:
        return !a->wish.csv || *a->wish.csv ? 0 : ry_cli_misuse("--csv: the file needs a name");
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"theta", 't', "LIST", 0, "Shields numbers: 0.05,0.1,0.2 or FROM:TO:STEPS or FROM:TO:STEPS:log",
     0},
    {"csv", 'c', "FILE", 0, "export the values as well; - for CSV in place of the page", 0},
    {"force", 'f', NULL, 0, "replace a FILE that is there", 0},
    {"diameter", 'd', "LENGTH", 0, "of the grains, such as 0.5mm: makes numbers of the thresholds", 0},
    {"density", DENSITY, "DENSITY", 0, "of the grains (2650 kg/m^3)", 0},
    {"fluid-density", FLUID_DENSITY, "DENSITY", 0, "of the fluid (1000 kg/m^3)", 0},
    {"viscosity", VISCOSITY, "VISCOSITY", 0, "of the fluid, kinematic (1e-6 m^2/s)", 0},
    {0},
};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "[NAME...]",
    .doc =
        "Prints bed-load relations, with their thresholds and sources, and the flux q* that they give. "
        "NAME is the key of a relation or a CSV file with the columns theta and q_star; all relations "
        "unless named.",
};

int ry_cli_relations(int argc, char **argv)
{
    ry_page page = {0};
    ry_error error = {0};
    arguments a = {.wish = {.write = ry_page_write, .data = &page}};
    int status = ry_cli_parse("ryusa relations", &argp, 0, argc, argv, &a);
    if (status == RY_OK && ry_curves(&a.wish, &error) != RY_OK) {
        free(page.text);
        status = ry_cli_report(&error);
    } else if (status == RY_OK) {
        ry_page_print(&page);
    }
    free(a.names);
    return status;
}
