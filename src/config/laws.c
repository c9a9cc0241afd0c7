/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "config/laws.h"

#include <assert.h>

/* Kernels are found by the place of their line. */
enum {
#define RY_LAW(name, law, ...) LINE_##name,
#include "law/laws.def"
#undef RY_LAW
    LINES
};
#define RY_LAW(name, law, ...) \
    static_assert((int)LINE_##name == (int)law, #name ": not at the same place in laws.def and RY_LIST_law of config.h");
#include "law/laws.def"
#undef RY_LAW
/* What the pair loop does with the columns of a line (stage/kernel.c). */
#define RY_LAW(name, law, m, ratio, parts, r, hertz, pulls)                                                            \
    static_assert(!hertz || ratio, #name ": in laws.def, hertz without ratio: its spring would be taken as linear");    \
    static_assert(!pulls || ratio, #name ": in laws.def, pulls without ratio: only a dashpot pulls");                   \
    static_assert(!parts || !ratio, #name ": in laws.def, parts with ratio: a law that bounds its dashpot has no damping ratio");
#include "law/laws.def"
#undef RY_LAW
static_assert((int)LINES == (int)RY_LAW_COUNT, "a law of RY_LIST_law (config.h) has no line in laws.def, or a line no law");

#define RY_NAME(value, text) [value] = {.word = text},
#define RY_LAW(name, law, m, q, p, r, h, t) \
    [law].moves = m, [law].ratio = q, [law].parts = p, [law].rests = r, [law].hertz = h, [law].pulls = t,
const ry_law_kind ry_laws[RY_LAW_COUNT] = {
    RY_LIST_law(RY_NAME)
#include "law/laws.def"
};
