#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Time to a given error: whole jobs in ryusa and in LAMMPS, each at the largest time step that it bears.

Wall time of the whole job (start, reading, running, writing) and the processor time of all its processes; the latter
is what can be compared on a busy machine. docs/performance.md has the definitions."""
import argparse
import csv
import datetime
import resource
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import calibrate
import flux
import impacts
import peers

HERE = Path(__file__).resolve().parent
COLUMNS = ("job", "program", "cores", "parts", "wall", "cpu", "loop", "flow", "repeats", "result")
JOBS = ["flux", "restitution"]
LONG = 5.0  # seconds of wall time after which a job of impacts isn't repeated


@dataclass
class Row:
    """One job of one program: medians over its repeats."""
    job: str
    program: str
    cores: int
    parts: float               # steps in a period
    wall: list = field(default_factory=list)
    cpu: list = field(default_factory=list)
    loop: list = field(default_factory=list)   # of the steps alone, where the program tells
    flow: list = field(default_factory=list)   # seconds of flow that were simulated
    result: list = field(default_factory=list)  # of each bed

    def numbers(self):
        def middle(values):
            return statistics.median(values) if values else float("nan")
        return {"job": self.job, "program": self.program, "cores": self.cores, "parts": f"{self.parts:g}",
                **{k: f"{middle(getattr(self, k)):.4g}" for k in ("wall", "cpu", "loop", "flow")},
                "repeats": len(self.wall), "result": " | ".join(dict.fromkeys(self.result))}


def processor_time():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def timed(row, job):
    """Runs it once more for this row."""
    began, used = time.monotonic(), processor_time()
    out = job()
    row.wall.append(time.monotonic() - began)
    row.cpu.append(processor_time() - used)
    print(f"  {row.job}, {row.program}, {row.cores} core{'s' * (row.cores > 1)}, T/{row.parts:g}: "
          f"{row.wall[-1]:.2f} s, processor {row.cpu[-1]:.2f} s", file=sys.stderr, flush=True)
    return out


# --- q* -------------------------------------------------------------------------------------------


def judge(found, reference):
    """The q* of a job, and how far each is from the value of small steps and long runs."""
    cells = [f"{q:.3g}" for _, (q, _) in sorted(found.items())]
    if reference:
        cells = [f"{c} ({100 * (found[theta][0] / reference[theta] - 1):+.0f} %)" for c, theta in
                 zip(cells, sorted(found))]
    return "q* " + " ".join(cells)


def keep(row, found, reference):
    row.flow.append(sum(seconds for _, seconds in found.values()))
    row.result.append(judge(found, reference))


def reference_of(rows, name, bed):
    """q* of this bed at the smallest steps of the ladder."""
    small = sorted({r["parts"] for r in rows if r["program"] == name})[-calibrate.REFERENCE:]
    return {theta: statistics.mean(r["q_star"] for r in rows if (r["program"], r["bed"], r["theta"]) == (name, bed, theta)
                                   and r["parts"] in small) for theta in flux.LEVEL}


def ryusa_rows(arguments, rows, parts, lengths):
    """The job with each law, and with the default fluid as information. How long each bed has flowed goes to `lengths`."""
    kinds = [(name, name.split()[1], parts[name], "log") for name in parts if name != "LAMMPS"]
    if not arguments.quick:
        kinds.append(("ryusa balance", "energy", parts["ryusa energy"], "balance"))
    out = []
    for name, law, step, model in kinds:
        for cores in arguments.cores:
            row = Row("flux", name, cores, step)
            for bed in arguments.beds[:1] if model == "balance" else arguments.beds:
                found = timed(row, lambda: flux.ryusa_job(arguments.ryusa, law, bed, step, cores, model))
                if model == "log":
                    lengths[bed] = {theta: lengths[bed].get(theta, []) + [seconds] for theta, (_, seconds) in found.items()}
                keep(row, found, reference_of(rows, name, bed) if model == "log" else None)
            out.append(row)
    return out


def lammps_rows(arguments, rows, parts, beds, lengths):
    """LAMMPS flows as long as ryusa's runs in the mean: when q* first seems to be known is chance."""
    kinds = [("LAMMPS", 1, "1", False)]
    if 2 in arguments.cores:
        kinds += [("LAMMPS, a case a core", 2, "2 serial", False), ("LAMMPS, MPI", 2, "2 MPI", False)]
    if not arguments.quick:
        kinds.append(("LAMMPS, drag on all", 1, "1", True))
    mean = {bed: {theta: statistics.mean(seconds) for theta, seconds in lengths[bed].items()} for bed in lengths}
    out = []
    for name, cores, way, everywhere in kinds:
        row = Row("flux", name, cores, parts["LAMMPS"])
        for bed in arguments.beds:
            found = timed(row, lambda: flux.lammps_job(arguments.lammps, arguments.folder, beds[bed], bed,
                                                       parts["LAMMPS"], mean[bed], way, everywhere))
            keep(row, found, None if everywhere else reference_of(rows, "LAMMPS", bed))
        out.append(row)
    return out


def flux_job(arguments):
    beds = {bed: flux.rest(arguments.ryusa, bed, arguments.folder) for bed in arguments.beds}
    if arguments.calibrate:
        print(f"calibrating, {arguments.calibrate:g} s of flow a case", file=sys.stderr)
        rows = calibrate.measure(arguments, beds, arguments.calibrate, len(arguments.cores))
        calibrate.write(rows, arguments.calibrated)
    else:
        rows = calibrate.read(arguments.calibrated)
    calibrate.say(rows)
    parts = {name: calibrate.choose(calibrate.differences(rows, name)) for name in flux.LADDER}
    print(file=sys.stderr)
    lengths = {bed: {} for bed in arguments.beds}
    return ryusa_rows(arguments, rows, parts, lengths) + lammps_rows(arguments, rows, parts, beds, lengths)


# --- restitution ----------------------------------------------------------------------------------


def runners(arguments, scene, cores):
    folder = arguments.folder
    return {"ryusa": lambda parts: impacts.ryusa(arguments.ryusa, scene, folder, "energy", parts, cores),
            "LAMMPS": lambda parts: impacts.lammps(arguments.lammps, scene, folder, parts, cores)}


def say_errors(scene, found):
    print(f"\n{scene.name}, e = {scene.e:g}: error of the mean / the worst, in %")
    for name, table in found.items():
        print(f"  {name:8s}" + "".join(f" T/{parts:g} {100 * mean:.2f}/{100 * worst:.1f} "
                                       for parts, (mean, worst) in sorted(table.items())))


def impact_rows(arguments, scene):
    """The scene to 1 % in the mean, and pairs also to 1 % in every impact."""
    impacts.lay(scene, arguments.folder)
    found = {name: impacts.table(run, scene) for name, run in runners(arguments, scene, 1).items()}
    say_errors(scene, found)
    goals = [("mean", 0)] + [("every", 1)] * (scene.name == "pairs")
    out = []
    for goal, which in goals:
        for name in found:
            parts = impacts.largest(found[name], which, impacts.GOAL[scene.name])
            for cores in arguments.cores if parts else ():
                row = Row(f"{scene.name} e={scene.e:g}, {goal}", name, cores, parts)
                run = runners(arguments, scene, cores)[name]
                while len(row.wall) < (1 if arguments.quick else 5) and sum(row.wall) < LONG:
                    row.loop.append(timed(row, lambda: run(parts))[1])
                mean, worst = found[name][parts]
                row.result.append(f"off by {100 * mean:.2g} %, worst {100 * worst:.2g} %")
                out.append(row)
    return out


def restitution_job(arguments):
    scenes = [impacts.pairs(0.5, count=500), impacts.gas(0.5, count=400)] if arguments.quick else \
        [impacts.pairs(0.5), impacts.pairs(0.9), impacts.gas(0.5), impacts.gas(0.9)]
    return [row for scene in scenes for row in impact_rows(arguments, scene)]


# --- what is said and written ---------------------------------------------------------------------


def say(rows):
    """Ratios to ryusa's fastest row of the same job and cores."""
    print(f"\n{'job':22s} {'program':22s} {'cores':>5s} {'step':>7s} {'wall/s':>8s} {'cpu/s':>8s} {'loop/s':>8s} "
          f"{'flow/s':>7s} {'wall':>6s} {'cpu':>6s} {'loop':>6s} {'a second of flow':>17s} times ryusa's")
    table = [r.numbers() for r in rows]
    for r in table:
        own = [o for o in table if (o["job"], o["cores"]) == (r["job"], r["cores"])
               and o["program"].startswith("ryusa") and o["program"] != "ryusa balance"]
        best = min(own, key=lambda o: float(o["cpu"]), default=r)
        ratio = [float(r[k]) / float(best[k]) for k in ("wall", "cpu", "loop")]
        ratio.append(ratio[0] / (float(r["flow"]) / float(best["flow"])))
        print(f"{r['job']:22s} {r['program']:22s} {r['cores']:5d} {'T/' + r['parts']:>7s} {r['wall']:>8s} {r['cpu']:>8s} "
              f"{r['loop']:>8s} {r['flow']:>7s} {ratio[0]:6.1f} {ratio[1]:6.1f} {ratio[2]:6.1f} {ratio[3]:17.1f}  {r['result']}")


def write_csv(path, rows):
    with open(path, "w", newline="") as file:
        file.write(f"# {peers.machine()}; {peers.versions()}; {datetime.date.today()}\n")
        out = csv.DictWriter(file, COLUMNS)
        out.writeheader()
        out.writerows(r.numbers() for r in rows)


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ryusa", default=str(peers.ROOT / "build/ryusa"))
    parser.add_argument("--lammps", default="lmp", help="another binary of LAMMPS")
    parser.add_argument("--csv", default="bench-jobs.csv", help="file for the numbers")
    parser.add_argument("--job", nargs="+", choices=JOBS, default=JOBS)
    parser.add_argument("--beds", type=int, nargs="+", default=[1, 2, 3], help="seeds of the beds of q*")
    parser.add_argument("--cores", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--quick", action="store_true", help="one bed, fewer impacts")
    parser.add_argument("--calibrated", default=str(HERE / "jobs-calibrated.csv"),
                        help="q* at each time step, measured before")
    parser.add_argument("--calibrate", type=float, metavar="SECONDS",
                        help="measure them anew, with so much flow for each case (4: half an hour), and write that file")
    arguments = parser.parse_args()
    arguments.ryusa = str(Path(arguments.ryusa).resolve())
    arguments.beds = arguments.beds[:1] if arguments.quick else arguments.beds
    return arguments


def main():
    arguments = parse()
    print(f"{peers.machine()}\n{peers.versions()}")
    with tempfile.TemporaryDirectory(prefix="ryusa-jobs-") as folder:
        arguments.folder = Path(folder)
        rows = [row for job, run in (("flux", flux_job), ("restitution", restitution_job)) if job in arguments.job
                for row in run(arguments)]
    say(rows)
    write_csv(arguments.csv, rows)
    print(f"\nnumbers in {arguments.csv}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
