# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The programs that are compared: each goes on from a state of ryusa for warm + rounds x steps steps and tells
how long each round took, and what came out."""
import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import state as states

HERE = Path(__file__).resolve().parent
D = 5e-4  # mean diameter of the scenes [m]


class Failed(Exception):
    pass


@dataclass
class Work:
    """One scene at one size, laid out for everybody."""
    scene: str
    grains: int      # that can move
    folder: Path
    state: states.State
    settings: list   # -s options of ryusa
    steps: int       # of a round; before the first some that are not timed
    rounds: int

    @property
    def warm(self):
        return max(self.steps // 4, 5)


@dataclass
class Outcome:
    seconds: list = field(default_factory=list)  # of each round
    steps: int = 0                               # of a round
    ends: list = field(default_factory=list)     # of each round: kinetic energy of the centres [J], mean height of the
                                                 # grains that move [m], pairs that touch

    @property
    def mean(self):
        """Energy, height and contacts, mean over the ends of the rounds."""
        return np.mean(self.ends, axis=0)


def pinned(command, cores):
    return ["taskset", "-c", "0" if cores == 1 else f"0-{cores - 1}"] + command


def call(command, folder, extra=None, seconds=900):
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_btl_base_warn_component_unused": "0",
                   **(extra or {})}
    done = subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True, timeout=seconds,
                          stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise Failed(f"{' '.join(map(str, command[:6]))} ...: status {done.returncode}\n{done.stdout[-800:]}"
                     f"{done.stderr[-800:]}")
    return done.stdout


# --- ryusa ----------------------------------------------------------------------------------------


def measure_state(s):
    moving = s.fixed == 0
    mass = 4.0 / 3.0 * np.pi * s.radius ** 3 * s.density
    return (0.5 * (mass * (s.vx ** 2 + s.vz ** 2))[moving].sum(), s.z[moving].mean(), s.contacts)


# What is measured and written: what the peers compute, or everything at the default interval.
FIELDS = {"plain": ["-s", "output.fields=[flux]", "-s", "output.interval=150 ms"],
          "measured": ["-s", "output.fields=[position, velocity, spin, flux, energy, profile]",
                       "-s", "output.interval=10 ms"]}


def ryusa(program, start):
    """Plain `ryusa run`, going on from the result file that `start` names."""
    def run(work, cores):
        import h5py
        path = work.folder / f"timed-{start}.h5"
        shutil.copy(work.folder / f"{start}.h5", path)
        outcome = Outcome(steps=work.steps)
        ends = [work.state.step + work.warm + k * work.steps for k in range(work.rounds + 1)]
        dt = work.state.parameters["time.step"]
        for number, end in enumerate(ends):
            call(pinned([program, "run", work.settings[0], "-o", str(path), "--resume", "--quiet", *work.settings[1:],
                         *FIELDS[start], "-s", f"time.end={end * dt!r}"], cores), work.folder)
            if number:
                with h5py.File(path) as file:
                    outcome.seconds.append(float(file["cost"].attrs["wall_seconds"]))
                outcome.ends.append(measure_state(states.read(path)))
        path.unlink()
        return outcome
    return run


# --- LAMMPS, LIGGGHTS -----------------------------------------------------------------------------


def variables(work, from_height):
    s, p, law = work.state, work.state.parameters, work.state.law()
    settled = work.scene == "settled"
    # gamma times the reduced mass is what ryusa calls eta
    values = {"data": "bed.data", "k": law["k"], "kt": law["kt"], "gamma": law["eta"] / law["reduced"],
              "gamma_t": law["eta_t"] / law["reduced"], "mu": law["mu"], "dt": p["time.step"], "g": s.gravity(),
              "skin": (0.1 if settled else 0.5) * D, "warm": work.warm, "steps": work.steps, "rounds": work.rounds,
              "drag": "/dev/null" if settled else HERE / "drag.txt"}
    if not settled:
        values |= {"rho": p["fluid.density"], "nu": p["fluid.viscosity"], "c": p["fluid.drag_coefficient"],
                   "level": s.level(), "per_ks": 30.0 / p["fluid.roughness"],
                   "us_kappa": s.friction_velocity() / states.KAPPA, "from": from_height}
    return [word for name, value in values.items() for word in ("-var", name, str(value))]


def read_lammps(text, work):
    outcome = Outcome(steps=work.steps)
    loops = [float(m[1]) for m in re.finditer(r"Loop time of (\S+) on .* for (\d+) steps", text)
             if int(m[2]) == work.steps]
    outcome.seconds = loops[-work.rounds:]
    rows = {}  # a step is shown at the end of a run and again before the next, where contacts are not counted aright
    for step, *row in re.findall(r"^ *(\d+) +([-+.e\d]+) +([-+.e\d]+) +([-+.e\d]+) *$", text, re.M):
        rows.setdefault(int(step), [float(v) for v in row])
    outcome.ends = [(energy, height, touches / 2.0) for energy, height, touches in list(rows.values())[-work.rounds:]]
    if len(outcome.seconds) != work.rounds or len(outcome.ends) != work.rounds:
        raise Failed(f"no times in\n{text[-1500:]}")
    return outcome


def lammps(program, script, top_only=False):
    def run(work, cores):
        above = work.state.bed_level - 0.5 * D if top_only else -1.0
        command = ([] if cores == 1 else ["mpirun", "--bind-to", "none", "-np", str(cores)]) + \
            [program, "-log", "none", "-in", str(HERE / script), *variables(work, above)]
        return read_lammps(call(pinned(command, cores), work.folder), work)
    return run


# --- YADE -----------------------------------------------------------------------------------------


def drag_ratio(s):
    """Drag on all grains over what YADE's formula gives."""
    p, moving = s.parameters, s.fixed == 0
    d = 2.0 * s.radius[moving]
    speed = np.hypot(s.seen(s.z[moving]) - s.vx[moving], s.vz[moving])
    viscous = p["fluid.viscosity"] / d
    own = (np.sqrt(p["fluid.drag_coefficient"] * speed) + np.sqrt(24.0 * viscous)) ** 2
    return float((d * d * own * speed).sum() / (d * d * (0.44 * speed + 24.4 * viscous) * speed).sum())


def yade(program):
    def run(work, cores):
        s, p = work.state, work.state.parameters
        settled = work.scene == "settled"
        denser = 1.0 if settled else drag_ratio(s)
        centres = (np.arange(len(s.fluid)) + 0.5) * s.cell
        task = {"state": str(work.folder / "bed.npz"), "law": s.law(), "length": s.length, "dt": p["time.step"],
                "skin": -0.2 if settled else -0.7, "gravity": p["domain.gravity"],
                "warm": work.warm, "steps": work.steps, "rounds": work.rounds,
                "rho": p["fluid.density"] * denser, "lift": p["domain.gravity"] / denser,
                "nu": p["fluid.viscosity"], "cell": s.cell, "fluid": [] if settled else s.seen(centres).tolist()}
        text = call(pinned([program, "-n", "-x", f"-j{cores}", str(HERE / "bed_yade.py")], cores), work.folder,
                    {"PEERS_TASK": json.dumps(task)})
        rounds = [json.loads(line.split("peers: ", 1)[1]) for line in text.splitlines() if "peers: {" in line]
        if len(rounds) != work.rounds:
            raise Failed(f"YADE ended early:\n{text[-1500:]}")
        return Outcome([r["seconds"] for r in rounds], work.steps,
                       [(r["energy"], r["height"], r["contacts"]) for r in rounds])
    return run
