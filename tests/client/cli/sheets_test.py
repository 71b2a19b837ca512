"""`kerf sheet`: sheets made, listed, run and removed; what is refused."""

import json
import pathlib

from cli_case import ROOT, Case, kerf, main, panel, path, scene_file, setUpModule, tearDownModule


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

    def test_a_stiff_sheet_in_real_time(self):
        exact = self.json_of("sheet", "create", "exact", "--grid", "50x50", "--material", "wool", "--paused")
        self.assertEqual(exact["scene"]["fidelity"], "EXACT")
        self.assertNotIn("softening", exact)
        soft = self.json_of("sheet", "create", "soft", "--grid", "50x50", "--material", "wool", "--paused",
                            "--fidelity", "real-time")
        self.assertEqual(soft["scene"]["fidelity"], "REAL_TIME")
        self.assertEqual(soft["scene"]["material"], exact["scene"]["material"])
        self.assertEqual((soft["softening"]["factor"], soft["softening"]["fits"]), (16, True))
        self.assertAlmostEqual(soft["softening"]["expected_error_m"], 0.0021, delta=0.0001)
        self.assertIn("membrane 16 times softer", kerf("sheet", "get", "soft").stdout)
        self.refused("sheet", "create", "none", "--fidelity", "quick", code=2, says="quick")
        for name in ("exact", "soft"):
            self.json_of("sheet", "delete", name)

    def test_clusters_that_cuts_make_are_told_of(self):
        whole = self.json_of("sheet", "create", "slivers", "--grid", "20x20", "--paused")
        self.assertNotIn("local_inertia", whole)
        for line in ("0.1,0.5 0.9,0.55", "0.1,0.55 0.9,0.5", "0.1,0.53 0.9,0.531"):
            kerf("cut", "slivers", "--polyline", line)
        inertia = self.json_of("sheet", "get", "slivers")["local_inertia"]
        self.assertGreaterEqual(inertia["vertices"], inertia["largest_cluster_vertices"])
        self.assertGreater(inertia["plain_substeps"], 2 * inertia["planned_substeps"])
        self.assertIn(f"local inertia: {inertia['clusters']} clusters of {inertia['vertices']} vertices",
                      kerf("sheet", "get", "slivers").stdout)
        self.json_of("sheet", "delete", "slivers")

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

    def test_saved_states(self):
        self.json_of("sheet", "create", "states", "--grid", "9x9", "--paused")
        self.assertIn("no saved states", kerf("sheet", "states", "states").stdout)
        saved = self.json_of("sheet", "save", "states", "before")
        self.assertEqual((saved["name"], saved["tick"], saved["num_vertices"]), ("sheets/states/states/before", 0, 81))
        self.refused("sheet", "save", "states", "before", says="STATE_EXISTS")
        self.json_of("sheet", "step", "states", "3")
        self.assertEqual(self.json_of("sheet", "save", "states", "before", "--overwrite")["tick"], 3)
        self.json_of("cut", "states", "--polyline", "0.4,-1 0.5,2")
        self.assertIn("tick 3, 81 vertices", kerf("sheet", "states", "states").stdout)
        back = self.json_of("sheet", "restore", "states", "before")
        self.assertEqual((back["tick"], back["pieces"]), (3, 1))
        self.assertEqual(len(self.json_of("sheet", "states", "states")["states"]), 1)
        self.assertIn("sheets/states/states/before deleted", kerf("sheet", "forget", "states", "before").stdout)
        self.refused("sheet", "restore", "states", "before", says="no saved state")
        self.refused("sheet", "forget", "states", "before", says="no saved state")
        self.refused("sheet", "save", "states", "Before", says="state_id")
        self.refused("sheet", "save", "states", code=2, says="NAME")
        self.refused("sheet", "save", "nobody", "before", says="nobody")
        self.json_of("sheet", "delete", "states")

    def test_self_contact_of_a_running_sheet(self):
        self.json_of("sheet", "create", "folds", "--grid", "9x9", "--paused")
        self.json_of("sheet", "self-contact", "folds", "on", "--friction", "0.5")
        self.json_of("sheet", "self-contact", "folds", "--thickness", "0.002")
        contact = self.json_of("sheet", "get", "folds")["scene"]["self_contact"]
        self.assertEqual(contact, {"mode": "ON", "friction": 0.5, "thickness_m": 0.002})
        self.assertNotIn("intersection", kerf("sheet", "get", "folds").stdout)
        self.json_of("sheet", "self-contact", "folds", "off")
        contact = self.json_of("sheet", "get", "folds")["scene"]["self_contact"]
        self.assertEqual(contact, {"mode": "OFF", "friction": 0.5, "thickness_m": 0.002})
        self.json_of("sheet", "self-contact", "folds", "--material-thickness")
        contact = self.json_of("sheet", "get", "folds")["scene"]["self_contact"]
        self.assertEqual(contact, {"mode": "OFF", "friction": 0.5})
        self.refused("sheet", "self-contact", "folds", code=2, says="give on, off, --friction, --thickness or")
        self.refused("sheet", "self-contact", "folds", "--thickness", "0.01", "--material-thickness", code=2, says="excludes")
        self.refused("sheet", "self-contact", "folds", "maybe", code=2, says="maybe")
        self.refused("sheet", "self-contact", "folds", "--thickness", "0", says="set_self_contact.thickness_m")
        self.refused("sheet", "self-contact", "nobody", "on", says="nobody")
        self.json_of("sheet", "delete", "folds")

    def test_intersections_are_counted(self):
        mesh = {"material_positions": [0, 0, 1, 0, 0, 1, 2, 0, 3, 0, 2, 1], "triangles": [0, 1, 2, 3, 4, 5],
                "positions": [0, 0, 0, 1, 0, 0, 0, 1, 0, 0.2, 0.2, -0.5, 0.2, 0.2, 0.5, 1.2, 0.2, -0.5]}
        scene = scene_file("pierced.json", grid=None, pins=[], commands=[], inline=mesh, ticks=3,
                           gravity_mps2={"z": 0}, self_contact={"mode": "ON"})
        self.json_of("sheet", "create", "pierced", "--scene", scene, "--paused")
        self.json_of("sheet", "step", "pierced", "1")
        self.assertEqual(self.json_of("sheet", "get", "pierced")["intersections"], 1)
        self.assertIn("\n  1 intersection\n", kerf("sheet", "get", "pierced").stdout)
        self.json_of("sheet", "delete", "pierced")
        self.assertEqual(self.json_of("run", scene)["self_contact"]["intersections"], 3)
        self.assertIn(", 3 intersections\n", kerf("run", scene).stdout)

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
        made = kerf("sheet", "create", "bow", "--ply", path("bow.ply"), "--pin", "none")
        self.assertIn("note: faces come apart that meet only at vertex 0 (line ", made.stdout)
        # Beyond a message it comes in parts.
        content = pathlib.Path(path("panel.obj")).read_bytes()
        pathlib.Path(path("large.obj")).write_bytes(b"# comment\n" * (1 << 17) + content)
        self.json_of("sheet", "create", "large", "--obj", path("large.obj"))
        self.json_of("sheet", "delete", "large")
        with open(path("larger.obj"), "wb") as file:
            file.truncate((64 << 20) + 1)
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

    def test_components_are_cut_by_name_in_their_own_coordinates(self):
        ribbon = str(ROOT / "deploy/scenes/ribbon.json")
        self.json_of("sheet", "create", "band", "--scene", ribbon, "--paused")
        places = self.json_of("sheet", "get", "band")["components"]
        self.assertEqual([(each["name"], each["num_vertices"]) for each in places], [("cloth", 400), ("ribbon", 80)])
        self.assertEqual(places[1]["offset"], {"x": 1.1, "y": 0})
        self.assertIn("component ribbon: 0,0 to 1,0.16, offset 1.1,0; vertices 400 to 479",
                      kerf("--verbose", "sheet", "get", "band").stdout)
        across = self.json_of("cut", "band", "--polyline", "-5,0.1 5,0.1", "--component", "ribbon")
        self.assertEqual((across["status"], across["pieces"]), ("APPLIED", 3))
        self.assertIn("5 pieces", kerf("cut", "band", "--polyline", "-5,0.05 5,0.05").stdout)
        self.refused("cut", "band", "--circle", "0.5,0.5,0.1", "--component", "band", says="cloth, ribbon")
        self.refused("cut", "band", "--circle", "9,9,5", "--component", "cloth", "--view", "0,0,2 0,0,0", code=2,
                     says="--component")
        exported = path("band-cuts.json")
        self.assertEqual(kerf("cuts", "band", "--export", exported).returncode, 0)
        self.assertEqual(json.loads(pathlib.Path(exported).read_text())["cuts"][0]["component"], "ribbon")
        self.json_of("sheet", "reset", "band")
        self.assertEqual(self.json_of("cut", "band", "--batch", exported)["pieces"], 5)

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

    def refused_report(self, *arguments):
        """Returns the report of a file that makes no sheet."""
        done = kerf("--json", "inspect", *arguments, server=False)
        self.assertEqual(done.returncode, 1, done.stderr)
        return json.loads(done.stdout)

    def test_mesh_files_are_mended_and_inspected(self):
        # A quilt whose squares have vertices of their own, in millimetres, y up; and a panel of one face.
        quilt, panel_file = (str(ROOT / f"deploy/examples/{name}.obj") for name in ("quilt_mm", "panel"))
        report = self.json_of("inspect", quilt, "--unit", "mm", "--up", "y")
        self.assertEqual((report["num_vertices"], report["pieces"], report["file_faces"]), (20, 1, 12))
        self.assertAlmostEqual(report["area_m2"], 0.12, places=12)
        self.assertEqual(report["faults"], [])
        said = kerf("inspect", quilt, server=False)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("if the file is in millimetres, pass --unit mm", said.stdout)
        self.assertIn("size 0.4 m x 0 mm x 0.3 m", kerf("inspect", quilt, "--unit", "mm", "--up", "y", server=False).stdout)
        self.assertEqual(self.json_of("inspect", quilt, "--scale", "0.001", "--join", "0")["pieces"], 12)
        self.assertEqual(self.json_of("inspect", panel_file)["num_triangles"], 6)
        made = kerf("sheet", "create", "quilt", "--obj", quilt, "--unit", "mm", "--pin", "none")
        self.assertIn("  note: joined ", made.stdout)
        self.assertEqual(self.json_of("sheet", "get", "quilt")["pieces"], 1)
        self.assertEqual(len(self.json_of("sheet", "get", "quilt")["mesh_notes"]), 1)
        # Faults: exit code 1, each with its line.
        square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        pathlib.Path(path("faults.obj")).write_text(square + "f 1 2 x\nf 1 2\n")
        bad = kerf("inspect", path("faults.obj"), server=False)
        self.assertEqual(bad.returncode, 1)
        self.assertIn("  fault: line 5: ", bad.stdout)
        self.assertIn("  fault: line 6: ", bad.stdout)
        self.refused("sheet", "create", "none", "--obj", path("faults.obj"), says="line 6: ")
        self.refused("inspect", path("missing.obj"), says="FILE_NOT_FOUND")
        self.refused("inspect", quilt, "--unit", "mile", code=2, says="--unit")
        lacking = self.refused_report(quilt, "--object", "left")
        self.assertIn('no object or group "left" with faces; it has quilt', lacking["faults"][0])
        self.refused("sheet", "create", "none", "--unit", "mm", "--grid", "5x5", code=2, says="--grid")
        # A mark at the front, lines that end with CR, and a turned face.
        flipped = (square + "f 1 2 3\nf 4 3 1\n").replace("\n", "\r")
        pathlib.Path(path("flipped.obj")).write_bytes(b"\xef\xbb\xbf" + flipped.encode())
        self.assertEqual(self.json_of("inspect", path("flipped.obj"))["notes"],
                         ["turned round face 2 (line 6), to face as its neighbours do"])
        # A vertex within the side of a face.
        pathlib.Path(path("within.obj")).write_text(square + "v .5 0 0\nv .5 -1 0\nf 1 2 3 4\nf 1 6 5\nf 5 6 2\n")
        joined = "joined vertex 5 (line 5) to face 1 (line 7), in whose side it lies; join_m 0 (--join 0) keeps them apart"
        self.assertEqual(self.json_of("inspect", path("within.obj"))["notes"], [joined])
        self.assertIn(f"  note: {joined}\n", kerf("sheet", "create", "within", "--obj", path("within.obj")).stdout)


if __name__ == "__main__":
    main(__doc__)
