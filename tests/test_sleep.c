/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * contact.sleep: the same bits whatever may not matter, with sleeping on; who sleeps and who wakes. */
#include "save_bench.h"
#include "sleep_bench.h"

/* ---- bits ---------------------------------------------------------------------------------------- */

/* Scenes in which many sleep and many wake. */
typedef struct sample_scene {
    const char *file, *overrides;
    long long steps;
} sample_scene;
static const sample_scene scenes[] = {
    {"flume.yaml", "grains.columns=10 grains.layers=14 time.settle=0.08 fluid.start=rest fluid.shields=0.6 "
                   "contact.sleep=0.5", 9000},
    {"flume.yaml", "grains.columns=10 grains.layers=14 time.settle=0.06 fluid.model=stress fluid.shields=0.2 "
                   "contact.sleep=0.5 contact.wet=true domain.periodic=false domain.walls=true", 9000},
    {"flume.yaml", "grains.columns=10 grains.layers=14 time.settle=0.06 fluid.model=log fluid.lift=0.2 "
                   "fluid.shields=0.2 contact.sleep=0.5 contact.law=tanaka output.fields=[energy,profile]", 10000},
    {"flume.yaml", "grains.columns=10 grains.layers=14 time.settle=0.06 fluid.shields=0.3 fluid.turbulence=walk "
                   "contact.sleep=0.5", 9000},
};
enum { SCENES = sizeof scenes / sizeof *scenes };

static scene *open_sample(int k, int threads, const char *more)
{
    return open_file(scenes[k].file, threads, "%s %s", scenes[k].overrides, more);
}

/* With the ledger, where there is one. */
static unsigned long long hash_now(const scene *s)
{
    assert_int_equal(ry_sim_collect(s->sim, NULL), RY_OK);
    return ry_state_checksum(&s->sim->state);
}

static unsigned long long hash_of(int k, int threads, const char *more)
{
    scene *const s = open_sample(k, threads, more);
    step_scene(s, scenes[k].steps);
    const unsigned long long hash = hash_now(s);
    close_scene(s);
    return hash;
}

/* Else the tests of bits would show nothing. */
static void test_scenes_sleep_and_wake(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        scene *const s = open_sample(k, 1, "");
        int fell = 0, woke = 0, before = s->sim->plan.motion.n_awake;
        while (ry_sim_view(s->sim).step < scenes[k].steps) {
            step_scene(s, 1);
            fell += s->sim->plan.motion.n_awake < before;
            woke += s->sim->plan.motion.n_awake > before;
            before = s->sim->plan.motion.n_awake;
        }
        printf("scene %d: sets formed anew by sleep %d, by waking %d times; asleep in the mean %.2f\n", k, fell, woke,
               s->sim->plan.sleep.slept / (double)s->sim->plan.sleep.steps);
        assert_true(fell >= 2 && woke >= 3);
        close_scene(s);
    }
}

static void test_what_may_not_matter(void **state)
{
    (void)state;
    static const struct {
        int threads;
        const char *more;
    } ways[] = {{2, ""}, {3, "numerics.skin=0.5"}, {1, "numerics.skin=0.05"}, {1, "numerics.order=bed"},
                {1, "numerics.order=shuffled numerics.skin=0.12"}};
    for (int k = 0; k < SCENES; k++) {
        const unsigned long long one = hash_of(k, 1, "");
        for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
            const unsigned long long other = hash_of(k, ways[w].threads, ways[w].more);
            if (other != one) {
                fail_msg("scene %d, %d threads %s: 0x%016llx, not 0x%016llx", k, ways[w].threads, ways[w].more, other,
                         one);
            }
        }
    }
}

static int sleeps(const scene *s, int id)
{
    return s->sim->state.sleepers.asleep[s->sim->plan.pairs.place[id]];
}

/* Steps once; 1: some have woken in it and others have fallen asleep. */
static int step_over(scene *s)
{
    uint8_t slept[200];
    const int n = s->sim->state.grains.n;
    int fell = 0, woke = 0;
    assert_true(n <= 200);
    for (int id = 0; id < n; id++) {
        slept[id] = (uint8_t)sleeps(s, id);
    }
    step_scene(s, 1);
    for (int id = 0; id < n; id++) {
        fell += sleeps(s, id) && !slept[id];
        woke += !sleeps(s, id) && slept[id];
    }
    return fell > 0 && woke > 0;
}

/* The flow becomes strong in the very step of a look: some wake in it while others fall asleep. */
static unsigned long long hash_of_gust(int look, int seed, const char *skin, int *both)
{
    scene *const s = open_file("flume.yaml", 1, "grains.columns=10 grains.layers=14 time.settle=0.02 fluid.model=stress "
                               "grains.spread=0.2 grains.seed=%d fluid.advance=1 fluid.shields=0.001 contact.sleep=0.2 "
                               "numerics.skin=%s", seed, skin);
    step_scene(s, look * s->sim->plan.sleep.look_every - 1);
    ry_sim_set_stress(s->sim, 600.0 * s->sim->plan.derived.shear_stress);
    *both += step_over(s);
    step_scene(s, 1000);
    const unsigned long long hash = hash_now(s);
    close_scene(s);
    return hash;
}

/* Few beds do both at once: they are looked for. */
static void test_gusts(void **state)
{
    (void)state;
    int found = 0;
    for (int bed = 0; found < 2 && bed < 60; bed++) {
        const int look = 3 + bed / 6, seed = 1 + bed % 6;
        int both = 0;
        const unsigned long long one = hash_of_gust(look, seed, "0.1", &both);
        if (both) {
            found++;
            const unsigned long long other = hash_of_gust(look, seed, "0.6", &both);
            if (one != other || both != 2) {
                fail_msg("look %d, seed %d: 0x%016llx and 0x%016llx with two skins", look, seed, one, other);
            }
        }
    }
    assert_int_equal(found, 2);
}

static void test_looking(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        scene *const s = open_sample(k, 1, "");
        for (long long step = 0, n; step < scenes[k].steps; step += n) {
            n = step % 5 == 0 ? 7 : 3;
            n = n < scenes[k].steps - step ? n : scenes[k].steps - step;
            step_scene(s, n);
            ry_sim_sample(s->sim);
            ry_sim_profile(s->sim);
            if (step % 11 == 0) {
                ry_sim_hash(s->sim);
            }
        }
        const unsigned long long looked = hash_now(s);
        close_scene(s);
        assert_true(looked == hash_of(k, 1, ""));
    }
}

/* Measuring or not: the grains go the same ways. */
static void test_measuring(void **state)
{
    (void)state;
    scene *const all = open_sample(0, 1, "output.fields=[position,flux,energy,profile]");
    scene *const flux = open_sample(0, 1, "output.fields=[flux]");
    step_scene(all, scenes[0].steps);
    step_scene(flux, scenes[0].steps);
    assert_true(ry_sim_hash(all->sim) == ry_sim_hash(flux->sim));
    close_scene(all);
    close_scene(flux);
}

/* Steps between looks at who rests. */
static long long look_every(int k)
{
    scene *const s = open_sample(k, 1, "");
    const long long every = s->sim->plan.sleep.look_every;
    close_scene(s);
    return every;
}

/* Before and after looks, between advances of the fluid, at once after a wake. */
static void test_going_on(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        const long long end = scenes[k].steps;
        const long long look = look_every(k);
        const long long stops[] = {0, 1, 2 * look - 1, 2 * look, end / 3, end / 2, end / 2 + 13, end / 2 + 14, end - 1};
        scene *const s = open_sample(k, 1, k % 2 ? "numerics.order=shuffled" : "");
        for (int m = 0; m < 9; m++) {
            step_scene(s, stops[m] - ry_sim_view(s->sim).step);
            save_and_forget(s, 1 + m % 3);
        }
        for (int times = 0; ry_sim_view(s->sim).step < end;) {
            const int before = s->sim->plan.motion.n_awake;
            step_scene(s, 1);
            if (s->sim->plan.motion.n_awake != before && times++ < 20) {
                save_and_forget(s, 1);
            }
        }
        const unsigned long long parts = hash_now(s);
        close_scene(s);
        assert_true(parts == hash_of(k, 1, ""));
    }
}

/* ---- who sleeps and who wakes -------------------------------------------------------------------- */

static void test_bad_values(void **state)
{
    (void)state;
    const char *const bad[] = {"contact.sleep=-0.1", "contact.sleep=11", "contact.sleep=1 mm", "contact.sleep=nan"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        ry_config config;
        ry_error error = {0};
        assert_int_equal(ry_config_load(&config, RY_SOURCE_DIR "/params/flume.yaml", &bad[k], 1, &error),
                         RY_BAD_INPUT);
        assert_non_null(strstr(error.text, "contact.sleep"));
    }
}

/* Without sleep there is no stage and no array of it. */
static void test_off(void **state)
{
    (void)state;
    scene *const s = open_file("flume.yaml", 1, "time.end=1");
    for (int k = 0; k < s->sim->plan.n_stages; k++) {
        assert_string_not_equal(s->sim->plan.stage[k].name, "sleep");
    }
    assert_null(s->sim->state.sleepers.asleep);
    assert_null(s->sim->plan.sleep.watch);
    close_scene(s);
}

static int listed(const scene *s)
{
    const ry_pairs *const pairs = &s->sim->plan.pairs;
    return pairs->row[pairs->n_grains];
}

/* A bed at rest sleeps as a whole, and then nobody looks at its pairs; its contacts are not forgotten. */
static void test_bed_falls_asleep(void **state)
{
    (void)state;
    const char *const bed = "grains.columns=16 grains.layers=10 fluid.model=none output.fields=[energy]";
    scene *const sleeping = open_file("flume.yaml", 1, "%s contact.sleep=0.5", bed);
    scene *const wakeful = open_file("flume.yaml", 1, "%s", bed);
    run_until(sleeping, 0.3);
    run_until(wakeful, 0.3);
    assert_true(asleep(sleeping) > 0.95);
    assert_true(listed(sleeping) < 0.1 * listed(wakeful));
    const ry_sample a = ry_sim_sample(sleeping->sim), b = ry_sim_sample(wakeful->sim);
    assert_int_equal(ry_sim_collect(sleeping->sim, NULL), RY_OK);
    assert_int_equal(ry_sim_collect(wakeful->sim, NULL), RY_OK);
    const double contacts = (double)wakeful->sim->state.contacts.n;
    /* the same bed, but for what it still creeps and trembles: a contact or two open and close */
    assert_true(fabs((double)sleeping->sim->state.contacts.n - contacts) < 0.03 * contacts);
    assert_true(fabs(a.gravity_energy / b.gravity_energy - 1.0) < 1e-3);
    assert_true(fabs(a.elastic_normal / b.elastic_normal - 1.0) < 0.1);
    assert_true(a.kinetic_energy <= b.kinetic_energy);
    close_scene(sleeping);
    close_scene(wakeful);
}

/* The flow sets in over a bed that sleeps; or becomes stronger, by ry_sim_set_stress. */
static void test_flow_wakes(void **state)
{
    (void)state;
    for (int grows = 0; grows < 2; grows++) {
        scene *const s = open_file("flume.yaml", 1, "grains.columns=16 grains.layers=10 time.settle=%s fluid.start=rest "
                                   "fluid.shields=%s contact.sleep=1", grows ? "0.02" : "0.25", grows ? "0.01" : "0.5");
        run_until(s, 0.25);
        assert_true(asleep(s) > 0.95);
        assert_true(ry_sim_sample(s->sim).q_star < 0.01);
        if (grows) {
            ry_sim_set_stress(s->sim, 50.0 * s->sim->plan.derived.shear_stress);
        }
        run_until(s, 0.5);
        assert_true(asleep(s) < 0.9);
        assert_true(ry_sim_sample(s->sim).q_star > 0.1);
        close_scene(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes_sleep_and_wake), cmocka_unit_test(test_what_may_not_matter),
        cmocka_unit_test(test_gusts), cmocka_unit_test(test_looking), cmocka_unit_test(test_measuring),
        cmocka_unit_test(test_going_on), cmocka_unit_test(test_bad_values), cmocka_unit_test(test_off),
        cmocka_unit_test(test_bed_falls_asleep), cmocka_unit_test(test_flow_wakes),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
