/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * For the tests of whole simulations: scenes as text, grains by id, what a set of grains holds. */
#ifndef RY_TESTS_SCENE_BENCH_H
#define RY_TESTS_SCENE_BENCH_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ryusa/ryusa.h"

#ifdef __GNUC__
#define LIKE_PRINTF(at) __attribute__((format(printf, at, at + 1), unused))
#define MAYBE_UNUSED __attribute__((unused))
#else
#define LIKE_PRINTF(at)
#define MAYBE_UNUSED
#endif

#define RY_NAME(value, word) word,
MAYBE_UNUSED static const char *const law_words[] = {RY_LIST_law(RY_NAME)};
#undef RY_NAME

typedef struct scene {
    ry_config config;
    ry_sim *sim;
} scene;

MAYBE_UNUSED static void close_scene(scene *s)
{
    ry_sim_free(s->sim);
    ry_config_free(&s->config);
    free(s);
}

static scene *start_scene(scene *s, ry_status status, int threads, ry_error *error)
{
    s->sim = status == RY_OK ? ry_sim_create(&s->config, threads, error) : NULL;
    if (s->sim == NULL) {
        fail_msg("%s", error->text);
    }
    return s;
}

/* A scene from the text of a scene file. */
MAYBE_UNUSED static scene *open_text(const char *text)
{
    ry_error error = {0};
    scene *const s = calloc(1, sizeof *s);
    return start_scene(s, ry_config_parse(&s->config, text, "scene", NULL, 0, &error), 1, &error);
}

LIKE_PRINTF(1) static scene *open_scene(const char *format, ...)
{
    static char text[8000];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return open_text(text);
}

/* A file of params/ with overrides "key=value key=value ..." */
LIKE_PRINTF(3) static scene *open_file(const char *name, int threads, const char *format, ...)
{
    char path[600], text[1000];
    const char *overrides[30];
    int n = 0;
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    for (char *word = strtok(text, " "); word != NULL && n < 30; word = strtok(NULL, " ")) {
        overrides[n++] = word;
    }
    snprintf(path, sizeof path, "%s/params/%s", RY_SOURCE_DIR, name);
    ry_error error = {0};
    scene *const s = calloc(1, sizeof *s);
    return start_scene(s, ry_config_load(&s->config, path, overrides, n, &error), threads, &error);
}

MAYBE_UNUSED static void step_scene(const scene *s, long long n)
{
    ry_error error = {0};
    if (ry_sim_step(s->sim, n, &error) != RY_OK) {
        fail_msg("%s", error.text);
    }
}

MAYBE_UNUSED static void run_until(const scene *s, double time)
{
    step_scene(s, llround(time / s->config.time_step) - ry_sim_view(s->sim).step);
}

/* ---- what grains hold -------------------------------------------------------------------------- */

typedef struct grain {
    double x, z, vx, vz, spin, radius, mass, inertia;
} grain;

MAYBE_UNUSED static grain grain_of(const scene *s, int id)
{
    const ry_view v = ry_sim_view(s->sim);
    int k = 0;
    while (v.id[k] != id) {
        k++;
    }
    const double r = v.radius[k], mass = 4.0 / 3.0 * M_PI * r * r * r * v.density[k];
    return (grain){v.x[k], v.z[k], v.vx[k], v.vz[k], v.spin[k], r, mass, 0.4 * mass * r * r};
}

/* Of all grains that can move; angular: about y, spin and orbit, z p_x - x p_z. The scales are sums of
 * absolute values, to judge a change by. */
typedef struct totals {
    double kinetic, px, pz, angular;
    double scale_p, scale_angular;
} totals;

MAYBE_UNUSED static totals totals_of(const scene *s)
{
    const ry_view v = ry_sim_view(s->sim);
    totals t = {0};
    for (int k = 0; k < v.n; k++) {
        const double r = v.radius[k], m = 4.0 / 3.0 * M_PI * r * r * r * v.density[k];
        const double inertia = 0.4 * m * r * r, p = m * hypot(v.vx[k], v.vz[k]);
        if (!v.fixed[k]) {
            t.kinetic += 0.5 * (m * (v.vx[k] * v.vx[k] + v.vz[k] * v.vz[k]) +
                                inertia * v.spin[k] * v.spin[k]);
            t.px += m * v.vx[k];
            t.pz += m * v.vz[k];
            t.angular += m * (v.z[k] * v.vx[k] - v.x[k] * v.vz[k]) + inertia * v.spin[k];
            t.scale_p += p;
            t.scale_angular += p * (hypot(v.x[k], v.z[k]) + r) + fabs(inertia * v.spin[k]);
        }
    }
    return t;
}

/* ---- random inputs (splitmix64: Steele et al. 2014, OOPSLA) -------------------------------------- */

static uint64_t random_state;

MAYBE_UNUSED static void set_seed(const char *test, uint64_t seed)
{
    random_state = seed;
    printf("%s: seed %llu\n", test, (unsigned long long)seed);
}

MAYBE_UNUSED static double evenly(double low, double high)
{
    uint64_t z = (random_state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return low + (high - low) * ((double)((z ^ (z >> 31)) >> 11) * 0x1p-53);
}

MAYBE_UNUSED static double evenly_log(double low, double high)
{
    return exp(evenly(log(low), log(high)));
}

#endif
