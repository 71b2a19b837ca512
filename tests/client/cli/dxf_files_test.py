"""DXF files that ezdxf writes, of several releases: `kerf inspect` finds the lines that ezdxf itself finds in them."""

import json
import math
import pathlib

import ezdxf
from ezdxf import path as paths

from cli_case import Case, kerf, main, path, setUpModule, tearDownModule

LINE, ARC, BULGED, CIRCLE = 2.0, 0.5 * math.pi * 3, 2 * math.pi, 2 * math.pi * 1.5


def drawing(release):
    """A drawing in millimetres with every entity that is read; returns it with the expected length of its visible lines."""
    file = ezdxf.new(release, setup=True, units=4)
    for name, colour in (("Cut", 1), ("Fold", 5), ("Off", 3), ("Frozen", 4)):
        file.layers.add(name, color=colour)
    file.layers.get("Off").off()
    file.layers.get("Frozen").freeze()
    model = file.modelspace()
    model.add_line((0, 0), (2, 0), dxfattribs={"layer": "Cut"})
    model.add_arc((0, 0), 3, 0, 90, dxfattribs={"layer": "Cut"})
    model.add_circle((5, 5), 1.5, dxfattribs={"layer": "Fold"})
    model.add_circle((5, 5), 100, dxfattribs={"layer": "Off"})
    model.add_line((0, 0), (500, 0), dxfattribs={"layer": "Frozen"})
    model.add_polyline2d([(0, 0, 1), (2, 0, 1)], format="xyb", close=True, dxfattribs={"layer": "Cut"})
    block = file.blocks.new("PART", base_point=(1, 1))
    block.add_line((1, 1), (3, 1))
    model.add_blockref("PART", (20, 20), dxfattribs={
        "layer": "Fold", "xscale": 2, "yscale": 3, "rotation": 30, "row_count": 2, "column_count": 3, "row_spacing": 5, "column_spacing": 7})
    model.add_text("words")
    length = LINE + ARC + CIRCLE + BULGED + 6 * 4
    if release != "R12":
        model.add_lwpolyline([(0, 10), (4, 10), (4, 13)], close=True, dxfattribs={"layer": "Cut"})
        ellipse = model.add_ellipse((30, 0), (4, 0), 0.5, 0, 1.5, dxfattribs={"layer": "Cut"})
        spline = model.add_spline(dxfattribs={"layer": "Cut"})
        spline.set_open_uniform([(0, 20, 0), (3, 25, 0), (6, 20, 0), (9, 24, 0), (12, 20, 0)])
        rational = model.add_spline(dxfattribs={"layer": "Cut"})
        rational.set_open_rational([(0, 40, 0), (3, 45, 0), (6, 40, 0), (9, 44, 0)], [1, 2, 0.5, 1], degree=3)
        quintic = model.add_spline(dxfattribs={"layer": "Cut"})
        quintic.set_open_uniform([(0, 50, 0), (3, 55, 0), (6, 50, 0), (9, 54, 0), (12, 50, 0), (13, 52, 0), (15, 50, 0)], degree=5)
        length += 12
        length += sum(length_of(entity) for entity in (ellipse, spline, rational, quintic))
    return file, length


def length_of(entity):
    points = list(paths.make_path(entity).flattening(1e-6, segments=64))
    return sum((b - a).magnitude for a, b in zip(points, points[1:]))


class Files(Case):
    def test_lines_and_layers_of_each_release(self):
        for release in ("R12", "R2000", "R2004", "R2007", "R2010", "R2013", "R2018"):
            with self.subTest(release):
                file, length = drawing(release)
                file.saveas(path("made.dxf"))
                report = json.loads(kerf("--json", "inspect", path("made.dxf"), server=False).stdout)
                self.assertEqual(report["format"], "DXF " + file.dxfversion)
                self.assertAlmostEqual(1e3 * report["length_m"], length, delta=5e-3)  # ezdxf's own curves are approximate
                names = [group["selector"] for group in report["groups"] if group["selector"].startswith("layer=")]
                self.assertEqual(sorted(names), ["layer=Cut", "layer=Fold", "layer=Frozen", "layer=Off"])
                self.assertEqual([warning for warning in report["warnings"] if "TEXT" in warning], ["DXF: 1 x TEXT: not cut"])
                red = json.loads(kerf("--json", "inspect", path("made.dxf"), "--only", "stroke=blue", server=False).stdout)
                self.assertAlmostEqual(1e3 * red["length_m"], CIRCLE + 24, delta=1e-3)

    def test_units_and_mirrored_planes(self):
        file = ezdxf.new("R2010", units=1)
        file.modelspace().add_circle((1, 2), 1, dxfattribs={"extrusion": (0, 0, -1)})
        file.saveas(path("inches.dxf"))
        report = json.loads(kerf("--json", "inspect", path("inches.dxf"), server=False).stdout)
        self.assertAlmostEqual(report["min"]["x"], -2 * 0.0254)
        self.assertAlmostEqual(report["max"]["y"], 3 * 0.0254)

    def test_binary_files_are_refused_by_name(self):
        file, _ = drawing("R2010")
        file.saveas(path("binary.dxf"), fmt="bin")
        refused = kerf("--json", "inspect", path("binary.dxf"), server=False)
        self.assertEqual(json.loads(refused.stderr)["error"]["reason"], "DXF_BINARY")
        self.assertGreater(pathlib.Path(path("binary.dxf")).stat().st_size, 1000)


if __name__ == "__main__":
    main(__doc__)
