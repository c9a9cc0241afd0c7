/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the commands share. Only this folder prints; errors go to stderr as "ryusa: text", and with an
 * error nothing goes to stdout. The functions return the exit code of the program. */
#ifndef RY_CLI_CLI_H
#define RY_CLI_CLI_H

#include <argp.h>

#include "ryusa/ryusa.h"

#define RY_COMMAND(name, arguments, text) int ry_cli_##name(int argc, char **argv);
#include "cli/commands.def"
#undef RY_COMMAND

/* Reads the command line of `name` ("ryusa run") into `input`; flags: those of argp_parse. Not RY_OK:
 * reported, just return it. */
int ry_cli_parse(const char *name, const struct argp *argp, unsigned flags, int argc, char **argv,
                 void *input);

/* For the functions of an argp: says what is wrong and where help is. Returns EINVAL. */
error_t ry_cli_misuse(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* How the program was called, for hints to be copied: the first word of its command line. */
extern const char *ry_cli_program;

/* stderr is a terminal on which a line can be rewritten. */
int ry_cli_is_terminal(void);

/* Prints an error of the library; returns its status. */
int ry_cli_report(const ry_error *error);

/* What -s collects: "key.path=value" texts, as many as the command line has words. */
typedef struct ry_overrides {
    const char **text;
    int n;
} ry_overrides;

/* Adds the argument of an -s; 0, or what an argp function returns. Free overrides->text at the end. */
error_t ry_cli_override(const struct argp_state *state, ry_overrides *overrides, const char *text);

/* The one argument without a dash that every command has; 0, or what an argp function returns. */
error_t ry_cli_single(const char **place, const char *text);

/* Reads the argument of an option: a whole number, `low` to `high`; 0, or what an argp function
 * returns. what: "the number of threads". */
error_t ry_cli_count(const char *option, const char *what, const char *text, int low, int high, int *value);

/* The default name of a result, in the current folder: flumes/steep.yaml -> steep + ending. NULL: no
 * memory. The caller frees it. */
char *ry_cli_name_output(const char *input, const char *ending);

/* Collects what a ry_describe function writes, so that nothing is printed if it fails in the middle. */
typedef struct ry_page {
    char *text;
    size_t length, capacity;
} ry_page;
void ry_page_write(void *page, const char *text);
void ry_page_print(ry_page *page); /* and frees it */

/* Every parameter of a scene file, as a page in Markdown (docs/parameters.md). */
void ry_cli_print_parameters(void);

#endif
