# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The largest time step at which each program has its own q*: what the timed job of flux.py takes for granted. Not
machine dependent, so it can be kept: jobs-calibrated.csv."""
import csv
import sys
from concurrent.futures import ThreadPoolExecutor
from queue import Queue

import flux
import known
import numpy as np
from programs import Failed

COLUMNS = ("program", "theta", "bed", "parts", "q_star", "error")


def run_case(tools, states, case, core):
    """One run; its q* is NaN if it became unphysical."""
    name, theta, bed, parts, seconds = case
    row = {"program": name, "theta": theta, "bed": bed, "parts": parts, "q_star": np.nan, "error": np.nan}
    try:
        if name == "LAMMPS":
            q = flux.lammps_series(tools.lammps, tools.folder, states[bed], theta, bed, parts, seconds, core=core)
        else:
            q = flux.ryusa_series(tools.ryusa, name.split()[1], theta, bed, parts, seconds, core)
        row["q_star"], row["error"] = known.mean(q)
    except Failed as error:
        print(f"  {name}, theta {theta}, bed {bed}, T/{parts:g}: {str(error).strip().splitlines()[-1]}", file=sys.stderr)
    return row


def measure(tools, states, seconds, cores):
    """All cases of all ladders, as many at a time as there are cores."""
    cases = [(name, theta, bed, parts, seconds) for name, ladder in flux.LADDER.items() for parts in ladder
             for bed in states for theta in flux.LEVEL]
    free = Queue()
    for core in range(cores):
        free.put(core)

    def one(case):
        core = free.get()
        try:
            return run_case(tools, states, case, core)
        finally:
            free.put(core)
            print(".", end="", file=sys.stderr, flush=True)
    with ThreadPoolExecutor(cores) as pool:
        rows = list(pool.map(one, cases))
    print(file=sys.stderr)
    return rows


def write(rows, path):
    with open(path, "w", newline="") as file:
        out = csv.DictWriter(file, COLUMNS)
        out.writeheader()
        out.writerows({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)


def read(path):
    with open(path) as file:
        return [{k: v if k == "program" else float(v) for k, v in row.items()} for row in csv.DictReader(file)]


REFERENCE = 3  # the smallest steps of a ladder are what all are judged by


def ratios(rows, name, theta, parts):
    """q* of each bed over its own mean at the smallest steps."""
    q = {(r["parts"], r["bed"]): r["q_star"] for r in rows if (r["program"], r["theta"]) == (name, theta)}
    small = sorted({p for p, _ in q})[-REFERENCE:]
    beds = sorted({b for _, b in q})
    return np.array([q[parts, b] / np.mean([q[p, b] for p in small]) for b in beds])


def scatter(rows, theta):
    """Standard deviation of the q* of one run by chance: what the smallest steps differ by, bed by bed, of all programs,
    for they run the same beds. The error that a run gives for itself is less, at theta = 0.2 by far: beds change
    slowly there."""
    total, freedom = 0.0, 0
    for name in {r["program"] for r in rows}:
        small = sorted({r["parts"] for r in rows if r["program"] == name})[-REFERENCE:]
        off = np.array([ratios(rows, name, theta, parts) - 1.0 for parts in small])
        total, freedom = total + (off ** 2).sum(), freedom + off.size - off.shape[1]
    return np.sqrt(total / freedom)


def differences(rows, name):
    """parts -> for each theta the change of q* against the smallest steps, and its standard error."""
    ladder = sorted({r["parts"] for r in rows if r["program"] == name})
    table = {parts: [] for parts in ladder}
    for theta in sorted({r["theta"] for r in rows}):
        for parts in ladder:
            of_beds = ratios(rows, name, theta, parts)
            error = scatter(rows, theta) * np.sqrt((1.0 + 1.0 / REFERENCE) / len(of_beds))
            table[parts].append((of_beds.mean() - 1.0, error))
    return table


def choose(table):
    """The fewest steps in a period that pass, if all smaller steps do: off by no more than SYSTEMATIC at any theta, or
    by so little more that its standard error may be the cause."""
    best = max(table)
    for parts in sorted(table, reverse=True):
        if not all(abs(off) <= flux.SYSTEMATIC + error for off, error in table[parts]):
            break
        best = parts
    return best


def say(rows):
    names = list(dict.fromkeys(r["program"] for r in rows))
    print(f"\nq* against that of the {REFERENCE} smallest steps, in %, at theta = {', '.join(map(str, flux.LEVEL))}")
    for name in names:
        table = differences(rows, name)
        for parts, row in sorted(table.items()):
            cells = "  ".join(f"{100 * off:+6.1f} +- {100 * error:.1f}" for off, error in row)
            mark = "   <- taken" if parts == choose(table) else ""
            print(f"  {name:14s} T/{parts:<5g} {cells}{mark}")


