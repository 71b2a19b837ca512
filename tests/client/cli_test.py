"""Runs every `kerf` command against a real kerfd, as a shell user would: outputs, JSON fields, exit codes, refusals."""

import argparse
import base64
import json
import math
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPTIONS = None
SERVER = None

SMALL_SCENE = {
    "sheet_id": "small",
    "grid": {"columns": 12, "rows": 12, "width_m": 1.0, "height_m": 1.0},
    "pins": [{"edge": "TOP"}],
    "ticks": 20,
    "commands": [
        {"tick": 5, "command": {"cut": {"curve": {"polyline": {"points": [{"x": -0.1, "y": 0.4}, {"x": 1.1, "y": 0.6}]}}}}}
    ],
}


def kerf(*arguments, server=True, timeout=120):
    command = [OPTIONS.kerf]
    if server:
        command += ["--server", SERVER["grpc"]]
    return subprocess.run(command + list(arguments), capture_output=True, text=True, timeout=timeout)


def setUpModule():
    global SERVER, PROCESS
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    os.makedirs(OPTIONS.work)
    PROCESS = subprocess.Popen(
        [OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--max-load", "0"], stdout=subprocess.PIPE, text=True)
    SERVER = json.loads(PROCESS.stdout.readline())


def tearDownModule():
    PROCESS.send_signal(signal.SIGTERM)
    if PROCESS.wait(timeout=20) != 0:
        raise AssertionError(f"kerfd left with {PROCESS.returncode} after SIGTERM")


def path(name):
    return os.path.join(OPTIONS.work, name)


def panel(kind, faces=((0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7))):
    """A PLY file: a square of 3 m with a square hole of 1 m, flat on the ground."""
    points = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)]
    header = (f"ply\nformat {kind} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n").encode()
    if kind == "ascii":
        rows = [f"{x} {y} 0" for x, y in points] + [f"3 {a} {b} {c}" for a, b, c in faces]
        return header + ("\n".join(rows) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    return (header + b"".join(struct.pack(order + "3f", x, y, 0) for x, y in points)
            + b"".join(struct.pack(order + "B3i", 3, *face) for face in faces))


class Case(unittest.TestCase):
    def json_of(self, *arguments):
        done = kerf("--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def refused(self, *arguments, code=1, says=""):
        done = kerf(*arguments)
        self.assertEqual(done.returncode, code, f"{arguments}: {done.stdout}{done.stderr}")
        self.assertIn(says, done.stderr)
        self.assertEqual(done.stdout, "")
        return done


class Sheets(Case):
    def test_life_of_a_sheet(self):
        made = self.json_of("sheet", "create", "life", "--grid", "10x8", "--size", "1x0.5", "--pin", "corners")
        self.assertEqual((made["name"], made["num_vertices"], made["num_triangles"], made["pieces"]),
                         ("sheets/life", 80, 126, 1))
        self.assertEqual(len(made["pinned_vertices"]), 4)
        self.assertIn("sheets/life", [sheet["name"] for sheet in self.json_of("sheet", "list")["sheets"]])
        paused = self.json_of("sheet", "pause", "life")
        self.assertEqual(paused["run_state"], "PAUSED")
        stepped = self.json_of("sheet", "step", "life", "7")
        self.assertEqual(stepped["tick"], paused["tick"] + 7)
        self.assertEqual(self.json_of("sheet", "get", "life")["state_hash"], stepped["state_hash"])
        self.json_of("sheet", "reset", "life")
        self.assertIn(self.json_of("sheet", "resume", "life")["run_state"], ("RUNNING", "SLEEPING"))
        self.refused("sheet", "step", "life", "1", says="pause")
        self.json_of("sheet", "delete", "life")
        self.refused("sheet", "get", "life", says="life")

    def test_parts_of_other_materials(self):
        made = self.json_of("sheet", "create", "parts", "--grid", "9x9", "--material", "cotton",
                            "--part", "0.5,0,1,1=denim", "--part", "0.5,0.5,1,1=foil")
        self.assertEqual(made["scene"]["material"]["density_kgpm3"], 375)
        self.assertEqual([part["material"]["density_kgpm3"] for part in made["scene"]["materials"]], [304, 2710])
        self.json_of("sheet", "delete", "parts")

    def test_material_and_speed_of_a_running_sheet(self):
        self.json_of("sheet", "create", "set", "--grid", "9x9", "--material", "cotton", "--part", "0.5,0,1,1=denim")
        self.assertGreaterEqual(self.json_of("sheet", "material", "set", "silk", "--with", "thickness_m=0.0003",
                                             "--part=-1")["tick"], 0)
        kerf("sheet", "material", "set", "foil", "--part", "0")
        scene = self.json_of("sheet", "get", "set")["scene"]
        self.assertEqual(scene["material"]["thickness_m"], 0.0003)
        self.assertEqual(scene["materials"][0]["material"]["density_kgpm3"], 2710)
        self.refused("sheet", "material", "set", "wood", says="wood")
        self.refused("sheet", "material", "set", "--with", "thickness_m=thin", code=2, says="thickness_m=0.001")
        self.refused("sheet", "material", "set", "--with", "thicknes_m=1", says="thicknes_m")
        self.refused("sheet", "material", "set", "--part", "1", says="UNKNOWN_PART")
        self.assertEqual(self.json_of("sheet", "speed", "set", "0.25")["speed"], 0.25)
        self.refused("sheet", "speed", "set", "5", says="0.01..4")
        self.json_of("sheet", "delete", "set")

    def test_output_for_people(self):
        done = kerf("sheet", "create", "people", "--grid", "5x5")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("25 vertices", done.stdout)
        self.assertIn("automatic: explicit; estimated per tick", kerf("sheet", "get", "people").stdout)
        self.assertIn("sheets/people", kerf("sheet", "list").stdout)
        self.assertIn("materials", kerf("info").stdout)

    def test_sheets_from_mesh_files(self):
        pathlib.Path(path("panel.ply")).write_bytes(panel("binary_big_endian"))
        made = self.json_of("sheet", "create", "panel", "--ply", path("panel.ply"), "--pin", "none")
        self.assertEqual((made["num_vertices"], made["num_triangles"], made["pieces"]), (8, 8, 1))
        self.json_of("sheet", "pause", "panel")
        cut = self.json_of("cut", "panel", "--polyline", "0.5,-1 0.5,4")
        self.assertEqual((cut["status"], cut["pieces"]), ("APPLIED", 2))
        kerf("export", "panel", "--out", path("panel.obj"))
        made = self.json_of("sheet", "create", "panel-again", "--obj", path("panel.obj"), "--pin", "none")
        self.assertEqual(made["pieces"], 2)
        bent = path("bent.obj")
        pathlib.Path(bent).write_text("v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
        for rest in ("auto", "surface"):
            self.json_of("sheet", "create", f"bent-{rest}", "--obj", bent, "--pin", "none", "--rest", rest)
            piece = self.json_of("pieces", f"bent-{rest}")["pieces"][0]
            self.assertAlmostEqual(piece["area_m2"], 1.25 ** 0.5, places=12)
        self.refused("sheet", "create", "none", "--obj", bent, "--rest", "flat", says="OBJ_NOT_PLANAR")
        self.refused("sheet", "create", "none", "--obj", bent, "--rest", "round", code=2, says="--rest")
        self.refused("sheet", "create", "none", "--rest", "surface", "--grid", "5x5", code=2, says="--grid")
        self.refused("sheet", "create", "none", "--ply", path("missing.ply"), says="FILE_NOT_FOUND")
        self.refused("sheet", "create", "none", "--ply", path("panel.obj"), says="PLY_HEADER")
        self.refused("sheet", "create", "none", "--ply", path("panel.ply"), "--grid", "5x5", code=2, says="--grid")
        self.refused("sheet", "create", "none", "--ply", path("panel.ply"), "--obj", path("panel.obj"), code=2)
        pathlib.Path(path("bow.ply")).write_bytes(panel("ascii", faces=((0, 1, 5), (0, 3, 7))))
        self.refused("sheet", "create", "none", "--ply", path("bow.ply"), "--pin", "none", says="MESH_NON_MANIFOLD_VERTEX")
        pathlib.Path(path("large.obj")).write_bytes(b"#" * (1 << 20))
        self.refused("sheet", "create", "none", "--obj", path("large.obj"), says="RESOURCE_EXHAUSTED")
        pathlib.Path(path("larger.obj")).write_bytes(b"#" * ((1 << 20) + 1))
        self.refused("sheet", "create", "none", "--obj", path("larger.obj"), says="FILE_TOO_LARGE")

    def test_sheets_with_an_integrator_of_their_own(self):
        made = self.json_of("sheet", "create", "euler", "--grid", "6x6", "--integrator", "implicit", "--solver", "direct")
        self.assertEqual((made["scene"]["integrator"]["kind"], made["scene"]["integrator"]["solver"]),
                         ("IMPLICIT_EULER", "DIRECT"))
        self.assertIn("implicit: Euler, one step a tick; direct solver", made["integrator"])
        made = self.json_of("sheet", "create", "leap", "--grid", "6x6", "--integrator", "explicit", "--precision", "double")
        self.assertEqual((made["scene"]["integrator"]["kind"], made["scene"]["integrator"]["precision"]),
                         ("EXPLICIT_LEAPFROG", "DOUBLE"))
        self.refused("sheet", "create", "none", "--integrator", "magic", code=2, says="--integrator")
        self.refused("sheet", "create", "none", "--precision", "half", code=2, says="--precision")
        self.refused("sheet", "create", "none", "--solver", "guess", code=2, says="--solver")

    def test_sheets_from_scene_files(self):
        pathlib.Path(path("scene-panel.ply")).write_bytes(panel("binary_little_endian"))
        scene = {"sheet_id": "of-the-file", "ply": {"file": "scene-panel.ply"}, "material": {"preset": "denim"},
                 "gravity_mps2": {"z": -1.5}, "integrator": {"kind": "BDF2"},
                 "constraints": [{"region": {"border": {}}}],
                 "commands": [{"tick": 3, "command": {"cut": {"curve": {"polyline": {"points": [
                     {"x": 0.5, "y": -1}, {"x": 0.5, "y": 4}]}}}}}]}
        pathlib.Path(path("live.json")).write_text(json.dumps(scene))
        made = self.json_of("sheet", "create", "live", "--scene", path("live.json"))
        self.assertEqual((made["name"], made["num_vertices"]), ("sheets/live", 8))
        self.assertEqual((made["scene"]["gravity_mps2"]["z"], made["scene"]["integrator"]["kind"]), (-1.5, "BDF2"))
        self.json_of("sheet", "pause", "live")
        self.json_of("sheet", "step", "live", "4")
        self.assertEqual(self.json_of("sheet", "get", "live")["pieces"], 2)
        made = self.json_of("sheet", "create", "live-again", "--scene", path("live.json"), "--integrator", "tr-bdf2")
        self.assertEqual(made["scene"]["integrator"]["kind"], "TR_BDF2")
        self.refused("sheet", "create", "none", "--scene", path("missing.json"), says="FILE_NOT_FOUND")
        scene["constraints"] = [{"region": {"box": {"min": {"x": 5, "y": 5}, "max": {"x": 6, "y": 6}}}}]
        pathlib.Path(path("empty.json")).write_text(json.dumps(scene))
        self.refused("sheet", "create", "none", "--scene", path("live.json"), "--grid", "5x5", code=2, says="--grid")
        self.refused("sheet", "create", "none", "--scene", path("live.json"), "--pin", "none", code=2, says="--pin")
        self.refused("sheet", "create", "none", "--scene", path("live.json"), "--material", "silk", code=2)
        del scene["commands"]
        pathlib.Path(path("empty.json")).write_text(json.dumps(scene))
        self.refused("sheet", "create", "none", "--scene", path("empty.json"), says="constraints[0].region")

    def test_refusals(self):
        self.refused("sheet", "create", "Bad_Name", says="sheet_id")
        self.refused("sheet", "create", "huge", "--grid", "1000x1000", says="500000")
        self.refused("sheet", "create", "flat", "--size", "1x0", says="height_m")
        self.refused("sheet", "create", "odd", "--material", "unobtainium", says="preset")
        self.refused("sheet", "create", "odd", "--part", "0,0,1=silk", code=2, says="--part")
        self.refused("sheet", "create", "odd", "--part", "sheet=silk", code=2, says="--part")
        self.refused("sheet", "create", "odd", "--part", "0,0,1,1", code=2, says="--part")
        self.refused("sheet", "create", "odd", "--part", "0,0,1,1=unobtainium", says="materials[0].material.preset")
        self.refused("sheet", "create", "odd", "--part", "4,4,5,5=silk", says="REGION_EMPTY")
        kerf("sheet", "create", "twice", "--grid", "3x3")
        self.refused("sheet", "create", "twice", "--grid", "3x3", says="ALREADY_EXISTS")
        for verb in ("get", "delete", "pause", "resume", "reset"):
            self.refused("sheet", verb, "nobody", says="NOT_FOUND")


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
        self.assertIn("layer: piece", kerf("cut", self.id, "--circle", "320,250,40", *view).stdout)
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
        self.assertIn("REDONE", kerf("redo", self.id).stdout)
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
        self.assertRegex(told.stdout, r"(?s)^APPLIED.*taken away: [0-9.e-]+ m\^2, [0-9.e-]+ kg, [0-9]+ vertices")
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
        self.assertIn("2 of 2 cuts APPLIED", kerf("cut", other, "--batch", file).stdout)
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
        text = kerf("cut", self.id, "--polyline", "0.2,0.45 0.7,0.5 0.2,0.5").stdout
        self.assertIn("0 below the contract", text)
        self.assertRegex(text, r"corner of \d+\.\d degrees at \(0\.7, 0\.5\) m: \d+ triangles below the angle")
        self.refused("cut", self.id, *curve, "--tolerance-m", "1e-9", says="TOLERANCE_TOO_SMALL")
        self.refused("cut", self.id, *curve, "--method", "element", "--tip-size", "0.01", says="OPTIONS_CONFLICT")

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
        self.assertRegex(text, r"note: gaps to older lips, the border or the path itself, closed: \d+, up to 1e-05 m wide")

    def test_options_may_follow_the_command(self):
        done = subprocess.run([OPTIONS.kerf, "cut", self.id, "--circle", "0.5,0.5,0.1", "--json", "--server",
                               SERVER["grpc"]], capture_output=True, text=True)
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


class Views(Case):
    @classmethod
    def setUpClass(cls):
        kerf("sheet", "create", "view", "--grid", "20x20")

    def test_render(self):
        done = kerf("render", "view", "--out", path("frame.png"), "--size", "320x200")
        if "renderer" in done.stderr:
            self.skipTest(done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(pathlib.Path(path("frame.png")).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        reply = self.json_of("render", "view", "--out", path("frame.jpg"), "--size", "320x200")
        self.assertEqual((reply["width_px"], reply["height_px"], reply["media_type"]), (320, 200, "image/jpeg"))
        self.assertEqual(pathlib.Path(path("frame.jpg")).read_bytes()[:2], b"\xff\xd8")
        near, flat = (self.json_of("render", "view", "--out", path(name), "--size", "64x64", *how) and
                      pathlib.Path(path(name)).read_bytes()
                      for name, how in (("near.png", ("--view", "0.5,-1,0.5 0.5,0,0.5", "--fov", "30")),
                                        ("flat.png", ("--undeformed", "--wireframe"))))
        self.assertNotEqual(near, flat)
        colours = set()
        for by in ("sides", "pieces", "strains"):
            self.json_of("render", "view", "--out", path("by.png"), "--size", "64x64", "--color-by", by)
            colours.add(open(path("by.png"), "rb").read())
        self.assertEqual(len(colours), 3)
        self.refused("render", "view", "--out", path("a.png"), "--color-by", "mood", code=2, says="--color-by")
        self.refused("render", "view", "--out", path("a.png"), "--view", "0,0,0 0,0,0", says="CAMERA_SINGULAR")
        self.refused("render", "view", "--out", path("a.png"), "--view", "0,0,0", code=2, says="--view")
        self.refused("render", "view", "--out", path("a.png"), "--fov", "30", code=2)
        self.refused("render", "view", "--out", path("a.png"), "--size", "9999x10", says="width_px")
        self.refused("render", "view", "--out", path("a.gif"), code=2, says="--out")
        self.refused("render", "view", "--out", "/nonexistent/a.png", says="/nonexistent/a.png")
        self.assertFalse(os.path.exists(path("a.png")))

    def test_export(self):
        self.assertEqual(kerf("export", "view", "--out", path("view.obj")).returncode, 0)
        lines = pathlib.Path(path("view.obj")).read_text().splitlines()
        self.assertEqual(sum(line.startswith("v ") for line in lines), 400)
        self.assertEqual(sum(line.startswith("f ") for line in lines), 722)
        for line in lines:
            if line.startswith("v "):
                self.assertTrue(all(math.isfinite(float(number)) for number in line.split()[1:]))
        self.assertEqual(kerf("export", "view", "--out", path("view.glb")).returncode, 0)
        file = pathlib.Path(path("view.glb")).read_bytes()
        self.assertEqual(struct.unpack("<4sII", file[:12]), (b"glTF", 2, len(file)))
        gltf = json.loads(file[20:20 + struct.unpack("<I", file[12:16])[0]])
        self.assertEqual([accessor["count"] for accessor in gltf["accessors"]], [400, 400, 400, 400, 3 * 722])

    def test_watch(self):
        done = kerf("--json", "watch", "view", "--frames", "5")
        self.assertEqual(done.returncode, 0, done.stderr)
        frames = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([frame["sequence"] for frame in frames], [1, 2, 3, 4, 5])
        self.assertEqual(frames[0]["kind"], "keyframe")
        ticks = [frame["tick"] for frame in frames]
        self.assertEqual(ticks, sorted(set(ticks)))
        self.refused("watch", "nobody", "--frames", "1", says="NOT_FOUND")


class Offline(Case):
    def scene(self, name, **changes):
        scene = {name: value for name, value in {**SMALL_SCENE, **changes}.items() if value is not None}
        pathlib.Path(path(name)).write_text(json.dumps(scene))
        return path(name)

    def test_scenes_may_name_svg_files_beside_them(self):
        pathlib.Path(path("leaf.svg")).write_text('<svg viewBox="0 0 9 9"><path d="M1 1Q8 1 8 8Q1 8 1 1Z"/></svg>')
        cut = {"curve": {"svg": {"file": "leaf.svg"}}, "fit": {"min": {"x": 0.2, "y": 0.2}, "max": {"x": 0.8, "y": 0.8}}}
        scene = self.scene("leaf.json", commands=[{"tick": 5, "command": {"cut": cut}}])
        result = self.json_of("run", scene, "--record", path("leaf.rec"))
        self.assertEqual((result["cuts"][0]["status"], result["pieces"]), ("APPLIED", 2))
        self.assertEqual(self.json_of("replay", path("leaf.rec"))["state_hash"], result["state_hash"])

    def test_scenes_may_name_or_hold_mesh_files(self):
        pathlib.Path(path("ring.ply")).write_bytes(panel("binary_little_endian"))
        changes = {"grid": None, "pins": [], "commands": [
            {"tick": 5, "command": {"cut": {"curve": {"polyline": {"points": [{"x": 0.5, "y": -1}, {"x": 0.5, "y": 4}]}}}}}]}
        named = self.json_of("run", self.scene("named.json", ply={"file": "ring.ply"}, **changes), "--record", path("ring.rec"))
        self.assertEqual((named["cuts"][0]["status"], named["pieces"]), ("APPLIED", 2))
        self.assertEqual(self.json_of("replay", path("ring.rec"))["state_hash"], named["state_hash"])
        held = {"data": base64.b64encode(panel("binary_little_endian")).decode()}
        self.assertEqual(self.json_of("run", self.scene("held.json", ply=held, **changes))["state_hash"], named["state_hash"])
        self.refused("run", self.scene("gone.json", ply={"file": "gone.ply"}, **changes), says="gone.ply")

    def test_run_record_replay(self):
        scene = self.scene("small.json")
        first = self.json_of("run", scene, "--out", path("result.json"), "--record", path("small.rec"))
        self.assertEqual((first["ticks"], first["pieces"], first["scene"]), (20, 2, "small"))
        self.assertEqual(first["cuts"][0]["status"], "APPLIED")
        self.assertEqual(json.loads(pathlib.Path(path("result.json")).read_text())["state_hash"], first["state_hash"])
        self.assertEqual(self.json_of("run", scene)["state_hash"], first["state_hash"])
        self.assertEqual(self.json_of("run", scene, "--ticks", "30")["ticks"], 30)
        replayed = self.json_of("replay", path("small.rec"))
        self.assertEqual((replayed["identical"], replayed["ticks"]), (True, 20))
        self.assertEqual(replayed["state_hash"], first["state_hash"])

    def test_an_equilibrium_by_loads_with_its_tables(self):
        pulled = {"commands": [{"tick": 2, "command": {"cut": {"curve": {"polyline": {"points": [
                      {"x": -0.1, "y": 0.5}, {"x": 0.5, "y": 0.5}]}}}}}],
                  "pins": [{"edge": "BOTTOM"}], "planar": True, "gravity_mps2": {},
                  "placement": {"y_axis": {"y": 1}},
                  "loads": [{"edge": {"region": {"edge": "TOP"}, "force_n": {"y": 1.0}}}],
                  "analysis": {"static": {"steps": 2}},
                  "probes": [{"name": "top", "quantity": "DISPLACEMENT", "region": {"edge": "TOP"}},
                             {"name": "held", "quantity": "REACTION", "region": {"edge": "BOTTOM"}}]}
        folder = path("tables")
        os.makedirs(folder, exist_ok=True)
        result = self.json_of("run", self.scene("pulled.json", **pulled), "--csv", folder)
        self.assertEqual((result["ticks"], result["static"]["load"], result["static"]["converged"]), (2, 1.0, True))
        table = result["tables"][0]
        self.assertEqual(table["columns"], ["load", "top.x", "top.y", "top.z", "held.x", "held.y", "held.z"])
        half, whole = (row["values"] for row in table["rows"])
        self.assertAlmostEqual(half[5], -0.5, 9)
        self.assertAlmostEqual(whole[5], -1.0, 9)
        self.assertGreater(whole[2], 2.1 * half[2])  # the cut came in between
        lines = pathlib.Path(folder, "probes.csv").read_text().splitlines()
        self.assertEqual(lines[0], ",".join(table["columns"]))
        self.assertEqual([float(cell) for cell in lines[2].split(",")], whole)
        people = kerf("run", self.scene("pulled.json", **pulled)).stdout
        self.assertIn("equilibrium at load 1,", people)
        self.assertIn("top.y", people)
        # Nothing holds it: what there is comes with a status of its own.
        free = self.scene("free.json", **{**pulled, "pins": [], "analysis": {"static": {"max_iterations": 3}}})
        done = kerf("--json", "run", free)
        self.assertEqual((done.returncode, json.loads(done.stdout)["static"]["converged"]), (1, False))
        self.assertIn("no equilibrium was found beyond load 0", done.stderr)
        self.assertIn("nothing holds the sheet", done.stderr)
        self.assertIn("along y", done.stderr)
        windy = self.scene("windy.json", **{**pulled, "wind": {"velocity_mps": {"x": 1}}})
        self.assertIn("left out: wind", kerf("run", windy).stdout)
        self.refused("run", self.scene("pulled.json", **pulled), "--record", path("no.rec"), says="dynamic")
        self.refused("run", self.scene("odd.json", probes=[{"name": "a", "quantity": "POSITION", "points": [{"x": 9}]}]),
                     says="probes[0].points[0]")

    def test_vibrations_by_scene_and_of_a_live_sheet(self):
        modes = self.json_of("run", self.scene(
            "modes.json", commands=[], gravity_mps2={}, analysis={"modes": {"count": 3, "about": {}}},
            pins=[{"edge": edge} for edge in ("TOP", "BOTTOM", "LEFT", "RIGHT")]))
        self.assertEqual([table["name"] for table in modes["tables"]], ["modes"])
        frequencies = [row["values"][2] for row in modes["tables"][0]["rows"]]
        self.assertEqual(frequencies, sorted(frequencies))
        self.assertGreater(frequencies[0], 0.01)
        self.json_of("sheet", "create", "rests", "--grid", "12x12")
        live = self.json_of("analyze", "rests", "--modes", "3")
        self.assertEqual((live["name"], len(live["tables"][0]["rows"])), ("sheets/rests", 3))
        hanging = self.json_of("analyze", "rests", "--modes", "2", "--resting")
        self.assertTrue(hanging["static"]["converged"])
        pathlib.Path(path("request.json")).write_text(json.dumps({"analysis": {"static": {}}, "probes": [
            {"name": "top", "quantity": "REACTION", "region": {"edge": "TOP"}}]}))
        asked = self.json_of("analyze", "rests", "--request", path("request.json"))
        self.assertEqual(asked["tables"][0]["columns"][3], "top.z")
        self.assertGreater(asked["tables"][0]["rows"][0]["values"][3], 0.0)
        self.assertIn("equilibrium at load 1", kerf("analyze", "rests").stdout)
        self.refused("analyze", "nobody", says="nobody")
        self.refused("analyze", "rests", "--modes", "0", code=2)
        self.refused("analyze", "rests", "--resting", code=2)
        self.json_of("sheet", "delete", "rests")

    def test_ticks_to_come_of_a_live_sheet(self):
        falls = {"grid": {"columns": 8, "rows": 8, "width_m": 1, "height_m": 1}, "pins": [{"edge": "TOP"}],
                 "probes": [{"name": "low", "quantity": "POSITION", "points": [{"x": 0.5, "y": 0}]},
                            {"name": "all", "quantity": "ENERGY"}]}
        pathlib.Path(path("falls.json")).write_text(json.dumps(falls))
        self.json_of("sheet", "create", "falls", "--scene", path("falls.json"))
        self.json_of("sheet", "pause", "falls")
        folder = path("ticks")
        os.makedirs(folder, exist_ok=True)
        before = self.json_of("sheet", "get", "falls")
        self.assertEqual(before["flagged_ticks"], {})
        ahead = self.json_of("analyze", "falls", "--dynamic", "--ticks", "30", "--every", "12", "--csv", folder)
        self.assertEqual(self.json_of("sheet", "get", "falls")["state_hash"], before["state_hash"])
        self.assertEqual((ahead["tick"], ahead["dynamic"]["ticks"]), (before["tick"], 30))
        rows = [row["values"] for row in ahead["tables"][0]["rows"]]
        self.assertEqual([round(60 * row[0]) for row in rows], [0, 12, 24, 30])
        self.assertAlmostEqual(rows[3][-1], sum(rows[3][-5:-1]), 12)
        lines = pathlib.Path(folder, "probes.csv").read_text().splitlines()
        self.assertEqual(lines[0], "time_s,low.x,low.y,low.z,all.kinetic,all.membrane,all.bending,all.gravity,all.total")
        self.assertEqual([float(cell) for cell in lines[4].split(",")], rows[3])
        self.assertEqual(self.json_of("sheet", "step", "falls", "30")["state_hash"], ahead["dynamic"]["state_hash"])
        people = kerf("analyze", "falls", "--dynamic").stdout
        self.assertIn(f"falls as it was at tick {before['tick'] + 30}", people)
        self.assertIn("0 ticks, 0 s: kinetic", people)
        pathlib.Path(path("ahead.json")).write_text(json.dumps({"analysis": {"dynamic": {"ticks": 2}}, "probes": [
            {"name": "top", "quantity": "STRESS", "region": {"edge": "TOP"}, "recovery": "PATCH", "stress_measure": "CAUCHY"}]}))
        asked = self.json_of("analyze", "falls", "--request", path("ahead.json"))["tables"][0]
        self.assertEqual((asked["columns"], len(asked["rows"])), (["time_s", "top.xx", "top.yy", "top.xy"], 3))
        self.refused("analyze", "falls", "--dynamic", "--request", path("ahead.json"), code=2, says="analysis")
        pathlib.Path(path("probes.json")).write_text(json.dumps({"probes": [{"name": "all", "quantity": "MOMENTUM"}]}))
        beside = self.json_of("analyze", "falls", "--dynamic", "--ticks", "4", "--request", path("probes.json"))["tables"][0]
        self.assertEqual((beside["columns"][3], len(beside["rows"])), ("all.z", 5))
        self.assertTrue(all(math.isfinite(value) for row in asked["rows"] for value in row["values"]))
        self.refused("analyze", "falls", "--ticks", "3", code=2)
        self.refused("analyze", "falls", "--dynamic", "--ticks", "100001", code=2)
        self.refused("analyze", "falls", "--dynamic", "--modes", "3", code=2)
        self.json_of("sheet", "delete", "falls")

    def test_flags_of_a_live_sheets_ticks_are_counted(self):
        scene = self.scene("limited.json", integrator={"kind": "EXPLICIT_LEAPFROG", "max_substeps": 1})
        self.json_of("sheet", "create", "short", "--scene", scene)
        live = int(self.json_of("sheet", "pause", "short")["flagged_ticks"].get("substep_limit", 0))
        self.json_of("sheet", "step", "short", "5")
        counted = str(live + 5)
        self.assertEqual(self.json_of("sheet", "get", "short")["flagged_ticks"]["substep_limit"], counted)
        listed = next(sheet for sheet in self.json_of("sheet", "list")["sheets"] if sheet["name"] == "sheets/short")
        self.assertEqual(listed["flagged_ticks"]["substep_limit"], counted)
        self.assertIn("ticks flagged substep_limit " + counted, kerf("sheet", "list").stdout)
        self.json_of("sheet", "reset", "short")
        self.assertEqual(self.json_of("sheet", "get", "short")["flagged_ticks"]["substep_limit"], counted)
        self.json_of("sheet", "delete", "short")

    def test_energies_and_cpu_time_are_told(self):
        # Nothing moves and nothing is stretched: all there is is weight at a height.
        still = self.json_of("run", self.scene("still.json", commands=[], pins=[{"box": {"min": {"x": 0, "y": 0},
                                                                                         "max": {"x": 1, "y": 1}}}],
                                               placement={"origin": {"z": 2}, "y_axis": {"y": 1}},
                                               material={"density_kgpm3": 400, "thickness_m": 0.0005}))
        energies = still["energies"]
        self.assertAlmostEqual(energies["gravity_j"], 0.0005 * 400 * 9.81 * 2, 6)
        for none in ("kinetic_j", "membrane_j", "bending_j"):
            self.assertAlmostEqual(energies[none], 0.0, 9)
        # Falls freely for 20 ticks: what it loses in height it has in speed.
        falling = self.json_of("run", self.scene("falling.json", commands=[], pins=[],
                                                 placement={"origin": {"z": 2}, "y_axis": {"y": 1}},
                                                 material={"density_kgpm3": 400, "thickness_m": 0.0005,
                                                           "mass_damping_per_s": 0}))
        fallen = energies["gravity_j"] - falling["energies"]["gravity_j"]
        self.assertGreater(fallen, 0.5)
        self.assertAlmostEqual(falling["energies"]["kinetic_j"], fallen, delta=0.05 * fallen)
        for result in (still, falling):
            self.assertGreater(result["cpu_s"], 0.0)
            self.assertAlmostEqual(result["cpu_per_tick_us"], 1e6 * result["cpu_s"] / 20, 6)

    def test_time_that_was_not_simulated_is_told(self):
        whole = self.json_of("run", self.scene("whole.json"))
        self.assertAlmostEqual(whole["simulated_s"], 20 / 60, 9)
        self.assertNotIn("substep_limit", whole.get("flagged_ticks", {}))
        short = self.json_of("run", self.scene("short.json", integrator={"kind": "EXPLICIT_LEAPFROG", "max_substeps": 1}))
        self.assertEqual(short["flagged_ticks"]["substep_limit"], "20")
        self.assertLess(short["simulated_s"], 0.5 * whole["simulated_s"])

    def test_mixed_precision_is_another_trajectory_near_that_of_double(self):
        results = [self.json_of("run", self.scene("precision.json"), "--integrator", "explicit", "--precision", precision)
                   for precision in ("double", "mixed")]
        self.assertNotEqual(results[0]["state_hash"], results[1]["state_hash"])
        energies = [result["energies"]["kinetic_j"] for result in results]
        self.assertAlmostEqual(energies[0], energies[1], delta=1e-3 * abs(energies[0]))

    def test_the_green_law_is_another_trajectory_near_the_corotational_one(self):
        recording = path("green.rec")
        green = self.json_of("run", self.scene("law.json", membrane_law="GREEN"), "--record", recording)
        self.assertEqual(self.json_of("replay", recording)["state_hash"], green["state_hash"])
        chosen = self.json_of("run", self.scene("law.json"), "--membrane-law", "green")
        self.assertEqual(chosen["state_hash"], green["state_hash"])
        corotational = self.json_of("run", self.scene("law.json", membrane_law="GREEN"), "--membrane-law", "corotational")
        self.assertEqual(corotational["state_hash"], self.json_of("run", self.scene("law.json"))["state_hash"])
        self.assertNotEqual(corotational["state_hash"], green["state_hash"])
        kinetic = corotational["energies"]["kinetic_j"]
        self.assertAlmostEqual(green["energies"]["kinetic_j"], kinetic, delta=0.02 * kinetic)
        self.refused("run", self.scene("law.json"), "--membrane-law", "hooke", code=2, says="hooke")

    def test_every_linear_solver_ends_near_the_direct_one(self):
        scene = self.scene("solvers.json", integrator={"solver_tolerance": 1e-9, "max_linear_iterations": 100000})
        results = {solver: self.json_of("run", scene, "--integrator", "implicit", "--solver", solver)
                   for solver in ("direct", "cg", "jacobi-cg", "block-jacobi-cg", "factor-cg", "multigrid-cg")}
        self.assertEqual(len({result["state_hash"] for result in results.values()}), 6)
        exact = results["direct"]["energies"]["kinetic_j"]
        for solver, result in results.items():
            self.assertAlmostEqual(result["energies"]["kinetic_j"], exact, delta=1e-6 * exact, msg=solver)
        self.assertIn("plain conjugate gradients", results["cg"]["integrator"])
        self.refused("run", scene, "--solver", "gauss", code=2, says="gauss")

    def test_one_linear_solve_a_tick_can_be_asked_for(self):
        scene = self.scene("baseline.json", commands=[], integrator={
            "kind": "IMPLICIT_EULER", "newton_iterations": 1, "solver": "PLAIN_CG", "max_linear_iterations": 3})
        limited = self.json_of("run", scene)
        self.assertEqual(limited["flagged_ticks"]["not_converged"], "20")
        self.refused("run", self.scene("none.json", integrator={"max_linear_iterations": -1}), says="max_linear_iterations")

    def test_solvers_of_another_system_say_so(self):
        implicit = {"kind": "IMPLICIT_EULER"}
        sound = self.json_of("run", self.scene("sound.json", integrator=implicit))
        self.assertLess(sound["linear_residual"], 1e-3)
        self.assertGreater(int(sound["linear_iterations"]), 20)
        scene = self.scene("es.json", integrator=implicit, commands=[], grid={"columns": 6, "rows": 6, "width_m": 1, "height_m": 1})
        for solver in ("es-cgm", "as-cgm"):
            result = self.json_of("run", scene, "--solver", solver)
            self.assertIn("solves a different system", result["integrator"])
            self.assertGreater(result["linear_residual"], 0.1)
            self.assertEqual(result["flagged_ticks"]["not_converged"], "20")
            self.assertIn("residual at most", kerf("run", scene, "--solver", solver).stdout)
            self.refused("run", self.scene("large.json", grid={"columns": 3, "rows": 167, "width_m": 1, "height_m": 1},
                                           integrator=implicit), "--solver", solver, says="SOLVER_TOO_DENSE")
        self.refused("run", self.scene("p.json", integrator={"covariance_root": {"p": 3}}), says="covariance_root.p")

    def test_a_tampered_recording_names_the_tick(self):
        self.json_of("run", self.scene("tamper.json"), "--record", path("tamper.rec"))
        content = bytearray(pathlib.Path(path("tamper.rec")).read_bytes())
        content[-1] ^= 1  # the last tick's hash
        pathlib.Path(path("tamper.rec")).write_bytes(content)
        self.assertEqual(kerf("--json", "replay", path("tamper.rec")).returncode, 1)
        self.refused("replay", path("tamper.rec"), says="tick 20")
        pathlib.Path(path("cut.rec")).write_bytes(content[:-3])
        self.refused("replay", path("cut.rec"), says="offset")
        pathlib.Path(path("text.rec")).write_text("no recording at all")
        self.refused("replay", path("text.rec"))

    def test_refusals(self):
        self.refused("run", path("missing.json"), says="missing.json")
        self.refused("run", self.scene("bad.json", gravity_mps2={"x": "NaN"}), says="gravity_mps2")
        self.refused("run", self.scene("typo.json", colour="red"), says="colour")
        self.refused("run", self.scene("small.json"), "--out", "/nonexistent/r.json", says="/nonexistent")
        self.refused("run", self.scene("small.json"), "--ticks", "0", code=2)
        pathlib.Path(path("broken.json")).write_text('{"grid": ')
        self.refused("run", path("broken.json"), says="line 1")

    def test_demo_scene(self):
        done = self.json_of("run", str(ROOT / "deploy/scenes/demo.json"), "--ticks", "10")
        self.assertEqual(done["num_vertices"], 2500)


class Load(Case):
    SMALL = ("load", "--grid", "6x6", "--warm-up", "0.1", "--duration", "0.5")

    def loaded(self):
        return [sheet["name"] for sheet in self.json_of("sheet", "list")["sheets"] if "load" in sheet["name"]]

    def test_json_text_and_html(self):
        report = self.json_of(*self.SMALL, "--sheets", "2", "--viewers", "3", "--cuts-per-second", "8", "--html", path("load.html"))
        self.assertEqual((report["sheets"]["made"], report["readers"]["viewers"]["readers"], report["cuts"]["sent"]), (2, 3, 4))
        self.assertEqual(report["errors"], {})
        page = pathlib.Path(path("load.html")).read_text()
        self.assertEqual(page.count("<svg"), page.count("</svg>"))
        self.assertGreater(page.count("<svg"), 2)
        self.assertIn("4 of 4" if report["cuts"]["applied"] == 4 else f"{report['cuts']['applied']} of 4", page)
        done = kerf(*self.SMALL)
        self.assertEqual(done.returncode, 0, done.stderr)
        for word in ("sheets     1 of 1", "real time", "a thread that only sleeps", "p99.9"):
            self.assertIn(word, done.stdout)
        self.assertEqual(done.stderr, "")  # no line that is written over and over where nobody sees it
        self.assertEqual(self.loaded(), [])

    def test_interrupted_it_tells_what_it_has_and_deletes_its_sheets(self):
        process = subprocess.Popen([OPTIONS.kerf, "--server", SERVER["grpc"], "--json", "load", "--grid", "6x6", "--duration", "600"],
                                   stdout=subprocess.PIPE, text=True)
        while not self.loaded():
            pass
        process.send_signal(signal.SIGINT)
        report = json.loads(process.communicate(timeout=60)[0])
        self.assertEqual(process.returncode, 0)
        self.assertTrue(report["interrupted"])
        self.assertEqual(self.loaded(), [])

    def test_wrong_options_are_refused_before_anything_is_made(self):
        for options, says in ((("--sheets", "10001"), "1..10000"), (("--grid", "big"), "50x50"), (("--duration", "0"), "0.1..1800"),
                              (("--viewers", "-1"), "0..1000"), (("--transport", "ws"), "--http"), (("--prefix", "Load"), "--prefix"),
                              (("--image-size", "1x1"), "16..4096")):
            self.refused("load", *options, code=2, says=says)
        self.refused(*self.SMALL, "--html", "/nonexistent/report.html", says="/nonexistent")
        self.assertEqual(self.loaded(), [])


class Usage(Case):
    def test_help_and_version(self):
        for command in ([], ["sheet"], ["sheet", "create"], ["cut"], ["cuts"], ["undo"], ["redo"], ["pieces"], ["render"], ["watch"], ["export"], ["run"], ["replay"], ["analyze"], ["load"]):
            done = kerf(*command, "--help", server=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("Usage", done.stdout)
        self.assertIn("kerf ", kerf("--version", server=False).stdout)

    def test_wrong_usage(self):
        for command in ([], ["fly"], ["sheet"], ["sheet", "create"], ["cut", "a", "--spline", "x"],
                        ["sheet", "create", "a", "--grid", "big"], ["sheet", "create", "a", "--pin", "left"],
                        ["sheet", "step", "a", "many"], ["watch", "a", "--frames", "-1"]):
            self.assertEqual(kerf(*command, server=False).returncode, 2, command)

    def test_no_server(self):
        done = subprocess.run([OPTIONS.kerf, "--server", "127.0.0.1:1", "sheet", "list"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no Kerf server answers at 127.0.0.1:1", done.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kerf", required=True)
    parser.add_argument("--kerfd", required=True)
    parser.add_argument("--work", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
