/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Memory that runs out, at each place in its turn: a simulation says so, and can still be asked and freed. */
#include "scene_bench.h"
#include "sim/sim.h"

static long left = -1; /* arrays that are still given; -1: all */
static long given;

/* In place of that of the system. */
void *aligned_alloc(size_t alignment, size_t size)
{
    void *array = NULL;
    given++;
    if (left == 0) {
        return NULL;
    }
    left -= left > 0;
    return posix_memalign(&array, alignment, size) == 0 ? array : NULL;
}

/* A loose bed falls together: its list grows. */
#define FALLING                                                                                             \
    "time: {step: 20 us, end: 1}\ngrains: {columns: 30, layers: 10, diameter: 0.5 mm, packing: random}\n" \
    "contact: {law: energy, sleep: %d}\nfluid: {model: %s}\noutput: {fields: %s}\nnumerics: {skin: 0.3}\n"
enum { STEPS = 1000 };

static scene *open_falling(int variant, int threads)
{
    const int sleeps[] = {0, 0, 1};
    const char *const fluid[] = {"none", "balance", "balance"};
    const char *const fields[] = {"[flux]", "[energy, profile]", "[energy, profile]"};
    char text[1000];
    ry_error error = {0};
    scene *const s = calloc(1, sizeof *s);
    snprintf(text, sizeof text, FALLING, sleeps[variant], fluid[variant], fields[variant]);
    return start_scene(s, ry_config_parse(&s->config, text, "scene", NULL, 0, &error), threads, &error);
}

/* After so many more arrays there is no memory. Returns whether that was too early for all the steps. */
static int run_short(int variant, int threads, long arrays, unsigned long long as)
{
    ry_error error = {0}, later = {0};
    scene *const s = open_falling(variant, threads);
    left = arrays;
    const ry_status status = ry_sim_step(s->sim, STEPS, &error);
    left = -1;
    const unsigned long long hash = ry_sim_hash(s->sim);
    (void)ry_sim_sample(s->sim);
    ry_sim_profile(s->sim);
    assert_int_equal(ry_sim_view(s->sim).n, s->sim->state.grains.n);
    if (status == RY_OK) {
        assert_true(hash == as);
    } else {
        assert_int_equal(status, RY_BAD_FILE);
        assert_non_null(strstr(error.text, "out of memory"));
        (void)ry_sim_step(s->sim, 1, &later); /* what it answers depends on who lacked memory */
    }
    close_scene(s);
    return status != RY_OK;
}

static void test_short_of_memory(void **state)
{
    (void)state;
    for (int variant = 0; variant < 3; variant++) {
        scene *const s = open_falling(variant, 1);
        const long before = given;
        ry_error error = {0};
        assert_int_equal(ry_sim_step(s->sim, STEPS, &error), RY_OK);
        const long all = given - before;
        const unsigned long long hash = ry_sim_hash(s->sim);
        close_scene(s);
        assert_true(all > 0);
        for (long k = 0; k < all; k += 1 + all / 16) {
            run_short(variant, 1 + (int)(k % 2), k, hash);
        }
        assert_false(run_short(variant, 1, all, hash));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_short_of_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
