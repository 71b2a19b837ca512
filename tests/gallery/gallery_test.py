"""The gallery's scenes end as they should, with the quality promised; and its page has their pictures."""

import argparse
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPTIONS = None
CONTRACT_PER_CROSSED = 6  # new triangles a crossed one
CONTRACT_PER_STRIP = 40  # more, where it has a width: its ends and corners are finer than the edge length
CONTRACT_ASPECT = 5.5
MEAN_EDGE = (2 + 2 ** 0.5) / 3  # of a grid, over its spacing: a third of the edges are diagonals


def make(folder, *arguments):
    return subprocess.run([ROOT / "tests/gallery/make", "--kerfd", OPTIONS.kerfd, "--out", OPTIONS.work / folder, *arguments],
                          capture_output=True, text=True)


def figures_in(folder):
    return json.loads((OPTIONS.work / folder / "figures.json").read_text())


class Gallery(unittest.TestCase):
    def test_every_scene_is_on_the_page(self):
        page = json.loads((ROOT / "tests/gallery/gallery.json").read_text())
        entries = [entry for section in page["sections"] for entry in section["scenes"]]
        files = {entry["scene"]: ROOT / entry.get("file", f"tests/data/scenes/{entry['scene']}.json") for entry in entries}
        self.assertEqual(len(files), len(entries))
        self.assertLessEqual(set((ROOT / "tests/data/scenes").glob("*.json")), set(files.values()))
        for name, file in files.items():
            self.assertEqual(json.loads(file.read_text())["sheet_id"], name)

    def test_scenes_end_as_they_should(self):
        done = make("figures", "--no-pictures", "--only", OPTIONS.only)
        self.assertEqual(done.returncode, 0, done.stderr)
        figures = figures_in("figures")
        self.assertGreater(len(figures), 0)
        page = json.loads((ROOT / "tests/gallery/gallery.json").read_text())
        entries = {entry["scene"]: entry for section in page["sections"] for entry in section["scenes"]}
        for name, each in figures.items():
            with self.subTest(scene=name):
                self.assertEqual(each["faults"], [])
                self.assertEqual(each["refinement_stopped"], 0)
                strips = entries[name].get("strips", 0)
                more = each["triangles_after"] - each["triangles_before"]
                if strips == 0:
                    self.assertEqual(more, each["new_triangles"])
                    self.assertEqual(each["removed_m2"], 0)
                else:
                    self.assertLess(more, each["new_triangles"])
                    self.assertGreater(each["removed_m2"], 0)
                self.assertLessEqual(each["new_triangles"],
                                     entries[name].get("per_crossed", CONTRACT_PER_CROSSED) * each["crossed_triangles"]
                                     + CONTRACT_PER_STRIP * strips)
                self.assertLessEqual(each["deviation_of_edge"], 0.02 * MEAN_EDGE)
                if each["sharp_corners"] == 0 and not entries[name].get("bent"):
                    self.assertEqual(each["below_contract"], 0)
                    self.assertGreaterEqual(each["elsewhere_min_angle_deg"], 20 - 1e-6)
                    self.assertGreaterEqual(each["strands_min_angle_deg"], 10 - 1e-6)
                    if each["strands_min_angle_deg"] == 180:  # no strands, and so no needles between them
                        self.assertGreaterEqual(each["min_angle_deg"], 20 - 1e-6)
                        self.assertLessEqual(each["max_aspect"], CONTRACT_ASPECT)
        if OPTIONS.only == "":
            self.assertEqual(figures["kirigami-1000"]["cuts"], 1000)
            self.assertEqual(figures["kirigami-20"]["cuts"], 20)
            for name in ("partial", "cross", "cut-out", "overlap-single", "overlap-dual", "overlap-partial", "kerf-fold"):
                self.assertEqual(figures[name]["triangles_before"], 393)
            for name in ("straight", "curve", "zigzag", "flower"):
                self.assertEqual(figures[name]["triangles_before"], 4802)

    def test_the_page_has_pictures_and_figures(self):
        done = make("page", "--size", "120", "--only", "punch-c")
        self.assertEqual(done.returncode, 0, done.stderr)
        if "no pictures" in done.stderr:
            self.skipTest(done.stderr)
        pictures = {}
        for what in ("before", "after", "flat", "detail"):
            content = (OPTIONS.work / f"page/punch-circle-{what}.png").read_bytes()
            self.assertEqual(struct.unpack(">II", content[16:24]), (120, 120))
            pictures[what] = content
        self.assertEqual(len(set(pictures.values())), 4)
        page = (OPTIONS.work / "page/index.html").read_text()
        figures = figures_in("page")["punch-circle"]
        self.assertEqual(figures["pieces"], 2)
        for shown in ("punch-circle-after.png", f"{figures['new_triangles']:,}", f"{figures['min_angle_deg']:.1f}°",
                      f"{figures['max_aspect']:.1f}", f"{1000 * figures['deviation_m']:.2g} mm"):
            self.assertIn(shown, page)
        self.assertNotIn("wrong\">", page)

    def test_figures_are_the_same_each_time(self):
        def counted(folder):
            self.assertEqual(make(folder, "--no-pictures", "--only", "crossing-star").returncode, 0)
            star = figures_in(folder)["crossing-star"]
            return {key: value for key, value in star.items() if not key.endswith("_ms")}
        self.assertEqual(counted("once"), counted("twice"))

    def test_nothing_to_draw_is_told(self):
        done = make("nothing", "--only", "no such scene")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no scene has 'no such scene' in its name", done.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kerfd", required=True)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--only", default="", help="scenes with this in their name")
    OPTIONS, rest = parser.parse_known_args()
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    OPTIONS.work.mkdir(parents=True)
    unittest.main(argv=[sys.argv[0]] + rest)
