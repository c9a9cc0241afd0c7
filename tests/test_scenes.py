#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# Every scene of params/ runs from the command line, and what it was made to show is seen in its result.
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

RYUSA = os.environ["RYUSA"]
PARAMS = Path(os.environ["SOURCE_DIR"]) / "params"
SCENES = sorted(p.name for p in PARAMS.glob("*.yaml") if "scene:" not in p.read_text())


def run(folder, scene, *overrides):
    """The open result of a scene."""
    out = Path(folder) / (Path(scene).stem + ".h5")
    words = [word for override in overrides for word in ("-s", override)]
    done = subprocess.run([RYUSA, "run", str(PARAMS / scene), "-o", str(out), "--quiet", "--force", *words],
                          capture_output=True, text=True, timeout=250)
    if done.returncode != 0 or done.stderr:
        raise AssertionError(f"{scene}: exit {done.returncode}: {done.stderr}")
    return h5py.File(out)


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def test_all_start(self):
        """Each runs a few hundred steps; the newcomers of the folder too."""
        self.assertGreaterEqual(len(SCENES), 7)
        for scene in SCENES:
            with self.subTest(scene):
                show = subprocess.run([RYUSA, "show", str(PARAMS / scene)], capture_output=True, text=True)
                self.assertEqual(show.returncode, 0, show.stderr)
                step = float(next(line for line in show.stdout.splitlines() if line.startswith("TIME STEP")).split()[2])
                with run(self.folder.name, scene, f"time.end={300 * step}") as file:
                    self.assertTrue(np.isfinite(file["particles/grains/position/value"][:]).all())

    def test_bounce(self):
        """Each bounce keeps e^2 = 0.49 of the energy (Fujioka & Ushijima 2005, sections 5.2 and 5.3)."""
        with run(self.folder.name, "bounce-slow.yaml") as file:
            z = file["particles/grains/position/value"][:, 0, 1]
            v = file["particles/grains/velocity/value"][:, 0, 1]
            height = z - 112.5 + v * v / (2 * 9.8)  # of the free flight that a frame is in
            flights = [height[0]]
            for h in height[z > 112.5]:
                if h < 0.8 * flights[-1]:
                    flights.append(h)
            self.assertGreater(len(flights), 4)
            for before, after in zip(flights, flights[1:]):
                self.assertAlmostEqual(after / before, 0.49, delta=1e-6)

    def test_three_spheres(self):
        """The spheres driven apart end with d' = 0.271463 (paper, eq. 28)."""
        with run(self.folder.name, "three-spheres.yaml") as file:
            v = file["particles/grains/velocity/value"][-1]
            self.assertAlmostEqual(np.abs(v[:2, 0]).max() / np.sqrt(4 * 9.8 * 0.02), 0.271463, delta=2e-6)

    def test_oblique(self):
        """Momentum stays, energy falls."""
        with run(self.folder.name, "oblique.yaml") as file:
            v = file["particles/grains/velocity/value"][:]
            momentum = v.sum(axis=1)
            self.assertLess(np.abs(momentum - momentum[0]).max(), 1e-12 * np.abs(v).max())
            kinetic = file["observables/energy/kinetic/value"][:]
            self.assertLess(kinetic[-1], kinetic[0])

    def test_settle(self):
        """The bed comes to rest: 1e-12 of m g d per grain."""
        with run(self.folder.name, "settle.yaml", "time.end=2") as file:
            d = file["particles/grains/diameter"][:]
            scale = np.sum(np.pi / 6 * d**3 * file["particles/grains/density"][:] * 9.81 * d)
            self.assertLess(file["observables/kinetic_energy/value"][-1], 1e-12 * scale)
            self.assertIn("q* = q_b/sqrt(g d^3),", file["observables/flux"].attrs["convention"])

    def test_profile_carries_flux(self):
        """The integral of phi u_grain over height is the mean q_b of the same samples."""
        with run(self.folder.name, "flume.yaml", "time.end=2") as file:
            equilibration = file["observables/flux"].attrs["equilibration_time"]
            profile = file["observables/profile"]
            z, carried = profile["z"][:], np.sum(profile["phi"][:] * profile["u_grain"][:])
            frames = file["observables/profile_series/phi/time"][:]
            first = frames[frames > equilibration][0]  # a frame averages the samples since the one before
            series = file["observables/q_b"]
            times = series["time"][:]
            interval = frames[1] - frames[0]
            inside = (times > first - interval + 1e-9) & (times < frames[-1] + 1e-9)
            q_b = series["value"][inside].mean()
            self.assertGreater(inside.sum(), 300)
            self.assertAlmostEqual(carried * (z[1] - z[0]) / q_b, 1.0, delta=3e-3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
