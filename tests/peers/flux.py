# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The job "q* at theta = 0.2, 0.4, 0.8 to 5 %": one bed in ryusa and in LAMMPS. docs/performance.md, "Time to a given
error", has the definitions."""
import dataclasses
import os
import re
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import known
import numpy as np
import programs
import state as states
from programs import D, HERE, Failed, call

SCENE = HERE.parent.parent / "params/bench-sheared.yaml"
PERIOD = 4e-4                 # of a grain on its spring: the springs are the same whatever the step is [s]
LEVEL = {0.2: 9.2, 0.4: 8.8, 0.8: 8.0}  # where the profile begins, in diameters above the floor
SETTLE, AFTER = 0.05, 1.0     # the fluid starts; a run is not ended before it has flowed for AFTER [s]
SAMPLE, LOOK = 1e-3, 0.1      # between samples of q*, and between looks at its error [s]
STATISTICAL = SYSTEMATIC = 0.025
# T/dt; a millisecond must be a whole number of steps. The last one is what the others are judged by. In a bed of
# these sizes ryusa allows law energy T/8.5 and cundall T/11.3.
LADDER = {"ryusa energy": (8.8, 10, 12, 16, 20, 28, 56), "ryusa cundall": (14, 16, 20, 28, 56),
          "LAMMPS": (8, 10, 12, 14, 16, 20, 28, 56)}


def settings(bed, parts, law):
    """-s options of ryusa: T/parts; `bed` is the seed of its grains."""
    stiffness = np.pi / 6.0 * D ** 3 * 2650.0 * (2.0 * np.pi / PERIOD) ** 2
    keys = {"grains.columns": 40, "grains.layers": 10, "grains.seed": bed, "time.settle": SETTLE,
            "time.step": PERIOD / parts, "contact.stiffness": float(stiffness), "contact.law": law,
            "fluid.advance": 1000,  # an imposed profile does not change
            "output.fields": "[flux]", "output.interval": LOOK / 10}
    return keys


def words(keys):
    return [word for key, value in keys.items() for word in ("-s", f"{key}={value}")]


def q_of(series_file):
    with h5py.File(series_file) as file:
        q, t = file["observables/q_star/value"][:], file["observables/q_star/time"][:]
        return q[t > SETTLE]


# --- ryusa ----------------------------------------------------------------------------------------


def ryusa_series(program, law, theta, bed, parts, seconds, core):
    with tempfile.TemporaryDirectory() as folder:
        keys = {**settings(bed, parts, law), "fluid.shields": theta, "fluid.level": LEVEL[theta] * D,
                "time.end": SETTLE + seconds}
        call(["taskset", "-c", str(core), program, "run", str(SCENE), "-j1", "--quiet", "-o", "run.h5", *words(keys)],
             folder)
        return q_of(Path(folder) / "run.h5")


def sweep_text(law, bed, parts, model):
    keys = {**settings(bed, parts, law), "stop.flux_error": STATISTICAL, "stop.after": SETTLE + AFTER,
            "time.end": SETTLE + 100.0, "fluid.model": model}
    if model != "log":
        del keys["fluid.advance"]
    lines = [f"scene: {SCENE}", "set:", *[f"  {key}: {value}" for key, value in keys.items()], "sample: list", "vary:",
             f"  fluid.shields: {list(LEVEL)}"]
    if model == "log":
        lines.append(f"  fluid.level: {[level * D for level in LEVEL.values()]}")
    return "\n".join(lines) + "\n"


def ryusa_job(program, law, bed, parts, cores, model="log"):
    """The whole job by `ryusa sweep`, from grains on a lattice on. Returns {theta: (q*, seconds of flow)}."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "job.yaml").write_text(sweep_text(law, bed, parts, model))
        call(programs.pinned([program, "sweep", "job.yaml", "-o", "job.h5", "--quiet", "-j", str(cores)], cores),
             folder)
        with h5py.File(Path(folder) / "job.h5") as file:
            cases = file["cases"]
            ends = [file[f"results/case-{n:04d}/observables/q_star/time"][-1] for n in cases["case"][:].astype(int)]
            return {theta: (q, end - SETTLE) for theta, q, end in
                    zip(cases["shields"][:].round(6), cases["q_star"][:], ends)}


# --- LAMMPS ---------------------------------------------------------------------------------------


def rest(program, bed, folder):
    """The bed that LAMMPS goes on from: what ryusa has when the fluid starts."""
    keys = {**settings(bed, 20, "cundall"), "time.end": SETTLE, "fluid.shields": 0.4}
    call([program, "run", str(SCENE), "--quiet", "-o", f"rest-{bed}.h5", *words(keys)], folder)
    state = states.read(folder / f"rest-{bed}.h5")
    states.write_data(state, folder / f"rest-{bed}.data")
    return state


def shifted_level(state, theta):
    """ryusa averages the profile over a grain, LAMMPS looks it up at the centre."""
    keys = {**state.parameters, "fluid.shields": theta}
    s = dataclasses.replace(state, parameters=keys, bed_level=LEVEL[theta] * D)
    z = (np.arange(len(s.fluid)) + 0.5) * s.cell
    over = np.maximum(30.0 * (z - s.bed_level) / keys["fluid.roughness"], 1.0)
    s.fluid = s.friction_velocity() / states.KAPPA * np.log(over)
    return s.level(), s.friction_velocity() / states.KAPPA


def lammps_words(state, theta, bed, parts, seconds, everywhere):
    p, law, dt = state.parameters, state.law(), PERIOD / parts
    level, speed = shifted_level(state, theta)
    sample = round(SAMPLE / dt)
    values = {"data": f"rest-{bed}.data", "k": law["k"], "kt": law["kt"], "gamma": law["eta"] / law["reduced"],
              "gamma_t": law["eta_t"] / law["reduced"], "mu": law["mu"], "dt": dt, "g": state.gravity(),
              "skin": 0.7 * D, "drag": HERE / "drag.txt", "rho": p["fluid.density"], "nu": p["fluid.viscosity"],
              "c": p["fluid.drag_coefficient"], "level": level, "per_ks": 30.0 / p["fluid.roughness"],
              "us_kappa": speed, "from": -1.0 if everywhere else (LEVEL[theta] - 0.5) * D, "sample": sample,
              "regroup": 5 * sample, "steps": round(seconds / SAMPLE) * sample}
    return [word for name, value in values.items() for word in ("-var", name, str(value))]


def lammps_series(binary, folder, state, theta, bed, parts, seconds, cores=1, core=0, everywhere=False):
    """q* every SAMPLE. On one core, or on two by MPI."""
    mpi = [] if cores == 1 else ["mpirun", "--bind-to", "none", "-np", str(cores)]
    where = str(core) if cores == 1 else f"0-{cores - 1}"
    text = call(["taskset", "-c", where, *mpi, binary, "-log", "none", "-in", str(HERE / "jobs.lammps"),
                 *lammps_words(state, theta, bed, parts, seconds, everywhere)], folder, {"OMP_NUM_THREADS": "1"}, 3000)
    rows = dict(re.findall(r"^ *(\d+) +([-+.e\d]+|-?nan|-?inf) *$", text, re.M))
    rows.pop("0", None)
    carried = np.array([float(v) for v in rows.values()])
    d, p = D, state.parameters
    unit = np.sqrt((p["grains.density"] / p["fluid.density"] - 1.0) * p["domain.gravity"] * d ** 3)
    q = 4.0 / 3.0 * np.pi * carried / (state.length * d * unit)
    if not np.isfinite(q).all() or len(q) < round(seconds / SAMPLE):
        raise Failed(f"LAMMPS: q* is no number\n{text[-500:]}")
    return q


def lammps_job(binary, folder, state, bed, parts, lengths, way, everywhere=False):
    """The three runs one after the other (way "1"), side by side on two cores ("2 serial"), or each on both ("2 MPI")."""
    def one(theta, core, cores):
        q = lammps_series(binary, folder, state, theta, bed, parts, lengths[theta], cores, core, everywhere)
        return theta, (known.mean(q)[0], lengths[theta])
    longest_first = sorted(lengths, key=lengths.get, reverse=True)
    if way != "2 serial":
        return dict(one(theta, 0, 2 if way == "2 MPI" else 1) for theta in longest_first)
    free = [0, 1]

    def on_a_free_core(theta):
        core = free.pop()
        try:
            return one(theta, core, 1)
        finally:
            free.append(core)
    with ThreadPoolExecutor(2) as pool:
        return dict(pool.map(on_a_free_core, longest_first))
