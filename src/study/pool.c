/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#define _GNU_SOURCE
#include "study/pool.h"

#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include "base/clock.h"
#include "base/memory.h"

enum { LOOK_EVERY_US = 10000, LOOKS_PER_CALL = 10 };

struct ry_pool_worker {
    _Atomic double share;
};

typedef struct running {
    const ry_pool *pool;
    ry_pool_worker *shared; /* one for each worker, seen by all processes */
    pid_t *pid;             /* 0: this worker is idle */
    int *job, *job_list;
    double *share_list;
    int held; /* a job that could not be begun yet, or what `next` said last */
    int n_running, stopping;
} running;

/* --- in the child ------------------------------------------------------------------------------- */

static volatile sig_atomic_t stop_asked;

static void on_terminate(int signal_number)
{
    (void)signal_number;
    stop_asked = 1;
}

void ry_pool_tell(ry_pool_worker *worker, double share)
{
    atomic_store_explicit(&worker->share, share, memory_order_relaxed);
}

int ry_pool_must_stop(void)
{
    return stop_asked;
}

/* Ctrl-C reaches every process of a terminal, but it is the parent that decides. */
static void set_signals(pid_t parent, const sigset_t *mask)
{
    struct sigaction action = {.sa_handler = on_terminate, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGINT, SIG_IGN);
    signal(SIGHUP, SIG_IGN);
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGTERM);
#endif
    if (getppid() != parent) { /* it died before that call */
        stop_asked = 1;
    }
    sigprocmask(SIG_SETMASK, mask, NULL);
}

/* --- in the parent ------------------------------------------------------------------------------ */

static ry_status begin(running *r, int worker, ry_error *error)
{
    const ry_pool *const pool = r->pool;
    const int job = r->held;
    const pid_t parent = getpid();
    sigset_t all, old;
    atomic_store(&r->shared[worker].share, 0.0);
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, &old); /* no signal before the child has its handlers */
    const pid_t pid = fork();
    if (pid == 0) {
        set_signals(parent, &old);
        _exit(pool->work(pool->data, job, &r->shared[worker]));
    }
    sigprocmask(SIG_SETMASK, &old, NULL);
    if (pid < 0) {
        return errno == EAGAIN && r->n_running > 0
                   ? RY_OK /* too many processes now; tried again when one has ended */
                   : ry_fail(error, RY_BAD_FILE, "no process can be made: %s", strerror(errno));
    }
    r->pid[worker] = pid;
    r->job[worker] = job;
    r->held = RY_POOL_WAIT;
    r->n_running++;
    return RY_OK;
}

static ry_status begin_all(running *r, ry_error *error)
{
    if (r->stopping && r->held >= 0) {
        r->pool->ended(r->pool->data, r->held, RY_STOPPED, 0);
        r->held = RY_POOL_WAIT;
    }
    for (int w = 0; w < r->pool->workers; w++) {
        if (r->pid[w] == 0 && r->held == RY_POOL_WAIT) {
            r->held = r->pool->next(r->pool->data);
        }
        if (r->pid[w] == 0 && r->held >= 0) {
            RY_TRY(begin(r, w, error));
        }
    }
    return RY_OK;
}

static ry_status collect(running *r, int *ended, ry_error *error)
{
    ry_status status = RY_OK;
    *ended = 0;
    for (int w = 0; w < r->pool->workers; w++) {
        int how = 0;
        const pid_t who = r->pid[w] != 0 ? waitpid(r->pid[w], &how, WNOHANG) : 0;
        if (who == 0 || (who < 0 && errno == EINTR)) {
            continue;
        }
        r->pid[w] = 0;
        r->n_running--;
        ++*ended;
        if (who < 0) {
            status = ry_fail(error, RY_BAD_FILE, "how a process has ended is not known: %s", strerror(errno));
            r->pool->ended(r->pool->data, r->job[w], RY_STOPPED, 0);
            continue;
        }
        r->pool->ended(r->pool->data, r->job[w], WIFEXITED(how) ? WEXITSTATUS(how) : 0,
                       WIFSIGNALED(how) ? WTERMSIG(how) : 0);
    }
    return status;
}

static void stop_all(running *r)
{
    r->stopping = 1;
    for (int w = 0; w < r->pool->workers; w++) {
        if (r->pid[w] > 0) {
            kill(r->pid[w], SIGTERM);
        }
    }
}

static void look(running *r)
{
    int n = 0;
    for (int w = 0; w < r->pool->workers; w++) {
        if (r->pid[w] > 0) {
            r->job_list[n] = r->job[w];
            r->share_list[n++] = atomic_load_explicit(&r->shared[w].share, memory_order_relaxed);
        }
    }
    if (r->pool->look(r->pool->data, n, r->job_list, r->share_list) && !r->stopping) {
        stop_all(r);
    }
}

static ry_status run_all(running *r, ry_error *error)
{
    ry_status status = RY_OK;
    int changed = 0;
    for (int turn = 1;; turn++) {
        if (r->pool->turn != NULL) {
            r->pool->turn(r->pool->data);
        }
        /* Before one is begun: the signal that ended a child may be for all. */
        if (changed || turn % LOOKS_PER_CALL == 0) {
            look(r);
        }
        if (status == RY_OK) {
            status = begin_all(r, error);
        }
        if (status != RY_OK && !r->stopping) {
            stop_all(r);
        }
        if (r->n_running == 0 && (r->held == RY_POOL_END || status != RY_OK)) {
            return status;
        }
        usleep(LOOK_EVERY_US);
        const ry_status collected = collect(r, &changed, error);
        status = status == RY_OK ? collected : status;
    }
}

ry_status ry_pool_run(const ry_pool *pool, ry_error *error)
{
    const size_t n = (size_t)pool->workers;
    void *const shared = mmap(NULL, n * sizeof(ry_pool_worker), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    running r = {.pool = pool,
                 .shared = shared == MAP_FAILED ? NULL : shared,
                 .held = RY_POOL_WAIT,
                 .pid = calloc(n, sizeof *r.pid),
                 .job = calloc(n, sizeof *r.job),
                 .job_list = calloc(n, sizeof *r.job_list),
                 .share_list = calloc(n, sizeof *r.share_list)};
    ry_status status = ry_no_memory(NULL, n);
    if (r.shared != NULL && r.pid != NULL && r.job != NULL && r.job_list != NULL &&
        r.share_list != NULL) {
        status = run_all(&r, error);
    } else {
        ry_no_memory(error, n * sizeof(ry_pool_worker));
    }
    if (r.shared != NULL) {
        munmap(r.shared, n * sizeof(ry_pool_worker));
    }
    free(r.pid);
    free(r.job);
    free(r.job_list);
    free(r.share_list);
    return status;
}

int ry_pool_cores(void)
{
    long n = sysconf(_SC_NPROCESSORS_ONLN);
#ifdef __linux__
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) {
        n = CPU_COUNT(&set);
    }
#endif
    const char *const slurm = getenv("SLURM_CPUS_PER_TASK");
    const long given = slurm != NULL ? strtol(slurm, NULL, 10) : 0;
    n = given > 0 && given < n ? given : n;
    return n > 0 ? (int)n : 1;
}
