/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The same bits whatever the number of threads, the reach of the neighbour list, the order in memory,
 * looking on, and stopping and going on; and from one version to the next (golden hashes). */
#include "save_bench.h"

/* ---- golden hashes -------------------------------------------------------------------------------- */

/* Scenes in which everything happens within few steps. The ledger is part of the state.
 *
 * Renew with
 *
 *     RY_UPDATE=1 build/tests/test_determinism
 *
 * which prints the table. A change means that every user gets other bits: it has to be wanted, and to be
 * noted in CHANGELOG.md. */
typedef struct golden {
    const char *file, *overrides;
    long long steps;
    unsigned long long hash;
} golden;

static const golden table[] = {
    {"settle.yaml", "grains.columns=12 grains.layers=6", 1500, 0xe077c06fd10876dbu},
    {"settle.yaml", "grains.columns=12 grains.layers=6 contact.law=fujioka-2", 600,
     0x4b5da7d180bdc560u},
    {"settle.yaml",
     "grains.columns=12 grains.layers=6 contact.law=fujioka-2-printed grains.spread=0", 600,
     0x3b3b55d7a00e2a57u},
    {"settle.yaml", "grains.columns=12 grains.layers=6 contact.law=fujioka-1 contact.friction=0",
     600, 0xb4a42f4a088eda46u},
    {"settle.yaml", "grains.columns=12 grains.layers=6 contact.law=fujioka-1 contact.restitution=0.6",
     2000, 0x58db29ee9bf25135u},
    {"settle.yaml", "grains.columns=12 grains.layers=6 contact.law=cundall contact.alpha_cn=0.1",
     600, 0xc79a245eba0edef1u},
    {"settle.yaml",
     "grains.columns=12 grains.layers=6 contact.law=cundall-tension grains.packing=random contact.alpha_cn=0.1",
     600, 0x9bd41f2d95025c63u},
    {"settle.yaml",
     "grains.columns=12 grains.layers=6 contact.law=tanaka domain.periodic=false domain.walls=true domain.floor=flat",
     600, 0x44b93cdff57ee089u},
    {"flume.yaml", "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.shields=0.8", 3000,
     0x7c5bfc47278c7548u},
    {"flume.yaml",
     "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.model=stress fluid.drag=schiller-naumann fluid.shields=0.8",
     2000, 0xe248b943c7de91d6u},
    {"flume.yaml",
     "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.model=log fluid.drag=ferguson-church fluid.shields=0.8 fluid.lift=0.2 output.fields=energy",
     2000, 0xa8582b0df319b83au},
    {"flume.yaml",
     "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.shields=0.8 contact.wet=true contact.restitution=0.9 grains.spread=0",
     2000, 0x6c9d61c956ad2811u},
    {"flume.yaml",
     "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.model=stress contact.law=cundall contact.alpha_cn=0.1 contact.wet=true domain.periodic=false domain.walls=true",
     2000, 0xd9ac7bd045406022u},
    {"flume.yaml", "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.shields=0.3 fluid.turbulence=walk", 2000,
     0x08ba5c7100bc8bfbu},
    {"flume.yaml",
     "grains.columns=12 grains.layers=6 time.settle=0.01 fluid.model=log fluid.shields=0.3 fluid.turbulence=walk fluid.eddy_time=2ms "
     "fluid.lift=0.2 contact.law=cundall contact.alpha_cn=0.1",
     2000, 0xc5ff15d062f5c3efu},
};
enum { SCENES = sizeof table / sizeof *table };

static unsigned long long hash_of(const golden *g, int threads, const char *more)
{
    scene *const s = open_file(g->file, threads, "%s %s", g->overrides, more);
    step_scene(s, g->steps);
    const unsigned long long hash = ry_sim_hash(s->sim);
    close_scene(s);
    return hash;
}

/* The default law aside, which scenes have that name none. */
static int has_golden(const char *law)
{
    char words[60];
    const int length = snprintf(words, sizeof words, "contact.law=%s", law);
    int found = strcmp(law, law_words[RY_LAW_ENERGY]) == 0;
    for (int k = 0; k < SCENES; k++) {
        const char *const at = strstr(table[k].overrides, words);
        found |= at != NULL && (at[length] == ' ' || at[length] == '\0');
    }
    return found;
}

static void test_golden(void **state)
{
    (void)state;
    int changed = 0;
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        if (!has_golden(law_words[law])) {
            fail_msg("law %s has no scene in the table of %s", law_words[law], __FILE__);
        }
    }
    for (int k = 0; k < SCENES; k++) {
        const unsigned long long hash = hash_of(&table[k], 1, "");
        changed += hash != table[k].hash;
        if (getenv("RY_UPDATE") != NULL) {
            printf("    {\"%s\", \"%s\",\n     %lld, 0x%016llxu},\n", table[k].file,
                   table[k].overrides, table[k].steps, hash);
        } else if (hash != table[k].hash) {
            printf("%s %s: 0x%016llx, not 0x%016llx\n", table[k].file, table[k].overrides, hash,
                   table[k].hash);
        }
    }
    assert_true(changed == 0 || getenv("RY_UPDATE") != NULL);
}

/* ---- what may not matter ---------------------------------------------------------------------------- */

static void check_same(const char *what, int scene_index, int threads, const char *more,
                       unsigned long long as)
{
    const golden *const g = &table[scene_index];
    const unsigned long long hash = hash_of(g, threads, more);
    if (hash != as) {
        fail_msg("%s %s: %s %s: 0x%016llx, not 0x%016llx", g->file, g->overrides, what, more, hash,
                 as);
    }
}

static void test_threads(void **state)
{
    (void)state;
    const int threads[] = {2, 3, 8};
    for (int k = 0; k < SCENES; k++) {
        const unsigned long long one = hash_of(&table[k], 1, "");
        for (int t = 0; t < 3; t++) {
            char what[40];
            snprintf(what, sizeof what, "%d threads", threads[t]);
            check_same(what, k, threads[t], "", one);
        }
    }
}

static void test_skin_and_order(void **state)
{
    (void)state;
    const char *const knobs[] = {
        "numerics.skin=0.05",      "numerics.skin=0.12",
        "numerics.skin=0.6",       "numerics.order=bed",
        "numerics.order=shuffled", "numerics.order=shuffled numerics.skin=0.05"};
    for (int k = 0; k < SCENES; k++) {
        const unsigned long long one = hash_of(&table[k], 1, "");
        for (size_t m = 0; m < sizeof knobs / sizeof *knobs; m++) {
            check_same("knob", k, m % 2 ? 3 : 1, knobs[m], one);
        }
    }
}

/* Grains that part faster than a short list reaches: 36 at 2 m/s, a twelfth of a diameter a step, in a box. */
enum { FAST = 36, IN_A_ROW = 6 };

static unsigned long long hash_of_fast(const char *law, double skin)
{
    char grains[6000];
    int at = 0;
    for (int k = 0; k < FAST; k++) {
        const double angle = 2.4 * k; /* of a sunflower: all directions */
        at += snprintf(grains + at, sizeof grains - (size_t)at,
                       "  - {position: [%.17g, %.17g], velocity: [%.17g, %.17g], diameter: %.17g}\n",
                       (0.3 + 0.6 * (k % IN_A_ROW)) * 1e-3, (0.4 + 0.6 * (k / IN_A_ROW)) * 1e-3, 2.0 * cos(angle),
                       2.0 * sin(angle), (0.42 + 0.002 * k) * 1e-3);
    }
    scene *const s = open_scene("domain: {length: 3.6 mm, periodic: false, walls: true, floor: flat, gravity: 9.81}\n"
                                "contact: {law: %s, alpha_m: 40, restitution: 0.9}\nnumerics: {skin: %g}\n"
                                "particles:\n%s", law, skin, grains);
    step_scene(s, 500);
    const unsigned long long hash = ry_sim_hash(s->sim);
    close_scene(s);
    return hash;
}

static void test_parting(void **state)
{
    (void)state;
#define NAME(value, word) word,
    static const char *const laws[] = {RY_LIST_law(NAME)};
#undef NAME
    for (size_t k = 0; k < sizeof laws / sizeof *laws; k++) {
        const unsigned long long hash = hash_of_fast(laws[k], 0.3);
        const double skins[] = {0.01, 0.05, 0.1, 0.8};
        for (int m = 0; m < 4; m++) {
            if (hash_of_fast(laws[k], skins[m]) != hash) {
                fail_msg("law %s: skin %g makes other bits", laws[k], skins[m]);
            }
        }
    }
}

/* Looking: samples, profiles, hashes, views at odd moments. */
static void test_looking(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        const golden *const g = &table[k];
        scene *const s = open_file(g->file, 1, "%s", g->overrides);
        for (long long step = 0; step < g->steps;) {
            const long long n = step % 5 == 0 ? 7 : 3;
            const long long left = g->steps - step;
            step_scene(s, n < left ? n : left);
            step += n < left ? n : left;
            ry_sim_sample(s->sim);
            ry_sim_profile(s->sim);
            if (step % 11 == 0) {
                ry_sim_hash(s->sim);
            }
        }
        const unsigned long long looked = ry_sim_hash(s->sim);
        close_scene(s);
        check_same("looking", k, 1, "", looked);
    }
}

/* The books come out the same, too, however often they are closed on the way. */
static uint64_t books_of(const golden *g, int threads, const char *more, int look)
{
    scene *const s = open_file(g->file, threads, "%s output.fields=energy %s", g->overrides, more);
    for (long long step = 0; step < g->steps; step++) {
        step_scene(s, 1);
        if (look > 0 && step % look == 0) {
            ry_sim_sample(s->sim);
        }
    }
    ry_sim_hash(s->sim);
    const uint64_t books = ry_state_checksum(&s->sim->state);
    close_scene(s);
    return books;
}

static void test_books(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        const uint64_t one = books_of(&table[k], 1, "", 0);
        assert_true(one == books_of(&table[k], 3, "", 0));
        assert_true(one == books_of(&table[k], 1, "numerics.skin=0.6", 1));
        assert_true(one == books_of(&table[k], 1, "numerics.skin=0.05", 17));
        assert_true(one == books_of(&table[k], 2, "numerics.order=shuffled", 3));
    }
}

/* A grain falls faster and faster, beside one that lies on the ground: from step 417 on, by more than its diameter
 * in a step. Ends at step 500. */
static const char falling[] = "time: {step: 20 us, end: 10 ms}\ndomain: {floor: flat, gravity: 6000}\n"
                              "output: {fields: [energy]}\ncontact: {stiffness: 1e4, restitution: 0.5}\n"
                              "particles:\n"
                              "  - {position: [0, 100], diameter: 1 mm, density: 2650}\n"
                              "  - {position: [0.1, 0.0006], diameter: 1 mm, density: 2650}\n";

/* What is kept of a run that has become unphysical is the state of the check before, contacts and books included. */
static void test_kept_state(void **state)
{
    (void)state;
    scene *const good = open_text(falling), *const bad = open_text(falling);
    ry_error error = {0};
    step_scene(good, 256);
    const unsigned long long hash = ry_sim_hash(good->sim);
    assert_int_equal(ry_sim_step(bad->sim, 600, &error), RY_UNPHYSICAL);
    assert_true(bad->sim->state.contacts.n > 0);
    assert_true(ry_sim_hash(bad->sim) == hash);
    assert_true(ry_state_checksum(&bad->sim->state) == ry_state_checksum(&good->sim->state));
    close_scene(good);
    close_scene(bad);
}

/* The steps since the last check are looked at, too, when a run ends. */
static void test_checked_at_end(void **state)
{
    (void)state;
    scene *const s = open_text(falling);
    const ry_run_options options = {.threads = 1};
    ry_run_result result;
    ry_error error = {0};
    step_scene(s, 256);
    assert_int_equal(ry_run(&s->config, &options, &result, &error), RY_UNPHYSICAL);
    assert_true(result.hash == ry_sim_hash(s->sim));
    close_scene(s);
}

/* The ledger changes nothing but itself: the grains go the same ways. */
static void test_ledger_is_neutral(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        scene *const with =
            open_file(table[k].file, 1, "%s output.fields=energy", table[k].overrides);
        scene *const without =
            open_file(table[k].file, 1, "%s output.fields=flux", table[k].overrides);
        step_scene(with, table[k].steps);
        step_scene(without, table[k].steps);
        const ry_view a = ry_sim_view(with->sim), b = ry_sim_view(without->sim);
        const size_t bytes = (size_t)a.n * sizeof *a.x;
        assert_memory_equal(a.x, b.x, bytes);
        assert_memory_equal(a.vz, b.vz, bytes);
        assert_memory_equal(a.spin, b.spin, bytes);
        close_scene(with);
        close_scene(without);
    }
}

/* ---- stopping and going on --------------------------------------------------------------------------- */

/* At any step: before the first, next to each other, after a rebuild, with another order in memory. */
static void test_going_on(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        const golden *const g = &table[k];
        const long long end = g->steps;
        const long long stops[] = {0, 1, 2, end / 7, end / 3, end / 2, end / 2 + 1, end - 1, end};
        scene *const s =
            open_file(g->file, 1, "%s%s", g->overrides, k % 2 ? " numerics.order=shuffled" : "");
        for (int m = 0; m < 9; m++) {
            step_scene(s, stops[m] - ry_sim_view(s->sim).step);
            save_and_forget(s, 1 + m % 3);
        }
        const unsigned long long parts = ry_sim_hash(s->sim);
        close_scene(s);
        check_same("going on", k, 1, "", parts);
    }
}

/* The same through ry_run and its files: stopped at whatever step the clock chooses. */
static int stop_now(void *data, long long step, long long last, double rate)
{
    (void)last;
    (void)rate;
    *(long long *)data = step;
    return 1;
}

static void same_files(const char *a, const char *b)
{
    char line[700];
    if (system("/usr/bin/python3 -c 'import h5py, numpy' 2>/dev/null") == 0) {
        snprintf(line, sizeof line, "/usr/bin/python3 -B '%s/tests/io_check.py' same '%s' '%s'", RY_SOURCE_DIR, a, b);
        assert_int_equal(system(line), 0);
    }
}

/* Returns at how many of the stops no frame was due. */
static int resume(const char *fields)
{
    ry_error error = {0};
    ry_config config;
    const char *const overrides[] = {"grains.columns=12", "grains.layers=6",   "time.settle=0.01",
                                     "time.end=4",        "fluid.shields=0.8", fields};
    assert_int_equal(
        ry_config_load(&config, RY_SOURCE_DIR "/params/flume.yaml", overrides, 6, &error), RY_OK);
    ry_run_result whole = {0}, part = {0};
    char straight_path[200];
    snprintf(straight_path, sizeof straight_path, "%s", in_folder("straight.h5"));
    const ry_run_options straight = {.output = straight_path, .threads = 1, .force = 1};
    assert_int_equal(ry_run(&config, &straight, &whole, &error), RY_OK);
    int stops = 0, between = 0;
    long long at = 0;
    ry_status status = RY_STOPPED;
    while (status == RY_STOPPED) {
        long long step = 0;
        const ry_run_options options = {.output = in_folder("run.h5"),
                                        .threads = 1 + stops % 3,
                                        .resume = stops > 0,
                                        .force = stops == 0,
                                        .progress = stops < 3 ? stop_now : NULL,
                                        .data = &step};
        status = ry_run(&config, &options, &part, &error);
        at += part.steps;
        stops += status == RY_STOPPED;
        between += status == RY_STOPPED && at % ry_config_derive(&config).steps_frame != 0;
    }
    assert_int_equal(status, RY_OK);
    printf("resumed %d times, %d of them within a frame\n", stops, between);
    same_files(straight_path, in_folder("run.h5"));
    ry_config_free(&config);
    assert_true(part.hash == whole.hash);
    assert_true(part.q_star == whole.q_star && part.samples == whole.samples);
    return between;
}

/* A run stops at once, with the sums of a profile that isn't finished. */
static void test_resume(void **state)
{
    (void)state;
    assert_in_range(resume("output.fields=[flux, profile, energy]"), 1, 3);
    assert_in_range(resume("output.fields=[flux, energy]"), 1, 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_golden),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_skin_and_order),
        cmocka_unit_test(test_parting),
        cmocka_unit_test(test_looking),
        cmocka_unit_test(test_books),
        cmocka_unit_test(test_kept_state),
        cmocka_unit_test(test_checked_at_end),
        cmocka_unit_test(test_ledger_is_neutral),
        cmocka_unit_test(test_going_on),
        cmocka_unit_test(test_resume),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
