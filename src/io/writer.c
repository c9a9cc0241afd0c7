/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "io/writer.h"

#include <pthread.h>
#include <signal.h>
#include <stdlib.h>

struct ry_writer {
    pthread_t thread;
    pthread_mutex_t mutex; /* of all below */
    pthread_cond_t changed;
    ry_writer_job *job; /* NULL: there is none */
    void *data;
    int must_end;
    ry_status status; /* of the last job */
    ry_error error;
};

static void *work(void *of)
{
    ry_writer *const w = of;
    pthread_mutex_lock(&w->mutex);
    while (!w->must_end || w->job != NULL) {
        if (w->job == NULL) {
            pthread_cond_wait(&w->changed, &w->mutex);
            continue;
        }
        ry_error error = {0};
        pthread_mutex_unlock(&w->mutex);
        const ry_status status = w->job(w->data, &error); /* neither changes while a job goes on */
        pthread_mutex_lock(&w->mutex);
        w->status = status;
        w->error = error;
        w->job = NULL;
        pthread_cond_broadcast(&w->changed);
    }
    pthread_mutex_unlock(&w->mutex);
    return NULL;
}

/* Signals are for the thread that runs; those that tell of a fault come where it is. */
static int start_thread(ry_writer *w)
{
    sigset_t blocked, before;
    sigfillset(&blocked);
    const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXFSZ};
    for (size_t k = 0; k < sizeof faults / sizeof faults[0]; k++) {
        sigdelset(&blocked, faults[k]);
    }
    pthread_sigmask(SIG_BLOCK, &blocked, &before);
    const int failed = pthread_create(&w->thread, NULL, work, w);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return failed;
}

ry_writer *ry_writer_start(void)
{
    ry_writer *const w = calloc(1, sizeof *w);
    if (w == NULL) {
        return NULL;
    }
    pthread_mutex_init(&w->mutex, NULL);
    pthread_cond_init(&w->changed, NULL);
    if (start_thread(w) != 0) {
        pthread_cond_destroy(&w->changed);
        pthread_mutex_destroy(&w->mutex);
        free(w);
        return NULL;
    }
    return w;
}

ry_status ry_writer_wait(ry_writer *w, ry_error *error)
{
    pthread_mutex_lock(&w->mutex);
    while (w->job != NULL) {
        pthread_cond_wait(&w->changed, &w->mutex);
    }
    const ry_status status = w->status;
    if (status != RY_OK && error != NULL && error->status == RY_OK) {
        *error = w->error;
    }
    pthread_mutex_unlock(&w->mutex);
    return status;
}

void ry_writer_begin(ry_writer *w, ry_writer_job *job, void *data)
{
    pthread_mutex_lock(&w->mutex);
    if (w->status == RY_OK) {
        w->data = data;
        w->job = job;
        pthread_cond_broadcast(&w->changed);
    }
    pthread_mutex_unlock(&w->mutex);
}

int ry_writer_is_busy(ry_writer *w)
{
    pthread_mutex_lock(&w->mutex);
    const int busy = w->job != NULL;
    pthread_mutex_unlock(&w->mutex);
    return busy;
}

void ry_writer_stop(ry_writer *w)
{
    if (w == NULL) {
        return;
    }
    pthread_mutex_lock(&w->mutex);
    w->must_end = 1;
    pthread_cond_broadcast(&w->changed);
    pthread_mutex_unlock(&w->mutex);
    pthread_join(w->thread, NULL);
    pthread_cond_destroy(&w->changed);
    pthread_mutex_destroy(&w->mutex);
    free(w);
}
