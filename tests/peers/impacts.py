# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The job "restitution within 1 %" in ryusa and in LAMMPS: pairs of grains that meet, and a gas
that cools. docs/performance.md, "Time to a given error", has the definitions."""
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import programs
import state as states
from programs import D, HERE, call

DENSITY, PERIOD = 2650.0, 4e-4
PAIRS, GRAINS = 5000, 10000
MEETING = 20.0  # a pair meets at some time within so many periods: a mean free time of ten
# T/dt; errors are against the last. ryusa allows law energy T/8.5 where there are more than two grains.
LADDER = {"pairs": (8.8, 11, 16, 22, 32, 45, 64, 90, 128, 180, 256, 360, 1024),
          "gas": (8.8, 11, 16, 22, 32, 45, 64, 128)}


@dataclass
class Scene:
    """Grains in the order of their ids, SI."""
    name: str
    e: float
    position: np.ndarray
    velocity: np.ndarray
    diameter: np.ndarray
    fixed: np.ndarray
    length: float     # of a periodic x; 0: unbounded
    seconds: float

    def steps(self, parts):
        return int(np.ceil(self.seconds * parts / PERIOD))

    @property
    def mass(self):
        return np.pi / 6.0 * self.diameter ** 3 * DENSITY


def pairs(e, seed=1, count=PAIRS):
    """Grains of unequal sizes that meet head on: directions, speeds and times of meeting are random."""
    r = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(count)))
    centre = 6.0 * D * np.stack([np.arange(count) % side, np.arange(count) // side + 1.0], axis=1)
    angle, speed = r.uniform(0.0, 2.0 * np.pi, count), 0.02 * 10.0 ** r.uniform(0.0, 1.0, count)
    axis = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    diameter = D * r.uniform(0.9, 1.1, (count, 2))
    apart = 0.5 * diameter.sum(axis=1) + speed * PERIOD * r.uniform(0.3, 0.3 + MEETING, count)
    position = np.stack([centre - 0.5 * apart[:, None] * axis, centre + 0.5 * apart[:, None] * axis], axis=1)
    velocity = 0.5 * speed[:, None, None] * np.stack([axis, -axis], axis=1)
    return Scene("pairs", e, position.reshape(-1, 2), velocity.reshape(-1, 2), diameter.ravel(),
                 np.zeros(2 * count, int), 0.0, (MEETING + 1.3) * PERIOD)


def gas(e, seed=1, count=GRAINS):
    """Grains at a solid fraction of 0.3 between two rows of fixed ones, x periodic, no gravity."""
    r = np.random.default_rng(seed)
    side, room = int(np.sqrt(count)), 1.6 * D
    where = np.stack([np.arange(side * side) % side + 0.5, np.arange(side * side) // side + 1.0], axis=1) * room
    position = where + r.uniform(-0.2, 0.2, where.shape) * D
    row = np.arange(int(side * room / D) + 1) * side * room / (int(side * room / D) + 1)
    edges = [np.stack([row, np.full(len(row), z)], axis=1) for z in (0.0, (side + 1) * room)]
    velocity = np.concatenate([r.normal(0.0, 0.1, position.shape), np.zeros((2 * len(row), 2))])
    diameter = np.concatenate([D * r.uniform(0.9, 1.1, len(position)), np.full(2 * len(row), D)])
    fixed = np.repeat([0, 1], [len(position), 2 * len(row)])
    return Scene("gas", e, np.concatenate([position, *edges]), velocity, diameter, fixed, side * room, 0.02)


def realised(scene, velocity):
    """pairs: restitution of each. gas: how far it has cooled, t/t_c in E = E0/(1 + t/t_c)^2 (Haff 1983)."""
    if scene.name == "pairs":
        along = scene.position[1::2] - scene.position[::2]
        before, after = (((v[1::2] - v[::2]) * along).sum(axis=1) for v in (scene.velocity, velocity))
        return -after / before
    moving = scene.fixed == 0
    before, after = ((scene.mass[moving] * (v[moving] ** 2).sum(axis=1)).sum() for v in (scene.velocity, velocity))
    return np.array([np.sqrt(before / after) - 1.0])


def errors(found, limit):
    """Relative errors of the mean, and the worst."""
    return abs(found.mean() / limit.mean() - 1.0), np.abs(found / limit - 1.0).max()


def stiffness():
    return np.pi / 6.0 * D ** 3 * DENSITY * (2.0 * np.pi / PERIOD) ** 2


# --- ryusa ----------------------------------------------------------------------------------------


def write_scene(scene, path):
    """The scene, and its grains in a table beside it."""
    table = path.with_suffix(".csv")
    x = f"{{length: {scene.length!r}, periodic: true}}" if scene.length else "{periodic: false}"
    with open(path, "w") as file:
        file.write(f"domain: {x}\ncontact: {{stiffness: {stiffness()!r}, restitution: {scene.e}, friction: 0}}\n"
                   "output: {fields: [flux], interval: 1 s}\n"
                   f"particles: [{{file: {table.name}, density: {DENSITY}}}]\n")
    with open(table, "w") as file:
        file.write("x,z,vx,vz,diameter,fixed\n")
        for (x, z), (vx, vz), d, fixed in zip(scene.position.tolist(), scene.velocity.tolist(),
                                              scene.diameter.tolist(), scene.fixed.tolist()):
            file.write(f"{x!r},{z!r},{vx!r},{vz!r},{d!r},{fixed}\n")


def ryusa(program, scene, folder, law, parts, cores):
    """Velocities at the end, and seconds of the step loop. The scene lies in `folder`."""
    dt = PERIOD / parts
    call(programs.pinned([program, "run", f"{scene.name}.yaml", "-o", "impacts.h5", "--force", "--quiet",
                          "-s", f"contact.law={law}", "-s", f"time.step={dt!r}",
                          "-s", f"time.end={scene.steps(parts) * dt!r}"], cores), folder)
    import h5py
    with h5py.File(folder / "impacts.h5") as file:
        loop = float(file["cost"].attrs["wall_seconds"])
    s = states.read(folder / "impacts.h5")
    return np.stack([s.vx, s.vz], axis=1), loop


# --- LAMMPS ---------------------------------------------------------------------------------------


def write_data(scene, path):
    low, high = scene.position.min(axis=0) - 3.0 * D, scene.position.max(axis=0) + 3.0 * D
    if scene.length:
        low[0], high[0] = 0.0, scene.length
    with open(path, "w") as file:
        file.write(f"impacts\n\n{len(scene.diameter)} atoms\n2 atom types\n\n{low[0]!r} {high[0]!r} xlo xhi\n"
                   f"{low[1]!r} {high[1]!r} ylo yhi\n{-0.5 * D!r} {0.5 * D!r} zlo zhi\n\nAtoms\n\n")
        for k, ((x, z), d) in enumerate(zip(scene.position.tolist(), scene.diameter.tolist())):
            file.write(f"{k + 1} {1 + scene.fixed[k]} {d!r} {DENSITY} {x!r} {z!r} 0\n")
        file.write("\nVelocities\n\n")
        for k, (vx, vz) in enumerate(scene.velocity.tolist()):
            file.write(f"{k + 1} {vx!r} {vz!r} 0 0 0 0\n")


def lammps(binary, scene, folder, parts, cores):
    """As ryusa()."""
    reduced = 0.5 * np.pi / 6.0 * D ** 3 * DENSITY
    zeta = -np.log(scene.e) / np.hypot(np.pi, np.log(scene.e))
    values = {"data": f"{scene.name}.data", "along": "p" if scene.length else "f", "skin": 0.3 * D, "k": stiffness(),
              "gamma": 2.0 * zeta * np.sqrt(stiffness() / reduced), "dt": PERIOD / parts, "steps": scene.steps(parts)}
    mpi = [] if cores == 1 else ["mpirun", "--bind-to", "none", "-np", str(cores)]
    text = call(programs.pinned([*mpi, binary, "-log", "none", "-in", str(HERE / "impacts.lammps"),
                                 *[w for name, v in values.items() for w in ("-var", name, str(v))]], cores), folder,
                {"OMP_NUM_THREADS": "1"})
    loop = float(re.findall(r"Loop time of (\S+)", text)[-1])
    return np.loadtxt(folder / "impacts.out", skiprows=9)[:, 1:], loop


# --- the largest step ------------------------------------------------------------------------------


def lay(scene, folder):
    write_scene(scene, folder / f"{scene.name}.yaml")
    write_data(scene, folder / f"{scene.name}.data")


def table(run, scene):
    """parts -> errors of mean and worst; run(parts) gives velocities, or raises where a step is refused."""
    ladder = LADDER[scene.name]
    limit = realised(scene, run(ladder[-1])[0])
    found = {}
    for parts in ladder[:-1]:
        try:
            found[parts] = errors(realised(scene, run(parts)[0]), limit)
        except programs.Failed:
            continue
    return found


# A gas of so many grains tells its cooling to half a percent: where grains meet is another matter at each step.
GOAL = {"pairs": 0.01, "gas": 0.015}


def largest(found, which, goal):
    """The fewest steps in a period from which on all smaller steps are as good; None: there is none."""
    best = None
    for parts in sorted(found, reverse=True):
        if not found[parts][which] <= goal:
            break
        best = parts
    return best
