#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# What is installed can be used: a program is built on it by pkg-config, by find_package and as C++, also
# after the tree was moved; all give the same bits.
set -eu
: "${SOURCE_DIR:?}" "${BUILD_DIR:?}"
if grep -q '^RY_SANITIZE:STRING=.' "$BUILD_DIR/CMakeCache.txt"; then
    echo "skipped: a library with a sanitizer wants programs with the same"
    exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
consumer=$SOURCE_DIR/tests/consumer

cmake --build "$BUILD_DIR" --target ryusa ryusa_program >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
cmake --install "$BUILD_DIR" --prefix "$folder/first" >/dev/null
mv "$folder/first" "$folder/tree"
tree=$folder/tree

"$tree/bin/ryusa" --version
config=$(find "$tree" -name ryusaConfig.cmake)
[ -f "$config" ] && [ -f "${config%Config.cmake}ConfigVersion.cmake" ] && [ -f "${config%Config.cmake}Targets.cmake" ]
pc=$(dirname "$(find "$tree" -name ryusa.pc)")
lib=$(dirname "$(find "$tree" -name libryusa.so)")
export LD_LIBRARY_PATH=$lib

# shellcheck disable=SC2046  # flags are words
cc -std=c17 -Wall -Wextra -Wpedantic -Werror -o "$folder/by_pkg_config" "$consumer/main.c" \
    $(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs ryusa)
[ "$(PKG_CONFIG_PATH=$pc pkg-config --modversion ryusa)" = "$("$tree/bin/ryusa" --version | cut -d' ' -f2)" ]
"$folder/by_pkg_config" | tee "$folder/one"

if ! { cmake -S "$consumer" -B "$folder/build" -DCMAKE_PREFIX_PATH="$tree" && cmake --build "$folder/build"; } \
    >"$folder/log" 2>&1; then
    cat "$folder/log"
    exit 1
fi
"$folder/build/consumer" | tee "$folder/two"
cmp "$folder/one" "$folder/two"

if command -v c++ >/dev/null; then
    # shellcheck disable=SC2046
    c++ -std=c++17 -Wall -Wextra -Werror -x c++ -o "$folder/as_cpp" "$consumer/main.c" \
        $(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs ryusa)
    "$folder/as_cpp" | cmp - "$folder/one"
else
    echo "C++: left out, there is no compiler"
fi
