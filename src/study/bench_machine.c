/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/bench_machine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

static void read_processor(char *text, size_t size)
{
    static const char key[] = "model name";
    char line[400];
    snprintf(text, size, "unknown");
    FILE *const file = fopen("/proc/cpuinfo", "r");
    if (file == NULL) {
        return;
    }
    while (fgets(line, sizeof line, file) != NULL) {
        const char *const colon = strchr(line, ':');
        if (strncmp(line, key, sizeof key - 1) == 0 && colon != NULL) {
            snprintf(text, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
            break;
        }
    }
    fclose(file);
}

ry_machine ry_machine_describe(void)
{
    ry_machine m = {.cores = (int)sysconf(_SC_NPROCESSORS_ONLN)};
    read_processor(m.processor, sizeof m.processor);
#if defined(__clang__)
    snprintf(m.compiler, sizeof m.compiler, "%.119s", __VERSION__);
#elif defined(__GNUC__)
    snprintf(m.compiler, sizeof m.compiler, "gcc %.110s", __VERSION__);
#else
    snprintf(m.compiler, sizeof m.compiler, "unknown");
#endif
    if (getloadavg(&m.load, 1) != 1) {
        m.load = 0.0;
    }
    return m;
}

double ry_machine_heap(void)
{
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
    const struct mallinfo2 info = mallinfo2();
    return (double)info.uordblks + (double)info.hblkhd;
#else
    return 0.0;
#endif
}
