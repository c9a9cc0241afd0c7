/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The neighbour list against looking at every pair: random clouds with sizes 1 to 5, bounded and
 * periodic, down to domains of one cell across, listed by one to four threads, a second time when the
 * grains have moved. Overlaps at the start likewise. And that the skins come to where the work is least. */
#include "config/overlap.h"
#include "scene_bench.h"
#include "stage/skin.h"

typedef struct cloud {
    ry_state state;
    ry_neighbor neighbor;
    ry_pairs pairs;
} cloud;

static void list_pairs(cloud *c)
{
    ry_error error = {0};
    if (ry_neighbor_rebuild(&c->neighbor, &c->state.grains, &c->pairs, &error) != RY_OK) {
        fail_msg("%s", error.text);
    }
}

static void make_cloud(cloud *c, int n, int periodic, double length, double height, double largest,
                       double skin, int threads)
{
    ry_error error = {0};
    *c = (cloud){0};
    assert_int_equal(ry_state_create(&c->state, n, 0, 0, &error), RY_OK);
    ry_grains *const g = &c->state.grains;
    for (int k = 0; k < n; k++) {
        g->id[k] = (k * 7 + 3) % n; /* n is no multiple of 7 */
        g->radius[k] = 0.5 * evenly(0.2 * largest, largest);
        g->x[k] = evenly(0.0, length) + (periodic ? 0.0 : -0.5 * length);
        g->z[k] = evenly(-0.2 * height, height);
        g->fixed[k] = k % 5 == 0;
        g->density[k] = 1.0;
        g->vx[k] = evenly(-1.0, 1.0);
        g->vz[k] = evenly(-1.0, 1.0);
    }
    c->neighbor = (ry_neighbor){.length = length,
                                .periodic = periodic,
                                .skin_least = 0.1 * skin, .skin_most = 0.5 * skin, .horizon = 0.5 * skin,
                                .n_walls = 1,
                                .wall = {RY_WALL_FLOOR}};
    assert_int_equal(ry_neighbor_create(&c->neighbor, g, threads, &error), RY_OK);
    assert_int_equal(ry_pairs_create(&c->pairs, n, 1, RY_PAIRS_RESTS, &error), RY_OK);
    list_pairs(c);
}

/* To a tenth of the height: there are many more pairs. */
static void press_cloud(cloud *c)
{
    for (int k = 0; k < c->state.grains.n; k++) {
        c->state.grains.z[k] *= 0.1;
    }
    list_pairs(c);
}

static void free_cloud(cloud *c)
{
    ry_neighbor_free(&c->neighbor);
    ry_pairs_free(&c->pairs);
    ry_state_free(&c->state);
}

static double distance(const cloud *c, int i, int j)
{
    const ry_grains *const g = &c->state.grains;
    double dx = g->x[j] - g->x[i];
    if (c->neighbor.periodic) {
        dx -= c->neighbor.length * nearbyint(dx / c->neighbor.length);
    }
    return hypot(dx, g->z[j] - g->z[i]);
}

/* Slots of a pair, whichever owns it; the owner has the lower id. */
static int count_slots(const cloud *c, int i, int j)
{
    const ry_grains *const g = &c->state.grains;
    const int owner = g->id[i] < g->id[j] ? i : j, partner = owner == i ? j : i;
    int found = 0;
    for (int p = c->pairs.row[owner]; p < c->pairs.row[owner + 1]; p++) {
        assert_int_equal(c->pairs.i[p], owner);
        found += c->pairs.j[p] == partner;
    }
    return found;
}

/* The list takes a little more than the square of the way that may be gone, which is a single (24 bits). */
static double skin_of(const cloud *c, int i)
{
    return sqrt((double)c->neighbor.limit2[i] / 0.999);
}

/* A fast grain may go further, none further than it may at most. */
static void check_skin(const cloud *c, int i)
{
    const ry_neighbor *const b = &c->neighbor;
    const ry_grains *const g = &c->state.grains;
    const double way = fmin(b->skin_least + b->horizon * hypot(g->vx[i], g->vz[i]), b->skin_most);
    assert_true(fabs(skin_of(c, i) - way) <= 1e-7 * way && (double)b->limit2[i] <= way * way);
}

/* The slots in which a grain is the partner: all of them, by ascending owner. */
static void check_below(const cloud *c, int i)
{
    const ry_pairs *const pairs = &c->pairs;
    const int first = pairs->below_start[i], end = pairs->below_start[i + 1];
    int expected = 0;
    for (int p = 0; p < pairs->row[pairs->n_grains]; p++) {
        expected += pairs->j[p] == i;
    }
    assert_int_equal(end - first, expected);
    for (int b = first; b < end; b++) {
        assert_int_equal(pairs->j[pairs->below[b]], i);
        assert_true(b == first || c->state.grains.id[pairs->i[pairs->below[b]]] >
                                      c->state.grains.id[pairs->i[pairs->below[b - 1]]]);
    }
}

/* Every pair that could touch before the next rebuild is listed once; none is listed twice, none with
 * itself; the partners of an owner have ascending ids; two fixed grains need no slot. */
static void check_cloud(const cloud *c)
{
    const ry_grains *const g = &c->state.grains;
    for (int i = 0; i < g->n; i++) {
        for (int j = i + 1; j < g->n; j++) {
            const double gap = distance(c, i, j) - g->radius[i] - g->radius[j];
            const int slots = count_slots(c, i, j), both_fixed = g->fixed[i] && g->fixed[j];
            assert_true(slots <= 1);
            const double skins = skin_of(c, i) + skin_of(c, j);
            if (gap <= skins && !both_fixed && slots != 1) {
                fail_msg("grains %d and %d, %g apart with skins of %g, are not listed (length %g)",
                         i, j, gap, skins, c->neighbor.length);
            }
            const double rounding = 2.0 * c->neighbor.raster.margin + 1e-5 * (skins + g->radius[i] + g->radius[j]);
            if (gap > skins + rounding || both_fixed) {
                assert_int_equal(slots, 0);
            }
        }
        for (int p = c->pairs.row[i] + 1; p < c->pairs.row[i + 1]; p++) {
            assert_true(g->id[c->pairs.j[p]] > g->id[c->pairs.j[p - 1]]);
        }
        check_skin(c, i);
        check_below(c, i);
        const int32_t floor_slot = c->pairs.wall_slot[0][i];
        if (g->z[i] - g->radius[i] <= skin_of(c, i) && !g->fixed[i]) {
            assert_true(floor_slot >= c->pairs.n_inner && floor_slot < c->pairs.n);
            assert_int_equal(c->pairs.i[floor_slot], i);
        }
    }
}

static void test_against_all_pairs(void **state)
{
    (void)state;
    set_seed("neighbours", 21);
    for (int k = 0; k < 120; k++) {
        const int periodic = k % 2, n = 20 + (k * 13) % 180;
        const double largest = 1.0, skin = evenly_log(0.01, 1.0);
        /* the smallest domain in which no grain meets another twice, up to many cells */
        const double least = 2.0 * (largest + skin),
                     length = k % 3 == 0 ? least * evenly(1.0, 2.5) : evenly(8.0, 40.0);
        cloud c;
        make_cloud(&c, n % 7 == 0 ? n + 1 : n, periodic, length, evenly(0.5, 20.0), largest, skin, 1 + k % 4);
        check_cloud(&c);
        press_cloud(&c);
        check_cloud(&c);
        free_cloud(&c);
    }
}

/* A grain that has gone astray, or is nowhere, spoils nothing for the others. */
static void test_astray(void **state)
{
    (void)state;
    const double places[] = {1e5, -1e30, 1e300, INFINITY, NAN};
    set_seed("astray", 22);
    for (int k = 0; k < 10; k++) {
        cloud c;
        make_cloud(&c, 100, k % 2, 12.0, 6.0, 1.0, 0.3, 1);
        const int before = c.pairs.row[100];
        c.state.grains.z[7] = places[k / 2];
        list_pairs(&c);
        check_cloud(&c);
        assert_true(c.pairs.row[8] == c.pairs.row[7] && c.pairs.below_start[8] == c.pairs.below_start[7]);
        assert_in_range(c.pairs.row[100], before - 20, before + 5);
        free_cloud(&c);
    }
}

/* Many have gone astray, as in a run that breaks down between two checks, by whole lengths of the domain and more: whom
 * one has for a partner has it, too. */
static void test_many_astray(void **state)
{
    (void)state;
    const double far[] = {13.0, -0.5, 40.0, -1e4, 1e9, -1e30, 1e300, INFINITY, NAN, 24.0};
    set_seed("many astray", 23);
    for (int k = 0; k < 200; k++) {
        cloud c;
        make_cloud(&c, 100, k % 2, 12.0, 6.0, 1.0, evenly(0.1, 2.0), 1 + k % 3);
        ry_grains *const g = &c.state.grains;
        for (int i = 0; i < 40; i++) {
            *(i % 3 == 0 ? &g->z[i] : &g->x[i]) = far[(int)evenly(0.0, 10.0)] + evenly(0.0, 1.0);
            g->vx[i] *= i % 5 == 0 ? 1e6 : 1.0;
        }
        list_pairs(&c);
        list_pairs(&c); /* with a memory of the one before */
        for (int i = 0; i < g->n; i++) {
            check_below(&c, i);
            for (int j = 0; j < i; j++) {
                assert_true(count_slots(&c, i, j) <= 1);
            }
        }
        free_cloud(&c);
    }
}

/* Pairs of a grain, of which those of moving grains grow with the area around them, at a horizon of so many steps. */
static double pairs_at(double still, double moving, double steps)
{
    return still + moving * (1.0 + steps / 40.0) * (1.0 + steps / 40.0);
}

/* The work of a step for a grain: looking at its pairs, and its part of a list, 22 pairs. */
static double work_at(double still, double moving, double steps)
{
    return pairs_at(still, moving, steps) + 22.0 / steps;
}

/* A list serves as many steps as the horizon has: it comes to the least work, or to its bounds, and stays. */
static void test_skins(void **state)
{
    (void)state;
    const double moving[] = {0.0, 0.02, 0.1, 0.4, 3.0};
    for (size_t m = 0; m < sizeof moving / sizeof *moving; m++) {
        ry_neighbor b = {0};
        ry_pairs pairs = {.n_grains = 1000000};
        ry_skin_begin(&b, 1.0, 1.0, INFINITY);
        double best = 10.0, step = 0.0;
        for (double steps = 10.0; steps <= 160.0; steps *= 1.01) {
            best = work_at(2.0, moving[m], steps) < work_at(2.0, moving[m], best) ? steps : best;
        }
        for (int list = 0; list < 400; list++) {
            assert_true(b.horizon >= 10.0 && b.horizon <= 160.0);
            assert_true(list < 200 || (b.horizon < best * 1.6 && b.horizon > best / 1.6));
            pairs.n = (int32_t)(1e6 * pairs_at(2.0, moving[m], b.horizon));
            step += b.horizon;
            b.rebuilds++;
            ry_skin_tune(&b, &pairs, (int64_t)step);
        }
    }
}

/* --- overlaps at the start ------------------------------------------------------------------------ */

static double depth(const ry_disc *a, const ry_disc *b, double length)
{
    const double across = length > 0.0 ? remainder(a->x - b->x, length) : a->x - b->x;
    return a->radius + b->radius - hypot(across, a->z - b->z);
}

static int overlap(const ry_disc *a, const ry_disc *b, double length)
{
    return !(a->fixed && b->fixed) && depth(a, b, length) > RY_MOST_OVERLAP * 2.0 * fmin(a->radius, b->radius);
}

/* Of clouds in which a pair or none overlaps: found is one that does, or none where there is none. */
static void test_overlaps(void **state)
{
    (void)state;
    enum { DISCS = 40 };
    int having = 0;
    for (int turn = 0; turn < 4000; turn++) {
        ry_disc disc[DISCS];
        const double length = turn % 2 ? 30.0 : 0.0;
        const int between = turn % 3 ? 0 : DISCS / 2;
        for (int k = 0; k < DISCS; k++) {
            disc[k] = (ry_disc){evenly(0.0, 30.0), evenly(-15.0, 15.0), evenly(0.02, 0.4), k % 5 == 0};
        }
        disc[turn % DISCS].radius = 1.5;
        int any = 0;
        for (int k = 0; k < DISCS * DISCS; k++) {
            const int a = k / DISCS, b = k % DISCS;
            const int looked_at = a < b && (between == 0 || (a < between && b >= between));
            any += looked_at && overlap(&disc[a], &disc[b], length);
        }
        ry_overlap found;
        ry_error error = {0};
        assert_int_equal(ry_overlap_find(disc, DISCS, between, length, &found, &error), RY_OK);
        assert_int_equal(found.first >= 0, any > 0);
        assert_true(any == 0 || fabs(found.depth - depth(&disc[found.first], &disc[found.second], length)) < 1e-12);
        having += any > 0;
    }
    assert_true(having > 1000 && having < 3000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_skins),
        cmocka_unit_test(test_against_all_pairs),
        cmocka_unit_test(test_astray),
        cmocka_unit_test(test_many_astray),
        cmocka_unit_test(test_overlaps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
