#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Sediment flux over time: samples, the equilibration cut, and the running mean with its error.

The band is the standard error of the running mean: the one in the file, which comes from the
autocorrelation time of the series, times the root of (all samples / samples so far)."""
import numpy as np
from ryusa_result import Result, ResultError, output_path, parser, run, with_error


def thin(time, value, most=4000):
    """Lowest and highest of neighbouring samples: the same picture with fewer points."""
    size = int(np.ceil(2 * len(value) / most))
    if size <= 2:
        return time, value
    n = len(value) // size * size
    block = value[:n].reshape(-1, size)
    pairs = np.column_stack([block.min(axis=1), block.max(axis=1)]).ravel()
    return np.repeat(time[:n].reshape(-1, size).mean(axis=1), 2), pairs


def draw_mean(axes, series, flux):
    from picture import BLUE, GREY
    cut = float(flux.get("equilibration_time", series.time[0]))
    behind = series.time >= cut
    n = int(behind.sum())
    if n == 0:
        return
    count = np.arange(1, n + 1)
    mean = np.cumsum(series.value[behind]) / count
    error = float(flux.get("q_star_standard_error", np.nan)) * np.sqrt(n / count)
    time = series.time[behind]
    shown = count > min(20, n // 10)  # the first few have errors without limit
    keep = np.flatnonzero(shown)[::max(1, n // 2000)]
    axes.plot(time[keep], mean[keep], color=BLUE, label="running mean")
    axes.fill_between(time[keep], (mean - error)[keep], (mean + error)[keep], color=BLUE, alpha=0.25, lw=0,
                      label="its standard error")
    if cut > series.time[0]:
        axes.axvline(cut, color=GREY, lw=0.9, ls="--")
        axes.text(cut, 0.98, " mean from here", transform=axes.get_xaxis_transform(), va="top", color=GREY, fontsize=8)


def heading(result, flux):
    theta = result.shields
    parts = [] if theta is None else [f"θ = {theta:.3g}"]
    if flux:
        parts.append("q* = " + with_error(flux["q_star_mean"], flux.get("q_star_standard_error", 0.0)))
        if flux.get("autocorrelation_time", 0) > 0:
            parts.append(f"autocorrelation time {flux['autocorrelation_time']:.2g} s")
    return ",  ".join(parts)


def make(result, path):
    import picture
    series, flux = result.series("q_star"), result.flux
    if len(series.time) < 2:
        raise ResultError(f"{result.path}: one sample of q* only")
    figure, axes = picture.plt.subplots(figsize=(6.6, 3.2), layout="constrained")
    axes.plot(*thin(series.time, series.value), color="#BBBBBB", lw=0.6, label="all grains at an instant", zorder=1)
    settle = float(result.parameter("time.settle", 0.0) or 0.0)
    if result.has_fluid and 0.0 < settle < series.time[-1]:
        axes.axvspan(0.0, settle, color="#E4E4E4", lw=0, zorder=0, label="fluid still")
    if flux:
        draw_mean(axes, series, flux)
    axes.set_xlim(series.time[0], series.time[-1] if len(series.time) > 1 else None)
    finite = series.value[np.isfinite(series.value)]
    if len(finite) and finite.max() > 0:
        axes.set_ylim(min(0.0, 1.05 * finite.min()), 1.1 * finite.max())
    axes.set_xlabel("time (s)")
    excess = r"(s-1)\," if result.has_fluid else ""
    axes.set_ylabel(rf"sediment flux  $q^* = q_b\,/\sqrt{{{excess}g\,d^3}}$")
    axes.set_title(heading(result, flux), loc="left")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncol=4)
    return picture.save(figure, path)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="result file")
    arguments.add_argument("-o", "--output", help="picture to write (default: FILE-flux.png beside the result)")
    given = arguments.parse_args()
    with Result(given.file) as result:
        print(make(result, output_path(result, given.output, "-flux.png")))


if __name__ == "__main__":
    run(main)
