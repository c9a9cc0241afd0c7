/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa tune: alpha_m, alpha_cn and beta of a movable bed, in the four steps of Harada et al. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "cli/cli.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "study/tune.h"

enum { MAX_THREADS = 1024, MAX_VARIED = 20, JOINT = 256, VARY, BUDGET };

typedef struct arguments {
    const char *scene, *output, *target;
    char *default_output;
    ry_overrides overrides;
    int threads, resume, force, quiet, quick, joint, budget, n_vary;
    const char *vary[MAX_VARIED];
} arguments;

typedef struct display {
    int quiet, terminal;
    const char *what;
    double next_share;
} display;

static error_t finish_arguments(arguments *a)
{
    if (!a->scene || !*a->scene) {
        return ry_cli_misuse("which scene file?");
    }
    if (!a->output) {
        a->default_output = ry_cli_name_output(a->scene, "-tuned.h5");
        a->output = a->default_output;
    }
    if (!a->output || !*a->output) {
        return ry_cli_misuse("-o: the result file needs a name");
    }
    if (a->resume && a->force) {
        return ry_cli_misuse("--resume and --force: go on, or begin anew?");
    }
    return 0;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o': a->output = text; return 0;
    case 't': a->target = text; return 0;
    case 's': return ry_cli_override(state, &a->overrides, text);
    case 'j': return ry_cli_count("-j", "the number of threads", text, 1, MAX_THREADS, &a->threads);
    case 'r': a->resume = 1; return 0;
    case 'f': a->force = 1; return 0;
    case 'q': a->quiet = 1; return 0;
    case 'Q': a->quick = 1; return 0;
    case JOINT: a->joint = 1; return 0;
    case VARY:
        if (a->n_vary == MAX_VARIED) {
            return ry_cli_misuse("--vary: too many constants");
        }
        a->vary[a->n_vary++] = text;
        return 0;
    case BUDGET:
        return ry_cli_count("--budget", "the number of candidates", text, 1, 100000, &a->budget);
    case ARGP_KEY_ARG: return ry_cli_single(&a->scene, text);
    case ARGP_KEY_END: return finish_arguments(a);
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"output", 'o', "OUT.h5", 0,
     "file for every curve (the scene's name with -tuned.h5, in the current folder); the scene with "
     "the constants found goes to OUT.yaml",
     0},
    {"target", 't', "KEY|FILE.csv", 0,
     "what the flux shall be: a relation (`ryusa relations' lists them), or a table with the columns "
     "theta and q_star (wong-parker)",
     0},
    {"joint", JOINT, NULL, 0,
     "fit alpha_m, alpha_cn, beta, restitution and friction together, and say which of them the data constrain", 0},
    {"vary", VARY, "KEY=LOW:HIGH", 0, "the same with these constants; may be repeated", 0},
    {"budget", BUDGET, "N", 0, "candidates of the joint fit (63 with five constants)", 0},
    {"set", 's', "KEY=VALUE", 0, "replace a value of the scene; may be repeated", 0},
    {"threads", 'j', "N", 0, "simulations at a time (as many as there are cores)", 0},
    {"resume", 'r', NULL, 0, "go on with what is missing", 0},
    {"force", 'f', NULL, 0, "begin anew, and replace an OUT.h5 and OUT.yaml that are there", 0},
    {"quick", 'Q', NULL, 0, "few candidates and short runs, to try it out", 0},
    {"quiet", 'q', NULL, 0, "print nothing but errors", 0},
    {0},
};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "SCENE.yaml",
    .doc =
        "Finds alpha_m, alpha_cn and beta of a movable bed in the four steps of Harada, Gotoh and Sakai "
        "(docs/tune.md); or any constants together (--joint, --vary).\v"
        "Ctrl-C keeps what is done in OUT.h5.pieces; --resume goes on, also after a kill. "
        "postprocess/tune.py draws OUT.h5.",
};

static void print(void *data, const char *text)
{
    display *const d = data;
    if (!d->quiet) {
        if (d->terminal) {
            fputs("\r\033[K", stderr);
        }
        fputs(text, stdout);
    }
}

static void on_progress(void *data, const ry_tune_progress *p)
{
    display *const d = data;
    char left[40] = "", text[160];
    const double share = p->all > 0 ? (double)p->done / p->all : 1.0;
    if (d->what != p->what) {
        d->what = p->what;
        d->next_share = 0.0;
    }
    if (d->quiet || (!d->terminal && share < d->next_share)) {
        return;
    }
    if (isfinite(p->seconds_left) && p->done < p->all) {
        ry_progress_span(left, sizeof left, p->seconds_left);
    }
    snprintf(text, sizeof text, "%s  %d of %d%s%s%s", p->what, p->done, p->all, left[0] ? "  " : "",
             left, left[0] ? " left" : "");
    if (d->terminal) {
        ry_progress_line(text);
    } else {
        fprintf(stderr, "%s\n", text);
    }
    d->next_share = floor(4.0 * share + 1.0) / 4.0;
}

static int stop_asked(void *data)
{
    (void)data;
    return ry_cli_stop_asked();
}

static int run(const arguments *a)
{
    display d = {.quiet = a->quiet,
                 .terminal = ry_cli_is_terminal()};
    const ry_tune_options wish = {.scene = a->scene,
                                  .output = a->output,
                                  .target = a->target,
                                  .overrides = a->overrides.text,
                                  .n_overrides = a->overrides.n,
                                  .threads = a->threads,
                                  .resume = a->resume,
                                  .force = a->force,
                                  .quick = a->quick,
                                  .joint = a->joint,
                                  .vary = a->vary,
                                  .n_vary = a->n_vary,
                                  .budget = a->budget,
                                  .write = print,
                                  .progress = on_progress,
                                  .stop = stop_asked,
                                  .data = &d};
    ry_error error = {0};
    ry_cli_catch_signals();
    const ry_status status = ry_tune(&wish, &error);
    if (d.terminal && !d.quiet) {
        fputs("\r\033[K", stderr);
    }
    if (status == RY_STOPPED) {
        fprintf(stderr, "ryusa: stopped; what is done is kept in %s.pieces, --resume goes on\n",
                a->output);
        return RY_STOPPED;
    }
    if (status != RY_OK) {
        error.status = status;
        return ry_cli_report(&error);
    }
    if (!a->quiet) {
        printf("        python3 postprocess/tune.py %s draws it\n", a->output);
    }
    return RY_OK;
}

int ry_cli_tune(int argc, char **argv)
{
    arguments a = {.target = "wong-parker"};
    int status = ry_cli_parse("ryusa tune", &argp, 0, argc, argv, &a);
    if (status == RY_OK) {
        status = run(&a);
    }
    free(a.default_output);
    free(a.overrides.text);
    return status;
}
