#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The program from outside: exit codes, what goes where, progress, signals, stop and resume."""
import math
import os
import pty
import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = os.environ["RYUSA"]
SCENE = """\
title: a few grains
time: {step: 20 us, end: 20 ms, settle: 2 ms}
grains: {columns: 8, layers: 4, seed: 3}
fluid: {shields: 0.5}
output: {interval: 2 ms}
"""


class Cli(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "scene.yaml").write_text(SCENE)

    def run_program(self, *words, **more):
        return subprocess.run([PROGRAM, *words], cwd=self.folder, text=True, timeout=120,
                              stdout=more.pop("stdout", subprocess.PIPE), stderr=subprocess.PIPE, **more)

    def refuses(self, status, *words, says=()):
        r = self.run_program(*words)
        self.assertEqual(r.returncode, status, (words, r.stderr))
        self.assertEqual(r.stdout, "", words)
        self.assertTrue(r.stderr.startswith("ryusa: "), r.stderr)
        for text in says:
            self.assertIn(text, r.stderr)

    def hash_of(self, r):
        self.assertEqual(r.returncode, 0, r.stderr)
        return re.search(r"^state hash (0x[0-9a-f]{16})$", r.stdout, re.M).group(1)

    def test_help_and_version(self):
        self.assertRegex(self.run_program("--version").stdout, r"^ryusa \d+\.\d+\.\d+\n$")
        self.assertIn("Commands:", self.run_program("--help").stdout)
        for command in ("run", "show", "info"):
            for word in ("--help", "-h"):
                r = self.run_program(command, word)
                self.assertEqual((r.returncode, r.stderr), (0, ""))
                self.assertTrue(r.stdout.startswith(f"Usage: ryusa {command} "), r.stdout)

    def test_bad_command_lines(self):
        self.refuses(2)
        self.refuses(2, "fly", says=["fly", "run", "show", "info"])
        self.refuses(2, "--fly", says=["--fly"])
        self.refuses(2, "run", says=["scene"])
        self.refuses(2, "run", "scene.yaml", "other.yaml", says=["scene.yaml", "other.yaml"])
        self.refuses(2, "run", "scene.yaml", "--fast", says=["--fast"])
        for threads in ("0", "-3", "1025", "two", "2x", ""):
            self.refuses(2, "run", "scene.yaml", "-j", threads, says=["1 to 1024"])
        self.refuses(2, "run", "scene.yaml", "-s", "contact.friction", says=["key.path=value"])
        self.refuses(2, "run", "scene.yaml", "-o", "scene.yaml", "--force", says=["scene"])
        self.refuses(2, "info", says=["file"])
        self.assertEqual((self.folder / "scene.yaml").read_text(), SCENE)

    def test_bad_scenes(self):
        self.refuses(2, "run", "scene.yaml", "-s", "contact.frictoin=0.4", says=["friction"])
        self.refuses(2, "show", "scene.yaml", "-s", "contact.friction=-1", says=["friction"])
        self.refuses(4, "run", "nowhere.yaml", says=["nowhere.yaml"])
        self.refuses(4, "info", "nowhere.h5", says=["nowhere.h5"])
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["scene.yaml"])
        (self.folder / "going.h5.part").touch()
        self.refuses(4, "info", "going.h5", says=["`info going.h5.part'"])

    def test_run(self):
        r = self.run_program("run", "scene.yaml")
        first = self.hash_of(r)
        self.assertTrue((self.folder / "scene.h5").is_file())
        self.assertFalse((self.folder / "scene.h5.part").exists())
        self.assertIn("q*", r.stdout)
        self.assertRegex(r.stderr, r"(?m)^100 %  t = .* s")
        self.assertNotIn("\r", r.stderr)
        self.refuses(4, "run", "scene.yaml", says=["scene.h5", "--force"])
        r = self.run_program("run", "-o", "scene.h5", "-j", "2", "scene.yaml", "--force")
        self.assertEqual(self.hash_of(r), first)
        other = self.hash_of(self.run_program("run", "scene.yaml", "-s", "grains.seed=4", "-o", "other.h5"))
        self.assertNotEqual(other, first)
        r = self.run_program("info", "scene.h5")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        self.assertIn("q", r.stdout)

    def test_part_that_goes_away(self):
        """What has its name by then is another's, and was taken for the end of this run."""
        for then in ("removed", "replaced"):
            job = subprocess.Popen([PROGRAM, "run", "scene.yaml", "-s", "time.end=400 s", "-o", "away.h5"], cwd=self.folder,
                                   text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            part = self.folder / "away.h5.part"
            while not part.exists():
                time.sleep(0.01)
            time.sleep(0.5)
            part.rename(self.folder / "moved.h5.part")
            if then == "replaced":
                part.write_text("another's")
            job.send_signal(signal.SIGINT)
            _, err = job.communicate(timeout=30)
            self.assertEqual(job.returncode, 4, err)
            self.assertIn("away.h5.part: was moved away or removed", err)
            self.assertEqual(part.read_text() if part.exists() else "", "another's" if then == "replaced" else "")
            self.assertEqual(self.run_program("info", "moved.h5.part").returncode, 0)
            self.assertFalse((self.folder / "away.h5").exists())

    def test_lost_sector(self):
        """HDF5 never ends, or breaks down, in a heap of texts that is damaged; what is left is told, or refused."""
        self.run_program("run", "scene.yaml", "-o", "whole.h5", "--quiet")
        whole = (self.folder / "whole.h5").read_bytes()
        heaps = [m.start() for m in re.finditer(b"GCOL\x01", whole)]
        self.assertGreater(len(heaps), 0)
        for at, bytes_ in [(16, bytes(496)), (24, b"\xff" * 7 + b"\x7f"), (24, b"\xff" * 8), (24, b"\0\0\0\0\1\0\0\0"),
                           (512, bytes(512))]:
            for heap in heaps:
                damaged = whole[:heap + at] + bytes_ + whole[heap + at + len(bytes_):]
                for name in ("d.h5", "e.h5.part"):
                    (self.folder / name).write_bytes(damaged)
                self.assertIn(self.run_program("info", "d.h5").returncode, (0, 4))
                for name in ("d.h5", "e.h5"):
                    r = self.run_program("run", "scene.yaml", "-o", name, "--resume", "-s", "time.end=22 ms")
                    self.assertIn(r.returncode, (0, 4), r.stderr)

    def test_flux_that_nobody_knows(self):
        for words in (("time.settle=1",), ("time.end=0",), ("time.settle=20 ms",)):
            r = self.run_program("run", "scene.yaml", "--force", *[w for word in words for w in ("-s", word)])
            self.assertIn("q*      not known: the run has no samples with the fluid on\n", r.stdout)
        (self.folder / "one.yaml").write_text("particles: [{position: [0, 1 mm], velocity: [0.1, 0]}]\ntime: {end: 10 ms}\n"
                                              "domain: {gravity: 9.81}\nfluid: {model: stress, shear_stress: 1 Pa}\n")
        self.assertIn("q*      not known: the scene has no domain.length\n", self.run_program("run", "one.yaml").stdout)

    def test_flux_without_samples(self):
        import h5py
        self.assertEqual(self.run_program("run", "scene.yaml", "-s", "time.settle=1").returncode, 0)
        with h5py.File(self.folder / "scene.h5") as file:
            self.assertNotEqual(*[file["observables/flux"].attrs["q_star_mean"]] * 2)  # not a number
        self.assertRegex(self.run_program("info", "scene.h5").stdout, r"q\* +not known: the run has no samples")

    def test_what_lies_where_the_part_goes(self):
        (self.folder / "scene.h5.part").write_text("my notes\n")
        self.refuses(4, "run", "scene.yaml", "--force", says=["scene.h5.part", "not a result"])
        self.assertEqual((self.folder / "scene.h5.part").read_text(), "my notes\n")

    def test_flux_of_the_start(self):
        """A run that ends with the start from motion says so."""
        scene = ("-s", "time.end=0.2", "-s", "time.settle=0.1", "-s", "fluid.start=motion", "-s", "fluid.shields=0.1")
        r = self.run_program("run", "scene.yaml", *scene)
        self.assertIn("note    q* is of the start from motion, at a higher stress (fluid.start), which ends at t = 0.35 s", r.stdout)
        self.assertIn("the run ended with the start", self.run_program("info", "scene.h5").stdout)
        r = self.run_program("run", "scene.yaml", "--force", *scene, "-s", "fluid.start=rest")
        self.assertNotIn("of the start from motion", r.stdout)

    def test_memory_that_is_given_back(self):
        """With other bytes in freed memory (glibc): nobody reads it."""
        r = self.run_program("run", "scene.yaml", env={**os.environ, "MALLOC_PERTURB_": "85"})
        self.assertEqual(r.returncode, 0, r.stderr)
        r = self.run_program("info", "scene.h5", env={**os.environ, "MALLOC_PERTURB_": "85"})
        self.assertEqual(r.returncode, 0, r.stderr)

    def test_the_clock_decides_nothing(self):
        """A run that breaks down does so at the same step, and keeps the same state, however often it saves."""
        found = []
        for often in ("0", "60"):
            r = self.run_program("run", "scene.yaml", "-s", "time.end=0.6", "-s", "time.settle=0.02", "-s", "fluid.shields=100",
                                 "-s", "fluid.lift=10", "-s", "output.interval=1ms", "-s", f"output.checkpoint={often}", "-o",
                                 f"broken{often}.h5")
            self.assertEqual(r.returncode, 3, r.stderr)
            hash_of = re.search(r"state hash +(\w+)", self.run_program("info", f"broken{often}.h5.part").stdout).group(1)
            found.append((r.stderr.splitlines()[-1], hash_of))
        self.assertEqual(*found)

    def test_byte_order_mark(self):
        (self.folder / "marked.yaml").write_text("\ufeff" + SCENE[SCENE.index("time"):], "utf-8")
        self.assertEqual(self.run_program("show", "marked.yaml").returncode, 0)

    def test_narrow_between_walls(self):
        import h5py
        import numpy as np
        for packing in ("square", "hexagonal", "random"):
            for length in ("0.55 mm", "0.6 mm", "0.9 mm", "1.3 mm"):
                r = self.run_program("run", "scene.yaml", "-o", "narrow.h5", "--force", "-s", "grains.columns=1", "-s",
                                     f"grains.packing={packing}", "-s", f"domain.length={length}", "-s",
                                     "domain.periodic=false", "-s", "domain.walls=true", "-s", "fluid.model=none")
                self.assertEqual(r.returncode, 0, r.stderr)
                with h5py.File(self.folder / "narrow.h5") as file:
                    grains, walls = file["particles/grains"], float(length.split()[0]) * 1e-3
                    x, r = grains["position/value"][:, :, 0], 0.5 * grains["diameter"][:]
                    moves = grains["fixed"][:] == 0
                self.assertTrue(np.all((x[0] > r - 1e-12) & (x[0] < walls - r + 1e-12) | ~moves), (packing, length))
                self.assertTrue(np.all((x > 0.9 * r) & (x < walls - 0.9 * r) | ~moves), (packing, length))

    def test_output_that_does_not_arrive(self):
        for words in (("--help",), ("run", "--help"), ("run", "--usage"), ("--version",), ("show", "scene.yaml")):
            with open("/dev/full", "w") as full:
                r = self.run_program(*words, stdout=full)
            self.assertEqual((r.returncode, r.stderr), (4, "ryusa: the output can't be written\n"), words)

    def test_quiet(self):
        r = self.run_program("run", "scene.yaml", "--quiet")
        self.assertEqual((r.returncode, r.stdout, r.stderr), (0, "", ""))

    def test_show(self):
        r = self.run_program("show", "scene.yaml", "-s", "contact.friction=0.4321")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        self.assertIn("0.4321", r.stdout)
        self.assertNotIn("diameters each", r.stdout)
        (self.folder / "scene.yaml").write_text(SCENE + "particles: [{position: [1 mm, 10 m], diameter: 0.5 mm}]\n")
        self.assertRegex(self.run_program("show", "scene.yaml").stdout, "8192 cells of 0.00122. m, 2.44 diameters each")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["scene.yaml"])

    def test_show_of_a_hertz_spring(self):
        """Only `energy` bounds; the overlap under a weight goes as its 2/3."""
        says = {law: self.run_program("show", "scene.yaml", "-s", f"contact.law={law}", "-s", "contact.alpha_cn=0.1",
                                      "-s", "domain.gravity=9.81").stdout for law in ("energy", "cundall", "tanaka")}
        self.assertEqual({law: "bounded by the law" in text for law, text in says.items()},
                         {"energy": True, "cundall": False, "tanaka": False})
        linear, hertz = (float(re.search(r"static overlap +(\S+) d", says[law]).group(1)) for law in ("cundall", "tanaka"))
        self.assertAlmostEqual(hertz / linear ** (2 / 3), 1.0, delta=0.01)
        self.assertGreater(linear, 0.0)

    def test_show_tells_what_is_used(self):
        """The dashpot of a restitution is not that of alpha_cn; of parameters without use is said why."""
        def show(*settings):
            words = [word for s in ("contact.law=cundall", "domain.gravity=9.81", *settings) for word in ("-s", s)]
            text = self.run_program("show", os.environ["SOURCE_DIR"] + "/params/flume.yaml", *words).stdout
            eta, c, zeta = (float(re.search(rf"{name} +(\S+)", text).group(1)) for name in
                            ("damping eta", "eta dt/m_r", "damping ratio zeta"))
            return eta, c, zeta, text
        eta, c, zeta, text = show("contact.restitution=0.5", "contact.alpha_cn=1.3")
        self.assertEqual((eta, c, zeta), show("contact.restitution=0.5", "contact.alpha_cn=0.1")[:3])
        self.assertAlmostEqual(zeta, math.log(2.0) / math.hypot(math.pi, math.log(2.0)), delta=1e-7)
        a, k = (float(re.search(rf"{name} +(\S+)", text).group(1)) for name in (r"a = k dt\^2/m_r", "stiffness k"))
        self.assertAlmostEqual(c / (2.0 * zeta * a ** 0.5), 1.0, delta=1e-6)
        self.assertAlmostEqual(eta * a / (c * k * 2e-5), 1.0, delta=1e-6)  # m_r = k dt^2/a
        self.assertIn("0.5 was asked for", text)
        self.assertRegex(text, r"alpha_cn +1\.3 +\(not used: the damping is that of contact\.restitution\)")
        self.assertRegex(text, r"roughness .*\(not used: of model log\)")
        self.assertNotRegex(show("fluid.model=log")[3], r"roughness .*not used")

    def test_reader_that_leaves(self):
        r = subprocess.run(f"'{PROGRAM}' show scene.yaml | true; exit ${{PIPESTATUS[0]}}", cwd=self.folder,
                           shell=True, executable="/bin/bash", stderr=subprocess.PIPE)
        self.assertEqual((r.returncode, r.stderr), (0, b""))
        r = subprocess.run(f"exec '{PROGRAM}' run scene.yaml >&- 2>&-", cwd=self.folder, shell=True)
        self.assertEqual(r.returncode, 0)
        r = self.run_program("info", "scene.h5")
        self.assertEqual(r.returncode, 0, r.stderr)
        if Path("/dev/full").exists():
            with open("/dev/full", "w") as full:
                self.assertEqual(self.run_program("show", "scene.yaml", stdout=full).returncode, 4)

    def stop_and_go_on(self, number):
        long = ("scene.yaml", "-s", "time.end=400 s", "-o", f"stopped{number}.h5")
        p = subprocess.Popen([PROGRAM, "run", *long], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
        time.sleep(1.0)
        p.send_signal(number)
        for _ in range(300 if number == signal.SIGTERM else 0):  # a scheduler may say it again
            p.send_signal(number)
        out, err = p.communicate(timeout=30)
        self.assertEqual((p.returncode, out), (130, ""), err)
        self.assertRegex(err, r"ryusa: stopped at t = .* s, saved; go on with: .* run .* --resume\n$")
        self.assertIn(f"go on with: {PROGRAM} run scene.yaml ", err)  # as it was called, to be copied
        return float(re.search(r"stopped at t = (\S+) s", err).group(1)), f"stopped{number}.h5"

    def test_stop_and_resume(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            time_stopped, name = self.stop_and_go_on(number)
            end = f"time.end={time_stopped + 0.01:.5f} s"
            resumed = self.run_program("run", "scene.yaml", "-s", end, "-o", name, "--resume")
            straight = self.run_program("run", "scene.yaml", "-s", end, "-o", "straight.h5", "--force")
            self.assertEqual(self.hash_of(resumed), self.hash_of(straight))

    def test_breaks_down(self):
        """In air, where the column ought to advance more often: grains leave the domain by many of its lengths."""
        words = ("grains.columns=16", "grains.layers=8", "contact.law=tanaka", "grains.seed=25", "grains.spread=0",
                 "contact.restitution=0.5", "contact.friction=0.3", "domain.floor=flat", "fluid.shields=0.4",
                 "fluid.density=1.2", "time.settle=3 ms", "time.end=60 ms")
        r = self.run_program("run", "scene.yaml", "-o", "broken.h5", "--quiet", *(w for o in words for w in ("-s", o)))
        self.assertEqual((r.returncode, r.stdout), (3, ""))
        self.assertRegex(r.stderr, r"^ryusa: step \d+ .*moves further than its diameter.* is kept.*fluid\.advance")
        self.assertIn("q*", self.run_program("info", "broken.h5.part").stdout)

    def test_breaks_down_to_no_numbers(self):
        """Samples that are no numbers are no reason to call the scene wrong."""
        words = ("domain.periodic=false", "domain.walls=true", "grains.columns=20", "grains.layers=3", "grains.spread=0",
                 "grains.packing=square", "grains.seed=231", "contact.law=cundall", "contact.alpha_m=80",
                 "fluid.shields=0.2", "fluid.advance=1", "fluid.drag=ferguson-church", "fluid.lift=0.2",
                 "fluid.density=0.05", "fluid.viscosity=1.5e-5", "time.settle=10 ms", "time.end=30 ms")
        r = self.run_program("run", "scene.yaml", "-o", "nan.h5", "--quiet", *(w for o in words for w in ("-s", o)))
        self.assertEqual((r.returncode, r.stdout), (3, ""))
        self.assertRegex(r.stderr, r"^ryusa: step \d+ .*not a number.* is kept")
        self.assertEqual(self.run_program("info", "nan.h5.part").returncode, 0)

    def test_resume_with_an_end_that_is_past(self):
        time_stopped, name = self.stop_and_go_on(signal.SIGINT)
        r = self.run_program("run", "scene.yaml", "-s", "time.end=40 ms", "-o", name, "--resume")
        self.assertEqual(r.returncode, 0, r.stderr)
        found = re.search(r"note +it had come to t = (\S+) s, beyond time.end = 0.04 s: no step", r.stdout)
        self.assertAlmostEqual(float(found.group(1)) / time_stopped, 1.0, 3)

    def test_terminal(self):
        try:
            pid, terminal = pty.fork()
        except OSError as error:
            self.skipTest(f"no terminal to be had: {error}")
        if pid == 0:
            os.chdir(self.folder)
            os.environ["TERM"] = "xterm"
            os.execv(PROGRAM, ["ryusa", "run", "scene.yaml", "-s", "time.end=400 s"])
        text, pressed, start = b"", False, time.monotonic()
        while True:
            try:
                piece = os.read(terminal, 4096)
            except OSError:
                break
            if not piece:
                break
            text += piece
            if not pressed and time.monotonic() - start > 1.5:
                os.write(terminal, b"\x03")
                pressed = True
        _, status = os.waitpid(pid, 0)
        self.assertEqual(os.waitstatus_to_exitcode(status), 130, text)
        self.assertRegex(text, rb"\r\x1b\[K *\d+ % .*t = .* s .*steps/s .* left")
        self.assertEqual(text.count(b"\n"), 1, text)


if __name__ == "__main__":
    unittest.main()
