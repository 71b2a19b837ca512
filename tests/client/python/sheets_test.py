"""Making sheets, running them, pulling at them, analysing them."""

import gzip
import json
import math
import os
import pathlib

import kerf
from kerf.files import CHUNK_BYTES
from support import Case, path


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

    def test_saved_states(self):
        saved = self.sheet.save_state("before")
        with self.assertRaises(kerf.AlreadyExists):
            self.sheet.save_state("before")
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        self.sheet.step(3)
        later = self.sheet.save_state("after", request_id="once")
        self.assertEqual(self.sheet.save_state("after", request_id="once"), later)
        self.assertEqual([state.name.rsplit("/")[-1] for state in self.sheet.states()], ["before", "after"])
        back = self.sheet.restore_state("before")
        self.assertEqual((back.tick, back.state_hash, back.pieces), (saved.tick, saved.state_hash, 1))
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        self.sheet.step(3)
        self.assertEqual(self.sheet.save_state("again").continuation_hash, later.continuation_hash)
        for name in ("before", "after", "again"):
            self.sheet.delete_state(name)
        with self.assertRaises(kerf.NotFound):
            self.sheet.restore_state("before")

    def test_frames_follow_a_sheet_that_goes_back(self):
        self.sheet.step(5)
        self.sheet.save_state("before")
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        self.sheet.step(3)
        frames = self.sheet.watch()
        late = next(frames)
        self.sheet.restore_state("before")
        back = next(frames)
        frames.close()
        self.assertLess(back.tick, late.tick)
        self.assertTrue(back.topology_changed)
        self.assertEqual(len(set(back.pieces.tolist())), 1)
        exact = self.sheet.state().positions
        self.assertLessEqual(abs(back.positions - exact).max(), back.resolution.max())

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
        quick = self.server.create_scene({**scene, "fidelity": "REAL_TIME"}, "py-quick", paused=True)
        self.assertEqual(quick.get().softening.factor, 1)
        quick.delete()
        folds = self.server.create_scene({**scene, "self_contact": {"mode": "ON", "friction": 0.5}}, "py-folds", paused=True)
        self.assertEqual(folds.get().scene.self_contact.friction, 0.5)
        self.assertIn("self-contact", folds.get().integrator)
        folds.set_self_contact(False)
        folds.set_self_contact(thickness_m=0.002)
        contact = folds.get().scene.self_contact
        self.assertEqual((contact.mode, contact.friction, contact.thickness_m), (contact.OFF, 0.5, 0.002))
        folds.set_self_contact(True, friction=0)
        contact = folds.get().scene.self_contact
        self.assertEqual((contact.mode, contact.friction, contact.thickness_m), (contact.ON, 0, 0.002))
        with self.assertRaises(kerf.InvalidArgument):
            folds.set_self_contact(thickness_m=0)
        with self.assertRaises(kerf.InvalidArgument):
            folds.set_self_contact(thickness_m=0.001, material_thickness=True)
        folds.set_self_contact(material_thickness=True)
        self.assertFalse(folds.get().scene.self_contact.HasField("thickness_m"))
        folds.delete()
        with self.assertRaisesRegex(kerf.InvalidArgument, "no folds that could touch"):
            self.server.create_scene({**scene, "self_contact": {"mode": "ON"}, "planar": True})
        with self.assertRaisesRegex(ValueError, "colour"):
            self.server.create_scene({"colour": "red"})

    def test_components_are_cut_and_pinned_in_their_own_coordinates(self):
        grid = {"columns": 11, "rows": 3, "width_m": 1, "height_m": 0.2}
        scene = {"components": [{"name": name, "grid": grid} for name in ("one", "two")]}
        made = self.server.create_scene(scene, "py-components", paused=True)
        one, two = made.get().components
        self.assertEqual((two.name, two.first_vertex, two.num_vertices), ("two", 33, 33))
        self.assertAlmostEqual(two.offset.x - one.offset.x, 1.1)
        self.assertEqual(made.cut(kerf.polyline((-9, 0.1), (9, 0.1)), component="two").pieces, 3)
        both = [kerf.cut(kerf.polyline((0.5, -1), (0.5, 1)), component=name) for name in ("one", "two")]
        self.assertEqual(made.cut_all(both).pieces, 6)
        made.set_pins([kerf.of_component("two", "left"), kerf.of_component("one", kerf.nearest((0, 0)))])
        pinned = list(made.get().pinned_vertices)
        self.assertEqual(pinned[:2], [0, 33])
        self.assertGreaterEqual(len(pinned), 4)
        with self.assertRaisesRegex(kerf.InvalidArgument, "one, two"):
            made.cut(kerf.circle((0.5, 0.1), 0.05), component="three")
        made.delete()

    def test_parts_of_other_materials(self):
        made = self.server.create_sheet("py-parts", grid=(9, 9), material="denim", parts=[((0.5, 0, 1, 1), "silk")],
                                        paused=True)
        scene = made.get().scene
        self.assertEqual(scene.material.thickness_m, 1.066e-3)
        self.assertEqual([part.material.thickness_m for part in scene.materials], [1.2e-4])
        made.delete()
        made = self.server.create_sheet("py-numbers", grid=(9, 9), material={"preset": "silk", "thickness_m": 2e-4}, paused=True)
        self.assertEqual(made.get().scene.material.thickness_m, 2e-4)
        made.delete()
        with self.assertRaisesRegex(ValueError, "material: .*thickness"):
            self.server.create_sheet("py-parts", material={"thickness": 1})
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
            self.assertEqual(list(modes.tables), ["modes"])
            self.assertEqual(modes.tables["modes"].values.shape, (3, 3))
            self.assertTrue((modes.tables["modes"]["frequency_hz"] > 0).all())
            with self.assertRaisesRegex(KeyError, "no column 'hertz'; there are mode, "):
                modes.tables["modes"]["hertz"]
            self.assertTrue(sheet.analyze(modes=2, about_equilibrium=True).static.converged)
            probes = [{"name": "top", "quantity": "REACTION", "region": {"edge": "TOP"}}]
            rest = sheet.analyze(request={"analysis": {"static": {"steps": 2}}, "probes": probes, "positions": True})
            self.assertEqual(rest.tables["probes"].columns[3], "top.z")
            self.assertEqual(len(rest.tables["probes"].values), 2)
            # The reaction is its weight, and it hangs below where it started.
            weight = 9.81 * sum(piece.mass_kg for piece in sheet.pieces())
            self.assertAlmostEqual(rest.tables["probes"]["top.z"][-1] / weight, 1, delta=0.01)
            self.assertLess(rest.positions[:8, 2].mean(), sheet.state().positions[:8, 2].mean())
            ahead = sheet.analyze(ticks=6, measure_every=4, request={"probes": probes})
            self.assertEqual((ahead.tables["probes"]["time_s"] * 60).round().tolist(), [0, 4, 6])
            self.assertEqual(sheet.step(6).state_hash, ahead.dynamic.state_hash)
            self.assertEqual(sheet.analyze(ticks=0).dynamic.ticks, 0)
            for wrong in ({"modes": 1}, {"about_equilibrium": True}):
                with self.assertRaises(ValueError):
                    sheet.analyze(request={}, **wrong)
            with self.assertRaises(ValueError):
                sheet.analyze(modes=1, ticks=1)
            with self.assertRaises(ValueError):
                sheet.analyze(ticks=1, request={"analysis": {"static": {}}})
            with self.assertRaisesRegex(ValueError, "request: .*probe"):
                sheet.analyze(request={"probe": []})
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

    def test_a_hand_lets_go_when_its_with_is_left(self):
        self.sheet.set_pins([])
        with self.sheet.holding(399, (1.2, 0.0, 1.2)) as hand:
            self.sheet.step(30)
            held = self.sheet.state().positions[399]
            hand.move((1.3, 0.0, 1.2))
            self.sheet.step(30)
            self.assertGreater(self.sheet.state().positions[399, 0], held[0])
        self.refused(kerf.NotFound, "NOT_FOUND", "GRAB_NOT_FOUND", "release.grab_id", self.sheet.release, hand.grab_id)
        with self.assertRaisesRegex(RuntimeError, "inside"):
            with self.sheet.holding((0.5, 0.5)) as hand:
                raise RuntimeError("inside")
        self.refused(kerf.NotFound, "NOT_FOUND", "GRAB_NOT_FOUND", "release.grab_id", self.sheet.release, hand.grab_id)

    def test_pins_at_every_kind_of_place(self):
        def pinned_by(*places):
            self.sheet.set_pins(places)
            return list(self.sheet.get().pinned_vertices)

        self.assertEqual(pinned_by("top_corners"), [380, 399])
        self.assertEqual(pinned_by(kerf.edge("bottom")), list(range(20)))
        self.assertEqual(pinned_by(kerf.box((0, 0), (0.06, 0.06))), [0, 1, 20, 21])
        self.assertEqual(pinned_by(kerf.vertices(7, 8), kerf.nearest((1, 1))), [7, 8, 399])
        self.assertEqual(pinned_by(kerf.along(kerf.polyline((0, 0), (0, 1)), within=0.001)), list(range(0, 400, 20)))
        self.assertEqual(len(pinned_by(kerf.whole())), 400)
        self.assertEqual(pinned_by(), [])
        self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", "REGION_EMPTY", "set_pins.pins[0]",
                     self.sheet.set_pins, [kerf.box((5, 5), (6, 6))])
        with self.assertRaisesRegex(ValueError, "edge is 'middle'; must be one of top, bottom, left, right"):
            self.sheet.set_pins(["middle"])
        with self.assertRaisesRegex(TypeError, r"give a list of places: \['top'\]"):
            self.sheet.set_pins("top")
        with self.assertRaisesRegex(TypeError, "not int"):
            self.sheet.set_pins([3])

    def test_gravity_and_wind(self):
        self.sheet.set_gravity((0, 0, -1))
        self.sheet.set_wind(kerf.wind((0, 5, 0), drag=2))
        scene = self.sheet.get().scene
        self.assertEqual((scene.gravity_mps2.z, scene.wind.velocity_mps.y, scene.wind.drag_coefficient), (-1, 5, 2))
        self.sheet.step(20)
        self.assertGreater(self.sheet.state().positions[:, 1].max(), 1e-4)  # blown along
        self.sheet.set_wind(None)
        self.assertFalse(self.sheet.get().scene.HasField("wind"))

    def test_a_temporary_sheet_goes_with_its_with(self):
        with self.server.temporary_sheet(grid=(5, 4), paused=True) as sheet:
            self.assertEqual((sheet.get().num_vertices, sheet.step().tick), (20, 1))
        with self.assertRaises(kerf.NotFound):
            sheet.get()
        with self.assertRaisesRegex(RuntimeError, "inside"):
            with self.server.temporary_sheet({"grid": {"columns": 3, "rows": 3, "width_m": 1, "height_m": 1}}) as sheet:
                raise RuntimeError("inside")
        with self.assertRaises(kerf.NotFound):
            sheet.get()
        with self.server.temporary_sheet(grid=(3, 3)) as sheet:
            sheet.delete()  # is no error then
        with self.assertRaisesRegex(TypeError, "a scene is given: 'grid' belongs in it"):
            with self.server.temporary_sheet({}, grid=(3, 3)):
                pass
        with self.assertRaisesRegex(TypeError, "a sheet has no option 'gird'; there are grid, "):
            self.server.create_sheet("py-gird", gird=(3, 3))

    def test_obj(self):
        lines = self.sheet.obj().decode().splitlines()
        self.assertEqual(sum(line.startswith("v ") for line in lines), 400)
        self.assertEqual(sum(line.startswith("f ") for line in lines), 722)

    def test_a_mesh_file_larger_than_a_message_goes_in_parts(self):
        # 150 x 150 vertices with long numbers: 1.4 MB, where a call may have 1 MiB.
        side = 150
        vertices = "".join(f"v {x / side:.17f} {y / side:.17f} 0\n" for y in range(side) for x in range(side))
        corner = [y * side + x + 1 for y in range(side - 1) for x in range(side - 1)]
        faces = "".join(f"f {v} {v + 1} {v + side + 1} {v + side}\n" for v in corner)
        pathlib.Path(path("large.obj")).write_text(vertices + faces)
        self.assertGreater(os.path.getsize(path("large.obj")), 1 << 20)
        self.assertLessEqual(CHUNK_BYTES, (1 << 20) - 4)  # what a message holds of a chunk
        large = self.server.create_sheet("py-large", mesh_file=path("large.obj"), pins=(), paused=True)
        self.assertEqual(large.get().num_vertices, side * side)
        large.delete()
        pathlib.Path(path("damaged.obj")).write_text(vertices + faces + "f 1 2 90000\n")
        with self.assertRaises(kerf.InvalidArgument) as refused:
            self.server.create_sheet("py-damaged", mesh_file=path("damaged.obj"), pins=(), paused=True)
        self.assertIn("90000", str(refused.exception))

    def test_sheets_from_mesh_files(self):
        square = ("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
        pathlib.Path(path("square.ply")).write_text(square)
        pathlib.Path(path("square.obj")).write_bytes(b"o T\xfcr\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        made = [self.server.create_sheet("py-" + end, mesh_file=path("square." + end), pins=()) for end in ("ply", "obj")]
        self.assertEqual([sheet.get().num_triangles for sheet in made], [2, 2])
        for sheet in made:
            sheet.delete()
        for end in ("ply", "obj"):
            packed = gzip.compress(pathlib.Path(path("square." + end)).read_bytes())
            pathlib.Path(path(f"square.{end}.gz")).write_bytes(packed)
            with self.server.temporary_sheet(mesh_file=path(f"square.{end}.gz"), pins=()) as sheet:
                self.assertEqual(sheet.get().num_triangles, 2)
            for content, fault in ((packed[:-9], "cut off"), (gzip.compress(packed), "compressed twice")):
                pathlib.Path(path(f"square.{end}.gz")).write_bytes(content)
                with self.assertRaisesRegex(ValueError, fault):
                    self.server.create_sheet("py-packed", mesh_file=path(f"square.{end}.gz"))
        for wrong, fault in (({"grid": 5}, "grid is 5"), ({"grid": (5.0, 5)}, "two whole numbers"), ({"grid": "5x5"}, "grid is"),
                             ({"size_m": 1}, "size_m is 1"), ({"size_m": (1, 2, 3)}, "two numbers")):
            with self.assertRaisesRegex(ValueError, fault):
                self.server.create_sheet("py-wrong", **wrong)
        # Two triangles with vertices of their own, in millimetres, y up.
        apart = "v 0 0 0\nv 400 0 0\nv 400 300 0\nv 0 0 0\nv 400 300 0\nv 0 300 0\no a\nf 1 2 3\no b\nf 4 5 6\n"
        pathlib.Path(path("apart.obj")).write_text(apart)
        joined = self.server.create_sheet("py-apart", mesh_file=path("apart.obj"), unit_m=1e-3, up="y", pins=()).get()
        self.assertEqual((joined.pieces, joined.num_vertices), (1, 4))
        self.assertEqual(list(joined.mesh_notes), ["joined 4 vertices that lie at the same place, which leaves 2; "
                                                   "join_m 0 (--join 0) keeps them apart"])
        self.server.sheet("py-apart").delete()
        with self.server.temporary_sheet(mesh_file=path("apart.obj"), join_m=0, unit_m=1e-3, pins=()) as sheet:
            self.assertEqual((sheet.get().pieces, list(sheet.get().mesh_notes)), (2, []))
        with self.server.temporary_sheet(mesh_file=path("apart.obj"), objects=["b"], ignore_texture=True, pins=()) as sheet:
            self.assertEqual(sheet.get().num_triangles, 1)
        with self.assertRaisesRegex(ValueError, "up is 'w'"):
            self.server.create_sheet("py-up", mesh_file=path("apart.obj"), up="w")
        pathlib.Path(path("bent.obj")).write_text("v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
        bent = self.server.create_sheet("py-bent", mesh_file=path("bent.obj"), rest="surface", pins=())
        self.assertAlmostEqual(sum(piece.area_m2 for piece in bent.pieces()), 1.25 ** 0.5, places=12)
        bent.delete()
        with self.assertRaises(kerf.InvalidArgument) as refused:
            self.server.create_sheet("py-bent", mesh_file=path("bent.obj"), rest="flat", pins=())
        self.assertEqual(refused.exception.reason, "OBJ_NOT_PLANAR")
        with self.assertRaisesRegex(ValueError, "ends in .obj or .ply"):
            self.server.create_sheet("py-stl", mesh_file=path("square.stl"))
