"""The Python client against a real kerfd: every kind of cut, undo, pieces, lists of cuts, refusals; and its types."""

import argparse
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPTIONS = None
PROCESS = None
ADDRESS = None
RING = ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><g transform="translate(50 50)">'
        '<circle r="40"/><circle r="20"/></g><text>ring</text></svg>')


def setUpModule():
    global PROCESS, ADDRESS, kerf
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    os.makedirs(OPTIONS.work)
    subprocess.run([ROOT / "client/python/generate", path("package")], check=True)
    sys.path.insert(0, path("package"))
    import kerf
    PROCESS = subprocess.Popen(
        [OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    ADDRESS = json.loads(PROCESS.stdout.readline())["grpc"]


def tearDownModule():
    PROCESS.send_signal(signal.SIGTERM)
    if PROCESS.wait(timeout=20) != 0:
        raise AssertionError(f"kerfd left with {PROCESS.returncode} after SIGTERM")


def path(name):
    return os.path.join(OPTIONS.work, name)


class Case(unittest.TestCase):
    def setUp(self):
        self.server = kerf.connect(ADDRESS, timeout_s=300)
        self.addCleanup(self.server.close)
        self.sheet = self.server.create_sheet(
            "py-" + self._testMethodName.replace("_", "-")[:50], grid=(20, 20), paused=True)
        self.addCleanup(self.sheet.delete)

    def pieces_after(self, curve, **options):
        result = self.sheet.cut(curve, **options)
        self.assertEqual(result.status, kerf.APPLIED)
        return result.pieces

    def refused(self, kind, code, reason, field, call, *arguments, **options):
        before = self.sheet.get().state_hash
        with self.assertRaises(kind) as caught:
            call(*arguments, **options)
        error = caught.exception
        self.assertIsInstance(error, kerf.Error)
        self.assertEqual((error.code, error.reason, error.field), (code, reason, field))
        self.assertIn(error.message, str(error))
        self.assertIn(reason, str(error))
        self.assertEqual(self.sheet.get().state_hash, before)


class Curves(Case):
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


class Lists(Case):
    def test_undo_and_redo(self):
        result = self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        ids = [piece.id for piece in self.sheet.pieces()]
        self.assertEqual(len(ids), 2)
        self.assertEqual(sum(piece.parent for piece in self.sheet.pieces()), 2)
        undone = self.sheet.undo()
        self.assertEqual((undone.pieces, list(undone.cuts)), (1, [result.name]))
        self.assertEqual(self.sheet.cuts(), [])
        self.assertEqual(self.sheet.redo().pieces, 2)
        self.assertEqual([piece.id for piece in self.sheet.pieces()], ids)

    def test_a_batch_is_one_step(self):
        line = kerf.polyline((-0.1, 0.4), (1.1, 0.6))
        done = self.sheet.cut_all([line, kerf.cut(kerf.circle((0.3, 0.2), 0.1), tolerance=0.01), kerf.circle((7, 7), 1)])
        self.assertEqual((done.status, done.applied, done.pieces, len(done.results)), (kerf.APPLIED, 2, 3, 3))
        self.assertEqual([entry.cut.tolerance for entry in self.sheet.cuts()], [0.02, 0.01])
        self.assertEqual(self.sheet.undo().pieces, 1)

    def test_more_pieces_and_cuts_than_a_page(self):
        holes = [kerf.circle((0.02 + 0.96 * (i % 33) / 32, 0.02 + 0.96 * (i // 33) / 32), 0.004) for i in range(1024)]
        self.assertEqual(self.sheet.cut_all(holes).applied, 1024)
        self.assertEqual(len(self.sheet.pieces()), 1025)
        self.assertEqual(len(self.sheet.cuts()), 1024)

    def test_cuts_are_carried_to_another_sheet(self):
        self.sheet.cut(kerf.circle((0.3, 0.7), 0.1))
        self.sheet.cut(kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5)), quality="fine")
        self.sheet.cut(kerf.polyline((-0.1, 0.3), (1.1, 0.35)))
        self.sheet.undo()
        self.assertEqual(self.sheet.export_cuts(path("cuts.json")), 2)
        other = self.server.create_sheet("py-other", grid=(20, 20), paused=True)
        self.addCleanup(other.delete)
        self.assertEqual(other.apply_cuts(path("cuts.json")).applied, 2)
        self.assertEqual(other.get().num_triangles, self.sheet.get().num_triangles)
        # The same file as the shell's.
        def exported_by_shell(sheet):
            subprocess.run([OPTIONS.kerf, "--server", ADDRESS, "cuts", sheet.id, "--export", path("shell.json")], check=True)
            return kerf.load_cuts(path("shell.json"))
        self.assertEqual(exported_by_shell(self.sheet), kerf.load_cuts(path("cuts.json")))
        other.undo()
        self.assertEqual(other.cut_all(exported_by_shell(self.sheet)).applied, 2)
        pathlib.Path(path("none.json")).write_text('{"cuts": [{"curve": {"spline": 1}}]}')
        with self.assertRaisesRegex(ValueError, "none.json.*spline"):
            other.apply_cuts(path("none.json"))
        with self.assertRaises(FileNotFoundError):
            other.apply_cuts(path("absent.json"))

    def test_scheduled_cuts(self):
        tick = self.sheet.get().tick
        result = self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), at_tick=tick + 2)
        self.assertEqual((result.status, result.tick), (kerf.SCHEDULED, tick + 2))
        self.sheet.cut_all([kerf.cut(kerf.circle((0.2, 0.2), 0.1), max_new_triangles=1)], at_tick=tick + 2)
        self.assertEqual([waiting.tick for waiting in self.sheet.waiting()], [tick + 2, tick + 2])
        other = self.sheet.cut(kerf.circle((0.5, 0.5), 0.3), at_tick=tick + 2).scheduled_name
        self.assertEqual(self.sheet.waiting()[-1].name, other)
        self.assertEqual(self.sheet.cancel(other).cuts[0].curve.circle.radius_m, 0.3)
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "SCHEDULED_CUTS_SETTLED", "", self.sheet.cancel, other)
        self.assertEqual([self.sheet.step().pieces, self.sheet.step().pieces], [1, 2])
        self.assertEqual(self.sheet.waiting(), [])
        refused = self.sheet.refused()
        self.assertEqual([(each.tick, each.reason) for each in refused], [(tick + 2, "CUT_ELEMENT_BUDGET")])
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "TICK_PAST", "at_tick",
                     self.sheet.cut, kerf.circle((0.5, 0.5), 0.2), at_tick=tick + 2)

    def test_a_repeated_request_cuts_once(self):
        first = self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), request_id="once")
        self.assertEqual(self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), request_id="once"), first)
        self.assertEqual(len(self.sheet.cuts()), 1)


class Refusals(Case):
    def test_each_names_code_reason_and_field(self):
        circle = kerf.circle((0.5, 0.5), 0.1)
        snake = kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5))
        for reason, field, curve, options in (
                ("RADIUS_NOT_POSITIVE", "cut.curve.circle.radius_m", kerf.circle((0.5, 0.5), -1), {}),
                ("CURVE_NOT_FINITE", "cut.curve.polyline.points[1].x", kerf.polyline((0, 0), (math.nan, 1)), {}),
                ("CURVE_WEIGHT", "cut.curve.path.subpaths[0].segments[0].quadratic.weights[1]",
                 kerf.rational((0, 0, 1), (1, 1, 0), (1, 0, 1)), {}),
                ("SVG_MALFORMED", "cut.curve.svg", kerf.svg("<svg><g></svg>"), {}),
                ("OUT_OF_RANGE", "cut.tolerance", circle, {"tolerance": 9}),
                ("TOLERANCE_TOO_SMALL", "cut.curve", snake, {"tolerance_m": 1e-9}),
                ("FIT_EMPTY", "cut.fit.max.x", circle, {"fit": (0, 0, 0, 1)}),
                ("CAMERA_SINGULAR", "cut.view.camera.up", circle, {"view": kerf.view(kerf.camera((0, 0, 0), (0, 0, 0)))})):
            with self.subTest(reason=reason):
                self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", reason, field, self.sheet.cut, curve, **options)
        self.refused(kerf.ResourceExhausted, "RESOURCE_EXHAUSTED", "CUT_ELEMENT_BUDGET", "cut",
                     self.sheet.cut, circle, max_new_triangles=1)
        self.refused(kerf.ResourceExhausted, "RESOURCE_EXHAUSTED", "CUT_ELEMENT_BUDGET", "cuts[1]",
                     self.sheet.cut_all, [circle, kerf.cut(kerf.circle((0.2, 0.2), 0.1), max_new_triangles=1)])
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "NOTHING_TO_UNDO", "", self.sheet.undo)
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "NOTHING_TO_REDO", "", self.sheet.redo)
        self.refused(kerf.NotFound, "NOT_FOUND", "SHEET_NOT_FOUND", "name", self.server.sheet("nobody").get)
        self.refused(kerf.AlreadyExists, "ALREADY_EXISTS", "SHEET_EXISTS", "sheet_id",
                     self.server.create_sheet, self.sheet.id)

    def test_misuse_is_told_before_anything_is_sent(self):
        circle = kerf.circle((0.5, 0.5), 0.1)
        with self.assertRaisesRegex(TypeError, "no option 'tolerence'; there are tolerance, "):
            self.sheet.cut(circle, tolerence=0.1)
        with self.assertRaisesRegex(TypeError, "kerf.cut"):
            self.sheet.cut(kerf.cut(circle), tolerance=0.1)
        with self.assertRaisesRegex(TypeError, "not str"):
            self.sheet.cut("M0 0L1 1")
        with self.assertRaisesRegex(ValueError, "method is 'best'; must be one of neighbourhood, element"):
            self.sheet.cut(circle, method="best")
        with self.assertRaisesRegex(ValueError, "fit is 'page'"):
            self.sheet.cut(circle, fit="page")
        with self.assertRaisesRegex(ValueError, "must be one of nearest, all, one_piece, depth_range"):
            kerf.view(kerf.camera((0, 0, 1), (0, 0, 0)), layers="some")

    def test_a_miss_is_no_error(self):
        result = self.sheet.cut(kerf.circle((7, 7), 1))
        self.assertEqual((result.status, result.pieces, result.name), (kerf.NO_INTERSECTION, 1, ""))

    def test_a_second_cut_beside_a_first_tells_of_the_gap_closed(self):
        first = self.sheet.cut(kerf.polyline((0.2, 0.43), (0.8, 0.43)))
        self.assertEqual((first.closed_gaps, first.widest_gap_m, first.merged_segments), (0, 0.0, 0))
        second = self.sheet.cut(kerf.polyline((0.2, 0.43001), (0.8, 0.43001)))
        self.assertEqual(second.status, kerf.NO_INTERSECTION)
        self.assertGreater(second.closed_gaps, 0)
        self.assertAlmostEqual(second.widest_gap_m, 1e-5, delta=1e-7)

    def test_no_server(self):
        with kerf.connect("127.0.0.1:1") as nobody, self.assertRaises(kerf.Unavailable) as caught:
            nobody.info()
        self.assertEqual((caught.exception.code, caught.exception.reason), ("UNAVAILABLE", ""))
        self.assertIn("no Kerf server answers at 127.0.0.1:1", str(caught.exception))

    def test_a_time_limit(self):
        with kerf.connect(ADDRESS, timeout_s=0.0001) as hasty, self.assertRaises(kerf.DeadlineExceeded):
            hasty.sheet(self.sheet.id).step(100000)


class Sheets(Case):
    def test_life_of_a_sheet(self):
        self.assertIn(self.sheet.id, [sheet.id for sheet in self.server.sheets()])
        self.assertIn("demo", self.server.info().material_presets)
        tick = self.sheet.get().tick
        stepped = self.sheet.step(7)
        self.assertEqual((stepped.tick, stepped.state_hash), (tick + 7, self.sheet.get().state_hash))
        self.sheet.resume()
        with self.assertRaises(kerf.FailedPrecondition):
            self.sheet.step()
        self.sheet.pause()

    def test_scenes(self):
        scene = {"grid": {"columns": 3, "rows": 4, "width_m": 1, "height_m": 2}, "pins": [{"edge": "TOP"}]}
        pathlib.Path(path("scene.json")).write_text(json.dumps(scene))
        for given in (scene, path("scene.json")):
            made = self.server.create_scene(given, "py-scene", paused=True)
            self.assertEqual(made.get().num_vertices, 12)
            made.delete()
        solved = self.server.create_scene({**scene, "integrator": {"kind": "IMPLICIT_EULER", "solver": "PLAIN_CG"}},
                                          "py-solver", paused=True)
        solved.step(3)
        self.assertIn("plain conjugate gradients", solved.get().integrator)
        self.assertGreater(solved.get().linear_iterations, 0)
        self.assertLess(solved.get().linear_residual, 1e-3)
        solved.delete()
        green = self.server.create_scene({**scene, "membrane_law": "GREEN"}, "py-green", paused=True)
        self.assertEqual(kerf.v1.scene_pb2.MembraneLaw.Name(green.get().scene.membrane_law), "GREEN")
        green.delete()
        with self.assertRaisesRegex(ValueError, "colour"):
            self.server.create_scene({"colour": "red"})

    def test_parts_of_other_materials(self):
        made = self.server.create_sheet("py-parts", grid=(9, 9), material="denim", parts=[((0.5, 0, 1, 1), "silk")],
                                        paused=True)
        scene = made.get().scene
        self.assertEqual(scene.material.thickness_m, 1.066e-3)
        self.assertEqual([part.material.thickness_m for part in scene.materials], [1.2e-4])
        made.delete()
        with self.assertRaisesRegex(kerf.InvalidArgument, "preset"):
            self.server.create_sheet("py-parts", parts=[((0, 0, 1, 1), "unobtainium")])

    def test_state_is_exact(self):
        self.sheet.cut(kerf.polyline((-0.1, 0.3), (1.1, 0.35)))
        told = self.sheet.step(3)
        state = self.sheet.state()
        self.assertEqual((state.tick, state.state_hash), (told.tick, told.state_hash))
        self.assertEqual(state.positions.shape, (told.num_vertices, 3))
        self.assertEqual(state.material_positions.shape, (told.num_vertices, 2))
        self.assertEqual(state.triangles.shape[0], len(state.pieces))
        self.assertEqual(max(state.pieces), 1)
        # The upper left corner is pinned.
        self.assertEqual([state.positions[380, axis] for axis in range(3)], [0.0, 0.0, 1.0])
        self.assertTrue(any(state.velocities[i, 2] < 0 for i in range(told.num_vertices)))

    def test_equilibria_and_vibrations(self):
        sheet = self.server.create_sheet("rests", grid=(8, 8), pins=["top"], paused=True)
        try:
            modes = sheet.analyze(modes=3)
            self.assertEqual([table.name for table in modes.tables], ["modes"])
            self.assertEqual(len(modes.tables[0].rows), 3)
            self.assertTrue(sheet.analyze(modes=2, about_equilibrium=True).static.converged)
            probes = [{"name": "top", "quantity": "REACTION", "region": {"edge": "TOP"}}]
            rest = sheet.analyze(request={"analysis": {"static": {"steps": 2}}, "probes": probes})
            self.assertEqual(rest.tables[0].columns[3], "top.z")
            self.assertEqual(len(rest.tables[0].rows), 2)
            ahead = sheet.analyze(ticks=6, measure_every=4, request={"probes": probes})
            self.assertEqual([round(row.values[0] * 60) for row in ahead.tables[0].rows], [0, 4, 6])
            self.assertEqual(sheet.step(6).state_hash, ahead.dynamic.state_hash)
            self.assertEqual(sheet.analyze(ticks=0).dynamic.ticks, 0)
            for wrong in ({"modes": 1}, {"about_equilibrium": True}):
                with self.assertRaises(ValueError):
                    sheet.analyze(request={}, **wrong)
            with self.assertRaises(ValueError):
                sheet.analyze(modes=1, ticks=1)
            with self.assertRaises(ValueError):
                sheet.analyze(ticks=1, request={"analysis": {"static": {}}})
        finally:
            sheet.delete()

    def test_hands(self):
        self.sheet.set_pins([])
        self.sheet.grab("corner", 399, (1.2, 0.0, 1.2))
        self.sheet.grab("middle", (0.5, 0.5))
        self.sheet.step(30)
        self.assertLess(math.dist(self.sheet.state().positions.tolist()[399], (1.2, 0.0, 1.2)), 0.1)
        self.sheet.drag("corner", (1.3, 0.0, 1.0))
        self.sheet.release("middle")
        self.refused(kerf.NotFound, "NOT_FOUND", "GRAB_NOT_FOUND", "release.grab_id", self.sheet.release, "middle")
        self.sheet.set_gravity((0, 0, -1))
        self.sheet.set_wind(None)
        self.assertEqual(self.sheet.get().scene.gravity_mps2.z, -1)

    def test_pictures_and_files(self):
        try:
            picture = self.sheet.render((320, 200), wireframe=True)
        except kerf.Unavailable as none:
            self.skipTest(str(none))
        self.assertEqual(picture[:8], b"\x89PNG\r\n\x1a\n")
        near = self.sheet.render((64, 64), camera=kerf.camera((0.5, -1, 0.5), (0.5, 0, 0.5)), format="jpeg")
        self.assertEqual(near[:2], b"\xff\xd8")
        self.assertNotEqual(self.sheet.render((64, 64), undeformed=True), self.sheet.render((64, 64)))
        self.assertTrue(self.sheet.obj().startswith(b"#") or b"\nv " in self.sheet.obj())
        self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", "OUT_OF_RANGE", "width_px", self.sheet.render, (9, 9))


class Package(unittest.TestCase):
    def test_example(self):
        with kerf.connect(ADDRESS) as server:
            server.create_sheet("snake", grid=(15, 15))
        example = shutil.copy(ROOT / "client/python/cut_example.py", path("package"))  # beside the package, as it is there
        done = subprocess.run(["/usr/bin/python3", example, ADDRESS, "snake"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("status: APPLIED", done.stdout)
        self.assertIn("pieces: 2", done.stdout)

    def test_sheets_from_mesh_files(self):
        square = ("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
        pathlib.Path(path("square.ply")).write_text(square)
        pathlib.Path(path("square.obj")).write_bytes(b"o T\xfcr\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        with kerf.connect(ADDRESS) as server:
            made = [server.create_sheet("py-" + end, mesh_file=path("square." + end), pins=()) for end in ("ply", "obj")]
            self.assertEqual([sheet.get().num_triangles for sheet in made], [2, 2])
            for sheet in made:
                sheet.delete()
            pathlib.Path(path("bent.obj")).write_text("v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
            bent = server.create_sheet("py-bent", mesh_file=path("bent.obj"), rest="surface", pins=())
            self.assertAlmostEqual(sum(piece.area_m2 for piece in bent.pieces()), 1.25 ** 0.5, places=12)
            bent.delete()
            with self.assertRaises(kerf.InvalidArgument) as refused:
                server.create_sheet("py-bent", mesh_file=path("bent.obj"), rest="flat", pins=())
            self.assertEqual(refused.exception.reason, "OBJ_NOT_PLANAR")
            with self.assertRaisesRegex(ValueError, "ends in .obj or .ply"):
                server.create_sheet("py-stl", mesh_file=path("square.stl"))

    def test_types(self):
        def checked(*what):
            return subprocess.run(["mypy", "--config-file", ROOT / "client/python/mypy.ini", *what], capture_output=True,
                                  text=True, cwd=path("package"))
        done = checked("-p", "kerf")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        pathlib.Path(path("wrong.py")).write_text(
            "import kerf\nsheet = kerf.connect().sheet('a')\nsheet.cut(kerf.circle((0, 0), 1), tolerence=1)\n"
            "sheet.cut(kerf.circle((0, 0), 1), tolerance='much')\nsheet.cut(kerf.circle(0, 1))\n")
        done = checked(path("wrong.py"))
        self.assertEqual(done.stdout.count("error:"), 3, done.stdout)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kerf", required=True)
    parser.add_argument("--kerfd", required=True)
    parser.add_argument("--work", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
