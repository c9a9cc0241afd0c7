#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""ryusa sweep: sampling, the table and its links, the same bits however it is run, kills and resume,
failures, shards, and what is refused."""
import fcntl
import os
import pty
import re
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import termios
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
title: a few grains
time: {step: 20 us, end: 20 ms, settle: 2 ms}
grains: {columns: 6, layers: 3, seed: 3}
fluid: {shields: 0.5}
output: {interval: 2 ms}
"""
PLAIN = {key: value for key, value in os.environ.items() if not key.startswith("SLURM_")}


class Sweep(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "scene.yaml").write_text(SCENE)

    def write(self, text, name="s.yaml"):
        (self.folder / name).write_text("scene: scene.yaml\n" + text)

    def run_program(self, *words, **environment):
        return subprocess.run([PROGRAM, "sweep", *words], cwd=self.folder, text=True, timeout=120,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**PLAIN, **environment})

    def sweep(self, *words, status=0, **environment):
        r = self.run_program("s.yaml", *words, **environment)
        self.assertEqual(r.returncode, status, r.stdout + r.stderr)
        return r

    def refuses(self, status, *words, says=(), **environment):
        r = self.run_program(*words, **environment)
        self.assertEqual((r.returncode, r.stdout), (status, ""), (words, r.stderr))
        for text in says:
            self.assertIn(text, r.stderr)

    def table(self, name="s.h5"):
        with h5py.File(self.folder / name) as file:
            return {f"{g}/{k}": v[()] for g in ("cases", "inputs", "points") if g in file for k, v in file[g].items()}

    def hashes(self, name="s.h5"):
        return list(self.table(name)["cases/hash"])

    # --- what is run ---

    def test_grid(self):
        self.write("vary:\n  fluid.shields: {from: 0.2, to: 0.8, steps: 3, scale: log}\n"
                   "  contact.law: [energy, cundall]\nreplicas: 2\nset: {grains.diameter: 0.4 mm, contact.alpha_cn: 0.1,"
                   " output.fields: [flux]}\n")
        r = self.sweep()
        self.assertIn("12 of 12 done", r.stdout)
        self.assertRegex(r.stderr, r"case 12 of 12 \(fluid.shields=0.8, contact.law=cundall, grains.seed=4\): q\* = ")
        self.assertRegex(r.stderr, r"(?m)^100 %  12 of 12 cases")
        t = self.table()
        self.assertEqual(t["cases/status"].tolist(), [0] * 12)
        np.testing.assert_allclose(t["inputs/fluid.shields"], np.repeat([0.2, 0.4, 0.8], 4), rtol=1e-11)
        self.assertEqual(list(t["inputs/contact.law"]), [b"energy", b"energy", b"cundall", b"cundall"] * 3)
        self.assertEqual(t["cases/seed"].tolist(), [3, 4] * 6)
        self.assertEqual(t["points/replicas"].tolist(), [2] * 6)
        np.testing.assert_allclose(t["points/q_star"], t["cases/q_star"].reshape(6, 2).mean(axis=1))
        within = np.sqrt((t["cases/q_star_standard_error"].reshape(6, 2) ** 2).sum(axis=1)) / 2
        between = np.sqrt(np.maximum(t["cases/q_star"].reshape(6, 2).var(axis=1, ddof=1) / 2 - within ** 2, 0.0))
        np.testing.assert_allclose(t["points/error_within"], within, rtol=1e-6)
        np.testing.assert_allclose(t["points/error_between"], between, rtol=1e-6, atol=1e-12)
        # of few beds: not below what their own errors give, and 95 % by Student's t
        error, wide = t["points/q_star_standard_error"], t["points/q_star_confidence_95"]
        self.assertTrue((error >= within * (1 - 1e-9)).all())
        self.assertTrue((wide > 1.95 * error).all() and (wide < 7.0 * error).all())
        with h5py.File(self.folder / "s.h5") as file:
            linked = file["results/case-0007/observables/q_star/value"]
            self.assertEqual(len(linked), 21)
            self.assertEqual(file["results/case-0007/parameters"].attrs["grains.diameter"], 0.4e-3)
            self.assertEqual(file.attrs["varied"], "fluid.shields,contact.law")

    def test_list_and_units(self):
        self.write("vary:\n  grains.diameter: [0.4 mm, 5e-4]\n  fluid.shields: [0.3, 0.6]\nsample: list\n")
        self.sweep("--quiet", "-s", "grains.layers=2")
        t = self.table()
        np.testing.assert_allclose(t["inputs/grains.diameter"], [4e-4, 5e-4])
        np.testing.assert_allclose(t["inputs/fluid.shields"], [0.3, 0.6])
        self.assertEqual(t["cases/changes"][0], b"grains.diameter=0.4 mm, fluid.shields=0.3")

    def test_random(self):
        both = "vary: {fluid.shields: {from: 0.1, to: 1.1}, contact.friction: {from: 0.1, to: 1, scale: log}}\n"
        for sample in ("random", "latin-hypercube"):
            self.write(both + f"sample: {sample}\nsamples: 10\n")
            self.sweep("--force", "-s", "time.end=4 ms", "--quiet")
            first = self.table()
            self.sweep("--force", "-s", "time.end=4 ms", "--quiet")
            again = self.table()
            x = (first["inputs/fluid.shields"] - 0.1) / 1.0
            y = 1.0 + np.log10(first["inputs/contact.friction"])
            self.assertTrue(((x >= 0) & (x <= 1) & (y >= 0) & (y <= 1)).all())
            self.assertEqual(first["inputs/fluid.shields"].tolist(), again["inputs/fluid.shields"].tolist())
            if sample == "latin-hypercube":
                for u in (x, y):
                    self.assertEqual(sorted(np.floor(10 * u).astype(int)), list(range(10)))
                self.assertLess(abs(np.corrcoef(x, y)[0, 1]), 0.9)

    def test_same_as_run(self):
        self.write("vary: {fluid.shields: [0.3, 0.9]}\n")
        self.sweep("-j", "1", "-o", "one.h5")
        self.sweep("-j", "7", "-o", "seven.h5")
        r = subprocess.run([PROGRAM, "run", "scene.yaml", "-s", "fluid.shields=0.9"], cwd=self.folder, text=True,
                           stdout=subprocess.PIPE, check=True)
        alone = re.search(r"hash (0x\w+)", r.stdout).group(1).encode()
        self.assertEqual(self.hashes("one.h5"), self.hashes("seven.h5"))
        self.assertEqual(self.hashes("one.h5")[1], alone)

    def test_cores_of_a_case(self):
        # 20 000 grains on two cores: each of two cases one core; a case alone both, if there are two
        (self.folder / "scene.yaml").write_text(SCENE.replace("columns: 6, layers: 3", "columns: 1000, layers: 20"))
        self.write("vary: {fluid.shields: [0.3, 0.5]}\nset: {time.end: 0.1 ms, time.settle: 0, output.fields: [flux]}\n")
        two = min(2, len(os.sched_getaffinity(0)))
        for cases, threads in ((2, 1), (1, two)):
            if cases == 1:
                self.write("vary: {fluid.shields: [0.3]}\nset: {time.end: 0.1 ms, time.settle: 0, output.fields: [flux]}\n")
            self.sweep("--force", "-j", "2")
            with h5py.File(self.folder / "s.h5") as file:
                self.assertEqual([r["cost"].attrs["threads"] for r in file["results"].values()], [threads] * cases)
        # small ones never get two
        (self.folder / "scene.yaml").write_text(SCENE)
        self.sweep("--force", "-j", "2", "-s", "time.end=0.2 ms")
        with h5py.File(self.folder / "s.h5") as file:
            self.assertEqual(file["results/case-0001/cost"].attrs["threads"], 1)

    def info(self, name):
        r = subprocess.run([PROGRAM, "info", name], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return r.stdout

    def test_info(self):
        self.write("vary:\n  contact.alpha_cn: [0.1, 0.2, 50]\n  contact.law: [cundall, energy]\n"
                   "  grains.diameter: [0.4 mm, 0.5 mm]\nreplicas: 2\ntitle: of three keys\n")
        self.sweep("-q", "--shard", "1/2", status=3)  # the first replicas; one law refuses alpha_cn = 50
        self.sweep("-q", "--merge", status=3)
        text, t = self.info("s.h5"), self.table()
        done = t["cases/status"] == 0
        q = t["cases/q_star"][done]
        self.assertIn("table of       ryusa sweep\n", text)
        self.assertIn("title          of three keys\n", text)
        self.assertIn("cases          24: 10 done, 2 failed, 12 missing\n", text)
        self.assertIn("points         12, each with 2 replicas\n", text)
        self.assertRegex(text, r"(?m)^  contact.alpha_cn +0.1 to 50, 3 values$")
        self.assertRegex(text, r"(?m)^  contact.law +cundall, energy$")
        self.assertRegex(text, r"(?m)^  grains.diameter +0.0004 to 0.0005 m, 2 values$")
        self.assertIn(f"q*             {q.min():.4g} to {q.max():.4g}\n", text)
        self.assertRegex(text, r"(?m)^  case 17 \(contact.alpha_cn=50, contact.law=cundall, .*, status 2: .*alpha_cn")
        self.assertEqual(len(re.findall(r"(?m)^ +\d+ +0\.5 ", text)), 10)  # rows of points
        with h5py.File(self.folder / "s.h5", "a") as file:  # a table of which some is missing
            del file["cases/q_star"], file["inputs/contact.law"], file["points/shields"], file["cases/changes"]
            file.attrs["replicas"] = "many"
        self.assertIn("2 failed, 12 missing", self.info("s.h5"))

    def draw(self, *words):
        script = Path(os.environ["SOURCE_DIR"]) / "postprocess/sweep.py"
        return subprocess.run([sys.executable, "-B", script, *words], cwd=self.folder, text=True, timeout=120,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def test_pictures(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError as missing:
            self.skipTest(str(missing))
        self.write("vary: {fluid.shields: [0.3, 0.9], contact.friction: [0.3, 0.6]}\ntitle: two by two\nreplicas: 2\n")
        self.sweep("-q", "-o", "theta.h5")
        self.write("vary: {contact.law: [energy, fujioka-2], contact.friction: [0.3, 0.6]}\n")
        self.sweep("-q", "-o", "law.h5")
        for name in ("theta", "law"):
            r = self.draw(f"{name}.h5")
            self.assertEqual((r.returncode, r.stdout, r.stderr), (0, f"{name}-sweep.png\n", ""))
            self.assertGreater((self.folder / f"{name}-sweep.png").stat().st_size, 10000)
        for words, code, says in ((["nowhere.h5"], 4, "no such file"), (["law.d/case-0001.h5"], 4, "not the table of a sweep"),
                                  (["s.yaml"], 4, "not an HDF5 file"), (["theta.h5", "-r", "nobody"], 2, "no relation")):
            r = self.draw(*words)
            self.assertEqual(r.returncode, code)
            self.assertIn(says, r.stderr)
            self.assertNotIn("Traceback", r.stderr)

    # --- stops ---

    LONG = "vary: {fluid.shields: [0.3, 0.6, 0.9]}\nset: {time.end: 9 s, output.checkpoint: 0.1 s, output.fields: [flux]}\n"

    def start(self, *words):
        return subprocess.Popen([PROGRAM, "sweep", "s.yaml", *words], cwd=self.folder, text=True, env=PLAIN,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def test_kill_and_resume(self):
        self.write(self.LONG)
        self.sweep("-o", "straight.h5")
        for number in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM):
            p = self.start("--force", "-j", "2")
            deadline = time.monotonic() + 60
            while not any((self.folder / "s.d").glob("case-*.part")) and time.monotonic() < deadline:
                time.sleep(0.02)
            time.sleep(0.4)
            p.send_signal(number)
            _, err = p.communicate(timeout=60)
            if number == signal.SIGKILL:
                self.assertEqual(p.returncode, -9)
            elif p.returncode != 0:  # a fast machine may have been done
                self.assertEqual(p.returncode, 130, err)
                self.assertIn("--resume goes on", err)
                self.assertFalse((self.folder / "s.h5").exists())
            self.refuses(4, "s.yaml", says=["--resume", "--force"])
            self.sweep("--resume", "-j", "3")
            self.assertEqual(self.hashes(), self.hashes("straight.h5"))
        before = {p.name: p.stat().st_mtime_ns for p in (self.folder / "s.d").glob("case-*.h5")}
        self.sweep("--resume")
        self.assertEqual(before, {p.name: p.stat().st_mtime_ns for p in (self.folder / "s.d").glob("case-*.h5")})

    def test_stop_while_cases_are_checked(self):
        (self.folder / "scene.yaml").write_text(
            "time: {step: 20 us, end: 2 ms}\nfluid: {model: none}\ndomain: {length: 1 m}\nparticles:\n" + "".join(
                f"  - {{position: [{k} mm, 1 cm], diameter: 0.5 mm, density: 2650 kg/m^3}}\n" for k in range(1, 500)))
        self.write("vary: {contact.friction: {from: 0.1, to: 1, steps: 20000}}\n")
        p = self.start()
        time.sleep(1.0)
        p.send_signal(signal.SIGINT)
        asked = time.monotonic()
        _, err = p.communicate(timeout=100)
        self.assertEqual(p.returncode, 130, err)
        self.assertLess(time.monotonic() - asked, 1.0)
        self.assertIn("none was begun", err)
        self.assertFalse((self.folder / "s.d").exists())

    def test_missing_case_is_run_again(self):
        self.write("vary: {fluid.shields: [0.3, 0.6, 0.9]}\n")
        self.sweep()
        first = self.hashes()
        (self.folder / "s.d/case-0002.h5").unlink()
        (self.folder / "s.d/case-0003.txt").unlink()
        self.sweep("--resume")
        self.assertEqual(self.hashes(), first)

    def test_damaged_record_is_run_again(self):
        self.write("vary: {fluid.shields: [0.3, 0.6]}\n")
        self.sweep()
        first = self.table()
        record = self.folder / "s.d/case-0002.txt"
        whole = record.read_bytes()
        for damaged in (whole[:whole.index(b"\n") + 1], whole[:-1], b"", whole.replace(b"status = 0", b"status = 0x"),
                        re.sub(rb"(samples = \d+)", rb"\1.5", whole), re.sub(rb"q_star = .*", b"q_star = ", whole),
                        bytes(len(whole))):
            record.write_bytes(damaged)
            self.sweep("--merge")
            self.assertEqual(self.table()["cases/status"].tolist(), [0, -1], damaged)
            self.sweep("--resume")
            again = self.table()
            for key in first.keys() - {"cases/wall_seconds"}:
                np.testing.assert_array_equal(again[key], first[key], key)

    def test_killed_worker(self):
        self.write(self.LONG.replace("time.end: 9 s", "time.end: 300 s, stop.flux_error: 0.5, stop.after: 20 s"))
        p = self.start("-j", "2")
        children = Path(f"/proc/{p.pid}/task/{p.pid}/children")
        deadline = time.monotonic() + 60
        pids = []
        try:
            while not pids and time.monotonic() < deadline:
                time.sleep(0.01)
                pids = children.read_text().split() if any((self.folder / "s.d").glob("case-*.part")) else []
        except OSError:
            p.kill()
            p.communicate()
            self.skipTest("this kernel does not list children")
        os.kill(int(pids[0]), signal.SIGKILL)
        out, err = p.communicate(timeout=120)
        self.assertEqual(p.returncode, 3, err)
        self.assertIn("killed by signal 9", err)
        self.assertEqual(sorted(self.table()["cases/status"].tolist()), [0, 0, 137])
        self.sweep("--resume")
        self.assertEqual(self.table()["cases/status"].tolist(), [0, 0, 0])

    def test_ignored_sigchld(self):
        self.write("vary: {fluid.shields: [0.3, 0.6]}\nset: {time.end: 900 s, output.fields: [flux]}\n")
        for number, status in ((signal.SIGINT, 130), (signal.SIGKILL, 3)):
            p = subprocess.Popen([PROGRAM, "sweep", "s.yaml", "--force", "-j", "1"], cwd=self.folder, text=True, env=PLAIN,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                 preexec_fn=lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN))
            for _ in range(2 if number == signal.SIGKILL else 1):  # both cases, or the sweep
                pids = []
                deadline = time.monotonic() + 60
                while not pids and time.monotonic() < deadline:
                    time.sleep(0.02)
                    pids = Path(f"/proc/{p.pid}/task/{p.pid}/children").read_text().split()
                time.sleep(0.3)
                os.kill(int(pids[0]) if number == signal.SIGKILL else p.pid, number)
                time.sleep(0.3)
            _, err = p.communicate(timeout=60)
            self.assertEqual(p.returncode, status, err)

    def test_failures(self):
        # 2: refused, the explicit dashpot would blow up; the others are done
        self.write("vary: {contact.alpha_cn: [0.1, 50]}\nset: {contact.law: cundall}\n")
        r = self.sweep(status=3)
        self.assertRegex(r.stderr, r"case 2 of 2 \(contact.alpha_cn=50\): FAILED: .*alpha_cn")
        self.assertRegex(r.stderr, r"(?m)^ryusa: 1 of 2 cases failed, the others are done; case 2 ")
        t = self.table()
        self.assertEqual(t["cases/status"].tolist(), [0, 2])
        self.assertTrue(np.isnan(t["cases/q_star"][1]))
        self.assertIn(b"alpha_cn", t["cases/message"][1])
        self.sweep("--resume", status=3)
        # every case refused: the sweep is wrong, and nothing is made
        self.write("vary: {contact.alpha_cn: [60, 50]}\nset: {contact.law: cundall}\n")
        self.refuses(2, "s.yaml", "-o", "none.h5", says=["alpha_cn"])
        self.write("vary: {contact.alpha_cn: [60, 50], contact.law: [cundall]}\n")
        self.refuses(2, "s.yaml", "-o", "none.h5", says=["s.yaml: every case is refused; the first: ", "alpha_cn"])
        self.assertFalse((self.folder / "none.d").exists())

    # --- shards ---

    def test_shards(self):
        self.write("vary: {fluid.shields: [0.3, 0.5, 0.7, 0.9, 1.1]}\n")
        self.sweep("-o", "whole.h5")
        r = self.sweep("--shard", "2/3")
        self.assertIn("2 of 5 done, 3 not run yet", r.stdout)
        self.assertFalse((self.folder / "s.h5").exists())
        self.refuses(4, "s.yaml", "--shard", "2/3", says=["--resume"])
        self.sweep("--merge")
        t = self.table()
        self.assertEqual(t["cases/status"].tolist(), [-1, 0, -1, -1, 0])
        self.assertEqual(t["points/replicas"].tolist(), [0, 1, 0, 0, 1])
        (self.folder / "s.h5").unlink()
        slurm = {"SLURM_ARRAY_TASK_COUNT": "3", "SLURM_ARRAY_TASK_MIN": "10", "SLURM_ARRAY_TASK_STEP": "2",
                 "SLURM_CPUS_PER_TASK": "1"}
        self.sweep("--resume", SLURM_ARRAY_TASK_ID="10", **slurm)
        self.assertFalse((self.folder / "s.h5").exists())
        self.sweep("--resume", SLURM_ARRAY_TASK_ID="14", **slurm)
        self.assertEqual(self.hashes(), self.hashes("whole.h5"))
        self.refuses(2, "s.yaml", says=["SLURM_ARRAY_TASK_COUNT"], SLURM_ARRAY_TASK_ID="1")
        self.refuses(4, "s.yaml", "--merge", "-o", "nothing.h5", says=["nothing.d", "no sweep"])

    def test_shards_together(self):
        self.write("vary: {fluid.shields: [0.3, 0.5, 0.7, 0.9, 1.1]}\n")
        tasks = [self.start("--shard", f"{k}/3") for k in (1, 2, 3)]
        for task in tasks:
            out, err = task.communicate(timeout=60)
            self.assertEqual(task.returncode, 0, out + err)
        self.assertEqual(self.table()["cases/status"].tolist(), [0] * 5)

    def test_shards_of_two_sweeps_together(self):
        for k, friction in enumerate((0.3, 0.6)):
            self.write(f"vary: {{fluid.shields: [0.3, 0.5]}}\nset: {{time.end: 0.4 s, contact.friction: {friction}}}\n",
                       f"{k}.yaml")
        for turn in range(3):
            tasks = [subprocess.Popen([PROGRAM, "sweep", f"{k}.yaml", "-o", f"{turn}.h5", "--shard", f"{k + 1}/2"],
                                      cwd=self.folder, text=True, env=PLAIN, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                     for k in (0, 1)]
            errors = "".join(task.communicate(timeout=60)[1] for task in tasks)
            self.assertEqual(sorted(task.returncode for task in tasks), [0, 2], errors)
            self.assertIn(f"{turn}.d holds another sweep: contact.friction was", errors)

    def stop_job_script(self, state):
        """What the job script has asked of scontrol when it was stopped and squeue says so of its task."""
        script = Path(os.environ["SOURCE_DIR"]) / "params/sweep.slurm"
        tools, asked = self.folder / "bin", self.folder / "requeued"
        tools.mkdir(exist_ok=True)
        for tool, does in ("scontrol", 'echo "$@" > requeued'), ("squeue", state):
            (tools / tool).write_text(f"#!/bin/sh\n{does}\n")
            (tools / tool).chmod(0o755)
        environment = {**PLAIN, "RYUSA": PROGRAM, "PATH": f"{tools}:{os.environ['PATH']}", "SLURM_JOB_ID": "77",
                       "SLURM_ARRAY_JOB_ID": "70", "SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_COUNT": "2",
                       "SLURM_ARRAY_TASK_MIN": "1"}
        p = subprocess.Popen(["bash", str(script), "s.yaml", "s.h5"], cwd=self.folder, text=True, env=environment,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(1.0)
        p.send_signal(signal.SIGTERM)
        _, err = p.communicate(timeout=60)
        self.assertEqual(p.returncode, 130, err)
        return asked.read_text() if asked.exists() else None

    def test_job_script(self):
        self.write(self.LONG.replace("9 s", "400 s"))
        self.assertIsNone(self.stop_job_script("echo COMPLETING"))
        for state in "echo RUNNING", "exit 1":
            self.assertEqual(self.stop_job_script(state), "requeue 70_1\n")

    # --- what is refused ---

    def test_changed_sweep(self):
        self.write("vary: {fluid.shields: [0.3, 0.6]}\n")
        self.sweep()
        self.write("vary: {fluid.shields: [0.3, 0.7]}\n")
        self.refuses(2, "s.yaml", "--resume", says=["vary fluid.shields was 0.3, 0.6, is 0.3, 0.7"])
        self.write("vary: {fluid.shields: [0.3, 0.6]}\nreplicas: 3\n")
        self.refuses(2, "s.yaml", "--resume", says=["replicas was 1, is 3"])
        self.write("vary: {contact.friction: [0.3, 0.6]}\n")
        self.refuses(2, "s.yaml", "--resume", says=["vary contact.friction was not there", "vary fluid.shields was 0.3"])
        self.write("vary: {fluid.shields: [0.3, 0.6]}\n")
        (self.folder / "scene.yaml").write_text(SCENE.replace("end: 20 ms", "end: 30 ms"))
        self.refuses(2, "s.yaml", "--resume", says=["time.end was 0.02, is 0.03"])
        self.refuses(2, "s.yaml", "--merge", says=["time.end was 0.02, is 0.03"])
        self.refuses(2, "s.yaml", "--shard", "1/2", "--force",
                     says=["time.end was 0.02", "or to begin anew, remove s.d, or --force without --shard"])
        self.assertEqual(self.table()["cases/status"].tolist(), [0, 0])
        self.sweep("--force")

    def test_narrow_terminal(self):
        self.write("vary: {fluid.shields: [0.2, 0.4]}\n")
        pid, terminal = pty.fork()
        if pid == 0:
            fcntl.ioctl(2, termios.TIOCSWINSZ, struct.pack("HHHH", 2, 12, 0, 0))
            os.chdir(self.folder)
            os.execve(PROGRAM, ["ryusa", "sweep", "s.yaml", "-s", "time.end=0.2 s"], {**PLAIN, "TERM": "xterm"})
        text = b""
        while True:
            try:
                piece = os.read(terminal, 4096)
            except OSError:
                break
            if not piece:
                break
            text += piece
        self.assertEqual(os.waitpid(pid, 0)[1], 0)
        lines = [line for line in re.findall(r"\x1b\[K([^\r\n\x1b]*)", text.decode()) if re.match(r" *\d+ %", line)]
        self.assertTrue(lines, text)
        self.assertLess(max(map(len, lines)), 12)

    def grains(self, n, head):
        rows = "".join(f"{head}{0.001 * (k % 200):.3f}, {0.001 * (k // 200 + 1):.3f}{']}' if head else ''}\n" for k in range(n))
        (self.folder / "t.csv").write_text("x, z\n" + rows)
        (self.folder / "scene.yaml").write_text("time: {step: 20 us, end: 20 us}\noutput: {fields: [flux]}\nparticles:\n" +
                                                (rows if head else "  - {file: t.csv, fixed: true}\n"))

    def test_many_particles(self):
        """To compare a sweep with the one that is there took the square of their number: minutes."""
        self.write("vary: {domain.gravity: [1, 2]}\n")
        for head in ("- {fixed: true, position: [", ""):
            self.grains(40000, head)
            begun = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
            self.sweep("--quiet", "--force")
            self.assertLess(sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - begun, 15)
            self.grains(39999, head)
            self.refuses(2, "s.yaml", "--resume", says=["holds another sweep", "particles[39999]" if head else "39999 grains"])

    def test_bad_files(self):
        bad = [
            ("vary: {}\n", ["s.yaml:2: vary: nothing to vary"]),
            ("replicas: 1\n", ["vary: nothing to vary"]),
            ("vary:\n  fluid.shields: []\n", ["s.yaml:3: fluid.shields: an empty list"]),
            ("vary:\n  fluid.shileds: [0.1]\n", ["s.yaml:3: fluid.shileds: unknown key", "did you mean fluid.shields?"]),
            ("vary:\n  shields: [0.1]\n", ["s.yaml:3: shields: unknown", "did you mean fluid.shields?"]),
            ("set:\n  contact.frictoin: 0.1\n", ["s.yaml:3: contact.frictoin", "did you mean contact.friction?"]),
            ("vary:\n  fluid.shields: [0.1,\n  -1]\n", ["s.yaml:4: fluid.shields: -1 is out of range", "0 to 100"]),
            ("vary:\n  fluid.shields: [0.1, 2 mm]\n", ["s.yaml:3: fluid.shields: '2 mm'"]),
            ("vary:\n  fluid.shields: 0.3\n", ["s.yaml:3: fluid.shields: '0.3'", "under 'set'"]),
            ("vary:\n  fluid.shields: [0.3, 0.3]\n", ["fluid.shields: the value 0.3 stands there twice"]),
            ("vary:\n  fluid.shields: [0.1, 0.2, 1e-1]\n", ["fluid.shields: the value 1e-1 stands there twice"]),
            ("vary:\n  contact.law: [energi]\n", ["s.yaml:3: contact.law", "did you mean energy?"]),
            ("vary:\n  contact.law: {from: 1, to: 2}\n", ["s.yaml:3: contact.law: takes words"]),
            ("vary:\n  fluid.shields: {from: 0.1, steps: 3}\n", ["no 'to'"]),
            ("vary:\n  fluid.shields: {from: 0.1, to: 1}\n", ["the range needs 'steps'"]),
            ("vary:\n  fluid.shields: {from: 0.1, to: 1, steps: 0}\n", ["0 is out of range"]),
            ("vary:\n  fluid.shields: {from: 0.1, to: 1, steps: 1}\n",
             ["s.yaml:3: fluid.shields: steps: 1 leaves out 'to'; at least 2"]),
            ("set: {fluid.shear_stress: 1}\nvary:\n  fluid.shields: [0.1, 0.2]\n",
             ["s.yaml:4: fluid.shields: contradicts fluid.shear_stress under 'set'; give only one"]),
            ("vary:\n  contact.alpha_m: [2, 3]\nset: {contact.stiffness: 100 N/m}\n",
             ["s.yaml:3: contact.alpha_m: contradicts contact.stiffness under 'set'"]),
            ("set: {fluid.shields: 0.1}\nvary:\n  fluid.shields: [0.1, 0.2]\n",
             ["s.yaml:4: fluid.shields: contradicts fluid.shields under 'set'; give only one"]),
            ("vary:\n  fluid.shields: {from: 0, to: 1, steps: 4, scale: log}\n", ["above 0"]),
            ("vary:\n  fluid.shields: {from: 0, to: 1, steps: 4, scale: cubic}\n", ["linear and log"]),
            ("vary:\n  fluid.shields: {from: 0, to: 1, setps: 4}\n", ["'setps'", "from, to, steps, scale"]),
            ("vary:\n  fluid.shields: [0.1, 0.2]\nsamples: 3\n", ["s.yaml:4: samples: only"]),
            ("vary:\n  fluid.shields: [0.1, 0.2]\nsample: random\n", ["s.yaml:4: samples: how many?"]),
            ("vary:\n  fluid.shields: [0.1, 0.2]\nsample: cubic\n", ["s.yaml:4: sample: 'cubic'", "latin-hypercube"]),
            ("vary:\n  fluid.shields: [0.1]\n  contact.friction: [0.1, 0.2]\nsample: list\n",
             ["s.yaml:4: contact.friction: 2 values, but fluid.shields has 1"]),
            ("vary:\n  grains.seed: [1, 2]\nreplicas: 2\n", ["s.yaml:3: grains.seed: can't be varied"]),
            ("vary:\n  grains.seed: {from: 1, to: 200000, steps: 200}\n  fluid.shields: {from: 0.1, to: 1, steps: 600}\n",
             ["120000 cases; at most 100000"]),
            ("vray:\n  fluid.shields: [0.1]\n", ["s.yaml:2: 'vray'", "did you mean vary?"]),
            ("replicas: two\n", ["s.yaml:2: replicas: 'two' is not a number"]),
            ("replicas: 2.5\n", ["s.yaml:2: replicas: 2.5 is not a whole number"]),
            ("vary: {fluid.shields: [0.1]}\nvary: {fluid.shields: [0.1]}\n", ["s.yaml:3: vary: stands here for the second"]),
            ("vary: {fluid.shields: [0.1}\n", ["s.yaml:2: not valid YAML"]),
            ("scene: other.yaml\n", ["second time"]),
        ]
        for text, says in bad:
            self.write(text)
            self.refuses(2, "s.yaml", says=says)
        (self.folder / "s.yaml").write_text("vary: {fluid.shields: [0.1]}\n")
        self.refuses(2, "s.yaml", says=["scene: not given"])
        (self.folder / "s.yaml").write_text("scene: nowhere.yaml\nvary: {fluid.shields: [0.1]}\n")
        self.refuses(4, "s.yaml", says=["s.yaml:1: scene: nowhere.yaml: can't be opened"])
        self.refuses(4, "nowhere.yaml", says=["nowhere.yaml"])
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["s.yaml", "scene.yaml"])

    def test_nothing_else_is_replaced(self):
        self.write("vary:\n  fluid.shields: [0.3]\n")
        before = {name: (self.folder / name).read_bytes() for name in ("s.yaml", "scene.yaml")}
        for words in (("-o", "./s.yaml", "--resume"), ("-o", "./s.yaml", "--force"), ("-o", "scene.yaml", "--force")):
            self.refuses(4, "s.yaml", *words, says=["not a result file"])
        subprocess.run([PROGRAM, "run", "scene.yaml", "-o", "res.h5", "--quiet"], cwd=self.folder, check=True)
        before["res.h5"] = (self.folder / "res.h5").read_bytes()
        self.refuses(4, "s.yaml", "-o", "res.h5", "--resume", says=["res.h5: not the result of a sweep", "--force"])
        # what has come there since: neither the last shard nor --merge replaces it
        self.write("vary: {fluid.shields: [0.3, 0.6]}\n")
        self.sweep("-o", "m.h5", "--shard", "1/2")
        subprocess.run([PROGRAM, "run", "scene.yaml", "-o", "m.h5", "--quiet"], cwd=self.folder, check=True)
        before["m.h5"] = (self.folder / "m.h5").read_bytes()
        self.refuses(4, "s.yaml", "-o", "m.h5", "--merge", says=["m.h5: not the result of a sweep", "--merge --force"])
        (self.folder / "m.h5").unlink()
        self.write("vary: {fluid.shields: [0.3, 0.6]}\nset: {time.end: 2 s}\n")
        self.sweep("-o", "m2.h5", "--shard", "1/2")
        p = self.start("-o", "m2.h5", "--shard", "2/2")
        deadline = time.monotonic() + 60
        while not any((self.folder / "m2.d").glob("case-0002.*")) and time.monotonic() < deadline:
            time.sleep(0.01)
        (self.folder / "m2.h5").write_bytes(before["m.h5"])
        _, err = p.communicate(timeout=60)
        self.assertEqual(p.returncode, 4, err)
        self.assertEqual((self.folder / "m2.h5").read_bytes(), before.pop("m.h5"))
        self.sweep("-o", "m2.h5", "--merge", "--force")
        self.write("vary:\n  fluid.shields: [0.3]\n")
        before["s.yaml"] = (self.folder / "s.yaml").read_bytes()
        for command in ("tune", "threshold"):
            r = subprocess.run([PROGRAM, command, "scene.yaml", "-o", "./scene.yaml", "--force"], cwd=self.folder, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertNotEqual(r.returncode, 0, command)
        self.assertEqual({name: (self.folder / name).read_bytes() for name in before}, before)

    def test_force_removes_its_own_files_only(self):
        self.write("vary: {fluid.shields: [0.3, 0.6]}\n")
        self.sweep()
        mine = ["case-0001.png", "case-0001.txt.bak", "case-0001.h5.old", "case-0003.txt.7.part.gz", "cases.csv"]
        left = ["case-0001.txt.77.part", "case-0002.h5.part.copy", "case-0002.xdmf.part", "case-0009.h5.part.journal"]
        for name in mine + left:
            (self.folder / "s.d" / name).write_text("mine")
        self.sweep("--force")
        names = {p.name for p in (self.folder / "s.d").iterdir()}
        self.assertEqual((names.intersection(mine), names.intersection(left)), (set(mine), set()))

    def test_bad_command_lines(self):
        self.write("vary: {fluid.shields: [0.3]}\n")
        self.refuses(2, says=["which sweep file"])
        for shard in ("0/2", "3/2", "1", "1/", "a/b", "1/2x"):
            self.refuses(2, "s.yaml", "--shard", shard, says=["--shard", "I/N"])
        self.refuses(2, "s.yaml", "-j", "0", says=["1 to 1024"])
        self.refuses(2, "s.yaml", "--resume", "--force", says=["--resume", "--force"])
        self.refuses(2, "s.yaml", "-s", "fluid.shields=0.2", says=["fluid.shields", "varies this key, in line 2 of s.yaml"])
        self.refuses(2, "s.yaml", "-s", "fluid.shear_stress=1", says=["varies fluid.shields, in line 2 of s.yaml"])
        self.refuses(4, "s.yaml", "-o", "nowhere/s.h5", says=["nowhere"])
        (self.folder / "full.d").mkdir()
        (self.folder / "full.d/mine.txt").write_text("mine")
        self.refuses(4, "s.yaml", "-o", "full.h5", "--force", says=["full.d", "holds no sweep"])
        self.assertEqual([p.name for p in (self.folder / "full.d").iterdir()], ["mine.txt"])


    def test_no_permission(self):
        if os.getuid() == 0 and subprocess.run([PROGRAM, "--version"], user=65534, stdout=subprocess.DEVNULL,
                                               stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("root may write everywhere, and others can't start the program")
        other = {"user": 65534} if os.getuid() == 0 else {}

        def refused(*words, says):
            r = subprocess.run([PROGRAM, "sweep", "s.yaml", *words], cwd=self.folder, text=True, env=PLAIN,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=60, **other)
            self.assertEqual((r.returncode, r.stdout), (4, ""), r.stderr)
            self.assertIn(says, r.stderr)
            self.assertIn("Permission denied", r.stderr)
        self.write("vary: {fluid.shields: [0.3, 0.6]}\n")
        self.sweep("-q")
        self.addCleanup(self.folder.chmod, 0o755)
        self.folder.chmod(0o555)
        refused("-o", "new.h5", says="new.h5")
        (self.folder / "s.d").chmod(0o555)
        refused("--resume", says="s.h5")
        self.folder.chmod(0o777)
        refused("--resume", says="s.d: can't be written to")
        (self.folder / "scene.yaml").chmod(0)
        refused("--resume", says="s.yaml:1: scene: scene.yaml: can't be opened")
        self.assertEqual(self.table()["cases/status"].tolist(), [0, 0])
        self.assertEqual(sorted(p.name for p in (self.folder / "s.d").glob("*.h5")), ["case-0001.h5", "case-0002.h5"])
        (self.folder / "s.d").chmod(0o755)


if __name__ == "__main__":
    unittest.main()
