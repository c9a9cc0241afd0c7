#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Outputs that are symbolic links: what a link leads to is written, the link stays."""
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = os.environ["RYUSA"]
SCENE = """\
time: {step: 20 us, end: 20 ms, settle: 2 ms}
grains: {columns: 6, layers: 3, packing: square, seed: 3}
fluid: {shields: 0.5}
output: {interval: 2 ms}
"""


class Links(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "scene.yaml").write_text(SCENE)
        (self.folder / "sweep.yaml").write_text("scene: scene.yaml\nvary: {fluid.shields: [0.3, 0.5]}\n")
        (self.folder / "disk").mkdir()
        self.link("link.h5", "second.h5")
        self.link("second.h5", "disk/far.h5")

    def link(self, name, to):
        (self.folder / name).symlink_to(to)

    def start(self, *words):
        return subprocess.Popen([PROGRAM, *words], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE)

    def run_program(self, *words, status=0):
        p = self.start(*words)
        out, err = p.communicate(timeout=120)
        self.assertEqual(p.returncode, status, (words, out, err))
        return out + err

    def hash_of(self, *words):
        return re.search(r"^state hash (\S+)$", self.run_program("run", "scene.yaml", *words), re.M).group(1)

    def files(self, where="."):
        return sorted(p.name for p in (self.folder / where).iterdir() if not p.is_symlink() and p.is_file())

    def both_are_links(self):
        self.assertEqual([os.readlink(self.folder / name) for name in ("link.h5", "second.h5")],
                         ["second.h5", "disk/far.h5"])
        self.assertEqual(self.files(), ["scene.yaml", "sweep.yaml"])

    def test_run(self):
        first = self.hash_of("-o", "link.h5")
        self.both_are_links()
        self.assertEqual(self.files("disk"), ["far.h5", "far.xdmf"])
        self.assertIn("exists", self.run_program("run", "scene.yaml", "-o", "link.h5", status=4))
        self.assertEqual(self.hash_of("-o", "link.h5", "--force"), first)
        more = ("-s", "time.end=30 ms")
        self.assertEqual(self.hash_of("-o", "link.h5", "--resume", *more), self.hash_of("-o", "disk/plain.h5", *more))
        self.both_are_links()
        self.assertIn("simulated      0.03 s", self.run_program("info", "link.h5"))

    def test_stopped_run(self):
        """By either name it is one output: one lock, one run to go on with."""
        job = self.start("run", "scene.yaml", "-o", "link.h5", "-s", "time.end=400 s")
        while not (self.folder / "disk/far.h5.part").exists():
            self.assertIsNone(job.poll())
            time.sleep(0.01)
        time.sleep(0.5)
        for name in ("link.h5", "disk/far.h5"):
            self.assertIn("in use", self.run_program("run", "scene.yaml", "-o", name, "--force", status=4))
        self.assertIn("`info disk/far.h5.part'", self.run_program("info", "link.h5", status=4))
        job.send_signal(signal.SIGINT)
        _, err = job.communicate(timeout=30)
        self.assertEqual(job.returncode, 130, err)
        self.assertEqual(self.files("disk"), ["far.h5.part"])
        end = f"time.end={float(re.search(r't = (.*) s, saved', err).group(1)) + 0.01:.5f} s"
        self.assertEqual(self.hash_of("-o", "link.h5", "--resume", "-s", end), self.hash_of("-o", "disk/p.h5", "-s", end))
        self.both_are_links()

    def test_sweep(self):
        self.run_program("sweep", "sweep.yaml", "-o", "link.h5", "--quiet")
        self.both_are_links()
        self.assertEqual(self.files("disk"), ["far.h5"])
        self.assertIn("case-0002.h5", self.files("disk/far.d"))
        for words in (["--resume"], ["--force"], ["--merge"]):
            self.run_program("sweep", "sweep.yaml", "-o", "link.h5", "--quiet", *words)
        self.both_are_links()
        self.assertIn("cases", self.run_program("info", "link.h5"))

    def test_tune(self):
        """Its list of pieces, too, and a tuned scene that is a link."""
        bed = ("tune", "scene.yaml", "--quick", "--quiet", "-s", "time.end=0.5 s", "-s", "grains.layers=2", "-o", "link.h5")
        self.link("disk/far.yaml", "tuned.yaml")
        job = self.start(*bed)
        while not (self.folder / "disk/far.h5.pieces").exists():
            self.assertIsNone(job.poll())
            time.sleep(0.01)
        job.send_signal(signal.SIGINT)
        job.communicate(timeout=30)
        self.both_are_links()
        self.run_program(*bed, "--resume")
        self.both_are_links()
        self.assertEqual(self.files("disk"), ["far.h5", "tuned.yaml"])

    def test_verify(self):
        self.run_program("verify", "fast-bounce", "--quick", "--quiet", "-o", "link.h5")
        self.both_are_links()
        self.assertEqual(self.files("disk"), ["far.h5"])

    def test_links_to_nowhere(self):
        self.link("nowhere.h5", "missing/far.h5")
        self.link("loop.h5", "pool.h5")
        self.link("pool.h5", "loop.h5")
        for words in (("run", "scene.yaml"), ("sweep", "sweep.yaml"), ("tune", "scene.yaml", "-s", "time.end=2 s")):
            for more in ([], ["--force"], ["--resume"]):
                for name, says in (("nowhere.h5", "nowhere.h5: a link to missing/far.h5, which can't be made: No such file"),
                                   ("loop.h5", "loop.h5: Too many levels of symbolic links")):
                    self.assertIn(says, self.run_program(*words, "-o", name, *more, status=4))
        self.assertEqual(self.files(), ["scene.yaml", "sweep.yaml"])


if __name__ == "__main__":
    unittest.main()
