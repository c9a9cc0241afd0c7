#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""fluid.mixing_length duran-moving: what lies deep in a bed at rest must not change the flow above it, so that a bed of
32 layers has the flux and the flow of one of 8; and the flow sets in over large beads without throwing any (with
duran, beads of 6 mm fly off at 2000 m/s)."""
import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; Debian: apt install python3-h5py")
    raise SystemExit(77)

SCENE = """\
time: {step: 20 us, end: 3 s, settle: 0.2 s}
grains: {diameter: 0.5 mm, columns: 16, layers: 8, seed: 2}
contact: {restitution: 0.5}
fluid: {shields: 0.4, mixing_length: duran-moving}
output: {interval: 20 ms, fields: [flux, profile]}
"""
BEADS = """\
time: {step: 70 us, end: 1.05 s, settle: 1 s}
grains: {diameter: 6 mm, density: 2500, columns: 40, layers: 15, seed: 1}
contact: {restitution: 0.5}
fluid: {shields: 1.2, mixing_length: duran-moving}
output: {fields: [flux]}
"""


class BedDepth(unittest.TestCase):
    def measure(self, folder, layers):
        (folder / "bed.yaml").write_text(SCENE)
        subprocess.run([os.environ["RYUSA"], "run", "bed.yaml", "-j1", "--quiet", "--force", "-o", "out.h5", "-s",
                        f"grains.layers={layers}"], cwd=folder, check=True, timeout=100)
        with h5py.File(folder / "out.h5") as file:
            flux, profile = file["observables/flux"].attrs, file["observables/profile"]
            level = file["observables/bed_level/value"][()][60:].mean()
            u = np.interp(level + 3 * 0.5e-3, profile["z"][()], profile["u_fluid"][()])
            return float(flux["q_star_mean"]), float(flux["q_star_standard_error"]), u

    def test_depth_does_not_matter(self):
        with tempfile.TemporaryDirectory() as name:
            (shallow, error, u), (deep, deep_error, deep_u) = (self.measure(Path(name), n) for n in (8, 32))
        # packings of 16 columns differ by 15 %
        self.assertLess(abs(deep - shallow), 3.0 * math.hypot(error, deep_error, 0.15 * shallow), (shallow, deep))
        self.assertLess(abs(deep_u / u - 1.0), 0.1, (u, deep_u))

    def test_flow_sets_in(self):
        with tempfile.TemporaryDirectory() as name:
            Path(name, "beads.yaml").write_text(BEADS)
            r = subprocess.run([os.environ["RYUSA"], "run", "beads.yaml", "-j1", "--quiet", "-o", "out.h5"], cwd=name,
                               text=True, stderr=subprocess.PIPE, timeout=100)
            self.assertEqual(r.returncode, 0, r.stderr)


if __name__ == "__main__":
    unittest.main()
