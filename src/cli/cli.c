/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "cli/cli.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* getopt begins its messages with argv[0], which stays "ryusa"; argp's pages begin with state->name,
 * which it sets from there after its INIT. So --help and its like are options of ours, which first put
 * the name of the command ("ryusa run") there. */
static char command_name[32] = "ryusa";

static error_t parse_common(int key, char *text, struct argp_state *state)
{
    (void)text;
    state->name = command_name;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = state->input; return 0;
    case 'h': argp_state_help(state, stdout, ARGP_HELP_STD_HELP); return 0;
    case 'u': argp_state_help(state, stdout, ARGP_HELP_USAGE | ARGP_HELP_EXIT_OK); return 0;
    case 'V': printf("ryusa %s\n", ry_version()); exit(RY_OK);
    default: return ARGP_ERR_UNKNOWN;
    }
}

int ry_cli_parse(const char *name, const struct argp *argp, unsigned flags, int argc, char **argv,
                 void *input)
{
    static const struct argp_option options[] = {
        {"help", 'h', NULL, 0, "print this page", -1},
        {"usage", 'u', NULL, OPTION_HIDDEN, NULL, -1},
        {"version", 'V', NULL, 0, "print the version", -1},
        {0},
    };
    const struct argp_child children[] = {{argp, 0, NULL, 0}, {0}};
    const struct argp outer = {options, parse_common, NULL, NULL, children, NULL, NULL};
    snprintf(command_name, sizeof command_name, "%s", name);
    static char program[] = "ryusa";
    argv[0] = program;
    argp_err_exit_status = RY_BAD_INPUT;
    return argp_parse(&outer, argc, argv, flags | ARGP_NO_HELP, NULL, input) ? RY_BAD_INPUT : RY_OK;
}

const char *ry_cli_program = "ryusa";

int ry_cli_is_terminal(void)
{
    const char *const term = getenv("TERM");
    return isatty(STDERR_FILENO) && term && strcmp(term, "dumb") != 0;
}

error_t ry_cli_misuse(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fprintf(stderr, "ryusa: ");
    vfprintf(stderr, format, list);
    fprintf(stderr, "\nTry `%s --help'.\n", command_name);
    va_end(list);
    return EINVAL;
}

int ry_cli_report(const ry_error *error)
{
    fprintf(stderr, "ryusa: %s\n", error->text);
    return (int)error->status;
}

error_t ry_cli_override(const struct argp_state *state, ry_overrides *overrides, const char *text)
{
    if (!strchr(text, '=') || text[0] == '=') {
        return ry_cli_misuse("-s %s: give it as key.path=value, such as -s contact.friction=0.4",
                             text);
    }
    if (!overrides->text) {
        overrides->text = calloc((size_t)state->argc, sizeof *overrides->text);
        if (!overrides->text) {
            return ENOMEM;
        }
    }
    overrides->text[overrides->n++] = text;
    return 0;
}

error_t ry_cli_single(const char **place, const char *text)
{
    if (*place) {
        return ry_cli_misuse("one file at a time: '%s' or '%s'?", *place, text);
    }
    *place = text;
    return 0;
}

error_t ry_cli_count(const char *option, const char *what, const char *text, int low, int high, int *value)
{
    char *end;
    errno = 0;
    const long n = strtol(text, &end, 10);
    if (end == text || *end || errno || n < low || n > high) {
        return ry_cli_misuse("%s %s: %s is a whole number, %d to %d", option, text, what, low, high);
    }
    *value = (int)n;
    return 0;
}

void ry_page_write(void *data, const char *text)
{
    ry_page *page = data;
    const size_t length = strlen(text);
    if (page->length + length + 1 > page->capacity) {
        const size_t capacity = 2 * (page->length + length + 1);
        char *grown = realloc(page->text, capacity);
        if (!grown) {
            return; /* a page cut short: nothing else can be said without memory */
        }
        page->text = grown;
        page->capacity = capacity;
    }
    memcpy(page->text + page->length, text, length + 1);
    page->length += length;
}

void ry_page_print(ry_page *page)
{
    if (page->length > 0) {
        fwrite(page->text, 1, page->length, stdout);
    }
    free(page->text);
    *page = (ry_page){0};
}

char *ry_cli_name_output(const char *input, const char *ending)
{
    const char *slash = strrchr(input, '/');
    const char *base = slash ? slash + 1 : input;
    const char *dot = strrchr(base, '.');
    const size_t length = dot && dot != base ? (size_t)(dot - base) : strlen(base);
    char *name = malloc(length + strlen(ending) + 1);
    if (name) {
        memcpy(name, base, length);
        strcpy(name + length, ending);
    }
    return name;
}
