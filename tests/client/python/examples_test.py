"""The examples, each as a user would run it, with small numbers; and what they wrote."""

import csv
import importlib.util
import json
import os
import pathlib
import random
import re
import sys
import unittest
import unittest.mock

import kerf
import numpy
import support
from PIL import Image
from support import ROOT, Case, closed_port, path

EXAMPLES = ROOT / "client/python/examples"


def pixels(file):
    with Image.open(file) as picture:
        return numpy.asarray(picture).astype(int)


class ExampleCase(Case):
    def run_example(self, name, *arguments):
        done = support.run_python(EXAMPLES / name, "--server", support.ADDRESS, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(self.server.sheets()), 1)  # the test's own: what an example made, it deleted
        return done.stdout


class Examples(ExampleCase):
    def test_cut_example(self):
        told = self.run_example("cut_example.py", self.sheet.id)
        self.assertIn("status: APPLIED", told)
        self.assertIn("pieces: 2", told)

    def test_each_has_help_and_says_where_to_get_a_server(self):
        for example in sorted(EXAMPLES.glob("*.py")):
            if "argparse" not in example.read_text():
                continue  # a module of others
            with self.subTest(example=example.name):
                helped = support.run_python(example, "--help")
                self.assertEqual(helped.returncode, 0, helped.stderr)
                self.assertIn("--server", helped.stdout)
                done = support.run_python(example, "--server", closed_port(), cwd=support.OPTIONS.work)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("start one with deploy/run", done.stderr)

    def test_rollouts_from_one_state(self):
        told = self.run_example("rollouts.py", "--trials", 3, "--ticks", 20)
        self.assertIn("3 trials from tick 30", told)
        states = re.findall(r"state ([0-9a-f]{16})$", told, re.MULTILINE)
        self.assertEqual(len(set(states)), 4)
        self.assertIn("again: the same bits", told)

    def test_sweep_agrees_with_fracture_mechanics(self):
        told = self.run_example("sweep.py", "--lengths", 3, "--columns", 21, "--out", path("sweep"))
        self.assertIn("length/width", told)
        with open(path("sweep/sweep.csv"), newline="", encoding="utf-8") as file:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
        self.assertEqual([row["length_over_width"] for row in rows], [0.1, 0.4, 0.7])
        for row in rows:
            self.assertAlmostEqual(row["opening_m"] / row["expected_m"], 1, delta=0.03)
        plot = pixels(path("sweep/sweep.png"))[:, :, :3]
        self.assertGreater(min(plot.shape[:2]), 500)
        self.assertGreater(len(numpy.unique(plot.reshape(-1, 3), axis=0)), 20)

    def test_formula_of_the_sweep_is_as_good_as_it_says(self):
        spec = importlib.util.spec_from_file_location("sweep", EXAMPLES / "sweep.py")
        sweep = importlib.util.module_from_spec(spec)
        with unittest.mock.patch.object(sys, "path", [str(EXAMPLES), *sys.path]):
            spec.loader.exec_module(sweep)
        for case, share in (("05a_centre_slit_025", 0.25), ("05b_centre_slit_050", 0.5)):
            reference = json.loads((ROOT / f"tests/data/reference/{case}.json").read_text(encoding="utf-8"))
            profile = next(each for each in reference["quantities"] if each["name"] == "slit opening profile")
            opening_m = next(row[1] for row in profile["table"]["rows"] if row[0] == 0)
            self.assertAlmostEqual(sweep.expected_m(share) / opening_m, 1, delta=0.006, msg=case)
        self.assertAlmostEqual(sweep.tada(1e-6), 1, delta=1e-5, msg="a short slit opens as in an endless sheet")

    def test_robot_does_the_same_again(self):
        def run(*arguments):
            return self.run_example("robot.py", "--cuts", 6, "--vertices", 100, *arguments)

        first = run()
        seed = re.match(r"seed (\d+)\n", first).group(1)
        self.assertEqual(first, run("--seed", seed))
        self.assertRegex(first, r"state [0-9a-f]{16}; again with --seed " + seed)
        self.assertNotEqual(first, run("--seed", int(seed) + 1))
        outcomes = re.findall(r"^ +(\d+)  (?:\w+ cut|missed|refused, \w+)$", first, re.MULTILINE)
        self.assertEqual(sum(map(int, outcomes)), 6)


class Dataset(unittest.TestCase):
    def setUp(self):
        spec = importlib.util.spec_from_file_location("dataset", EXAMPLES / "dataset.py")
        self.dataset = importlib.util.module_from_spec(spec)
        with unittest.mock.patch.object(sys, "path", [str(EXAMPLES), *sys.path]):
            spec.loader.exec_module(self.dataset)
        self.sheet = unittest.mock.Mock()

    def cut(self):
        return self.dataset._cut_at_random(self.sheet, random.Random(1), 2)

    def test_a_server_that_is_gone_ends_it(self):
        for gone in (kerf.Unavailable("UNAVAILABLE", "", "gone"), kerf.NotFound("NOT_FOUND", "SHEET_NOT_FOUND", "gone")):
            self.sheet.cut.side_effect = gone
            with self.assertRaises(type(gone)):
                self.cut()

    def test_a_sheet_that_cannot_be_cut_is_given_up(self):
        self.sheet.cut.side_effect = kerf.InvalidArgument("INVALID_ARGUMENT", "NO", "no")
        with self.assertRaisesRegex(SystemExit, "0 of 2 cuts after 100 tries"):
            self.cut()


class Pictures(ExampleCase):
    def setUp(self):
        super().setUp()
        self.needs_renderer()

    def test_kirigami_opens(self):
        told = self.run_example("kirigami.py", "--rows", 4, "--columns", 3, "--vertices", 200, "--out", path("kirigami"))
        self.assertIn("14 slits", told)
        height, depth = map(float, re.search(r"height ([\d.]+) m of 0.4 m, depth ([\d.]+) m", told).groups())
        self.assertAlmostEqual(height, 0.48, delta=0.005)
        self.assertGreater(depth, 0.005)  # it left its plane
        names = ["pulled-1.png", "pulled-2.png", "pulled-3.png", "pulled-4.png", "slits.png", "strains.png"]
        self.assertEqual(sorted(os.listdir(path("kirigami"))), names)
        for name in names:
            self.assertEqual(pixels(path(f"kirigami/{name}")).shape[:2], (720, 720))

    def test_robot_draws_how_it_ends(self):
        self.run_example("robot.py", "--cuts", 2, "--vertices", 100, "--seed", 1, "--picture", path("robot.png"))
        self.assertEqual(pixels(path("robot.png")).shape[:2], (720, 720))

    def test_dataset_is_complete_and_taken_up_again(self):
        folder = pathlib.Path(path("dataset"))
        how = ("--size", 96, "--grid", 12, "--max-cuts", 2, "--out", folder)
        self.run_example("dataset.py", "--samples", 2, *how)
        before = {file: file.read_bytes() for file in folder.glob("*/*")}
        (folder / "labels/000001.json").unlink()
        self.assertIn("1 of 5 samples are there", self.run_example("dataset.py", "--samples", 5, *how))
        for file, content in before.items():
            self.assertEqual(file.read_bytes(), content, file)
        self.assertEqual((folder / "train.txt").read_text().split(), ["000000", "000001", "000002", "000003"])
        self.assertEqual((folder / "val.txt").read_text().split(), ["000004"])
        for number in range(5):
            self.check_sample(folder, f"{number:06d}")
        other = support.run_python(EXAMPLES / "dataset.py", "--server", support.ADDRESS, *how, "--seed", 2)
        self.assertEqual(other.returncode, 1)
        self.assertIn("was made with seed 1, not 2: take another --out", other.stderr)

    def check_sample(self, folder, name):
        label = json.loads((folder / f"labels/{name}.json").read_text())
        picture, mask = pixels(folder / f"images/{name}.png")[:, :, :3], pixels(folder / f"masks/{name}.png")
        self.assertEqual((picture.shape, mask.shape), ((96, 96, 3), (96, 96)))
        self.assertGreaterEqual(len(label["cuts"]), 1)
        for piece in label["pieces"]:
            self.assertEqual(piece["pixels"], (mask == piece["mask"]).sum())
        # The mask lies on the sheet: away from borders, what it calls background has the colours of the picture's background,
        # which change from a light one to a dark one.
        light, dark = (numpy.array(colour, dtype=float) for colour in ((0xFB, 0xFC, 0xFD), (0xD6, 0xDD, 0xE6)))
        share = numpy.clip((picture - light) @ (dark - light) / ((dark - light) @ (dark - light)), 0, 1)
        is_background = abs(picture - light - share[:, :, None] * (dark - light)).max(axis=2) < 12
        sure = numpy.ones(mask.shape, dtype=bool)
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            sure &= (numpy.roll(mask, step, axis) > 0) == (mask > 0)
        self.assertGreater((is_background == (mask == 0))[sure].mean(), 0.97)
