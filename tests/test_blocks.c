/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Beds so long that a step goes through them block by block: the same bits as where each pass waits for the one
 * before, for any number of threads and any order in memory. */
#include "scene_bench.h"
#include "sim/sim.h"

/* Grains that fall, settle and flow; 4 200, and so many that slots lie in a ring. */
#define FLOW "time.settle=0.004 fluid.shields=0.8"
#define BED "grains.columns=300 grains.layers=14 " FLOW
#define LONG_BED "grains.columns=1300 grains.layers=14 " FLOW
enum { STEPS = 400, STEPS_OF_LONG = 80 };

static const char *const laws[] = {
    BED " output.fields=[flux] contact.law=cundall contact.alpha_cn=0.1",
    BED " output.fields=[flux]",
    BED,
    BED " contact.law=tanaka contact.wet=true",
    BED " output.fields=[energy] contact.law=fujioka-2",
};
enum { LAWS = sizeof laws / sizeof *laws };

/* What became of the bed; the ledger is in the checksum. */
static uint64_t run_steps(int steps, const char *law, int threads, const char *more, double *inner, int *rings)
{
    scene *const s = open_file("flume.yaml", threads, "%s %s", law, more);
    step_scene(s, steps);
    const ry_blocks *const b = &s->sim->plan.blocks;
    const ry_pairs *const pairs = &s->sim->plan.pairs;
    int due = 0;
    *rings = 0;
    for (int32_t k = 0; k < b->n; k++) {
        due += b->due[b->n_passes][k] != RY_LATE;
    }
    for (int t = 0; t < threads; t++) {
        *rings += pairs->shelf[t].mask > 0;
    }
    *inner = (double)due / b->n;
    ry_sim_hash(s->sim); /* collects the contacts, closes the books */
    const uint64_t sum = ry_state_checksum(&s->sim->state);
    close_scene(s);
    return sum;
}

static uint64_t run(const char *law, int threads, const char *more, double *inner, int *rings)
{
    return run_steps(STEPS, law, threads, more, inner, rings);
}

static void check_same(const char *law, int threads, uint64_t sum, uint64_t as)
{
    if (sum != as) {
        fail_msg("%s: %d threads: 0x%016llx, not 0x%016llx", law, threads, (unsigned long long)sum,
                 (unsigned long long)as);
    }
}

/* Most blocks are through before the list is; with grains in any order none is. */
static void test_same_bits(void **state)
{
    (void)state;
    const int threads[] = {1, 2, 3};
    for (int l = 0; l < LAWS; l++) {
        double inner;
        int rings;
        const uint64_t apart = run(laws[l], 1, "numerics.order=shuffled", &inner, &rings);
        assert_true(inner == 0.0);
        assert_int_equal(rings, 0);
        for (int t = 0; t < 3; t++) {
            const uint64_t sum = run(laws[l], threads[t], "", &inner, &rings);
            check_same(laws[l], threads[t], sum, apart);
            assert_true(inner > 0.2 || threads[t] > 1);
        }
    }
}

static void test_rings(void **state)
{
    (void)state;
    const char *const beds[] = {LONG_BED " output.fields=[flux] contact.law=cundall contact.alpha_cn=0.1", LONG_BED};
    for (int k = 0; k < 2; k++) {
        double inner;
        int rings;
        const uint64_t apart = run_steps(STEPS_OF_LONG, beds[k], 2, "numerics.order=shuffled", &inner, &rings);
        assert_int_equal(rings, 0);
        check_same(beds[k], 1, run_steps(STEPS_OF_LONG, beds[k], 1, "", &inner, &rings), apart);
        assert_true(inner > 0.7);
        assert_int_equal(rings, 1);
    }
}

/* With more threads than blocks, and blocks of many chunks that are late throughout. */
static void test_many_threads(void **state)
{
    (void)state;
    double inner;
    int rings;
    const char *const small = "grains.columns=30 grains.layers=5 time.settle=0.004 fluid.shields=0.8";
    const uint64_t one = run(small, 1, "", &inner, &rings);
    assert_true(run(small, 2, "", &inner, &rings) == one);
    assert_true(run(small, 16, "", &inner, &rings) == one);
}

/* How many grains lie more than two columns from the one before them in memory. */
static int astray(const ry_sim *sim)
{
    const ry_grains *const g = &sim->state.grains;
    int n = 0;
    for (int32_t k = 1; k < g->n; k++) {
        n += fabs(g->x[k] - g->x[k - 1]) > 2.0 * sim->plan.derived.d;
    }
    return n;
}

/* A long bed whose grains have flowed far is put in order while it runs: here one in any order, as if it had. All that
 * stands in storage order goes along: the ledger, profiles that are being taken, contacts. */
static void test_put_in_order(void **state)
{
    (void)state;
    for (int l = 0; l < LAWS; l++) {
        scene *const kept = open_file("flume.yaml", 1, "%s", laws[l]);
        scene *const moved = open_file("flume.yaml", 2, "%s numerics.order=shuffled", laws[l]);
        ry_plan *const plan = &moved->sim->plan;
        for (int k = 0; k < 4; k++) {
            step_scene(kept, STEPS / 4 + 7);
            step_scene(moved, STEPS / 4 + 7);
            assert_true((k < 2) == (astray(moved->sim) > 1000));
            plan->keeps_order = plan->contact.large = k == 1;
            plan->ordered_at = -1000;
            ry_sim_profile(kept->sim);
            ry_sim_profile(moved->sim);
        }
        assert_true(ry_sim_hash(kept->sim) == ry_sim_hash(moved->sim));
        assert_true(ry_state_checksum(&kept->sim->state) == ry_state_checksum(&moved->sim->state));
        const ry_measure *const a = &kept->sim->plan.measure, *const b = &plan->measure;
        assert_int_equal(a->nz, b->nz);
        if (a->nz > 0) {
            assert_memory_equal(a->tau_grain, b->tau_grain, (size_t)a->nz * sizeof(double));
        }
        close_scene(kept);
        close_scene(moved);
    }
}

/* Walls and sleepers wait for all. */
static void test_apart(void **state)
{
    (void)state;
    double inner;
    int rings;
    const char *const cases[] = {"domain.periodic=false domain.walls=true", "contact.sleep=1"};
    for (int k = 0; k < 2; k++) {
        const uint64_t one = run(laws[1], 1, cases[k], &inner, &rings);
        assert_true(inner == 0.0);
        assert_true(run(laws[1], 3, cases[k], &inner, &rings) == one);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_rings),
        cmocka_unit_test(test_many_threads),
        cmocka_unit_test(test_put_in_order),
        cmocka_unit_test(test_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
