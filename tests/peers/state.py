# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""A state of ryusa, read from the checkpoint of a result file, and what other programs need to go on from it."""
from dataclasses import dataclass

import h5py
import numpy as np

KAPPA = 0.41  # von Karman's constant in ryusa


@dataclass
class State:
    """Grains in the order of their ids, SI; the plane is x, z; spin is positive from z towards x."""
    x: np.ndarray
    z: np.ndarray
    vx: np.ndarray
    vz: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    density: np.ndarray
    fixed: np.ndarray
    length: float
    parameters: dict
    contacts: int      # pairs that touch
    bed_level: float
    fluid: np.ndarray  # the fluid's velocity in cells of height `cell` from z = 0 on
    cell: float
    step: int

    @property
    def movable(self):
        return int(np.count_nonzero(self.fixed == 0))

    def law(self):
        """Constants of the linear law between two mean grains: k, kt [N/m], eta, eta_t [N s/m], reduced mass [kg]."""
        p = self.parameters
        mass = np.pi / 6.0 * p["grains.diameter"] ** 3 * p["grains.density"]
        reduced = 0.5 * mass
        k = mass * (2.0 * np.pi / (p["contact.alpha_m"] * p["time.step"])) ** 2
        log_e = np.log(p["contact.restitution"])
        zeta = -log_e / np.sqrt(np.pi ** 2 + log_e ** 2)
        eta = 2.0 * zeta * np.sqrt(k * reduced)
        ratio = 1.0 / (2.0 * (1.0 + p["contact.poisson"]))
        return {"k": k, "kt": k * ratio, "eta": eta, "eta_t": eta * np.sqrt(ratio), "reduced": reduced,
                "mu": p["contact.friction"]}

    def gravity(self):
        """Of a grain in the fluid: less its buoyancy."""
        p = self.parameters
        lift = p["fluid.density"] / p["grains.density"] if p["fluid.model"] != "none" else 0.0
        return p["domain.gravity"] * (1.0 - lift)

    def friction_velocity(self):
        p = self.parameters
        weight = (p["grains.density"] - p["fluid.density"]) * p["domain.gravity"]
        tau = p["fluid.shields"] * weight * p["grains.diameter"]
        return np.sqrt(tau / p["fluid.density"])

    def seen(self, z):
        """The fluid's velocity as ryusa's grains see it: averaged over a sphere of mean diameter about z."""
        s = (np.arange(64) + 0.5) / 32.0 - 1.0
        weight = 1.0 - s * s
        cells = (np.arange(len(self.fluid)) + 0.5) * self.cell
        at = np.asarray(z)[..., None] + 0.5 * self.parameters["grains.diameter"] * s
        return np.interp(at, cells, self.fluid) @ weight / weight.sum()

    def level(self):
        """Where a log law that is looked up at the grains' centres must begin to give them the same mean velocity."""
        z = self.z[self.fixed == 0]
        wanted = self.seen(z).mean()
        d = self.parameters["grains.diameter"]
        low, high = self.bed_level - d, self.bed_level + d
        for _ in range(50):
            middle = 0.5 * (low + high)
            over = np.maximum(30.0 * (z - middle) / self.parameters["fluid.roughness"], 1.0)
            if (self.friction_velocity() / KAPPA * np.log(over)).mean() > wanted:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)


def read(path):
    with h5py.File(path) as file:
        checkpoint = file["checkpoint"]
        slot = max((checkpoint[s] for s in "ab" if s in checkpoint), key=lambda s: s.attrs["sequence"])
        grains = {name: slot["grains"][name][:] for name in
                  ("x", "z", "vx", "vz", "spin", "radius", "density", "fixed")}
        parameters = {k: v.decode() if isinstance(v, bytes) else v for k, v in file["parameters"].attrs.items()}
        fluid = slot["column/u"][:] if "column/u" in slot else np.zeros(0)
        return State(**grains, length=float(file["particles/grains/box/edges"][0]), parameters=parameters,
                     contacts=int(slot.attrs["contacts"]), bed_level=float(slot.attrs.get("bed_level", 0.0)),
                     fluid=fluid, cell=float(slot.attrs.get("cell_height", 0.0)), step=int(slot.attrs["step"]))


def write_data(state, path):
    """A data file of LAMMPS and LIGGGHTS, atom style sphere: x along x, z along y. Type 1 moves, type 2 is fixed."""
    n, d = len(state.x), 2.0 * state.radius.max()
    top, bottom = 2.0 * state.z.max() + 20.0 * d, -2.0 * d
    with open(path, "w") as file:
        file.write(f"a bed of ryusa\n\n{n} atoms\n2 atom types\n\n0 {state.length!r} xlo xhi\n"
                   f"{bottom!r} {top!r} ylo yhi\n{-0.5 * d!r} {0.5 * d!r} zlo zhi\n\nAtoms\n\n")
        for k in range(n):
            file.write(f"{k + 1} {1 + int(state.fixed[k] != 0)} {2.0 * state.radius[k]!r} {state.density[k]!r} "
                       f"{state.x[k]!r} {state.z[k]!r} 0\n")
        file.write("\nVelocities\n\n")
        for k in range(n):
            file.write(f"{k + 1} {state.vx[k]!r} {state.vz[k]!r} 0 0 0 {-state.spin[k]!r}\n")
