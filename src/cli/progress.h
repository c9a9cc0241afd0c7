/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * How far a run is, on stderr: one line that is rewritten on a terminal, plain lines now and then in a
 * log, nothing if quiet. */
#ifndef RY_CLI_PROGRESS_H
#define RY_CLI_PROGRESS_H

#include <stddef.h>

#include "ryusa/ryusa.h"

typedef struct ry_progress {
    int quiet, terminal;
    double dt, settle;         /* of the scene [s] */
    double next_time;          /* of the clock, when to show again [s] */
    long long next_tenth;      /* of the run, when a log gets its next line */
    long long shown_step;      /* of the last line in a log, -1: none */
    long long step, last_step; /* as last told */
    double rate;               /* steps per second */
} ry_progress;

ry_progress ry_progress_start(const ry_config *config, int quiet);
void ry_progress_update(ry_progress *progress, long long step, long long last_step, double rate);

/* Rewrites the terminal's line, cut to its width. */
void ry_progress_line(const char *text);

/* Clears the terminal's line; a log gets its last line, of how far it came: all the way if `finished`. */
void ry_progress_end(ry_progress *progress, int finished);

/* 7 -> "7 s", 200 -> "3 min 20 s", 4000 -> "1 h 06 min". */
void ry_progress_span(char *out, size_t size, double seconds);

#endif
