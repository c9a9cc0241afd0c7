# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""A made-up result file in the layout of the program's, for tests of postprocess/: no run is needed.

A bed of grains at rest under a sheared layer; flux with a transient, then AR(1) noise."""
import h5py
import numpy as np

D, LENGTH, STRESS = 0.5e-3, 10e-3, 3.2373


def element(group, name, step, time, value, unit):
    one = group.create_group(name)
    one["step"], one["time"], one["value"] = step, time, value
    one["value"].attrs["unit"] = unit
    one["time"].attrs["unit"] = "s"


def grains(frames, columns, layers, end, rng):
    """Positions and velocities over the frames; the top layers drift, faster with height."""
    x = np.concatenate([(np.arange(columns) + 0.5 * (k % 2)) * D for k in range(layers + 1)])
    z = np.repeat(np.arange(layers + 1) * 0.88 * D + 0.5 * D, columns)
    fixed = np.repeat(np.arange(layers + 1) == 0, columns)
    above = np.clip(z / D - 0.6 * layers, 0.0, None)
    speed = 0.012 * above ** 1.5 * (1 + 0.3 * rng.standard_normal(len(x))) * (above > 0)
    times = np.linspace(0.0, end, frames)
    position = np.empty((frames, len(x), 2))
    position[:, :, 0] = (x + times[:, None] * speed) % LENGTH
    hop = 0.25 * D * above * np.abs(np.sin(40 * times[:, None] + 6 * rng.random(len(x))))
    position[:, :, 1] = z + hop
    velocity = np.zeros_like(position)
    velocity[:, :, 0] = speed
    diameter = np.where(fixed, D, D * rng.uniform(0.9, 1.0, len(x)))
    return times, position, velocity, diameter, fixed


def profiles(layers):
    z = (np.arange(10 * layers) + 0.5) * 0.2 * D
    bed = 0.88 * layers * D
    phi = 0.6 / (1 + np.exp((z - 0.95 * bed) / (0.4 * D)))
    u_fluid = 0.3 * np.log1p(np.exp((z - 0.8 * bed) / D)) / 2
    share = 1 / (1 + np.exp((z - 0.85 * bed) / (0.6 * D)))
    moving = np.where(phi > 1e-4, 0.7 * u_fluid, 0.0)
    return {"z": z, "phi": phi, "u_grain": moving, "u_fluid": u_fluid, "tau_fluid": STRESS * (1 - share),
            "tau_grain": STRESS * share * (1 + 0.01 * np.sin(9 * z / D))}, bed


def write(path, frames=60, columns=20, layers=10, samples=2000, end=6.0, fluid=True, seed=1):
    rng = np.random.default_rng(seed)
    times, position, velocity, diameter, fixed = grains(frames, columns, layers, end, rng)
    profile, bed = profiles(layers)
    time = np.linspace(0.0, end, samples)
    noise = np.zeros(samples)
    for k in range(1, samples):
        noise[k] = 0.95 * noise[k - 1] + 0.31 * rng.standard_normal()
    q = np.clip(2.0 + 3.0 * np.exp(-(time - 0.3) / 0.4) + 0.4 * noise, 0.0, None) * (time >= 0.3)
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        home = file.create_group("particles/grains")
        box = home.create_group("box")
        box.attrs["dimension"] = 2
        box.attrs["boundary"] = ["periodic", "none"]
        box["edges"] = [LENGTH, 20e-3]
        step = np.rint(times / 20e-6).astype(int)
        element(home, "position", step, times, position, "m")
        element(home, "velocity", step, times, velocity, "m/s")
        element(home, "spin", step, times, velocity[:, :, 0] / D, "rad/s")
        home["diameter"], home["fixed"], home["id"] = diameter, fixed.astype("i4"), np.arange(len(diameter))
        home["density"] = np.full(len(diameter), 2650.0)
        seen = file.create_group("observables")
        step = np.rint(time / 20e-6).astype(int)
        for name, value, unit in (("q_star", q, "1"), ("q_b", q * 4.5e-5, "m2 s-1"),
                                  ("bed_level", bed + 0.05 * D * noise, "m"), ("kinetic_energy", 1e-7 * q, "J")):
            element(seen, name, step, time, value, unit)
        parameters = file.create_group("parameters").attrs
        parameters.update({"title": "synthetic", "program": "ryusa", "time.settle": 0.3, "grains.density": 2650.0,
                           "fluid.density": 1000.0, "domain.gravity": 9.81, "fluid.shear_stress": float("nan"),
                           "fluid.shields": 0.4 if fluid else float("nan"), "fluid.model": "balance" if fluid else "none"})
        if fluid:
            behind = q[time > 1.2]
            seen.create_group("flux").attrs.update({
                "q_star_mean": behind.mean(), "q_star_standard_error": 0.04, "autocorrelation_time": 0.06,
                "samples": len(behind), "equilibration_time": 1.2})
            group = seen.create_group("profile")
            for name, value in profile.items():
                group[name] = value
