"""Analyses by `kerf run` and of live sheets by `kerf analyze`."""

import json
import math
import os
import pathlib

from cli_case import Case, kerf, main, path, scene_file, setUpModule, tearDownModule


class Analyses(Case):
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
        result = self.json_of("run", scene_file("pulled.json", **pulled), "--csv", folder)
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
        people = kerf("run", scene_file("pulled.json", **pulled)).stdout
        self.assertIn("equilibrium at load 1,", people)
        self.assertIn("top.y", people)
        # Nothing holds it: what there is comes with a status of its own.
        free = scene_file("free.json", **{**pulled, "pins": [], "analysis": {"static": {"max_iterations": 3}}})
        done = kerf("--json", "run", free)
        self.assertEqual((done.returncode, json.loads(done.stdout)["static"]["converged"]), (1, False))
        self.assertIn("no equilibrium was found beyond load 0", done.stderr)
        self.assertIn("nothing holds the sheet", done.stderr)
        self.assertIn("along y", done.stderr)
        windy = scene_file("windy.json", **{**pulled, "wind": {"velocity_mps": {"x": 1}}})
        self.assertIn("left out: wind", kerf("run", windy).stdout)
        self.refused("run", scene_file("pulled.json", **pulled), "--record", path("no.rec"), says="dynamic")
        self.refused("run", scene_file("odd.json", probes=[{"name": "a", "quantity": "POSITION", "points": [{"x": 9}]}]),
                     says="probes[0].points[0]")

    def test_vibrations_by_scene_and_of_a_live_sheet(self):
        modes = self.json_of("run", scene_file(
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
        scene = scene_file("limited.json", integrator={"kind": "EXPLICIT_LEAPFROG", "max_substeps": 1})
        self.json_of("sheet", "create", "short", "--scene", scene)
        live = int(self.json_of("sheet", "pause", "short")["flagged_ticks"].get("substep_limit", 0))
        self.json_of("sheet", "step", "short", "5")
        counted = str(live + 5)
        self.assertEqual(self.json_of("sheet", "get", "short")["flagged_ticks"]["substep_limit"], counted)
        listed = next(sheet for sheet in self.json_of("sheet", "list")["sheets"] if sheet["name"] == "sheets/short")
        self.assertEqual(listed["flagged_ticks"]["substep_limit"], counted)
        self.assertIn("ticks flagged substep_limit " + counted, kerf("sheet", "list", "--verbose").stdout)
        self.json_of("sheet", "reset", "short")
        self.assertEqual(self.json_of("sheet", "get", "short")["flagged_ticks"]["substep_limit"], counted)
        self.json_of("sheet", "delete", "short")

    def test_energies_and_cpu_time_are_told(self):
        # Nothing moves and nothing is stretched: all there is is weight at a height.
        still = self.json_of("run", scene_file("still.json", commands=[], pins=[{"box": {"min": {"x": 0, "y": 0},
                                                                                         "max": {"x": 1, "y": 1}}}],
                                               placement={"origin": {"z": 2}, "y_axis": {"y": 1}},
                                               material={"density_kgpm3": 400, "thickness_m": 0.0005}))
        energies = still["energies"]
        self.assertAlmostEqual(energies["gravity_j"], 0.0005 * 400 * 9.81 * 2, 6)
        for none in ("kinetic_j", "membrane_j", "bending_j"):
            self.assertAlmostEqual(energies[none], 0.0, 9)
        # Falls freely for 20 ticks: what it loses in height it has in speed.
        falling = self.json_of("run", scene_file("falling.json", commands=[], pins=[],
                                                 placement={"origin": {"z": 2}, "y_axis": {"y": 1}},
                                                 material={"density_kgpm3": 400, "thickness_m": 0.0005,
                                                           "mass_damping_per_s": 0}))
        fallen = energies["gravity_j"] - falling["energies"]["gravity_j"]
        self.assertGreater(fallen, 0.5)
        self.assertAlmostEqual(falling["energies"]["kinetic_j"], fallen, delta=0.05 * fallen)
        for result in (still, falling):
            self.assertGreater(result["cpu_s"], 0.0)
            self.assertAlmostEqual(result["cpu_per_tick_us"], 1e6 * result["cpu_s"] / 20, 6)


if __name__ == "__main__":
    main(__doc__)
