#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa bench: files, classes and curves of quick runs; refusals. No timing decides anything.
ctest: slow"""
import os
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
from pathlib import Path

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

PROGRAM = os.environ["RYUSA"]
SOURCE = Path(os.environ.get("SOURCE_DIR", Path(__file__).resolve().parent.parent))
sys.path.append(str(SOURCE / "postprocess"))
LAWS = re.findall(r'\(RY_LAW_\w+, "([\w-]+)"\)', (SOURCE / "include/ryusa/config.h").read_text())


class Bench(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)

    def run_program(self, *words):
        return subprocess.run([PROGRAM, "bench", *words], cwd=self.folder, text=True, timeout=200,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def succeeds(self, *words):
        r = self.run_program(*words)
        self.assertEqual(r.returncode, 0, r.stderr)
        return r

    def refuses(self, status, *words, says=""):
        r = self.run_program(*words)
        self.assertEqual((r.returncode, r.stdout), (status, ""), (words, r.stderr))
        self.assertIn(says, r.stderr)

    def draws(self, name):
        r = subprocess.run([sys.executable, "-B", SOURCE / "postprocess/bench.py", name], text=True,
                           cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertGreater((self.folder / name).with_suffix(".png").stat().st_size, 10000)

    def test_bad_input(self):
        self.refuses(2, says="which bench")
        self.refuses(2, "beauty", says="accuracy, stability, speed")
        self.refuses(2, "stability", "speed", says="one bench")
        self.refuses(2, "speed", "-l", "tanaka", says="cundall and energy")
        self.refuses(2, "stability", "--law", "newton", says="cundall-tension")
        self.refuses(2, "stability", "-j", "0", says="-j 0")
        self.refuses(2, "stability", "-o", "", says="name")
        self.refuses(4, "stability", "-o", "nowhere/x.h5", says="nowhere")
        (self.folder / "there.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
        self.refuses(4, "speed", "-o", "there.h5", says="--force")
        self.assertEqual((self.folder / "there.h5").stat().st_size, 8)
        (self.folder / "there.h5").write_text("mine")
        self.refuses(4, "speed", "-o", "there.h5", "--force", says="not a result file")
        self.assertEqual((self.folder / "there.h5").read_text(), "mine")
        self.assertEqual([p.name for p in self.folder.iterdir()], ["there.h5"])

    def test_peers_are_drawn(self):
        """Tables as tests/peers/peers.py and jobs.py write them; the programs themselves are run by `make bench` only."""
        rows = [f"{scene},{n},{program},{cores},{rate},{rate},3,100,1e-9,0.0025,100"
                for scene in ("settled", "sheared") for n in (50, 1000) for cores in (1, 2)
                for program, rate in (("ryusa", 4e7), ("LAMMPS", 1e7))]
        head = "scene,grains,program,cores,best,median,rounds,steps,kinetic_energy,height,contacts"
        (self.folder / "p.csv").write_text("\n".join(["# a machine", head, *rows, ""]))
        self.draws("p.csv")
        head = "job,program,cores,parts,wall,cpu,loop,flow,repeats,result"
        rows = [f'flux,{program},{cores},20,{wall},{wall},nan,3,3,"q* 1, 2"' for cores in (1, 2)
                for program, wall in (("ryusa energy", 1.0), ("LAMMPS", 10.0))]
        (self.folder / "j.csv").write_text("\n".join(["# a machine", head, *rows, ""]))
        self.draws("j.csv")
        (self.folder / "other.csv").write_text("# x\na,b\n1,2\n")
        r = subprocess.run([sys.executable, "-B", SOURCE / "postprocess/bench.py", "other.csv"], text=True,
                           cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual((r.returncode, "not a table" in r.stderr), (4, True), r.stderr)
        for name in ("nowhere.h5", "other.csv/x.h5", "other.csv"):
            r = subprocess.run([sys.executable, "-B", SOURCE / "postprocess/bench.py", name], text=True,
                               cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual((r.returncode, r.stderr.count("\n")), (4, 1), r.stderr)

    def test_stability(self):
        r = self.succeeds("stability", "--quick", "-o", "s.h5")
        self.assertIn("sizes", r.stdout)
        with h5py.File(self.folder / "s.h5") as f:
            words = [w.decode() if isinstance(w, bytes) else w for w in f["class/word"][:]]
            for name in ("alpha_cn", "beta", "impact", "sizes"):
                n = len(f[name]["x"]) * len(f[name]["y"])
                for law in LAWS:
                    g = f[name][law]
                    classes = g["class"][:].astype(int)
                    self.assertEqual(len(classes), n)
                    self.assertTrue(((classes >= 0) & (classes < len(words))).all())
                    refused = classes == words.index("refused")
                    self.assertTrue(np.isnan(g["integration"][:][refused]).all())
                    self.assertTrue(np.isfinite(g["integration"][:][~refused]).all())
                    self.assertTrue(all(len(m) > 20 for m in g["message"][:][refused]))
            # The default law gains nowhere.
            for name in ("alpha_cn", "beta", "impact", "sizes"):
                got = {words[int(c)] for c in f[name]["energy"]["class"][:]}
                self.assertFalse(got & {"gains", "explodes"}, (name, got))
            # A row of equal grains on fixed ones comes to rest.
            self.assertEqual(words[int(f["sizes/energy/class"][0])], "quiet")
        self.draws("s.h5")

    def test_stability_does_not_depend_on_threads(self):
        for j in ("1", "2"):
            self.succeeds("stability", "--quick", "--quiet", "--law", "energy", "-j", j, "-o", f"{j}.h5")
        with h5py.File(self.folder / "1.h5") as a, h5py.File(self.folder / "2.h5") as b:
            for name in ("alpha_cn", "beta", "impact", "sizes"):
                for what in ("class", "kinetic", "integration", "rise"):
                    np.testing.assert_array_equal(a[name]["energy"][what][:], b[name]["energy"][what][:])

    def test_accuracy(self):
        r = self.succeeds("accuracy", "--quick", "-o", "a.h5")
        self.assertIn("at equal error cundall", r.stdout)
        with h5py.File(self.folder / "a.h5") as f:
            for name in ("binary", "sliding", "sticking", "three-spheres", "settling", "flux"):
                for law in LAWS:
                    g = f[name][law]
                    dt, steps, error = g["dt"][:], g["steps"][:], g["error"][:]
                    self.assertTrue((np.diff(dt) < 0).all() and (np.diff(steps) > 0).all(), (name, law))
                    self.assertTrue((np.isfinite(error) & (error >= 0)).all(), (name, law))
                    self.assertTrue((g["seconds"][:] > 0).all())
                    if not len(dt):
                        self.assertGreater(len(g.attrs["refused"]), 20, (name, law))
            # What the laws of the authors are made for.
            self.assertLess(f["binary/energy/error"][:].max(), 1e-12)
            self.assertLess(f["binary/fujioka-2/error"][:].max(), 1e-12)
            three = f["three-spheres/energy/error"][:]
            self.assertTrue((np.diff(three) < 0).all() and three[-1] < 1.6e-4, three)
        self.draws("a.h5")

    def test_laws_of_equal_steps_stand_beside_each_other(self):
        """Those that bench.py has no style for too."""
        import bench
        laws = [*LAWS, "newcomer"]
        with h5py.File("made-up", "w", driver="core", backing_store=False) as file:
            group = file.create_group("flux")
            group.attrs["error"] = "relative error"
            for law in laws:
                one = group.create_group(law)
                one["steps"], one["seconds"], one["error"], one["error_bar"] = [5000.0], [0.05], [0.2], [0.1]
            with unittest.mock.patch.object(bench, "save", lambda figure, path: figure):
                figure = bench.accuracy(file, None)
        figure.canvas.draw()
        at = [line.get_transform().transform(line.get_xydata())[0, 0] for line in figure.axes[0].get_lines()
              if line.get_label() in laws]
        self.assertEqual(len(at), len(laws))
        self.assertEqual([text.get_text() for text in figure.legends[0].get_texts()][-1], "newcomer")
        self.assertGreater(np.diff(np.sort(at)).min(), 3.0)
        bench.plt.close(figure)

    def test_speed(self):
        r = self.succeeds("speed", "--quick", "-o", "v.h5")
        self.assertIn("grain-st./s", r.stdout)
        with h5py.File(self.folder / "v.h5") as f:
            self.assertTrue((f["runs/rate"][:] >= f["runs/median"][:]).all())
            self.assertTrue((f["runs/median"][:] > 0).all())
            reached, contacts = f["runs/reached"][:], f["runs/contacts"][:]
            self.assertTrue(((reached > 0) & (reached < 1)).all(), reached)
            self.assertTrue(((contacts > 0.5) & (contacts < 3)).all(), contacts)
            self.assertTrue((f["runs/arithmetic"][:] > 0).all() and (f["runs/moving"][:] > 0).all())
            stages = f["stages/settled/cundall/1000/1"].attrs
            self.assertEqual(set(stages) & {"contact", "gather", "column"}, {"contact", "gather"})
            self.assertIn("processor", f["machine"].attrs)
        lines = (self.folder / "v.csv").read_text().splitlines()
        self.assertTrue(lines[0].startswith("# ryusa "))
        self.assertEqual(len(lines), 2 + 16)
        self.draws("v.h5")


if __name__ == "__main__":
    unittest.main(verbosity=2)
