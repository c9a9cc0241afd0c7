/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The mark of a config made by ry_config_default; change it when ry_config changes its meaning. */
#ifndef RY_CONFIG_GUARD_H
#define RY_CONFIG_GUARD_H

#define RY_CONFIG_GUARD UINT32_C(0x72795501)

#endif
