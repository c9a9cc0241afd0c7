#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The pages agree with the program: the parameter page, links between pages, the commands in README, the laws."""
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(os.environ["SOURCE_DIR"])
PROGRAM = os.environ["RYUSA"]
problems = []

made = subprocess.run([PROGRAM, "show", "--parameters"], check=True, stdout=subprocess.PIPE, text=True).stdout
page = ROOT / "docs/parameters.md"
if not page.is_file() or page.read_text() != made:
    problems.append("docs/parameters.md is not what `ryusa show --parameters` prints: run `make docs`")

for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("params/*.md"), *ROOT.glob("runs/README.md")]:
    for target in re.findall(r"\]\(([^)#\s]+)", path.read_text()):
        if "://" not in target and not (path.parent / target).exists():
            problems.append(f"{path.relative_to(ROOT)}: link to {target}, which is not there")

readme = (ROOT / "README.md").read_text()
commands = re.findall(r"(?m)^RY_COMMAND\((\w+), ", (ROOT / "src/cli/commands.def").read_text())
for name in commands:
    if f"ryusa {name} " not in readme:
        problems.append(f"README.md does not name the command {name}")
    text = subprocess.run([PROGRAM, name, "--help"], check=True, stdout=subprocess.PIPE, text=True).stdout
    if not text.startswith(f"Usage: ryusa {name} "):
        problems.append(f"ryusa {name} --help begins with {text[:40]!r}")

for law in re.findall(r'\(RY_LAW_\w+, "([\w-]+)"\)', (ROOT / "include/ryusa/config.h").read_text()):
    if f"`{law}`" not in (ROOT / "docs/physics.md").read_text():
        problems.append(f"docs/physics.md does not say what the law {law} is")

version = subprocess.run([PROGRAM, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout.split()[1]
if f"## {version}" not in (ROOT / "CHANGELOG.md").read_text():
    problems.append(f"CHANGELOG.md has no part `## {version}`")

print(*problems, sep="\n")
sys.exit(1 if problems else 0)
