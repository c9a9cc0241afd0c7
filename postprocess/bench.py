#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Draws what `ryusa bench`, tests/peers/peers.py or jobs.py measured."""
import csv
from pathlib import Path

from ryusa_result import ResultError, parser, run

import h5py
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation
from picture import AMBER, BLACK, BLUE, GREEN, GREY, ORANGE, PINK, SKY, plt, save

# In the order of the pictures; a law that is not here comes last.
LAW_STYLE = {
    "energy": (BLUE, "o", "-"), "fujioka-2": (GREEN, "s", "-"), "fujioka-2-printed": (GREEN, "s", ":"),
    "fujioka-1": (PINK, "^", "-"), "cundall": (ORANGE, "v", "-"), "cundall-tension": (ORANGE, "v", ":"),
    "tanaka": (AMBER, "D", "-"),
}
OTHER_STYLE = (BLACK, "x", "-")
# Refused is blank; from quiet (light blue) over jitter and leaks to gains (orange) and explosions (black).
CLASS_COLOR = {
    "refused": "#FFFFFF", "quiet": "#D6E9F5", "settles": SKY, "jitters": "#F3E3A0", "leaks": GREEN,
    "gains": ORANGE, "pressed through": "#B9A6B5", "explodes": BLACK,
}


def text_of(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def texts(dataset):
    return [text_of(v) for v in dataset[:]]


def laws_of(group):
    order = list(LAW_STYLE)
    there = [name for name, one in group.items() if isinstance(one, h5py.Group)]
    return sorted(there, key=lambda law: order.index(law) if law in order else len(order))


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
    laws = laws_of(file[maps[0]])
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


PROBLEMS = ["binary", "sliding", "sticking", "three-spheres", "settling", "flux"]
ROUNDING = 1e-16  # where errors of 0 are drawn
APART = 4.0 / 72.0  # inches between the laws where all of them take the same steps


def label_few(axis):
    """Of an axis that spans little: labels that have room, where matplotlib puts one at each of 3, 4, 5, ... x 10^n."""
    low, high = axis.get_view_interval()
    if high < 20.0 * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)) if high > 4.0 * low else MaxNLocator(3))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def draw_curves(axes, group, work, label, unit=1.0):
    """Error over steps or run time, in `unit`; laws with error bars stand beside each other over equal steps."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    laws = laws_of(group)
    for place, law in enumerate(laws):
        color, marker, line = LAW_STYLE.get(law, OTHER_STYLE)
        curve = group[law]
        error = np.maximum(curve["error"][:], ROUNDING)
        if not len(error):
            continue
        x, bar = curve[work][:] / unit, curve["error_bar"][:]
        barred = (bar > 0.0).any()
        drawn = axes.plot(x, error, line, color=color, marker=marker, markersize=3, label=law, linewidth=1)
        if barred:
            _, caps, bars = axes.errorbar(x, error, bar, fmt="none", color=color, linewidth=0.7, capsize=2)
            drawn += [*caps, *bars]
        if barred and work == "steps":
            shift = ScaledTranslation(APART * (place - len(laws) // 2), 0.0, axes.figure.dpi_scale_trans)
            for artist in drawn:
                artist.set_transform(axes.transData + shift)
    label_few(axes.xaxis)
    axes.set_xlabel(label)
    axes.set_title(group.name.strip("/"))
    axes.set_ylabel(text_of(group.attrs["error"]).split(",")[0], fontsize=7)


def accuracy(file, path):
    """Above: error against steps; below: against run time. Left on a curve are large time steps."""
    problems = [p for p in PROBLEMS if p in file]
    figure, axes = plt.subplots(2, len(problems), squeeze=False, layout="constrained",
                                figsize=(2.7 * len(problems), 6.2))
    for column, name in zip(axes.T, problems):
        draw_curves(column[0], file[name], "steps", "steps")
        draw_curves(column[1], file[name], "seconds", "wall time, one thread (ms)", 1e-3)
    drawn = {}  # a law may have no point in some panels
    for one in axes.flat:
        handles, labels = one.get_legend_handles_labels()
        drawn.update(zip(labels, handles))
    laws = [law for law in laws_of(file[problems[0]]) if law in drawn]
    figure.legend([drawn[law] for law in laws], laws, loc="upper center", ncol=len(laws))
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.95))
    return save(figure, path)


def scale_rates(axes):
    """Rates differ by less than a decade: 1, 2 and 5 of each are labelled."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def speed(file, path):
    runs = {k: v[:] if k not in ("scene", "law") else np.array(texts(v)) for k, v in file["runs"].items()}
    figure, axes = plt.subplots(1, 2, sharey=True, layout="constrained", figsize=(8.4, 3.2))
    for place, scene in zip(axes, ("settled", "sheared")):
        for law in ("cundall", "energy"):
            for threads, line in ((1, "-"), (2, "--")):
                which = (runs["scene"] == scene) & (runs["law"] == law) & (runs["threads"] == threads)
                if not which.any():  # bench speed -l LAW
                    continue
                color, marker, _ = LAW_STYLE[law]
                place.plot(runs["grains"][which], runs["rate"][which] * 1e-6, line, color=color, marker=marker,
                           markersize=3, label=f"{law}, {threads} thread{'s' * (threads > 1)}")
                if "arithmetic" in runs and threads == 1:
                    limit = 1e3 / np.maximum(runs["arithmetic"], runs["moving"])[which]
                    place.plot(runs["grains"][which], limit, ":", color=color, linewidth=0.8, label=f"{law}, limit")
        scale_rates(place)
        place.set_xlabel("grains")
        place.set_title(scene)
    axes[0].set_ylabel("million grain-steps per second")
    axes[1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    machine = file["machine"].attrs
    figure.suptitle(f"{text_of(machine['processor'])}, {machine['cores']:g} cores, {text_of(machine['compiler'])}",
                    fontsize=7)
    return save(figure, path)


PROGRAM_STYLE = {"ryusa": (BLUE, "o"), "ryusa measuring": (SKY, "o"), "LAMMPS": (ORANGE, "v"),
                 "LAMMPS top": (AMBER, "^"), "LIGGGHTS": (GREEN, "s"), "YADE": (PINK, "D")}


def table(path, picture):
    """Of tests/peers."""
    with open(path) as file:
        machine = file.readline().lstrip("# ").strip()
        rows = list(csv.DictReader(file))
    if not rows or "program" not in rows[0]:
        raise ResultError(f"{path}: not a table of tests/peers")
    return (jobs if "job" in rows[0] else peers)(rows, machine, picture)


def jobs(rows, machine, picture):
    """Wall and processor time of whole jobs: a row of bars for each, a column per number of cores."""
    all_cores = sorted({int(r["cores"]) for r in rows})
    tallest = max(sum(int(r["cores"]) == cores for r in rows) for cores in all_cores)
    figure, axes = plt.subplots(1, len(all_cores), sharex=True, squeeze=False, layout="constrained",
                                figsize=(1.0 + 4.5 * len(all_cores), 1.2 + 0.3 * tallest))
    for place, cores in zip(axes[0], all_cores):
        chosen = [r for r in rows if int(r["cores"]) == cores]
        y = np.arange(len(chosen))
        color = [BLUE if r["program"].startswith("ryusa") else ORANGE for r in chosen]
        place.barh(y, [float(r["wall"]) for r in chosen], 0.7, color=color)
        place.plot([float(r["cpu"]) for r in chosen], y, "|", color=BLACK, markersize=9, label="processor time")
        place.set_yticks(y, [f"{r['job']}: {r['program']}, T/{r['parts']}" for r in chosen], fontsize=6)
        place.invert_yaxis()
        place.set_xscale("log")
        place.set_xlabel("wall time of the whole job (s)")
        place.set_title(f"{cores} core{'s' * (cores > 1)}")
    axes[0, 0].legend(fontsize=6)
    figure.suptitle(machine, fontsize=5)
    return save(figure, picture)


def peers(rows, machine, picture):
    """Rates of all programs over the number of grains: a column per scene, a row per number of cores."""
    all_cores = sorted({int(r["cores"]) for r in rows})
    figure, axes = plt.subplots(len(all_cores), 2, sharex=True, sharey=True, squeeze=False, layout="constrained",
                                figsize=(7.0, 0.6 + 2.7 * len(all_cores)))
    for line, cores in zip(axes, all_cores):
        for place, scene in zip(line, ("settled", "sheared")):
            for program, (color, marker) in PROGRAM_STYLE.items():
                points = sorted((int(r["grains"]), float(r["best"]), float(r["median"])) for r in rows if
                                (r["scene"], r["program"], int(r["cores"])) == (scene, program, cores))
                if points:
                    n, best, median = zip(*points)
                    place.plot(n, np.array(best) * 1e-6, color=color, marker=marker, markersize=3, label=program)
                    place.plot(n, np.array(median) * 1e-6, ":", color=color, linewidth=0.8)
            scale_rates(place)
            place.set_title(f"{scene}, {cores} core{'s' * (cores > 1)}")
        line[0].set_ylabel("million grain-steps per second")
    for place in axes[-1]:
        place.set_xlabel("grains that can move (dotted: median)")
    axes[0, 1].legend(fontsize=6)
    figure.suptitle(machine, fontsize=5)
    return save(figure, picture)


DRAW = {"accuracy": accuracy, "stability": stability, "speed": speed}


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", type=Path, help="FILE.h5 of ryusa bench, or FILE.csv of tests/peers")
    arguments.add_argument("picture", nargs="?", help="picture to write (default: FILE.png)")
    given = arguments.parse_args()
    picture = given.picture or given.file.with_suffix(".png")
    if given.file.suffix == ".csv":
        print(table(given.file, picture))
        return
    with h5py.File(given.file) as file:
        draw = DRAW.get(text_of(file.attrs.get("bench", "")))
        if draw is None:
            raise ResultError(f"{given.file}: not a file of ryusa bench")
        print(draw(file, picture))


if __name__ == "__main__":
    run(main)
