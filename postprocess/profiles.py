#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Mean profiles over height: solid fraction, velocities of grains and fluid, and the stresses.

Fluid and grain stress must add up to the imposed one at every height above the moving bed."""
import numpy as np
from ryusa_result import Result, output_path, parser, run


def visible(result, profile, bed):
    """Heights to show: the grains, and some flow above them."""
    z, phi = profile["z"] / result.d, profile.get("phi", np.zeros_like(profile["z"]))
    dense = z[phi > 1e-3]
    top = dense.max() + 2.0 if len(dense) else z.max()
    if bed is not None:
        top = max(top, bed / result.d + 3.0)
    return 0.0, min(top, z.max())


def legend_above(axes):
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=2, borderaxespad=0.2, columnspacing=1.2, handlelength=1.6)


def draw_fraction(axes, z, profile, picture):
    axes.plot(profile["phi"], z, color=picture.BLACK)
    axes.set_xlabel("solid fraction φ")
    axes.set_xlim(0.0, max(0.7, 1.05 * np.nanmax(profile["phi"])))


def draw_velocity(axes, z, top, profile, fluid, picture):
    if fluid and "u_fluid" in profile:
        axes.plot(profile["u_fluid"], z, color=picture.BLUE, label="fluid")
    if "u_grain" in profile:
        grains = np.where(profile.get("phi", np.ones_like(z)) > 1e-4, profile["u_grain"], np.nan)
        axes.plot(grains, z, color=picture.ORANGE, label="grains")
    axes.set_xlabel("velocity (m/s)")
    axes.locator_params(axis="x", nbins=4)
    shown = np.concatenate([line.get_xdata()[z <= top] for line in axes.get_lines()] or [[]])
    fastest = shown[np.isfinite(shown)].max(initial=0.0)
    if fastest > 0.0:
        axes.set_xlim(right=1.1 * fastest)
    legend_above(axes)


def draw_stress(axes, z, profile, wet, stress, picture):
    fluid, grain = profile.get("tau_fluid") if wet else None, profile.get("tau_grain")
    if fluid is not None and grain is not None:
        axes.plot(fluid + grain, z, color=picture.BLACK, lw=2.6, alpha=0.35, label="sum")
    if fluid is not None:
        axes.plot(fluid, z, color=picture.BLUE, label="fluid")
    if grain is not None:
        axes.plot(grain, z, color=picture.ORANGE, label="grains")
    if stress:
        axes.axvline(stress, color=picture.GREY, lw=0.9, ls="--", label=r"imposed $\tau_b$")
        axes.set_xlim(right=1.25 * stress)
        low = min(np.nanmin(v) for v in (fluid, grain, np.zeros(1)) if v is not None)
        axes.set_xlim(left=max(1.05 * low, -0.5 * stress) if low < -0.02 * stress else -0.02 * stress)
    axes.set_xlabel("shear stress (Pa)")
    axes.locator_params(axis="x", nbins=4)
    legend_above(axes)


def make(result, path):
    import picture
    profile, bed = result.profile, result.bed_level()
    z, (bottom, top) = profile["z"] / result.d, visible(result, profile, bed)
    figure, (left, middle, right) = picture.plt.subplots(1, 3, figsize=(7.2, 3.6), sharey=True, layout="constrained")
    if "phi" in profile:
        draw_fraction(left, z, profile, picture)
    draw_velocity(middle, z, top, profile, result.has_fluid, picture)
    draw_stress(right, z, profile, result.has_fluid, result.shear_stress, picture)
    for axes in (left, middle, right):
        if bed is not None:
            axes.axhline(bed / result.d, color=picture.GREY, lw=0.8, ls=":")
    if bed is not None:
        left.annotate("bed level", (1.0, bed / result.d), xycoords=("axes fraction", "data"), xytext=(0, 2),
                      textcoords="offset points", ha="right", va="bottom", color=picture.GREY, fontsize=8)
    left.set_ylim(bottom, top)
    left.set_ylabel("height z/d")
    theta = result.shields
    if theta is not None:
        left.set_title(f"θ = {theta:.3g}", loc="left")
    return picture.save(figure, path)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="result file")
    arguments.add_argument("-o", "--output", help="picture to write (default: FILE-profiles.png beside the result)")
    given = arguments.parse_args()
    with Result(given.file) as result:
        print(make(result, output_path(result, given.output, "-profiles.png")))


if __name__ == "__main__":
    run(main)
