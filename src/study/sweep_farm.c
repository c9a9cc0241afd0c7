/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A sweep on several processes. Process 0 has the queue and writes the table; the others ask it for
 * cases, one message and one answer at a time, and tell it how these ended. All run their cases in
 * children, so that a case that is killed takes no process of the farm with it. A process that is gone
 * is noticed by its silence and, where the file system has locks, by the lock that its last child lets
 * go of; then its cases are given to others, who go on from their checkpoints.
 *
 * Messages are these structs as they lie in memory: all processes run the same program. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/text.h"
#include "study/sweep_private.h"

/* Seconds of silence after which the lock of a process is looked at, and after which it counts as gone
 * where there are no locks; seconds between the messages of one that has nothing to tell. */
static const double LOOK_AFTER = 2.0, GONE_AFTER = 60.0, ASK_EVERY = 0.1;
enum { TURN_US = 10000 };

typedef enum { HELLO, ASK, ENDED, LEAVE } kind;
typedef enum { GO_ON, STOP, GO_HOME } order;

/* To process 0. ENDED: job and how it ended; LEAVE: why, and no answer is awaited. */
typedef struct request {
    kind kind;
    int idle, running; /* cases that it could begin, cases that it runs */
    double work;       /* done of those that it runs */
    int job, exit_code, killed_by;
    ry_case_record record;
    char text[600];
} request;

typedef struct answer {
    order order;
    int job; /* a new case; -1: none */
    int threads;
    double work; /* of that case */
    int gone;    /* a process of the farm is */
} answer;

/* Time that this process has seen go by: one that was suspended has not listened either. */
static double time_seen(double *last)
{
    const double now = ry_clock(), seen = fmin(now - *last, 1.0);
    *last = now;
    return seen;
}

/* Once per second of silence. */
static int is_time_to_look(double silence, double seen)
{
    return silence > LOOK_AFTER && floor(silence) > floor(silence - seen);
}

/* --- process 0 ---------------------------------------------------------------------------------- */

typedef struct member {
    enum { AWAITED, HERE, GONE } state;
    int has_asked;
    int is_visible; /* its lock is seen from here */
    int running;
    double work, silence;
} member;

struct ry_sweep_farm {
    const ry_farm *wire;
    int *holder; /* of each case: the process that has it; 0: none, or this one */
    int n_out;   /* cases that others have */
    double looked;
    member member[]; /* by rank */
};

ry_sweep_farm *ry_sweep_farm_create(const ry_farm *wire, int n_cases)
{
    ry_sweep_farm *const f = calloc(1, sizeof *f + (size_t)wire->size * sizeof *f->member);
    int *const holder = calloc((size_t)n_cases + 1, sizeof *holder);
    if (f == NULL || holder == NULL) {
        free(f);
        free(holder);
        return NULL;
    }
    f->wire = wire;
    f->holder = holder;
    f->looked = ry_clock();
    return f;
}

void ry_sweep_farm_free(ry_sweep_farm *f)
{
    if (f != NULL) {
        free(f->holder);
    }
    free(f);
}

int ry_sweep_farm_count(const ry_sweep_run *run, int *running, double *work)
{
    const ry_sweep_farm *const f = run->farm;
    for (int rank = 1; rank < f->wire->size && running != NULL; rank++) {
        *running += f->member[rank].running;
        *work += f->member[rank].work;
    }
    return f->n_out;
}

static void part_with(ry_sweep_run *run, int rank, const char *why)
{
    ry_sweep_farm *const f = run->farm;
    int n = 0;
    for (int k = 0; k < run->n_cases && f->n_out > 0; k++) {
        if (f->holder[k] == rank) {
            f->holder[k] = 0;
            f->n_out--;
            n++;
            ry_sweep_cases_put_back(run, k);
        }
    }
    f->member[rank] = (member){.state = GONE};
    if (run->stopping) {
        return; /* all are going */
    }
    char *const news = ry_text_print("process %d of %d %s%s", rank + 1, f->wire->size, why,
                                     n == 0   ? ""
                                     : n == 1 ? "; its case is given to another"
                                              : "; its cases are given to others");
    if (news != NULL) {
        ry_sweep_cases_say(run, news);
    }
    free(news);
}

static void notice_the_gone(ry_sweep_run *run)
{
    ry_sweep_farm *const f = run->farm;
    const double seen = time_seen(&f->looked);
    for (int rank = 1; rank < f->wire->size; rank++) {
        member *const m = &f->member[rank];
        if (m->state == GONE) {
            continue;
        }
        m->silence += seen;
        if (m->is_visible && is_time_to_look(m->silence, seen) &&
            !ry_sweep_store_is_there(&run->store, run->options->shard, rank)) {
            run->result->gone = 1;
            part_with(run, rank, "is gone");
        } else if (m->silence > GONE_AFTER && !(m->is_visible && m->state == HERE)) {
            run->result->gone = 1;
            part_with(run, rank, "has not been heard for a minute");
        }
    }
}

static void end_case(ry_sweep_run *run, int rank, const request *q)
{
    ry_sweep_farm *const f = run->farm;
    if (q->job < 0 || q->job >= run->n_cases || f->holder[q->job] != rank) {
        return; /* it was given to another one meanwhile */
    }
    f->holder[q->job] = 0;
    f->n_out--;
    if (q->exit_code == RY_STOPPED && !run->stopping && !run->broken) {
        ry_sweep_cases_put_back(run, q->job);
    } else {
        ry_sweep_cases_end(run, q->job, q->exit_code, q->killed_by, &q->record);
    }
}

static answer decide(ry_sweep_run *run, int rank, const request *q)
{
    ry_sweep_farm *const f = run->farm;
    const int ending = run->stopping || run->broken;
    answer a = {.order = ending ? STOP : GO_ON,
                .job = -1,
                .threads = run->threads,
                .gone = run->result->gone};
    if (q->idle > 0) {
        a.job = ry_sweep_cases_take(run);
    }
    if (a.job >= 0) {
        f->holder[a.job] = rank;
        f->n_out++;
        a.work = run->cases[a.job].work;
    } else if (q->running == 0 && ending) {
        a.order = GO_HOME;
    }
    return a;
}

static void take_request(ry_sweep_run *run, int rank, const request *q)
{
    ry_sweep_farm *const f = run->farm;
    member *const m = &f->member[rank];
    answer a = {.order = GO_HOME, .job = -1, .threads = 1, .gone = 1};
    if (q->kind == LEAVE) {
        if (m->state != GONE) {
            part_with(run, rank, q->text);
        }
        return;
    }
    if (m->state != GONE) {
        m->state = HERE;
        m->silence = 0.0;
        m->running = q->running;
        m->work = q->work;
        if (q->kind == ASK && !m->has_asked) {
            m->has_asked = 1;
            m->is_visible = ry_sweep_store_is_there(&run->store, run->options->shard, rank);
        } else if (q->kind == ENDED) {
            end_case(run, rank, q);
        }
        a = decide(run, rank, q);
        m->state = a.order == GO_HOME ? GONE : HERE;
    }
    f->wire->send(f->wire->data, rank, &a, (int)sizeof a);
}

void ry_sweep_farm_turn(ry_sweep_run *run)
{
    ry_sweep_farm *const f = run->farm;
    request q;
    int rank = 0;
    for (int n; (n = f->wire->receive(f->wire->data, &rank, &q, (int)sizeof q)) > 0;) {
        if (n == (int)sizeof q && rank > 0 && rank < f->wire->size) {
            take_request(run, rank, &q);
        }
    }
    notice_the_gone(run);
}

void ry_sweep_farm_dismiss(ry_sweep_run *run)
{
    ry_sweep_farm *const f = run->farm;
    run->stopping = 1; /* nothing is begun any more */
    for (int someone = 1; someone;) {
        ry_sweep_farm_turn(run);
        someone = 0;
        for (int rank = 1; rank < f->wire->size; rank++) {
            someone = someone || f->member[rank].state != GONE;
        }
        if (someone) {
            usleep(TURN_US);
        }
    }
}

/* --- the other processes ------------------------------------------------------------------------ */

typedef struct worker {
    ry_sweep_run *run;
    const ry_farm *wire;
    int slots, threads; /* cases at a time, threads for each */
    int n_running;      /* begun or in hand, and not told yet that they have ended */
    int hand;           /* a case that is to be begun; -1: none */
    request *told;      /* how cases have ended, to be told; a stack */
    int n_told;
    double work;
    order order;
    int waits;       /* for an answer */
    int is_answered; /* before the first answer process 0 may check cases for any time */
    int is_hungry;  /* the last answer brought a case: there may be more */
    int is_leaving; /* a signal of its own */
    int is_orphan;  /* process 0 is gone */
    int sees_parent;
    double silence, looked, since; /* since: of the last answer */
} worker;

static int is_stopping(const worker *w)
{
    return w->order != GO_ON || w->is_leaving || w->is_orphan;
}

static void ask(worker *w, request q)
{
    q.idle = is_stopping(w) ? 0 : w->slots - w->n_running;
    q.running = w->n_running;
    q.work = w->work;
    w->wire->send(w->wire->data, 0, &q, (int)sizeof q);
    w->waits = q.kind != LEAVE;
}

static void take_answer(worker *w)
{
    answer a;
    int from = 0;
    while (w->wire->receive(w->wire->data, &from, &a, (int)sizeof a) == (int)sizeof a) {
        w->waits = 0;
        w->is_answered = 1;
        w->silence = 0.0;
        w->since = ry_clock();
        w->order = a.order;
        w->run->result->gone = a.gone;
        w->threads = a.threads;
        w->is_hungry = a.job >= 0;
        if (a.job >= 0) {
            w->hand = a.job;
            w->n_running++;
            w->run->cases[a.job].work = a.work;
        }
    }
    const double seen = time_seen(&w->looked);
    w->silence += seen;
    if (w->waits && ((w->sees_parent && is_time_to_look(w->silence, seen) &&
                      !ry_sweep_store_is_there(&w->run->store, w->run->options->shard, 0)) ||
                     (!w->sees_parent && w->is_answered && w->silence > GONE_AFTER))) {
        w->is_orphan = 1;
        w->run->result->gone = 1;
    }
}

static void on_turn(void *data)
{
    worker *const w = data;
    take_answer(w);
    if (w->waits || w->is_orphan || w->order == GO_HOME) {
        return;
    }
    if (w->n_told > 0) {
        w->n_running--;
        ask(w, w->told[--w->n_told]);
    } else if (w->hand < 0 && ((w->is_hungry && w->n_running < w->slots && !is_stopping(w)) ||
                               ry_clock() - w->since >= ASK_EVERY)) {
        ask(w, (request){.kind = ASK});
    }
}

static int on_work(void *data, int job, ry_pool_worker *worker_of_pool)
{
    return ry_sweep_cases_work(((worker *)data)->run, job, worker_of_pool);
}

static void on_ended(void *data, int job, int exit_code, int killed_by)
{
    worker *const w = data;
    request *const q = &w->told[w->n_told++];
    *q = (request){.kind = ENDED, .job = job, .exit_code = exit_code, .killed_by = killed_by};
    w->work = fmax(w->work - w->run->cases[job].work, 0.0);
    if (exit_code == 0 && killed_by == 0) {
        ry_sweep_store_read(&w->run->store, job, &q->record, NULL);
    }
}

static int on_next(void *data)
{
    worker *const w = data;
    const int job = w->hand;
    w->hand = -1;
    if (job >= 0 && !is_stopping(w)) {
        return job;
    }
    if (job >= 0) {
        on_ended(w, job, RY_STOPPED, 0);
    }
    const int left = w->is_leaving && w->n_running == 0 && !w->waits;
    return w->is_orphan || w->order == GO_HOME || left ? RY_POOL_END : RY_POOL_WAIT;
}

static int on_look(void *data, int n_running, const int *job, const double *share)
{
    worker *const w = data;
    const ry_sweep_options *const o = w->run->options;
    const ry_sweep_progress nothing = {.news = NULL};
    w->work = 0.0;
    for (int k = 0; k < n_running; k++) {
        w->work += share[k] * w->run->cases[job[k]].work;
    }
    w->is_leaving = w->is_leaving || (o->progress != NULL && o->progress(o->data, &nothing));
    return is_stopping(w);
}

static void leave(worker *w, const char *what, const char *why)
{
    request q = {.kind = LEAVE};
    snprintf(q.text, sizeof q.text, "%s%s", what, why);
    ask(w, q);
}

/* The first answer comes when process 0 has opened the folder. */
static void say_hello(worker *w)
{
    ask(w, (request){.kind = HELLO});
    while (w->waits && !w->is_orphan) {
        usleep(TURN_US);
        take_answer(w);
    }
}

static ry_status work(worker *w, const char *description)
{
    ry_sweep_run *const run = w->run;
    const ry_sweep_options *const o = run->options;
    const ry_status status =
        ry_sweep_store_join(&run->store, description, o->shard, w->wire->rank, run->error);
    if (status != RY_OK) {
        leave(w, "can't take part: ", run->error->text);
        return RY_OK;
    }
    w->sees_parent = ry_sweep_store_is_there(&run->store, o->shard, 0);
    const int cores = o->cores > 0 ? o->cores : w->wire->cores;
    run->threads = w->threads < cores ? w->threads : cores;
    w->slots = cores / run->threads;
    w->told = calloc((size_t)w->slots, sizeof *w->told);
    if (w->told == NULL) {
        leave(w, "can't take part: ", "it has no memory");
        return RY_OK;
    }
    const ry_pool pool = {.workers = w->slots,
                          .data = w,
                          .next = on_next,
                          .work = on_work,
                          .ended = on_ended,
                          .look = on_look,
                          .turn = on_turn};
    const ry_status end = ry_pool_run(&pool, run->error);
    if (end != RY_OK) {
        leave(w, "gives up: ", run->error->text);
    } else if (w->order != GO_HOME && !w->is_orphan) {
        leave(w, "was asked to stop", "");
    }
    free(w->told);
    return w->is_orphan ? RY_STOPPED : RY_OK;
}

ry_status ry_sweep_farm_work(ry_sweep_run *run, const char *description, ry_status status)
{
    worker w = {.run = run, .wire = run->options->farm, .hand = -1, .looked = ry_clock()};
    if (status != RY_OK) {
        leave(&w, "can't take part: ", run->error->text);
        return RY_OK;
    }
    say_hello(&w);
    if (w.is_orphan) {
        return RY_STOPPED;
    }
    return w.order == GO_ON ? work(&w, description) : RY_OK;
}
