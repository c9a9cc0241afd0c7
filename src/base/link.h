/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Outputs that are symbolic links. Files are made under another name and renamed, which would put them in the place
 * of the link; so a link is followed once, before anything is made, and all names are those of the file behind it. */
#ifndef RY_BASE_LINK_H
#define RY_BASE_LINK_H

#include "ryusa/status.h"

/* The file that `path` leads to, which the caller frees: `path` itself unless it is a link; it need not be there, its
 * folder must. RY_BAD_FILE: a loop, or no folder. */
ry_status ry_link_follow(const char *path, char **target, ry_error *error);

#endif
