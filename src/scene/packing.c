/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "scene/packing.h"

#include "base/random.h"

/* A random packing starts loose, 1.3 largest diameters apart with a play of 0.15 in both directions,
 * and packs itself while it settles. */
#define LOOSE_PITCH 1.3
#define LOOSE_PLAY 0.15
/* Touching neighbours of the largest size must not overlap by rounding. */
#define CLEARANCE (1.0 + 1e-12)

ry_places ry_packing_plan(const ry_config *config, double length)
{
    const double d = config->grains_diameter;
    const double largest = d * (1.0 + config->grains_spread);
    const int hexagonal = config->grains_packing == RY_PACKING_HEXAGONAL;
    const int loose = config->grains_packing == RY_PACKING_RANDOM;
    const double wanted = loose ? LOOSE_PITCH * largest : largest;
    ry_places p = {.n = (int64_t)config->grains_columns * config->grains_layers,
                   .seed = (uint32_t)config->grains_seed};
    const double fit = floor(length / wanted + 1e-9);
    p.columns = fit > 1.0 ? (int64_t)fit : 1;
    if (p.columns > p.n) {
        p.columns = p.n;
    }
    const int stacked = p.columns == 1 && !config->domain_periodic; /* there may be walls, and are no gaps to lie in */
    p.pitch_x = stacked ? length : fmax(length / (double)p.columns, wanted * CLEARANCE);
    p.shift = hexagonal && !stacked ? 0.5 * p.pitch_x : 0.0;
    p.odd_columns = hexagonal && !config->domain_periodic && p.columns > 1 ? p.columns - 1 : p.columns;
    /* a grain of an odd row lies in the gap of the row below: no nearer than the largest diameter */
    const double reach = wanted * CLEARANCE;
    const double rise2 = reach * reach - p.shift * p.shift;
    const double half2 = 0.25 * reach * reach; /* rows two apart must clear each other as well */
    p.pitch_z = hexagonal ? sqrt(fmax(rise2, half2)) : reach;
    p.play = loose ? LOOSE_PLAY * largest : 0.0;
    p.play = stacked ? fmax(fmin(p.play, 0.5 * (length - largest)), 0.0) : p.play;
    p.base = config->domain_floor == RY_FLOOR_ROUGH ? 0.5 * (d + largest) * CLEARANCE + p.play
                                                    : 0.5 * largest + p.play;
    const int64_t two_rows = p.columns + p.odd_columns;
    const int64_t left = p.n % two_rows;
    p.rows = 2 * (p.n / two_rows) + (left > 0) + (left > p.columns);
    return p;
}

/* Is there a grain at this place? The rows are filled from the floor up, each from the left. */
static int is_filled(const ry_places *p, int64_t column, int64_t row)
{
    const int64_t width = row % 2 == 1 ? p->odd_columns : p->columns;
    const int64_t below = row / 2 * (p->columns + p->odd_columns) + (row % 2 == 1 ? p->columns : 0);
    return column < width && below + column < p->n;
}

static ry_placed place(const ry_config *config, const ry_places *p, int64_t column, int64_t row,
                       uint64_t index)
{
    const double off = 2.0 * ry_random(p->seed, RY_RANDOM_DIAMETER, index) - 1.0;
    const double play_x = 2.0 * ry_random(p->seed, RY_RANDOM_PLACE_X, index) - 1.0;
    const double play_z = 2.0 * ry_random(p->seed, RY_RANDOM_PLACE_Z, index) - 1.0;
    ry_placed grain;
    grain.diameter = config->grains_diameter * (1.0 + config->grains_spread * off);
    grain.x = ((double)column + 0.5) * p->pitch_x + (row % 2 == 1 ? p->shift : 0.0) + p->play * play_x;
    grain.z = p->base + (double)row * p->pitch_z + p->play * play_z;
    return grain;
}

void ry_packing_fill(const ry_config *config, const ry_places *p, ry_placed *out)
{
    int64_t k = 0;
    for (int64_t column = 0; column < p->columns; column++) {
        for (int64_t row = 0; row < p->rows; row++) {
            if (is_filled(p, column, row)) {
                out[k] = place(config, p, column, row, (uint64_t)k);
                k++;
            }
        }
    }
}
