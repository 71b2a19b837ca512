"""Every kind of curve, cut with every option."""

import math
import pathlib

import kerf
from support import Case, path

RING = ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><g transform="translate(50 50)">'
        '<circle r="40"/><circle r="20"/></g><text>ring</text></svg>')


class Curves(Case):
    def test_points_come_one_by_one_or_as_an_array(self):
        import numpy as np
        line, curve = [(-0.1, 0.3), (1.1, 0.35)], [(0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5)]
        weighted = [(-0.1, 0.9, 1), (0.5, 0.5, 3), (1.1, 0.9, 1)]
        for make, points in ((kerf.polyline, line), (kerf.bezier, curve), (kerf.rational, weighted)):
            expected = make(*points)
            for given in (points, tuple(points), np.array(points), np.array(points, dtype=np.float64).tolist()):
                self.assertEqual(make(given), expected)
                self.assertEqual(make(*given), expected)
        self.assertAlmostEqual(kerf.polyline(np.array(line, dtype=np.float32)).polyline.points[1].x, 1.1, places=6)
        for wrong in ((), (1, 2), ((1, 2, 3), (4, 5, 6)), ("ab",), (None, None), ((1, 2), (3,)), (np.zeros((2, 2, 2)),)):
            with self.subTest(wrong), self.assertRaisesRegex(ValueError, "points must be"):
                kerf.polyline(*wrong)

    def test_polyline_bezier_and_circle(self):
        self.assertEqual(self.pieces_after(kerf.polyline((-0.1, 0.3), (1.1, 0.35))), 2)
        self.assertEqual(self.pieces_after(kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5))), 2)
        self.assertEqual(self.pieces_after(kerf.circle((0.5, 0.8), 0.1)), 3)

    def test_ellipse(self):
        self.assertEqual(self.pieces_after(kerf.ellipse((0.5, 0.5), 0.3, 0.1, 30)), 2)
        hole = min(self.sheet.pieces(), key=lambda piece: piece.area_m2)
        self.assertAlmostEqual(hole.area_m2, math.pi * 0.3 * 0.1, delta=0.002)

    def test_rational_curves(self):
        self.assertEqual(self.pieces_after(kerf.rational((-0.1, 0.9, 1), (0.5, 0.5, 3), (1.1, 0.9, 1))), 2)
        self.assertEqual(
            self.pieces_after(kerf.rational((-0.1, 0.2, 1), (0.3, 0.5, 3), (0.6, 0.1, 1), (1.1, 0.3, 2))), 3)
        with self.assertRaisesRegex(ValueError, "3 points or 4"):
            kerf.rational((0, 0, 1), (1, 1, 1))

    def test_path_of_every_piece(self):
        path = kerf.Path((0.1, 0.1)).line((0.2, 0.1), (0.2, 0.2)).close()
        path.move((0.4, 0.4)).quadratic((0.5, 0.5), (0.6, 0.4), weights=(1, 2, 1))
        path.cubic((0.6, 0.3), (0.4, 0.3), (0.4, 0.4))
        path.move((0.7, 0.7)).arc((0.9, 0.7), 0.1).close()
        self.assertEqual(self.pieces_after(path.curve()), 4)
        areas = sorted(piece.area_m2 for piece in self.sheet.pieces())
        self.assertAlmostEqual(areas[0], 0.005, places=9)
        self.assertAlmostEqual(areas[1], math.pi * 0.01 / 2, delta=2e-4)  # the half disc
        # From left to right and counter-clockwise, it lies below its chord.
        half_disc = sorted(self.sheet.pieces(), key=lambda piece: piece.area_m2)[1]
        self.assertLess(half_disc.centroid.y, 0.7)

    def test_drawings_are_read_as_asked(self):
        drawing = ('<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" viewBox="0 0 200 100"><g id="Cut">'
                   '<circle class="a" cx="50" cy="50" r="20" stroke="red"/></g><circle cx="150" cy="50" r="20" stroke="blue"/>'
                   '<path d="M0 0H1" fill="none"/></svg>')
        for reading, pieces in (({}, 3), ({"only": "stroke=red"}, 2), ({"only": ["layer=Cut"], "fit_page": True}, 2),
                                ({"true_size": True, "at": (0.3, 0.3)}, 3), ({"only": ".a", "unit_m": 1e-3}, 2)):
            with self.subTest(reading):
                self.assertEqual(self.sheet.cut(kerf.svg(drawing, **reading)).pieces, pieces)
                self.sheet.undo()
        with self.assertRaises(kerf.InvalidArgument) as refused:
            self.sheet.cut(kerf.svg(drawing, only="stroke=pink"))
        self.assertEqual(refused.exception.reason, "SELECTOR_UNMATCHED")
        self.assertIn("stroke=blue", str(refused.exception))
        with self.assertRaisesRegex(TypeError, "no option 'colour'"):
            kerf.svg(drawing, colour="red")

    def test_drawings_come_in_any_encoding(self):
        import gzip
        text = '<svg xmlns="http://www.w3.org/2000/svg"><circle id="Gr\u00f6\u00dfe" r="40"/></svg>'
        picture = '<image href="data:image/png;base64,' + "A" * 1_500_000 + '"/>'
        for content in (text, text.encode(), text.encode("utf-8-sig"), text.encode("iso-8859-1"), text.encode("utf-16"),
                        gzip.compress(text.encode()), text.replace("<circle", picture + "<circle").encode()):
            curve = kerf.svg(content, only="#Gr\u00f6\u00dfe")
            self.assertLess(curve.ByteSize(), 1000)
            self.sheet.cut(curve, fit=(0.1, 0.1, 0.3, 0.3))
            self.sheet.undo()
        broken = kerf.svg(b"\x1f\x8bno gzip")
        with self.assertRaises(kerf.InvalidArgument) as refused:
            self.sheet.cut(broken)
        self.assertEqual(refused.exception.reason, "SVG_MALFORMED")

    def test_dxf(self):
        groups = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES 0 CIRCLE 8 Cut 10 100 20 100 40 50 0 ENDSEC 0 EOF"
        drawing = ("\n".join(groups.split()) + "\n").encode()
        result = self.sheet.cut(kerf.dxf(drawing, true_size=True, at=(0.2, 0.2)))
        self.assertEqual(result.pieces, 2)
        disc = min(self.sheet.pieces(), key=lambda piece: piece.area_m2)
        self.assertAlmostEqual(disc.centroid.x, 0.3, delta=1e-3)
        pathlib.Path(path("disc.dxf")).write_bytes(drawing)
        self.assertEqual(self.sheet.cut(kerf.dxf_file(path("disc.dxf")), fit=(0.6, 0.6, 0.7, 0.7)).pieces, 3)

    def test_ends_are_joined(self):
        gap = kerf.polyline((0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7), (0.3, 0.301))
        open_one = self.sheet.cut(gap)
        self.assertEqual((open_one.pieces, open_one.near_ends), (1, 2))
        self.assertAlmostEqual(open_one.nearest_end_m, 1e-3)
        self.assertRegex(open_one.warnings[-1], "2 ends nearly meet .* 1 mm away; join_m")
        self.sheet.undo()
        joined = self.sheet.cut(gap, join_m=2e-3)
        self.assertEqual((joined.pieces, joined.joined_ends, joined.near_ends), (2, 1, 0))

    def test_svg_fitted_with_its_warnings(self):
        result = self.sheet.cut(kerf.svg(RING))
        self.assertEqual((result.status, result.pieces), (kerf.APPLIED, 3))
        self.assertIn("SVG: 1 x text element: not cut", result.warnings)
        pathlib.Path(path("ring.svg")).write_text(RING)
        self.sheet.undo()
        self.sheet.cut(kerf.svg_file(path("ring.svg")), fit=(0.1, 0.1, 0.3, 0.3))
        ring = min(self.sheet.pieces(), key=lambda piece: piece.area_m2)
        self.assertAlmostEqual(ring.area_m2, math.pi * 0.05 ** 2, delta=3e-4)

    def test_fit_to_the_sheet_and_dashes(self):
        self.assertEqual(self.pieces_after(kerf.circle((7, 7), 3), fit="sheet"), 2)
        self.assertAlmostEqual(min(piece.area_m2 for piece in self.sheet.pieces()), 1 - math.pi * 0.45 ** 2, delta=0.005)
        self.sheet.undo()
        line = kerf.polyline((-0.1, 0.3), (1.1, 0.35))
        self.assertEqual(self.pieces_after(line, dash=(0.1, 0.05), dash_offset=0.03), 1)

    def test_a_width_takes_a_strip_away(self):
        def area():
            return sum(piece.area_m2 for piece in self.sheet.pieces())

        result = self.sheet.cut(kerf.polyline((0.2, 0.5), (0.8, 0.5)), width_m=0.06)
        self.assertAlmostEqual(result.removed.area_m2, 0.6 * 0.06 + math.pi * 0.03 ** 2, delta=1e-3)
        self.assertAlmostEqual(area(), 1 - result.removed.area_m2, places=12)
        self.assertGreater(result.removed.mass_kg, 0)
        self.assertEqual((result.removed.pieces, self.sheet.cuts()[0].cut.width_m), (0, 0.06))
        ring = kerf.cut(kerf.circle((0.3, 0.8), 0.1), width_m=0.02)
        self.assertEqual(self.sheet.cut(ring).pieces, 2)
        gone = self.sheet.cut(kerf.polyline((0.3, 0.8), (0.31, 0.8)), width_m=0.3)
        self.assertEqual((gone.removed.pieces, gone.pieces), (1, 1))
        self.assertEqual([len(split.children) for split in gone.split_pieces], [0])
        self.assertFalse(self.sheet.cut(kerf.circle((0.8, 0.2), 0.1)).HasField("removed"))
        for _ in range(4):
            self.sheet.undo()
        self.assertAlmostEqual(area(), 1, places=12)
        everything = kerf.polyline((0, 0), (1, 1))
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "STRIP_COVERS_SHEET", "cut.width_m",
                     self.sheet.cut, everything, width_m=3)
        self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", "OPTIONS_CONFLICT", "cut.width_m",
                     self.sheet.cut, everything, width_m=0.1, method="element")

    def test_cuts_on_a_picture(self):
        # The sheet hangs in the plane y = 0, 1 m x 1 m; from 2 m in front of it 640 x 640 pixels show 1.456 m.
        camera = kerf.camera((0.5, -2, 0.5), (0.5, 0, 0.5))
        result = self.sheet.cut(kerf.polyline((0, 320), (640, 320)), view=kerf.view(camera, (640, 640), layers="all"))
        self.assertEqual((result.status, result.pieces, len(result.layers)), (kerf.APPLIED, 2, 1))
        self.assertAlmostEqual(result.layers[0].length_m, 1.0, 2)
        self.assertAlmostEqual(result.layers[0].nearest_m, 2.0, 2)
        # Beyond the depths asked for there is nothing; the same picture as matrices cuts the same.
        far = kerf.view(camera, (640, 640), layers="depth_range", depth_m=(3, 4))
        self.assertEqual(self.sheet.cut(kerf.circle((320, 250), 40), view=far).status, kerf.NO_INTERSECTION)
        focal = 1 / math.tan(math.radians(20))
        # Right is +x, up is +z: the camera looks along +y.
        world_to_camera = (1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, -0.5, -0.5, -2, 1)
        perspective = (focal, 0, 0, 0, 0, focal, 0, 0, 0, 0, -1.02, -1, 0, 0, -0.2, 0)
        same = kerf.view_of_matrices(world_to_camera, perspective, (640, 640), layers="one_piece")
        by_matrices = self.sheet.cut(kerf.circle((320, 250), 40), view=same)
        self.sheet.undo()
        by_camera = self.sheet.cut(kerf.circle((320, 250), 40), view=kerf.view(camera, (640, 640)))
        self.assertEqual(by_matrices.pieces, by_camera.pieces)
        self.assertEqual(by_matrices.new_triangles, by_camera.new_triangles)

    def test_every_field_of_a_cut_is_an_option(self):
        fields = [field.name for field in kerf.cut(kerf.circle((0.5, 0.5), 0.1)).DESCRIPTOR.fields if field.name != "curve"]
        self.assertCountEqual(kerf.CutOptions.__annotations__, fields)

    def test_meshing_options(self):
        curve = kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5))

        def fresh(**options):
            self.sheet.reset()
            return self.sheet.cut(curve, **options)

        plain = fresh()
        self.assertGreaterEqual(plain.min_angle_deg, 19.999)
        self.assertGreaterEqual(fresh(quality="fine").min_angle_deg, 24.999)
        self.assertLess(fresh(method="element").min_angle_deg, 20)
        self.assertGreater(fresh(method="element", tolerance=0.005).new_triangles, 0)
        self.assertLessEqual(fresh(tolerance_m=1e-4).deviation_m, 1e-4)
        self.assertGreaterEqual(fresh(min_angle_deg=27).min_angle_deg, 26.999)
        self.assertGreater(fresh(relax=False).new_triangles, plain.new_triangles)
        self.assertGreater(fresh(tip_edge_length_m=0.002, tip_grading=1.3).new_triangles, plain.new_triangles + 100)
