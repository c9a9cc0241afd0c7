#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa threshold on a small bed: brackets, hysteresis the right way round, the same on any number of
cores, what is refused."""
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; Debian: apt install python3-h5py")
    raise SystemExit(77)

PROGRAM = os.environ["RYUSA"]
SCENE = """\
time: {step: 20 us, end: 1.4 s, settle: 0.2 s}
grains: {columns: 6, layers: 3, seed: 3}
fluid: {shields: 0.2}
"""
COARSE = ("--low", "0.005", "--high", "0.6", "--tolerance", "0.1")


class Threshold(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "scene.yaml").write_text(SCENE)

    def threshold(self, *words):
        return subprocess.run([PROGRAM, "threshold", *words], cwd=self.folder, text=True, timeout=200,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def refuses(self, status, *words, says=()):
        r = self.threshold(*words)
        self.assertEqual((r.returncode, r.stdout), (status, ""), (words, r.stderr))
        for text in says:
            self.assertIn(text, r.stderr)

    def test_search(self):
        r = self.threshold("scene.yaml", "-n", "2", *COARSE, "-o", "t.h5", "-j", "2")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertRegex(r.stdout, r"(?m)^from rest +0\.\d+ \+- \S+ +\(95 %: \S+ to \S+\)")
        self.assertRegex(r.stdout, r"(?m)^from motion +0\.\d+ \+- ")
        number = r"(-?[\d.e+-]+)"
        told = re.search(rf"(?m)^difference +{number} \+- {number} +\(95 %: {number} to {number}\)$", r.stdout)
        self.assertTrue(told, r.stdout)
        mean, error, low, high = map(float, told.groups())
        self.assertAlmostEqual((high - low) / (2 * 12.706 * error), 1.0, delta=0.1)  # one degree of freedom
        self.assertIn("soulsby-whitehouse 0.0308", r.stdout)
        self.assertRegex(r.stderr, r"(?m)^100 %  20 of 20 trials")
        with h5py.File(self.folder / "t.h5") as file:
            for start in ("rest", "motion"):
                low, high = file[start + "/low"][()], file[start + "/high"][()]
                self.assertTrue((high - low <= 0.1).all() and (high > low).all())
                np.testing.assert_allclose(file[start].attrs["mean"], ((low + high) / 2).mean())
                self.assertEqual(file[start + "/seed"][()].tolist(), [3, 4])
                trials = file["trials"]
                mine = np.array([word == start.encode() for word in trials["start"][()]])
                for k, seed in enumerate((3, 4)):
                    one = mine & (trials["seed"][()] == seed)
                    theta, moves = trials["shields"][()][one], trials["moves"][()][one].astype(bool)
                    self.assertEqual(theta[moves].min(), high[k])
                    self.assertEqual(theta[~moves].max(), low[k])
                    self.assertGreaterEqual(trials["q_star"][()][one][moves].min(), 1e-4)
            first = {k: file["trials/" + k][()].tolist() for k in ("shields", "q_star", "moves")}
        self.refuses(4, "scene.yaml", *COARSE, "-o", "t.h5", says=["t.h5: exists", "--force"])
        r = self.threshold("scene.yaml", "-n", "2", *COARSE, "-o", "t.h5", "-j", "1", "--force", "--quiet")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        with h5py.File(self.folder / "t.h5") as file:
            self.assertEqual(first, {k: file["trials/" + k][()].tolist() for k in first})

    def test_outside(self):
        for words, says in ((("--low", "0.001", "--high", "0.01"), "raise --high"),
                            (("--low", "0.9", "--high", "1.2"), "lower --low")):
            r = self.threshold("scene.yaml", "-n", "1", "--tolerance", "0.005", "--quiet", *words)
            self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
            self.assertIn(says, r.stderr)

    def test_stop(self):
        p = subprocess.Popen([PROGRAM, "threshold", "scene.yaml", "-s", "time.end=400 s", "-o", "t.h5", "--low", "0.5",
                              "--high", "0.6"], cwd=self.folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(0.5)
        p.send_signal(signal.SIGINT)
        _, err = p.communicate(timeout=60)
        self.assertEqual(p.returncode, 130, err)
        self.assertRegex(err, re.compile("stopped"))
        self.assertEqual([x.name for x in self.folder.iterdir()], ["scene.yaml"])

    def test_refused(self):
        self.refuses(2, says=["which scene"])
        self.refuses(4, "nowhere.yaml", says=["nowhere.yaml"])
        self.refuses(2, "scene.yaml", "-s", "fluid.shileds=1", says=["did you mean fluid.shields"])
        self.refuses(2, "scene.yaml", "-s", "fluid.model=none", says=["fluid.model: none", "balance"])
        self.refuses(2, "scene.yaml", "-s", "time.end=0.5", says=["time.end", "at least 1 s"])
        self.refuses(2, "scene.yaml", "--low", "0.3", "--high", "0.2", says=["low < high"])
        self.refuses(2, "scene.yaml", "--tolerance", "0", says=["--tolerance"])
        self.refuses(2, "scene.yaml", "--tolerance", "little", says=["--tolerance little"])
        self.refuses(2, "scene.yaml", "--criterion", "-1", says=["--criterion"])
        self.refuses(2, "scene.yaml", "--replicas", "0", says=["1 to 1000"])
        self.refuses(4, "scene.yaml", "-o", "nowhere/t.h5", says=["nowhere"])
        (self.folder / "two.yaml").write_text("particles: [{position: [0, 1 mm]}]\nfluid: {model: log}\n"
                                              "domain: {length: 1 cm, gravity: 9.81}\ntime: {end: 2 s}\n")
        self.refuses(2, "two.yaml", says=["--replicas", "grains"])


if __name__ == "__main__":
    unittest.main()
