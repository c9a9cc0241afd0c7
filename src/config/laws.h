/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The contact laws as options: the columns of law/laws.def, by ry_config.contact_law. */
#ifndef RY_CONFIG_LAWS_H
#define RY_CONFIG_LAWS_H

#include "ryusa/config.h"

typedef struct ry_law_kind {
    const char *word; /* in a scene file */
    int moves, ratio, parts, rests, hertz, pulls;
} ry_law_kind;
extern const ry_law_kind ry_laws[RY_LAW_COUNT];

/* A linear spring and dashpot, whose steps bear a + 2c < 4, see stability.c. */
static inline int ry_is_linear_dashpot(const ry_config *config)
{
    return ry_laws[config->contact_law].ratio && !ry_laws[config->contact_law].hertz;
}

#endif
