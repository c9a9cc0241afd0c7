/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The problems of `ryusa bench accuracy`: each can be run with any law at any of its time steps, and
 * gives values that are held against exact ones or against those of its own smallest step. */
#ifndef RY_STUDY_BENCH_PROBLEMS_H
#define RY_STUDY_BENCH_PROBLEMS_H

#include "study/bench_private.h"

enum { RY_PROBLEM_VALUES = 32, RY_PROBLEM_STEPS = 24 };

/* One law at one time step. */
typedef struct ry_attempt {
    ry_law law;
    double dt; /* [s] */
    int quick;
    long long steps; /* that the whole problem takes */
    double seconds;  /* wall time of the step loop */
    int n;           /* values */
    double value[RY_PROBLEM_VALUES];
    double bar;   /* standard error of the values; 0: they are not statistical */
    double error; /* worst of |value - reference|/scale */
    double error_bar;
    int has_run; /* 0: refused, `message` tells why */
    char message[200];
} ry_attempt;

typedef struct ry_problem {
    const char *name, *text, *error_text;
    double dt_max, dt_ratio; /* time steps are dt_max dt_ratio^-k */
    int n, n_quick;          /* how many */
    int has_reference; /* one more, dt_reference times smaller than the last, is the reference */
    double dt_reference;
    ry_status (*run)(ry_attempt *attempt, ry_error *error);
    double (*exact)(int k); /* of value k, where has_reference is 0 */
    double scale;           /* of the error */
} ry_problem;

enum { RY_PROBLEMS = 6 };
extern const ry_problem ry_problems[RY_PROBLEMS];

/* A config with what all problems share: law, its mapping, time step, nothing written. */
ry_config ry_problem_config(const ry_attempt *attempt, int has_grains);

/* Resolves `config` and runs `steps` steps on one thread, timed; the best of several for short runs.
 * *sim is NULL where the scene was refused or became unphysical (attempt->message). */
ry_status ry_problem_run(ry_attempt *attempt, ry_config *config, long long steps, ry_sim **sim,
                         ry_error *error);

ry_status ry_problem_binary(ry_attempt *attempt, ry_error *error);
double ry_problem_binary_exact(int k);
ry_status ry_problem_sliding(ry_attempt *attempt, ry_error *error);
double ry_problem_sliding_exact(int k);
ry_status ry_problem_sticking(ry_attempt *attempt, ry_error *error);
ry_status ry_problem_three(ry_attempt *attempt, ry_error *error);
double ry_problem_three_exact(int k);
ry_status ry_problem_settle(ry_attempt *attempt, ry_error *error);
ry_status ry_problem_flux(ry_attempt *attempt, ry_error *error);

#endif
