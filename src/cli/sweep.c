/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa sweep: many cases of one scene, on all cores, or a share of them on one node of many, or all of
 * them by the processes that mpirun has started. */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/cli.h"
#include "cli/mpi.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "study/sweep.h"

enum { MAX_CORES = 1024, MAX_SHARDS = 100000 };

typedef struct arguments {
    const char *sweep, *output;
    char *default_output;
    ry_overrides overrides;
    int cores, resume, force, quiet, merge, shard, shards;
} arguments;

/* --- The command line ------------------------------------------------------------------------- */

static error_t parse_shard(const char *text, arguments *a)
{
    char *end;
    const long shard = strtol(text, &end, 10);
    const int slash = *end == '/' && end > text;
    const char *const second = end + 1;
    const long shards = slash ? strtol(second, &end, 10) : 0;
    if (!slash || end == second || *end || shard < 1 || shards < 1 || shard > shards ||
        shards > MAX_SHARDS) {
        return ry_cli_misuse("--shard %s: give I/N, the I-th of N shares, 1 to N (at most %d)",
                             text, MAX_SHARDS);
    }
    a->shard = (int)shard;
    a->shards = (int)shards;
    return 0;
}

static int number_from(const char *name, long *value)
{
    const char *const text = getenv(name);
    char *end = NULL;
    *value = text ? strtol(text, &end, 10) : 0;
    return text && end > text && !*end;
}

/* A task of a Slurm array is a share of the cases: #SBATCH --array=1-8 needs nothing else. */
static error_t take_slurm_shard(arguments *a)
{
    long id, count, first = 0, stride = 1;
    if (a->shards || a->merge || !number_from("SLURM_ARRAY_TASK_ID", &id)) {
        return 0;
    }
    if (!number_from("SLURM_ARRAY_TASK_COUNT", &count)) {
        return ry_cli_misuse(
            "SLURM_ARRAY_TASK_ID is set, but not SLURM_ARRAY_TASK_COUNT; give --shard I/N");
    }
    number_from("SLURM_ARRAY_TASK_MIN", &first);
    if (!number_from("SLURM_ARRAY_TASK_STEP", &stride) || stride < 1) {
        stride = 1;
    }
    char text[60];
    snprintf(text, sizeof text, "%ld/%ld", (id - first) / stride + 1, count);
    return parse_shard(text, a);
}

static error_t finish_arguments(arguments *a)
{
    if (!a->sweep || !*a->sweep) {
        return ry_cli_misuse("which sweep file?");
    }
    if (!a->output) {
        a->default_output = ry_cli_name_output(a->sweep, ".h5");
        a->output = a->default_output;
    }
    if (!a->output || !*a->output) {
        return ry_cli_misuse("-o: the result file needs a name");
    }
    if (strcmp(a->output, a->sweep) == 0) {
        return ry_cli_misuse("-o %s: the result would replace the sweep", a->output);
    }
    if (a->resume && a->force) {
        return ry_cli_misuse("--resume and --force: go on, or begin anew?");
    }
    return take_slurm_shard(a);
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o': a->output = text; return 0;
    case 's': return ry_cli_override(state, &a->overrides, text);
    case 'j': return ry_cli_count("-j", "the number of cores", text, 1, MAX_CORES, &a->cores);
    case 'r': a->resume = 1; return 0;
    case 'f': a->force = 1; return 0;
    case 'q': a->quiet = 1; return 0;
    case 'm': a->merge = 1; return 0;
    case 'S': return parse_shard(text, a);
    case ARGP_KEY_ARG: return ry_cli_single(&a->sweep, text);
    case ARGP_KEY_END: return finish_arguments(a);
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"output", 'o', "OUT.h5", 0,
     "table of the cases (the name of the sweep with .h5, in the current folder); "
     "their results go to OUT.d/",
     0},
    {"set", 's', "KEY=VALUE", 0, "replace a value of the scene in every case; may be repeated", 0},
    {"cores", 'j', "N", 0,
     "cores to use (all): a case on each, or several for each if there are few cases", 0},
    {"resume", 'r', NULL, 0, "go on with what is missing", 0},
    {"force", 'f', NULL, 0, "begin anew: removes the cases that are there", 0},
    {"quiet", 'q', NULL, 0, "print nothing but errors", 0},
    {"shard", 'S', "I/N", 0,
     "run the I-th of N shares of the cases; a task of a Slurm array does so by itself", 0},
    {"merge", 'm', NULL, 0, "run nothing: make OUT.h5 of the cases that are there", 0},
    {0},
};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "SWEEP.yaml",
    .doc =
        "Runs a scene many times with some of its keys varied (docs/sweep.md).\v"
        "A case that fails is reported and does not stop the others; the exit status is then 3. Ctrl-C "
        "saves and stops; --resume goes on, also after a kill. " RY_CLI_MPI_ABOUT,
};

/* --- Progress --------------------------------------------------------------------------------- */

typedef struct display {
    int quiet, terminal;
    double next_share; /* of the work, when a log gets its next line */
} display;

static void describe(char *out, size_t size, const ry_sweep_progress *p)
{
    char left[40] = "", failed[40] = "";
    if (p->checked) {
        snprintf(out, size, "checked %d of %d cases", p->checked, p->cases);
        return;
    }
    if (isfinite(p->seconds_left)) {
        ry_progress_span(left, sizeof left, p->seconds_left);
    }
    if (p->failed > 0) {
        snprintf(failed, sizeof failed, "  %d failed", p->failed);
    }
    snprintf(out, size, "%3d %%  %d of %d cases  %d running%s%s%s%s", (int)(100.0 * p->share),
             p->ended, p->cases, p->running, failed, left[0] ? "  " : "", left,
             left[0] ? " left" : "");
}

static int on_progress(void *data, const ry_sweep_progress *p)
{
    display *const d = data;
    char text[200];
    if (!d->quiet && p->news) {
        fprintf(stderr, "%s%s\n", d->terminal ? "\r\033[K" : "", p->news);
    } else if (!d->quiet && (d->terminal || (!p->checked && p->share >= d->next_share))) {
        describe(text, sizeof text, p);
        if (d->terminal) {
            ry_progress_line(text);
        } else {
            fprintf(stderr, "%s\n", text);
        }
        d->next_share = floor(10.0 * p->share + 1.0) / 10.0;
    }
    return ry_cli_stop_asked();
}

/* --- What is said at the end ------------------------------------------------------------------ */

static void print_summary(const arguments *a, const ry_sweep_result *r)
{
    char span[40];
    ry_progress_span(span, sizeof span, r->seconds);
    printf("cases   %d of %d done", r->done, r->cases);
    if (r->failed) {
        printf(", %d failed", r->failed);
    }
    if (r->missing) {
        printf(", %d not run yet", r->missing);
    }
    printf("; %s\n", span);
    if (r->table) {
        printf("result  %s\n        python3 postprocess/sweep.py %s draws it\n", a->output,
               a->output);
    } else if (r->missing) {
        printf("result  when all shares are done; `%s sweep --merge' makes it of what is there\n", ry_cli_program);
    }
}

static int run(const arguments *a, const ry_farm *farm, int *gone)
{
    const int is_silent = farm && farm->rank > 0; /* process 0 speaks for all */
    display d = {.quiet = a->quiet || is_silent,
                 .terminal = ry_cli_is_terminal()};
    ry_error error = {0};
    ry_sweep_result result = {0};
    const ry_sweep_options wish = {.sweep = a->sweep,
                                   .output = a->output,
                                   .overrides = a->overrides.text,
                                   .n_overrides = a->overrides.n,
                                   .cores = a->cores,
                                   .resume = a->resume,
                                   .force = a->force,
                                   .merge = a->merge,
                                   .shard = a->shard,
                                   .shards = a->shards,
                                   .farm = farm,
                                   .progress = on_progress,
                                   .data = &d};
    ry_cli_catch_signals();
    const ry_status status = ry_sweep(&wish, &result, &error);
    *gone = result.gone;
    if (d.terminal && !d.quiet) {
        fputs("\r\033[K", stderr);
    }
    if (is_silent) {
        if (status == RY_STOPPED) {
            fprintf(
                stderr,
                "ryusa: process %d of %d: the one that hands out the cases is gone; saved, --resume goes on\n",
                farm->rank + 1, farm->size);
        }
        return status;
    }
    if (status == RY_STOPPED && !result.cases) {
        fprintf(stderr, "ryusa: stopped while the cases were checked; none was begun\n");
        return RY_STOPPED;
    }
    if (status == RY_STOPPED) {
        fprintf(stderr, "ryusa: stopped with %d of %d cases done, saved; --resume goes on\n",
                result.done, result.cases);
        return RY_STOPPED;
    }
    if (!a->quiet && (status == RY_OK || result.table)) {
        print_summary(a, &result);
        fflush(stdout);
    }
    if (status != RY_OK) {
        error.status = status;
        return ry_cli_report(&error);
    }
    return RY_OK;
}

/* 1: the command line asks for a sweep. Tried in a child, where what argp says and does goes nowhere. */
static int is_good(int argc, char **argv)
{
    enum { GOOD = 100 };
    int how = 0;
    const pid_t pid = fork();
    if (pid == 0) {
        arguments a = {0};
        const int nowhere = open("/dev/null", O_WRONLY);
        dup2(nowhere, STDOUT_FILENO);
        dup2(nowhere, STDERR_FILENO);
        _exit(ry_cli_parse("ryusa sweep", &argp, 0, argc, argv, &a) == RY_OK ? GOOD : RY_BAD_INPUT);
    }
    return pid > 0 && waitpid(pid, &how, 0) == pid && WIFEXITED(how) && WEXITSTATUS(how) == GOOD;
}

/* Of processes that were started together the first says what is wrong, and its status is that of all:
 * mpirun ends the others as soon as one has failed, maybe before the first has spoken. */
int ry_cli_sweep(int argc, char **argv)
{
    const int is_silent = ry_cli_mpi_rank() > 0;
    arguments a = {0};
    const ry_farm *farm = NULL;
    int gone = 0;
    if (is_silent && !is_good(argc, argv)) {
        return RY_OK;
    }
    int status = ry_cli_parse("ryusa sweep", &argp, 0, argc, argv, &a);
    if (status == RY_OK) {
        status = ry_cli_mpi_begin(a.shard, &farm);
        if (status == RY_OK) {
            status = run(&a, farm, &gone);
        } else if (is_silent) {
            status = RY_OK;
        }
    }
    if (farm) {
        fflush(stdout);
        ry_cli_mpi_end(gone);
    }
    free(a.default_output);
    free(a.overrides.text);
    return status;
}
