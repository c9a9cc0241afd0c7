/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa threshold: when does a bed begin to move, when does it come to rest? */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "study/threshold.h"

enum { MAX_CORES = 1024, LOW = 256, HIGH, TOLERANCE, CRITERION, FRESH };

typedef struct arguments {
    ry_threshold_options wish;
    ry_overrides overrides;
    int quiet, terminal, next_tenth;
} arguments;

static error_t parse_number(const char *option, const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && !*end && isfinite(*value)
               ? 0
               : ry_cli_misuse("%s %s: give a number", option, text);
}

static error_t finish_arguments(const arguments *a)
{
    if (!a->wish.scene || !*a->wish.scene) {
        return ry_cli_misuse("which scene file?");
    }
    if (a->wish.output && (!*a->wish.output || strcmp(a->wish.output, a->wish.scene) == 0)) {
        return ry_cli_misuse("-o: the result file needs a name of its own");
    }
    return 0;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o': a->wish.output = text; return 0;
    case 's': return ry_cli_override(state, &a->overrides, text);
    case 'j': return ry_cli_count("-j", "the number of cores", text, 1, MAX_CORES, &a->wish.cores);
    case 'n':
        return ry_cli_count("--replicas", "the number of beds", text, 1, 1000, &a->wish.replicas);
    case LOW: return parse_number("--low", text, &a->wish.low);
    case HIGH: return parse_number("--high", text, &a->wish.high);
    case TOLERANCE: return parse_number("--tolerance", text, &a->wish.tolerance);
    case CRITERION: return parse_number("--criterion", text, &a->wish.criterion);
    case FRESH: a->wish.fresh = 1; return 0;
    case 'f': a->wish.force = 1; return 0;
    case 'q': a->quiet = 1; return 0;
    case ARGP_KEY_ARG: return ry_cli_single(&a->wish.scene, text);
    case ARGP_KEY_END: return finish_arguments(a);
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"output", 'o', "OUT.h5", 0, "file for every trial (none)", 0},
    {"set", 's', "KEY=VALUE", 0, "replace a value of the scene; may be repeated", 0},
    {"cores", 'j', "N", 0, "cores to use (all)", 0},
    {"replicas", 'n', "N", 0, "beds, with consecutive grains.seed (4)", 0},
    {"low", LOW, "THETA", 0, "Shields number at which every bed rests (0.01)", 0},
    {"high", HIGH, "THETA", 0, "Shields number at which every bed moves (0.4)", 0},
    {"tolerance", TOLERANCE, "WIDTH", 0, "known within this, for each bed (0.002)", 0},
    {"criterion", CRITERION, "Q", 0, "a bed moves if its q* is at least this (1e-4)", 0},
    {"fresh", FRESH, NULL, 0, "from rest: the bed as it has settled from its lattice, without a push", 0},
    {"force", 'f', NULL, 0, "replace an OUT.h5 that is there", 0},
    {"quiet", 'q', NULL, 0, "no progress", 0},
    {0},
};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "SCENE.yaml",
    .doc =
        "Finds the Shields numbers at which a bed at rest begins to move, and at which a moving one comes to "
        "rest, by bisection for each of several beds (docs/threshold.md). Both begin with the same push.\v"
        "The mean q* over the second half of the time with the fluid on decides. A trial runs up to time.end.",
};

static int on_progress(void *data, int trials, int most)
{
    arguments *const a = data;
    if (!a->quiet && a->terminal) {
        char text[80];
        snprintf(text, sizeof text, "%3d %%  %d of %d trials", 100 * trials / most, trials, most);
        ry_progress_line(text);
    } else if (!a->quiet && 10 * trials >= a->next_tenth * most) {
        fprintf(stderr, "%3d %%  %d of %d trials\n", 100 * trials / most, trials, most);
        a->next_tenth = 10 * trials / most + 1;
    }
    return ry_cli_stop_asked();
}

static void print_side(const char *name, const ry_threshold_side *side, int digits)
{
    printf("%-12s %.*g", name, digits, side->mean);
    if (isfinite(side->standard_error)) {
        printf(" +- %.2g   (95 %%: %.*g to %.*g)", side->standard_error, digits, side->low, digits, side->high);
    }
    printf("\n");
}

static void print_result(const arguments *a, const ry_threshold_result *r)
{
    printf("Shields number at which the flux reaches q* = %g, %d beds, each known within %g\n",
           a->wish.criterion, a->wish.replicas, a->wish.tolerance);
    print_side("from rest", &r->side[RY_THRESHOLD_REST], 4);
    print_side("from motion", &r->side[RY_THRESHOLD_MOTION], 4);
    print_side("difference", &r->difference, 2);
    printf("literature at D* = %.4g:", r->d_star);
    for (int k = 0; k < r->n_literature; k++) {
        printf("%s %s %.3g", k ? "," : "", r->literature_name[k], r->literature[k]);
    }
    printf("\n%d trials in %.3g s\n", r->trials, r->seconds);
    if (a->wish.output) {
        printf("result  %s\n", a->wish.output);
    }
}

int ry_cli_threshold(int argc, char **argv)
{
    arguments a = {.wish = ry_threshold_options_default(),
                   .terminal = ry_cli_is_terminal()};
    ry_threshold_result result;
    ry_error error = {0};
    int status = ry_cli_parse("ryusa threshold", &argp, 0, argc, argv, &a);
    if (status == RY_OK) {
        a.wish.overrides = a.overrides.text;
        a.wish.n_overrides = a.overrides.n;
        a.wish.progress = on_progress;
        a.wish.data = &a;
        ry_cli_catch_signals();
        status = (int)ry_threshold_find_motion(&a.wish, &result, &error);
        if (a.terminal && !a.quiet) {
            fputs("\r\033[K", stderr);
        }
        if (status == RY_OK) {
            print_result(&a, &result);
        } else if (status == RY_STOPPED) {
            fprintf(stderr, "ryusa: stopped; nothing is kept of a search for thresholds\n");
        } else {
            status = ry_cli_report(&error);
        }
    }
    free(a.overrides.text);
    return status;
}
