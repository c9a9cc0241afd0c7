/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Copies of a bed side by side do what the bed does alone: no contact is lost over their ends. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "sim/sim.h"
#include "study/bench_tile.h"

enum { COLUMNS = 6, LAYERS = 4, TILES = 3, GRAINS = COLUMNS * LAYERS };

static ry_config make_config(int tiles)
{
    ry_config config = ry_config_default(1);
    config.grains_columns = COLUMNS * tiles;
    config.grains_layers = LAYERS;
    config.contact_law = RY_LAW_CUNDALL;
    config.contact_restitution = 0.5;
    config.fluid_model = RY_FLUID_NONE;
    config.time_settle = 0.0;
    config.output_fields = RY_FIELD_FLUX;
    assert_int_equal(ry_config_resolve(&config, NULL), RY_OK);
    return config;
}

static int32_t place_of(const ry_sim *sim, int32_t id)
{
    return sim->plan.pairs.place[id];
}

static void test_tiles_move_alike(void **unused)
{
    (void)unused;
    ry_config one = make_config(1), many = make_config(TILES);
    ry_state state = {0};
    ry_sim *const alone = ry_sim_create(&one, 1, NULL);
    assert_non_null(alone);
    assert_int_equal(ry_sim_step(alone, 2500, NULL), RY_OK); /* in touch, not yet at rest */
    assert_int_equal(ry_sim_collect(alone, NULL), RY_OK);
    const int64_t contacts = alone->state.contacts.n;
    assert_true(contacts > GRAINS);
    assert_int_equal(ry_bench_tile(&state, &alone->state, one.domain_length, TILES, NULL), RY_OK);
    assert_int_equal(state.contacts.n, TILES * contacts);
    assert_int_equal(state.grains.n, TILES * alone->state.grains.n);

    ry_sim *const together = ry_sim_adopt(&many, &state, 1, NULL);
    assert_non_null(together);
    assert_int_equal(ry_sim_step(alone, 200, NULL), RY_OK);
    assert_int_equal(ry_sim_step(together, 200, NULL), RY_OK);
    assert_int_equal(ry_sim_collect(alone, NULL), RY_OK);
    assert_int_equal(ry_sim_collect(together, NULL), RY_OK);
    assert_int_equal(together->state.contacts.n, TILES * alone->state.contacts.n);
    for (int tile = 0; tile < TILES; tile++) {
        for (int32_t id = 0; id < GRAINS; id++) {
            const int32_t k = place_of(alone, id), m = place_of(together, tile * GRAINS + id);
            const double x = alone->state.grains.x[k] + tile * one.domain_length;
            assert_true(fabs(together->state.grains.x[m] - x) < 1e-9 * one.grains_diameter);
            assert_true(fabs(together->state.grains.z[m] - alone->state.grains.z[k]) < 1e-9 * one.grains_diameter);
        }
    }
    ry_sim_free(together);
    ry_sim_free(alone);
    ry_config_free(&one);
    ry_config_free(&many);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_tiles_move_alike)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
