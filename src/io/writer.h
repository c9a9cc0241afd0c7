/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A thread that does one job at a time beside the thread that gives it jobs: a run goes on computing
 * while its result is written. All calls come from the thread that made the writer. */
#ifndef RY_IO_WRITER_H
#define RY_IO_WRITER_H

#include "ryusa/status.h"

typedef struct ry_writer ry_writer;
typedef ry_status ry_writer_job(void *data, ry_error *error);

/* NULL: no thread can be had. */
ry_writer *ry_writer_start(void);

/* Waits for the job that goes on, if any; what came of it. After a failure nothing more is done, and
 * every call returns that failure. */
ry_status ry_writer_wait(ry_writer *writer, ry_error *error);

/* Begins a job; the one before has been waited for. */
void ry_writer_begin(ry_writer *writer, ry_writer_job *job, void *data);

int ry_writer_is_busy(ry_writer *writer);

/* Waits for the job that goes on, ends the thread, frees. */
void ry_writer_stop(ry_writer *writer);

#endif
