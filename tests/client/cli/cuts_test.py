"""`kerf cut`, `cuts`, `undo`, `redo` and `pieces` against a real kerfd."""

import json
import math
import pathlib

from cli_case import Case, address, kerf, main, path, setUpModule, tearDownModule


class Cuts(Case):
    def setUp(self):
        self.id = "cut-" + self._testMethodName.replace("_", "-")
        self.json_of("sheet", "create", self.id, "--grid", "20x20")
        self.json_of("sheet", "pause", self.id)

    def hash(self):
        return self.json_of("sheet", "get", self.id)["state_hash"]

    def test_bezier_inside(self):
        reply = self.json_of("cut", self.id, "--bezier", "0.2,0.5 0.4,0.8 0.6,0.2 0.8,0.5")
        self.assertEqual(reply["status"], "APPLIED")
        self.assertEqual(reply["pieces"], 1)
        self.assertGreater(reply["new_vertices"], 10)
        self.assertGreater(reply["new_triangles"], 10)
        self.assertLess(reply["deviation_m"], 0.03 / 19)
        self.assertEqual(reply["state_hash"], self.hash())
        self.assertIsInstance(reply["tick"], int)

    def test_polyline_across_and_circle(self):
        self.assertEqual(self.json_of("cut", self.id, "--polyline", "-0.1,0.3 1.1,0.35")["pieces"], 2)
        self.assertEqual(self.json_of("cut", self.id, "--circle", "0.5,0.7,0.1")["pieces"], 3)
        self.assertIn("4 pieces", kerf("cut", self.id, "--circle", "0.2,0.15,0.05").stdout)

    def test_ellipses_rational_curves_and_paths(self):
        self.assertEqual(self.json_of("cut", self.id, "--ellipse", "0.3,0.3,0.2,0.1,30")["pieces"], 2)
        self.assertEqual(self.json_of("cut", self.id, "--rational", "-0.1,0.9,1 0.5,0.5,3 1.1,0.9,1")["pieces"], 3)
        self.assertEqual(self.json_of("cut", self.id, "--rational", "0.7,0.5,1 0.8,0.6,3 0.9,0.4,1 0.95,0.5,2")["pieces"], 3)
        # A triangle and a half disc: arcs bulge to the right of their direction where the sweep is 1, with y up.
        two = "M.1.55h.1l-.05.1z M.6.15A.1.1 0 0 1 .8.15Z"
        reply = self.json_of("cut", self.id, "--path", two)
        self.assertEqual((reply["status"], reply["pieces"]), ("APPLIED", 5))

    def test_svg_is_fitted_and_says_what_it_left_out(self):
        pathlib.Path(path("ring.svg")).write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><g transform="translate(50 50)">'
            '<circle r="40"/><circle r="20"/></g><text>ring</text></svg>')
        reply = self.json_of("cut", self.id, "--svg", path("ring.svg"))
        self.assertEqual((reply["status"], reply["pieces"]), ("APPLIED", 3))
        self.assertIn("SVG: 1 x text element: not cut", reply["warnings"])
        self.assertIn("note: SVG: 1 x text", kerf("cut", self.id, "--svg", path("ring.svg"), "--fit", "0,0,0.2,0.2").stdout)

    def test_perforation_leaves_one_piece(self):
        reply = self.json_of("cut", self.id, "--polyline", "-0.1,0.3 1.1,0.35", "--dash", "0.1,0.05", "--dash-offset", "0.03")
        self.assertEqual((reply["status"], reply["pieces"]), ("APPLIED", 1))
        self.assertGreater(reply["new_vertices"], 10)

    def test_view_follows_sight_lines(self):
        # The sheet hangs in the plane y = 0, 1 m x 1 m; from 2 m in front of it 640x640 pixels show 1.456 m.
        view = ("--view", "0.5,-2,0.5 0.5,0,0.5", "--picture", "640x640", "--layers", "all")
        reply = self.json_of("cut", self.id, "--polyline", "0,320 640,320", *view)
        self.assertEqual((reply["status"], reply["pieces"], len(reply["layers"])), ("APPLIED", 2, 1))
        self.assertAlmostEqual(reply["layers"][0]["length_m"], 1.0, 2)
        self.assertAlmostEqual(reply["layers"][0]["nearest_m"], 2.0, 2)
        self.assertIn("layer: piece", kerf("cut", self.id, "--circle", "320,250,40", *view, "--verbose").stdout)
        behind = self.json_of("cut", self.id, "--polyline", "0,320 640,320", "--view", "0.5,-2,0.5 0.5,-4,0.5")
        self.assertEqual(behind["status"], "NO_INTERSECTION")
        self.assertIn("behind", behind["warnings"][0])
        self.refused("cut", self.id, "--circle", "320,250,40", "--view", "0,0,0 0,0,0", says="CAMERA_SINGULAR")
        self.refused("cut", self.id, "--circle", "9,9,4", "--fit", "sheet", *view, says="FIT_WITH_VIEW")

    def test_undo_and_redo(self):
        self.refused("undo", self.id, says="NOTHING_TO_UNDO")
        reply = self.json_of("cut", self.id, "--circle", "0.5,0.5,0.2")
        self.assertEqual(reply["split_pieces"][0]["piece"], 1)
        self.assertEqual(len(reply["split_pieces"][0]["children"]), 2)
        pieces = self.json_of("pieces", self.id)["pieces"]
        self.assertEqual([piece["parent"] for piece in pieces], [1, 1])
        self.assertAlmostEqual(sum(piece["area_m2"] for piece in pieces), 1.0, places=12)
        undone = self.json_of("undo", self.id)
        self.assertEqual((undone["pieces"], undone["cuts"]), (1, [reply["name"]]))
        self.assertEqual(self.json_of("cuts", self.id)["cuts"], [])
        self.assertIn("Redone", kerf("redo", self.id).stdout)
        self.assertEqual([piece["id"] for piece in self.json_of("pieces", self.id)["pieces"]],
                         [piece["id"] for piece in pieces])
        self.refused("redo", self.id, says="NOTHING_TO_REDO")
        self.assertIn("piece 2", kerf("pieces", self.id).stdout)
        self.refused("undo", "nobody", says="NOT_FOUND")
        self.refused("pieces", "nobody", says="NOT_FOUND")

    def test_a_width_takes_a_strip_away(self):
        line = ["cut", self.id, "--polyline", "0.2,0.5 0.8,0.5"]
        reply = self.json_of(*line, "--width", "0.06")
        self.assertAlmostEqual(reply["removed"]["area_m2"], 0.6 * 0.06 + math.pi * 0.03 ** 2, delta=1e-3)
        self.assertEqual((reply["pieces"], reply["removed"]["pieces"]), (1, 0))
        left = sum(piece["area_m2"] for piece in self.json_of("pieces", self.id)["pieces"])
        self.assertAlmostEqual(left, 1 - reply["removed"]["area_m2"], places=12)
        told = kerf("cut", self.id, "--circle", "0.3,0.8,0.1", "--width", "0.02", "--dash", "0.05,0.05")
        self.assertRegex(told.stdout, r"(?s)^Cut: .*removed: [0-9.e-]+ m\^2, [0-9.e-]+ kg, [0-9]+ vertices")
        self.assertEqual([cut["cut"]["width_m"] for cut in self.json_of("cuts", self.id)["cuts"]], [0.06, 0.02])
        self.assertEqual(self.json_of(*line, "--width", "0.06")["status"], "NO_INTERSECTION")
        self.assertNotIn("removed", self.json_of("cut", self.id, "--circle", "0.8,0.2,0.1"))
        before = self.hash()
        self.refused(*line, "--width", "5", says="STRIP_COVERS_SHEET")
        self.refused(*line, "--width", "-1", says="cut.width_m")
        self.refused(*line, "--width", "2e4", says="cut.width_m")
        self.refused(*line, "--width", "0.01", "--method", "element", says="OPTIONS_CONFLICT")
        self.refused(*line, "--width", "wide", code=2, says="--width")
        self.assertEqual(self.hash(), before)

    def test_cuts_are_carried_to_another_sheet(self):
        self.json_of("cut", self.id, "--circle", "0.3,0.7,0.1")
        self.json_of("cut", self.id, "--bezier", "0.2,0.5 0.4,0.8 0.6,0.2 0.8,0.5", "--tolerance", "0.01")
        self.json_of("cut", self.id, "--polyline", "-0.1,0.3 1.1,0.35")
        self.json_of("undo", self.id)
        self.assertIn("/cuts/2", kerf("cuts", self.id).stdout)
        file = path("exported.json")
        self.assertEqual(kerf("cuts", self.id, "--export", file).returncode, 0)
        exported = json.loads(pathlib.Path(file).read_text())
        self.assertEqual([cut["tolerance"] for cut in exported["cuts"]], [0.02, 0.01])
        other = self.id + "-other"
        self.json_of("sheet", "create", other, "--grid", "20x20")
        self.json_of("sheet", "pause", other)
        reply = self.json_of("cuts", other, "--apply", file)
        self.assertEqual((reply["status"], reply["applied"], reply["pieces"]), ("APPLIED", 2, 2))
        self.json_of("undo", other)
        self.assertIn("2 of 2 cuts made", kerf("cut", other, "--batch", file).stdout)
        shapes = [self.json_of("sheet", "get", each) for each in (self.id, other)]
        self.assertEqual(shapes[0]["num_vertices"], shapes[1]["num_vertices"])
        self.assertEqual(shapes[0]["num_triangles"], shapes[1]["num_triangles"])

    def test_a_batch_is_whole_or_not_at_all(self):
        before = self.hash()
        file = path("batch.json")
        line = {"curve": {"polyline": {"points": [{"x": -0.1, "y": 0.4}, {"x": 1.1, "y": 0.6}]}}}
        circle = {"center": {"x": 0.5, "y": 0.5}, "radius_m": 0.1}
        pathlib.Path(file).write_text(json.dumps({"cuts": [line, {"curve": {"circle": circle}, "max_new_triangles": 1}]}))
        self.refused("cut", self.id, "--batch", file, says="cuts[1]")
        pathlib.Path(file).write_text(json.dumps({"cuts": [line, {**line, "tolerance": 7}]}))
        self.refused("cut", self.id, "--batch", file, says="cuts[1].tolerance")
        pathlib.Path(file).write_text('{"cuts": [{"curve": {"spline": 1}}]}')
        self.refused("cut", self.id, "--batch", file, says="spline")
        self.refused("cut", self.id, "--batch", path("absent.json"))
        self.refused("cut", self.id, "--batch", file, "--tolerance", "0.1", code=2)
        self.refused("cuts", self.id, "--export", file, "--apply", file, code=2)
        self.assertEqual(self.hash(), before)

    def test_a_file_of_more_cuts_than_a_call_takes_goes_in_several(self):
        def line(y):
            return {"curve": {"polyline": {"points": [{"x": -0.1, "y": y}, {"x": 1.1, "y": y}]}}}

        def write(last):
            pathlib.Path(file).write_text(json.dumps({"cuts": [line(0.3), *[line(7)] * 4095, line(9), last]}))

        file = path("many.json")
        # The second call is refused: the cuts of the first stay, and are reported.
        write({**line(0.6), "tolerance": 7})
        done = self.refused("cut", self.id, "--batch", file, says="field: cuts[4097].tolerance]")
        self.assertIn(f"cuts[0] to cuts[4095] of {file} were made before that, and `kerf undo` takes them back in 1 step", done.stderr)
        self.assertEqual(self.json_of("sheet", "get", self.id)["pieces"], 2)
        self.assertEqual(self.json_of("undo", self.id)["undo_steps"], 0)
        self.assertEqual(self.json_of("sheet", "get", self.id)["pieces"], 1)
        write(line(0.6))
        reply = self.json_of("cut", self.id, "--batch", file)
        self.assertEqual((reply["status"], reply["applied"], reply["pieces"]), ("APPLIED", 2, 3))
        statuses = [result["status"] for result in reply["results"]]
        self.assertEqual(statuses, ["APPLIED", *["NO_INTERSECTION"] * 4096, "APPLIED"])
        self.assertEqual(reply["new_vertices"], sum(result["new_vertices"] for result in reply["results"]))
        self.assertEqual(reply["state_hash"], self.hash())
        self.assertEqual([self.json_of("undo", self.id)["pieces"] for _ in range(2)], [2, 1])
        told = kerf("cuts", self.id, "--apply", file).stdout
        self.assertIn("2 of 4098 cuts made", told)
        self.assertIn("in 2 calls, each whole or not at all; `kerf undo` undoes them in 2 steps", told)
        before = self.hash()
        self.refused("cut", self.id, "--batch", file, "--at-tick", "1000000", says="split the file")
        self.refused("cut", self.id, "--batch", file, "--dry-run", says="split the file")
        self.assertEqual(self.hash(), before)

    def test_what_was_exported_can_be_applied_however_much_it_is(self):
        # Each crosses the sheet once it has come from far, in 4096 points; all of them are more than 1 MiB.
        cuts = [{"curve": {"polyline": {"points": [*({"x": -1 - 1 / (2 + i), "y": 0.05 * n + 1 / (2 + i)} for i in range(4095)),
                                                   {"x": 1.1, "y": 0.05 * n}]}}} for n in range(1, 19)]
        file, exported = path("long.json"), path("long-exported.json")
        pathlib.Path(file).write_text(json.dumps({"cuts": cuts}))
        self.assertIn("18 of 18 cuts made", kerf("cut", self.id, "--batch", file).stdout)
        self.assertEqual(self.json_of("cuts", self.id, "--export", exported)["cuts"], 18)
        other = self.id[:50] + "-other"
        self.json_of("sheet", "create", other, "--grid", "20x20")
        self.json_of("sheet", "pause", other)
        told = kerf("cuts", other, "--apply", exported).stdout
        self.assertIn("18 of 18 cuts made", told)
        self.assertIn("in 2 calls", told)
        shapes = [self.json_of("sheet", "get", each) for each in (self.id, other)]
        for each in ("pieces", "num_vertices", "num_triangles"):
            self.assertEqual(shapes[0][each], shapes[1][each])
        self.assertEqual(shapes[0]["pieces"], 19)

    def test_a_dry_run_says_what_a_cut_would_be_and_cuts_nothing(self):
        before = self.hash()
        told = kerf("cut", self.id, "--circle", "0.5,0.5,0.2", "--dry-run").stdout
        self.assertTrue(told.startswith("Dry run, nothing is cut:\nCut: 2 pieces"), told)
        self.assertRegex(told, r"\n  a tick would take [\d.]+ ms of the 16\.7 ms available; now it takes [\d.]+ ms\n$")
        reply = self.json_of("cut", self.id, "--circle", "0.5,0.5,0.2", "--dry-run")
        self.assertEqual((reply["status"], reply["pieces"]), ("APPLIED", 2))
        self.assertGreater(reply["tick_after_us"], reply["tick_before_us"])
        self.assertNotIn("name", {key for key, value in reply.items() if value})
        def line(y):
            return {"curve": {"polyline": {"points": [{"x": -0.1, "y": y}, {"x": 1.1, "y": y}]}}}

        file = path("dry.json")
        pathlib.Path(file).write_text(json.dumps({"cuts": [line(0.3), line(0.6)]}))
        told = kerf("cut", self.id, "--batch", file, "--dry-run").stdout
        self.assertTrue(told.startswith("Dry run, nothing is cut:\n2 of 2 cuts made: 3 pieces"), told)
        self.assertIn("\n  a tick would take ", told)
        self.refused("cut", self.id, "--circle", "0.5,0.5,0.2", "--dry-run", "--at-tick", "9", code=2, says="--at-tick")
        self.assertEqual(self.hash(), before)
        self.assertEqual(kerf("cuts", self.id, "--json").stdout.count("sheets/"), 0)

    def scheduled_and_cancelled(self, tick):
        reply = self.json_of("cut", self.id, "--circle", "0.5,0.5,0.3", "--at-tick", str(tick))
        return kerf("cuts", self.id, "--cancel", reply["scheduled_name"].split("/")[-1]).stdout

    def test_a_cut_at_a_tick(self):
        tick = self.json_of("sheet", "get", self.id)["tick"]
        self.refused("cut", self.id, "--circle", "0.5,0.5,0.1", "--at-tick", str(tick), says="TICK_PAST")
        reply = self.json_of("cut", self.id, "--circle", "0.5,0.5,0.1", "--at-tick", str(tick + 2))
        self.assertEqual((reply["status"], reply["tick"]), ("SCHEDULED", tick + 2))
        self.assertIn(f"1 waiting for tick {tick + 2}: 1 cut", kerf("cuts", self.id).stdout)
        told = kerf("cut", self.id, "--circle", "0.5,0.5,0.3", "--at-tick", str(tick + 2)).stdout
        self.assertIn("--cancel 2", told)
        cancelled = self.json_of("cuts", self.id, "--cancel", "2")
        self.assertEqual((cancelled["state"], cancelled["tick"], cancelled["name"]),
                         ("CANCELLED", tick + 2, f"sheets/{self.id}/scheduledCuts/2"))
        self.refused("cuts", self.id, "--cancel", "2", says="SCHEDULED_CUTS_SETTLED")
        self.refused("cuts", self.id, "--cancel", "3", says="SCHEDULED_CUTS_NOT_FOUND")
        self.refused("cuts", self.id, "--cancel", "0", code=2, says="--cancel")
        self.refused("cuts", self.id, "--cancel", "1", "--export", path("no.json"), code=2)
        self.assertEqual(self.json_of("sheet", "step", self.id, "1")["pieces"], 1)
        self.assertEqual(self.json_of("sheet", "step", self.id, "1")["pieces"], 2)
        self.assertEqual(self.json_of("cuts", self.id)["cuts"][0]["result"]["tick"], tick + 2)
        self.assertIn("CANCELLED: 1 cut", self.scheduled_and_cancelled(tick + 9))

    def test_meshing_options(self):
        curve = ("--bezier", "0.2,0.5 0.4,0.8 0.6,0.2 0.8,0.5")

        def fresh(*options):
            self.json_of("sheet", "reset", self.id)
            return self.json_of("cut", self.id, *curve, *options)

        plain = fresh()
        self.assertGreaterEqual(plain["min_angle_deg"], 19.999)
        self.assertLessEqual(plain["quality"]["max_aspect"], 5.5)
        self.assertEqual(plain["quality"]["below_contract"], 0)
        self.assertGreaterEqual(fresh("--quality", "fine")["min_angle_deg"], 24.999)
        self.assertLessEqual(fresh("--tolerance-m", "0.0001")["deviation_m"], 0.0001)
        graded = fresh("--tip-size", "0.002", "--tip-grading", "1.3")
        self.assertGreater(graded["new_triangles"], plain["new_triangles"] + 100)
        self.assertGreater(fresh("--no-relax")["new_triangles"], plain["new_triangles"])
        element = fresh("--method", "element")
        self.assertLess(element["min_angle_deg"], 20)
        self.assertGreater(element["quality"]["below_contract"], 0)
        self.json_of("sheet", "reset", self.id)
        text = kerf("cut", self.id, "--polyline", "0.2,0.45 0.7,0.5 0.2,0.5", "--verbose").stdout
        self.assertIn("0 below the contract", text)
        self.assertRegex(text, r"corner of \d+\.\d degrees at \(0\.7, 0\.5\) m: \d+ triangles below the angle")
        self.refused("cut", self.id, *curve, "--tolerance-m", "1e-9", says="TOLERANCE_TOO_SMALL")
        self.refused("cut", self.id, *curve, "--method", "element", "--tip-size", "0.01", says="OPTIONS_CONFLICT")

    def test_a_budget_of_triangles(self):
        self.json_of("sheet", "create", "budget", "--grid", "20x20")
        across = ["cut", "budget", "--polyline", "-0.1,0.52 1.1,0.47", "--max-new-triangles"]
        few = self.refused(*across, "5", says="CUT_ELEMENT_BUDGET")
        self.assertIn("max_new_triangles", few.stderr)
        self.assertEqual(self.json_of(*across, "5000")["status"], "APPLIED")
        self.refused(*across, "1000001", says="max_new_triangles")
        self.json_of("sheet", "delete", "budget")

    def test_a_miss_is_no_error(self):
        before = self.hash()
        reply = self.json_of("cut", self.id, "--polyline", "2,2 3,3")
        self.assertEqual((reply["status"], reply["pieces"], reply["new_vertices"]), ("NO_INTERSECTION", 1, 0))
        self.assertEqual(self.hash(), before)

    def test_gaps_closed_and_dust_merged_are_told(self):
        slit = self.json_of("cut", self.id, "--polyline", "0.2,0.43 0.8,0.43")
        self.assertEqual((slit["closed_gaps"], slit["widest_gap_m"], slit["merged_segments"]), (0, 0, 0))
        short = self.json_of("cut", self.id, "--polyline", "0.45,0.81 0.46,0.43002")  # of the slit, by less than snapping
        self.assertEqual((short["status"], short["closed_gaps"]), ("APPLIED", 1))
        self.assertAlmostEqual(short["widest_gap_m"], 2e-5, delta=1e-7)
        beside = self.json_of("cut", self.id, "--polyline", "0.2,0.43001 0.8,0.43001")
        self.assertEqual(beside["status"], "NO_INTERSECTION")
        self.assertGreater(beside["closed_gaps"], 0)
        self.assertAlmostEqual(beside["widest_gap_m"], 1e-5, delta=1e-7)
        dust = self.json_of("cut", self.id, "--polyline", "0.25,0.17 0.250001,0.170001 0.65,0.24")
        self.assertEqual((dust["status"], dust["merged_segments"]), ("APPLIED", 1))
        text = kerf("cut", self.id, "--polyline", "0.2,0.43001 0.8,0.43001").stdout
        self.assertRegex(text, r"^Nothing was cut: the curve follows an earlier cut or the border \(\d+ pieces?, tick \d+\)\n$")

    def test_what_is_below_the_tolerance_is_no_warning(self):
        self.json_of("cut", self.id, "--polyline", "0.2,0.43 0.8,0.43")
        for line in ("0.45,0.81 0.46,0.43002", "0.25,0.17 0.250001,0.170001 0.65,0.24"):
            reply = self.json_of("cut", self.id, "--polyline", line)
            self.assertGreater(reply["closed_gaps"] + reply["merged_segments"], 0)
            self.assertEqual(reply["warnings"], [])
        edge_on = ("--view", "0.5,-0.0005,3 0.5,0,0.5 0,1,0", "--picture", "640x640", "--tolerance-m", "0.0001")
        self.assertRegex(kerf("cut", self.id, "--polyline", "100,318 540,322", *edge_on).stdout,
                         r"\n  note: seen nearly edge-on: the cut is up to [\d.]+ mm off the sight lines\n$")

    def test_a_cut_is_told_in_a_line_and_more_on_request(self):
        line = r"Cut: \d+ pieces?, \d+ new vertices, at most [\d.]+ mm off the curve \(tick \d+\)\n"
        self.assertRegex(kerf("cut", self.id, "--circle", "0.3,0.3,0.05").stdout, f"^{line}$")
        self.assertRegex(kerf("cut", self.id, "--circle", "0.3,0.7,0.05", "-v").stdout,
                         f"^{line}(?s:.*)smallest angle(?s:.*)state hash(?s:.*)model update")
        self.assertRegex(kerf("cut", self.id, "--circle", "8,8,0.05").stdout, "^Nothing was cut: the curve misses the sheet or is too small")

    def test_options_may_follow_the_command(self):
        done = kerf("cut", self.id, "--circle", "0.5,0.5,0.1", "--json", "--server", address(), server=False)
        self.assertEqual(json.loads(done.stdout)["pieces"], 2)

    def test_refusals_change_nothing(self):
        before = self.hash()
        self.refused("cut", self.id, "--polyline", "0,0 nan,1", says="points[1].x")
        self.refused("cut", self.id, "--bezier", "0,0 inf,1 1,1 1,0", says="points[1].x")
        self.refused("cut", self.id, "--circle", "0.5,0.5,-1", says="radius_m")
        self.refused("cut", self.id, "--polyline", "0.5,0.5 0.5,0.5", says="polyline")
        self.refused("cut", self.id, "--polyline", "0,0 1e9,1", says="points[1].x")
        self.refused("cut", self.id, "--circle", "0.5,0.5,0.1", "--tolerance", "9", says="tolerance")
        self.refused("cut", "nobody", "--circle", "0.5,0.5,0.1", says="NOT_FOUND")
        self.refused("cut", self.id, "--ellipse", "0.5,0.5,0.1,0", says="semi_axis_y_m")
        self.refused("cut", self.id, "--rational", "0,0,1 1,1,0 1,0,1", says="weights[1]")
        self.refused("cut", self.id, "--path", "M0 0L0 0", says="CURVE_DEGENERATE")
        self.refused("cut", self.id, "--circle", "0.5,0.5,0.1", "--fit", "0,0,0,1", says="cut.fit.max.x")
        self.refused("cut", self.id, "--circle", "0.5,0.5,0.1", "--dash", "0.1,0", says="cut.dash[1]")
        self.refused("cut", self.id, "--circle", "0.5,0.5,0.1", "--dash", "1e-6", says="TOO_MANY_DASHES")
        pathlib.Path(path("bad.svg")).write_text("<svg><g></svg>")
        self.refused("cut", self.id, "--svg", path("bad.svg"), says="SVG_MALFORMED")
        self.refused("cut", self.id, "--svg", path("none.svg"), says="none.svg")
        self.assertEqual(self.hash(), before)

    def test_usage_errors(self):
        self.refused("cut", self.id, code=2)
        self.refused("cut", self.id, "--circle", "1,2", code=2, says="--circle")
        self.refused("cut", self.id, "--bezier", "0,0 1,1", code=2, says="--bezier")
        self.refused("cut", self.id, "--polyline", "0,0", code=2, says="--polyline")
        self.refused("cut", self.id, "--polyline", "0;0", code=2)
        self.refused("cut", self.id, "--ellipse", "1,2,3", code=2, says="--ellipse")
        self.refused("cut", self.id, "--rational", "1,2,3 4,5,6", code=2, says="--rational")
        self.refused("cut", self.id, "--path", "M0 0L1", code=2, says="byte 6")
        self.refused("cut", self.id, "--circle", "1,2,3", "--fit", "1,2", code=2, says="--fit")
        self.refused("cut", self.id, "--circle", "1,2,3", "--dash", "x", code=2, says="--dash")
        self.refused("cut", self.id, "--circle", "1,2,3", "--dash-offset", "1", code=2)
        self.refused("cut", self.id, "--circle", "1,2,3", "--polyline", "0,0 1,1", code=2)


if __name__ == "__main__":
    main(__doc__)
