/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa verify: the cases of the paper against exact values. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "study/verify.h"

enum { MAX_THREADS = 1024 };

typedef struct arguments {
    unsigned cases;
    const char *output;
    int force, quick, quiet, threads;
} arguments;

static error_t add_case(arguments *a, const char *word)
{
    for (int k = 0; k < RY_VERIFY_CASES; k++) {
        if (strcmp(word, ry_verify_case_word(k)) == 0) {
            a->cases |= 1u << k;
            return 0;
        }
    }
    char list[400] = "";
    for (int k = 0; k < RY_VERIFY_CASES; k++) {
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", ry_verify_case_word(k));
    }
    return ry_cli_misuse("there is no case '%s'; there are: %s", word, list);
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o': a->output = text; return 0;
    case 'f': a->force = 1; return 0;
    case 'Q': a->quick = 1; return 0;
    case 'q': a->quiet = 1; return 0;
    case 'j': return ry_cli_count("-j", "the number of threads", text, 1, MAX_THREADS, &a->threads);
    case ARGP_KEY_ARG: return add_case(a, text);
    case ARGP_KEY_END: return *a->output ? 0 : ry_cli_misuse("-o: the file needs a name");
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"output", 'o', "FILE.h5", 0, "file for the numbers behind the tables (verify.h5)", 0},
    {"force", 'f', NULL, 0, "replace a FILE.h5 that is there", 0},
    {"quick", 'Q', NULL, 0, "a few seconds: no time steps below 1e-5 s, shorter timings", 0},
    {"threads", 'j', "N", 0, "simulations at a time (as many as there are cores)", 0},
    {"quiet", 'q', NULL, 0, "print nothing but errors", 0},
    {0},
};

/* Before the \v what it does, behind it the cases. */
static char *add_cases_to_help(int key, const char *text, void *input)
{
    (void)input;
    if (key != ARGP_KEY_HELP_POST_DOC) {
        return (char *)text;
    }
    ry_page page = {0};
    ry_page_write(&page, "Cases, all of them unless named:\n");
    for (int k = 0; k < RY_VERIFY_CASES; k++) {
        char line[120];
        snprintf(line, sizeof line, "  %-14s %s\n", ry_verify_case_word(k), ry_verify_case_text(k));
        ry_page_write(&page, line);
    }
    ry_page_write(&page,
                  "\nA claim is ok, or differs for a reason that is told, or has FAILED: then the "
                  "exit status is 3. postprocess/verify.py draws FILE.h5.");
    return page.text;
}

static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "[CASE...]",
    .doc = "Runs the tests of section 5 of Fujioka and Ushijima (2005) for the laws compared there and `energy`, and "
           "holds them against exact values and against what is printed there.\v",
    .help_filter = add_cases_to_help,
};

static void print(void *data, const char *text)
{
    if (!((const arguments *)data)->quiet) {
        fputs(text, stdout);
        fflush(stdout);
    }
}

int ry_cli_verify(int argc, char **argv)
{
    arguments a = {.output = "verify.h5"};
    const int status = ry_cli_parse("ryusa verify", &argp, 0, argc, argv, &a);
    if (status != RY_OK) {
        return status;
    }
    const ry_verify_options wish = {.cases = a.cases,
                                    .output = a.output,
                                    .force = a.force,
                                    .quick = a.quick,
                                    .threads = a.threads,
                                    .write = print,
                                    .data = &a};
    ry_verify_summary summary = {0};
    ry_error error = {0};
    if (ry_verify(&wish, &summary, &error) != RY_OK) {
        return ry_cli_report(&error);
    }
    if (!a.quiet) {
        printf("%d claims: %d ok, %d differ for a known reason, %d failed; %.3g s; numbers in %s\n",
               summary.ok + summary.differs + summary.failed, summary.ok, summary.differs,
               summary.failed, summary.seconds, a.output);
    }
    if (summary.failed > 0) {
        ry_fail(&error, RY_UNPHYSICAL, "verify: %d claims failed%s", summary.failed,
                a.quiet ? "" : ": see FAILED above");
        return ry_cli_report(&error);
    }
    return RY_OK;
}
