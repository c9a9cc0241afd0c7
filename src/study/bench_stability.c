/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa bench stability`: every law on every point of every map. */
#include <stdlib.h>

#include "base/memory.h"
#include "study/bench_maps.h"

#define RY_CLASS_WORD(name, word, text) word,
static const char *const class_word[] = {RY_LIST_stress_class(RY_CLASS_WORD)};
#undef RY_CLASS_WORD
#define RY_CLASS_TEXT(name, word, text) text,
static const char *const class_text[] = {RY_LIST_stress_class(RY_CLASS_TEXT)};
#undef RY_CLASS_TEXT

enum { MOST_POINTS = RY_MAP_POINTS * RY_MAP_POINTS, QUICK_POINTS = 3 };

typedef struct point {
    int map, law;
    double x, y;
    ry_stress stress;
} point;

typedef struct study {
    ry_bench_run *run;
    int n;
    point *points; /* map by map, law by law, y by y */
} study;

/* --- which points --- */

static int axis_points(const ry_axis *axis, int quick)
{
    return quick ? QUICK_POINTS : axis->n;
}

static double axis_value(const ry_axis *axis, int quick, int k)
{
    return axis->value[quick ? (axis->n - 1) * k / (QUICK_POINTS - 1) : k];
}

static int map_points(int map, int quick)
{
    return axis_points(&ry_maps[map].x, quick) * axis_points(&ry_maps[map].y, quick);
}

static ry_status lay_points(study *s, int quick, ry_error *error)
{
    for (int map = 0; map < RY_MAPS; map++) {
        s->n += ry_bench_laws(s->run) * map_points(map, quick);
    }
    s->points = calloc((size_t)s->n, sizeof *s->points);
    if (s->points == NULL) {
        return ry_no_memory(error, (size_t)s->n * sizeof *s->points);
    }
    point *p = s->points;
    for (int map = 0; map < RY_MAPS; map++) {
        const ry_axis *const x = &ry_maps[map].x, *const y = &ry_maps[map].y;
        for (int law = 0; law < RY_LAW_COUNT; law++) {
            for (int k = 0; k < map_points(map, quick) && ry_bench_has_law(s->run, law); k++) {
                const int nx = axis_points(x, quick);
                *p++ = (point){.map = map,
                               .law = law,
                               .x = axis_value(x, quick, k % nx),
                               .y = axis_value(y, quick, k / nx)};
            }
        }
    }
    return RY_OK;
}

static ry_status run_point(void *data, int index, ry_error *error)
{
    study *const s = data;
    point *const p = &s->points[index];
    RY_TRY(
        ry_maps[p->map].run((ry_law)p->law, p->x, p->y, s->run->options->quick, &p->stress, error));
    ry_bench_progress(s->run);
    return RY_OK;
}

/* --- the file --- */

static void write_axis(const study *s, int map, const char *name, const ry_axis *axis)
{
    const int quick = s->run->options->quick, n = axis_points(axis, quick);
    double value[RY_MAP_POINTS];
    for (int k = 0; k < n; k++) {
        value[k] = axis_value(axis, quick, k);
    }
    ry_table_file_numbers(s->run->file, ry_bench_at("%s/%s", ry_maps[map].name, name).text,
                          axis->unit, axis->key, n, value);
}

static void write_law(const study *s, const point *p, int n)
{
    double value[4][MOST_POINTS];
    const char *message[MOST_POINTS];
    static const char *const name[4] = {"class", "kinetic", "integration", "rise"};
    static const char *const text[4] = {
        "index of the class", "kinetic energy per grain in the end [m g' d]; NAN: not judged",
        "row `integration` of the energy ledger over the losses",
        "largest rise of the energy less the fluid's work, over the losses"};
    for (int k = 0; k < n; k++) {
        const ry_stress *const q = &p[k].stress;
        value[0][k] = q->class;
        value[1][k] = q->kinetic;
        value[2][k] = q->integration;
        value[3][k] = q->rise;
        message[k] = q->message;
    }
    const char *const map = ry_maps[p->map].name, *const law = ry_laws[p->law].word;
    for (int k = 0; k < 4; k++) {
        ry_table_file_numbers(s->run->file, ry_bench_at("%s/%s/%s", map, law, name[k]).text, "1",
                              text[k], n, value[k]);
    }
    ry_table_file_texts(s->run->file, ry_bench_at("%s/%s/message", map, law).text,
                        "why a scene was refused or stopped", n, message);
}

static void write_file(const study *s)
{
    ry_table_file_texts(s->run->file, "class/word", "classes by index", RY_STRESS_COUNT,
                        class_word);
    ry_table_file_texts(s->run->file, "class/text", "when", RY_STRESS_COUNT, class_text);
    const point *p = s->points;
    for (int map = 0; map < RY_MAPS; map++) {
        const int n = map_points(map, s->run->options->quick);
        ry_table_file_set_text(s->run->file, ry_maps[map].name, "text", ry_maps[map].text);
        write_axis(s, map, "x", &ry_maps[map].x);
        write_axis(s, map, "y", &ry_maps[map].y);
        for (int k = 0; k < ry_bench_laws(s->run); k++, p += n) {
            write_law(s, p, n);
        }
    }
}

/* --- what is said --- */

static void say_law(const study *s, const point *p, int n)
{
    int count[RY_STRESS_COUNT] = {0};
    for (int k = 0; k < n; k++) {
        count[p[k].stress.class]++;
    }
    ry_bench_say(s->run, "  %-18s", ry_laws[p->law].word);
    for (int c = 0; c < RY_STRESS_COUNT; c++) {
        ry_bench_say(s->run, count[c] ? " %8d" : "        .", count[c]);
    }
    ry_bench_say(s->run, "\n");
}

static void say_worst(const study *s, int law)
{
    for (int k = 0; k < s->n; k++) {
        const point *const p = &s->points[k];
        if (p->law == law && p->stress.class >= RY_STRESS_LEAKS) {
            const ry_map *const m = &ry_maps[p->map];
            ry_bench_say(s->run,
                         "  %s: %s at %s = %g, %s = %g: integration %.3g of the losses%s%s\n",
                         m->name, class_word[p->stress.class], m->x.key, p->x, m->y.key, p->y,
                         p->stress.integration, *p->stress.message ? "; " : "", p->stress.message);
        }
    }
}

static void say(const study *s)
{
    const point *p = s->points;
    for (int map = 0; map < RY_MAPS; map++) {
        const int n = map_points(map, s->run->options->quick);
        ry_bench_say(s->run, "%s: %s against %s; %s\n  %-18s", ry_maps[map].name,
                     ry_maps[map].y.key, ry_maps[map].x.key, ry_maps[map].text, "points that are");
        for (int c = 0; c < RY_STRESS_COUNT; c++) {
            ry_bench_say(s->run, " %8.8s", class_word[c]);
        }
        ry_bench_say(s->run, "\n");
        for (int k = 0; k < ry_bench_laws(s->run); k++, p += n) {
            say_law(s, p, n);
        }
    }
    ry_bench_say(s->run, "law %s where it is worse than that:\n", ry_laws[RY_LAW_ENERGY].word);
    say_worst(s, RY_LAW_ENERGY);
}

ry_status ry_bench_stability(ry_bench_run *run, ry_error *error)
{
    study s = {.run = run};
    ry_status status = lay_points(&s, run->options->quick, error);
    run->n = s.n;
    if (status == RY_OK) {
        status = ry_each(s.n, run->options->threads, run_point, &s, error);
    }
    if (status == RY_OK) {
        write_file(&s);
        say(&s);
    }
    free(s.points);
    return status;
}
