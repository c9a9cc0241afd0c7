#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# ctest: slow
"""The scripts of postprocess/ on a made-up result, on a short real one, and on files that are no results.

Pictures must exist, have a sensible size and show something; whatever is wrong ends in one line and
exit code 4 (files) or 2 (command line), never in a traceback."""
import os
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

try:
    import h5py
    import numpy as np
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-h5py python3-matplotlib)")
    sys.exit(77)

ROOT = Path(os.environ.get("SOURCE_DIR", Path(__file__).resolve().parent.parent))
SCRIPTS = ROOT / "postprocess"
sys.path[:0] = [str(ROOT / "tests"), str(SCRIPTS)]
import ryusa_result  # noqa: E402
import synthetic_result  # noqa: E402
from ryusa_result import Result, ResultError, with_error  # noqa: E402

SINGLE = {"flux.py": "-flux.png", "profiles.py": "-profiles.png", "bed.py": "-bed.png",
          "relations.py": "-relations.png", "animate.py": ".gif"}


def call(script, *arguments, cwd=None):
    return subprocess.run([sys.executable, "-B", str(SCRIPTS / script), *map(str, arguments)], cwd=cwd,
                          capture_output=True, text=True, timeout=120, check=False)


class PostprocessTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.home = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.home.name)
        cls.file = cls.folder / "flume.h5"
        synthetic_result.write(cls.file)

    @classmethod
    def tearDownClass(cls):
        cls.home.cleanup()

    def check_picture(self, path, least=(500, 250)):
        self.assertTrue(path.exists(), path)
        with Image.open(path) as image:
            width, height = image.size
            self.assertTrue(least[0] <= width <= 3000 and least[1] <= height <= 3000, image.size)
            pixels = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(int)
        self.assertGreater(len(np.unique(pixels, axis=0)), 20, f"{path} has few colours")
        ink = (pixels.min(axis=1) < 200).mean()
        self.assertTrue(0.01 < ink < 0.9, f"{path}: {ink:.3f} of it is inked")

    def check_film(self, path, frames):
        with Image.open(path) as film:
            self.assertEqual(film.n_frames, frames)
            first = np.asarray(film.convert("RGB")).astype(int)
            film.seek(frames - 1)
            last = np.asarray(film.convert("RGB")).astype(int)
        self.assertGreater(np.abs(first - last).max(axis=2).astype(bool).mean(), 0.005, "nothing moves")
        self.assertLess(path.stat().st_size, 3_100_000)

    def check_refused(self, result, code, *words):
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        if code == 4:
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)

    # --- what works ---

    def test_each_script(self):
        for script, ending in SINGLE.items():
            with self.subTest(script):
                done = call(script, self.file)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(done.stderr, "")
                self.check_picture(self.folder / ("flume" + ending), (300, 200))

    def test_output_names(self):
        for script, name in (("flux.py", "a.png"), ("bed.py", "b.pdf"), ("animate.py", "c.gif")):
            with self.subTest(script):
                path = self.folder / name
                done = call(script, self.file, "-o", path)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertGreater(path.stat().st_size, 1000)

    def test_all(self):
        folder = self.folder / "new" / "pictures"
        done = call("all.py", self.file, "-o", folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        for ending in SINGLE.values():
            self.check_picture(folder / ("flume" + ending), (300, 200))
        self.check_film(folder / "flume.gif", 60)
        self.assertEqual(len(list(folder.iterdir())), len(SINGLE))

    def test_relative_path(self):
        done = call("flux.py", "flume.h5", cwd=self.folder)
        self.assertEqual((done.returncode, done.stdout.strip()), (0, "flume-flux.png"), done.stderr)

    def test_part_file(self):
        """A run that goes on: no mean, no profiles yet."""
        path = self.folder / "early.h5.part"
        synthetic_result.write(path, frames=5, samples=50)
        with h5py.File(path, "a") as file:
            del file["observables/flux"], file["observables/profile"]
        done = call("all.py", path)
        self.assertEqual(done.returncode, 0, done.stderr)
        for ending in ("-flux.png", "-bed.png", ".gif"):
            self.check_picture(self.folder / ("early" + ending), (300, 200))
        self.assertIn("early-profiles.png: left out", done.stdout)
        self.check_refused(call("profiles.py", path), 4, "/observables/profile")
        self.check_refused(call("relations.py", path), 4, "flux")
        self.check_refused(call("flux.py", self.folder / "early.h5"), 4, "not finished", "early.h5.part")

    def test_dry(self):
        path = self.folder / "dry.h5"
        synthetic_result.write(path, fluid=False)
        done = call("all.py", path)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.check_picture(self.folder / "dry-bed.png")
        self.assertFalse((self.folder / "dry-relations.png").exists())
        self.check_refused(call("relations.py", path), 4)

    def test_no_fluid_no_panel(self):
        """A dry result has a profile of the fluid, which is 0."""
        sizes = []
        for name, fluid in (("still.h5", False), ("flows.h5", True)):
            path = self.folder / name
            synthetic_result.write(path, frames=2, fluid=fluid)
            self.assertEqual(call("bed.py", path).returncode, 0)
            with Image.open(path.with_name(path.stem + "-bed.png")) as image:
                sizes.append(image.size[0])
        self.assertLess(sizes[0], sizes[1])

    def test_no_grain_in_the_profile(self):
        """All have fallen out of a scene without floor."""
        path = self.folder / "fallen.h5"
        synthetic_result.write(path, frames=2)
        with h5py.File(path, "a") as file:
            for name, value in (("phi", 0.0), ("u_grain", 0.0), ("tau_grain", 0.0), ("u_fluid", np.nan)):
                file["observables/profile"][name][...] = value
        done = call("profiles.py", path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_all_goes_on(self):
        path = self.folder / "odd.h5"
        synthetic_result.write(path, frames=2)
        with h5py.File(path, "a") as file:
            del file["observables/profile/phi"]
            file["observables/profile/phi"] = [0.5, 0.5]
        done = call("all.py", path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("odd-profiles.png: left out, the file does not hold", done.stdout)
        for ending in ("-flux.png", "-bed.png", "-relations.png", ".gif"):
            self.check_picture(self.folder / ("odd" + ending), (300, 200))

    def test_flux_not_known(self):
        """A run that ends before its flow is under way: 0 of no samples, or not a number."""
        path = self.folder / "unknown.h5"
        for mean, samples in ((0.0, 0), (float("nan"), 7)):
            synthetic_result.write(path, frames=2)
            with h5py.File(path, "a") as file:
                file["observables/flux"].attrs.update({"q_star_mean": mean, "samples": samples})
            self.check_refused(call("relations.py", path), 4, "unknown.h5", "not known")
            done = call("relations.py", path, self.file, "-o", self.folder / "known.png")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("unknown.h5: q* is not known", done.stderr)
            done = call("all.py", path)
            self.assertIn("unknown-relations.png: left out", done.stdout)

    def test_no_motion(self):
        """q* = 0 has no place on a logarithmic scale, and no speed range."""
        path = self.folder / "rest.h5"
        synthetic_result.write(path, frames=3)
        with h5py.File(path, "a") as file:
            file["observables/flux"].attrs["q_star_mean"] = 0.0
            file["observables/flux"].attrs["q_star_standard_error"] = 0.0
            for name in ("observables/q_star/value", "particles/grains/velocity/value"):
                file[name][...] = 0.0
        done = call("all.py", path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.check_picture(self.folder / "rest-relations.png")

    def test_single_frame_and_sample(self):
        path = self.folder / "one.h5"
        synthetic_result.write(path, frames=1, samples=2)
        done = call("all.py", path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_not_periodic_and_few_fields(self):
        path = self.folder / "few.h5"
        synthetic_result.write(path, frames=4)
        with h5py.File(path, "a") as file:
            file["particles/grains/box"].attrs["boundary"] = ["none", "none"]
            del file["particles/grains/velocity"], file["observables/bed_level"]
        done = call("all.py", path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.check_picture(self.folder / "few-bed.png")

    def test_bed_at_a_time(self):
        for when in ("0", "3.1", "6"):
            self.assertEqual(call("bed.py", self.file, "-t", when, "-o", self.folder / "t.png").returncode, 0)
        for when in ("99", "-1", "nan"):
            self.check_refused(call("bed.py", self.file, "-t", when), 2, "flume.h5", "0 to 6 s")

    def test_relations_of_several_files(self):
        other = self.folder / "other.h5"
        synthetic_result.write(other, seed=2, frames=2)
        with h5py.File(other, "a") as file:
            file["parameters"].attrs["fluid.shields"] = 0.8
        points = self.folder / "points.csv"
        points.write_text("run,theta,q_star\n1,0.1,0.05\n2,0.2,0.4\n", encoding="utf-8")
        path = self.folder / "both.png"
        for more in ((), ("--all",), ("-r", "parker", "-r", "yalin"), ("-p", points)):
            done = call("relations.py", self.file, other, "-o", path, *more)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.check_picture(path)
        listed = call("relations.py", "--list")
        self.assertEqual(len(listed.stdout.splitlines()), 19)
        self.check_refused(call("relations.py", self.file, "-r", "no-such"), 2, "no-such", "wong-parker")
        points.write_text("a,b\n1,2\n", encoding="utf-8")
        self.check_refused(call("relations.py", self.file, "-p", points), 4, "theta")

    def test_film_options(self):
        path = self.folder / "short.gif"
        done = call("animate.py", self.file, "-o", path, "-n", "7", "--width", "300")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.check_film(path, 7)
        for bad in (("-n", "0"), ("--fps", "-1"), ("--width", "7"), ("-o", "film.avi")):
            self.check_refused(call("animate.py", self.file, *bad), 2)

    def test_large_film_stays_small(self):
        path = self.folder / "large.h5"
        synthetic_result.write(path, frames=600, samples=6000)
        start = time.monotonic()
        done = call("all.py", path)
        print(f"all.py, 220 grains x 600 frames: {time.monotonic() - start:.1f} s")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLess((self.folder / "large.gif").stat().st_size, 3_100_000)
        self.assertLess(time.monotonic() - start, 60.0)

    # --- what is refused ---

    def test_help(self):
        for script in [*SINGLE, "all.py"]:
            done = call(script, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn("usage", done.stdout)

    def test_bad_command_line(self):
        for script in [*SINGLE, "all.py"]:
            self.check_refused(call(script, self.file, "--no-such-option"), 2, "usage")
        self.check_refused(call("all.py"), 2, "usage")
        self.check_refused(call("relations.py"), 2, "usage")
        self.check_refused(call("bed.py", self.file, "-t", "soon"), 2)

    def test_bad_files(self):
        text, empty, foreign, cut = (self.folder / name for name in ("text.h5", "empty.h5", "foreign.h5", "cut.h5"))
        text.write_text("no HDF5\n", encoding="utf-8")
        empty.touch()
        with h5py.File(foreign, "w") as file:
            file["x"] = 1
        cut.write_bytes(self.file.read_bytes()[:5000])
        cases = ((self.folder / "missing.h5", "no such file"), (text, "not an HDF5 file"),
                 (empty, "not an HDF5 file"), (foreign, "not a result of ryusa"), (cut, "damaged"),
                 (self.folder, "folder"))
        for script in [*SINGLE, "all.py"]:  # all of them read by the same code
            for path, word in cases if script == "all.py" else cases[:1]:
                with self.subTest(f"{script} {path.name}"):
                    self.check_refused(call(script, path), 4, word)

    def test_tables_are_named(self):
        path = self.folder / "table.h5"
        for program, word in (("ryusa sweep", "postprocess/sweep.py"), ("ryusa tune", "postprocess/tune.py"),
                              ("ryusa threshold", "not a result of ryusa")):
            with h5py.File(path, "w") as file:
                file.attrs["program"] = program
            self.check_refused(call("flux.py", path), 4, "table.h5", word)
        self.check_refused(call("all.py", path), 4, "table.h5")

    def test_lacking_fields(self):
        for script, gone in (("flux.py", "observables/q_star"), ("profiles.py", "observables/profile"),
                             ("bed.py", "particles/grains/position"), ("animate.py", "particles/grains/position"),
                             ("relations.py", "observables/flux"), ("bed.py", "particles/grains/diameter")):
            path = self.folder / "lacking.h5"
            synthetic_result.write(path, frames=2)
            with h5py.File(path, "a") as file:
                del file[gone]
            with self.subTest(f"{script} without {gone}"):
                self.check_refused(call(script, path), 4, gone.rsplit("/", 1)[1])

    def test_output_cannot_be_written(self):
        self.check_refused(call("flux.py", self.file, "-o", self.folder / "no" / "such" / "a.png"), 4)
        self.check_refused(call("all.py", self.file, "-o", self.file), 4)

    # --- the reader ---

    def test_reader(self):
        with Result(self.file) as result:
            self.assertEqual((result.n, int(result.fixed.sum()), result.stem), (220, 20, "flume"))
            self.assertAlmostEqual(result.shields, 0.4)
            self.assertAlmostEqual(result.shear_stress, 0.4 * 1650.0 * 9.81 * result.d)
            self.assertEqual(result.length, synthetic_result.LENGTH)
            self.assertEqual(len(result.frame_times), 60)
            self.assertEqual(result.frame("position", -1).shape, (220, 2))
            self.assertEqual(result.series("q_star").unit, "1")
            self.assertIsNone(result.parameter("fluid.shear_stress"))  # not a number: follows from others
            with self.assertRaises(ResultError):
                result.series("nothing")

    def test_rounding(self):
        for value, error, text in ((2.0371, 0.04, "2.04 ± 0.04"), (0.28081, 0.0119, "0.281 ± 0.012"),
                                   (1234.5, 20.0, "1234 ± 20"), (3.0, 0.0, "3"), (3.0, float("nan"), "3"),
                                   (5.0, 0.0999, "5.00 ± 0.10"), (5.0, 0.0196, "5.00 ± 0.02"),
                                   (1.62e-10, 1.81e-10, "1.6e-10 ± 1.8e-10")):
            self.assertEqual(with_error(value, error), text)

    def test_unit_and_walls(self):
        import picture
        for d, unit, right in ((0.5e-3, "mm", 10.0), (225.0, "m", 0.01)):
            figure, axes = picture.plt.subplots()
            parameters = {"domain.walls": 1, "domain.length": 0.01, "domain.floor": "flat"}
            one = SimpleNamespace(d=d, has_fluid=False, parameter=lambda key, default=None: parameters.get(key, default))
            picture.setup_bed_axes(axes, one, (0.0, 0.01, 0.0, 0.01))
            self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), (f"x ({unit})", f"z ({unit})"))
            self.assertEqual([line.get_xdata()[0] for line in axes.get_lines()], [0.0, right, 0.0])
            parameters.clear()
            picture.setup_bed_axes(axes, one, (0.0, 0.01, 0.0, 0.01))
            self.assertEqual(len(axes.get_lines()), 3)
            picture.plt.close(figure)

    def test_unit_of_the_flux(self):
        import flux
        import picture
        for fluid in (True, False):
            path = self.folder / "unit.h5"
            synthetic_result.write(path, frames=2, fluid=fluid)
            with Result(path) as result, mock.patch.object(picture, "save", lambda figure, _: figure):
                figure = flux.make(result, None)
            self.assertEqual("(s-1)" in figure.axes[0].get_ylabel(), fluid)
            picture.plt.close(figure)

    def test_time_in_a_film_of_milliseconds(self):
        import animate
        path = self.folder / "fast.h5"
        for end, digits in ((6.0, 2), (1e-3, 4)):
            synthetic_result.write(path, frames=11, end=end)
            with Result(path) as result:
                film = animate.Film(result, animate.choose(11, 11), 400)
                film.frame(10)
                self.assertEqual(film.label.get_text(), f"t = {end:.{digits}f} s")

    def test_a_file_that_is_written_to(self):
        """Reads of a run that goes on may meet a flush: once more; of any other file not."""
        for name, tries in (("one.h5.part", 2), ("one.h5", 1)):
            fails = mock.Mock(side_effect=[OSError("Can't read data (addr overflow)"), None])
            with mock.patch.object(sys, "argv", ["flux.py", name]), mock.patch("sys.stderr"), \
                    mock.patch("time.sleep"), self.assertRaises(SystemExit) as end:
                ryusa_result.run(fails)
            self.assertEqual((fails.call_count, end.exception.code or 0), (tries, 0 if tries > 1 else 4))

    # --- where words lie in a picture ---

    def test_legends_of_a_tuning_hide_nothing(self):
        import picture
        import tune
        value, time = np.geomspace(10.0, 320.0, 11), np.linspace(0.1, 0.3, 11)
        settling = SimpleNamespace(
            key="alpha_m", value=value, settling_time=time, settling_time_error=0.1 * time,
            settling_time_coarse=0.5 * time, settling_time_coarse_error=0.1 * time, soonest_low=10.0, soonest_high=20.0, ours=40.0, clear=False,
            curve={k: np.linspace(6.6, 5.5, 50) for k in range(11)}, time=lambda k: 0.005 * np.arange(50))
        figure = picture.plt.figure(figsize=(8.0, 3.4), layout="constrained")
        tune.draw_settling(figure, settling, picture)
        figure.canvas.draw()
        for axes in figure.axes:
            legend = axes.get_legend().get_window_extent()
            self.assertGreaterEqual(legend.y0, axes.bbox.y1)
            self.assertTrue(figure.bbox.x0 <= legend.x0 and legend.x1 <= figure.bbox.x1, legend)
        picture.plt.close(figure)

    def test_legend_of_one_bounce(self):
        """Of a file of `ryusa verify slow-bounce`: one panel, as wide as the legend of seven laws is not."""
        import picture
        import verify
        figure, axes = picture.plt.subplots(figsize=(4.4, 3.6), layout="constrained")
        for law in verify.LAWS:
            axes.plot([1, 2], [0.4, 0.5], **verify.style(law))
        axes.set_xlabel("N")
        verify.legend(figure, axes)
        figure.canvas.draw()
        words = figure.legends[0].get_window_extent()
        self.assertTrue(figure.bbox.x0 <= words.x0 and words.x1 <= figure.bbox.x1, words)
        self.assertTrue(figure.bbox.y0 <= words.y0 and words.y1 <= axes.get_tightbbox().y0, words)
        picture.plt.close(figure)

    def test_names_of_constants(self):
        from tune import label_of
        keys = ["contact.beta", "contact.friction", "fluid.density", "grains.density"]
        self.assertEqual([label_of(key, keys) for key in keys], ["β", "friction", "fluid.density", "grains.density"])

    # --- the program itself ---

    @unittest.skipUnless("RYUSA" in os.environ, "needs the program")
    def test_real_run(self):
        path = self.folder / "real.h5"
        done = subprocess.run([os.environ["RYUSA"], "run", str(ROOT / "params/flume.yaml"), "-o", str(path), "--quiet",
                               "-s", "time.end=0.8 s", "-s", "grains.layers=5", "-s", "fluid.shields=0.8"],
                              capture_output=True, text=True, timeout=200, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = call("all.py", path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertNotIn("left out", done.stdout)
        with Result(path) as result:
            self.assertAlmostEqual(result.shields, 0.8)
            self.assertTrue(result.flux and result.length)
            self.assertAlmostEqual(result.series("q_star").time[-1], 0.8)
            self.assertIsNotNone(result.fluid_velocity(-1))


if __name__ == "__main__":
    unittest.main()
