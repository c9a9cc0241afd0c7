#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The validity study (runs/validity): q* against the Shields number for three grains, among relations and
measurements, a picture for each and one for all; and what q* changes by when the bed is longer or deeper, the
time step smaller, or the packings others. Prints the tables of docs/validity.md."""
from pathlib import Path

import h5py
import numpy as np
from relations import CLASSIC, draw_curves, read_curves, read_points
from ryusa_result import ResultError, parser, run
from sweep import MEASURED, Sweep, make

GRAINS = {"sand-0.5mm": "0.5 mm sand, s = 2.65", "beads-2mm": "2 mm glass, s = 2.5", "beads-6mm": "6 mm glass, s = 2.5"}
AT_REST = 1e-5
TARGETS = ("wong-parker", "meyer-peter-muller", "ashida-michiue")
CHANGES = ("as it is", "twice as long", "twice as many layers", "half the time step, same springs")


def columns_of(rows):
    """A table of Markdown."""
    head, *body = rows
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in body])


def ratio(q, theta, key):
    theta_of, q_of = read_curves()[key][1:3]
    target = np.interp(theta, theta_of, q_of)
    return f"{q / target:.2f}" if target > 1e-3 else "–"


def table_of_grain(sweep):
    rows = [["θ", "q\\*", "±", *(f"/ {key}" for key in TARGETS if key in read_curves())]]
    for theta, q, error in zip(sweep.shields, sweep.mean, sweep.error):
        if q < AT_REST:
            rows.append([f"{theta:g}", "at rest", *[""] * (len(rows[0]) - 2)])
            continue
        rows.append([f"{theta:g}", f"{q:.3g}", f"{error:.2g}",
                     *(ratio(q, theta, key) for key in TARGETS if key in read_curves())])
    return columns_of(rows)


def draw_all(sweeps, path):
    import picture
    figure = picture.plt.figure(figsize=(7.2, 4.4), layout="constrained")
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_yscale("log")
    points = read_points(MEASURED)
    axes.plot(points[:, 0], points[:, 1], ls="none", marker="x", ms=3.5, mew=0.7, color="#A8A8A8", zorder=1,
              label="Meyer-Peter & Müller 1948, measured")
    draw_curves(axes, CLASSIC, picture)
    for sweep, label, color, marker in zip(sweeps, GRAINS.values(), (picture.ORANGE, picture.BLUE, picture.GREEN), "osD"):
        good = np.isfinite(sweep.mean) & (sweep.mean > 1e-3)
        low = np.minimum(sweep.error, 0.99 * sweep.mean)
        axes.errorbar(sweep.shields[good], sweep.mean[good], yerr=[low[good], sweep.error[good]], label=label, color=color,
                      marker=marker, ms=5, mec="white", mew=0.5, ls="none", capsize=2.5, zorder=5)
    axes.set_xlim(0.03, 3.0)
    axes.set_ylim(1e-3, 100.0)
    ticks = (0.05, 0.1, 0.2, 0.5, 1, 2)
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.xaxis.set_minor_formatter(picture.plt.NullFormatter())
    axes.set_xlabel("Shields number  θ")
    axes.set_ylabel("sediment flux  q*")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return picture.save(figure, path)


def convergence(sweep, other):
    """Each change against the bed as it is: the difference over its standard error."""
    rows = [["θ", *CHANGES, "other packings"]]
    verdict = []
    n = len(CHANGES)
    for k in range(len(sweep.mean) // n):
        which = slice(n * k, n * (k + 1))
        mean, error = sweep.mean[which], sweep.error[which]
        at = int(np.argmin(np.abs(other.shields - sweep.shields[n * k])))
        mean, error = np.append(mean, other.mean[at]), np.append(error, other.error[at])
        off = (mean[1:] - mean[0]) / np.hypot(error[1:], error[0])
        rows.append([f"{sweep.shields[n * k]:g}", f"{mean[0]:.3g} ± {error[0]:.2g}",
                     *(f"{m:.3g} ± {e:.2g} ({100 * (m / mean[0] - 1):+.0f} %, {o:+.1f} σ)"
                       for m, e, o in zip(mean[1:], error[1:], off))])
        verdict += [abs(o) <= 2.0 for o in off]
    return columns_of(rows), f"{sum(verdict)} of {len(verdict)} within two standard errors of the difference."


def spread_of(path):
    with h5py.File(path, "r") as file:
        return float(file["points"].attrs["spread_between_replicas"]), float(np.nansum(file["cases/wall_seconds"][()]))


def main():
    arguments = parser(__doc__)
    arguments.add_argument("folder", help="folder with the results of the five sweeps")
    folder = Path(arguments.parse_args().folder)
    needed = [*GRAINS, "convergence", "other-packings"]
    missing = [name for name in needed if not (folder / f"{name}.h5").exists()]
    if missing:
        raise ResultError(f"{folder}: no {missing[0]}.h5; runs/validity/run.sh makes it")
    sweeps = [Sweep(folder / f"{name}.h5") for name in GRAINS]
    for (name, label), sweep in zip(GRAINS.items(), sweeps):
        make(sweep, folder / f"{name}.png")
        spread, _ = spread_of(sweep.path)
        print(f"### {label}\n\nBeds differ by {100 * spread:.0f} %.\n\n{table_of_grain(sweep)}\n")
    draw_all(sweeps, folder / "all.png")
    table, verdict = convergence(Sweep(folder / "convergence.h5"), Sweep(folder / "other-packings.h5"))
    print(f"### Convergence\n\n{table}\n\n{verdict}\n")
    seconds = sum(spread_of(folder / f"{name}.h5")[1] for name in needed)
    print(f"All cases together: {seconds / 60:.0f} minutes, each on one core, beside whatever else ran.")
    return 0


if __name__ == "__main__":
    run(main)
