/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa run: one scene, one result file. Ctrl-C asks the run to save and stop, a second one ends it at
 * once (what was saved last is kept). */
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/cli.h"
#include "cli/progress.h"
#include "cli/signals.h"

enum { MAX_THREADS = 1024 };

typedef struct arguments {
    const char *scene, *output;
    char *default_output;
    ry_overrides overrides;
    int threads, resume, force, quiet;
} arguments;

/* --- The command line ------------------------------------------------------------------------- */

static int is_same_file(const char *a, const char *b)
{
    struct stat sa, sb;
    return stat(a, &sa) == 0 && stat(b, &sb) == 0 && sa.st_dev == sb.st_dev &&
           sa.st_ino == sb.st_ino;
}

static error_t finish_arguments(arguments *a)
{
    if (!a->scene || !*a->scene) {
        return ry_cli_misuse("which scene file?");
    }
    if (!a->output) {
        a->default_output = ry_cli_name_output(a->scene, ".h5");
        a->output = a->default_output;
    }
    if (!a->output || !*a->output) {
        return ry_cli_misuse("-o: the result file needs a name");
    }
    if (is_same_file(a->scene, a->output)) {
        return ry_cli_misuse("-o %s: the result would replace the scene", a->output);
    }
    return 0;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o': a->output = text; return 0;
    case 's': return ry_cli_override(state, &a->overrides, text);
    case 'j': return ry_cli_count("-j", "the number of threads", text, 1, MAX_THREADS, &a->threads);
    case 'r': a->resume = 1; return 0;
    case 'f': a->force = 1; return 0;
    case 'q': a->quiet = 1; return 0;
    case ARGP_KEY_ARG: return ry_cli_single(&a->scene, text);
    case ARGP_KEY_END: return finish_arguments(a);
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"output", 'o', "OUT.h5", 0,
     "result file (the name of the scene with .h5, in the current folder)", 0},
    {"set", 's', "KEY=VALUE", 0,
     "replace a value of the scene, such as contact.friction=0.4; may be repeated, of one key the last counts", 0},
    {"threads", 'j', "N", 0, "number of threads (as many as pay); changes no bit of the result", 0},
    {"resume", 'r', NULL, 0, "go on from OUT.h5.part, or from OUT.h5 if time.end has grown", 0},
    {"force", 'f', NULL, 0, "replace an OUT.h5 that is there", 0},
    {"quiet", 'q', NULL, 0, "print nothing but errors", 0},
    {0},
};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "SCENE.yaml",
    .doc =
        "Runs a scene to its end. While it goes on the result is OUT.h5.part.\v"
        "Ctrl-C saves and stops; --resume goes on from there, to the same bits as if it had never "
        "stopped.",
};

static int on_progress(void *data, long long step, long long last_step, double rate)
{
    ry_progress_update(data, step, last_step, rate);
    return ry_cli_stop_asked();
}

/* --- What is said at the end ------------------------------------------------------------------ */

/* As a shell would need it. */
static void print_word(FILE *out, const char *word)
{
    int plain = *word != 0;
    for (const char *c = word; *c; c++) {
        plain = plain && (isalnum((unsigned char)*c) || strchr("_-./=,:+@%", *c));
    }
    if (plain) {
        fprintf(out, " %s", word);
        return;
    }
    fputs(" '", out);
    for (const char *c = word; *c; c++) {
        fputs(*c == '\'' ? "'\\''" : (char[]){*c, 0}, out);
    }
    fputc('\'', out);
}

static void print_stopped(const arguments *a, const ry_progress *progress)
{
    fprintf(stderr, "ryusa: stopped at t = %.6g s, saved; go on with:",
            (double)progress->step * progress->dt);
    print_word(stderr, ry_cli_program);
    fputs(" run", stderr);
    print_word(stderr, a->scene);
    fputs(" -o", stderr);
    print_word(stderr, a->output);
    for (int i = 0; i < a->overrides.n; i++) {
        fputs(" -s", stderr);
        print_word(stderr, a->overrides.text[i]);
    }
    if (a->threads) {
        fprintf(stderr, " -j %d", a->threads);
    }
    fputs(" --resume\n", stderr);
}

static void print_flux(const ry_config *config, const ry_run_result *r)
{
    if (r->samples <= 0 || !(ry_config_derive(config).length > 0.0)) {
        printf("q*      not known: %s\n", r->samples <= 0 ? "the run has no samples with the fluid on"
                                                          : "the scene has no domain.length");
        return;
    }
    printf("q*      %.4g +- %.2g at Shields number %.4g\n", r->q_star, r->q_star_error,
           ry_config_derive(config).shields);
    printf(
        "        q* = q_b/sqrt((s-1) g d^3), q_b = sum of sphere volume x velocity / (length x d)\n"
        "        +- one standard error, from the autocorrelation of %lld samples after t = %.4g s\n",
        r->samples, r->equilibration);
    if (r->stopped_early) {
        printf("        ended before time.end: known as well as stop.flux_error asks\n");
    }
}

static void print_summary(const arguments *a, const ry_config *config, const ry_run_result *r)
{
    if (r->note[0]) {
        printf("note    %s\n", r->note);
    }
    if (config->fluid_model != RY_FLUID_NONE) {
        print_flux(config, r);
    }
    printf("steps   %lld in %.4g s", r->steps, r->wall_seconds);
    if (r->steps > 0 && r->wall_seconds > 0) {
        printf(", %.4g per second", (double)r->steps / r->wall_seconds);
    }
    printf("\nresult  %s\nstate hash 0x%016llx\n", a->output, r->hash);
}

static int run(const arguments *a, const ry_config *config)
{
    ry_error error = {0};
    ry_run_result result = {0};
    ry_progress progress = ry_progress_start(config, a->quiet);
    const ry_run_options run_options = {.output = a->output,
                                        .threads = a->threads,
                                        .resume = a->resume,
                                        .force = a->force,
                                        .progress = on_progress,
                                        .data = &progress};
    ry_cli_catch_signals();
    const ry_status status = ry_run(config, &run_options, &result, &error);
    ry_progress_end(&progress, status == RY_OK && result.steps > 0 && !result.stopped_early);
    if (status == RY_STOPPED) {
        print_stopped(a, &progress);
        return RY_STOPPED;
    }
    if (status != RY_OK) {
        error.status = status;
        return ry_cli_report(&error);
    }
    if (!a->quiet) {
        print_summary(a, config, &result);
    }
    return RY_OK;
}

int ry_cli_run(int argc, char **argv)
{
    arguments a = {0};
    int status = ry_cli_parse("ryusa run", &argp, 0, argc, argv, &a);
    if (status == RY_OK) {
        ry_error error = {0};
        ry_config config;
        if (ry_config_load(&config, a.scene, a.overrides.text, a.overrides.n, &error) == RY_OK) {
            status = run(&a, &config);
            ry_config_free(&config);
        } else {
            status = ry_cli_report(&error);
        }
    }
    free(a.default_output);
    free(a.overrides.text);
    return status;
}
