#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# ctest: slow, timeout 3000
#
# The same bits from every build: no optimisation and no OpenMP, all instructions of this machine, another
# compiler, and a build that checks addresses and undefined behaviour while it runs. For every contact law and
# every fluid. The tests in C pass under these checks, too. And no thread touches what another has not finished.
set -eu
: "${RYUSA:?}" "${SOURCE_DIR:?}" "${BUILD_DIR:?}"
folder=$BUILD_DIR/variants
mkdir -p "$folder"

cat >"$folder/scene.yaml" <<'SCENE'
title: a small bed under a strong flow
time: {step: 20 us, end: 40 ms, settle: 5 ms}
grains: {columns: 12, layers: 5, spread: 0.1, seed: 7}
contact: {alpha_m: 150, restitution: 0.6}   # what every law allows
fluid: {shields: 0.6}
output: {interval: 20 ms}
SCENE
# The words that a key allows, as settings; from the parameter page.
choices() { # SECTION KEY
    "$RYUSA" show --parameters | awk -F'|' -v section="## $1" -v key="$2" '
        /^## / { here = $0 == section }
        here && $2 ~ "`" key "`" { n = split($5, word, ","); for (i = 1; i <= n; i++) { print word[i] } }' |
        sed "s/^ */$1.$2=/; s/ *\$//"
}
settings=$(choices contact law; choices fluid model)
[ "$(echo "$settings" | wc -l)" -ge 8 ] || { echo "the parameter page lacks the laws or fluids"; exit 1; }

# One line per setting: its name and the hash of the last state.
hashes() { # PROGRAM NAME
    for setting in $settings; do
        echo "$setting $("$1" run "$folder/scene.yaml" -s "$setting" -j 2 -o "$folder/$2.h5" --force \
            2>"$folder/$2.log" | sed -n 's/^state hash //p')"
    done
}

build() { # NAME CMAKE_OPTION...
    name=$1
    shift
    {
        cmake -S "$SOURCE_DIR" -B "$folder/$name" "$@" && cmake --build "$folder/$name" --parallel 2
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

# Beds of several blocks for each thread (stage/blocks.h), so that they have something to share. Clang's OpenMP alone
# tells the sanitizer what its barriers keep apart.
look_for_races() {
    archer=$(clang -print-resource-dir)/../../libarcher.so
    if [ ! -f "$archer" ]; then
        echo "races: left out, Debian: libomp-dev"
        return
    fi
    build threads -DRY_TESTS=OFF -DRY_MPI=OFF -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=Debug -DRY_SANITIZE=thread
    printf '%s\n' $settings 'grains.columns=4000 time.end=1ms time.settle=0' \
        'contact.sleep=2 grains.columns=60 grains.layers=10 fluid.shields=0.3 time.settle=0.2s time.end=0.25s' \
        'domain.floor=flat contact.wet=true' 'domain.periodic=false domain.walls=true' >"$folder/races"
    while read -r words; do
        options=()
        for word in grains.columns=120 time.end=10ms output.interval=5ms $words; do
            options+=(-s "$word")
        done
        if ! OMP_TOOL_LIBRARIES=$archer TSAN_OPTIONS=ignore_noninstrumented_modules=1 \
            "$folder/threads/ryusa" run "$folder/scene.yaml" "${options[@]}" -j 3 -q --force \
            -o "$folder/threads.h5" >"$folder/threads.log" 2>&1; then
            echo "races: $words"
            cat "$folder/threads.log"
            failed=1
        fi
    done <"$folder/races"
    echo "races: looked for in $(wc -l <"$folder/races") scenes"
}

hashes "$RYUSA" reference >"$folder/reference.hashes"
cat "$folder/reference.hashes"
if grep -v ' 0x[0-9a-f]\{16\}$' "$folder/reference.hashes"; then
    echo "a run without a hash"
    cat "$folder/reference.log"
    exit 1
fi

build plain -DRY_TESTS=OFF -DCMAKE_BUILD_TYPE=Debug -DRY_OPENMP=OFF -DCMAKE_C_FLAGS=-DRY_ONE_TARGET
compare plain
build native -DRY_TESTS=OFF -DRY_NATIVE=ON
compare native
build checked -DRY_TESTS=ON -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS=-O1 -DRY_SANITIZE=address
compare checked
if ! ctest --test-dir "$folder/checked" --no-tests=error --output-on-failure --parallel 2 -L '^c$' -LE slow \
    >"$folder/checked.tests" 2>&1; then
    cat "$folder/checked.tests"
    failed=1
fi
if command -v clang >/dev/null; then
    build clang -DRY_TESTS=OFF -DCMAKE_C_COMPILER=clang
    compare clang
    look_for_races
else
    echo "clang: left out, it is not installed"
fi
exit $failed
