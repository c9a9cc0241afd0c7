/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "cli/signals.h"

#include <signal.h>
#include <stddef.h>
#include <unistd.h>

#include "ryusa/status.h"

static volatile sig_atomic_t stop_asked;

/* Schedulers send SIGTERM more than once, to a job's processes and through its script. */
static void ask_to_stop(int signal_number)
{
    if (stop_asked && signal_number == SIGINT) {
        _exit(RY_STOPPED);
    }
    stop_asked = 1;
}

int ry_cli_stop_asked(void)
{
    return stop_asked;
}

/* A signal that the caller has ignored (nohup, a job in the background) stays ignored. */
void ry_cli_catch_signals(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        struct sigaction old, action = {.sa_handler = ask_to_stop, .sa_flags = SA_RESTART};
        sigemptyset(&action.sa_mask);
        if (sigaction(numbers[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN) {
            sigaction(numbers[i], &action, NULL);
        }
    }
}
