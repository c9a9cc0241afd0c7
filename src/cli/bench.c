/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa bench: accuracy, stability, speed. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"
#include "study/bench.h"

enum { MAX_THREADS = 1024 };

typedef struct arguments {
    int bench; /* -1: none yet */
    char output[64];
    const char *wish;
    unsigned laws;
    int force, quick, quiet, threads;
    int is_terminal, percent;
} arguments;

static error_t set_bench(arguments *a, const char *word)
{
    char list[200] = "";
    for (int k = 0; k < RY_BENCHES; k++) {
        if (strcmp(word, ry_bench_word(k)) == 0) {
            if (a->bench >= 0) {
                return ry_cli_misuse("one bench at a time, not '%s' too", word);
            }
            a->bench = k;
            return 0;
        }
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", ry_bench_word(k));
    }
    return ry_cli_misuse("there is no bench '%s'; there are: %s", word, list);
}

static error_t add_law(arguments *a, const char *word)
{
#define RY_NAME(value, name) name,
    static const char *const names[] = {RY_LIST_law(RY_NAME)};
#undef RY_NAME
    char list[200] = "";
    for (int k = 0; k < RY_LAW_COUNT; k++) {
        if (strcmp(word, names[k]) == 0) {
            a->laws |= 1u << k;
            return 0;
        }
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", names[k]);
    }
    return ry_cli_misuse("there is no law '%s'; there are: %s", word, list);
}

static error_t parse_threads(const char *text, int *threads)
{
    char *end;
    errno = 0;
    const long n = strtol(text, &end, 10);
    if (end == text || *end || errno || n < 1 || n > MAX_THREADS) {
        return ry_cli_misuse("-j %s: the number of threads is a whole number, 1 to %d", text,
                             MAX_THREADS);
    }
    *threads = (int)n;
    return 0;
}

static error_t finish_arguments(arguments *a)
{
    if (a->bench < 0) {
        return ry_cli_misuse("which bench? accuracy, stability or speed");
    }
    if (a->wish == NULL) {
        snprintf(a->output, sizeof a->output, "bench-%s.h5", ry_bench_word(a->bench));
        a->wish = a->output;
    }
    return *a->wish ? 0 : ry_cli_misuse("-o: the file needs a name");
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o': a->wish = text; return 0;
    case 'l': return add_law(a, text);
    case 'f': a->force = 1; return 0;
    case 'Q': a->quick = 1; return 0;
    case 'q': a->quiet = 1; return 0;
    case 'j': return parse_threads(text, &a->threads);
    case ARGP_KEY_ARG: return set_bench(a, text);
    case ARGP_KEY_END: return finish_arguments(a);
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"output", 'o', "FILE.h5", 0, "file for the numbers (bench-NAME.h5)", 0},
    {"force", 'f', NULL, 0, "replace a FILE.h5 that is there", 0},
    {"law", 'l', "NAME", 0, "this contact law only; may be repeated", 0},
    {"quick", 'Q', NULL, 0, "coarse: tens of seconds instead of minutes", 0},
    {"threads", 'j', "N", 0,
     "simulations at a time (as many as there are cores); changes times only. speed takes 1 and 2 "
     "threads whatever this says",
     0},
    {"quiet", 'q', NULL, 0, "print nothing but errors", 0},
    {0},
};

/* Before the \v what it does, behind it the benches. */
static char *add_benches_to_help(int key, const char *text, void *input)
{
    (void)input;
    if (key != ARGP_KEY_HELP_POST_DOC) {
        return (char *)text;
    }
    ry_page page = {0};
    for (int k = 0; k < RY_BENCHES; k++) {
        char line[120];
        snprintf(line, sizeof line, "  %-12s %s\n", ry_bench_word(k), ry_bench_text(k));
        ry_page_write(&page, line);
    }
    ry_page_write(&page, "\npostprocess/bench.py draws FILE.h5.");
    return page.text;
}

static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "accuracy|stability|speed",
    .doc = "Measures the simulator itself.\v",
    .help_filter = add_benches_to_help,
};

static void print(void *data, const char *text)
{
    if (!((const arguments *)data)->quiet) {
        fputs(text, stdout);
        fflush(stdout);
    }
}

static void print_progress(void *data, int done, int n)
{
    arguments *const a = data;
    const int percent = (int)(100LL * done / n);
    if (a->quiet || percent == a->percent || (!a->is_terminal && percent / 10 == a->percent / 10)) {
        return;
    }
    a->percent = percent;
    fprintf(stderr, a->is_terminal ? "\r%3d %%  %d of %d%s" : "%3d %%  %d of %d%s", percent, done,
            n, !a->is_terminal || done == n ? "\n" : " ");
}

int ry_cli_bench(int argc, char **argv)
{
    arguments a = {.bench = -1, .percent = -1, .is_terminal = ry_cli_is_terminal()};
    const int status = ry_cli_parse("ryusa bench", &argp, 0, argc, argv, &a);
    if (status != RY_OK) {
        return status;
    }
    const ry_bench_options wish = {.bench = a.bench,
                                   .output = a.wish,
                                   .force = a.force,
                                   .laws = a.laws,
                                   .quick = a.quick,
                                   .threads = a.threads,
                                   .write = print,
                                   .progress = print_progress,
                                   .data = &a};
    ry_error error = {0};
    if (ry_bench(&wish, &error) != RY_OK) {
        return ry_cli_report(&error);
    }
    if (!a.quiet) {
        printf("numbers in %s\n", a.wish);
    }
    return RY_OK;
}
