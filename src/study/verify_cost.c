/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Section 5.4 of the paper, Table 1: 16 spheres dropped on a floor, dt = 1e-5 s, 5e6 steps: how often
 * the contact force is evaluated, and how long one evaluation takes. The spheres never touch each
 * other, so the paper's square of 4 x 4 is a row here. After about 4 s all lie still and every step is
 * like the one before: the last steps simulated stand for the rest. */
#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "study/verify_ball.h"
#include "study/verify_law_time.h"

enum { SPHERES = 16, LONG_RUN = 1000000, QUICK_RUN = 500000, TAIL = 50000, ROUNDS = 200 };
static const double paper_steps = 5e6;

static const struct {
    double evaluations, each; /* [1], [s] */
} printed[RY_VARIANTS] = {
    [RY_V_C_TENSION] = {1.87e7, 1.88e-6},
    [RY_V_T] = {1.26e7, 1.91e-6},
    [RY_V_F] = {5.62e6, 1.95e-6},
    [RY_V_P_PRINTED] = {1.07e7, 1.96e-6},
};

typedef struct cost {
    double wall;            /* of a step of all spheres [s] */
    double bouncing, all;   /* evaluations of the first 3e5 steps; of 5e6 */
    double together, alone; /* of an evaluation [s] */
} cost;

/* Evaluations of one step: the spheres that touch the floor when it begins. */
static int touching(const ry_sim *sim)
{
    const ry_view view = ry_sim_view(sim);
    int n = 0;
    for (int k = 0; k < view.n; k++) {
        n += view.z[k] < view.radius[k];
    }
    return n;
}

static ry_status count(ry_sim *sim, int steps, cost *c, ry_error *error)
{
    const int bouncing = 300000;
    double all = 0.0, tail = 0.0;
    const double start = ry_clock();
    for (int k = 0; k < steps; k++) {
        const int now = touching(sim);
        all += now;
        c->bouncing += k < bouncing ? now : 0;
        tail += k >= steps - TAIL ? now : 0;
        RY_TRY(ry_sim_step(sim, 1, error));
    }
    c->wall = (ry_clock() - start) / steps;
    c->all = all + tail / TAIL * (paper_steps - steps);
    return RY_OK;
}

/* All laws with the same spring constant: how long an evaluation takes does not depend on it. */
static ry_status measure(int k, int steps, cost *c, ry_error *error)
{
    ry_config config;
    ry_ball ball = ry_ball_of(k);
    ball.a = RY_FOUND_STEP_RATIO;
    ball.dt = 1e-5;
    ball.n = SPHERES;
    *c = (cost){.together = ry_verify_law_time((int)ry_variants[k].law, ROUNDS, 0),
                .alone = ry_verify_law_time((int)ry_variants[k].law, ROUNDS, 1)};
    RY_TRY(ry_ball_scene(&ball, &config, error));
    ry_sim *const sim = ry_sim_create(&config, 1, error);
    const ry_status status = sim == NULL ? error->status : count(sim, steps, c, error);
    ry_sim_free(sim);
    ry_config_free(&config);
    return status;
}

static void say_costs(const ry_verify_run *run, const cost *c)
{
    ry_verify_say(run, "  %-20s %9s %19s %20s %22s\n", "", "of a step", "evaluations, 5e6",
                  "ns per evaluation", "relative to C");
    ry_verify_say(run, "  %-20s %9s %10s %8s %11s %8s %8s %6s %6s\n", "law", "16 balls", "here",
                  "paper", "one by one", "together", "here", "tog.", "paper");
    for (int k = 0; k < RY_VARIANTS; k++) {
        char paper[2][20] = {"-", "-"};
        if (printed[k].each > 0.0) {
            snprintf(paper[0], sizeof paper[0], "%.3g", printed[k].evaluations);
            snprintf(paper[1], sizeof paper[1], "%.2f",
                     printed[k].each / printed[RY_V_C_TENSION].each);
        }
        ry_verify_say(run, "  %s %-18s %6.0f ns %10.3g %8s %11.2f %8.2f %8.2f %6.2f %6s\n",
                      ry_variants[k].letter, ry_variants[k].name, 1e9 * c[k].wall, c[k].all,
                      paper[0], 1e9 * c[k].alone, 1e9 * c[k].together,
                      c[k].alone / c[RY_V_C_TENSION].alone,
                      c[k].together / c[RY_V_C_TENSION].together, paper[1]);
    }
}

static void write_costs(const ry_verify_run *run, const cost *c)
{
    const char *names[RY_VARIANTS];
    double column[7][RY_VARIANTS];
    for (int k = 0; k < RY_VARIANTS; k++) {
        const double values[7] = {c[k].wall,
                                  c[k].all,
                                  c[k].bouncing,
                                  c[k].alone,
                                  c[k].together,
                                  printed[k].each > 0.0 ? printed[k].evaluations : NAN,
                                  printed[k].each > 0.0 ? printed[k].each : NAN};
        names[k] = ry_variants[k].name;
        for (int n = 0; n < 7; n++) {
            column[n][k] = values[n];
        }
    }
    static const char *const name[7][3] = {
        {"step", "s", "wall time of a step of 16 spheres, with a look at all of them"},
        {"evaluations", "1", "of the contact force, in 5e6 steps"},
        {"evaluations_bouncing", "1", "of them, in the first 3e5 steps"},
        {"evaluation", "s", "time of one evaluation, one after another"},
        {"evaluation_together", "s", "the same, many side by side as the simulator does it"},
        {"printed_evaluations", "1", "Table 1"},
        {"printed_evaluation", "s", "Table 1, on the authors' machine"}};
    ry_table_file_texts(run->file, ry_verify_at(run, "", "law").text, "law", RY_VARIANTS, names);
    for (int n = 0; n < 7; n++) {
        ry_table_file_numbers(run->file, ry_verify_at(run, "", name[n][0]).text, name[n][1],
                              name[n][2], RY_VARIANTS, column[n]);
    }
}

static void claim_costs(ry_verify_run *run, const cost *c)
{
    ry_verify_claim(
        run, (ry_claim){c[RY_V_P].bouncing / c[RY_V_F].bouncing, NAN, 0.0, 1.0, INFINITY, NULL},
        "while they bounce: evaluations of P over F (paper: 1.9 in all)");
    ry_verify_claim(
        run,
        (ry_claim){c[RY_V_C_TENSION].bouncing / c[RY_V_P].bouncing, NAN, 0.0, 1.0, INFINITY, NULL},
        "while they bounce: evaluations of C over P (paper: 1.7 in all)");
    ry_verify_claim(
        run,
        (ry_claim){
            c[RY_V_P_PRINTED].all, printed[RY_V_P_PRINTED].evaluations, 1e5, 2e7, 8e7,
            "After 4 of 50 s all spheres lie on the floor. Here one that lies there touches it "
            "in every step. In the paper its force is evaluated in 1 of 7 steps (C: 1 of 4, "
            "F: 1 of 13), so its spheres go on hopping; how gravity enters its steps is not "
            "printed."},
        "P as printed: evaluations in 5e6 steps");
    ry_verify_claim(
        run,
        (ry_claim){
            c[RY_V_P_PRINTED].alone / c[RY_V_C_TENSION].alone,
            printed[RY_V_P_PRINTED].each / printed[RY_V_C_TENSION].each, 0.1, 0.2, 100.0,
            "Most of the paper's 1.9e-6 s per evaluation is likely the call and two readings of a "
            "clock, which hide the square roots of P. Without them they show."},
        "P as printed: time of an evaluation over that of C");
}

ry_status ry_verify_cost(ry_verify_run *run, ry_error *error)
{
    cost c[RY_VARIANTS];
    for (int k = 0; k < RY_VARIANTS; k++) { /* one after the other: it is time that is measured */
        RY_TRY(measure(k, run->options->quick ? QUICK_RUN : LONG_RUN, &c[k], error));
    }
    say_costs(run, c);
    write_costs(run, c);
    claim_costs(run, c);
    return RY_OK;
}
