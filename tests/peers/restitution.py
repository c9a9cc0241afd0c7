#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The largest time step at which LAMMPS gives binary impacts their restitution, mean and worst over the phase of a
step in which the grains meet: 64 pairs of grains meet head on, each at another phase. T is the period of a grain on
its spring, as in docs/accuracy.md, which has the same of ryusa's laws."""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

D, DENSITY, SPEED, PERIOD, DAMPING_RATIO, PAIRS = 5e-4, 2650.0, 0.05, 4e-4, 0.2155, 64

SCRIPT = """
units si
atom_style sphere
dimension 2
newton off
boundary f f p
comm_modify vel yes
read_data {data}
neighbor {skin} bin
pair_style gran/hooke/history {k} NULL {gamma} NULL 0.0 0 limit_damping
pair_coeff * *
timestep {dt}
fix motion all nve/sphere
fix plane all enforce2d
run {steps}
write_dump all custom {out} id vx modify sort id format float %.15g
"""


def write_pairs(path, dt):
    """Row k begins k/PAIRS of a step's approach further apart."""
    with open(path, "w") as file:
        file.write(f"pairs\n\n{2 * PAIRS} atoms\n1 atom types\n\n{-20 * D} {20 * D} xlo xhi\n"
                   f"{-3 * D} {3 * D * PAIRS} ylo yhi\n{-0.5 * D} {0.5 * D} zlo zhi\n\nAtoms\n\n")
        for k in range(PAIRS):
            half = 0.5 * (D + SPEED * dt * (1.0 + k / PAIRS))
            for side in (-1, 1):
                file.write(f"{2 * k + (side + 3) // 2} 1 {D} {DENSITY} {side * half!r} {3 * D * k!r} 0\n")
        file.write("\nVelocities\n\n")
        for k in range(PAIRS):
            for side in (-1, 1):
                file.write(f"{2 * k + (side + 3) // 2} {-0.5 * side * SPEED!r} 0 0 0 0 0\n")


def restitution(folder, parts):
    """Of each pair, with time steps of PERIOD / parts."""
    mass = np.pi / 6.0 * D ** 3 * DENSITY
    k = mass * (2.0 * np.pi / PERIOD) ** 2
    gamma = 2.0 * DAMPING_RATIO * np.sqrt(k / (0.5 * mass))
    dt = PERIOD / parts
    write_pairs(folder / "pairs.data", dt)
    steps = int(PERIOD / dt) + 5
    (folder / "in").write_text(SCRIPT.format(data=folder / "pairs.data", skin=0.5 * D, k=k, gamma=gamma, dt=dt,
                                             steps=steps, out=folder / "out"))
    done = subprocess.run(["lmp", "-log", "none", "-in", folder / "in"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stdout[-1500:])
    speed = np.loadtxt(folder / "out", skiprows=9)[:, 1]
    return (speed[1::2] - speed[::2]) / SPEED


def main():
    with tempfile.TemporaryDirectory() as folder:
        exact = restitution(Path(folder), 40000).mean()
        print(f"restitution in the limit of small steps {exact:.6f}")
        print(f"{'T/dt':>6s} {'mean':>9s} {'worst':>9s}   relative errors")
        for parts in (8, 11, 16, 22, 32, 45, 64, 90, 128, 180, 256, 360, 512, 1024):
            e = restitution(Path(folder), parts)
            print(f"{parts:6d} {e.mean() / exact - 1.0:9.2%} {np.abs(e / exact - 1.0).max():9.2%}")


if __name__ == "__main__":
    main()
