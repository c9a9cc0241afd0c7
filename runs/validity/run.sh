#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# The validity study: five sweeps, one picture for each grain and one for all, and the tables of docs/validity.md.
# Goes on where it was stopped.     run.sh [PROGRAM]      `make validity` calls it
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
program=${1:-$root/build/ryusa}
python=/usr/bin/python3
[ -x "$python" ] || python=python3
out=$here/results
mkdir -p "$out"
begun=$(date +%s)
for sweep in convergence sand-0.5mm beads-2mm beads-6mm other-packings; do
    if [ ! -e "$out/$sweep.h5" ]; then
        echo "$sweep"
        nice -n 10 "$program" sweep "$here/$sweep.yaml" -o "$out/$sweep.h5" --resume
    fi
done
"$python" -B "$root/postprocess/validity.py" "$out" | tee "$out/tables.md"
echo "took $((($(date +%s) - begun) / 60)) minutes (what had been done before not counted)"
