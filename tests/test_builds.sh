#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# ctest: slow, timeout 900
#
# The same bits from every build: no optimisation and no OpenMP, all instructions of this machine, another
# compiler, and a build that checks addresses and undefined behaviour while it runs. For every contact law.
set -eu
: "${RYUSA:?}" "${SOURCE_DIR:?}" "${BUILD_DIR:?}"
folder=$BUILD_DIR/variants
mkdir -p "$folder"

cat >"$folder/scene.yaml" <<'SCENE'
title: a small bed under a strong flow
time: {step: 20 us, end: 40 ms, settle: 5 ms}
grains: {columns: 12, layers: 5, spread: 0.1, seed: 7}
fluid: {shields: 0.6}
output: {interval: 20 ms}
SCENE
laws=$("$RYUSA" show --parameters | awk -F'|' '$2 ~ /`law`/ { gsub(",", "", $5); print $5 }')
[ -n "$laws" ] || { echo "no laws in the parameter page"; exit 1; }

# One line per law: its name and the hash of the last state.
hashes() { # PROGRAM NAME
    for law in $laws; do
        echo "$law $("$1" run "$folder/scene.yaml" -s "contact.law=$law" -j 2 -o "$folder/$2.h5" --force \
            2>"$folder/$2.log" | sed -n 's/^state hash //p')"
    done
}

build() { # NAME CMAKE_OPTION...
    name=$1
    shift
    {
        cmake -S "$SOURCE_DIR" -B "$folder/$name" -DRY_TESTS=OFF "$@" &&
            cmake --build "$folder/$name" --parallel 2 --target ryusa_program
    } >"$folder/$name.build" 2>&1 || { tail -n 30 "$folder/$name.build"; echo "$name does not build"; exit 1; }
}

failed=0
compare() { # NAME
    hashes "$folder/$1/ryusa" "$1" >"$folder/$1.hashes"
    if diff "$folder/reference.hashes" "$folder/$1.hashes" >"$folder/$1.diff"; then
        echo "$1: the same bits"
    else
        echo "$1: other bits (< reference, > $1)"
        cat "$folder/$1.diff" "$folder/$1.log"
        failed=1
    fi
}

hashes "$RYUSA" reference >"$folder/reference.hashes"
cat "$folder/reference.hashes"
if grep -v ' 0x[0-9a-f]\{16\}$' "$folder/reference.hashes"; then
    echo "a run without a hash"
    cat "$folder/reference.log"
    exit 1
fi

build plain -DCMAKE_BUILD_TYPE=Debug -DRY_OPENMP=OFF -DCMAKE_C_FLAGS=-DRY_ONE_TARGET
compare plain
build native -DRY_NATIVE=ON
compare native
build checked -DCMAKE_BUILD_TYPE=Debug -DRY_SANITIZE=address
compare checked
if command -v clang >/dev/null; then
    build clang -DCMAKE_C_COMPILER=clang
    compare clang
else
    echo "clang: left out, it is not installed"
fi
exit $failed
