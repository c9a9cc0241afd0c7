/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Sets of pieces: made from the scene and some changes, run side by side, kept in the journal. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "study/each.h"
#include "study/tune_private.h"

typedef struct batch {
    ry_tune_run *run;
    ry_tune_piece *piece;
    const char *what;
    int n, done, ran;
    double started;
    int *todo;
} batch;

static void tell(batch *b)
{
    const ry_tune_options *const wish = b->run->wish;
    const int left = b->n - b->done;
    const double per = b->ran > 0 ? (ry_clock() - b->started) / b->ran : NAN;
    const ry_tune_progress p = {b->what, b->done, b->n, per * left};
    if (wish->progress != NULL) {
        wish->progress(wish->data, &p);
    }
}

static int never(void *data)
{
    (void)data;
    return 0;
}

static ry_status run_piece(void *data, int index, ry_error *error)
{
    batch *const b = data;
    ry_tune_piece *const piece = &b->piece[b->todo[index]];
    const ry_tune_options *const wish = b->run->wish;
    RY_TRY(ry_tune_piece_run(piece, wish->stop != NULL ? wish->stop : never, wish->data, error));
    ry_status status;
#pragma omp critical
    {
        status = ry_tune_journal_add(b->run->journal, piece, error);
        b->done++;
        b->ran++;
        tell(b);
    }
    return status;
}

ry_status ry_tune_run_batch(ry_tune_run *run, const char *what, ry_tune_piece *piece, int n,
                            ry_error *error)
{
    batch b = {.run = run, .piece = piece, .what = what, .n = n, .started = ry_clock()};
    b.todo = ry_array((size_t)n, sizeof *b.todo);
    if (b.todo == NULL) {
        return ry_no_memory(error, (size_t)n * sizeof *b.todo);
    }
    int left = 0;
    for (int k = 0; k < n; k++) {
        if (piece[k].done || ry_tune_journal_find(run->journal, &piece[k])) {
            b.done++;
        } else {
            b.todo[left++] = k;
        }
    }
    run->kept += b.done;
    tell(&b);
    const ry_status status = ry_each(left, run->wish->threads, run_piece, &b, error);
    free(b.todo);
    return status;
}

ry_tune_piece *ry_tune_new_pieces(ry_tune_run *run, int n, ry_error *error)
{
    ry_tune_piece *const set = ry_array((size_t)n, sizeof *set);
    if (set == NULL) {
        ry_no_memory(error, (size_t)n * sizeof *set);
        return NULL;
    }
    run->piece[run->n_sets] = set;
    run->n_piece[run->n_sets++] = n;
    return set;
}

/* The scene with what this piece changes. One that is refused for its constants is done: its text
 * tells why. */
static void make_config(const ry_tune_run *run, ry_tune_piece *piece, const char *const *changes,
                        int n)
{
    ry_error own = {0};
    if (ry_config_parse(&piece->config, run->base.text, run->base.path, changes, n, &own) !=
        RY_OK) {
        piece->status = RY_BAD_INPUT;
        snprintf(piece->why, sizeof piece->why, "%.299s", own.text);
        piece->why[strcspn(piece->why, "\n")] = '\0';
        piece->done = 1;
    }
}

/* --- changes ------------------------------------------------------------------------------------ */

void ry_tune_change_word(ry_tune_changes *c, const char *key, const char *word)
{
    snprintf(c->text[c->n], sizeof c->text[0], "%s=%s", key, word);
    c->list[c->n] = c->text[c->n];
    c->n++;
}

void ry_tune_change(ry_tune_changes *c, const char *key, double value)
{
    char word[30];
    snprintf(word, sizeof word, "%.10g", value);
    ry_tune_change_word(c, key, word);
}

/* Its words are its name in the journal. */
void ry_tune_make_piece(const ry_tune_run *run, ry_tune_piece *piece, ry_tune_kind kind,
                        ry_tune_changes *c)
{
    size_t used = (size_t)snprintf(piece->words, sizeof piece->words, "%s",
                                   kind == RY_TUNE_SETTLE ? "settle" : "flux");
    for (int k = 0; k < c->n; k++) {
        c->list[k] = c->text[k]; /* the struct may have been copied */
        if (used < sizeof piece->words) {
            used += (size_t)snprintf(piece->words + used, sizeof piece->words - used, " %s", c->text[k]);
        }
    }
    piece->kind = kind;
    make_config(run, piece, c->list, c->n);
}

void ry_tune_make_flux(const ry_tune_run *run, ry_tune_piece *piece, ry_tune_changes *c, int i)
{
    ry_tune_change(c, "fluid.shields", run->fit.theta[i]);
    ry_tune_change_word(c, "fluid.start", "motion");
    if (run->wish->quick) {
        const double start = 0.5 * run->base.time_settle;
        const double rest = run->base.time_end - run->base.time_settle - RY_TUNE_BOOST;
        ry_tune_change(c, "time.settle", start);
        ry_tune_change(c, "time.end", start + RY_TUNE_BOOST + 0.05 * rest);
    }
    piece->goal = 0.02;
    piece->target = run->fit.target[i];
    ry_tune_make_piece(run, piece, RY_TUNE_FLUX, c);
}
