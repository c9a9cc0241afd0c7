/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The processes that mpirun (srun, ...) has started together, and their messages. MPI is begun only if
 * there are several: a lone process neither needs it nor waits for it. */
#ifndef RY_CLI_MPI_H
#define RY_CLI_MPI_H

#include "study/farm.h"

#ifdef RY_HAVE_MPI
#define RY_CLI_MPI_ABOUT \
    "This ryusa was built with MPI: `mpirun -n K ryusa sweep ...' shares the cases among K processes."
#else
#define RY_CLI_MPI_ABOUT \
    "This ryusa was built without MPI: mpirun can't share the cases among processes, --shard can."
#endif

/* This process's number among those started together, 0 if it is alone, as the launcher tells it. */
int ry_cli_mpi_rank(void);

/* RY_OK and *farm, NULL for a lone process; otherwise reported. `share`: the I of --shard, 0 without it;
 * processes with shares of their own are alone, each. */
int ry_cli_mpi_begin(int share, const ry_farm **farm);

/* When every process has done its work. gone: not every one is there any more; then MPI is left without
 * the farewell, in which it would wait for that one. */
void ry_cli_mpi_end(int gone);

#endif
