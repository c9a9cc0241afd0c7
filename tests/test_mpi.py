#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""mpirun ryusa sweep, with real Open MPI: the same table as without it, cases go to whoever is free, and
what is lost when a case, a process or the whole job is killed: nothing."""
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path


def skip(reason):
    print(f"skipped: {reason}")
    raise SystemExit(77)


try:
    import h5py
    import numpy as np
except ImportError as missing:
    skip(f"{missing}; Debian: apt install python3-h5py")

PROGRAM = os.environ["RYUSA"]
MPIRUN = shutil.which("mpirun")
if MPIRUN is None:
    skip("no mpirun; Debian: apt install openmpi-bin libopenmpi-dev")
if "Open MPI" not in subprocess.run([MPIRUN, "--version"], text=True, stdout=subprocess.PIPE).stdout:
    skip("mpirun is not Open MPI's, whose options this test uses")
if "built with MPI" not in " ".join(subprocess.run([PROGRAM, "sweep", "--help"], text=True,
                                                   stdout=subprocess.PIPE).stdout.split()):
    skip("ryusa was built without MPI; Debian: apt install libopenmpi-dev")

SCENE = """\
time: {step: 20 us, end: 8 s, settle: 2 ms}
grains: {columns: 6, layers: 3, seed: 3}
fluid: {shields: 0.5}
output: {interval: 2 ms, checkpoint: 0.1 s, fields: [flux]}
"""
PLAIN = {key: value for key, value in os.environ.items() if not key.startswith(("SLURM_", "OMPI_", "PMI"))}
# As root, without a network, on fewer cores than processes; a sanitizer would report what MPI leaves behind.
MPI = {**PLAIN, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "ASAN_OPTIONS": "detect_leaks=0"}
RUN = [MPIRUN, "--oversubscribe", "--bind-to", "none", "--mca", "btl", "self,vader"]


def children(pid):
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def rank_of(pid):
    return int(re.search(rb"OMPI_COMM_WORLD_RANK=(\d+)", Path(f"/proc/{pid}/environ").read_bytes()).group(1))


class Farm(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "scene.yaml").write_text(SCENE)
        self.write("vary: {fluid.shields: [0.3, 0.5, 0.7, 0.9, 1.1]}\n")

    def write(self, text):
        (self.folder / "s.yaml").write_text("scene: scene.yaml\n" + text)

    def start(self, processes, *words, options=()):
        command = [*RUN, *options, "-n", str(processes), PROGRAM, "sweep", "s.yaml", *words]
        return subprocess.Popen(command, cwd=self.folder, text=True, env=MPI, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE)

    def end(self, p, *status):
        out, err = p.communicate(timeout=120)
        self.assertIn(p.returncode, status, out + err)
        return out, err

    def farm(self, processes, *words, status=0):
        return self.end(self.start(processes, *words), status)

    kept = None  # the table of that sweep, made once

    def plain(self):
        if Farm.kept is None:
            subprocess.run([PROGRAM, "sweep", "s.yaml", "-q", "-o", "plain.h5"], cwd=self.folder, check=True, env=PLAIN)
            Farm.kept = self.table("plain.h5")

    def assert_like_plain(self):
        self.assert_same(self.table("s.h5"), Farm.kept)

    def table(self, name):
        with h5py.File(self.folder / name) as file:
            return {f"{g}/{k}": v[()] for g in ("cases", "inputs", "points") for k, v in file[g].items()}

    def assert_same(self, ours, plain):
        self.assertEqual(ours.keys(), plain.keys())
        for key in plain.keys() - {"cases/wall_seconds", "cases/file"}:
            np.testing.assert_array_equal(ours[key], plain[key], key)

    def wait_for(self, what, condition):
        deadline = time.monotonic() + 60
        while not condition():
            self.assertLess(time.monotonic(), deadline, what)
            time.sleep(0.02)

    def files(self, pattern):
        return sorted((self.folder / "s.d").glob(pattern))

    def ranks(self, p, n):
        """The processes by rank, when each of them has a case to run."""
        found = {}

        def look():
            try:
                found.update({rank_of(pid): pid for pid in children(p.pid)})
                return len(found) == n and all(children(pid) for pid in found.values())
            except (OSError, AttributeError):  # not yet, or between fork and exec
                return False
        self.wait_for("the processes", look)
        return found

    # --- nothing goes wrong ---

    def test_same_table(self):
        self.write("vary: {contact.alpha_cn: [0.1, 0.2, 50], contact.law: [cundall, energy]}\nreplicas: 2\n"
                   "set: {time.end: 20 ms}\n")
        r = subprocess.run([PROGRAM, "sweep", "s.yaml", "-o", "plain.h5"], cwd=self.folder, env=PLAIN, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(r.returncode, 3, r.stderr)  # alpha_cn = 50 is refused by one of the laws
        out, err = self.farm(3, status=3)
        self.assertRegex(out, r"cases   10 of 12 done, 2 failed")
        self.assertEqual(len(re.findall(r"(?m)^case .* q\* = ", err)), 10)
        self.assertEqual(err.count("FAILED"), 2)
        self.assert_same(self.table("s.h5"), self.table("plain.h5"))
        out, err = self.farm(2, "--resume", "-q", status=3)
        self.assertEqual(out, "")
        self.assert_same(self.table("s.h5"), self.table("plain.h5"))

    def test_cases_go_to_whoever_is_free(self):
        self.write("vary: {time.end: [30 s, 0.1 s, 0.11 s, 0.12 s, 0.13 s, 0.14 s, 0.15 s]}\n")
        _, err = self.farm(2, "-s", "stop.flux_error=0.001")
        ended = re.findall(r"(?m)^case (\d) of 7", err)
        self.assertEqual((sorted(ended), ended[-1]), (list("1234567"), "1"), err)

    def test_errors_come_once(self):
        _, err = self.farm(3, "--shard", "4/3", status=2)
        self.assertEqual(err.count("--shard 4/3: give I/N"), 1, err)
        self.write("vary: {fluid.shileds: [0.3]}\n")
        _, err = self.farm(3, status=2)
        self.assertEqual(err.count("s.yaml:2: fluid.shileds: unknown key"), 1, err)
        self.assertNotIn("can't take part", err)
        # started by the mpirun of another MPI
        r = subprocess.run([PROGRAM, "sweep", "s.yaml"], cwd=self.folder, text=True, stderr=subprocess.PIPE,
                           env={**MPI, "PMI_SIZE": "4", "PMI_RANK": "0"})
        self.assertEqual(r.returncode, 2, r.stderr)
        self.assertIn("one of 4 processes", r.stderr)

    def test_shares(self):
        """Farms of processes with the same share, and lone processes with shares of their own."""
        self.plain()
        self.farm(2, "--shard", "1/3")
        p = subprocess.Popen([*RUN, "-n", "1", PROGRAM, "sweep", "s.yaml", "--shard", "2/3", ":",
                              "-n", "1", PROGRAM, "sweep", "s.yaml", "--shard", "3/3"], cwd=self.folder, text=True, env=MPI,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.end(p, 0)
        self.assert_like_plain()

    def test_check_of_more_than_a_minute(self):
        """Process 0 says nothing before it has checked all cases; nobody takes it for dead."""
        (self.folder / "scene.yaml").write_text(
            "time: {step: 20 us, end: 2 ms}\nfluid: {model: none}\ndomain: {length: 1 m}\nparticles:\n" + "".join(
                f"  - {{position: [{k} mm, 1 cm], diameter: 0.5 mm, density: 2650 kg/m^3}}\n" for k in range(1, 500)))
        self.write("vary: {contact.friction: {from: 0.1, to: 1, steps: 20000}}\n")
        p = self.start(2)
        self.wait_for("the processes", lambda: len(children(p.pid)) == 2)
        time.sleep(2.0)
        found = {rank_of(pid): pid for pid in children(p.pid)}
        os.kill(found[0], signal.SIGSTOP)  # as if it had more to check, and took no time of the machine
        time.sleep(64.0)
        still_there = children(p.pid)
        os.kill(found[0], signal.SIGKILL)
        _, err = p.communicate(timeout=60)
        self.assertEqual(sorted(still_there), sorted(found.values()), err)
        self.assertEqual(self.files("*"), [])

    # --- kills ---

    def test_killed_case(self):
        self.plain()
        p = self.start(3)
        os.kill(children(self.ranks(p, 3)[2])[0], signal.SIGKILL)
        _, err = self.end(p, 3)
        self.assertIn("killed by signal 9", err)
        self.assertEqual(sorted(self.table("s.h5")["cases/status"].tolist()), [0, 0, 0, 0, 137])
        self.farm(2, "--resume")
        self.assert_like_plain()

    def test_killed_process(self):
        """Open MPI ends the whole job."""
        self.plain()
        for rank in (0, 1):
            p = self.start(2, "--force")
            found = self.ranks(p, 2)
            self.wait_for("a case that is done", lambda: self.files("case-*.txt"))
            done = {path: path.stat().st_mtime_ns for path in self.files("case-*.h5")}
            os.kill(found[rank], signal.SIGKILL)
            self.end(p, 137)
            self.assertFalse((self.folder / "s.h5").exists())
            self.farm(3, "--resume")
            self.assert_like_plain()
            self.assertEqual(done, {path: path.stat().st_mtime_ns for path in done})

    def test_killed_process_with_recovery(self):
        """Open MPI lets the others live; they do what the killed one had."""
        self.plain()
        p = self.start(3, options=["--enable-recovery"])
        os.kill(self.ranks(p, 3)[1], signal.SIGKILL)
        out, err = self.end(p, 0)
        self.assertIn("process 2 of 3 is gone; its case is given to another", err)
        self.assertIn("5 of 5 done", out)
        self.assert_like_plain()

    def test_killed_head_with_recovery(self):
        self.plain()
        p = self.start(3, options=["--enable-recovery"])
        os.kill(self.ranks(p, 3)[0], signal.SIGKILL)
        _, err = self.end(p, *range(256))  # Open MPI 4 says 0
        self.assertIn("process 2 of 3: the one that hands out the cases is gone; saved", err)
        self.assertFalse((self.folder / "s.h5").exists())
        self.farm(2, "--resume")
        self.assert_like_plain()

    def test_stopped(self):
        self.plain()
        for number in (signal.SIGINT, signal.SIGTERM):
            p = self.start(2, "--force")
            self.ranks(p, 2)
            self.wait_for("files", lambda: self.files("*.part"))
            p.send_signal(number)
            self.end(p, *range(1, 256))
            self.assertFalse((self.folder / "s.h5").exists())
            self.farm(2, "--resume")
            self.assert_like_plain()


if __name__ == "__main__":
    unittest.main()
