/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Numbers and quantities as people write them: "20", "1e-6 m^2/s", "0.5 mm". */
#ifndef RY_CONFIG_QUANTITY_H
#define RY_CONFIG_QUANTITY_H

#include <stddef.h>

/* Reads a quantity and converts it to `unit`; a bare number is in `unit` already. With unit "1" no
 * unit may stand. Returns 1, or 0 with what is wrong and what is allowed in `problem`. */
int ry_quantity_read(const char *text, const char *unit, double *value, char *problem, size_t size);

#endif
