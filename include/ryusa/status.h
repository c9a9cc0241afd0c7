/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * How a call says that it failed. The values of ry_status are the exit codes of the program. */
#ifndef RYUSA_STATUS_H
#define RYUSA_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(RY_BUILDING) && defined(__GNUC__)
#define RY_API __attribute__((visibility("default")))
#else
#define RY_API
#endif

typedef enum ry_status {
    RY_OK = 0,          /* done */
    RY_BAD_INPUT = 2,   /* a command line, scene or value that is not allowed */
    RY_UNPHYSICAL = 3,  /* the run left what physics allows: what, where and when are in the text */
    RY_BAD_FILE = 4,    /* a file that can't be read, written or understood; no memory; disk full */
    RY_STOPPED = 130    /* a signal asked the run to stop; everything is saved */
} ry_status;

/* The first error of a call, in one or more lines of plain text without a trailing newline. */
typedef struct ry_error {
    ry_status status;
    char text[2000];
} ry_error;

/* Fills `error` (which may be NULL) printf-like and returns `status`, so that a function can end
 * with `return ry_fail(error, RY_BAD_INPUT, "...", ...)`. The first failure is kept. */
RY_API ry_status ry_fail(ry_error *error, ry_status status, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* Passes a failure up. */
#define RY_TRY(call)                     \
    do {                                 \
        const ry_status try_ = (call);   \
        if (try_ != RY_OK) return try_;  \
    } while (0)

#ifdef __cplusplus
}
#endif
#endif
