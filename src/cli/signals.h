/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Ctrl-C, SIGTERM and a lost terminal ask to save and stop; Ctrl-C after that ends the program at once
 * (what was saved last is kept). */
#ifndef RY_CLI_SIGNALS_H
#define RY_CLI_SIGNALS_H

void ry_cli_catch_signals(void);
int ry_cli_stop_asked(void);

#endif
