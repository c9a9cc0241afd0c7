#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa verify: the quick cases hold, the file has what it must, the pictures can be drawn, slips are refused."""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-h5py python3-matplotlib)")
    sys.exit(77)

PROGRAM = os.environ["RYUSA"]
ROOT = Path(os.environ["SOURCE_DIR"])
CASES = ("slow-bounce", "fast-bounce", "phase-space", "cost", "steps", "three-spheres")
LAWS = ("cundall-tension", "cundall", "tanaka", "fujioka-1", "fujioka-2-printed", "fujioka-2", "energy")


class Verify(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.home = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.home.name)
        cls.all = cls.run_program("verify", "--quick", "-o", "all.h5")

    @classmethod
    def tearDownClass(cls):
        cls.home.cleanup()

    @classmethod
    def run_program(cls, *words):
        return subprocess.run([PROGRAM, *words], cwd=cls.folder, text=True, timeout=500, check=False, capture_output=True)

    def refuses(self, status, *words, says=()):
        r = self.run_program(*words)
        self.assertEqual((r.returncode, r.stdout), (status, ""), (words, r.stderr))
        for text in says:
            self.assertIn(text, r.stderr)

    def test_all_claims_hold(self):
        self.assertEqual((self.all.returncode, self.all.stderr), (0, ""), self.all.stdout)
        self.assertNotIn("FAILED", self.all.stdout)
        self.assertIn(" 0 failed", self.all.stdout.splitlines()[-1])
        for case in CASES:
            self.assertIn(f"\n{case}: ", "\n" + self.all.stdout)
        for line in self.all.stdout.splitlines()[:-1]:
            self.assertLessEqual(len(line), 100, line)

    def test_file(self):
        with h5py.File(self.folder / "all.h5") as file:
            self.assertEqual(file.attrs["program"], "ryusa verify")
            self.assertIn("version", file.attrs)
            verdicts = file["claims/verdict"].asstr()[()]
            self.assertEqual(set(verdicts), {"ok", "differs"})
            whys = file["claims/why"].asstr()[()]
            self.assertTrue(all(bool(why) == (verdict == "differs") for why, verdict in zip(whys, verdicts)))
            for law in LAWS:
                for case, names in {"slow-bounce": ("kept", "steps"), "fast-bounce": ("kept", "deepest"),
                                    "phase-space": ("d", "w", "bounce"), "steps": ("steps", "printed"),
                                    "three-spheres": ("d_prime_error", "T0_error")}.items():
                    for name in names:
                        self.assertGreater(len(file[f"{case}/{law}/{name}"]), 0)
            np.testing.assert_allclose(file["slow-bounce/energy/kept"], 0.49, rtol=1e-9)
            np.testing.assert_allclose(file["fast-bounce/fujioka-2/kept"], 0.49, rtol=1e-5)
            np.testing.assert_array_equal(file["steps/tanaka/steps"], [14, 23, 37])
            self.assertAlmostEqual(file["three-spheres/exact"].attrs["d_prime"], 0.271463, 6)
            self.assertEqual(file["three-spheres/dt"].attrs["unit"], "s")

    def test_pictures(self):
        r = subprocess.run([sys.executable, "-B", str(ROOT / "postprocess/verify.py"), "all.h5"], cwd=self.folder,
                           text=True, timeout=200, check=False, capture_output=True)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        for name in ("bounce", "phase", "tables", "spheres"):
            self.assertGreater((self.folder / f"all-{name}.png").stat().st_size, 10000)

    def test_same_numbers_on_any_threads(self):
        for threads in "12":
            r = self.run_program("verify", "slow-bounce", "steps", "-j", threads, "-o", f"j{threads}.h5")
            self.assertEqual((r.returncode, r.stderr), (0, ""))
        with h5py.File(self.folder / "j1.h5") as one, h5py.File(self.folder / "j2.h5") as two:
            self.assertNotIn("cost", one)
            np.testing.assert_array_equal(one["claims/value"], two["claims/value"])

    def test_existing_file(self):
        before = (self.folder / "all.h5").read_bytes()
        self.refuses(4, "verify", "steps", "-o", "all.h5", says=["all.h5: exists", "--force"])
        self.assertEqual((self.folder / "all.h5").read_bytes(), before)
        self.assertEqual(self.run_program("verify", "-q", "phase-space", "-o", "again.h5").stdout, "")
        self.assertEqual(self.run_program("verify", "phase-space", "-o", "again.h5", "--force").returncode, 0)

    def test_slips(self):
        self.refuses(2, "verify", "slow", says=["'slow'", *CASES])
        self.refuses(2, "verify", "-j", "0", says=["-j 0"])
        self.refuses(2, "verify", "-o", "", says=["-o"])
        self.refuses(2, "verify", "--fly", says=["--fly"])
        self.refuses(4, "verify", "steps", "-o", "nowhere/verify.h5", says=["nowhere/verify.h5"])
        self.refuses(4, "verify", "steps", "-o", ".", says=["folder"])
        self.assertEqual([p.name for p in self.folder.glob("*.part*")], [])


if __name__ == "__main__":
    unittest.main()
