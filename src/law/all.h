/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The laws of laws.def. */
#ifndef RY_LAW_ALL_H
#define RY_LAW_ALL_H

#include "law/cundall.h"
#include "law/energy.h"
#include "law/fujioka.h"
#include "law/tanaka.h"

#endif
