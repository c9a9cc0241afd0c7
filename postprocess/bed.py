#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""The bed at one instant: grains to scale, coloured by speed where the file has velocities (fixed ones grey), and the flow beside it."""
import numpy as np
from ryusa_result import Result, output_path, parser, run


def draw_flow(axes, result, index, picture):
    z, u = result.fluid_velocity(index)
    z = z * picture.unit_of(result)[1]
    axes.fill_betweenx(z, 0.0, u, color=picture.WATER, lw=0)
    axes.plot(u, z, color=picture.BLUE)
    axes.set_xlabel("fluid (m/s)")
    low, high = axes.get_ylim()
    inside = u[(z >= low) & (z <= high)]
    top = float(np.nanmax(inside)) if len(inside) else 1.0
    axes.set_xlim(min(0.0, float(np.nanmin(inside)) if len(inside) else 0.0), 1.1 * top if top > 0 else 1.0)
    axes.tick_params(labelleft=False)


def make(result, path, index=-1):
    import picture
    times = result.frame_times
    index = index if index >= 0 else len(times) + index
    sample = np.unique(np.linspace(0, len(times) - 1, min(len(times), 40)).astype(int))
    box, norm = picture.extent(result, [index]), picture.speed_norm(result, np.append(sample, index))
    flow = result.has_fluid and result.fluid_velocity(index) is not None
    height = picture.bed_size(box, 4.4, 1.2, 5.5)
    figure = picture.plt.figure(figsize=(6.9 if flow else 5.6, height + 0.6), layout="constrained")
    axes = figure.subplots(1, 2 if flow else 1, sharey=True, gridspec_kw={"width_ratios": [4.4, 1.3]} if flow else None)
    left = axes[0] if flow else axes
    picture.setup_bed_axes(left, result, box)
    left.set_anchor("E" if flow else "C")
    left.add_collection(picture.grain_collection(left, result, index, norm))
    bed = result.bed_level(times[index])
    if bed is not None and np.isfinite(bed) and result.has_fluid:
        bed *= picture.unit_of(result)[1]
        for one in axes if flow else [left]:
            one.axhline(bed, color=picture.ORANGE, lw=0.9, ls="--")
        at = axes[1] if flow else left
        at.annotate("bed level", (0.98, bed), xycoords=("axes fraction", "data"), xytext=(0, -2),
                    textcoords="offset points", ha="right", va="top", color=picture.ORANGE, fontsize=8)
    if flow:
        axes[1].set_box_aspect((box[3] - box[2]) / (box[1] - box[0]) * 4.4 / 1.3)
        axes[1].set_anchor("W")
        draw_flow(axes[1], result, index, picture)
    if result.has("velocity"):
        bar = figure.colorbar(picture.plt.cm.ScalarMappable(norm, picture.SPEED), ax=axes,
                              label="speed of the grains (m/s)", shrink=0.8, aspect=28, pad=0.02, extend="max")
        bar.outline.set_linewidth(0.5)
    left.set_title(f"t = {times[index]:.4g} s", loc="left")
    return picture.save(figure, path)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="result file")
    arguments.add_argument("-o", "--output", help="picture to write (default: FILE-bed.png beside the result)")
    arguments.add_argument("-t", "--time", type=float, help="the frame nearest to this time in s (default: the last)")
    given = arguments.parse_args()
    with Result(given.file) as result:
        times, index = result.frame_times, -1
        if given.time is not None:
            rounding = 1e-9 * abs(times[-1])
            if not times[0] - rounding <= given.time <= times[-1] + rounding:
                arguments.error(f"{given.file}: no frame at {given.time:g} s; allowed: {times[0]:g} to {times[-1]:g} s")
            index = int(np.argmin(np.abs(times - given.time)))
        print(make(result, output_path(result, given.output, "-bed.png"), index))


if __name__ == "__main__":
    run(main)
