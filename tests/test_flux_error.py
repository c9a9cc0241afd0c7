#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""stop.flux_error: a run ends as soon as q* is known that well and not before stop.after, at the same step
also when it was interrupted; the mean that it ends with is that of a longer run within the errors."""
import math
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

try:
    import h5py
except ImportError as missing:
    print(f"skipped: {missing}; Debian: apt install python3-h5py")
    raise SystemExit(77)

PROGRAM = os.environ["RYUSA"]
SCENE = """\
time: {step: 20 us, end: 8 s, settle: 0.1 s}
grains: {columns: 8, layers: 6, seed: 2}
fluid: {shields: 0.4}
output: {interval: 10 ms, fields: [flux]}
"""
STOP = ("-s", "stop.flux_error=0.1", "-s", "stop.after=1 s")


class FluxError(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "bed.yaml").write_text(SCENE)

    def run_program(self, *words):
        r = subprocess.run([PROGRAM, "run", "bed.yaml", "-j1", *words], cwd=self.folder, text=True, timeout=100,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(r.returncode, 0, r.stderr)
        return r.stdout

    def flux(self, name):
        with h5py.File(self.folder / name) as file:
            flux = file["observables/flux"].attrs
            return (float(flux["q_star_mean"]), float(flux["q_star_standard_error"]),
                    float(file["observables/q_star/time"][-1]))

    def test_ends_when_known(self):
        self.run_program("-o", "long.h5")
        self.run_program("-o", "short.h5", *STOP)
        mean, error, end = self.flux("short.h5")
        all_mean, all_error, all_end = self.flux("long.h5")
        self.assertAlmostEqual(all_end, 8.0)
        self.assertTrue(1.0 <= end < 8.0, end)
        self.assertLess(error, 0.1 * mean)
        self.assertLess(all_error, 0.1 * all_mean)  # it stays known
        self.run_program("-o", "soon.h5", "-s", "stop.flux_error=0.5", "-s", "stop.after=0.2 s")
        with h5py.File(self.folder / "soon.h5") as file:
            flux, times = file["observables/flux"].attrs, file["observables/q_star/time"][:2]
            effective = flux["samples"] * (times[1] - times[0]) / (2.0 * flux["autocorrelation_time"])
        self.assertGreaterEqual(effective, 20.0)  # of fewer the error itself is not known
        self.assertLess(abs(mean - all_mean), 4.0 * math.hypot(error, all_error))
        self.run_program("-o", "later.h5", *STOP[:2], "-s", "stop.after=4 s")
        self.assertGreaterEqual(self.flux("later.h5")[2], 4.0)

    def test_ends_at_the_same_step_after_a_stop(self):
        whole = self.run_program("-o", "whole.h5", *STOP)
        job = subprocess.Popen([PROGRAM, "run", "bed.yaml", "-j1", "-o", "part.h5", "--quiet", *STOP], cwd=self.folder)
        time.sleep(0.25)
        job.send_signal(signal.SIGINT)
        self.assertIn(job.wait(timeout=60), (0, 130))
        part = self.run_program("-o", "part.h5", "--resume", *STOP)
        self.assertEqual(self.flux("whole.h5"), self.flux("part.h5"))
        hash_of = [next((line for line in text.splitlines() if "hash" in line or "0x" in line), "").split()[-1:] for text in
                   (whole, part)]
        self.assertEqual(*hash_of)
        self.assertTrue(hash_of[0])

    def test_ended_but_not_renamed(self):
        """Killed between the last flush and the rename; and a later time.end for a run that has ended by itself."""
        settings = ("-s", "stop.flux_error=0.5", "-s", "stop.after=0.3", "-o", "a.h5")
        self.run_program(*settings)
        found = self.flux("a.h5")
        self.assertLess(found[2], 8.0)
        (self.folder / "a.h5").rename(self.folder / "a.h5.part")
        self.run_program(*settings, "--resume")
        self.assertEqual(self.flux("a.h5"), found)
        self.run_program(*settings, "--resume", "-s", "time.end=9")
        self.assertEqual(self.flux("a.h5"), found)


if __name__ == "__main__":
    unittest.main()
