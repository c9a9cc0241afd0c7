/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Changes to a file that happen as a whole or not at all, as a file driver for HDF5. HDF5 rewrites
 * its own bookkeeping in place, so a process that dies while it writes may leave a file that nothing
 * can open. Here bytes that are already in the file are changed in memory only (pages), while new
 * ones are written behind its end, where nothing points to them yet. ry_atomic_commit then writes the
 * changed pages into a journal beside the file (FILE.journal), copies them from there into the file
 * and removes the journal. Whoever opens a file and finds a whole journal beside it, reads through it
 * or completes the copy; an incomplete one is ignored, and so is what stands behind the end.
 *
 * Write errors (disk full) are kept, not handed to HDF5, which cannot close a file that it cannot
 * write: the pages stay in memory, HDF5 ends in peace, and the commit reports the error. */
#ifndef RY_IO_ATOMIC_H
#define RY_IO_ATOMIC_H

#include <hdf5.h>
#include <stdint.h>

typedef struct ry_atomic ry_atomic;

/* Opens `path` to read (through a journal, if there is one), or to change (after completing one);
 * `fd` is then a descriptor open for reading and writing, which stays the caller's. On failure NULL,
 * errno tells. */
ry_atomic *ry_atomic_open(const char *path, int fd);

/* Sets the access property list so that H5Fopen and H5Fcreate work on `file`. Returns the driver, which H5FDunregister
 * gives back after H5Fclose: HDF5 closes a file by the driver that it has just let go of. Negative on failure. */
hid_t ry_atomic_set_access(hid_t access, ry_atomic *file);

/* Lets changes of bytes begin .. begin + size - 1 go into the file at once. For data that nobody
 * reads before the commit. */
void ry_atomic_expose(ry_atomic *file, uint64_t begin, uint64_t size);

/* The first write error so far, an errno; 0: none. */
int ry_atomic_error(const ry_atomic *file);

/* After H5Fclose: makes the changes happen. 0, or an errno: then nothing has changed but what was
 * exposed. */
int ry_atomic_commit(ry_atomic *file);

/* Forgets what was not committed. */
void ry_atomic_close(ry_atomic *file);

/* 1: the file begins as every HDF5 file, 0: it is empty or its head was never written (its first
 * bytes are zeros), -1: it is something else. */
int ry_atomic_looks_like_hdf5(ry_atomic *file);

/* For the driver: reads (zeros behind the end), writes, and what HDF5 takes for the size. */
int ry_atomic_read(ry_atomic *file, void *buffer, size_t size, uint64_t at);
int ry_atomic_write(ry_atomic *file, const void *from, size_t size, uint64_t at);
uint64_t ry_atomic_size(const ry_atomic *file);
void ry_atomic_set_size(ry_atomic *file, uint64_t size);

/* Removes the journal of a file that is about to begin anew. */
void ry_atomic_forget_journal(const char *path);

#endif
