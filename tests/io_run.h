/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * For the tests of the result file: runs of a state that moves by a rule of its own in place of a
 * simulation, in a folder of their own. Contents are read back by io_check.py (h5py). */
#ifndef RY_TESTS_IO_RUN_H
#define RY_TESTS_IO_RUN_H

#include <errno.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "io/result.h"

#ifndef RY_SOURCE_DIR
#define RY_SOURCE_DIR "."
#endif

static const char scene[] = "title: a test of <files> & \"folders\"\n"
                            "grains: {columns: 6, layers: 5}\n"
                            "time: {step: 20 us, end: 0.2 s, settle: 0}\n"
                            "output: {interval: 2 ms}\n";

enum { N = 36, NZ = 12 };
static char folder[] = "/tmp/ryusa-test-io-XXXXXX";

/* The path of a name; it stays valid. */
static const char *in_folder(const char *name)
{
    static char paths[64][200];
    char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    int k = 0;
    while (paths[k][0] != '\0' && strcmp(paths[k], path) != 0) {
        ++k;
        assert_true(k < 64);
    }
    return strcpy(paths[k], path);
}

static int python(const char *command, const char *a, const char *b)
{
    char line[900];
    snprintf(line, sizeof line, "/usr/bin/python3 -B '%s/tests/io_check.py' %s '%s' '%s'",
             RY_SOURCE_DIR, command, a, b != NULL ? b : "");
    if (b == NULL) {
        line[strlen(line) - 3] = '\0';
    }
    return system(line);
}

static int have_h5py(void)
{
    return system("/usr/bin/python3 -c 'import h5py, numpy' 2>/dev/null") == 0;
}

/* --- a state that moves --- */

static ry_config config_of(const char *override)
{
    ry_config config;
    ry_error error = {0};
    const char *const overrides[] = {override};
    if (ry_config_parse(&config, scene, "test", overrides, override != NULL, &error) != RY_OK) {
        fail_msg("%s", error.text);
    }
    return config;
}

static ry_state first_state(void)
{
    ry_state state;
    assert_int_equal(ry_state_create(&state, N, NZ, 1, NULL), RY_OK);
    for (int k = 0; k < N; ++k) {
        const int id = (k * 7 + 3) % N;
        state.grains.id[k] = id;
        state.grains.x[k] = 1e-4 * id;
        state.grains.z[k] = 5e-4 + 1e-5 * id;
        state.grains.radius[k] = 2.5e-4;
        state.grains.density[k] = 2650.0;
        state.grains.fixed[k] = id < 6;
    }
    state.column.dz = 2.5e-4;
    return state;
}

static void fill_contacts(ry_state *state)
{
    const int64_t n = state->step / 100 % 70;
    assert_int_equal(ry_contacts_reserve(&state->contacts, n, NULL), RY_OK);
    state->contacts.n = n;
    for (int64_t k = 0; k < n; ++k) {
        state->contacts.id_i[k] = (int32_t)(k / 3);
        state->contacts.id_j[k] = (int32_t)(k / 3 + 1 + k % 3);
        state->contacts.slip[k] = 1e-9 * (double)(k + state->step);
        state->contacts.rest[k] = 1e-12 * (double)k;
        state->contacts.age[k] = (ry_steps)(k % 256);
    }
}

/* The next state follows from this one alone, whatever the storage order. */
static void move(ry_state *state, double dt, double length)
{
    ry_grains *const grains = &state->grains;
    for (int k = 0; k < N; ++k) {
        grains->vx[k] = 0.9 * grains->vx[k] + 1e-4 * (grains->id[k] % 5);
        grains->vz[k] = 1e-3 * (grains->id[k] % 3) - 1e-6 * grains->vx[k];
        grains->x[k] += grains->vx[k] * dt;
        if (grains->x[k] >= length) {
            grains->x[k] -= length;
            ++grains->image[k];
        }
        grains->spin[k] = grains->x[k] * 10.0;
        const double lost = grains->vx[k] * 1e-9;
        ry_exact_add(&state->ledger.loss_friction, ry_scale_make(1.0), &lost, 1);
    }
    for (int k = 0; k < NZ; ++k) {
        state->column.u[k] += 1e-6 * k;
    }
    ++state->step;
    state->time = (double)state->step * dt;
}

static ry_sample sample_of(const ry_state *state)
{
    double sum = 0.0;
    for (int id = 0; id < N; ++id) {
        for (int k = 0; k < N; ++k) {
            sum += state->grains.id[k] == id ? state->grains.vx[k] : 0.0;
        }
    }
    return (ry_sample){.q_star = sum,
                       .q_b = sum * 1e-6,
                       .bed_level = 1e-3,
                       .kinetic_energy = sum * sum,
                       .integration = -1e-12 * (double)state->step};
}

typedef struct plan {
    const char *path, *override;
    int resume, force;
    long long until; /* stop after this step without finishing; 0: to the end */
    int flush_every; /* steps */
    int pause;       /* microseconds after a flush */
    int found;       /* answer of resume */
    ry_error error;
} plan;

static ry_status write_rows(ry_result *result, const ry_state *state, const ry_derived *derived,
                            ry_error *error)
{
    if (state->step % derived->steps_series == 0) {
        const ry_sample sample = sample_of(state);
        RY_TRY(ry_result_sample(result, state, &sample, error));
    }
    if (state->step % derived->steps_frame == 0) {
        double *const u = state->column.u;
        const ry_profile profile = {NZ, 2.5e-4, u, u, u, u, u};
        RY_TRY(ry_result_frame(result, state, error));
        RY_TRY(ry_result_profile(result, state, &profile, error));
    }
    return RY_OK;
}

static ry_status end_run(ry_result *result, const ry_state *state, ry_error *error)
{
    ry_summary summary = {.q_star_mean = 0.5,
                          .q_star_standard_error = 0.01,
                          .samples = 7,
                          .equilibration_method = "a test"};
    summary.has_profile = 1;
    summary.profile_from = 0.05;
    const ry_cost cost = {.wall_seconds = 1.0,
                          .threads = 2,
                          .n_stages = 1,
                          .stage_name = {"contact"},
                          .stage_seconds = {0.5}};
    ry_result_summary(result, &summary, &cost);
    return ry_result_finish(result, state, error);
}

static ry_status step_until(ry_result *result, ry_state *state, const ry_config *config, plan *of)
{
    const ry_derived derived = ry_config_derive(config);
    const long long last = of->until > 0 ? of->until : derived.steps_end;
    ry_status status = write_rows(result, state, &derived, &of->error);
    while (status == RY_OK && state->step < last) {
        move(state, config->time_step, derived.length);
        status = write_rows(result, state, &derived, &of->error);
        if (status == RY_OK && state->step % of->flush_every == 0) {
            fill_contacts(state);
            status = ry_result_flush(result, state, &of->error);
            usleep((unsigned)of->pause);
        }
    }
    fill_contacts(state);
    return status;
}

static ry_status begin(ry_result **result, ry_state *state, const ry_config *config, plan *of)
{
    of->found = 0;
    if (of->resume) {
        RY_TRY(ry_result_resume(result, of->path, config, state, &of->found, &of->error));
    }
    if (of->found == 0) {
        *state = first_state();
        return ry_result_create(result, of->path, config, state, of->force, &of->error);
    }
    return RY_OK;
}

static ry_status run(plan *of)
{
    ry_config config = config_of(of->override);
    ry_state state = {0};
    ry_result *result = NULL;
    of->error = (ry_error){0};
    ry_status status = begin(&result, &state, &config, of);
    if (status == RY_OK && result != NULL) {
        status = step_until(result, &state, &config, of);
        if (status == RY_OK && of->until == 0) {
            status = end_run(result, &state, &of->error);
        } else {
            ry_result_close(result);
        }
    }
    ry_state_free(&state);
    ry_config_free(&config);
    return status;
}

static void must(plan *of)
{
    if (run(of) != RY_OK) {
        fail_msg("%s: %s", of->path, of->error.text);
    }
}

static const char *whole(void)
{
    const char *const path = in_folder("whole.h5");
    if (access(path, F_OK) != 0) {
        plan of = {.path = path, .flush_every = 1000};
        must(&of);
    }
    return path;
}

static int exists(const char *name)
{
    return access(in_folder(name), F_OK) == 0;
}

static void assert_same(const char *path)
{
    if (have_h5py()) {
        assert_int_equal(python("same", whole(), path), 0);
    }
}

static int make_folder(void **unused)
{
    (void)unused;
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static int remove_folder(void **unused)
{
    (void)unused;
    char line[300];
    snprintf(line, sizeof line, "rm -rf '%s'", folder);
    return system(line) == 0 ? 0 : -1;
}

#endif
