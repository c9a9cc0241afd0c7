/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The folder of a sweep: OUT.d/sweep.txt says what is swept, case-0001.txt how a case has ended. Both
 * are texts that appear whole; case-0001.h5 belongs to ry_run. */
#ifndef RY_STUDY_SWEEP_STORE_H
#define RY_STUDY_SWEEP_STORE_H

#include "ryusa/ryusa.h"

typedef struct ry_case_record {
    int known;  /* there is a record */
    int status; /* ry_status of the run; 128 + n: its process was killed by signal n */
    double q_star, q_star_error, autocorrelation_time, equilibration_time;
    long long samples;
    double wall_seconds; /* of the call that ended it */
    int stopped_early;
    unsigned long long hash;
    char message[500];
} ry_case_record;

typedef struct ry_sweep_store {
    char *output; /* OUT.h5 */
    char *folder; /* OUT.d */
    int n_cases, digits;
    int shards; /* 0: this is a sweep without */
    int lock;   /* descriptor of sweep.txt; -1: none */
} ry_sweep_store;

/* Only makes the names. */
ry_status ry_sweep_store_init(ry_sweep_store *store, const char *output, int n_cases,
                              ry_error *error);
void ry_sweep_store_close(ry_sweep_store *store);

/* "OUT.d/case-0007" + ending; the caller frees it. Without `folder`: "case-0007" + ending. */
char *ry_sweep_store_name(const ry_sweep_store *store, int index, const char *ending,
                          int with_folder);

/* Makes the folder if it isn't there and locks it for `shard` of `shards` (0: for all cases). An old
 * sweep, and one that another shard has just begun, must be described by the same text, line by line,
 * else RY_BAD_INPUT names what differs; but with `anew` and no shards everything of the old one is
 * removed first. */
ry_status ry_sweep_store_open(ry_sweep_store *store, const char *description, int shard, int shards,
                              int anew, ry_error *error);

/* For --merge: the folder must be there and the description the same; nothing is locked. */
ry_status ry_sweep_store_look(const ry_sweep_store *store, const char *description,
                              ry_error *error);

/* Of a sweep that several processes share (study/farm.h): process `rank`, 1 or above, says that it is
 * there, until the store is closed and all its children have ended. Process 0 has opened the store.
 * RY_BAD_FILE if the folder can't be seen, or holds another sweep. */
ry_status ry_sweep_store_join(ry_sweep_store *store, const char *description, int shard, int rank,
                              ry_error *error);

/* 1: process `rank` or one of its children is there; 0: it isn't, or the file system can't tell. */
int ry_sweep_store_is_there(const ry_sweep_store *store, int shard, int rank);

/* Waits for the right to write OUT.h5, and keeps it until the store is closed. */
ry_status ry_sweep_store_lock_table(ry_sweep_store *store, ry_error *error);

/* 1: something of this case is there. */
int ry_sweep_store_has(const ry_sweep_store *store, int index);
/* Removes all of it. */
void ry_sweep_store_remove(const ry_sweep_store *store, int index);

ry_status ry_sweep_store_read(const ry_sweep_store *store, int index, ry_case_record *record,
                              ry_error *error);
ry_status ry_sweep_store_write(const ry_sweep_store *store, int index, const ry_case_record *record,
                               ry_error *error);

#endif
