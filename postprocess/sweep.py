#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Flux of a sweep, with error bars: against the Shields number, among relations and measurements, where
that is what was varied first; otherwise against the first key that was varied.

Replicas are taken together; the error bar is one standard error, of the series and of the beds. mpm1948.csv has the 105 flume runs of Meyer-Peter & Müller."""
from pathlib import Path

import h5py
import numpy as np
from relations import CLASSIC, draw_curves, read_curves, read_points
from ryusa_result import ResultError, parser, run

MEASURED = Path(__file__).resolve().with_name("mpm1948.csv")
MOST_SERIES = 10


def text_of(value):
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


class Sweep:
    """The points of OUT.h5: what was varied (a list of values or words for each key), theta, q*."""

    def __init__(self, path):
        self.path = Path(path)
        if not self.path.exists():
            raise ResultError(f"{path}: no such file; a sweep that goes on has none yet, `ryusa sweep --merge` makes it")
        try:
            with h5py.File(self.path, "r") as file:
                self._read(file)
        except OSError:
            raise ResultError(f"{path}: not an HDF5 file, or damaged") from None

    def _read(self, file):
        if text_of(file.attrs.get("program", "")) != "ryusa sweep":
            raise ResultError(f"{self.path}: not the table of a sweep")
        self.title = text_of(file.attrs["title"])
        self.keys = [key for key in text_of(file.attrs["varied"]).split(",") if key]
        row = file["points/first_case"][()].astype(int) - 1
        self.inputs, self.units = {}, {}
        for key in self.keys:
            values = file["inputs/" + key]
            self.units[key] = text_of(values.attrs.get("unit", "1"))
            self.inputs[key] = np.array([text_of(v) for v in values[()][row]]) if values.dtype.kind == "O" \
                else values[()][row]
        self.shields = file["points/shields"][()]
        self.mean = file["points/q_star"][()]
        self.error = file["points/q_star_standard_error"][()]
        status = file["cases/status"][()]
        self.cases, self.done, self.failed = len(status), int((status == 0).sum()), int((status > 0).sum())
        if not np.isfinite(self.mean).any():
            raise ResultError(f"{self.path}: no case of the sweep has a flux")

    @property
    def stem(self):
        return self.path.name.removesuffix(".h5")

    @property
    def is_over_shields(self):
        return bool(self.keys) and self.keys[0] in ("fluid.shields", "fluid.shear_stress")

    def series(self):
        """(label, points) for each combination of the keys behind the first one."""
        others = self.keys[1:]
        rows = list(zip(*(self.inputs[key] for key in others))) if others else [()] * len(self.mean)
        kinds = list(dict.fromkeys(rows))
        if len(kinds) > MOST_SERIES:
            return [("simulated", np.arange(len(rows)))]
        shown = [", ".join(f"{key} {value}" if isinstance(value, str) else f"{key} {value:.4g} {self.units[key]}".removesuffix(" 1")
                           for key, value in zip(others, kind)) or "simulated" for kind in kinds]
        return [(label, np.array([k for k, row in enumerate(rows) if row == kind])) for label, kind in zip(shown, kinds)]


def draw_points(axes, sweep, x, floor, picture):
    colors = [picture.ORANGE, picture.BLUE, picture.GREEN, picture.PINK, picture.AMBER, picture.SKY, picture.BLACK]
    for k, (label, which) in enumerate(sweep.series()):
        style = {"color": colors[k % len(colors)], "marker": "osD^v<>pP*"[k % 10], "ms": 5, "mec": "white", "mew": 0.5,
                 "ls": "none", "zorder": 5}
        mean, error = sweep.mean[which], np.nan_to_num(sweep.error[which])
        good = np.isfinite(mean) & (mean > floor)
        low = np.minimum(error, 0.999 * mean) if floor > 0 else error
        axes.errorbar(x[which][good], mean[good], yerr=[low[good], error[good]], capsize=2.5, elinewidth=1.1,
                      label=label, **style)
        below = np.isfinite(mean) & ~good
        if below.any() and floor > 0:
            axes.plot(x[which][below], np.full(below.sum(), 1.2 * floor), **{**style, "marker": "v", "mfc": "none",
                      "mec": style["color"], "mew": 1.0}, label="below the scale" if k == 0 else None)


def make_shields(sweep, figure, keys, points, picture):
    axes = figure.subplots()
    good = sweep.mean[np.isfinite(sweep.mean) & (sweep.mean > 1e-6)]
    floor = min(1e-3, max(0.3 * good.min(initial=1.0), 1e-5))
    axes.set_xscale("log")
    axes.set_yscale("log")
    label = "Meyer-Peter & Müller 1948, measured" if points is None else "measured"
    points = read_points(MEASURED) if points is None else points
    axes.plot(points[:, 0], points[:, 1], ls="none", marker="x", ms=3.5, mew=0.7, color="#A8A8A8", label=label, zorder=1)
    draw_curves(axes, keys or CLASSIC, picture)
    draw_points(axes, sweep, sweep.shields, floor, picture)
    theta = sweep.shields[np.isfinite(sweep.shields) & (sweep.shields > 0)]
    axes.set_xlim(min(0.03, 0.7 * theta.min(initial=1.0)), max(2.0, 1.4 * theta.max(initial=0.0)))
    axes.set_ylim(floor, max(60.0, 3.0 * good.max(initial=0.0)))
    ticks = [t for t in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10) if axes.get_xlim()[0] <= t <= axes.get_xlim()[1]]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.xaxis.set_minor_formatter(picture.plt.NullFormatter())
    axes.set_xlabel("Shields number  θ")
    return axes


def make_plain(sweep, figure, picture):
    axes = figure.subplots()
    if not sweep.keys:  # replicas alone
        x = np.arange(len(sweep.mean)) + 1.0
        axes.set_xlabel("point")
    else:
        key, values = sweep.keys[0], sweep.inputs[sweep.keys[0]]
        if values.dtype.kind in "OUS":
            words = list(dict.fromkeys(values))
            x = np.array([words.index(v) for v in values], float)
            axes.set_xticks(range(len(words)), words)
            axes.set_xlim(-0.5, len(words) - 0.5)
        else:
            x = values
            spread = x[x > 0].max(initial=1.0) / x[x > 0].min(initial=1.0)
            if (x > 0).all() and spread > 20.0:
                axes.set_xscale("log")
        axes.set_xlabel(key if sweep.units[key] in ("", "1") else f"{key} ({sweep.units[key]})")
    draw_points(axes, sweep, x, 0.0, picture)
    axes.set_ylim(bottom=0.0)
    return axes


def make(sweep, path, keys=None, points=None):
    import picture
    figure = picture.plt.figure(figsize=(7.2, 4.2), layout="constrained")
    axes = make_shields(sweep, figure, keys, points, picture) if sweep.is_over_shields \
        else make_plain(sweep, figure, picture)
    axes.set_ylabel("sediment flux  q*")
    axes.grid(True, which="major", color="#E6E6E6", lw=0.6)
    note = f"{sweep.done} of {sweep.cases} cases" + (f", {sweep.failed} failed" if sweep.failed else "")
    axes.set_title(f"{sweep.title}: {note}" if sweep.title else note, loc="left")
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > 1 or labels != ["simulated"]:
        axes.legend(handles, labels, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return picture.save(figure, path)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="OUT.h5 of ryusa sweep")
    arguments.add_argument("-o", "--output", help="picture to write (default: OUT-sweep.png beside the table)")
    arguments.add_argument("-r", "--relation", action="append", metavar="KEY", help="show this relation; may be repeated")
    arguments.add_argument("-p", "--points", metavar="CSV", help="other measured points: a table with columns theta and q_star")
    given = arguments.parse_args()
    unknown = [key for key in given.relation or [] if key not in read_curves()]
    if unknown:
        arguments.error(f"no relation '{unknown[0]}'; there are: {', '.join(read_curves())}")
    sweep = Sweep(given.file)
    path = Path(given.output) if given.output else sweep.path.with_name(sweep.stem + "-sweep.png")
    print(make(sweep, path, given.relation, read_points(given.points) if given.points else None))
    return 0


if __name__ == "__main__":
    run(main)
