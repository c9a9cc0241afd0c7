#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa against LAMMPS, LIGGGHTS and YADE on the same grains: docs/performance.md.

All programs go on from the same state, which ryusa has made; they take turns, so that a machine that slows down
slows all of them. A rate is steps times the grains that can move, per second of the step loop."""
import argparse
import dataclasses
import datetime
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import programs
import state as states
from programs import HERE, Failed, Work, call

SIZES = {50: (5, 10), 1000: (100, 10), 10000: (500, 20), 100000: (5000, 20)}
SCENES = ["settled", "sheared"]
ROUND = 0.6         # seconds of a round of LAMMPS; all others take as many steps,
LONGEST = 3.0       # if that takes them no more seconds than this
FEWEST = 40         # steps of a round: some rebuilds of the neighbour list are among them
# The first turn tells how fast everybody is, and whether all do the same: grain-steps, but not fewer steps unless
# these are as many grain-steps as MOST.
PROBE, PROBE_STEPS, MOST = 3e5, 200, 5e6
ROOT = HERE.parent.parent
INFINITE = float("inf")


def lay_work(arguments, scene, grains, folder):
    """Runs ryusa to the state that all go on from, and writes it for everybody."""
    columns, layers = SIZES[grains]
    folder.mkdir()
    settings = [str(ROOT / f"params/bench-{scene}.yaml"), "-s", f"grains.columns={columns}",
                "-s", f"grains.layers={layers}"]
    for start, fields in programs.FIELDS.items():
        call([arguments.ryusa, "run", settings[0], "-o", str(folder / f"{start}.h5"), "--quiet", *settings[1:],
              *fields], folder)
    s = states.read(folder / "plain.h5")
    if s.movable != grains:
        raise Failed(f"{s.movable} grains, not {grains}")
    states.write_data(s, folder / "bed.data")
    names = ("x", "z", "vx", "vz", "spin", "radius", "density", "fixed")
    np.savez(folder / "bed.npz", **{name: getattr(s, name) for name in names})
    return Work(scene, grains, folder, s, settings, steps=int(max(PROBE / grains, min(PROBE_STEPS, MOST / grains))), rounds=1)


def line_up(arguments, scene):
    """Name -> function that runs it, of the programs that are there."""
    found = {"ryusa": programs.ryusa(arguments.ryusa, "plain"),
             "ryusa measuring": programs.ryusa(arguments.ryusa, "measured")}
    if shutil.which(arguments.lammps):
        found["LAMMPS"] = programs.lammps(arguments.lammps, "bed.lammps")
        if scene == "sheared":
            found["LAMMPS top"] = programs.lammps(arguments.lammps, "bed.lammps", top_only=True)
    if shutil.which("liggghts"):
        found["LIGGGHTS"] = programs.lammps("liggghts", "bed.liggghts")
    if shutil.which("yade"):
        found["YADE"] = programs.yade("yade")
    return found


def machine():
    with open("/proc/cpuinfo") as file:
        name = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "unknown")
    load = os.getloadavg()[0]
    return f"{name}, {os.cpu_count()} cores, load {load:.2f} at the start"


def versions():
    packages = subprocess.run(["dpkg-query", "-W", "-f=${Package} ${Version}; ", "lammps", "liggghts", "yade"],
                              capture_output=True, text=True).stdout
    return packages.rstrip("; ") or "no Debian packages of the peers"


# --- what is said and written ---------------------------------------------------------------------


def rates(work, outcomes):
    """Best and median million grain-steps per second over the rounds of all turns."""
    every = [work.grains * o.steps / s * 1e-6 for o in outcomes[1:] for s in o.seconds]
    return max(every), statistics.median(every), len(every)


def say_case(work, results, cores):
    print(f"\n{work.scene}, {work.grains} grains, {cores} core{'s' * (cores > 1)}")
    print(f"  {'program':16s} {'best':>8s} {'median':>8s}  {'ryusa/it':>8s}   {'kinetic/J':>10s} {'height/d':>9s} "
          f"{'contacts':>9s}")
    own = results.get(("ryusa", cores))
    for (name, n), outcomes in results.items():
        if n != cores:
            continue
        best, median, _ = rates(work, outcomes)
        ratio = rates(work, own)[0] / best
        energy, height, contacts = outcomes[0].mean
        print(f"  {name:16s} {best:8.2f} {median:8.2f}  {ratio:8.2f}   {energy:10.3g} {height / programs.D:9.4f} "
              f"{contacts:9.0f}")


def write_csv(path, cases):
    with open(path, "w") as file:
        file.write(f"# {machine()}; {versions()}; {datetime.date.today()}\n")
        file.write("scene,grains,program,cores,best,median,rounds,steps,kinetic_energy,height,contacts\n")
        for work, results in cases:
            for (name, cores), outcomes in results.items():
                best, median, n = rates(work, outcomes)
                energy, height, contacts = outcomes[0].mean
                file.write(f"{work.scene},{work.grains},{name},{cores},{best * 1e6:.4g},{median * 1e6:.4g},{n},"
                           f"{outcomes[-1].steps},{energy:.4g},{height:.6g},{contacts:.0f}\n")


# --- the same physics? ----------------------------------------------------------------------------

# Against ryusa, at the end of the first turn. Where the beds move they are chaotic, and a grain that just
# touches counts or does not; so contacts are those of a sample, and a bed of 50 has few.
HEIGHT = 0.003    # of itself; 0.02 below 1000 grains
CONTACTS = 0.10   # of themselves; 0.5 below 1000 grains where they move
AT_REST = 1e-3    # m g d per grain; a hundredth of what the sheared bed has


def disagreements(work, results):
    if ("ryusa", 1) not in results:
        return []
    _, height, contacts = results["ryusa", 1][0].mean
    mgd = np.pi / 6.0 * programs.D ** 3 * 2650.0 * 9.81 * programs.D
    small = work.grains < 1000 and work.scene == "sheared"
    wrong = []
    for (name, cores), outcomes in results.items():
        e, h, n = outcomes[0].mean
        who = f"{work.scene}, {work.grains} grains, {name}, {cores} cores"
        if abs(h - height) > (0.02 if small else HEIGHT) * height:
            wrong.append(f"{who}: height {h:.6g} m, ryusa {height:.6g} m")
        if abs(n - contacts) > (0.5 if small else CONTACTS) * contacts:
            wrong.append(f"{who}: {n:.0f} contacts, ryusa {contacts:.0f}")
        if work.scene == "settled" and e / work.grains > AT_REST * mgd:
            wrong.append(f"{who}: not at rest, {e / work.grains / mgd:.2g} m g d per grain")
    return wrong


def common_steps(results):
    """Steps of a timed round: the same for all, since a sheared bed changes on its way; ROUND seconds for LAMMPS."""
    name, factor = ("LAMMPS", 1.0) if ("LAMMPS", 1) in results else ("ryusa", 0.25)
    probe = results.get((name, 1)) or next(iter(results.values()))
    return max(int(factor * ROUND * probe[0].steps / probe[0].seconds[0]), FEWEST)


def run_one(work, run, cores, outcomes, results):
    """One turn of a program; none is added if it failed. The first is the probe."""
    if outcomes:
        affordable = LONGEST * outcomes[0].steps / outcomes[0].seconds[0]
        work = dataclasses.replace(work, rounds=3, steps=int(max(min(common_steps(results), affordable), FEWEST)))
    try:
        outcomes.append(run(work, cores))
    except (Failed, subprocess.TimeoutExpired) as error:
        print(f"{work.scene}, {work.grains} grains, {cores} cores: {error}", file=sys.stderr)


def take_turn(arguments, cases, end):
    """All programs on all cases, one after the other. Breaks off at `end`."""
    for work, results in cases:
        for name, run in line_up(arguments, work.scene).items():
            if arguments.only and not any(name.lower().startswith(o.lower()) for o in arguments.only):
                continue
            for cores in arguments.cores:
                if time.monotonic() > end:
                    return
                run_one(work, run, cores, results.setdefault((name, cores), []), results)
        print(".", end="", file=sys.stderr, flush=True)


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ryusa", default=str(ROOT / "build/ryusa"))
    parser.add_argument("--lammps", default="lmp", help="another binary of LAMMPS")
    parser.add_argument("--csv", default="bench-peers.csv", help="file for the numbers")
    parser.add_argument("--minutes", type=float, default=20.0, help="two turns at least; no program is begun later")
    parser.add_argument("--quick", action="store_true", help="50 and 1 000 grains, one short turn")
    parser.add_argument("--grains", type=int, nargs="+", choices=SIZES, help="these sizes only")
    parser.add_argument("--scene", nargs="+", choices=SCENES, default=SCENES)
    parser.add_argument("--cores", type=int, nargs="+", default=[1, 2][:max(1, min(2, os.cpu_count() or 1))])
    parser.add_argument("--only", nargs="+", help="programs whose names begin so")
    arguments = parser.parse_args()
    arguments.ryusa = str(Path(arguments.ryusa).resolve())
    arguments.grains = arguments.grains or ([50, 1000] if arguments.quick else list(SIZES))
    return arguments


def main():
    arguments = parse()
    begun = time.monotonic()
    print(f"{machine()}\n{versions()}\nmillion grain-steps per second, by the grains that can move")
    with tempfile.TemporaryDirectory(prefix="ryusa-peers-") as folder:
        cases = [(lay_work(arguments, scene, grains, Path(folder) / f"{scene}-{grains}"), {})
                 for grains in arguments.grains for scene in arguments.scene]
        take_turn(arguments, cases, INFINITE)
        take_turn(arguments, cases, INFINITE)
        end = begun + 60.0 * arguments.minutes
        while not arguments.quick and time.monotonic() < end:
            take_turn(arguments, cases, end)
        for _, results in cases:  # those of which there is more than the probe
            for key in [k for k, outcomes in results.items() if len(outcomes) < 2]:
                del results[key]
        print(file=sys.stderr)
    for work, results in cases:
        for cores in arguments.cores:
            say_case(work, results, cores)
    write_csv(arguments.csv, cases)
    print(f"\nnumbers in {arguments.csv}")
    wrong = [w for work, results in cases for w in disagreements(work, results)]
    for line in wrong:
        print(f"not the same physics: {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
