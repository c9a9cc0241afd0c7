/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * `ryusa bench accuracy`: every law on every problem at every time step; error, steps and run time. */
#include <stdlib.h>

#include "base/memory.h"
#include "study/bench_problems.h"

enum { MOST = RY_PROBLEM_STEPS + 1 };

/* One problem with one law: its curve. */
typedef struct curve {
    const ry_problem *problem;
    int law, n; /* time steps, the reference last if there is one */
    ry_attempt attempt[MOST];
} curve;

typedef struct study {
    ry_bench_run *run;
    int n_curves, n;
    curve *curves;
} study;

/* --- running ------------------------------------------------------------------------------------ */

static void lay_curve(const study *s, curve *c, const ry_problem *problem, int law)
{
    const int quick = s->run->options->quick, shown = quick ? problem->n_quick : problem->n;
    *c = (curve){.problem = problem, .law = law, .n = shown + problem->has_reference};
    for (int k = 0; k < c->n; k++) {
        double dt = problem->dt_max * pow(problem->dt_ratio, -k);
        if (k == shown) {
            dt = c->attempt[shown - 1].dt / problem->dt_reference;
        }
        c->attempt[k] = (ry_attempt){.law = (ry_law)law, .dt = dt, .quick = quick};
    }
}

/* Long runs first: the last step of the slowest problem, then the one before it. */
static ry_status run_attempt(void *data, int index, ry_error *error)
{
    study *const s = data;
    int left = index;
    for (int k = s->n_curves - 1; k >= 0; k--) {
        curve *const c = &s->curves[k];
        if (left < c->n) {
            RY_TRY(c->problem->run(&c->attempt[c->n - 1 - left], error));
            ry_bench_progress(s->run);
            return RY_OK;
        }
        left -= c->n;
    }
    return RY_OK;
}

/* --- errors ------------------------------------------------------------------------------------- */

static void judge(const curve *c, ry_attempt *a)
{
    const ry_problem *const p = c->problem;
    const ry_attempt *const last = &c->attempt[c->n - 1];
    const double scale = p->scale > 0.0 ? p->scale : fabs(last->value[0]);
    a->error = 0.0;
    for (int k = 0; k < a->n; k++) {
        const double exact = p->has_reference ? last->value[k] : p->exact(k);
        a->error = fmax(a->error, fabs(a->value[k] - exact) / scale);
    }
    a->error_bar = (p->has_reference ? hypot(a->bar, last->bar) : a->bar) / scale;
    a->has_run = a->has_run && isfinite(a->error) && (!p->has_reference || last->has_run);
}

static int n_shown(const curve *c)
{
    return c->n - c->problem->has_reference;
}

/* The largest step from which on every smaller one has at most this error; NULL: none. */
static const ry_attempt *cheapest(const curve *c, double error)
{
    const ry_attempt *best = NULL;
    for (int k = n_shown(c) - 1; k >= 0; k--) {
        const ry_attempt *const a = &c->attempt[k];
        if (!a->has_run || a->error > error) {
            return best;
        }
        best = a;
    }
    return best;
}

/* --- the file ----------------------------------------------------------------------------------- */

static void write_curve(const study *s, const curve *c)
{
    enum { COLUMNS = 5 };
    static const char *const name[COLUMNS] = {"dt", "steps", "seconds", "error", "error_bar"};
    static const char *const unit[COLUMNS] = {"s", "1", "s", "1", "1"};
    static const char *const text[COLUMNS] = {"time step", "steps of the whole problem",
                                              "wall time of these steps, one thread", "error",
                                              "standard error of the error"};
    double value[COLUMNS][MOST];
    int n = 0;
    for (int k = 0; k < n_shown(c); k++) {
        const ry_attempt *const a = &c->attempt[k];
        if (a->has_run) {
            const double row[COLUMNS] = {a->dt, (double)a->steps, a->seconds, a->error,
                                         a->error_bar};
            for (int i = 0; i < COLUMNS; i++) {
                value[i][n] = row[i];
            }
            n++;
        }
    }
    for (int i = 0; i < COLUMNS; i++) {
        const ry_bench_path at =
            ry_bench_at("%s/%s/%s", c->problem->name, ry_laws[c->law].word, name[i]);
        ry_table_file_numbers(s->run->file, at.text, unit[i], text[i], n, value[i]);
    }
    const ry_bench_path at = ry_bench_at("%s/%s", c->problem->name, ry_laws[c->law].word);
    ry_table_file_set_text(s->run->file, at.text, "refused", c->attempt[0].message);
    ry_table_file_set_number(s->run->file, at.text, "steps_refused", n_shown(c) - n);
    if (c->problem->has_reference) {
        ry_table_file_set_number(s->run->file, at.text, "reference", c->attempt[c->n - 1].value[0]);
    }
}

static void write_file(const study *s)
{
    for (int k = 0; k < RY_PROBLEMS; k++) {
        const ry_problem *const p = &ry_problems[k];
        ry_table_file_set_text(s->run->file, p->name, "text", p->text);
        ry_table_file_set_text(s->run->file, p->name, "error", p->error_text);
    }
    for (int k = 0; k < s->n_curves; k++) {
        write_curve(s, &s->curves[k]);
    }
}

/* --- what is said ------------------------------------------------------------------------------- */

static const double levels[] = {1e-1, 3e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-9, 1e-12};
enum { LEVELS = sizeof levels / sizeof levels[0] };

/* Steps and step size with which each law reaches an error. */
static void say_problem(const study *s, const ry_problem *p)
{
    ry_bench_say(s->run, "%s: %s\n  error: %s\n  %-18s", p->name, p->text, p->error_text,
                 "steps, dt [us] for");
    for (int i = 0; i < LEVELS; i++) {
        ry_bench_say(s->run, " %13.0e", levels[i]);
    }
    ry_bench_say(s->run, "\n");
    for (int k = 0; k < s->n_curves; k++) {
        const curve *const c = &s->curves[k];
        if (c->problem != p) {
            continue;
        }
        ry_bench_say(s->run, "  %-18s", ry_laws[c->law].word);
        for (int i = 0; i < LEVELS; i++) {
            const ry_attempt *const a = cheapest(c, levels[i]);
            if (a == NULL) {
                ry_bench_say(s->run, " %13s", "-");
            } else {
                ry_bench_say(s->run, " %7lld %5.3g", a->steps, a->dt * 1e6);
            }
        }
        ry_bench_say(s->run, "\n");
    }
}

static const curve *find_curve(const study *s, const ry_problem *p, int law)
{
    for (int k = 0; k < s->n_curves; k++) {
        if (s->curves[k].problem == p && s->curves[k].law == law) {
            return &s->curves[k];
        }
    }
    return NULL;
}

/* At every error that `other` reaches: the steps that it takes over those of `energy`; the least. */
static double least_ratio(const curve *energy, const curve *other)
{
    double least = INFINITY;
    for (int k = 0; k < n_shown(other); k++) {
        const ry_attempt *const a = &other->attempt[k];
        if (a->has_run && cheapest(other, a->error) == a) {
            const ry_attempt *const e = cheapest(energy, a->error);
            least = fmin(least, e == NULL ? 0.0 : (double)a->steps / (double)e->steps);
        }
    }
    return least;
}

/* At how many of the levels that at least two laws reach is `energy` the one with the longest run? */
static int count_slowest(const study *s, const ry_problem *p, int *n)
{
    int slowest = 0;
    *n = 0;
    for (int i = 0; i < LEVELS; i++) {
        int laws = 0, slower = 0;
        const curve *const energy = find_curve(s, p, RY_LAW_ENERGY);
        const ry_attempt *const e = cheapest(energy, levels[i]);
        for (int law = 0; law < RY_LAW_COUNT; law++) {
            const curve *const c = find_curve(s, p, law);
            const ry_attempt *const a = c == NULL ? NULL : cheapest(c, levels[i]);
            laws += a != NULL;
            slower += law != RY_LAW_ENERGY && (a == NULL || (e != NULL && a->steps >= e->steps));
        }
        *n += laws > 0;
        slowest += laws > 0 && (e == NULL || slower == 0);
    }
    return slowest;
}

static void say_goals(const study *s)
{
    const curve *const energy = find_curve(s, &ry_problems[0], RY_LAW_ENERGY);
    for (int law = 0; law < RY_LAW_COUNT; law++) {
        const curve *const c = find_curve(s, &ry_problems[0], law);
        if (c != NULL && energy != NULL &&
            (law == RY_LAW_CUNDALL || law == RY_LAW_CUNDALL_TENSION)) {
            ry_bench_say(
                s->run, "binary: at equal error %s takes at least %.3g times the steps of energy\n",
                ry_laws[law].word, least_ratio(energy, c));
        }
    }
    for (int k = 0; k < RY_PROBLEMS && ry_bench_laws(s->run) == RY_LAW_COUNT; k++) {
        int n;
        const int slowest = count_slowest(s, &ry_problems[k], &n);
        ry_bench_say(
            s->run,
            "%s: energy takes most steps, or does not get there, at %d of %d errors that a law reaches\n",
            ry_problems[k].name, slowest, n);
    }
}

/* --- all of it ---------------------------------------------------------------------------------- */

static ry_status lay_curves(study *s, ry_error *error)
{
    s->curves = calloc(RY_PROBLEMS * RY_LAW_COUNT, sizeof *s->curves);
    if (s->curves == NULL) {
        return ry_no_memory(error, RY_PROBLEMS * RY_LAW_COUNT * sizeof *s->curves);
    }
    for (int k = 0; k < RY_PROBLEMS; k++) {
        for (int law = 0; law < RY_LAW_COUNT; law++) {
            if (ry_bench_has_law(s->run, law)) {
                lay_curve(s, &s->curves[s->n_curves], &ry_problems[k], law);
                s->n += s->curves[s->n_curves++].n;
            }
        }
    }
    s->run->n = s->n;
    return RY_OK;
}

static void finish(study *s)
{
    for (int k = 0; k < s->n_curves; k++) {
        for (int i = 0; i < s->curves[k].n; i++) {
            judge(&s->curves[k], &s->curves[k].attempt[i]);
        }
    }
    write_file(s);
    for (int k = 0; k < RY_PROBLEMS; k++) {
        say_problem(s, &ry_problems[k]);
    }
    say_goals(s);
}

ry_status ry_bench_accuracy(ry_bench_run *run, ry_error *error)
{
    study s = {.run = run};
    ry_status status = lay_curves(&s, error);
    if (status == RY_OK) {
        status = ry_each(s.n, run->options->threads, run_attempt, &s, error);
    }
    if (status == RY_OK) {
        finish(&s);
    }
    free(s.curves);
    return status;
}
