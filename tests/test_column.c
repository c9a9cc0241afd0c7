/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The fluid column of model `balance`, in water, oil and air: where it comes to does not depend on how often it
 * advances, and what drives it is what the grains and the floor take. */
#include "scene_bench.h"
#include "sim/sim.h"

typedef struct fluid {
    const char *name, *text;
    int seldom; /* an advance in so many steps */
} fluid;

static const fluid fluids[] = {
    {"water", "density: 1000, viscosity: 1e-6", 200},
    {"oil", "density: 900, viscosity: 1e-3", 200},
    {"air", "density: 1.2, viscosity: 1.5e-5", 20},
};
enum { FLUIDS = sizeof fluids / sizeof *fluids };

/* Rows of grains that don't touch. */
enum { COLUMNS = 6, LAYERS = 4 };
#define LENGTH 3.3e-3

static scene *open_rows(const fluid *f, const char *mixing, int advance, int fixed)
{
    char grains[4000];
    int at = 0;
    for (int k = 0; k < COLUMNS * LAYERS; k++) {
        at += snprintf(grains + at, sizeof grains - (size_t)at, "  - {position: [%g, %g], diameter: 0.5 mm, fixed: %s}\n",
                       (0.5 + k % COLUMNS) * LENGTH / COLUMNS, (0.5 + k / COLUMNS) * LENGTH / COLUMNS,
                       fixed ? "true" : "false");
    }
    return open_scene("domain: {length: %g, periodic: true, floor: none, gravity: 0}\n"
                      "fluid: {model: balance, start: rest, shear_stress: 3 Pa, mixing_length: %s, advance: %d, %s}\n"
                      "time: {step: 20 us, end: 10, settle: 0}\nparticles:\n%s", LENGTH, mixing, advance,
                      f->text, grains);
}

/* ---- past grains that do not move -------------------------------------------------------------------- */

static double furthest_off(const ry_column *a, const ry_column *b)
{
    double off = 0.0, most = 0.0;
    for (int k = 0; k < a->nz; k++) {
        off = fmax(off, fabs(a->u[k] - b->u[k]));
        most = fmax(most, fabs(a->u[k]));
    }
    return off / most;
}

/* The flow in the end is the same whether the column advances in each step or seldom. */
static void test_where_it_comes_to(void **state)
{
    (void)state;
    const char *const mixing[] = {"li-sawamoto", "duran", "duran-moving"};
    for (int k = 0; k < 3 * FLUIDS; k++) {
        const fluid *const f = &fluids[k / 3];
        scene *const often = open_rows(f, mixing[k % 3], 1, 1);
        run_until(often, 1.0);
        const int advances[] = {5, f->seldom};
        for (int a = 0; a < 2; a++) {
            scene *const s = open_rows(f, mixing[k % 3], advances[a], 1);
            run_until(s, 1.0);
            const double off = furthest_off(&often->sim->state.column, &s->sim->state.column);
            printf("%s, %s, advance %d: u is off by %.1e of its largest\n", f->name, mixing[k % 3], advances[a], off);
            assert_true(off < 1e-10);
            close_scene(s);
        }
        close_scene(often);
    }
}

/* ---- with grains that go along ------------------------------------------------------------------------ */

/* Momentum of fluid, grains and what they carry along (added mass), along x [N s]. */
static double momentum_of(const scene *s)
{
    const ry_column *const c = &s->sim->state.column;
    const ry_flow *const f = &s->sim->plan.flow;
    const ry_grains *const g = &s->sim->state.grains;
    double sum = 0.0;
    for (int k = 0; k < f->clear; k++) {
        sum += f->density * (1.0 - c->phi[k]) * c->u[k] * c->dz * f->length * f->d;
    }
    for (int k = 0; k < g->n; k++) {
        sum += g->vx[k] / s->sim->plan.motion.im[k];
    }
    return sum;
}

/* Without weight all grains go along x, each layer at its speed: what fluid and grains have is what the stress at the
 * top has given less what the floor has taken, but for the last advance. */
static void test_momentum(void **state)
{
    (void)state;
    for (int k = 0; k < FLUIDS; k++) {
        const int advances[] = {1, 20};
        for (int a = 0; a < 2; a++) {
            const int advance = advances[a];
            scene *const s = open_rows(&fluids[k], "duran-moving", advance, 0);
            const ry_flow *const f = &s->sim->plan.flow;
            const ry_column *const c = &s->sim->state.column;
            const double area = f->length * f->d * f->dt * advance;
            double given = 0.0, floor = 0.0;
            for (int n = 0; n < 4000 / advance; n++) {
                step_scene(s, advance);
                floor += f->density * (1.0 - c->phi[0]) * f->viscosity * c->u[0] / (0.5 * c->dz) * area;
                given += f->tau * area;
            }
            const double had = momentum_of(s);
            printf("%s, advance %d: given %.6g, floor %.3g, there is %.6g N s\n", fluids[k].name, advance, given,
                   floor, had);
            assert_true(fabs(had + floor - given) < 2.0 * f->tau * area);
            close_scene(s);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_where_it_comes_to),
        cmocka_unit_test(test_momentum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
