/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa COMMAND ...: finds the command, and sees to it that what was printed arrived. */
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"

typedef struct command {
    const char *name;
    int (*run)(int argc, char **argv);
} command;

static const command commands[] = {
#define RY_COMMAND(name, arguments, text) {#name, ry_cli_##name},
#include "cli/commands.def"
#undef RY_COMMAND
};
enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

static const char page[] =
    "Bed-load transport: grains and fluid by the distinct element method.\v"
    "Commands:\n"
#define RY_COMMAND(name, arguments, text) "  " #name " " arguments "\n      " text "\n"
#include "cli/commands.def"
#undef RY_COMMAND
    "\n`ryusa COMMAND --help' tells the options of one.\n\n"
    "Exit status: 0 done; 2 the command line or the scene is wrong; 3 the run became unphysical; "
    "4 a file can't be read or written; 130 stopped by a signal, everything is saved.";

/* Options before the command are answered there and then; what follows it is the command's. */
static error_t parse_main(int key, char *text, struct argp_state *state)
{
    switch (key) {
    case ARGP_KEY_ARG:
        *(const char **)state->input = text;
        state->next = state->argc;
        return 0;
    case ARGP_KEY_NO_ARGS: return ry_cli_misuse("which command?");
    default: return ARGP_ERR_UNKNOWN;
    }
}

static int run_command(int argc, char **argv)
{
    static const struct argp argp = {.parser = parse_main, .args_doc = "COMMAND ...", .doc = page};
    const char *name = NULL;
    ry_cli_program = argc > 0 ? argv[0] : ry_cli_program; /* ry_cli_parse changes it */
    const int status = ry_cli_parse("ryusa", &argp, ARGP_IN_ORDER, argc, argv, &name);
    if (status != RY_OK) {
        return status;
    }
    for (int i = 0; i < N_COMMANDS; i++) {
        if (strcmp(name, commands[i].name) == 0) {
            return commands[i].run(argc - 1, argv + 1);
        }
    }
    fprintf(stderr, "ryusa: there is no command '%s'; there are:", name);
    for (int i = 0; i < N_COMMANDS; i++) {
        fprintf(stderr, "%s %s", i ? "," : "", commands[i].name);
    }
    fprintf(stderr, "\nTry `ryusa --help'.\n");
    return RY_BAD_INPUT;
}

/* The reader of our output has closed it: no failure of ours. */
static int is_reader_gone(void)
{
    struct pollfd out = {.fd = STDOUT_FILENO, .events = POLLOUT};
    return poll(&out, 1, 0) == 1 && (out.revents & POLLERR);
}

/* Also where argp ends the program, after --help. */
static int outcome = RY_OK;

static void see_output_arrive(void)
{
    if ((fflush(stdout) != 0 || ferror(stdout)) && outcome == RY_OK && !is_reader_gone()) {
        fprintf(stderr, "ryusa: the output can't be written\n");
        _exit(RY_BAD_FILE);
    }
}

/* OpenMP's threads spin while they wait for the next loop, for so long by default that on a busy machine a
 * run becomes fifty times slower (measured, 220 grains: 60 000 steps per second with one thread, 1 000
 * with two). They should wait for some microseconds, then sleep, unless the user has said how.
 * Returns whether it has changed anything. */
static int wait_briefly(void)
{
    return getenv("OMP_WAIT_POLICY") == NULL && getenv("GOMP_SPINCOUNT") == NULL &&
           setenv("GOMP_SPINCOUNT", "1000", 0) == 0;
}

/* The library reads its settings before main. One that is part of the program does so after this. */
#ifdef RY_STATIC_OPENMP
__attribute__((constructor(101))) static void set_up_waiting(void)
{
    (void)wait_briefly();
}
#endif

int main(int argc, char **argv)
{
#ifndef RY_STATIC_OPENMP
    if (wait_briefly()) {
        execv("/proc/self/exe", argv); /* once more, with the settings; on failure go on as we are */
    }
#endif
    signal(SIGCHLD, SIG_DFL); /* who ignores it, which is inherited, isn't told how a child has ended */
    /* A result file must never take the number of a standard stream that came closed. */
    for (int fd = open("/dev/null", O_RDWR); fd >= 0; fd = open("/dev/null", O_RDWR)) {
        if (fd > STDERR_FILENO) {
            close(fd);
            break;
        }
    }
    /* A reader of our output that has seen enough must not end a run; nor a file that has become as long as `ulimit`
     * allows, which is told like a full disk. */
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    atexit(see_output_arrive);
    outcome = run_command(argc, argv);
    if (outcome == RY_BAD_FILE) { /* where HDF5 had no memory to close a file, it breaks down at exit */
        see_output_arrive();
        _exit(outcome);
    }
    return outcome;
}
