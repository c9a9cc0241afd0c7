#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Explicit grains from tables: the same bits as from a list, what is wrong with a table, a scene that begins where
another one ended."""
import os
import re
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT, PROGRAM = Path(os.environ["SOURCE_DIR"]), os.environ["RYUSA"]
HEAD = "domain: {length: 10 mm, periodic: true}\ntime: {end: 2 ms}\noutput: {fields: [position, velocity, spin]}\n"
ROWS = np.random.default_rng(1).uniform(-1, 1, (40, 8))
ROWS[:, 0] = np.arange(40) % 8 * 1.2e-3 + 1e-4 * ROWS[:, 0]
ROWS[:, 1] = np.arange(40) // 8 * 1.2e-3 + 1e-4 * ROWS[:, 1]
ROWS[:, 4] *= 100.0
ROWS[:, 5] = 8e-4 + 1e-4 * ROWS[:, 5]
ROWS[:, 6] = 2650.0
ROWS[:, 7] = np.arange(40) % 8 == 0
NAMES = ["x", "z", "vx", "vz", "spin", "diameter", "density", "fixed"]
NEEDED = "the first line names the columns: x and z, and as wanted vx, vz, spin, diameter, density, fixed"
BAD = [  # table, what is said after "bad.csv"
    ("", ": no column x; " + NEEDED),
    ("# nothing\n", ": no column x; " + NEEDED),
    ("x,z\n", ": no rows"),
    ("x\n1\n", ":1: no column z; " + NEEDED),
    ("x,z,diametre\n", ":1: unknown column 'diametre'; did you mean diameter? " + NEEDED),
    ("x,z,x\n", ":1: two columns are named x"),
    ("x [mm,z\n1,2\n", ":1: 'x [mm' is no column; a unit stands in brackets, as in x [mm]"),
    ("x [kg],z\n1,2\n", ":1: x: the unit 'kg' does not fit"),
    ("x,z\n\n# comment\n1e-3\n", ":4: 1 columns, but the header has 2"),
    ("x,z\n1e-3,1e-3,1e-3\n", ":2: 3 columns, but the header has 2"),
    ("x,z\n1e-3,\n", ":2: z: nothing where a number belongs"),
    ("x,z\n1e-3,high\n", ":2: z: 'high' is not a number"),
    ("x,z\n1e-3,2 kg\n", ":2: z: the unit 'kg' does not fit"),
    ("x [mm],z\n1 mm,0\n", ":2: x: '1 mm' is not a plain number"),
    ("x,z,diameter\n1e-3,1e-3,-1\n", ":2: diameter: -1 is out of range; allowed is 1e-09 to 10000 m"),
    ("x,z,fixed\n1e-3,1e-3,2\n", ":2: fixed: 2 is not allowed; 0, 1, true or false is"),
    ("x,z\n1e-3,1e-3\n1.1e-3,1e-3\n", ":3: particles[1]: overlaps another grain, line 2 of bad.csv, by 0.0004 m"),
    ("x,z\n1e-3,\xff\n", ": not a text file (UTF-8)"),
    (",".join(["x"] * 65), ":1: 65 columns; at most 64 are allowed"),
]


class Particles(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def scene(self, particles, head=HEAD, name="scene.yaml"):
        (self.folder / name).write_text(f"{head}particles:\n{particles}")
        return name

    def table(self, name, columns=NAMES, rows=ROWS):
        keep = [NAMES.index(c) for c in columns]
        lines = [",".join(columns)] + [",".join(repr(v) for v in row) for row in rows[:, keep].tolist()]
        (self.folder / name).write_text("\n".join(lines) + "\n")

    def run_program(self, *words, status=0):
        r = subprocess.run([PROGRAM, *words], cwd=self.folder, text=True, timeout=120, stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE)
        self.assertEqual(r.returncode, status, (words, r.stderr))
        return r.stderr if status else r.stdout

    def hash_of(self, scene):
        out = self.run_program("run", scene, "-o", "o.h5", "--force")
        return re.search(r"^state hash (0x[0-9a-f]{16})$", out, re.M).group(1)

    def test_as_from_a_list(self):
        entries = "".join(f"- {{position: [{x!r}, {z!r}], velocity: [{vx!r}, {vz!r}], spin: {w!r}, diameter: {d!r}, "
                          f"density: {rho!r}, fixed: {'true' if fixed else 'false'}}}\n"
                          for x, z, vx, vz, w, d, rho, fixed in ROWS.tolist())
        wanted = self.hash_of(self.scene(entries))
        self.table("grains.csv")
        self.assertEqual(self.hash_of(self.scene("- {file: grains.csv}\n")), wanted)
        with h5py.File(self.folder / "o.h5") as file:
            found = file["parameters/particles"]
            self.assertEqual(list(found.attrs["columns"]), NAMES)
            self.assertTrue(np.array_equal(found[:], np.where(np.arange(8) == 0, ROWS[:, :1] % 0.01, ROWS)))

    def test_columns_in_any_order_units_and_what_all_have(self):
        table = "\n# a comment\n vz [cm/s], \"x [mm]\" ,z, fixed\r\n 10 , 1, 2 mm, true\r\n\r\n1e1,\"3\",2e-3,0"
        (self.folder / "grains.csv").write_text("\ufeff" + table)
        (self.folder / "sub").mkdir()
        (self.folder / "sub/more.csv").write_text("x,z\n5e-3,5e-3\n")
        self.scene("- {position: [9 mm, 9 mm]}\n- {file: grains.csv, density: 2 g/cm^3, velocity: [1, 2]}\n"
                   "- {file: sub/more.csv, diameter: 1 mm, fixed: true}\n")
        self.run_program("run", "scene.yaml", "-o", "o.h5")
        with h5py.File(self.folder / "o.h5") as file:
            found = file["parameters/particles"][:]
        wanted = [[9e-3, 9e-3, 0, 0, 0, 5e-4, 2650, 0], [1e-3, 2e-3, 1, 0.1, 0, 5e-4, 2000, 1],
                  [3e-3, 2e-3, 1, 0.1, 0, 5e-4, 2000, 0], [5e-3, 5e-3, 0, 0, 0, 1e-3, 2650, 1]]
        np.testing.assert_allclose(found, wanted, rtol=1e-15)

    def test_from_another_folder(self):
        self.table("grains.csv")
        self.scene("- file: grains.csv\n")
        out = subprocess.run([PROGRAM, "show", str(self.folder / "scene.yaml")], cwd="/", stdout=subprocess.PIPE, text=True)
        self.assertEqual(out.returncode, 0)
        self.scene(f"- file: {self.folder}/grains.csv\n")
        self.run_program("show", "scene.yaml")

    def test_bad_tables(self):
        self.scene("- {file: bad.csv}\n")
        for text, says in BAD:
            (self.folder / "bad.csv").write_bytes(text.encode("latin-1"))
            said = self.run_program("show", "scene.yaml", status=2)
            self.assertTrue(said.startswith(f"ryusa: bad.csv{says}"), (text, said))

    def test_bad_entries(self):
        for entry, says in (("file: ", "particles[0].file: nothing stands where the name of a table (CSV) belongs"),
                            ("file: [a, b]", "particles[0].file: a list stands where the name of a table (CSV) belongs"),
                            ("file: a.csv, position: [0, 1]", "particles[0]: has a file and a position; give only one")):
            said = self.run_program("show", self.scene(f"- {{{entry}}}\n"), status=2)
            self.assertTrue(said.startswith("ryusa: scene.yaml:5: " + says), said)
        (self.folder / "folder.csv").mkdir()
        for name, says in (("nowhere.csv", "can't be opened: No such file"), ("folder.csv", "a folder, not a table")):
            said = self.run_program("run", self.scene(f"- {{file: {name}}}\n"), "-o", "o.h5", status=4)
            self.assertTrue(said.startswith(f"ryusa: scene.yaml:5: particles: {name}: {says}"), said)
        self.assertFalse(list(self.folder.glob("o.h5*")))

    def test_resume_sees_another_table(self):
        self.table("grains.csv")
        self.scene("- {file: grains.csv}\n")
        self.run_program("run", "scene.yaml", "-o", "o.h5")
        self.run_program("run", "scene.yaml", "-o", "o.h5", "--resume", "-s", "time.end=3 ms")
        other = ROWS.copy()
        other[7, 4] += 1.0
        self.table("grains.csv", rows=other)
        said = self.run_program("run", "scene.yaml", "-o", "o.h5", "--resume", "-s", "time.end=4 ms", status=2)
        self.assertIn("particles[7].spin", said)

    def test_a_sweep_reads_it(self):
        self.table("grains.csv")
        self.scene("- {file: grains.csv}\n")
        (self.folder / "sweep.yaml").write_text("scene: scene.yaml\nvary:\n  contact.friction: [0, 0.3, 0.6]\n")
        self.run_program("sweep", "sweep.yaml", "-o", "s.h5")
        with h5py.File(self.folder / "s.h5") as file:
            self.assertEqual(len(set(file["cases/hash"][:])), 3)

    def test_begins_where_another_ended(self):
        """By the lines that docs/file-format.md tells."""
        self.table("grains.csv")
        self.scene("- {file: grains.csv}\n")
        self.run_program("run", "scene.yaml", "-o", "OUT.h5")
        page = (ROOT / "docs/file-format.md").read_text()
        code = textwrap.dedent(re.search(r"(?s)    import h5py, numpy\n.*?\n\n", page).group())
        subprocess.run([sys.executable, "-c", code], cwd=self.folder, check=True)
        self.run_program("run", self.scene("- {file: grains.csv}\n", name="next.yaml"), "-o", "next.h5")
        with h5py.File(self.folder / "OUT.h5") as one, h5py.File(self.folder / "next.h5") as two:
            for name in ("position", "velocity", "spin"):
                self.assertTrue(np.array_equal(one[f"particles/grains/{name}/value"][-1],
                                               two[f"particles/grains/{name}/value"][0]), name)

    def test_in_a_bed(self):
        """Where none but the scene itself knows of the other grain."""
        bed = "grains: {columns: 6, layers: 3}\nfluid: {model: none}\n"
        rough = "domain: {floor: rough, length: 1 cm, gravity: 9.81}\n\n"
        for head, place, says in ((bed, "[0.3 mm, 0.6 mm]", "a grain of the bed, at x = "),
                                  (rough, "[0.25 mm, 0.1 mm]", "a grain of the rough floor, at x = 0.00025 m, z = 0 m, by 0.0004 m"),
                                  (rough, "[9.99 mm, 0.3 mm]", "a grain of the rough floor, at x = 0.00975 m, z = 0 m")):
            scene = self.scene(f"- {{position: [5 mm, 9 mm]}}\n- {{position: {place}}}\n", head)
            for command in ("show", "run"):
                said = self.run_program(command, scene, status=2)
                self.assertTrue(said.startswith(f"ryusa: scene.yaml:5: particles[1]: overlaps {says}"), said)
        self.run_program("show", self.scene("- {position: [0.25 mm, 0.48 mm]}\n", rough))
        self.assertEqual([p.name for p in self.folder.iterdir()], ["scene.yaml"])

    def test_begins_where_a_bed_ended(self):
        """Grains of a bed lie in each other, a little."""
        bed = ("grains: {columns: 10, layers: 4}\ntime: {settle: 50 ms, end: 0.1 s}\nfluid: {shields: 0.6}\n"
               "output: {interval: 10 ms}\n")
        head = "domain: {length: 5 mm, periodic: true, gravity: 9.81}\ntime: {end: 10 ms}\n"
        (self.folder / "bed.yaml").write_text(bed)
        page = (ROOT / "docs/file-format.md").read_text()
        code = textwrap.dedent(re.search(r"(?s)    import h5py, numpy\n.*?\n\n", page).group())
        for law in ("energy", "cundall"):
            law = ["-s", f"contact.law={law}", "-s", "contact.alpha_m=80"]
            self.run_program("run", "bed.yaml", "-o", "OUT.h5", "--force", *law)
            subprocess.run([sys.executable, "-c", code], cwd=self.folder, check=True)
            x, z, *_, d, _, fixed = np.loadtxt(self.folder / "grains.csv", delimiter=",", skiprows=1).T
            dx = x[:, None] - x
            apart = np.hypot(dx - 5e-3 * np.round(dx / 5e-3), z[:, None] - z)
            deepest = np.max((0.5 * (d[:, None] + d) - apart)[~np.eye(len(x), dtype=bool) & (fixed == 0)])
            self.assertTrue(1e-5 < deepest / 5e-4 < 0.05, deepest)
            self.run_program("run", self.scene("- {file: grains.csv}\n", head, "next.yaml"), "-o", "next.h5", "--force", *law)
            with h5py.File(self.folder / "next.h5") as file:
                self.assertLess(file["particles/grains/velocity/value"][-1].max(), 1.0)


if __name__ == "__main__":
    unittest.main()
