# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""How pictures look, and the drawing of grains that bed.py and animate.py share."""
import os

os.environ["MPLBACKEND"] = "Agg"
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import LinearSegmentedColormap, PowerNorm
from ryusa_result import ResultError

# Okabe & Ito (2008): told apart by colour-blind readers too.
BLUE, ORANGE, GREEN, PINK = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
SKY, AMBER, BLACK, GREY = "#56B4E9", "#E69F00", "#222222", "#8C8C8C"
FIXED = "#9A9A9A"
WATER = "#EEF5FA"
# Sand at rest, blue in motion; lightness falls all the way.
SPEED = LinearSegmentedColormap.from_list("speed", ["#F3E3BE", "#C9CF9E", "#6FB3A2", "#2B7FA3", "#123F7C"])

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 9, "axes.labelsize": 9, "legend.fontsize": 8,
    "axes.linewidth": 0.7, "axes.spines.top": False, "axes.spines.right": False,
    "xtick.major.width": 0.7, "ytick.major.width": 0.7, "xtick.labelsize": 8, "ytick.labelsize": 8,
    "lines.linewidth": 1.4, "legend.frameon": False, "savefig.dpi": 160, "figure.dpi": 160,
    "mathtext.fontset": "dejavusans",
})


def unit_of(result):
    """Of lengths in a picture of grains: its name, and how many of it are a metre."""
    return ("mm", 1e3) if result.d < 0.1 else ("m", 1.0)


def save(figure, path):
    figure.savefig(path)
    plt.close(figure)
    return path


def speed_norm(result, indices):
    """Colours end where the fastest per cent begins; the power below 1 brings out the slow ones."""
    free = ~result.fixed
    if not free.any() or not result.has("velocity"):
        return PowerNorm(0.7, 0.0, 1.0)
    speeds = np.concatenate([result.speed(k)[free] for k in indices])
    speeds = speeds[np.isfinite(speeds)]
    top = float(np.percentile(speeds, 99)) if len(speeds) else 0.0
    top = top if top > 0.0 else float(speeds.max(initial=0.0))
    return PowerNorm(0.7, 0.0, top if top > 0.0 else 1.0)


def extent(result, indices):
    """x0, x1, z0, z1 [m] that hold the grains of these frames, with some water above."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    radius = 0.5 * result.diameter[:, None]
    for k in indices:
        position = result.frame("position", k)
        good = np.isfinite(position).all(axis=1)
        if good.any():
            low = np.minimum(low, (position - radius)[good].min(axis=0))
            high = np.maximum(high, (position + radius)[good].max(axis=0))
    if not np.isfinite(low).all():
        raise ResultError(f"{result.path}: no position is a finite number")
    margin = 2.0 * result.d if result.has_fluid else 0.5 * result.d
    z0, z1 = low[1] - 0.3 * result.d, high[1] + margin
    if result.length:
        return 0.0, result.length, z0, z1
    return low[0] - result.d, high[0] + result.d, z0, z1


def grain_collection(axes, result, index, norm, linewidth=0.4):
    """The grains of a frame to scale, drawn twice where they stick out of a periodic domain."""
    position = result.frame("position", index)
    x, z, diameter = position[:, 0], position[:, 1], result.diameter
    which = np.arange(result.n)
    if result.length:
        left, right = x < 0.5 * diameter, x > result.length - 0.5 * diameter
        which = np.concatenate([which, which[left], which[right]])
        x = np.concatenate([x, x[left] + result.length, x[right] - result.length])
    colors = SPEED(norm(result.speed(index)))
    colors[result.fixed] = plt.matplotlib.colors.to_rgba(FIXED)
    scale = unit_of(result)[1]
    size = diameter[which] * scale
    return EllipseCollection(size, size, np.zeros(len(which)), units="x", linewidths=linewidth,
                             edgecolors="#4A4A4A", facecolors=colors[which],
                             offsets=np.column_stack([x, z[which]]) * scale, offset_transform=axes.transData)


def setup_bed_axes(axes, result, box):
    axes.set_aspect("equal")
    unit, scale = unit_of(result)
    axes.set_xlim(box[0] * scale, box[1] * scale)
    axes.set_ylim(box[2] * scale, box[3] * scale)
    axes.set_xlabel(f"x ({unit})")
    axes.set_ylabel(f"z ({unit})")
    if result.has_fluid:
        axes.set_facecolor(WATER)
    length = result.parameter("domain.length")
    if result.parameter("domain.walls", 0) and length is not None:
        for x in (0.0, length):
            axes.axvline(x * scale, color=BLACK, lw=1.0, zorder=0)
    if result.parameter("domain.floor") == "flat":
        axes.axhline(0.0, color=BLACK, lw=1.0, zorder=0)


def bed_size(box, width, low, high):
    """Height in inches of a panel `width` wide that shows `box` to scale, within limits."""
    return float(np.clip(width * (box[3] - box[2]) / (box[1] - box[0]), low, high))
