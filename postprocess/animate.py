#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""A film of the bed: grains to scale, coloured by speed, and the flux as it goes.

Writes a GIF, or an MP4 if the output ends so and ffmpeg is there. Frames are evenly chosen."""
import shutil
import subprocess

import numpy as np
from ryusa_result import Result, ResultError, output_path, parser, run

LARGEST = 3_000_000  # bytes of a GIF that still travels well


class Film:
    """Draws what stands still once, and over it what moves."""

    def __init__(self, result, indices, width):
        import picture
        self.picture, self.result, self.indices = picture, result, indices
        box = picture.extent(result, indices[::max(1, len(indices) // 60)])
        self.norm = picture.speed_norm(result, indices[::max(1, len(indices) // 40)])
        inches, self.flux = 5.2, result.series("q_star") if result.has("q_star") else None
        height = picture.bed_size(box, inches - 0.6, 1.0, 4.4)
        strip = 0.8 if self.flux is not None else 0.0
        self.figure = picture.plt.figure(figsize=(inches, height + strip + 0.75), dpi=2 * round(width / inches / 2),
                                         layout="constrained")
        rows = self.figure.subplots(2 if strip else 1, 1, gridspec_kw={"height_ratios": [height, strip]} if strip else None)
        self.bed, self.strip = (rows[0], rows[1]) if strip else (rows, None)
        picture.setup_bed_axes(self.bed, result, box)
        if result.has("velocity"):
            self._draw_scale()
        apart = np.diff(result.frame_times[indices]).min(initial=1.0)
        self.digits = int(np.clip(np.ceil(-np.log10(apart) - 1e-6), 2, 12)) if apart > 0.0 else 2
        self.label = self.bed.text(0.01, 0.985, "", transform=self.bed.transAxes, va="top", animated=True)
        if self.strip is not None:
            self._draw_strip()
        self.figure.canvas.draw()
        self.figure.set_layout_engine("none")
        if self.strip is not None:  # as wide as the bed, which its aspect has made narrower
            bed, strip = self.bed.get_position(), self.strip.get_position()
            self.strip.set_position([bed.x0, strip.y0, bed.width, strip.height])
            self.figure.canvas.draw()
        self.background = self.figure.canvas.copy_from_bbox(self.figure.bbox)

    def _draw_scale(self):
        """What the colours mean, in the corner where the water is."""
        inset = self.bed.inset_axes([0.66, 0.925, 0.31, 0.03])
        bar = self.figure.colorbar(self.picture.plt.cm.ScalarMappable(self.norm, self.picture.SPEED), cax=inset,
                                   orientation="horizontal", extend="max")
        bar.outline.set_linewidth(0.4)
        inset.set_xticks([0.0, float(f"{self.norm.vmax:.2g}")])
        inset.tick_params(labelsize=6, length=1.5, pad=1)
        inset.set_ylabel("m/s", rotation=0, fontsize=6, ha="right", va="center", labelpad=2)

    def _draw_strip(self):
        from flux import thin
        time, value = thin(self.flux.time, self.flux.value, 1500)
        self.strip.plot(time, value, color="#A8A8A8", lw=0.6)
        times = self.result.frame_times[self.indices]
        self.strip.set_xlim(self.flux.time[0], max(times[-1], self.flux.time[-1]) or None)
        self.strip.set_ylim(bottom=min(0.0, np.nanmin(value)))
        self.strip.set_xlabel("time (s)")
        self.strip.set_ylabel("q*")
        self.marker, = self.strip.plot([], [], "o", color=self.picture.ORANGE, ms=4, animated=True)

    def frame(self, index):
        """One picture as an array of rows, columns and red, green, blue."""
        time = self.result.frame_times[index]
        canvas = self.figure.canvas
        canvas.restore_region(self.background)
        grains = self.picture.grain_collection(self.bed, self.result, index, self.norm, linewidth=0.3)
        grains.set_animated(True)
        self.bed.add_collection(grains, autolim=False)
        self.bed.draw_artist(grains)
        grains.remove()
        self.label.set_text(f"t = {time:.{self.digits}f} s")
        self.bed.draw_artist(self.label)
        if self.strip is not None:
            near = int(np.argmin(np.abs(self.flux.time - time)))
            self.marker.set_data([self.flux.time[near]], [self.flux.value[near]])
            self.strip.draw_artist(self.marker)
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def choose(n, most):
    return np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int))


def common_palette(frames):
    """Sixty colours of some frames, and exactly those of the grains, the ground, the marker and the letters."""
    from PIL import Image, ImageColor
    from matplotlib.colors import to_hex
    from picture import BLACK, FIXED, ORANGE, SPEED, WATER
    sample = np.concatenate([frames[k] for k in (0, len(frames) // 2, len(frames) - 1)])
    exact = np.array([ImageColor.getrgb(color)
                      for color in ("#FFFFFF", WATER, ORANGE, BLACK, FIXED, *map(to_hex, SPEED(np.linspace(0.0, 1.0, 24))))])
    found = Image.fromarray(sample).quantize(60, method=Image.Quantize.MEDIANCUT).getpalette()[:180]
    found = np.array(found).reshape(-1, 3)
    far = np.abs(found[:, None, :] - exact).max(axis=2).min(axis=1) > 10
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.concatenate([exact, found[far]]).ravel().tolist())
    return palette


def save_gif(frames, path, fps):
    """All frames share one palette; of a file that is too large, evenly chosen frames go."""
    from PIL import Image
    palette = common_palette(frames)
    pictures = [Image.fromarray(f).quantize(palette=palette, dither=Image.Dither.NONE) for f in frames]
    shown = pictures
    while True:
        duration = 1000.0 / fps * len(pictures) / len(shown)
        shown[0].save(path, format="GIF", save_all=True, append_images=shown[1:], duration=round(duration), loop=0)
        size = path.stat().st_size
        if size <= LARGEST or len(shown) <= 20:
            return path
        fewer = max(20, int(0.95 * len(shown) * LARGEST / size))
        shown = [pictures[k] for k in choose(len(pictures), fewer)]


def save_mp4(frames, path, fps):
    height, width = (2 * (size // 2) for size in frames[0].shape[:2])
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
               "-r", str(fps), "-i", "-", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", str(path)]
    data = b"".join(np.ascontiguousarray(frame[:height, :width]).tobytes() for frame in frames)
    done = subprocess.run(command, input=data, stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        raise ResultError(f"{path}: ffmpeg: {done.stderr.decode(errors='replace').strip()}")
    return path


def make(result, path, most=120, fps=20, width=500):
    indices = choose(len(result.frame_times), most)
    film = Film(result, indices, width)
    frames = [film.frame(int(index)) for index in indices]
    film.picture.plt.close(film.figure)
    return (save_mp4 if path.suffix == ".mp4" else save_gif)(frames, path, fps)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="result file")
    arguments.add_argument("-o", "--output", help="film to write, .gif or .mp4 (default: FILE.gif beside the result)")
    arguments.add_argument("-n", "--frames", type=int, default=120, help="at most so many frames (default: 120)")
    arguments.add_argument("--fps", type=float, default=20.0, help="frames per second (default: 20)")
    arguments.add_argument("--width", type=int, default=500, help="width in pixels (default: 500)")
    given = arguments.parse_args()
    if given.frames < 1 or not 0 < given.fps <= 100 or not 100 <= given.width <= 4000:
        arguments.error("allowed: --frames from 1, --fps to 100, --width 100 to 4000")
    with Result(given.file) as result:
        path = output_path(result, given.output, ".gif")
        if path.suffix not in (".gif", ".mp4"):
            arguments.error(f"{path}: a film ends in .gif or .mp4")
        if path.suffix == ".mp4" and not shutil.which("ffmpeg"):
            arguments.error("an .mp4 needs ffmpeg (Debian: apt install ffmpeg)")
        print(make(result, path, given.frames, given.fps, given.width))


if __name__ == "__main__":
    run(main)
