/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "cli/progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "cli/cli.h"

static double clock_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* 7 -> "7 s", 200 -> "3 min 20 s", 4000 -> "1 h 06 min", 200000 -> "2 d 7 h" */
void ry_progress_span(char *out, size_t size, double seconds)
{
    const long long s = llround(fmin(seconds, 1e15));
    if (s < 60) {
        snprintf(out, size, "%lld s", s);
    } else if (s < 3600) {
        snprintf(out, size, "%lld min %02lld s", s / 60, s % 60);
    } else if (s < 48 * 3600) {
        snprintf(out, size, "%lld h %02lld min", s / 3600, s % 3600 / 60);
    } else {
        snprintf(out, size, "%lld d %lld h", s / 86400, s % 86400 / 3600);
    }
}

/* 15576 -> "15600", 2345678 -> "2.35 million" */
static void print_rate(char *out, size_t size, double rate)
{
    if (rate >= 1e6) {
        snprintf(out, size, "%.3g million", rate / 1e6);
    } else if (rate >= 100) {
        const double unit = pow(10, floor(log10(rate)) - 2);
        snprintf(out, size, "%.0f", round(rate / unit) * unit);
    } else {
        snprintf(out, size, "%.2g", rate);
    }
}

/* "t = 4.51 / 10.00 s", with as many digits as tell apart a thousandth of the run. */
static void print_clock(char *out, size_t size, double time, double end)
{
    const int digits = end > 0 ? 3 - (int)ceil(log10(end)) : 0;
    if (digits > 7) {
        snprintf(out, size, "t = %.3e / %.3e s", time, end);
    } else {
        snprintf(out, size, "t = %.*f / %.*f s", digits > 0 ? digits : 0, time,
                 digits > 0 ? digits : 0, end);
    }
}

static void print_state(char *out, size_t size, const ry_progress *p)
{
    char now[80], rate[32] = "", left[32] = "";
    print_clock(now, sizeof now, (double)p->step * p->dt, (double)p->last_step * p->dt);
    const char *phase = (double)p->step * p->dt < p->settle ? "  settling" : "";
    if (p->rate > 0) {
        print_rate(rate, sizeof rate, p->rate);
        ry_progress_span(left, sizeof left, (double)(p->last_step - p->step) / p->rate);
        snprintf(out, size, "%s  %s steps/s  %s left%s", now, rate, left, phase);
    } else {
        snprintf(out, size, "%s%s", now, phase);
    }
}

static int percent(const ry_progress *p)
{
    return p->last_step > 0 ? (int)(100.0 * (double)p->step / (double)p->last_step) : 0;
}

static int terminal_columns(void)
{
    struct winsize window = {0};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col : 80;
}

void ry_progress_line(const char *text)
{
    fprintf(stderr, "\r\033[K%.*s", terminal_columns() - 1, text);
    fflush(stderr);
}

static void show_on_terminal(const ry_progress *p)
{
    enum { BAR = 30 };
    char text[200], bar[BAR + 4] = "";
    const int columns = terminal_columns();
    print_state(text, sizeof text, p);
    int length = columns - 1 - 5 - 2 - (int)strlen(text) - 3;
    length = length < BAR ? length : BAR;
    if (length >= 5) {
        const int full = percent(p) * length / 100;
        bar[0] = '[';
        for (int i = 0; i < length; i++) {
            bar[i + 1] = i < full ? '#' : '-';
        }
        strcpy(bar + length + 1, "] ");
    }
    char line[300];
    snprintf(line, sizeof line, "%3d %% %s %s", percent(p), bar, text);
    ry_progress_line(line);
}

static void show_in_log(const ry_progress *p)
{
    char text[200];
    print_state(text, sizeof text, p);
    fprintf(stderr, "%3d %%  %s\n", percent(p), text);
}

ry_progress ry_progress_start(const ry_config *config, int quiet)
{
    return (ry_progress){.quiet = quiet,
                         .terminal = ry_cli_is_terminal(),
                         .dt = config->time_step,
                         .last_step = ry_config_derive(config).steps_end,
                         .shown_step = -1,
                         .settle = config->time_settle};
}

void ry_progress_update(ry_progress *p, long long step, long long last_step, double rate)
{
    const double now = clock_seconds();
    p->step = step;
    p->last_step = last_step;
    p->rate = rate;
    if (p->quiet) {
        return;
    }
    if (p->terminal) {
        if (now >= p->next_time) {
            show_on_terminal(p);
            p->next_time = now + 0.2;
        }
    } else if (now >= p->next_time || percent(p) >= 10 * p->next_tenth) {
        show_in_log(p);
        p->shown_step = p->step;
        p->next_time = now + 10.0;
        p->next_tenth = percent(p) / 10 + 1;
    }
}

void ry_progress_end(ry_progress *p, int finished)
{
    if (finished) {
        p->step = p->last_step;
    }
    if (p->quiet) {
        return;
    }
    if (p->terminal) {
        fprintf(stderr, "\r\033[K");
        fflush(stderr);
    } else if (p->step != p->shown_step && (finished || p->step > 0)) {
        show_in_log(p);
    }
}
