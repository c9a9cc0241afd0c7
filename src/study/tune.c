/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The four steps of a tuning, one after the other; within a step all pieces are independent. */
#include "study/tune.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/hash.h"
#include "base/link.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/text.h"
#include "config/particle.h"
#include "io/table_file.h"
#include "study/each.h"
#include "study/tune_private.h"

/* The lattice is watched for this many times sqrt(2 H/g), the time of a fall through its height. */
#define FALLS 30.0

static const double alpha_m_full[] = {10, 14.1421, 20,  28.2843, 40, 56.5685,
                                      80, 113.137, 160, 226.274, 320};
static const double alpha_m_quick[] = {10, 20, 80, 320};
static const double alpha_cn_full[] = {0.1, 0.2, 0.35, 0.7, 1.3, 2.5, 5, 10, 20};
static const double alpha_cn_quick[] = {0.2, 1.3, 5};
static const double beta_full[] = {0.25, 0.5, 1, 2, 4, 8, 15.8};
static const double beta_quick[] = {0.5, 1, 4};
enum { FULL_SETTLE_SEEDS = 6, FULL_FLUX_SEEDS = 4, FULL_THETAS = 6, QUICK_THETAS = 2 };
#define COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

/* --- steps 1 and 2: settling ---------------------------------------------------------------------- */

typedef struct constants {
    double alpha_m, alpha_cn, beta;
} constants;

static ry_tune_changes change_constants(constants a, int seed)
{
    ry_tune_changes c = {.n = 0};
    ry_tune_change(&c, "contact.alpha_m", a.alpha_m);
    ry_tune_change(&c, "contact.alpha_cn", a.alpha_cn);
    ry_tune_change(&c, "contact.beta", a.beta);
    ry_tune_change(&c, "grains.seed", seed);
    return c;
}

static void make_settling(const ry_tune_run *run, ry_tune_piece *piece, constants a, int seed)
{
    ry_tune_changes c = change_constants(a, seed);
    ry_tune_change(&c, "time.end", run->settle_window);
    ry_tune_change_word(&c, "fluid.model", "none");
    ry_tune_change_word(&c, "contact.wet", "false");
    ry_tune_make_piece(run, piece, RY_TUNE_SETTLE, &c);
}

static ry_status settle_all(ry_tune_run *run, ry_tune_settling *t, const char *what,
                            const double *values, int n, ry_error *error)
{
    t->n = n;
    t->seeds = run->wish->quick ? 2 : FULL_SETTLE_SEEDS;
    ry_tune_piece *const set = ry_tune_new_pieces(run, n * t->seeds, error);
    if (set == NULL) {
        return error->status;
    }
    const int is_stiffness = t == &run->stiffness;
    const double alpha_m = is_stiffness ? 0.0 : run->stiffness.candidate[run->stiffness.ours].value;
    for (int k = 0; k < n; k++) {
        const constants a = {is_stiffness ? values[k] : alpha_m,
                             is_stiffness ? run->base.contact_alpha_cn : values[k], 1.0};
        t->candidate[k].value = values[k];
        t->candidate[k].piece = &set[k * t->seeds];
        for (int s = 0; s < t->seeds; s++) {
            make_settling(run, &set[k * t->seeds + s], a, ry_random_replica(run->base.grains_seed, s));
        }
    }
    RY_TRY(ry_tune_run_batch(run, what, set, n * t->seeds, error));
    return ry_tune_choose(t, error);
}

static ry_status settle_both(ry_tune_run *run, ry_error *error)
{
    const int quick = run->wish->quick;
    run->stiffness.key = "alpha_m";
    run->damping.key = "alpha_cn";
    RY_TRY(settle_all(run, &run->stiffness, "step 1 of 4: settling by alpha_m",
                      quick ? alpha_m_quick : alpha_m_full,
                      quick ? COUNT(alpha_m_quick) : COUNT(alpha_m_full), error));
    return settle_all(run, &run->damping, "step 2 of 4: settling by alpha_cn",
                      quick ? alpha_cn_quick : alpha_cn_full,
                      quick ? COUNT(alpha_cn_quick) : COUNT(alpha_cn_full), error);
}

/* --- steps 3 and 4: flux -------------------------------------------------------------------------- */

static void fill_flux(const ry_tune_run *run, ry_tune_flux *f, ry_tune_piece *set, constants a)
{
    f->beta = a.beta;
    f->piece = set;
    for (int i = 0; i < run->fit.n_theta; i++) {
        for (int s = 0; s < run->fit.seeds; s++) {
            ry_tune_changes c = change_constants(a, ry_random_replica(run->base.grains_seed, s));
            ry_tune_make_flux(run, &set[i * run->fit.seeds + s], &c, i);
        }
    }
}

static constants ours(const ry_tune_run *run, double beta)
{
    return (constants){run->stiffness.candidate[run->stiffness.ours].value,
                       run->damping.candidate[run->damping.ours].value, beta};
}

/* Around the best beta of the grid the misfit is looked at more closely. */
static ry_status run_around(ry_tune_run *run, int per, ry_error *error)
{
    static const double full[] = {0.63, 0.794, 1.26, 1.587}, quick[] = {0.707, 1.414};
    const double *const factor = run->wish->quick ? quick : full;
    const int n = run->wish->quick ? COUNT(quick) : COUNT(full);
    ry_tune_fit *const fit = &run->fit;
    const double best = fit->grid[ry_tune_best_of_grid(fit)].beta;
    ry_tune_piece *const set = ry_tune_new_pieces(run, n * per, error);
    if (set == NULL) {
        return error->status;
    }
    const int grid = fit->n_beta;
    for (int k = 0; k < n; k++) {
        const double beta = best * factor[k];
        if (beta >= fit->grid[0].beta && beta <= fit->grid[grid - 1].beta) {
            const int place = fit->n_beta - grid;
            fill_flux(run, &fit->grid[fit->n_beta++], &set[place * per], ours(run, beta));
        }
    }
    RY_TRY(ry_tune_run_batch(run, "step 4 of 4: flux around the best beta", set, (fit->n_beta - grid) * per,
                             error));
    return ry_tune_fit_beta(fit, error);
}

static ry_status run_fluxes(ry_tune_run *run, ry_error *error)
{
    ry_tune_fit *const fit = &run->fit;
    const double *const beta = run->wish->quick ? beta_quick : beta_full;
    const int per = fit->n_theta * (fit->seeds = run->wish->quick ? 1 : FULL_FLUX_SEEDS);
    fit->n_beta = run->wish->quick ? COUNT(beta_quick) : COUNT(beta_full);
    const int all = per * (fit->n_beta + 1);
    ry_tune_piece *const set = ry_tune_new_pieces(run, all, error);
    if (set == NULL) {
        return error->status;
    }
    for (int b = 0; b < fit->n_beta; b++) {
        fill_flux(run, &fit->grid[b], &set[b * per], ours(run, beta[b]));
    }
    fill_flux(run, &fit->his, &set[fit->n_beta * per],
              (constants){RY_TUNE_HIS_ALPHA_M, RY_TUNE_HIS_ALPHA_CN, RY_TUNE_HIS_BETA});
    RY_TRY(ry_tune_run_batch(run, "steps 3 and 4 of 4: flux by beta", set, all, error));
    RY_TRY(ry_tune_fit_beta(fit, error));
    RY_TRY(run_around(run, per, error));
    ry_tune_take_flux(fit, &fit->his);
    return RY_OK;
}

/* The best beta itself is run, too: the report tells what it gives, not what was interpolated. */
static ry_status run_best(ry_tune_run *run, ry_error *error)
{
    ry_tune_fit *const fit = &run->fit;
    const int n = fit->n_theta * fit->seeds;
    ry_tune_piece *const set = ry_tune_new_pieces(run, n, error);
    char rounded[30];
    if (set == NULL) {
        return error->status;
    }
    snprintf(rounded, sizeof rounded, "%.3g", fit->beta);
    fit->beta = strtod(rounded, NULL);
    fill_flux(run, &fit->best, set, ours(run, fit->beta));
    RY_TRY(ry_tune_run_batch(run, "step 4 of 4: flux at the best beta", set, n, error));
    ry_tune_take_flux(fit, &fit->best);
    return RY_OK;
}

/* --- before and after ------------------------------------------------------------------------------ */

static ry_status check_scene(const ry_tune_run *run, ry_error *error)
{
    const ry_config *const c = &run->base;
    const char *const path = run->wish->scene;
    if (!c->has_grains || c->grains_columns == 0 || c->grains_layers == 0) {
        return ry_fail(error, RY_BAD_INPUT,
                       "%s: grains: there is no bed to tune; give grains.columns and grains.layers",
                       path);
    }
    if (!isnan(c->contact_stiffness)) {
        return ry_fail(error, RY_BAD_INPUT,
                       "%s: contact.stiffness: replaces alpha_m, which is to be found; remove it",
                       path);
    }
    if (c->fluid_model == RY_FLUID_NONE) {
        return ry_fail(error, RY_BAD_INPUT,
                       "%s: fluid.model: none moves no grain, so beta can't be found; allowed are "
                       "stress, log, balance",
                       path);
    }
    if (!(c->domain_gravity > 0.0)) {
        return ry_fail(error, RY_BAD_INPUT, "%s: domain.gravity: a bed settles by gravity; it is 0",
                       path);
    }
    if (!(c->time_end >= c->time_settle + RY_TUNE_BOOST + 0.1)) {
        return ry_fail(
            error, RY_BAD_INPUT,
            "%s: time.end: %g s leaves no time for a flux after time.settle and the start "
            "from motion; allowed is at least %g s",
            path, c->time_end, c->time_settle + RY_TUNE_BOOST + 0.1);
    }
    return RY_OK;
}

/* 0.1 to 1 evenly in ln theta, or what the target's points cover; where it is above 0. */
static ry_status choose_thetas(ry_tune_run *run, ry_error *error)
{
    ry_tune_fit *const fit = &run->fit;
    const ry_target *const target = &run->target;
    const int own = target->relation == NULL && target->n <= RY_TUNE_THETAS && !run->wish->quick;
    double low = 0.1, high = 1.0;
    if (target->relation == NULL) {
        ry_target_range(target, &low, &high);
    } else if (run->wish->quick) {
        low = 0.4;
    }
    const int between = !(high > low) ? 1 : run->wish->quick ? QUICK_THETAS : FULL_THETAS;
    const int n = own ? target->n : between;
    for (int k = 0; k < n; k++) {
        char text[30];
        snprintf(text, sizeof text, "%.3g", low * pow(high / low, n > 1 ? k / (n - 1.0) : 0.0));
        const double theta = own ? target->theta[k] : fmin(fmax(strtod(text, NULL), low), high);
        const double q = ry_target_flux(target, theta);
        if (q > 0.0 && theta <= 100.0) {
            fit->theta[fit->n_theta] = theta;
            fit->target[fit->n_theta] = q;
            fit->target_error[fit->n_theta++] = ry_target_error(target, theta);
        }
    }
    return fit->n_theta > 0
               ? RY_OK
               : ry_fail(error, RY_BAD_INPUT,
                         "%s: no flux above 0 at a Shields number of at most 100 between %g and %g: nothing "
                         "to tune for",
                         target->name, low, high);
}

/* One word for everything that the pieces depend on; more --budget uses those that are there. */
static void make_mark(ry_tune_run *run)
{
    const ry_tune_fit *const fit = &run->fit;
    uint64_t hash = ry_hash_mix(RY_HASH_START, run->base.text, strlen(run->base.text));
    hash = ry_particle_hash(hash, run->base.particles, run->base.n_particles); /* the text may name a table of them */
    for (int i = 0; i < fit->n_theta; i++) {
        hash = ry_hash_mix(hash, &fit->theta[i], sizeof(double));
        hash = ry_hash_mix(hash, &fit->target[i], sizeof(double));
    }
    for (int k = 0; k < run->joint.n_axes; k++) {
        const ry_tune_axis *const axis = &run->joint.axis[k];
        hash = ry_hash_mix(hash, axis->path, strlen(axis->path));
        hash = ry_hash_mix(hash, &axis->low, sizeof(double));
        hash = ry_hash_mix(hash, &axis->high, sizeof(double));
    }
    snprintf(run->mark, sizeof run->mark, "ryusa tune %s %s %016llx", ry_version(),
             run->wish->quick ? "quick" : "full", (unsigned long long)hash);
}

/* Begins as a tuned scene does: an earlier one may be replaced by a resume, nobody's own scene. */
static int is_tuned_scene(const char *path)
{
    char first[sizeof RY_TUNE_SCENE_HEAD] = "";
    FILE *const file = fopen(path, "r");
    const int read = file != NULL && fread(first, 1, sizeof first - 1, file) == sizeof first - 1;
    if (file != NULL) {
        fclose(file);
    }
    return read && strcmp(first, RY_TUNE_SCENE_HEAD) == 0;
}

/* A job that is put back into its queue after its end has nothing left to do. */
static int is_finished(const ry_tune_run *run)
{
    return run->wish->resume && !run->wish->force && ry_table_file_says(run->output, "mark", run->mark);
}

/* OUT.h5 -> OUT.yaml, which must neither be the scene nor be there already. */
static ry_status check_outputs(ry_tune_run *run, ry_error *error)
{
    RY_TRY(ry_link_follow(run->wish->output, &run->output, error));
    const char *const output = run->output;
    const size_t length = strlen(output);
    run->yaml_path = ry_text_print("%.*s.yaml", ry_text_stem(output), output);
    if (run->yaml_path == NULL) {
        return ry_no_memory(error, length);
    }
    struct stat scene, yaml;
    const int exists = stat(run->yaml_path, &yaml) == 0;
    if (exists && stat(run->wish->scene, &scene) == 0 && scene.st_ino == yaml.st_ino &&
        scene.st_dev == yaml.st_dev) {
        return ry_fail(error, RY_BAD_INPUT,
                       "-o %s: the tuned scene %s would replace the scene; give another name",
                       output, run->yaml_path);
    }
    if (is_finished(run)) {
        return RY_OK;
    }
    RY_TRY(ry_table_file_check(output, run->wish->force, error));
    return exists && !run->wish->force && !(run->wish->resume && is_tuned_scene(run->yaml_path))
               ? ry_fail(error, RY_BAD_FILE, "%s: exists; --force overwrites it", run->yaml_path)
               : RY_OK;
}

static ry_status prepare(ry_tune_run *run, ry_error *error)
{
    const ry_tune_options *const w = run->wish;
    RY_TRY(ry_config_load(&run->base, w->scene, w->overrides, w->n_overrides, error));
    RY_TRY(check_scene(run, error));
    RY_TRY(ry_tune_joint_read(run, error));
    RY_TRY(ry_target_open(&run->target, w->target, error));
    RY_TRY(choose_thetas(run, error));
    make_mark(run);
    RY_TRY(check_outputs(run, error));
    const ry_derived q = ry_config_derive(&run->base);
    const double fall = sqrt(2.0 * run->base.grains_layers * q.d / run->base.domain_gravity);
    run->settle_window = (w->quick ? 0.3 : 1.0) * FALLS * fall;
    const double steps = ceil(run->settle_window / run->base.time_step / RY_TUNE_CURVE_STEPS);
    run->settle_window = steps * RY_TUNE_CURVE_STEPS * run->base.time_step;
    return RY_OK;
}

static ry_status tune(ry_tune_run *run, ry_error *error)
{
    RY_TRY(prepare(run, error));
    if (is_finished(run)) {
        ry_tune_say(run, "%s was finished already%s\n", run->wish->output,
                    run->joint.n_axes > 0 ? "; for more candidates give another name" : "");
        return RY_OK;
    }
    RY_TRY(ry_tune_journal_open(&run->journal, run->output, run->mark, run->wish->resume, run->wish->force, error));
    const int joint = run->joint.n_axes > 0;
    if (joint) {
        RY_TRY(ry_tune_joint_fit(run, error));
    } else {
        RY_TRY(settle_both(run, error));
        RY_TRY(run_fluxes(run, error));
        RY_TRY(run_best(run, error));
    }
    RY_TRY(ry_tune_write_scene(run, error));
    RY_TRY(ry_tune_write_file(run, error));
    (joint ? ry_tune_report_joint : ry_tune_report)(run);
    return RY_OK;
}

/* forget: nothing is left that a --resume could use */
static void release(ry_tune_run *run, int forget)
{
    for (int s = 0; s < run->n_sets; s++) {
        for (int k = 0; k < run->n_piece[s]; k++) {
            ry_tune_piece_clear(&run->piece[s][k]);
            ry_config_free(&run->piece[s][k].config);
        }
        free(run->piece[s]);
    }
    ry_tune_journal_close(run->journal, forget);
    ry_target_free(&run->target);
    free(run->joint.sample);
    ry_config_free(&run->base);
    free(run->output);
    free(run->yaml_path);
}

ry_status ry_tune(const ry_tune_options *options, ry_error *error)
{
    ry_error own = {0};
    ry_tune_run *const run = calloc(1, sizeof *run);
    if (run == NULL) {
        return ry_no_memory(error, sizeof *run);
    }
    run->wish = options;
    run->started = ry_clock();
    const ry_status status = tune(run, error != NULL ? error : &own);
    const int too_few = status == RY_UNPHYSICAL && run->joint.n_axes > 0; /* a larger budget goes on with them */
    release(run, status != RY_STOPPED && status != RY_BAD_FILE && !too_few);
    free(run);
    return status;
}
