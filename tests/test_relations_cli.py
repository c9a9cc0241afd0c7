#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa relations: the page, the export against the published numbers, its way back as a target, and
what is refused."""
import csv
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["RYUSA"]
CHECK = Path(os.environ["SOURCE_DIR"]) / "tests/data/bedload_relations.csv"


def rows_of(text):
    return list(csv.reader(line for line in text.splitlines() if not line.startswith("#")))


class Relations(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)

    def relations(self, *words):
        return subprocess.run([PROGRAM, "relations", *words], cwd=self.folder, text=True, timeout=60,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def refuses(self, status, *words, says=()):
        r = self.relations(*words)
        self.assertEqual((r.returncode, r.stdout), (status, ""), (words, r.stderr))
        for text in says:
            self.assertIn(text, r.stderr)

    def test_page(self):
        r = self.relations()
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        for text in ("wong-parker", "Ashida & Michiue 1972", "0.0495", "8 (θ - 0.047)^1.5", "brownlie"):
            self.assertIn(text, r.stdout)
        r = self.relations("-d", "0.5 mm", "wong-parker", "--theta", "0.2")
        self.assertIn("D* = 12.65", r.stdout)
        self.assertNotIn("nielsen", r.stdout)

    def test_export(self):
        published = rows_of(CHECK.read_text())
        thetas = published[0][1:]
        r = self.relations("--theta", ",".join(t.split("_")[-1] for t in thetas), "--csv", "-")
        self.assertEqual(r.returncode, 0, r.stderr)
        made = rows_of(r.stdout)
        column = {key: k for k, key in enumerate(made[0])}
        self.assertEqual(len(made[0]) - 1, len(published) - 1)
        for row in published[1:]:
            for k, value in enumerate(row[1:], 1):
                self.assertAlmostEqual(float(made[k][column[row[0]]]), float(value), delta=2e-5 * abs(float(value)))

    def test_export_is_a_target(self):
        r = self.relations("wilson", "--theta", "0.05:1:30:log", "--csv", "wilson.csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.refuses(4, "wilson", "--csv", "wilson.csv", says=["wilson.csv: exists", "--force"])
        r = self.relations("wilson.csv", "wilson", "--theta", "0.3,3", "--csv", "-")
        rows = rows_of(r.stdout)
        self.assertAlmostEqual(float(rows[1][1]) / float(rows[1][2]), 1.0, delta=0.01)
        self.assertEqual(rows[2][1], "")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["wilson.csv"])

    def test_refused(self):
        (self.folder / "bad.csv").write_text("theta,q_star\n0.1,0.2\n0.2,much\n")
        self.refuses(2, "bad.csv", says=["bad.csv:3: q_star: 'much'"])
        self.refuses(2, "wilsn", says=["wilsn", "did you mean wilson?"])
        for theta in ("0.1,x", "0", "", "0.1:0.05:3", "0.1:1", "0.1:1:2.5", "0.1:1:1", "0.1:1:5:cubic", "-1"):
            self.refuses(2, f"--theta={theta}", says=["--theta", "FROM:TO:STEPS"])
        self.refuses(2, "-d", "0.5 kg", says=["--diameter", "kg"])
        self.refuses(2, "--density", "900", says=["--density", "fluid"])
        self.refuses(2, "--viscosity", "0", says=["--viscosity", "above 0"])
        self.refuses(4, "--csv", "nowhere/out.csv", says=["nowhere/out.csv"])


if __name__ == "__main__":
    unittest.main()
