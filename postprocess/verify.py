#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Draws what `ryusa verify` wrote as the figures and tables of section 5 of Fujioka & Ushijima (2005).

NAME-bounce.png (Figs. 4, 5), NAME-phase.png (Figs. 6, 7), NAME-tables.png (Tables 1, 2) and
NAME-spheres.png (Figs. 10, 11), each for the cases that the file holds."""
from pathlib import Path

from ryusa_result import ResultError, parser, run

import h5py
import numpy as np
import picture
from picture import AMBER, BLACK, BLUE, GREEN, GREY, ORANGE, PINK, SKY

# law -> label, colour, marker, line; in the order of the tables
LAWS = {
    "cundall-tension": ("C, pulling", ORANGE, "s", "-"),
    "cundall": ("C, never pulling", AMBER, "D", "-"),
    "tanaka": ("T", GREEN, "^", "-"),
    "fujioka-1": ("F", PINK, "v", "-"),
    "fujioka-2-printed": ("P as printed", SKY, "o", "-"),
    "fujioka-2": ("P", BLUE, "x", "--"),
    "energy": ("energy", BLACK, "+", ":"),
}
EXACT = {"color": GREY, "lw": 0.9, "zorder": 0}


def open_file(path):
    if not path.is_file():
        raise ResultError(f"{path}: no such file")
    try:
        file = h5py.File(path, "r")
    except OSError:
        raise ResultError(f"{path}: not an HDF5 file, or damaged") from None
    if file.attrs.get("program", "") != "ryusa verify":
        file.close()
        raise ResultError(f"{path}: not made by ryusa verify")
    return file


def style(law):
    label, color, marker, line = LAWS[law]
    return {"label": label, "color": color, "marker": marker, "ls": line, "ms": 4.5, "mfc": "none", "mew": 1.1, "lw": 1.0}


def laws_of(group):
    return [law for law in LAWS if law in group]


def legend(figure, axes):
    """Below the panels, in one row, or in three where there is one panel only."""
    handles, labels = axes.get_legend_handles_labels()
    rows = 1 if figure.get_figwidth() > 6.0 else 3
    figure.get_layout_engine().set(rect=(0.0, 0.04 + 0.05 * rows, 1.0, 0.96 - 0.05 * rows))
    figure.legend(handles, labels, loc="lower center", ncol=-(-len(handles) // rows), columnspacing=1.2, handletextpad=0.5)


# --- Figs. 4 and 5 ---

def draw_bounces(axes, group, title):
    axes.axhline(0.49, **EXACT)
    for law in laws_of(group):
        kept = group[law]["kept"][()]
        axes.plot(np.arange(1, len(kept) + 1), kept, **style(law))
    axes.set_xlabel("N, number of the bounce")
    axes.set_ylabel(r"energy behind/before a bounce, $e^2$")
    axes.set_ylim(0.38, 0.62)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_title(title, loc="left")


def make_bounces(file, path):
    cases = [(name, title) for name, title in (("slow-bounce", "Fig. 4: slow bounce"), ("fast-bounce", "Fig. 5: fast bounce"))
             if name in file]
    if not cases:
        return None
    figure, axes = picture.plt.subplots(1, len(cases), figsize=(4.4 * len(cases), 3.6), layout="constrained", squeeze=False)
    for one, (name, title) in zip(axes[0], cases):
        draw_bounces(one, file[name], title)
    legend(figure, axes[0][0])
    return picture.save(figure, path)


# --- Figs. 6 and 7 ---

def draw_tracks(axes, group, law, zoom):
    d, w, bounce = (group[law][name][()] for name in ("d", "w", "bounce"))
    shown = style(law)
    for n in np.unique(bounce):
        of = bounce == n
        axes.plot(d[of], w[of], **shown)
        shown.pop("label", None)
    if not zoom:
        return
    a = float(group[law].attrs["a"])
    limit = 0.75
    lines = [(1.0, "$s=1$"), (0.0, "$s=0$")]
    if a < 1.0:
        lines.append((-np.sqrt(1.0 - a), r"$s=-\sqrt{1-a}$"))
    if law == "fujioka-1":
        lines.append((1.0 / 0.7, "$s=1/e$"))
    for slope, text in lines:
        axes.plot([0.0, limit], [0.0, slope * limit], **EXACT)
        reach = min(limit, 0.46 / abs(slope)) if slope else limit
        axes.annotate(text, (reach, slope * reach), xytext=(-6 if slope else 0, 1), textcoords="offset points", ha="right",
                      va="bottom", color=GREY, fontsize=7)
    axes.set_xlim(0.0, limit)
    axes.set_ylim(-0.5, 0.5)
    axes.set_title(f"Fig. 7: {LAWS[law][0]}", loc="left")
    axes.set_xlabel("$d$")


def make_phase(file, path):
    if "phase-space" not in file:
        return None
    group = file["phase-space"]
    zoomed = [law for law in ("tanaka", "fujioka-1", "fujioka-2-printed", "energy") if law in group]
    figure, axes = picture.plt.subplots(1, 1 + len(zoomed), figsize=(11.5, 3.3), layout="constrained", sharey=True,
                                        gridspec_kw={"width_ratios": [1.5] + [1.0] * len(zoomed)})
    axes[0].axvline(1.0, **EXACT)
    axes[0].annotate(" buried", (1.0, 0.42), color=GREY, fontsize=7)
    for law in laws_of(group):
        draw_tracks(axes[0], group, law, zoom=False)
    axes[0].set_title("Fig. 6: tracks of the contacts of a fast ball", loc="left")
    axes[0].set_xlabel("$d$, overlap in diameters")
    axes[0].set_ylabel("$p+q$, approach per step")
    for one, law in zip(axes[1:], zoomed):
        draw_tracks(one, group, law, zoom=True)
    legend(figure, axes[0])
    return picture.save(figure, path)


# --- Tables 1 and 2 ---

def draw_steps(axes, group):
    dt = group["dt"][()]
    for law in laws_of(group):
        axes.plot(dt, group[law]["steps"][()], **style(law))
        printed = group[law]["printed"][()]
        axes.scatter(dt, printed, s=90, facecolors="none", edgecolors=GREY, lw=0.8, zorder=0)
    axes.scatter([], [], s=90, facecolors="none", edgecolors=GREY, lw=0.8, label="as printed")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_yticks([1, 2, 3, 5, 10, 20, 40], ["1", "2", "3", "5", "10", "20", "40"])
    axes.minorticks_off()
    axes.invert_xaxis()
    axes.set_xlabel("time step (s)")
    axes.set_ylabel("steps of a contact")
    axes.set_title("Table 2: steps of the first contact", loc="left")


def draw_cost(axes, group):
    laws = [name.decode() if isinstance(name, bytes) else name for name in group["law"][()]]
    here = group["evaluation"][()] * 1e9
    together = group["evaluation_together"][()] * 1e9
    paper = group["printed_evaluation"][()]
    place = np.arange(len(laws))
    axes.bar(place - 0.2, here, 0.38, color=[LAWS[law][1] for law in laws])
    axes.bar(place + 0.2, together, 0.38, color=[LAWS[law][1] for law in laws], alpha=0.45)
    for k, value in enumerate(paper):
        times = f"{here[k] / here[0]:.1f} × C"
        if np.isfinite(value):
            times += f"\npaper {value / paper[0]:.2f}"
        axes.text(place[k], max(here[k], together[k]), times, ha="center", va="bottom", fontsize=7, color=GREY)
    axes.set_xticks(place, [LAWS[law][0].replace(" ", "\n") for law in laws], fontsize=7)
    axes.margins(y=0.2)
    axes.set_ylabel("time of an evaluation (ns)")
    axes.set_title("Table 1: one by one (full), many side by side (pale)", loc="left")


def make_tables(file, path):
    cases = [(name, draw) for name, draw in (("cost", draw_cost), ("steps", draw_steps)) if name in file]
    if not cases:
        return None
    figure, axes = picture.plt.subplots(1, len(cases), figsize=(4.6 * len(cases), 3.6), layout="constrained", squeeze=False)
    for one, (name, draw) in zip(axes[0], cases):
        draw(one, file[name])
    if "steps" in file:
        legend(figure, axes[0][-1])
    return picture.save(figure, path)


# --- Figs. 10 and 11 ---

def make_spheres(file, path):
    if "three-spheres" not in file:
        return None
    group = file["three-spheres"]
    dt = group["dt"][()]
    figure, axes = picture.plt.subplots(1, 2, figsize=(8.8, 3.8), layout="constrained")
    for one, name, title in zip(axes, ("d_prime_error", "T0_error"), ("Fig. 10: $d'$", "Fig. 11: $T_0$")):
        for law in laws_of(group):
            one.loglog(dt, group[law][name][()], **style(law))
        one.set_xlabel(r"time step $\delta_t$ (s)")
        one.set_ylabel("relative error")
        one.set_title(title, loc="left")
    off = abs(float(group["exact"].attrs["T0_eq31_error"]))
    axes[1].axhline(off, **EXACT)
    axes[1].annotate("error of the paper's own exact value (eq. 31)", (dt.max(), 0.75 * off), ha="right", va="top",
                     color=GREY, fontsize=7)
    legend(figure, axes[0])
    return picture.save(figure, path)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", nargs="?", default="verify.h5", help="what ryusa verify wrote (verify.h5)")
    arguments.add_argument("-o", "--output", metavar="FOLDER", help="folder for the pictures (default: beside the file)")
    given = arguments.parse_args()
    source = Path(given.file)
    folder = Path(given.output) if given.output else source.parent
    makers = {"bounce": make_bounces, "phase": make_phase, "tables": make_tables, "spheres": make_spheres}
    with open_file(source) as file:
        folder.mkdir(parents=True, exist_ok=True)
        made = [make(file, folder / f"{source.stem}-{name}.png") for name, make in makers.items()]
    for path in filter(None, made):
        print(path)
    if not any(made):
        raise ResultError(f"{source}: nothing in it to draw")


if __name__ == "__main__":
    run(main)
