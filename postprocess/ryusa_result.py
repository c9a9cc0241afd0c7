# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""Reads a result of ryusa (OUT.h5, or OUT.h5.part of a run that goes on) into numpy arrays.

    from ryusa_result import Result
    result = Result("runs/flume.h5")
    flux = result.series("q_star")          # flux.time [s], flux.value, flux.unit
    x, z = result.frame("position", -1).T   # last frame, a row per grain
    print(result.diameter, result.parameter("fluid.shields"), result.flux)

All values are SI, grains in the order of their ids. Whatever is wrong with a file is a ResultError,
whose text is one line for the user.
"""
import argparse
import os
import sys
import time
from collections import namedtuple
from pathlib import Path

# A run that goes on holds a lock on its file; reading beside it does no harm.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
try:
    import h5py
    import numpy as np
except ImportError as missing:
    sys.exit(f"{Path(sys.argv[0]).name}: {missing} for {sys.executable}; Debian: apt install python3-h5py python3-matplotlib, "
             "which are for Debian's own python3")

BAD_USAGE, BAD_FILE = 2, 4
UNEXPECTED = (KeyError, RuntimeError, ValueError, IndexError, TypeError)  # what a file with other contents leads to
GRAINS = "particles/grains"

Series = namedtuple("Series", "time value unit")


class ResultError(Exception):
    """A file that is missing, is no result of ryusa or lacks something; one line for the user."""


def _text(value):
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


class Result:
    """One result file. Arrays over time are read when asked for."""

    def __init__(self, path):
        self.path = Path(path)
        self._file = self._open()
        self._need(GRAINS + "/diameter")
        self.diameter = self._array(GRAINS + "/diameter")
        self.n = len(self.diameter)
        self.fixed = self._array(GRAINS + "/fixed").astype(bool) if self.has("fixed") else np.zeros(self.n, bool)
        moving = ~self.fixed if (~self.fixed).any() else np.ones(self.n, bool)
        # The unit of lengths: mean diameter of the grains that can move.
        self.d = float(self.diameter[moving].mean()) if self.n else float("nan")
        self.density = float(self._array(GRAINS + "/density")[moving].mean()) if self.has("density") else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    def _open(self):
        path = self.path
        if not path.exists():
            part = path.with_name(path.name + ".part")
            hint = f"; the run has not finished: {part} is there" if part.exists() else ""
            raise ResultError(f"{path}: no such file{hint}")
        if path.is_dir():
            raise ResultError(f"{path}: a folder, not a result file")
        try:
            file = h5py.File(path, "r")
        except PermissionError:
            raise ResultError(f"{path}: permission denied") from None
        except OSError:
            raise ResultError(f"{path}: not an HDF5 file, or damaged") from None
        if "h5md" not in file or "parameters" not in file or GRAINS not in file:
            program = str(_text(file.attrs.get("program", "")))
            file.close()
            name = program.removeprefix("ryusa ")
            if name != program and Path(__file__).with_name(f"{name}.py").exists():
                raise ResultError(f"{path}: the table of a ryusa {name}, not the result of a run; "
                                  f"postprocess/{name}.py draws it")
            raise ResultError(f"{path}: an HDF5 file, but not a result of ryusa")
        return file

    def _need(self, name):
        if name not in self._file:
            raise ResultError(f"{self.path}: holds no /{name}")
        return self._file[name]

    def _array(self, name):
        return np.asarray(self._need(name)[()])

    @property
    def stem(self):
        """The file's name without .h5 or .h5.part: what pictures are named after."""
        name = self.path.name
        for ending in (".part", ".h5"):
            name = name[:-len(ending)] if name.endswith(ending) and name != ending else name
        return name

    @property
    def title(self):
        return str(self.parameter("title", "") or "")

    # --- parameters ---

    def parameter(self, key, default=None):
        """A parameter, "section.key"; `default` if the file has none or it follows from others."""
        value = _text(self._file["parameters"].attrs.get(key, default))
        if isinstance(value, (float, np.floating)) and not np.isfinite(value):
            return default
        return value

    @property
    def has_fluid(self):
        return self.parameter("fluid.model", "none") != "none"

    def _weight(self):
        """(rho_s - rho_f) g d [Pa]."""
        density = self.density if self.density is not None else self.parameter("grains.density", 2650.0)
        return (density - self.parameter("fluid.density", 1000.0)) * self.parameter("domain.gravity", 9.81) * self.d

    @property
    def shields(self):
        """theta, or None without a fluid."""
        theta, stress = self.parameter("fluid.shields"), self.parameter("fluid.shear_stress")
        if not self.has_fluid or (theta is None and stress is None):
            return None
        return float(theta) if theta is not None else float(stress / self._weight())

    @property
    def shear_stress(self):
        """tau_b [Pa], or None without a fluid."""
        stress, theta = self.parameter("fluid.shear_stress"), self.shields
        if theta is None:
            return None
        return float(stress) if stress is not None else theta * self._weight()

    @property
    def length(self):
        """Length of a periodic domain [m]; None if it is not periodic."""
        box = self._file.get(GRAINS + "/box")
        if box is None or "edges" not in box:
            return None
        boundary = [_text(word) for word in np.atleast_1d(box.attrs.get("boundary", []))]
        edge = float(np.atleast_1d(box["edges"][()])[0])
        return edge if boundary and boundary[0] == "periodic" and edge > 0 else None

    # --- over time ---

    def has(self, name):
        """Whether there is an array of the grains ("velocity") or an observable ("q_star", "profile")."""
        return f"{GRAINS}/{name}" in self._file or f"observables/{name}" in self._file

    def series(self, name):
        """An observable over time."""
        group = self._need(f"observables/{name}")
        value = group["value"]
        n = min(len(value), len(group["time"]))  # a file that is being written may be ahead in one
        if n == 0:
            raise ResultError(f"{self.path}: /observables/{name} has no samples yet")
        return Series(group["time"][:n], value[:n], _text(value.attrs.get("unit", "1")))

    @property
    def frame_times(self):
        group = self._need(f"{GRAINS}/position")
        n = min(len(group["value"]), len(group["time"]))
        if n == 0:
            raise ResultError(f"{self.path}: there are no frames yet")
        return group["time"][:n]

    def frame(self, name, index):
        """One frame of "position", "velocity" (a row x, z per grain) or "spin"."""
        value = self._need(f"{GRAINS}/{name}/value")
        return np.asarray(value[index if index >= 0 else len(self.frame_times) + index])

    def speed(self, index):
        """Speeds of the grains [m/s]; zeros if the file has no velocities."""
        if not self.has("velocity"):
            return np.zeros(self.n)
        return np.hypot(*self.frame("velocity", index).T)

    # --- results ---

    @property
    def flux(self):
        """Mean and error of q* as a dict; empty if they are not written yet, or rest on no sample."""
        group = self._file.get("observables/flux")
        found = {} if group is None else {key: _text(value) for key, value in group.attrs.items()}
        return found if np.isfinite(found.get("q_star_mean", np.nan)) and found.get("samples", 1) > 0 else {}

    @property
    def profile(self):
        """Mean profiles: a dict of z, phi, u_grain, ... [SI]."""
        group = self._need("observables/profile")
        if "z" not in group or len(group["z"]) == 0:
            raise ResultError(f"{self.path}: /observables/profile is empty")
        return {name: np.asarray(group[name][()], float) for name in group if isinstance(group[name], h5py.Dataset)}

    def fluid_velocity(self, index):
        """z, u of the fluid in the frame `index`, else its mean; None if the file has neither."""
        if not self.has("profile"):
            return None
        profile = self.profile
        z, mean = profile["z"], profile.get("u_fluid")
        series = self._file.get("observables/profile_series/u_fluid")
        if series is not None and len(series["time"]) > 0:
            when = self.frame_times[index]
            row = int(np.argmin(np.abs(series["time"][()] - when)))
            if row < len(series["value"]) and series["value"].shape[1] == len(z):
                return z, np.asarray(series["value"][row])
        return None if mean is None else (z, mean)

    def bed_level(self, time=None):
        """Height of the bed [m] at a time, else its mean since equilibration; None if not there."""
        if not self.has("bed_level"):
            return None
        series = self.series("bed_level")
        if time is not None:
            return float(series.value[np.argmin(np.abs(series.time - time))])
        behind = series.time >= self.flux.get("equilibration_time", 0.0)
        level = series.value[behind] if behind.any() else series.value[-1:]
        return float(np.nanmean(level)) if np.isfinite(level).any() else None


# --- the frame of every script ---

def parser(description, **options):
    return argparse.ArgumentParser(description=description.strip().split("\n\n")[0], **options)


def with_error(value, error):
    """"2.04 ± 0.04": the error with two digits if it begins with 1, else one, the value as far; "1.6e-10 ± 1.8e-10"."""
    if not (np.isfinite(error) and error > 0.0):
        return f"{value:.4g}"
    digits = int(np.floor(np.log10(error)))
    digits -= error < 1.95 * 10.0 ** digits
    places = max(0, -digits)
    if places > 5:
        return f"{value:.2g} ± {error:.2g}"
    return f"{value:.{places}f} ± {error:.{places}f}"


def output_path(result, given, ending):
    """Where a picture goes: what was given, else beside the result."""
    return Path(given) if given else result.path.with_name(result.stem + ending)


def run(main):
    """Calls main() and ends the program: 0, 2 for the command line, 4 with one line for a bad file. What a run has
    written to between two reads fails in some way: then once more, twice at most."""
    name = Path(sys.argv[0]).name
    goes_on = any(word.endswith(".part") for word in sys.argv[1:])
    for wait in (0.3, 1.0, 0.0) if goes_on else (0.0,):
        try:
            sys.exit(main())
        except ResultError as error:
            text = str(error)
        except KeyboardInterrupt:
            sys.exit(130)
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            text = f"{where}{error.strerror or error}"
        except UNEXPECTED as error:
            text = f"the file does not hold what is expected: {error}"
        time.sleep(wait)
    print(f"{name}: " + " ".join(text.split()), file=sys.stderr)
    sys.exit(BAD_FILE)
