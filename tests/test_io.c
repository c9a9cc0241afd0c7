/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The result file, with a state that moves by a rule of its own in place of a simulation. Contents
 * are read back by io_check.py (h5py). ctest: timeout 300 */
#include <errno.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "io/result.h"

#ifndef RY_SOURCE_DIR
#define RY_SOURCE_DIR "."
#endif

static const char scene[] =
    "title: a test of <files> & \"folders\"\n"
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
    snprintf(line, sizeof line, "/usr/bin/python3 -B '%s/tests/io_check.py' %s '%s' '%s'", RY_SOURCE_DIR,
             command, a, b != NULL ? b : "");
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
        state->contacts.age[k] = (double)(k % 256);
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
        state->ledger.loss_friction[k] += grains->vx[k] * 1e-9;
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
    return (ry_sample){.q_star = sum, .q_b = sum * 1e-6, .bed_level = 1e-3, .kinetic_energy = sum * sum,
                       .integration = -1e-12 * (double)state->step};
}

typedef struct plan {
    const char *path, *override;
    int resume, force;
    long long until;      /* stop after this step without finishing; 0: to the end */
    int flush_every;      /* steps */
    int pause;            /* microseconds after a flush */
    int found;            /* answer of resume */
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
    ry_summary summary = {.q_star_mean = 0.5, .q_star_standard_error = 0.01, .samples = 7,
                          .equilibration_method = "a test"};
    summary.profile = ry_result_mean_profile(result, 0.05, &summary.n_profiles_averaged);
    const ry_cost cost = {.wall_seconds = 1.0, .threads = 2, .n_stages = 1, .stage_name = {"contact"},
                          .stage_seconds = {0.5}};
    const ry_status status = ry_result_summary(result, &summary, &cost, error);
    if (status != RY_OK) {
        ry_result_close(result);
        return status;
    }
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

static void refused(plan *of, ry_status status, const char *word)
{
    assert_int_equal(run(of), status);
    if (strstr(of->error.text, word) == NULL) {
        fail_msg("'%s' does not say '%s'", of->error.text, word);
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

/* --- tests --- */

static void test_hash(void **unused)
{
    (void)unused;
    ry_state a = first_state(), b = first_state();
    a.step = b.step = 300;
    fill_contacts(&a);
    fill_contacts(&b);
    assert_true(ry_state_hash(&a) == ry_state_hash(&b));
#define SWAP(type, name, unit, text)                   \
    {                                                  \
        const type kept = b.grains.name[4];            \
        b.grains.name[4] = b.grains.name[9];           \
        b.grains.name[9] = kept;                       \
    }
    RY_GRAIN_FIELDS(SWAP)
    assert_true(ry_state_hash(&a) == ry_state_hash(&b));
#define CHANGE(type, name, unit, text)                          \
    b.grains.name[5] = (type)(b.grains.name[5] + (type)1);      \
    assert_true(ry_state_hash(&a) != ry_state_hash(&b));        \
    b.grains.name[5] = (type)(b.grains.name[5] - (type)1);
    RY_GRAIN_FIELDS(CHANGE)
#undef CHANGE
    ry_state_free(&b);
    b = first_state();
    b.step = 300;
    fill_contacts(&b);
#define CHANGE(type, name, unit, text)                          \
    b.contacts.name[1] = (type)(b.contacts.name[1] + (type)1);  \
    assert_true(ry_state_hash(&a) != ry_state_hash(&b));
    RY_CONTACT_FIELDS(CHANGE)
    ry_state_free(&a);
    ry_state_free(&b);
}

static void test_layout(void **unused)
{
    (void)unused;
    const char *const path = whole();
    assert_false(exists("whole.h5.part"));
    assert_false(exists("whole.h5.part.journal"));
    assert_true(exists("whole.xdmf"));
    if (!have_h5py()) {
        skip();
    }
    assert_int_equal(python("layout", path, NULL), 0);
    assert_int_equal(python("xdmf", path, NULL), 0);
}

static void test_resume(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("resumed.h5"), .resume = 1, .flush_every = 700};
    for (long long until = 1234; until < 9900; until += 1111) {
        of.until = until;
        must(&of);
        assert_true(exists("resumed.h5.part") && !exists("resumed.h5"));
        assert_int_equal(of.found, until > 1234);
    }
    of.until = 0;
    must(&of);
    assert_same(of.path);
}

static void test_fallback(void **unused)
{
    (void)unused;
    if (!have_h5py()) {
        skip();
    }
    plan of = {.path = in_folder("spoilt.h5"), .flush_every = 1000, .until = 3500};
    must(&of);
    assert_int_equal(python("spoil", in_folder("spoilt.h5.part"), "b"), 0);
    of.resume = 1;
    must(&of);
    assert_int_equal(of.found, 1);
    of.until = 4500;
    must(&of);
    assert_int_equal(python("spoil", in_folder("spoilt.h5.part"), "a"), 0);
    assert_int_equal(python("spoil", in_folder("spoilt.h5.part"), "b"), 0);
    refused(&of, RY_BAD_FILE, "damaged");
}

static void test_longer(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("longer.h5"), .override = "time.end=0.1", .flush_every = 900};
    must(&of);
    of.resume = 1;
    must(&of);
    assert_int_equal(of.found, 2);
    of.override = NULL;
    must(&of);
    assert_int_equal(of.found, 1);
    assert_false(exists("longer.h5.part"));
    assert_same(of.path);
    of.override = "contact.friction=0.5";
    refused(&of, RY_BAD_INPUT, "contact.friction: 0.57");
    of.override = "title=another";
    must(&of);
    assert_int_equal(of.found, 2);
}

static void test_fields(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("few.h5"), .override = "output.fields=[spin]", .flush_every = 900,
               .until = 2000};
    must(&of);
    of.resume = 1;
    of.until = 0;
    must(&of);
    assert_int_equal(of.found, 1);
    assert_false(exists("few.xdmf"));
    of = (plan){.path = in_folder("none.h5"), .override = "output.fields=[]", .flush_every = 900};
    (void)run(&of);
}

static void test_paths(void **unused)
{
    (void)unused;
    plan of = {.path = whole(), .flush_every = 1000, .until = 100};
    refused(&of, RY_BAD_FILE, "--force");
    of.path = folder;
    refused(&of, RY_BAD_FILE, "folder");
    of.path = in_folder("nowhere/x.h5");
    refused(&of, RY_BAD_FILE, "No such file");
    of.path = in_folder("whole.h5/x.h5");
    refused(&of, RY_BAD_FILE, "whole.h5");
    of.path = "/dev/full";
    refused(&of, RY_BAD_FILE, "regular file");
    of.path = "";
    refused(&of, RY_BAD_FILE, "empty");
    of.path = in_folder("no ending");
    of.until = 0;
    must(&of);
    assert_true(exists("no ending") && exists("no ending.xdmf"));
}

static void test_leftover(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("left.h5"), .flush_every = 1000, .until = 1500};
    must(&of);
    refused(&of, RY_BAD_FILE, "--resume");
    of.force = 1;
    of.until = 500;
    must(&of); /* this one leaves no checkpoint */
    of.force = 0;
    of.resume = 1;
    must(&of);
    assert_int_equal(of.found, 0);
}

static void test_foreign(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("foreign.h5"), .flush_every = 1000, .resume = 1};
    FILE *const file = fopen(in_folder("foreign.h5.part"), "w");
    fputs("this is a text, not a result", file);
    fclose(file);
    refused(&of, RY_BAD_FILE, "not an HDF5 file");
    if (have_h5py()) {
        assert_int_equal(python("foreign", in_folder("foreign.h5.part"), NULL), 0);
        refused(&of, RY_BAD_FILE, "has no /h5md");
    }
    assert_int_equal(truncate(in_folder("foreign.h5.part"), 0), 0);
    must(&of);
    assert_int_equal(of.found, 0);
    assert_same(of.path);
}

static void test_lock(void **unused)
{
    (void)unused;
    const char *const path = in_folder("locked.h5");
    ry_config config = config_of(NULL);
    ry_state state = first_state();
    ry_result *first = NULL;
    assert_int_equal(ry_result_create(&first, path, &config, &state, 0, NULL), RY_OK);
    plan of = {.path = path, .flush_every = 1000, .until = 100, .force = 1};
    refused(&of, RY_BAD_FILE, "in use by another run");
    of.resume = 1;
    refused(&of, RY_BAD_FILE, "in use by another run");
    if (have_h5py()) {
        assert_int_equal(python("opens", in_folder("locked.h5.part"), NULL), 0);
    }
    ry_result_close(first);
    of.resume = 0;
    must(&of);
    ry_state_free(&state);
    ry_config_free(&config);
}

static void write_nothing(void *data, const char *text)
{
    *(size_t *)data += strlen(text);
}

static void test_describe(void **unused)
{
    (void)unused;
    size_t length = 0;
    ry_error error = {0};
    char *text = NULL;
    assert_int_equal(ry_result_describe(whole(), write_nothing, &length, &error), RY_OK);
    assert_true(length > 1000);
    assert_int_equal(ry_result_scene_text(whole(), &text, &error), RY_OK);
    assert_non_null(strstr(text, "columns: 6"));
    free(text);
    plan of = {.path = in_folder("part.h5"), .override = "output.fields=[flux]", .flush_every = 1000,
               .until = 1500};
    must(&of);
    assert_int_equal(ry_result_describe(in_folder("part.h5.part"), write_nothing, &length, &error), RY_OK);
    assert_int_equal(ry_result_describe(in_folder("nowhere"), write_nothing, &length, &error), RY_BAD_FILE);
}

/* The run is killed at any moment, again and again, each time taken up, until it is whole. */
static void test_kill(void **unused)
{
    (void)unused;
    const char *const kills_text = getenv("RY_KILLS");
    const int kills = kills_text != NULL ? atoi(kills_text) : 40;
    plan of = {.path = in_folder("killed.h5"), .resume = 1, .flush_every = 50};
    uint64_t random = 88172645463325252u;
    int killed = 0;
    for (int k = 0; k < kills && !exists("killed.h5"); ++k) {
        const pid_t child = fork();
        if (child == 0) {
            _exit((int)run(&of));
        }
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        usleep((unsigned)(2000 + random % 60000));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        killed += WIFSIGNALED(status);
        assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
    }
    of.flush_every = 1000;
    must(&of);
    assert_true(killed > 3);
    assert_same(of.path);
    assert_false(exists("killed.h5.part") || exists("killed.h5.part.journal"));
}

/* A file may not grow beyond a limit, which moves from almost nothing to almost enough. */
static void test_limit(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("limit.h5"), .resume = 1, .flush_every = 500};
    for (rlim_t limit = 10000; limit < 700000; limit += 23456) {
        const pid_t child = fork();
        if (child == 0) {
            const struct rlimit most = {limit, limit};
            signal(SIGXFSZ, SIG_IGN);
            setrlimit(RLIMIT_FSIZE, &most);
            const ry_status status = run(&of);
            if (status != RY_OK && strstr(of.error.text, "File too large") == NULL) {
                print_message("%s\n", of.error.text);
                _exit(99);
            }
            _exit((int)status);
        }
        int status = 0;
        waitpid(child, &status, 0);
        assert_true(WIFEXITED(status));
        assert_true(WEXITSTATUS(status) == RY_BAD_FILE || WEXITSTATUS(status) == RY_OK);
        if (have_h5py() && exists("limit.h5.part")) {
            assert_int_equal(python("opens", in_folder("limit.h5.part"), NULL), 0);
        }
    }
    must(&of);
    assert_same(of.path);
}

/* A disk that fills up, and is given more room then. */
static void test_disk_full(void **unused)
{
    (void)unused;
    const char *const disk = in_folder("disk");
    if (mkdir(disk, 0700) != 0 || mount("tmpfs", disk, "tmpfs", 0, "size=100k") != 0) {
        skip();
    }
    plan of = {.path = in_folder("disk/full.h5"), .resume = 1, .flush_every = 500};
    int full = 0;
    for (int size = 120; size < 2000; size += 40) {
        char options[40];
        snprintf(options, sizeof options, "size=%dk", size);
        assert_int_equal(mount("tmpfs", disk, "tmpfs", MS_REMOUNT, options), 0);
        of.path = in_folder("disk/full.h5");
        if (run(&of) == RY_OK) {
            break;
        }
        ++full;
        assert_non_null(strstr(of.error.text, "No space left on device"));
        if (have_h5py() && exists("disk/full.h5.part")) {
            assert_int_equal(python("opens", in_folder("disk/full.h5.part"), NULL), 0);
        }
    }
    of.path = in_folder("disk/full.h5");
    const int made = exists("disk/full.h5");
    if (made) {
        assert_same(of.path);
    }
    umount(disk);
    assert_true(made && full > 2);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hash),     cmocka_unit_test(test_layout),
        cmocka_unit_test(test_resume),   cmocka_unit_test(test_fallback),
        cmocka_unit_test(test_longer),   cmocka_unit_test(test_fields),
        cmocka_unit_test(test_paths),    cmocka_unit_test(test_leftover),
        cmocka_unit_test(test_foreign),  cmocka_unit_test(test_lock),
        cmocka_unit_test(test_describe), cmocka_unit_test(test_kill),
        cmocka_unit_test(test_limit),    cmocka_unit_test(test_disk_full),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
