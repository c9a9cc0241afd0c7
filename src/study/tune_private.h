/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the parts of ryusa tune share. A piece is one simulation; it depends on the words that
 * describe it alone, so the pieces may be run in any order, on any number of threads, and be kept. */
#ifndef RY_STUDY_TUNE_PRIVATE_H
#define RY_STUDY_TUNE_PRIVATE_H

#include "analysis/replicas.h"
#include "analysis/response.h"
#include "analysis/target.h"
#include "base/text.h"
#include "study/tune.h"

enum {
    RY_TUNE_CANDIDATES = 12, /* of alpha_m or alpha_cn, at most */
    RY_TUNE_BETAS = 12, /* the grid and what is added around its best */
    RY_TUNE_SETS = 400, /* of constants whose flux is found, at most */
    RY_TUNE_THETAS = 8,
    RY_TUNE_SEEDS = 6,
    RY_TUNE_FINE = 121 /* values of beta at which the misfit is tabulated */
};

/* Theirs. */
#define RY_TUNE_HIS_ALPHA_M 20.0
#define RY_TUNE_HIS_ALPHA_CN 1.3
#define RY_TUNE_HIS_BETA 15.8
/* The first words of a tuned scene. */
#define RY_TUNE_SCENE_HEAD "# Tuned against "
/* Within this part of the target it counts as met. */
#define RY_TUNE_GOAL 0.25
/* The start from motion: 0.25 s at a higher stress (docs/physics.md); its samples are no flux [s]. */
#define RY_TUNE_BOOST 0.25
/* Ours for alpha_m: overlap that the softest spring may have in the settled bed, in d. */
#define RY_TUNE_OVERLAP 0.01

/* --- pieces --- */

typedef enum { RY_TUNE_SETTLE, RY_TUNE_FLUX } ry_tune_kind;

/* Numbers that a piece leaves, in this order; a settling piece has its curve y_gc/d behind them. */
enum {
    RY_TUNE_COARSE,  /* settling time to 1e-3 d [s] */
    RY_TUNE_FINE_,   /* to 1e-4 d [s] */
    RY_TUNE_HEIGHT,  /* settled height [d] */
    RY_TUNE_DEEPEST, /* largest overlap at the end [d] */
    RY_TUNE_UNREST,  /* 1: still moving by more than 1e-4 d at the end */
    RY_TUNE_PERIOD,  /* of the bed's ringing, from the spectrum of y_gc [s]; NAN: it doesn't ring */
    RY_TUNE_RINGING, /* its damping ratio; NAN: unknown */
    RY_TUNE_CURVE
};
enum { RY_TUNE_Q, RY_TUNE_Q_ERROR, RY_TUNE_TAU, RY_TUNE_END, RY_TUNE_FLUX_VALUES };

typedef struct ry_tune_piece {
    ry_tune_kind kind;
    char words[500]; /* what it is; its name in the journal */
    ry_config config;
    double goal; /* of a flux: a standard error below this part of the target is enough */
    double target;
    int done;
    ry_status status; /* RY_OK, RY_BAD_INPUT: refused, RY_UNPHYSICAL */
    char why[300];
    int n;
    double *value; /* owned */
} ry_tune_piece;

/* Why the first of n pieces failed that did; "": none did. */
const char *ry_tune_reason(const ry_tune_piece *piece, int n);

/* Runs one piece; RY_STOPPED if asked to, RY_OK also where the piece itself failed. */
typedef int ry_tune_stop(void *data);
ry_status ry_tune_piece_run(ry_tune_piece *piece, ry_tune_stop *stop, void *data, ry_error *error);
void ry_tune_piece_clear(ry_tune_piece *piece);

/* Steps between the points of a curve y_gc(t). */
enum { RY_TUNE_CURVE_STEPS = 10 };

/* --- the journal: finished pieces, a line each, beside OUT.h5 --- */

typedef struct ry_tune_journal ry_tune_journal;
/* `mark` tells the scene and the target: a journal with another mark is refused. */
ry_status ry_tune_journal_open(ry_tune_journal **journal, const char *path, const char *mark,
                               int resume, int force, ry_error *error);
/* 1 and the piece filled if it is in there. */
int ry_tune_journal_find(const ry_tune_journal *journal, ry_tune_piece *piece);
ry_status ry_tune_journal_add(ry_tune_journal *journal, const ry_tune_piece *piece,
                              ry_error *error);
/* remove: it has served. */
void ry_tune_journal_close(ry_tune_journal *journal, int remove);

/* --- settling --- */

/* One candidate of alpha_m or alpha_cn. All candidates have the same seeds. */
typedef struct ry_tune_candidate {
    double value;
    const ry_tune_piece *piece;  /* one for each seed */
    int good;                    /* 0: refused or unphysical, see the first piece that tells why */
    double time[2], error[2];    /* settling time to 1e-3 d and 1e-4 d, mean over seeds [s] */
    double height, height_error; /* [d] */
    double deepest, deepest_error; /* [d] */
    double period, ringing; /* medians over seeds [s], [1]; NAN where half of them don't ring */
    int as_soon;            /* settles as soon as the soonest one, within the errors */
    int unrest;             /* seeds that were still moving */
} ry_tune_candidate;

typedef struct ry_tune_settling {
    const char *key; /* "alpha_m" */
    int n, seeds;
    ry_tune_candidate candidate[RY_TUNE_CANDIDATES];
    int theirs, ours;               /* chosen candidates */
    double theirs_low, theirs_high; /* 95 % of the resampled optima */
    double ours_low, ours_high;
    int clear; /* settling time singles one out */
} ry_tune_settling;

/* Fills in the means and chooses; RY_UNPHYSICAL if no candidate is good. */
ry_status ry_tune_choose(ry_tune_settling *settling, ry_error *error);

/* --- flux --- */

typedef struct ry_tune_flux {
    double beta;
    const ry_tune_piece *piece; /* [theta][seed] */
    int good;
    double q[RY_TUNE_THETAS], error[RY_TUNE_THETAS]; /* mean of the seeds, its standard error */
    double misfit;
} ry_tune_flux;

typedef struct ry_tune_fit {
    int n_theta, seeds, n_beta;
    double theta[RY_TUNE_THETAS], target[RY_TUNE_THETAS], target_error[RY_TUNE_THETAS];
    ry_tune_flux grid[RY_TUNE_BETAS];
    ry_tune_flux his, best; /* his constants; ours with the best beta */
    double spread[RY_TUNE_THETAS]; /* of beds with other seeds, as a part of q*, pooled over all sets */
    double fine_beta[RY_TUNE_FINE], fine_misfit[RY_TUNE_FINE];
    double beta, low, high; /* 95 %, by the misfit */
    int identifiable, at_edge;
    double contrast;               /* misfit at its worst less at its best */
    int reachable[RY_TUNE_THETAS]; /* some beta of the grid comes within 25 % of the target */
} ry_tune_fit;

/* Means and errors of the grid, then the best beta; RY_UNPHYSICAL if no beta is good. */
ry_status ry_tune_fit_beta(ry_tune_fit *fit, ry_error *error);
/* The beta of the grid with the least misfit. */
int ry_tune_best_of_grid(const ry_tune_fit *fit);

/* What beds differ by, over these sets: fit->spread. Then the means of a set, with their errors. */
void ry_tune_pool(ry_tune_fit *fit, int n, const ry_tune_flux *const *set);
void ry_tune_take_flux(const ry_tune_fit *fit, ry_tune_flux *flux);
void ry_tune_find_reach(ry_tune_fit *fit, int n, const ry_tune_flux *const *set);
/* ln of q* over the target, bounded: a bed at rest is ten times too slow; and its standard error. */
double ry_tune_ratio(double q, double target);
double ry_tune_ratio_error(const ry_tune_fit *fit, const ry_tune_flux *flux, int i);
/* How well ln q* at a theta is to meet ln target: error of the target, and of the beds that all share. */
double ry_tune_aim_variance(const ry_tune_fit *fit, int i);

/* --- the joint fit --- */

typedef struct ry_tune_axis {
    int key;
    char path[60];
    double low, high;
} ry_tune_axis;

typedef struct ry_tune_sample {
    double x[RY_RESPONSE_INPUTS]; /* -1..1: ln of the constant between its bounds */
    ry_tune_flux flux;
} ry_tune_sample;

typedef struct ry_tune_joint {
    int n_axes, budget, first, n, good; /* samples: all, over the whole box, made, of use */
    ry_tune_axis axis[RY_RESPONSE_INPUTS];
    ry_tune_sample *sample; /* owned */
    ry_aim aim;
    ry_verdict verdict;
    double best[RY_RESPONSE_INPUTS], low[RY_RESPONSE_INPUTS], high[RY_RESPONSE_INPUTS];
} ry_tune_joint;

/* The constant that x stands for. */
double ry_tune_axis_value(const ry_tune_axis *axis, double x);

/* --- the whole --- */

typedef struct ry_tune_run {
    const ry_tune_options *wish;
    ry_config base;
    ry_target target;
    double settle_window; /* [s] */
    ry_tune_journal *journal;
    ry_tune_settling stiffness, damping;
    ry_tune_fit fit;
    ry_tune_joint joint; /* n_axes 0: the four steps instead */
    ry_tune_piece *piece[8]; /* owned sets, and how many are in each */
    int n_piece[8], n_sets;
    char *output, *yaml_path;
    char mark[100]; /* what its pieces depend on, in short */
    double started;
    int kept; /* pieces that were in the journal */
} ry_tune_run;

/* Reads --vary and --budget into run->joint, checked. */
ry_status ry_tune_joint_read(ry_tune_run *run, ry_error *error);
/* Runs the samples, fits, runs the best. */
ry_status ry_tune_joint_fit(ry_tune_run *run, ry_error *error);

/* --- sets of pieces --- */

enum { RY_TUNE_CHANGES = 12 };
typedef struct ry_tune_changes {
    char text[RY_TUNE_CHANGES][80];
    const char *list[RY_TUNE_CHANGES];
    int n;
} ry_tune_changes;

void ry_tune_change(ry_tune_changes *c, const char *key, double value);
void ry_tune_change_word(ry_tune_changes *c, const char *key, const char *word);
/* From one thread only: reading units is not made for several. */
void ry_tune_make_piece(const ry_tune_run *run, ry_tune_piece *piece, ry_tune_kind kind,
                        ry_tune_changes *c);
/* The flux at fit.theta[i] with these changes. */
void ry_tune_make_flux(const ry_tune_run *run, ry_tune_piece *piece, ry_tune_changes *c, int i);
/* A set that the run owns; NULL: no memory. */
ry_tune_piece *ry_tune_new_pieces(ry_tune_run *run, int n, ry_error *error);
ry_status ry_tune_run_batch(ry_tune_run *run, const char *what, ry_tune_piece *piece, int n,
                            ry_error *error);

/* --- what is left --- */

ry_status ry_tune_write_file(const ry_tune_run *run, ry_error *error);
ry_status ry_tune_write_scene(const ry_tune_run *run, ry_error *error);
void ry_tune_report(const ry_tune_run *run);
void ry_tune_report_joint(const ry_tune_run *run);
/* The lines of a report, shared by both. */
#define ry_tune_say(run, ...) ry_text_say((run)->wish->write, (run)->wish->data, __VA_ARGS__)
void ry_tune_report_head(const ry_tune_run *run);
void ry_tune_report_flux(const ry_tune_run *run, const ry_tune_flux *flux, const char *name);
void ry_tune_report_theta(const ry_tune_run *run);
void ry_tune_report_spread(const ry_tune_run *run);
void ry_tune_report_reach(const ry_tune_run *run, const char *what);

#endif
