/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * For tests that save a simulation and go on from the file. */
#ifndef RY_TESTS_SAVE_BENCH_H
#define RY_TESTS_SAVE_BENCH_H

#include <unistd.h>

#include "io/result.h"
#include "scene_bench.h"
#include "sim/sim.h"

/* Whose last letters mkdtemp replaces. */
static char folder[] = "/tmp/ryusa-test-save-XXXXXX";

static int make_folder(void **unused)
{
    (void)unused;
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static int remove_folder(void **unused)
{
    (void)unused;
    char line[100];
    snprintf(line, sizeof line, "rm -rf '%s'", folder);
    return system(line) == 0 ? 0 : -1;
}

static const char *in_folder(const char *name)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* Saves the state as a run does, forgets it, reads it back and goes on from there. */
static void save_and_forget(scene *s, int threads)
{
    ry_error error = {0};
    ry_result *file = NULL;
    ry_state state = {0};
    int found = 0;
    assert_int_equal(ry_sim_collect(s->sim, &error), RY_OK);
    assert_int_equal(
        ry_result_create(&file, in_folder("saved.h5"), &s->config, &s->sim->state, 1, &error),
        RY_OK);
    assert_int_equal(ry_result_flush(file, &s->sim->state, &error), RY_OK);
    ry_result_close(file);
    ry_sim_free(s->sim);
    assert_int_equal(
        ry_result_resume(&file, in_folder("saved.h5"), &s->config, &state, &found, &error), RY_OK);
    assert_int_equal(found, 1);
    ry_result_close(file);
    s->sim = ry_sim_adopt(&s->config, &state, threads, &error);
    if (s->sim == NULL) {
        fail_msg("%s", error.text);
    }
}

#endif
