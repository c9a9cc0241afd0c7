#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa tune: quick tunings and what it leaves, the same bits on any number of threads, stop and resume,
targets, and what is refused."""
import os
import signal
import subprocess
import sys
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

PROGRAM, SOURCE = os.environ["RYUSA"], Path(os.environ["SOURCE_DIR"])
SCENE = """\
title: a small bed
time: {step: 20 us, end: 2 s, settle: 0.1 s}
grains: {columns: 4, layers: 4, packing: square, seed: 3}
fluid: {model: balance, shields: 0.5}
"""


class Tune(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        self.write(SCENE)

    def write(self, text, name="bed.yaml"):
        (self.folder / name).write_text(text)

    def run_program(self, *words):
        return subprocess.run([PROGRAM, "tune", *words], cwd=self.folder, text=True, timeout=200,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def tune(self, *words, status=0):
        r = self.run_program("bed.yaml", "--quick", *words)
        self.assertEqual(r.returncode, status, r.stdout + r.stderr)
        return r

    def refuses(self, status, *words, says=()):
        r = self.run_program(*words)
        self.assertEqual((r.returncode, r.stdout), (status, ""), (words, r.stderr))
        for text in says:
            self.assertIn(text, r.stderr)

    def numbers(self, name):
        found = {}
        with h5py.File(self.folder / name) as file:
            file.visititems(lambda path, item: found.update({path: item[()]}) if isinstance(item, h5py.Dataset) else None)
        return found

    def same(self, first, second):
        a, b = self.numbers(first), self.numbers(second)
        self.assertEqual(set(a), set(b))
        for path in a:
            self.assertEqual(a[path].tobytes(), b[path].tobytes(), path)

    def test_files_and_report(self):
        r = self.tune("-j1")
        for text in ("wong-parker", "tau_b/((rho_s - rho_f) g d)", "alpha_m", "Harada's criterion", "Ours", "95 %",
                     "15.8", "divides k by beta^2", "within 25 %", "bed-tuned.h5", "bed-tuned.yaml"):
            self.assertIn(text, r.stdout)
        self.assertLessEqual(max(len(line) for line in r.stdout.splitlines()), 100)
        self.assertFalse((self.folder / "bed-tuned.h5.pieces").exists())
        with h5py.File(self.folder / "bed-tuned.h5") as file:
            constants = {key: float(file.attrs[key]) for key in ("alpha_m", "alpha_cn", "beta")}
            self.assertEqual(file["settling/alpha_m/value"][()].tolist(), [10, 20, 80, 320])
            curve = file["settling/alpha_m/curve/01-seed-1"][()]
            self.assertGreater(len(curve), 100)
            self.assertLess(abs(curve[-1] - curve[-10]), 0.01)
            self.assertGreater(curve[0], curve[-1])
            self.assertEqual(len(file["flux/best/q_star"]), len(file["flux/theta"]))
            low, high = (file["misfit"].attrs[k] for k in ("low", "high"))
            self.assertLessEqual(low, high)
        shown = subprocess.run([PROGRAM, "show", "bed-tuned.yaml"], cwd=self.folder, text=True, stdout=subprocess.PIPE)
        self.assertEqual(shown.returncode, 0)
        for key, value in constants.items():
            self.assertRegex(shown.stdout, rf"(?m)^\s+{key}\s+{value:.6g}\s")
        self.tune("-j3", "-o", "three.h5", "--quiet")
        self.same("bed-tuned.h5", "three.h5")
        r = self.tune(status=4)
        self.assertIn("--force", r.stderr)
        drawn = subprocess.run([sys.executable, "-B", SOURCE / "postprocess/tune.py", "bed-tuned.h5"], cwd=self.folder,
                               text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if "No module named 'matplotlib'" not in drawn.stdout:
            self.assertEqual((drawn.returncode, len(list(self.folder.glob("*.png")))), (0, 4), drawn.stdout)

    def test_stop_and_resume(self):
        self.tune("-o", "whole.h5", "--quiet")
        for killer, status in ((signal.SIGINT, 130), (signal.SIGKILL, -9)):
            job = subprocess.Popen([PROGRAM, "tune", "bed.yaml", "--quick", "-j1", "-o", "part.h5"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            pieces = self.folder / "part.h5.pieces"
            begun = time.monotonic()
            while time.monotonic() < begun + 20 and job.poll() is None and \
                    not (pieces.exists() and pieces.read_text().count("\n") > 4):
                time.sleep(0.005)
            job.send_signal(killer)
            self.assertEqual(job.wait(timeout=30), status)
            self.assertTrue(pieces.exists())
            self.assertIn("--resume", self.tune("-o", "part.h5", status=4).stderr)
            pieces.write_text(pieces.read_text() + "flux cut sho")
            changed = self.tune("-o", "part.h5", "--resume", "-s", "contact.friction=0.4", status=2)
            self.assertIn("has changed", changed.stderr)
            self.tune("-o", "part.h5", "--resume", "--quiet")
            self.same("whole.h5", "part.h5")
            self.assertIn("finished already", self.tune("-o", "part.h5", "--resume").stdout)
            self.tune("-o", "part.h5", "--resume", "-s", "contact.friction=0.4", status=4)
            (self.folder / "part.h5").unlink()
            (self.folder / "part.yaml").unlink()

    def test_pieces_of_one_that_just_ends(self):
        """Its last piece comes between the start of another and its lock; what a power cut leaves is on the disk."""
        strace = ["strace", "-f", "-o", "calls", "-e", "trace=flock,fdatasync", "-e", "inject=flock:delay_enter=1000000:when=1"]
        try:
            subprocess.run([*strace, "true"], cwd=self.folder, check=True, stderr=subprocess.DEVNULL)
        except (OSError, subprocess.CalledProcessError):
            self.skipTest("no strace that may trace; Debian: apt install strace")
        pieces, calls = self.folder / "part.h5.pieces", self.folder / "calls"

        def wait_for(condition):
            deadline = time.monotonic() + 30
            while not condition() and time.monotonic() < deadline:
                time.sleep(0.005)

        def tune(*before):
            return subprocess.Popen([*before, PROGRAM, "tune", "bed.yaml", "--quick", "-j1", "-o", "part.h5", "--resume"],
                                    cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        first = tune()
        wait_for(lambda: pieces.exists() and pieces.read_text().count("\n") > 2)
        first.kill()
        first.wait()
        kept = pieces.read_text()
        kept = kept[:kept.rindex("\n") + 1] + "the last piece|0|1 0x1p+0|\n"
        second = tune(*strace)
        wait_for(lambda: calls.exists() and "flock" in calls.read_text())  # it sleeps before its lock
        pieces.write_text(kept)
        wait_for(lambda: pieces.read_text().count("\n") > kept.count("\n") + 2)
        second.send_signal(signal.SIGTERM)
        children = Path(f"/proc/{second.pid}/task/{second.pid}/children").read_text().split()
        for pid in children:
            os.kill(int(pid), signal.SIGINT)
        second.wait(timeout=30)
        now = pieces.read_text()
        self.assertTrue(now.startswith(kept))
        self.assertEqual(calls.read_text().count("fdatasync("), now.count("\n") - kept.count("\n"))

    def test_joint(self):
        r = self.tune("--vary", "contact.friction=0.2:0.8", "--vary", "contact.alpha_m=20:30", "--budget", "12")
        for text in ("Joint fit of 2 constants: 9 candidates", "contact.friction", "95 %", "the data constrain",
                     "left-out candidates", "bed-tuned.yaml"):
            self.assertIn(text, r.stdout)
        self.assertLessEqual(max(len(line) for line in r.stdout.splitlines()), 100)
        with h5py.File(self.folder / "bed-tuned.h5") as file:
            self.assertEqual(file.attrs["varied"], "contact.friction,contact.alpha_m")
            best = float(file["joint/contact.friction"].attrs["best"])
            self.assertTrue(0.2 <= best <= 0.8)
            values = file["joint/contact.friction/candidates"][()]
            self.assertTrue(len(values) == 12 and (values >= 0.2).all() and (values <= 0.8).all())
            self.assertLess(file["joint/contact.friction/profile"][()].min(), 0.2)
            vectors = np.array([file[f"joint/direction-{d}/vector"][()] for d in range(2)])
            np.testing.assert_allclose(vectors @ vectors.T, np.eye(2), atol=1e-12)
        shown = subprocess.run([PROGRAM, "show", "bed-tuned.yaml"], cwd=self.folder, text=True, stdout=subprocess.PIPE)
        self.assertRegex(shown.stdout, rf"(?m)^\s+friction\s+{best:.6g}\s")
        drawn = subprocess.run([sys.executable, "-B", SOURCE / "postprocess/tune.py", "bed-tuned.h5"], cwd=self.folder,
                               text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if "No module named 'matplotlib'" not in drawn.stdout:
            self.assertEqual((drawn.returncode, len(list(self.folder.glob("*-joint-*.png")))), (0, 2), drawn.stdout)

    def test_joint_resume(self):
        words = ("--vary", "contact.friction=0.2:0.8", "-o", "part.h5")
        job = subprocess.Popen([PROGRAM, "tune", "bed.yaml", "--quick", "-j1", *words], cwd=self.folder,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        pieces = self.folder / "part.h5.pieces"
        begun = time.monotonic()
        while time.monotonic() < begun + 20 and job.poll() is None and \
                not (pieces.exists() and pieces.read_text().count("\n") > 6):
            time.sleep(0.005)
        job.kill()
        job.wait()
        kept = pieces.read_text()
        changed = self.tune("--vary", "contact.friction=0.2:0.9", "-o", "part.h5", "--resume", status=2)
        self.assertIn("--vary", changed.stderr)
        self.assertTrue(pieces.read_text().startswith(kept[:kept.rindex("\n")]))
        self.tune(*words, "--resume", "--quiet")
        self.tune(*words[:2], "-o", "whole.h5", "--quiet", "-j3")
        self.same("whole.h5", "part.h5")

    def test_joint_finds_its_own_truth(self):
        """The target is the model itself with friction 0.2: friction is found; of springs of 20 to 30 steps, which the flux
        feels by 1 or 2 % (20 and 60: 4 +- 2 %), less than a tenth as much is known. (How often an interval holds the truth:
        test_response.)"""
        self.write("title: truth\ntime: {step: 20 us, end: 2.4 s, settle: 0.1 s}\n"
                   "grains: {columns: 24, layers: 4, packing: random, seed: 3}\n"
                   "contact: {restitution: 0.5}\nfluid: {model: balance}\n", "own.yaml")
        rows = ["theta,q_star,error"]
        for theta in (0.25, 0.35, 0.5):
            q = []
            for seed in range(11, 15):
                r = subprocess.run([PROGRAM, "run", "own.yaml", "-o", "t.h5", "--force", "--quiet", "-j1",
                                    "-s", "contact.friction=0.2", "-s", f"grains.seed={seed}", "-s", f"fluid.shields={theta}",
                                    "-s", "time.end=2.5", "-s", "output.fields=[flux]"], cwd=self.folder)
                self.assertEqual(r.returncode, 0)
                with h5py.File(self.folder / "t.h5") as file:
                    q.append(float(file["observables/flux"].attrs["q_star_mean"]))
            rows.append(f"{theta},{np.mean(q):.6g},{np.std(q, ddof=1) / len(q) ** 0.5:.4g}")
        self.write("\n".join(rows) + "\n", "own.csv")
        r = self.run_program("own.yaml", "--target", "own.csv", "--vary", "contact.friction=0.04:0.9",
                             "--vary", "contact.alpha_m=20:30", "--budget", "12", "-o", "found.h5")
        self.assertEqual(r.returncode, 0, r.stderr)
        with h5py.File(self.folder / "found.h5") as file:
            friction, information = file["joint/contact.friction"].attrs, file["joint/information"][()]
            self.assertLess(abs(np.log(friction["best"] / 0.2)), np.log(2.0), r.stdout)
            self.assertLess(np.log(friction["high"] / friction["low"]), np.log(0.9 / 0.04) / 2, r.stdout)
            self.assertLess(information[1], 0.1 * information[0], r.stdout)
            self.assertLess(abs(file["joint/direction-1/vector"][0]), 0.5, r.stdout)

    def test_resume_replaces_no_scene(self):
        self.write("title: mine\n", "found.yaml")
        self.refuses(4, "bed.yaml", "--quick", "--resume", "-o", "found.h5", says=["found.yaml", "exists"])
        self.assertEqual((self.folder / "found.yaml").read_text(), "title: mine\n")

    def test_joint_refused(self):
        for words, says in ((("--vary", "contact.fricton=0.2:0.8"), "did you mean contact.friction"),
                            (("--vary", "friction=0.2:0.8"), "contact.friction"),
                            (("--vary", "contact.friction"), "KEY=LOW:HIGH"),
                            (("--vary", "contact.friction=0.5"), "two bounds"),
                            (("--vary", "contact.friction=0.8:0.2"), "LOW < HIGH"),
                            (("--vary", "contact.friction=0:0.2"), "LOW above 0"),
                            (("--vary", "contact.friction=much:0.2"), "much"),
                            (("--vary", "contact.friction=0.1:50"), "10"),
                            (("--vary", "contact.law=1:2"), "is not fitted"),
                            (("--vary", "fluid.shields=0.1:2"), "is not fitted"),
                            (("--vary", "time.end=1:2"), "is not fitted"),
                            (("--vary", "contact.beta=1:2", "--vary", "contact.beta=1:2"), "twice"),
                            (("--joint", "--budget", "10"), "at least 27"),
                            (("--budget", "40"), "--joint")):
            self.refuses(2, "bed.yaml", *words, says=[says])
        self.refuses(3, "bed.yaml", "--quick", "--quiet", "--vary", "contact.beta=100:900", says=["narrow --vary"])

    def test_own_target_and_refused_candidates(self):
        self.write("theta,q_star,error\n0.5,0.9,0.1\n1,3,0.3\n", "mine.csv")
        r = self.tune("--target", "mine.csv", "-s", "contact.law=cundall", "-s", "contact.alpha_cn=0.1")
        self.assertIn("mine.csv: 2 points", r.stdout)
        self.assertIn("not run", r.stdout)
        self.assertEqual(self.numbers("bed-tuned.h5")["settling/alpha_m/status"].tolist()[0], 2)
        self.write("theta,q_star\n0.5,1e6\n1,1e7\n", "far.csv")
        self.assertIn("OUT OF REACH", self.tune("--target", "far.csv", "-o", "far.h5").stdout)

    def test_bad_input(self):
        self.refuses(2, says=["which scene file"])
        self.refuses(2, "bed.yaml", "--target", "wong-praker", says=["did you mean wong-parker", "ashida-michiue"])
        self.write("theta,q_star\n0.1,0.2\n0.3,much\n", "text.csv")
        self.refuses(2, "bed.yaml", "--target", "text.csv", says=["text.csv:3"])
        self.write("theta,q_star\n0.1,0\n0.3,0\n", "still.csv")
        self.refuses(2, "bed.yaml", "--target", "still.csv", says=["no flux above 0"])
        self.refuses(2, "bed.yaml", "--resume", "--force", says=["go on, or begin anew"])
        self.refuses(2, "bed.yaml", "-s", "contact.stiffness=100", says=["contact.stiffness"])
        self.refuses(2, "bed.yaml", "-s", "fluid.model=none", says=["fluid.model"])
        self.refuses(2, "bed.yaml", "-s", "time.end=0.2", says=["time.end"])
        self.refuses(2, "bed.yaml", "-o", "bed.h5", says=["would replace the scene"])
        self.write("particles:\n  - {position: [0, 1 mm]}\n", "few.yaml")
        self.refuses(2, "few.yaml", says=["no bed"])
        self.refuses(4, "none.yaml", says=["none.yaml"])
        self.refuses(4, "bed.yaml", "-o", "nowhere/out.h5", says=["nowhere"])
        self.assertEqual(sorted(p.name for p in self.folder.glob("*.pieces")), [])


if __name__ == "__main__":
    unittest.main()
