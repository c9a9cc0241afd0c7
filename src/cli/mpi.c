/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#define _GNU_SOURCE
#include "cli/mpi.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"

#ifdef RY_HAVE_MPI
#include <mpi.h>
#endif

/* The first of these that is set; Open MPI, PMIx, MPICH and its kin. Slurm's own SLURM_PROCID is also set
 * for a script that srun has not started. */
static int from_environment(const char *const *names, int otherwise)
{
    for (; *names; names++) {
        const char *const text = getenv(*names);
        if (text && *text) {
            return (int)strtol(text, NULL, 10);
        }
    }
    return otherwise;
}

static int started_together(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE",
                                        NULL};
    if (getenv("PMIX_RANK") && getenv("SLURM_STEP_NUM_TASKS") && !getenv(names[0])) {
        return (int)strtol(getenv("SLURM_STEP_NUM_TASKS"), NULL, 10);
    }
    return from_environment(names, 1);
}

int ry_cli_mpi_rank(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK",
                                        "MV2_COMM_WORLD_RANK", NULL};
    return started_together() > 1 ? from_environment(names, 0) : 0;
}

static int refuse(const char *format, int processes)
{
    ry_error error = {.status = RY_BAD_INPUT};
    snprintf(error.text, sizeof error.text, format, processes);
    return ry_cli_mpi_rank() == 0 ? ry_cli_report(&error) : RY_BAD_INPUT;
}

#ifndef RY_HAVE_MPI

int ry_cli_mpi_begin(int share, const ry_farm **farm)
{
    const int n = started_together();
    *farm = NULL;
    if (n <= 1 || share > 0) {
        return RY_OK;
    }
    return refuse("started as one of %d processes, but this ryusa was built without MPI (Debian: "
                  "libopenmpi-dev, then build again); or give each its own --shard I/N",
                  n);
}

void ry_cli_mpi_end(int gone)
{
    (void)gone;
}

#else

enum { TAG = 1, END_TRIES = 100, END_WAIT_US = 10000 };

/* A message on its way, and its bytes. */
typedef struct letter {
    struct letter *next;
    MPI_Request request;
    unsigned char bytes[];
} letter;

static letter *letters;

/* 1: some are still on their way. */
static int clear_letters(void)
{
    for (letter **place = &letters; *place;) {
        letter *const l = *place;
        int done = 0;
        if (MPI_Test(&l->request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS || done) {
            *place = l->next;
            free(l);
        } else {
            place = &l->next;
        }
    }
    return letters != NULL;
}

/* Without memory, or to a process that is gone, it is lost; the farm lives with that. */
static void send(void *data, int to, const void *bytes, int n)
{
    letter *const l = malloc(sizeof *l + (size_t)n);
    (void)data;
    clear_letters();
    if (!l) {
        return;
    }
    memcpy(l->bytes, bytes, (size_t)n);
    if (MPI_Isend(l->bytes, n, MPI_BYTE, to, TAG, MPI_COMM_WORLD, &l->request) != MPI_SUCCESS) {
        free(l);
        return;
    }
    l->next = letters;
    letters = l;
}

static int receive(void *data, int *from, void *bytes, int capacity)
{
    MPI_Status status;
    int there = 0, n = 0;
    (void)data;
    if (MPI_Iprobe(MPI_ANY_SOURCE, TAG, MPI_COMM_WORLD, &there, &status) != MPI_SUCCESS || !there) {
        return 0;
    }
    *from = status.MPI_SOURCE;
    if (MPI_Recv(bytes, capacity, MPI_BYTE, *from, TAG, MPI_COMM_WORLD, &status) != MPI_SUCCESS) {
        return 0;
    }
    MPI_Get_count(&status, MPI_BYTE, &n);
    return n;
}

/* Those that this process may use; where several may use the same ones, its fair share. */
static int own_cores(void)
{
    MPI_Comm node;
    int n = 1;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    MPI_Comm_size(node, &n);
#ifdef __linux__
    cpu_set_t own, all;
    if (sched_getaffinity(0, sizeof own, &own) != 0) {
        CPU_ZERO(&own);
    }
    MPI_Allreduce(&own, &all, (int)sizeof own, MPI_BYTE, MPI_BOR, node);
    const int may = CPU_COUNT(&own), share = CPU_COUNT(&all) / n;
#else
    const int may = (int)sysconf(_SC_NPROCESSORS_ONLN), share = may / n;
#endif
    MPI_Comm_free(&node);
    return share < 1 ? 1 : share < may ? share : may;
}

int ry_cli_mpi_begin(int share, const ry_farm **farm)
{
    static ry_farm f = {.send = send, .receive = receive};
    const int n = started_together();
    *farm = NULL;
    if (n <= 1) {
        return RY_OK;
    }
    MPI_Init(NULL, NULL);
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &f.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &f.size);
    if (f.size != n) {
        MPI_Finalize();
        return refuse(
            "started as one of %d processes that MPI does not know of: mpirun is of another MPI than "
            "the one that ryusa was built with",
            n);
    }
    int lowest, highest;
    MPI_Allreduce(&share, &lowest, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    MPI_Allreduce(&share, &highest, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    if (lowest != highest) {
        MPI_Finalize();
        return RY_OK;
    }
    f.cores = own_cores();
    MPI_Allreduce(&f.cores, &f.all_cores, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    *farm = &f;
    return RY_OK;
}

void ry_cli_mpi_end(int gone)
{
    for (int k = 0; k < END_TRIES && clear_letters(); k++) {
        usleep(END_WAIT_US);
    }
    if (!gone) {
        MPI_Finalize();
    }
}

#endif
