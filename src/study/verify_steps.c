/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Section 5.5 of the paper, Table 2: steps of the first contact of the slow bounce. It tells the two
 * constants that the paper leaves out: a of the linear spring and the coefficient of Hertz' spring. */
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "study/each.h"
#include "study/verify_ball.h"

enum { STEPS = 3, PHASES = 64, GRID = 41 };
static const double dt_of[STEPS] = {1e-3, 1e-4, 1e-5};

static const int printed[RY_VARIANTS][STEPS] = {
    [RY_V_C_TENSION] = {9, 10, 10},
    [RY_V_C] = {9, 10, 10},
    [RY_V_T] = {14, 23, 37},
    [RY_V_F] = {2, 1, 1},
    [RY_V_P_PRINTED] = {3, 3, 3},
    [RY_V_P] = {3, 3, 3},
    [RY_V_ENERGY] = {0},
};

/* The paper's step moves a grain by its new velocity, x' = x + v' dt (eq. 10), in flight too; its
 * positions are then those of a throw with g dt/2 downwards. The simulator's flight is exact, so it
 * meets the floor at the paper's phase if it begins with that speed. */
static double paper_start(double dt)
{
    return 0.5 * RY_PAPER_GRAVITY * dt;
}

/* Steps of the first contact; -1: it failed, see error. */
static int count_steps(ry_ball ball, ry_error *error)
{
    ry_bounces *const b = calloc(1, sizeof *b);
    if (b == NULL) {
        ry_no_memory(error, sizeof *b);
        return -1;
    }
    const int steps = ry_ball_follow(&ball, 1, b, error) == RY_OK ? b->bounce[0].steps : -1;
    free(b);
    return steps;
}

typedef struct table2 {
    int paper[RY_VARIANTS][STEPS];             /* entered at the paper's phase */
    int exact[RY_VARIANTS][STEPS];             /* dropped from rest */
    int least[RY_VARIANTS], most[RY_VARIANTS]; /* over all phases of entry, dt = 1e-3 s */
    int holds_c[GRID], holds_t[GRID];          /* all of Table 2 comes out, with these constants */
} table2;

/* Heights whose last step of fall differs by up to a whole step. */
static ry_status scan_phases(table2 *t, int k, ry_error *error)
{
    const double step =
        sqrt(2.0 * RY_PAPER_GRAVITY * RY_PAPER_HEIGHT / RY_PAPER_DIAMETER) * dt_of[0];
    t->least[k] = 1000000;
    for (int p = 0; p < PHASES; p++) {
        ry_ball ball = ry_ball_of(k);
        ball.height += step * p / PHASES;
        const int steps = count_steps(ball, error);
        if (steps < 0) {
            return error->status;
        }
        t->least[k] = steps < t->least[k] ? steps : t->least[k];
        t->most[k] = steps > t->most[k] ? steps : t->most[k];
    }
    return RY_OK;
}

static ry_status count_law(void *data, int k, ry_error *error)
{
    table2 *const t = data;
    for (int s = 0; s < STEPS; s++) {
        ry_ball ball = ry_ball_of(k);
        ball.dt = dt_of[s];
        t->exact[k][s] = count_steps(ball, error);
        ball.down = paper_start(ball.dt);
        t->paper[k][s] = count_steps(ball, error);
        if (t->exact[k][s] < 0 || t->paper[k][s] < 0) {
            return error->status;
        }
    }
    return scan_phases(t, k, error);
}

/* --- the constants ---------------------------------------------------------------------------- */

static double grid_a(int g)
{
    return 0.090 + 0.0005 * g;
}

static double grid_hertz(int g)
{
    return 4.0 + 0.025 * g;
}

static ry_status holds(int variant, double a, int *yes, ry_error *error)
{
    *yes = 1;
    for (int s = 0; s < STEPS && *yes; s++) {
        ry_ball ball = ry_ball_of(variant);
        ball.a = a;
        ball.dt = dt_of[s];
        ball.down = paper_start(ball.dt);
        const int steps = count_steps(ball, error);
        if (steps < 0) {
            return error->status;
        }
        *yes = steps == printed[variant][s];
    }
    return RY_OK;
}

static ry_status try_constants(void *data, int g, ry_error *error)
{
    table2 *const t = data;
    const int linear[] = {RY_V_C_TENSION, RY_V_F, RY_V_P};
    t->holds_c[g] = 1;
    for (int k = 0; k < 3 && t->holds_c[g]; k++) {
        RY_TRY(holds(linear[k], grid_a(g), &t->holds_c[g], error));
    }
    return holds(RY_V_T, grid_hertz(g), &t->holds_t[g], error);
}

/* The grid's first and last value with which it holds; NAN if none. */
static void find_range(const int *holds_at, double (*value)(int), double range[2])
{
    range[0] = range[1] = NAN;
    for (int g = 0; g < GRID; g++) {
        if (holds_at[g]) {
            range[0] = isnan(range[0]) ? value(g) : range[0];
            range[1] = value(g);
        }
    }
}

/* --- what is said ----------------------------------------------------------------------------- */

static void say_table(const ry_verify_run *run, const table2 *t)
{
    ry_verify_say(run, "  %-20s  %-16s %-16s %-16s %s\n", "dt 1e-3 / 1e-4 / 1e-5", "printed",
                  "as the paper", "exact flight", "any phase, 1e-3");
    for (int k = 0; k < RY_VARIANTS; k++) {
        char text[3][40] = {"-"};
        if (printed[k][0] > 0) {
            snprintf(text[0], sizeof text[0], "%d / %d / %d", printed[k][0], printed[k][1],
                     printed[k][2]);
        }
        snprintf(text[1], sizeof text[1], "%d / %d / %d", t->paper[k][0], t->paper[k][1],
                 t->paper[k][2]);
        snprintf(text[2], sizeof text[2], "%d / %d / %d", t->exact[k][0], t->exact[k][1],
                 t->exact[k][2]);
        ry_verify_say(run, "  %s %-18s   %-16s %-16s %-16s %d to %d\n", ry_variants[k].letter,
                      ry_variants[k].name, text[0], text[1], text[2], t->least[k], t->most[k]);
    }
}

static void write_table(const ry_verify_run *run, const table2 *t)
{
    ry_table_file_numbers(run->file, ry_verify_at(run, "", "dt").text, "s", "time steps", STEPS,
                          dt_of);
    for (int k = 0; k < RY_VARIANTS; k++) {
        double paper[STEPS], exact[STEPS], want[STEPS];
        for (int s = 0; s < STEPS; s++) {
            paper[s] = t->paper[k][s];
            exact[s] = t->exact[k][s];
            want[s] = printed[k][s] > 0 ? (double)printed[k][s] : (double)NAN;
        }
        const char *const law = ry_variants[k].name;
        ry_table_file_numbers(run->file, ry_verify_at(run, law, "steps").text, "1",
                              "steps of the first contact, entered at the paper's phase", STEPS,
                              paper);
        ry_table_file_numbers(run->file, ry_verify_at(run, law, "steps_exact_flight").text, "1",
                              "the same, dropped from rest", STEPS, exact);
        ry_table_file_numbers(run->file, ry_verify_at(run, law, "printed").text, "1", "Table 2",
                              STEPS, want);
        ry_table_file_set_number(run->file, ry_verify_at(run, law, "").text, "least", t->least[k]);
        ry_table_file_set_number(run->file, ry_verify_at(run, law, "").text, "most", t->most[k]);
    }
}

static void claim_table(ry_verify_run *run, const table2 *t)
{
    for (int k = 0; k < RY_VARIANTS; k++) {
        int wrong = 0;
        for (int s = 0; s < STEPS; s++) {
            wrong += t->paper[k][s] != printed[k][s];
        }
        if (printed[k][0] > 0) {
            ry_verify_claim(run, (ry_claim){.value = wrong, .tolerance = 0.0},
                            "%s: entries of Table 2 that differ", ry_variants[k].name);
        }
    }
    double a[2], hertz[2];
    find_range(t->holds_c, grid_a, a);
    find_range(t->holds_t, grid_hertz, hertz);
    ry_verify_claim(run, (ry_claim){a[0], NAN, 0.0, 0.097, RY_FOUND_STEP_RATIO, NULL},
                    "C, F, P: Table 2 holds from this a = k dt^2/m_r ...");
    ry_verify_claim(run, (ry_claim){a[1], NAN, 0.0, RY_FOUND_STEP_RATIO, 0.109, NULL},
                    "... to this a");
    ry_verify_claim(run, (ry_claim){hertz[0], NAN, 0.0, 4.4, RY_FOUND_HERTZ, NULL},
                    "T: Table 2 holds from this Hertz coefficient ...");
    ry_verify_claim(run, (ry_claim){hertz[1], NAN, 0.0, RY_FOUND_HERTZ, 4.8, NULL},
                    "... to this one");
    ry_table_file *const f = run->file;
    const ry_verify_path group = ry_verify_at(run, "constants", "");
    ry_table_file_set_number(f, group.text, "a_from", a[0]);
    ry_table_file_set_number(f, group.text, "a_to", a[1]);
    ry_table_file_set_number(f, group.text, "hertz_from", hertz[0]);
    ry_table_file_set_number(f, group.text, "hertz_to", hertz[1]);
}

ry_status ry_verify_steps(ry_verify_run *run, ry_error *error)
{
    table2 *const t = calloc(1, sizeof *t);
    if (t == NULL) {
        return ry_no_memory(error, sizeof *t);
    }
    const int threads = run->options->threads;
    ry_status status = ry_each(RY_VARIANTS, threads, count_law, t, error);
    if (status == RY_OK) {
        status = ry_each(GRID, threads, try_constants, t, error);
    }
    if (status == RY_OK) {
        say_table(run, t);
        write_table(run, t);
        claim_table(run, t);
    }
    free(t);
    return status;
}
