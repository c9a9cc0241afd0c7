/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

/* Large pages for what of a large array fills them: of small ones a bed of a million grains needs so many that the
 * processor has to look up where they are. Where none can be had nothing is lost. */
static void ask_for_large_pages(void *array, size_t bytes)
{
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    const uintptr_t page = (uintptr_t)2 << 20;
    const uintptr_t begin = ((uintptr_t)array + page - 1) / page * page, end = ((uintptr_t)array + bytes) / page * page;
    if (end > begin) {
        (void)madvise((void *)begin, end - begin, MADV_HUGEPAGE);
    }
#else
    (void)array;
    (void)bytes;
#endif
}

void *ry_array(size_t count, size_t size)
{
    if (size != 0 && count > (SIZE_MAX - RY_ALIGNMENT) / size) {
        return NULL;
    }
    const size_t bytes = (count * size + RY_ALIGNMENT - 1) / RY_ALIGNMENT * RY_ALIGNMENT;
    void *const array = aligned_alloc(RY_ALIGNMENT, bytes > 0 ? bytes : RY_ALIGNMENT);
    if (array != NULL) {
        ask_for_large_pages(array, bytes);
        memset(array, 0, bytes);
    }
    return array;
}

ry_status ry_no_memory(ry_error *error, size_t bytes)
{
    const int is_large = bytes >= (size_t)1 << 20;
    return ry_fail(error, RY_BAD_FILE, "out of memory: %zu %s more were needed", bytes >> (is_large ? 20 : 0),
                   is_large ? "MiB" : "bytes");
}

ry_status ry_array_grow(void *array, size_t *capacity, size_t used, size_t wanted, size_t size,
                        ry_error *error)
{
    void **const slot = array;
    if (wanted <= *capacity) {
        return RY_OK;
    }
    const size_t room = wanted + wanted / 4 + 64;
    void *const grown = ry_array(room, size);
    if (grown == NULL) {
        return ry_no_memory(error, room * size);
    }
    if (used > 0) {
        memcpy(grown, *slot, used * size);
    }
    free(*slot);
    *slot = grown;
    *capacity = room;
    return RY_OK;
}
