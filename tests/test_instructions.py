#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# Counts the instructions of the step loop of small scenes (valgrind's callgrind) and compares them with
# tests/instructions.csv: a scene, or one of its stages, that has grown by more than 3 % fails until the
# table says so. What has changed with good reason is noted by writing the table anew:
#
#     make instructions           or      RY_UPDATE=1 ctest -R test_instructions
#
# Times depend on the machine and on what else it does; counts on the compiler, the C library and the vector
# width only. The first two are named in the table, and other ones skip the test. Valgrind knows no AVX-512
# and shows every machine with AVX2 the same processor, so that the clones for x86-64-v3 run; where they don't,
# the test skips, too. So each scene has also been computed with other vectors than this machine's: the state has to
# be the same, bit for bit.
import csv
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(os.environ["SOURCE_DIR"])
BUILD = Path(os.environ["BUILD_DIR"])
RYUSA = os.environ["RYUSA"]
TABLE = ROOT / "tests/instructions.csv"
GROWTH = 0.03
SMALL = 0.01  # of its scene: growth of a stage by less than this is let pass
WITHIN = ["ry_sim_step", "ry_sim_sample", "ry_sim_profile"]  # reading the scene and writing files is left out
CLONE = ".arch_x86_64_v3"

# Name, scene, what is changed, steps. Reach and law are fixed, so that a change of their defaults is no growth.
COMMON = ["grains.columns=20", "grains.layers=10", "numerics.skin=0.25", "contact.restitution=0.5"]
SCENES = [  # the fluid starts when the bed lies: at first its grains fall freely
    ("settled", "bench-settled", ["output.fields=[]"], 2000),
    ("settled-50", "bench-settled", ["grains.columns=5", "output.fields=[]"], 5000),
    ("sheared", "bench-sheared", ["time.settle=0.03", "output.fields=[]"], 2500),
    ("flume", "flume", ["time.settle=0.03", "contact.law=energy", "output.fields=[flux]"], 2500),
    ("flume-measured", "flume", ["time.settle=0.03", "contact.law=energy"], 2000),
]


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def environment():
    """What the counts belong to."""
    cache = (BUILD / "CMakeCache.txt").read_text()
    entry = {m[1]: m[2] for m in re.finditer(r"^(\w+):\w+=(.*)$", cache, re.M)}
    flags = entry.get("CMAKE_C_FLAGS", "") + entry.get("RY_SANITIZE", "")
    if entry.get("CMAKE_BUILD_TYPE") != "Release" or flags or entry.get("RY_NATIVE") == "ON":
        skip("this is no plain Release build")
    version = subprocess.run([entry["CMAKE_C_COMPILER"], "--version"], capture_output=True, text=True).stdout
    compiler = version.splitlines()[0].split(" ")[0] + " " + re.search(r"(\d+\.\d+\.\d+)", version)[1]
    return f"{compiler}; {' '.join(platform.libc_ver())}; {platform.machine()}; Release"


def hash_of(result):
    text = subprocess.run([RYUSA, "info", result], capture_output=True, text=True, check=True).stdout
    return re.search(r"^state hash +(\w+)$", text, re.M)[1]


def count(case):
    """Instructions per grain-step of all that WITHIN names, and of each stage (run_<stage> of the plan)."""
    name, scene, changes, steps = case
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "counts"
        results = [f"{folder}/counted.h5", f"{folder}/native.h5"]
        callgrind = ["valgrind", "--tool=callgrind", *(f"--toggle-collect={f}" for f in WITHIN),
                     f"--callgrind-out-file={out}"]
        for result, before in zip(results, (callgrind, [])):
            run = subprocess.run(
                [*before, RYUSA, "run", str(ROOT / f"params/{scene}.yaml"), "-o", result, "-j1", "--quiet",
                 *(word for c in [*COMMON, *changes, f"time.end={steps * 2e-5!r}"] for word in ("-s", c))],
                env={**os.environ, "OMP_WAIT_POLICY": "passive"},  # without it ryusa sets it and starts anew
                capture_output=True, text=True)
            if run.returncode != 0:
                sys.exit(f"{name}: status {run.returncode}\n{run.stderr[-2000:]}")
        if hash_of(results[0]) != hash_of(results[1]):
            sys.exit(f"{name}: another state with the processor that valgrind shows than with this one")
        if CLONE not in out.read_text():
            skip("this processor has no AVX2, or the build has one target only")
        text = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", str(out)],
                              capture_output=True, text=True, check=True).stdout
    rows = re.findall(r"^\s*([\d,]+) \([^)]*\)\s+\S*?:([\w.']+)", text, re.M)
    inclusive = {}
    for number, function in rows:
        inclusive.setdefault(function, int(number.replace(",", "")))
    grains = next(float(c.split("=")[1]) for c in [*changes[::-1], *COMMON] if c.startswith("grains.columns")) * 10
    per = 1.0 / (grains * steps)
    counts = {"all": sum(inclusive.get(f, 0) for f in WITHIN) * per,
              "measure": sum(inclusive.get(f, 0) for f in WITHIN[1:]) * per}
    for function, number in inclusive.items():
        if function.startswith("run_"):
            counts[function[4:]] = number * per
    return {(name, stage): value for stage, value in counts.items()}


def read_table():
    with open(TABLE) as file:
        head = file.readline().lstrip("# ").strip()
        return head, {(r["scene"], r["stage"]): float(r["instructions"]) for r in csv.DictReader(file)}


def write_table(where, counts):
    with open(TABLE, "w") as file:
        file.write(f"# {where}\nscene,stage,instructions\n")
        for (scene, stage), value in counts.items():
            file.write(f"{scene},{stage},{value:.2f}\n")
    print(f"wrote {TABLE}")


def grown(table, counts):
    """What to complain about."""
    said = []
    for key, value in counts.items():
        scene, stage = key
        before = table.get(key, 0.0)
        whole = table.get((scene, "all"), 0.0)
        rise = value - before
        if rise > GROWTH * before and (stage == "all" or rise > SMALL * whole):
            said.append(f"{scene}, {stage}: {value:.1f} instructions per grain-step, the table has {before:.1f}")
    return said


def check_itself():
    table = {("s", "all"): 100.0, ("s", "contact"): 50.0}
    assert grown(table, table) == []
    assert len(grown(table, {("s", "all"): 103.1})) == 1
    assert len(grown(table, {("s", "contact"): 52.0, ("s", "new"): 5.0})) == 2


def main():
    check_itself()
    where = environment()
    if not (shutil.which("valgrind") and shutil.which("callgrind_annotate")):
        skip("no valgrind (Debian: valgrind)")
    update = bool(os.environ.get("RY_UPDATE"))
    head, table = read_table() if TABLE.is_file() else ("", {})
    if where != head and not update:
        skip(f"the table is for {head}, this is {where}")
    counts = {}
    with ThreadPoolExecutor(2) as pool:
        for part in pool.map(count, SCENES):
            counts |= part
    print(f"{'scene':16s} {'stage':12s} {'now':>9s} {'table':>9s}   instructions per grain-step")
    for (scene, stage), value in counts.items():
        print(f"{scene:16s} {stage:12s} {value:9.1f} {table.get((scene, stage), float('nan')):9.1f}")
    if update:
        write_table(where, counts)
        return
    said = grown(table, counts)
    print("\n".join(said))
    if said:
        sys.exit("more instructions than noted; if it must be so: make instructions")


if __name__ == "__main__":
    main()
