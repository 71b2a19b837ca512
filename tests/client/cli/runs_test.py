"""`kerf run` and `kerf replay`, which need no server."""

import base64
import json
import pathlib
import struct

from cli_case import ROOT, Case, below_a_file, kerf, main, panel, path, scene_file, setUpModule, tearDownModule


def crc32c(content):
    crc = 0xffffffff
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82f63b78 if crc & 1 else 0)
    return crc ^ 0xffffffff


class Runs(Case):
    def test_scenes_may_name_svg_files_beside_them(self):
        pathlib.Path(path("leaf.svg")).write_text('<svg viewBox="0 0 9 9"><path d="M1 1Q8 1 8 8Q1 8 1 1Z"/></svg>')
        cut = {"curve": {"svg": {"file": "leaf.svg"}}, "fit": {"min": {"x": 0.2, "y": 0.2}, "max": {"x": 0.8, "y": 0.8}}}
        scene = scene_file("leaf.json", commands=[{"tick": 5, "command": {"cut": cut}}])
        result = self.json_of("run", scene, "--record", path("leaf.rec"))
        self.assertEqual((result["cuts"][0]["status"], result["pieces"]), ("APPLIED", 2))
        self.assertEqual(self.json_of("replay", path("leaf.rec"))["state_hash"], result["state_hash"])

    def test_scenes_may_name_or_hold_mesh_files(self):
        pathlib.Path(path("ring.ply")).write_bytes(panel("binary_little_endian"))
        changes = {"grid": None, "pins": [], "commands": [
            {"tick": 5, "command": {"cut": {"curve": {"polyline": {"points": [{"x": 0.5, "y": -1}, {"x": 0.5, "y": 4}]}}}}}]}
        named = self.json_of("run", scene_file("named.json", ply={"file": "ring.ply"}, **changes), "--record", path("ring.rec"))
        self.assertEqual((named["cuts"][0]["status"], named["pieces"]), ("APPLIED", 2))
        self.assertEqual(self.json_of("replay", path("ring.rec"))["state_hash"], named["state_hash"])
        held = {"data": base64.b64encode(panel("binary_little_endian")).decode()}
        self.assertEqual(self.json_of("run", scene_file("held.json", ply=held, **changes))["state_hash"], named["state_hash"])
        self.refused("run", scene_file("gone.json", ply={"file": "gone.ply"}, **changes), says="gone.ply")

    def test_cuts_of_components_are_recorded_and_replayed(self):
        result = self.json_of("run", str(ROOT / "deploy/scenes/ribbon.json"), "--ticks", "260", "--record", path("band.rec"))
        self.assertEqual([each["status"] for each in result["cuts"]], ["APPLIED", "APPLIED"])
        self.assertEqual(result["pieces"], 3)
        self.assertEqual(self.json_of("replay", path("band.rec"))["state_hash"], result["state_hash"])

    def test_run_record_replay(self):
        scene = scene_file("small.json")
        first = self.json_of("run", scene, "--out", path("result.json"), "--record", path("small.rec"))
        self.assertEqual((first["ticks"], first["pieces"], first["scene"]), (20, 2, "small"))
        self.assertEqual(first["cuts"][0]["status"], "APPLIED")
        self.assertEqual(json.loads(pathlib.Path(path("result.json")).read_text())["state_hash"], first["state_hash"])
        self.assertEqual(self.json_of("run", scene)["state_hash"], first["state_hash"])
        self.assertEqual(self.json_of("run", scene, "--ticks", "30")["ticks"], 30)
        replayed = self.json_of("replay", path("small.rec"))
        self.assertEqual((replayed["identical"], replayed["ticks"]), (True, 20))
        self.assertEqual(replayed["state_hash"], first["state_hash"])

    def test_time_that_was_not_simulated_is_told(self):
        whole = self.json_of("run", scene_file("whole.json"))
        self.assertAlmostEqual(whole["simulated_s"], 20 / 60, 9)
        self.assertNotIn("substep_limit", whole.get("flagged_ticks", {}))
        short = self.json_of("run", scene_file("short.json", integrator={"kind": "EXPLICIT_LEAPFROG", "max_substeps": 1}))
        self.assertEqual(short["flagged_ticks"]["substep_limit"], "20")
        self.assertLess(short["simulated_s"], 0.5 * whole["simulated_s"])

    def test_mixed_precision_is_another_trajectory_near_that_of_double(self):
        results = [self.json_of("run", scene_file("precision.json"), "--integrator", "explicit", "--precision", precision)
                   for precision in ("double", "mixed")]
        self.assertNotEqual(results[0]["state_hash"], results[1]["state_hash"])
        energies = [result["energies"]["kinetic_j"] for result in results]
        self.assertAlmostEqual(energies[0], energies[1], delta=1e-3 * abs(energies[0]))

    def test_the_green_law_is_another_trajectory_near_the_corotational_one(self):
        recording = path("green.rec")
        green = self.json_of("run", scene_file("law.json", membrane_law="GREEN"), "--record", recording)
        self.assertEqual(self.json_of("replay", recording)["state_hash"], green["state_hash"])
        chosen = self.json_of("run", scene_file("law.json"), "--membrane-law", "green")
        self.assertEqual(chosen["state_hash"], green["state_hash"])
        corotational = self.json_of("run", scene_file("law.json", membrane_law="GREEN"), "--membrane-law", "corotational")
        self.assertEqual(corotational["state_hash"], self.json_of("run", scene_file("law.json"))["state_hash"])
        self.assertNotEqual(corotational["state_hash"], green["state_hash"])
        kinetic = corotational["energies"]["kinetic_j"]
        self.assertAlmostEqual(green["energies"]["kinetic_j"], kinetic, delta=0.02 * kinetic)
        self.refused("run", scene_file("law.json"), "--membrane-law", "hooke", code=2, says="hooke")

    def test_a_stiff_scene_in_real_time_is_recorded_so(self):
        grid = {"columns": 42, "rows": 42, "width_m": 1, "height_m": 1}
        wool = {"grid": grid, "material": {"preset": "wool"}, "commands": [], "ticks": 2}
        recording = path("real-time.rec")
        soft = self.json_of("run", scene_file("stiff.json", fidelity="REAL_TIME", **wool), "--record", recording)
        self.assertIn("membrane 4 times softer", soft["integrator"])
        self.assertEqual(self.json_of("replay", recording)["state_hash"], soft["state_hash"])
        chosen = self.json_of("run", scene_file("stiff.json", **wool), "--fidelity", "real-time")
        self.assertEqual(chosen["state_hash"], soft["state_hash"])
        exact = self.json_of("run", scene_file("stiff.json", fidelity="REAL_TIME", **wool), "--fidelity", "exact")
        self.assertEqual(exact["state_hash"], self.json_of("run", scene_file("stiff.json", **wool))["state_hash"])
        self.assertNotEqual(exact["state_hash"], soft["state_hash"])
        self.refused("run", scene_file("stiff.json", fidelity="QUICK"), says="QUICK")

    def test_every_linear_solver_ends_near_the_direct_one(self):
        scene = scene_file("solvers.json", integrator={"solver_tolerance": 1e-9, "max_linear_iterations": 100000})
        results = {solver: self.json_of("run", scene, "--integrator", "implicit", "--solver", solver)
                   for solver in ("direct", "cg", "jacobi-cg", "block-jacobi-cg", "factor-cg", "multigrid-cg")}
        self.assertEqual(len({result["state_hash"] for result in results.values()}), 6)
        exact = results["direct"]["energies"]["kinetic_j"]
        for solver, result in results.items():
            self.assertAlmostEqual(result["energies"]["kinetic_j"], exact, delta=1e-6 * exact, msg=solver)
        self.assertIn("plain conjugate gradients", results["cg"]["integrator"])
        self.refused("run", scene, "--solver", "gauss", code=2, says="gauss")

    def test_one_linear_solve_a_tick_can_be_asked_for(self):
        scene = scene_file("baseline.json", commands=[], integrator={
            "kind": "IMPLICIT_EULER", "newton_iterations": 1, "solver": "PLAIN_CG", "max_linear_iterations": 3})
        limited = self.json_of("run", scene)
        self.assertEqual(limited["flagged_ticks"]["not_converged"], "20")
        self.refused("run", scene_file("none.json", integrator={"max_linear_iterations": -1}), says="max_linear_iterations")

    def test_solvers_of_another_system_say_so(self):
        implicit = {"kind": "IMPLICIT_EULER"}
        sound = self.json_of("run", scene_file("sound.json", integrator=implicit))
        self.assertLess(sound["linear_residual"], 1e-3)
        self.assertGreater(int(sound["linear_iterations"]), 20)
        scene = scene_file("es.json", integrator=implicit, commands=[], grid={"columns": 6, "rows": 6, "width_m": 1, "height_m": 1})
        for solver in ("es-cgm", "as-cgm"):
            result = self.json_of("run", scene, "--solver", solver)
            self.assertIn("solves a different system", result["integrator"])
            self.assertGreater(result["linear_residual"], 0.1)
            self.assertEqual(result["flagged_ticks"]["not_converged"], "20")
            self.assertIn("residual at most", kerf("run", scene, "--solver", solver).stdout)
            self.refused("run", scene_file("large.json", grid={"columns": 3, "rows": 167, "width_m": 1, "height_m": 1},
                                           integrator=implicit), "--solver", solver, says="SOLVER_TOO_DENSE")
        self.refused("run", scene_file("p.json", integrator={"covariance_root": {"p": 3}}), says="covariance_root.p")

    def test_a_tampered_recording_names_the_tick(self):
        self.json_of("run", scene_file("tamper.json"), "--record", path("tamper.rec"))
        content = bytearray(pathlib.Path(path("tamper.rec")).read_bytes())
        head = content.rindex(struct.pack("<I", 11))  # of the last entry: tick 20 and its hash
        content[-1] ^= 1
        pathlib.Path(path("flipped.rec")).write_bytes(content)
        self.refused("replay", path("flipped.rec"), says=f"offset {head}")
        # As a program would write it that had come to another hash.
        content[head + 4:head + 8] = struct.pack("<I", crc32c(content[head + 10:]))
        content[head + 8:head + 10] = struct.pack("<H", crc32c(content[head:head + 8]) & 0xffff)
        pathlib.Path(path("tamper.rec")).write_bytes(content)
        self.assertEqual(kerf("--json", "replay", path("tamper.rec")).returncode, 1)
        self.refused("replay", path("tamper.rec"), says="tick 20")
        pathlib.Path(path("text.rec")).write_text("no recording at all")
        self.refused("replay", path("text.rec"))

    def test_a_torn_recording_is_replayed_to_its_last_whole_entry(self):
        self.json_of("run", scene_file("torn.json"), "--record", path("whole.rec"))
        content = pathlib.Path(path("whole.rec")).read_bytes()
        pathlib.Path(path("torn.rec")).write_bytes(content[:-3])
        replayed = self.json_of("replay", path("torn.rec"))
        self.assertEqual((replayed["identical"], replayed["ticks"], replayed["torn_bytes"]), (True, 19, 18))
        self.assertIn("the last 18 bytes are an incomplete entry", kerf("replay", path("torn.rec")).stdout)
        self.assertEqual(self.json_of("replay", path("whole.rec"))["torn_bytes"], 0)
        pathlib.Path(path("headless.rec")).write_bytes(content[:30])
        self.refused("replay", path("headless.rec"), says="within its header")
        self.assertNotIn("incomplete", kerf("replay", path("whole.rec")).stdout)
    def test_refusals(self):
        self.refused("run", path("missing.json"), says="missing.json")
        self.refused("run", scene_file("bad.json", gravity_mps2={"x": "NaN"}), says="gravity_mps2")
        self.refused("run", scene_file("typo.json", colour="red"), says="colour")
        self.refused("run", scene_file("small.json"), "--out", below_a_file("r.json"), says="no-folder/r.json")
        self.refused("run", scene_file("small.json"), "--ticks", "0", code=2)
        pathlib.Path(path("broken.json")).write_text('{"grid": ')
        self.refused("run", path("broken.json"), says="line 1")

    def test_demo_scene(self):
        done = self.json_of("run", str(ROOT / "deploy/scenes/demo.json"), "--ticks", "10")
        self.assertEqual(done["num_vertices"], 2500)


if __name__ == "__main__":
    main(__doc__)
