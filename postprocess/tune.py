#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Figures 2 to 5 of Harada, Gotoh and Sakai, from ryusa tune: how a lattice settles by alpha_m and by
alpha_cn, the flux at beta = 1, and the flux at the best beta beside the misfit over beta; our optimum
and theirs (20.0, 1.3, 15.8) marked. Of a joint fit: the misfit over each constant, the directions that the
data see and those they don't, and the flux."""
from pathlib import Path

import h5py
import numpy as np
from relations import read_curves
from ryusa_result import ResultError, parser, run

HIS = {"alpha_m": 20.0, "alpha_cn": 1.3, "beta": 15.8}
SYMBOL = {"alpha_m": "α$_m$", "alpha_cn": "α$_{cn}$", "beta": "β"}


def text_of(value):
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def label_of(key, keys=()):
    """A constant's symbol, else its name; with its section where two have the same name."""
    name = key.split(".")[-1]
    alone = sum(other.split(".")[-1] == name for other in keys) < 2
    return SYMBOL.get(name, name) if alone else key


def legend_above(axes, columns, **style):
    """Where it hides no data."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2, columnspacing=1.2,
                handlelength=1.6, **style)


class Settling:
    def __init__(self, group, key):
        self.key = key
        for name in ("value", "settling_time", "settling_time_error", "settling_time_coarse", "deepest_overlap",
                     "settling_time_coarse_error"):
            setattr(self, name, group[name][()])
        for name in ("soonest", "soonest_low", "soonest_high", "ours", "ours_low", "ours_high", "curve_spacing_s"):
            setattr(self, name, float(group.attrs[name]))
        self.clear = bool(group.attrs["soonest_is_clear"])
        self.curve = {}
        for k in range(len(self.value)):
            name = f"curve/{k:02d}-seed-1"
            if name in group:
                self.curve[k] = group[name][()]

    def time(self, k):
        return np.arange(len(self.curve[k])) * self.curve_spacing_s


class Joint:
    """The joint fit of some constants."""

    def __init__(self, file):
        self.keys = text_of(file.attrs["varied"]).split(",")
        joint = file["joint"]
        self.threshold = float(joint.attrs["threshold"])
        self.axis = {key: {**{name: float(joint[key].attrs[name]) for name in
                              ("lower_bound", "upper_bound", "best", "low", "high")},
                           "value": joint[key + "/value"][()], "profile": joint[key + "/profile"][()]}
                     for key in self.keys}
        self.information, self.rise, self.flat = (joint[name][()] for name in ("information", "rise", "flat"))
        half = np.array([0.5 * np.log(a["upper_bound"] / a["lower_bound"]) for a in self.axis.values()])
        vectors = np.array([joint[f"direction-{d}/vector"][()] for d in range(len(self.keys))])
        powers = vectors * half
        self.power = powers / np.take_along_axis(powers, np.abs(powers).argmax(axis=1)[:, None], axis=1)


class Tuning:
    """What OUT.h5 of ryusa tune holds."""

    def __init__(self, path):
        self.path = Path(path)
        if not self.path.exists():
            raise ResultError(f"{path}: no such file")
        try:
            with h5py.File(self.path, "r") as file:
                self._read(file)
        except OSError:
            raise ResultError(f"{path}: not an HDF5 file, or damaged") from None

    def _read(self, file):
        if text_of(file.attrs.get("program", "")) != "ryusa tune":
            raise ResultError(f"{self.path}: not the file of a tuning")
        self.title, self.target_name = text_of(file.attrs["title"]), text_of(file.attrs["target"])
        self.joint = Joint(file) if "joint" in file else None
        flux = file["flux"]
        self.theta, self.target = flux["theta"][()], flux["target"][()]
        self.reachable = flux["reachable"][()] > 0
        self.sets = {name: (float(group.attrs["beta"]), group["q_star"][()], group["q_star_standard_error"][()],
                            float(group.attrs["misfit"]))
                     for name, group in flux.items() if isinstance(group, h5py.Group)}
        if self.joint:
            return
        self.beta = float(file.attrs["beta"])
        self.settling = {key: Settling(file["settling/" + key], key) for key in ("alpha_m", "alpha_cn")}
        self.grid = [self.sets[name] for name in sorted(self.sets) if name.startswith("beta-")]
        misfit = file["misfit"]
        self.fine = misfit["beta"][()], misfit["misfit"][()]
        self.interval = float(misfit.attrs["low"]), float(misfit.attrs["high"])
        self.identifiable = bool(misfit.attrs["identifiable"])

    @property
    def stem(self):
        return self.path.name.removesuffix(".h5")


def draw_settling(figure, settling, picture):
    """Curves of one packing, and beside them the settling time of every candidate."""
    left, right = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
    shown = sorted(settling.curve)
    colors = picture.SPEED(np.linspace(0.3, 1.0, max(len(shown), 2)))
    for color, k in zip(colors, shown):
        value = settling.value[k]
        special = np.isclose(value, HIS[settling.key], rtol=1e-3), np.isclose(value, settling.ours, rtol=1e-3)
        style = {"color": picture.ORANGE if special[1] else picture.BLUE if special[0] else color,
                 "lw": 1.8 if any(special) else 0.9, "zorder": 4 if any(special) else 2}
        note = {(True, True): "  ours and theirs", (False, True): "  ours", (True, False): "  theirs"}.get(
            (bool(special[0]), bool(special[1])), "")
        left.plot(settling.time(k) * 1e3, settling.curve[k], label=f"{value:.3g}{note}", **style)
    left.set_xscale("symlog", linthresh=20.0)
    left.set_xlim(left=0.0)
    left.set_xlabel("time (ms); linear up to 20")
    left.set_ylabel("mean height  y$_{gc}$ / d")
    legend_above(left, 4, title=SYMBOL[settling.key], fontsize=6.5, title_fontsize=8)
    for name, marker, label in (("settling_time", "o", "to $10^{-4}$ d"), ("settling_time_coarse", "s", "to $10^{-3}$ d")):
        error = np.nan_to_num(getattr(settling, name + "_error"))
        right.errorbar(settling.value, getattr(settling, name), yerr=error, marker=marker, ms=4, lw=0.8, capsize=2,
                       color=picture.BLACK if marker == "o" else picture.GREY, label=label)
    right.axvspan(settling.soonest_low / 1.04, settling.soonest_high * 1.04, color=picture.GREEN, alpha=0.15, lw=0,
                  label="soonest, 95 %" + ("" if settling.clear else ": not identifiable"))
    right.axvline(settling.ours, color=picture.ORANGE, lw=1.6, zorder=1, label=f"ours {settling.ours:.3g}")
    right.axvline(HIS[settling.key], color=picture.BLUE, lw=1.6, ls="--", zorder=1,
                  label=f"theirs {HIS[settling.key]:.3g}")
    right.set_xscale("log")
    right.set_ylim(bottom=0.0)
    right.set_xlabel(SYMBOL[settling.key])
    right.set_ylabel("settling time (s)")
    legend_above(right, 2, fontsize=7)


def draw_flux(axes, tuning, picture, sets):
    """sets: (label, color, marker, (beta, q*, error, misfit))."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    curves = read_curves()
    theta = np.geomspace(0.8 * tuning.theta.min(), 1.25 * tuning.theta.max(), 200)
    label = f"target {tuning.target_name}"
    if tuning.target_name in curves:
        line = np.interp(np.log(theta), np.log(curves[tuning.target_name][1]), curves[tuning.target_name][2])
        theta, line = theta[line > 0], line[line > 0]
    else:
        theta, line = tuning.theta, tuning.target
    axes.fill_between(theta, 0.75 * line, 1.25 * line, color=picture.GREEN, alpha=0.15, lw=0, label="target ± 25 %")
    axes.plot(theta, line, color=picture.GREEN, label=label)
    floor = 1e-2 * tuning.target.min()
    for text, color, marker, (_, q, error, _) in sets:
        good = np.isfinite(q) & (q > floor)
        low = np.minimum(error, 0.99 * np.abs(q))
        axes.errorbar(tuning.theta[good], q[good], yerr=[low[good], error[good]], color=color, marker=marker, ms=4.5, lw=0.9,
                      capsize=2.5, label=text)
        below = np.isfinite(q) & ~good
        axes.plot(tuning.theta[below], np.full(below.sum(), 1.2 * floor), ls="none", marker="v", mfc="none", color=color)
    axes.set_ylim(bottom=floor)
    ticks = [t for t in (0.05, 0.1, 0.2, 0.5, 1, 2) if theta[0] <= t <= theta[-1]]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.xaxis.set_minor_formatter(picture.plt.NullFormatter())
    axes.set_xlabel("Shields number  θ")
    axes.set_ylabel("sediment flux  q*")
    axes.legend(fontsize=7)


def draw_misfit(axes, tuning, picture):
    axes.set_xscale("log")
    axes.plot(*tuning.fine, color=picture.BLACK)
    points = np.array([(beta, misfit) for beta, _, _, misfit in tuning.grid])
    axes.plot(points[:, 0], points[:, 1], ls="none", marker="o", ms=4, color=picture.BLACK)
    note = "" if tuning.identifiable else ": not identifiable"
    axes.axvspan(*tuning.interval, color=picture.ORANGE, alpha=0.15, lw=0, label="95 %" + note)
    axes.axvline(tuning.beta, color=picture.ORANGE, label=f"ours {tuning.beta:.3g}")
    axes.axvline(HIS["beta"], color=picture.BLUE, ls="--", label="theirs 15.8")
    ticks = [0.25, 0.5, 1, 2, 4, 8, 16]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.xaxis.set_minor_formatter(picture.plt.NullFormatter())
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("β")
    axes.set_ylabel("misfit")
    legend_above(axes, 3, fontsize=7)


def draw_profile(axes, key, keys, axis, threshold, picture):
    """The least misfit with this constant fixed, over it."""
    name = key.split(".")[-1]
    axes.set_xscale("log")
    axes.plot(axis["value"], axis["profile"], color=picture.BLACK)
    axes.axhline(threshold, color=picture.GREY, lw=0.8, ls=":")
    axes.axvspan(axis["low"], axis["high"], color=picture.ORANGE, alpha=0.15, lw=0)
    axes.axvline(axis["best"], color=picture.ORANGE, label=f"best {axis['best']:.3g}")
    if name in HIS and axis["lower_bound"] <= HIS[name] <= axis["upper_bound"]:
        axes.axvline(HIS[name], color=picture.BLUE, ls="--", label=f"theirs {HIS[name]:.3g}")
    low, high = axis["lower_bound"], axis["upper_bound"]
    ticks = [low, (low * high) ** 0.5, high]
    axes.set_xticks(ticks, [f"{t:.2g}" for t in ticks])
    axes.xaxis.set_minor_formatter(picture.plt.NullFormatter())
    axes.set_xlim(low, high)
    axes.set_ylim(0.0, 4.0 * threshold)
    axes.set_xlabel(label_of(key, keys))
    legend_above(axes, 1, fontsize=7)


def draw_directions(axes, joint, picture):
    """Exponents of each direction, best seen at the top; flat ones pale."""
    names = [label_of(key, joint.keys) for key in joint.keys]
    n = len(names)
    axes.imshow(joint.power, cmap="RdBu_r", vmin=-1.6, vmax=1.6, aspect="auto")
    for row in range(n):
        for column in range(n):
            axes.text(column, row, f"{joint.power[row, column]:.2f}", ha="center", va="center", fontsize=8,
                      color=picture.GREY if joint.flat[row] else picture.BLACK)
    axes.set_xticks(range(n), names)
    axes.set_yticks(range(n), [f"rise {rise:.3g}{', flat' if flat else ''}" for rise, flat in zip(joint.rise, joint.flat)])
    axes.set_title("exponents of each direction", loc="left")
    axes.tick_params(length=0)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def make_joint(tuning, base, picture):
    joint = tuning.joint
    n = len(joint.keys)
    figure = picture.plt.figure(figsize=(max(2.0 * n, 4.0), 2.9), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, n, sharey=True))
    for axes, key in zip(panels, joint.keys):
        draw_profile(axes, key, joint.keys, joint.axis[key], joint.threshold, picture)
    panels[0].set_ylabel("misfit over its least; dotted: 95 %")
    figure.get_layout_engine().set(wspace=0.06)  # or the last tick of a panel meets the first of the next
    made = [picture.save(figure, f"{base}-joint-profiles.png")]
    figure = picture.plt.figure(figsize=(8.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_flux(left, tuning, picture, [("the best constants", picture.ORANGE, "o", tuning.sets["best"])])
    draw_directions(right, joint, picture)
    return made + [picture.save(figure, f"{base}-joint-flux.png")]


def make(tuning, folder):
    import picture
    made = []
    base = Path(folder) / tuning.stem
    if tuning.joint:
        return make_joint(tuning, base, picture)
    for number, key in ((2, "alpha_m"), (3, "alpha_cn")):
        figure = picture.plt.figure(figsize=(8.0, 3.4), layout="constrained")
        draw_settling(figure, tuning.settling[key], picture)
        made.append(picture.save(figure, f"{base}-fig{number}-{key.replace('_', '-')}.png"))
    one = [s for s in tuning.grid if abs(s[0] - 1.0) < 1e-9]
    figure = picture.plt.figure(figsize=(4.6, 3.4), layout="constrained")
    draw_flux(figure.subplots(), tuning, picture, [("β = 1", picture.ORANGE, "o", s) for s in one])
    made.append(picture.save(figure, f"{base}-fig4-flux.png"))
    figure = picture.plt.figure(figsize=(8.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_flux(left, tuning, picture, [(f"ours, β = {tuning.beta:.3g}", picture.ORANGE, "o", tuning.sets["best"]),
                                      ("their 20.0, 1.3, 15.8", picture.BLUE, "s", tuning.sets["his"])]
              + [("β = 1", picture.GREY, "D", s) for s in one])
    draw_misfit(right, tuning, picture)
    made.append(picture.save(figure, f"{base}-fig5-beta.png"))
    return made


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="OUT.h5 of ryusa tune")
    arguments.add_argument("-o", "--output", help="folder for the pictures (default: beside the file)")
    given = arguments.parse_args()
    tuning = Tuning(given.file)
    for path in make(tuning, given.output or tuning.path.parent):
        print(path)
    return 0


if __name__ == "__main__":
    run(main)
