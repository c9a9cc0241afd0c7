/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * How a failure is recorded. The first one is kept: what fails later is mostly its consequence. */
#include "ryusa/status.h"

#include <stdarg.h>
#include <stdio.h>

ry_status ry_fail(ry_error *error, ry_status status, const char *format, ...)
{
    if (error != NULL && error->status == RY_OK) {
        error->status = status;
        va_list arguments;
        va_start(arguments, format);
        (void)vsnprintf(error->text, sizeof error->text, format, arguments);
        va_end(arguments);
    }
    return status;
}
