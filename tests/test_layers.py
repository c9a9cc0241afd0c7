#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The rules that keep the source readable, checked on the text.

Folders are layers: a file includes its own folder or one to the left in LAYERS. Beyond that: only io
knows HDF5, only analysis FFTW, only cli MPI, only cli prints and ends the program; io and analysis do not know each
other; what computes (up to stage) gets numbers, not options. The shared library shows the names marked
RY_API and no others. Functions and files have an end. No file names a place on somebody's machine.
"""
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(os.environ.get("SOURCE_DIR", Path(__file__).resolve().parent.parent))
LAYERS = {"base": 0, "law": 1, "store": 2, "config": 3, "stage": 4, "scene": 5, "io": 6, "analysis": 6,
          "sim": 7, "study": 8, "cli": 9}
PUBLIC = {"ryusa/status.h": 0, "ryusa/config.h": 3, "ryusa/config.def": 3, "ryusa/ryusa.h": 3}
NO_OPTIONS = {"base", "law", "store", "stage"}
ONLY_IN = {"hdf5.h": "io", "hdf5_hl.h": "io", "fftw3.h": "analysis", "nlopt.h": "analysis", "argp.h": "cli", "mpi.h": "cli",
           "yaml.h": "config"}
PRINTS = re.compile(r"(?<!format\()(?<!format \()\b(?:v?printf|puts|putchar|perror|_?exit|quick_exit|stdout|stderr)\b(?!\.)")
LONGEST_FUNCTION, LONGEST_FILE, LONGEST_TEST, LONGEST_LINE = 120, 600, 1000, 120

POOL = ROOT / "src/study/pool.c"

problems = []


def problem(path, line, text):
    problems.append(f"{path.relative_to(ROOT)}:{line}: {text}")


def blank(match):
    return re.sub(r"[^\n]", " ", match.group())


def without_comments(text, strings=False):
    """The text with comments (and strings) as spaces, lines where they were."""
    token = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
    return token.sub(lambda m: blank(m) if m.group()[0] == "/" or strings else m.group(), text)


def check_includes(path, text):
    folder = path.relative_to(ROOT / "src").parts[0]
    if folder not in LAYERS:
        problem(path, 1, f"folder {folder} is no layer: {', '.join(LAYERS)}")
        return
    for match in re.finditer(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', text, re.M):
        kind, name = match.groups()
        line = text.count("\n", 0, match.start()) + 1
        if name in ONLY_IN and folder != ONLY_IN[name]:
            problem(path, line, f"{name} is for {ONLY_IN[name]} only")
        if name in PUBLIC:
            if folder in NO_OPTIONS and PUBLIC[name] > 0:
                problem(path, line, f"{folder} gets numbers, not options: {name}")
            continue
        if kind == "<":
            continue
        other = name.split("/")[0]
        if "/" not in name or other not in LAYERS:
            problem(path, line, f'"{name}": includes are written "folder/file.h"')
        elif not (ROOT / "src" / name).is_file():
            problem(path, line, f'"{name}" does not exist')
        elif folder == "cli" and other not in ("cli", "study"):
            problem(path, line, f"cli knows the public headers and study only, not {name}")
        elif other != folder and LAYERS[other] >= LAYERS[folder]:
            problem(path, line, f"{folder} may not include {name}: it is to the right")


def check_printing(path, text):
    if path.relative_to(ROOT / "src").parts[0] == "cli":
        return
    for match in PRINTS.finditer(text):
        if path == POOL and match.group() == "_exit":
            continue  # the end of a child process, not of the program
        problem(path, text.count("\n", 0, match.start()) + 1, f"only cli prints and exits: {match.group()}")


def function_lengths(text):
    """(line, lines) of every function body: a brace at depth 0 that follows a ')'."""
    depth, start = 0, None
    for match in re.finditer(r"[{}]", text):
        if match.group() == "{":
            if depth == 0 and text[:match.start()].rstrip().endswith(")"):
                start = match.start()
            depth += 1
        else:
            depth -= 1
            if depth == 0 and start is not None:
                yield text.count("\n", 0, start) + 1, text.count("\n", start, match.start()) + 1
                start = None


def check_size(path, text, code, longest):
    lines = text.count("\n")
    if lines > longest:
        problem(path, longest, f"{lines} lines in a file; at most {longest}")
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LONGEST_LINE and '"' not in line:
            problem(path, number, f"{len(line)} characters in a line; at most {LONGEST_LINE}")
    flat = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, code, flags=re.M)
    lengths = list(function_lengths(flat))
    for line, length in lengths:
        if length > LONGEST_FUNCTION:
            problem(path, line, f"{length} lines in a function; at most {LONGEST_FUNCTION}")
    return [length for _, length in lengths]


def check_symbols():
    library = os.environ.get("RY_LIBRARY")
    if not library:
        return
    names = subprocess.run(["nm", "-D", "--defined-only", "--format=posix", library], check=True, text=True,
                           stdout=subprocess.PIPE).stdout
    shown = {line.split()[0] for line in names.splitlines()}
    # Only there in a build with a sanitizer.
    shown = {name for name in shown if not name.startswith(("__asan", "__odr_asan", "__tsan", "__ubsan"))}
    marked = set()
    for header in (ROOT / "include/ryusa").glob("*.h"):
        text = without_comments(header.read_text())
        marked |= set(re.findall(r"RY_API\s[^;(]*?(\w+)\s*\(", re.sub(r"^\s*#.*", "", text, flags=re.M)))
    for name in sorted(shown - marked):
        problems.append(f"{library}: shows {name}, which is not marked RY_API in include/ryusa")
    for name in sorted(marked - shown):
        problems.append(f"{library}: {name} is marked RY_API, but not there")


def tracked_files():
    try:
        listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], check=True, stderr=subprocess.DEVNULL,
                                stdout=subprocess.PIPE).stdout.decode()
        return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]
    except (OSError, subprocess.CalledProcessError):  # no git, or a tree without its history
        return [p for folder in ROOT.iterdir() if not folder.name.startswith(("build", "runs", ".git"))
                for p in (folder.rglob("*") if folder.is_dir() else [folder]) if p.is_file()]


def check_places():
    place = re.compile(r"(?<![\w.$}])/(?:home|Users|root|work|mnt|scratch|workspace)/\w")
    for path in tracked_files():
        try:
            text = path.read_text()
        except UnicodeDecodeError:
            continue
        for match in place.finditer(text):
            problem(path, text.count("\n", 0, match.start()) + 1, "a path of one machine")


def main():
    files = [p for p in sorted((ROOT / "src").rglob("*")) if p.suffix in (".c", ".h", ".def")]
    lengths = []
    for path in files:
        text = path.read_text()
        code = without_comments(text, strings=True)
        check_includes(path, without_comments(text))
        check_printing(path, code)
        lengths += check_size(path, text, code, LONGEST_FILE)
    for path in sorted((ROOT / "tests").glob("*.[ch]")):
        check_size(path, path.read_text(), without_comments(path.read_text(), strings=True), LONGEST_TEST)
    check_symbols()
    check_places()
    lengths.sort()
    if lengths:
        print(f"{len(files)} files, {len(lengths)} functions: median {lengths[len(lengths) // 2]} lines, "
              f"90 % up to {lengths[len(lengths) * 9 // 10]}, longest {lengths[-1]}")
    for text in problems:
        print(text)
    return 1 if problems else 0


sys.exit(main())
