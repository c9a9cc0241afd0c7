#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""params/sweep.slurm on a real Slurm: a cluster of one node, with all that it has in a temporary folder and
on free ports of the loopback; nothing of an installed Slurm is touched, and no daemon stays behind. An array
of two tasks; one is asked to stop, one is requeued by force: both go on, to the table of a plain sweep. One
that is cancelled stays so.
ctest: serial"""
import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path


def skip(reason):
    print(f"skipped: {reason}", flush=True)
    raise SystemExit(77)


try:
    import h5py
    import numpy as np
except ImportError as missing:
    skip(f"{missing}; Debian: apt install python3-h5py")

PROGRAM, SOURCE = os.environ["RYUSA"], Path(os.environ["SOURCE_DIR"])
NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "scancel", "scontrol", "squeue", "srun")
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"
TOOL = {name: shutil.which(name, path=PATH) for name in NEEDED}
if None in TOOL.values():
    skip("no " + ", ".join(k for k, v in TOOL.items() if v is None)
         + "; Debian: apt install slurmctld slurmd slurm-client munge")

PLAIN = {key: value for key, value in os.environ.items() if not key.startswith(("SLURM_", "OMPI_", "PMI"))}
# Without cgroups: they are the machine's, not the test's.
CONFIGURATION = """\
ClusterName=ryusa
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/builtin
SelectType=select/cons_res
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
SlurmdParameters=config_overrides
ReturnToService=2
JobRequeue=1
KillWait=30
NodeName=node NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=2 RealMemory=500
PartitionName=all Nodes=node Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(n):
    sockets = [socket.socket() for _ in range(n)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Cluster:
    """A Slurm of one node in `folder`."""

    def __init__(self, folder):
        self.folder, self.daemons = folder, []
        for name in ("munge", "state", "spool"):
            (folder / name).mkdir(mode=0o711)
        key = folder / "munge/key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.file = folder / "slurm.conf"
        import pwd
        self.file.write_text(CONFIGURATION.format(folder=folder, host=socket.gethostname().split(".")[0],
                                                  ports=free_ports(2), user=pwd.getpwuid(os.getuid()).pw_name))
        self.environment = {**PLAIN, "SLURM_CONF": str(self.file), "PATH": PATH}

    def start(self, name, *words):
        log = open(self.folder / f"{name}.log", "w")
        self.daemons.append(subprocess.Popen([TOOL[name], *words], stdout=log, stderr=subprocess.STDOUT, cwd=self.folder,
                                             stdin=subprocess.DEVNULL, env=self.environment, preexec_fn=die_with_parent))
        log.close()

    def run(self, name, *words, **options):
        return subprocess.run([TOOL[name], *words], env=self.environment, text=True, timeout=60, cwd=self.folder,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    def tell_all(self, *words):
        r = self.run(*words)
        return r.stdout + r.stderr

    def is_up(self):
        r = self.run("scontrol", "show", "node", "node")
        return r.returncode == 0 and "State=IDLE" in r.stdout

    def up(self):
        """None, or why it does not start."""
        munge = self.folder / "munge"
        self.start("munged", "-F", "--force", f"--socket={munge}/socket", f"--key-file={munge}/key",
                   f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed", "--num-threads=1")
        deadline = time.monotonic() + 10
        while not (munge / "socket").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        self.start("slurmctld", "-D", "-c")
        self.start("slurmd", "-D", "-N", "node")
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            for daemon in self.daemons:
                if daemon.poll() is not None:
                    return f"{Path(daemon.args[0]).name} ended at once: {self.last_words(Path(daemon.args[0]).name)}"
            if self.is_up():
                return None
            time.sleep(0.2)
        return f"the node does not come up: {self.last_words('slurmctld')} / {self.last_words('slurmd')}"

    def last_words(self, name):
        return " | ".join((self.folder / f"{name}.log").read_text(errors="replace").splitlines()[-3:])

    def ours(self):
        """Every process that was started with our configuration: daemons, steps, jobs."""
        mark = f"SLURM_CONF={self.file}".encode()
        for entry in Path("/proc").glob("[0-9]*/environ"):
            try:
                if mark in entry.read_bytes().split(b"\0"):
                    yield int(entry.parent.name)
            except OSError:
                pass

    def down(self):
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        for pid in self.ours():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass


GOING = ("PENDING", "CONFIGURING", "RUNNING", "COMPLETING", "REQUEUED", None)  # None: no answer


class Array(unittest.TestCase):
    def setUp(self):
        self.folder = FOLDER / "work"
        self.folder.mkdir()
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "scene.yaml").write_text(
            "time: {step: 20 us, end: 60 s, settle: 2 ms}\ngrains: {columns: 6, layers: 3, seed: 3}\n"
            "output: {interval: 2 ms, checkpoint: 0.1 s, fields: [flux]}\n")
        (self.folder / "s.yaml").write_text("scene: scene.yaml\nvary: {fluid.shields: [0.3, 0.5, 0.7, 0.9]}\n")

    def tell(self, *words):
        r = CLUSTER.run(*words)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        return r.stdout

    def wait_for(self, what, condition, seconds=90):
        deadline = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), deadline, f"{what}\n{CLUSTER.run('squeue').stdout}{self.logs()}")
            time.sleep(0.1)

    def logs(self):
        return "".join(f"--- {p.name}\n{p.read_text()}" for p in sorted(self.folder.glob("*.log")))

    def state(self, task):
        """What Slurm says of a task: {"JobState": ...}; empty when it has forgotten it."""
        r = CLUSTER.run("scontrol", "--oneliner", "show", "job", task)
        return dict(word.split("=", 1) for word in r.stdout.split() if "=" in word) if r.returncode == 0 else {}

    def simulated(self, case):
        r = subprocess.run([PROGRAM, "info", f"s.d/{case}.h5.part"], cwd=self.folder, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        line = [text for text in r.stdout.splitlines() if text.startswith("simulated")]
        return float(line[0].split()[1]) if line and "no checkpoint" not in line[0] else 0.0

    def mark(self, case):
        """Begun anew, the file would lose it."""
        with h5py.File(self.folder / f"s.d/{case}.h5.part", "a") as file:
            file.attrs["seen"] = 1

    def runs(self, task):
        """A process of the task is left; Slurm may call it pending before that."""
        mark = f"SLURM_ARRAY_TASK_ID={task.split('_')[1]}".encode()
        for pid in CLUSTER.ours():
            try:
                if mark in Path(f"/proc/{pid}/environ").read_bytes().split(b"\0"):
                    return True
            except OSError:
                pass
        return False

    def requeued(self, task, case):
        self.wait_for(f"{task} in the queue again", lambda: self.state(task).get("JobState") == "PENDING")
        self.wait_for(f"{task} to have saved", lambda: not self.runs(task))
        self.assertEqual(self.state(task)["Restarts"], "1")
        self.assertGreater(self.simulated(case), 0.0)
        self.mark(case)

    def table(self, name):
        with h5py.File(self.folder / name) as file:
            return {f"{g}/{k}": v[()] for g in ("cases", "inputs", "points") for k, v in file[g].items()}

    def assert_like_plain(self):
        ours, plain = self.table("s.h5"), self.table("plain.h5")
        for key in plain.keys() - {"cases/wall_seconds", "cases/file"}:
            np.testing.assert_array_equal(ours[key], plain[key], key)

    def begin(self):
        """The array, when its first cases are half done."""
        out = self.tell("sbatch", "--parsable", "--array=1-2", "--cpus-per-task=1", f"--chdir={self.folder}",
                        f"--export=ALL,RYUSA={PROGRAM}", str(SOURCE / "params/sweep.slurm"), "s.yaml", "s.h5")
        job = out.strip().split(";")[0]
        tasks = {"case-0001": f"{job}_1", "case-0002": f"{job}_2"}
        for case, task in tasks.items():
            self.wait_for(f"{task} to run", lambda: self.state(task).get("JobState") == "RUNNING")
            self.wait_for(f"{case} half done", lambda: self.simulated(case) > 0.0)
        return tasks

    def test_array(self):
        subprocess.run([PROGRAM, "sweep", "s.yaml", "-q", "-o", "plain.h5"], cwd=self.folder, check=True, env=PLAIN)
        tasks = self.begin()
        # Slurm's warning (--signal=B:TERM@120) comes to the shell of the job; a preemption to all it runs.
        self.tell("scancel", "--batch", "--signal=TERM", tasks["case-0001"])
        self.requeued(tasks["case-0001"], "case-0001")
        self.tell("scontrol", "requeue", tasks["case-0002"])
        self.requeued(tasks["case-0002"], "case-0002")
        self.assertFalse((self.folder / "s.h5").exists())
        time.sleep(2)  # slurmd refuses what is begun in the second in which it was requeued: exit code 1
        for task in tasks.values():  # now, not in two minutes
            self.tell("scontrol", "update", f"JobId={task}", "StartTime=now")
        for task in tasks.values():
            self.wait_for(f"{task} to end", lambda: self.state(task).get("JobState") not in GOING)
            self.assertEqual(self.state(task).get("JobState"), "COMPLETED", f"{self.state(task)}\n{self.logs()}")
        self.wait_for("the table", (self.folder / "s.h5").exists)
        for case in tasks:
            with h5py.File(self.folder / f"s.d/{case}.h5") as file:
                self.assertEqual(file.attrs["seen"], 1, f"{case} was begun anew")
        self.assert_like_plain()

    def test_cancel(self):
        tasks = self.begin()
        self.tell("scancel", *tasks.values())
        for case, task in tasks.items():
            self.wait_for(f"{task} to end", lambda: self.state(task).get("JobState") not in GOING and not self.runs(task))
            self.assertEqual(self.state(task)["JobState"], "CANCELLED", f"{self.state(task)}\n{self.logs()}")
            self.assertGreater(self.simulated(case), 0.0)
        self.assertEqual(self.logs().count(", saved; --resume goes on"), 2, self.logs())

    def test_srun(self):
        """srun starts the processes of one farm, which speak MPI."""
        about = subprocess.run([PROGRAM, "sweep", "--help"], text=True, stdout=subprocess.PIPE).stdout
        if "built with MPI" not in " ".join(about.split()):
            self.skipTest("ryusa was built without MPI")
        if "pmix" not in CLUSTER.tell_all("srun", "--mpi=list"):
            self.skipTest("this Slurm has no PMIx")
        words = [PROGRAM, "sweep", "s.yaml", "-s", "time.end=20 s"]
        subprocess.run([*words, "-q", "-o", "plain.h5"], cwd=self.folder, check=True, env=PLAIN)
        r = CLUSTER.run("srun", "--mpi=pmix", "-n", "2", f"--chdir={self.folder}", *words)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        self.assertEqual(r.stdout.count("4 of 4 done"), 1, r.stdout)
        self.assertIn("2 running", r.stderr)
        self.assert_like_plain()


if __name__ == "__main__":
    def stop(number, frame):  # the daemons must go, whatever ends the test
        sys.exit(128 + number)
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, stop)
    with tempfile.TemporaryDirectory() as name:
        FOLDER = Path(name)
        CLUSTER = Cluster(FOLDER)
        try:
            reason = CLUSTER.up()
            if reason is not None:
                skip(f"Slurm does not start here: {reason}")
            unittest.main()
        finally:
            CLUSTER.down()
