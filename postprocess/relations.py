#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Flux against Shields number: one or more results among the bed-load relations of the literature.

The curves are in relations.csv, which is made from the formulas in src/analysis/relations.c. The
relations hold for three dimensions; q* counts sphere volumes over a slab one mean diameter wide."""
import csv
import sys
from pathlib import Path

import numpy as np
from ryusa_result import Result, ResultError, output_path, parser, run, with_error

MOST_NAMED = 8  # results in the legend
CURVES = Path(__file__).resolve().with_name("relations.csv")
CLASSIC = ["meyer-peter-muller", "wong-parker", "ashida-michiue", "engelund-fredsoe", "fernandez-luque-van-beek",
           "einstein"]


def read_curves():
    """key -> (label, theta, q*)."""
    with open(CURVES, encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    theta = np.array(rows[0][4:], float)
    names = {}
    for key, author, year, *_ in rows[1:]:
        name = f"{author} {year}"
        names[key] = f"{name} ({key})" if name in names.values() else name  # they have two
    return {row[0]: (names[row[0]], theta, np.array(row[4:], float)) for row in rows[1:]}


def read_points(path):
    """Columns theta and q_star of a table with a header."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        points = np.array([(float(row["theta"]), float(row["q_star"])) for row in rows])
    except (KeyError, TypeError, ValueError):
        raise ResultError(f"{path}: needs columns theta and q_star with numbers") from None
    if not len(points):
        raise ResultError(f"{path}: no rows")
    return points


def draw_curves(axes, keys, picture):
    curves = read_curves()
    colors = [picture.BLACK, picture.GREEN, picture.BLUE, picture.PINK, picture.AMBER, picture.SKY, picture.GREY]
    styles = ["-", "--", "-.", (0, (5, 1, 1, 1, 1, 1)), ":"]
    for k, key in enumerate(keys):
        label, theta, q = curves[key]
        line = np.where(q > 0.0, q, np.nan)
        axes.plot(theta, line, color=colors[k % len(colors)], ls=styles[(k + k // len(colors)) % len(styles)], lw=1.1,
                  label=label)


def name_results(results):
    """As short as tells them apart; one name for all where there are too many for a legend."""
    if len(results) > MOST_NAMED:
        return [f"{len(results)} results"] + [None] * (len(results) - 1)
    stems = [result.stem for result in results]
    return [stem if stems.count(stem) == 1 else f"{Path(result.path).parent.name}/{stem}"
            for stem, result in zip(stems, results)]


def draw_results(axes, results, floor, picture):
    markers, names = "osD^v<>pP*" if len(results) <= MOST_NAMED else "o", name_results(results)
    for k, result in enumerate(results):
        theta, flux = result.shields, result.flux
        mean, error = flux["q_star_mean"], flux.get("q_star_standard_error", 0.0)
        error = error if np.isfinite(error) else 0.0
        style = {"color": picture.ORANGE, "marker": markers[k % len(markers)], "ms": 6, "mec": "white", "mew": 0.6,
                 "ls": "none", "zorder": 5}
        value = with_error(mean, error) if mean > floor else f"{mean:.2g}, below the scale"
        label = f"{names[k]}: {value}" if len(results) <= MOST_NAMED else names[k]
        if mean > floor:
            axes.errorbar([theta], [mean], yerr=[[min(error, 0.999 * mean)], [error]], capsize=2.5, elinewidth=1.2,
                          label=label, **style)
        else:
            axes.plot([theta], [1.15 * floor], **{**style, "marker": "v"}, label=label)


def make(results, path, keys=None, points=None):
    import picture
    results = with_flux(results)
    figure, axes = picture.plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    thetas = np.array([result.shields for result in results] + ([] if points is None else list(points[:, 0])))
    means = np.array([result.flux["q_star_mean"] for result in results])
    floor = min(1e-3, 0.3 * means[means > 1e-4].min(initial=np.inf))
    axes.set_xscale("log")
    axes.set_yscale("log")
    draw_curves(axes, keys or CLASSIC, picture)
    if points is not None:
        axes.plot(points[:, 0], points[:, 1], ls="none", marker="x", ms=4, mew=0.8, color=picture.GREY, label="measured",
                  zorder=2)
    draw_results(axes, results, floor, picture)
    axes.set_xlim(min(0.03, 0.7 * thetas[thetas > 0].min(initial=1.0)), max(2.0, 1.4 * thetas.max(initial=0.0)))
    axes.set_ylim(floor, max(60.0, 3.0 * means.max(initial=0.0)))
    axes.set_xlabel("Shields number  θ")
    axes.set_ylabel("sediment flux  q*")
    axes.grid(True, which="major", color="#E6E6E6", lw=0.6)
    ticks = [t for t in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10) if axes.get_xlim()[0] <= t <= axes.get_xlim()[1]]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.xaxis.set_minor_formatter(picture.plt.NullFormatter())
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles, labels, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return picture.save(figure, path)


def with_flux(results):
    """Those whose q* is known; the others are named."""
    unknown = []
    for result in results:
        if result.shields is None:
            raise ResultError(f"{result.path}: a run without fluid has no Shields number")
        if not result.flux:
            unknown.append(f"{result.path}: q* is not known: no mean flux (/observables/flux), or of no sample")
    if len(unknown) == len(results):
        raise ResultError(unknown[0])
    for line in unknown:
        print(f"{line}; left out", file=sys.stderr)
    return [result for result in results if result.flux]


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", nargs="*", help="result files")
    arguments.add_argument("-o", "--output", help="picture to write (default: FILE-relations.png beside the first result)")
    arguments.add_argument("-r", "--relation", action="append", metavar="KEY", help="show this relation; may be repeated")
    arguments.add_argument("-a", "--all", action="store_true", help="show every relation")
    arguments.add_argument("-p", "--points", metavar="CSV", help="measured points: a table with columns theta and q_star")
    arguments.add_argument("-l", "--list", action="store_true", help="list the relations and end")
    given = arguments.parse_args()
    curves = read_curves()
    if given.list:
        print("\n".join(f"{key:26} {label}" for key, (label, _, _) in curves.items()))
        return 0
    if not given.file:
        arguments.error("which result files?")
    unknown = [key for key in given.relation or [] if key not in curves]
    if unknown:
        arguments.error(f"no relation '{unknown[0]}'; there are: {', '.join(curves)}")
    keys = list(curves) if given.all else given.relation
    points = read_points(given.points) if given.points else None
    results = [Result(file) for file in given.file]
    print(make(results, output_path(results[0], given.output, "-relations.png"), keys, points))
    return 0


if __name__ == "__main__":
    run(main)
