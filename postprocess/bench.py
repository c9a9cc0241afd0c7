#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Draws what `ryusa bench` measured: bench.py FILE.h5 [PICTURE.png]"""
import sys
from pathlib import Path

import h5py
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from picture import AMBER, BLACK, BLUE, GREEN, GREY, ORANGE, PINK, SKY, plt, save

LAWS = ["energy", "fujioka-2", "fujioka-2-printed", "fujioka-1", "cundall", "cundall-tension", "tanaka"]
LAW_STYLE = {
    "energy": (BLUE, "o", "-"), "fujioka-2": (GREEN, "s", "-"), "fujioka-2-printed": (GREEN, "s", ":"),
    "fujioka-1": (PINK, "^", "-"), "cundall": (ORANGE, "v", "-"), "cundall-tension": (ORANGE, "v", ":"),
    "tanaka": (AMBER, "D", "-"),
}
# Refused is blank; from quiet (light blue) over jitter and leaks to gains (orange) and explosions (black).
CLASS_COLOR = {
    "refused": "#FFFFFF", "quiet": "#D6E9F5", "settles": SKY, "jitters": "#F3E3A0", "leaks": GREEN,
    "gains": ORANGE, "pressed through": "#B9A6B5", "explodes": BLACK,
}


def text_of(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def texts(dataset):
    return [text_of(v) for v in dataset[:]]


def draw_map(axes, group, law, words):
    x, y = group["x"], group["y"]
    index = group[law]["class"][:].reshape(len(y), len(x))
    colors = ListedColormap([CLASS_COLOR[w] for w in words])
    axes.imshow(index, origin="lower", aspect="auto", interpolation="nearest", cmap=colors,
                norm=BoundaryNorm(np.arange(len(words) + 1) - 0.5, len(words)))
    axes.set_xticks(range(len(x)), [f"{v:.4g}" for v in x[:]], rotation=90, fontsize=5.5)
    axes.set_yticks(range(len(y)), [f"{v:.3g}" for v in y[:]], fontsize=5.5)
    axes.set_title(law, fontsize=8)
    units = {a: text_of(group[a].attrs.get("unit", "1")) for a in "xy"}
    for a, name in (("x", axes.set_xlabel), ("y", axes.set_ylabel)):
        label = text_of(group[a].attrs["description"])
        name(label if units[a] == "1" else f"{label} ({units[a]})", fontsize=7)


def stability(file, path):
    words = texts(file["class/word"])
    maps = [m for m in ("alpha_cn", "beta", "impact", "sizes") if m in file]
    laws = [law for law in LAWS if law in file[maps[0]]]
    figure, axes = plt.subplots(len(maps), len(laws), squeeze=False, layout="constrained",
                                figsize=(2.0 + 2.1 * len(laws), 0.8 + 2.3 * len(maps)))
    for row, name in zip(axes, maps):
        for place, law in zip(row, laws):
            draw_map(place, file[name], law, words)
        for place in row[1:]:
            place.set_ylabel("")
    figure.legend(handles=[Patch(facecolor=CLASS_COLOR[w], edgecolor=GREY, label=w) for w in words],
                  loc="upper center", ncol=4 if len(laws) < 4 else len(words))
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.96))
    return save(figure, path)


def main(words):
    if not 1 <= len(words) <= 2:
        sys.exit("usage: bench.py FILE.h5 [PICTURE.png]")
    path = Path(words[0])
    try:
        with h5py.File(path) as file:
            bench = text_of(file.attrs.get("bench", ""))
            draw = DRAW.get(bench)
            if draw is None:
                sys.exit(f"bench.py: {path}: not a file of ryusa bench")
            print(draw(file, words[1] if len(words) > 1 else path.with_suffix(".png")))
    except OSError as error:
        sys.exit(f"bench.py: {path}: {error}")


DRAW = {"stability": stability}

if __name__ == "__main__":
    main(sys.argv[1:])
