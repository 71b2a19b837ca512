"""The page tests/accuracy/PLOTS.md and its pictures are made of the tables; those say what the page claims; and what is
cheap of them is found again."""

import argparse
import math
import pathlib
import re
import sys
import unittest

import measure
import page
import sizes
import studies

OPTIONS = None
SAME = 1e-3  # of an error, from one build to another
SAME_IN_TIME = 0.02  # of an error in motion
SAME_DRIFT = 1.5  # factor
RUN_KEYS = ("scheme", "solver", "newton_limit", "tick_hz")


def is_quick(case, run):
    """Dense matrices take their time: one run in sixteen has to do."""
    return run["solver"] not in sizes.OTHER_SYSTEM or (case["cut"], run["scheme"], run["solver"]) == (
        "before", "implicit Euler", "ES_CGM")


def rows_of(study):
    return [row for row in studies.table(studies.CONVERGENCE) if row["study"] == study["name"]]


class Tables(unittest.TestCase):
    def test_every_curve_has_all_its_points(self):
        for study in studies.studies()["convergence"]:
            self.assertGreaterEqual(len(study["fineness"]), 3)
            self.assertEqual(len(rows_of(study)), len(study["curves"]) * len(study["fineness"]))
            for curve in study["curves"]:
                found = studies.points(rows_of(study), curve)
                self.assertEqual(len(found), len(study["fineness"]))
                for coarse, fine in zip(found, found[1:]):
                    self.assertGreater(coarse[0], fine[0])
                    self.assertLess(coarse[2], fine[2])
                self.assertTrue(all(math.isfinite(point[1]) and point[1] > 0 for point in found))

    def test_errors_fall_as_the_page_says(self):
        for study in studies.studies()["convergence"]:
            for curve in study["curves"]:
                with self.subTest(study=study["name"], curve=curve["label"]):
                    uncertainty = studies.quantity(curve["scene"], curve["quantity"])["uncertainty_rel"]
                    found = studies.points(rows_of(study), curve)
                    order = studies.observed_order(found, uncertainty)
                    if "order" not in curve:
                        self.assertLess(found[-1][1], found[0][1])
                    else:
                        self.assertGreaterEqual(order, curve["order"])

    def test_order_is_the_slope_above_the_uncertainty(self):
        points = [(h, 3 * h ** 1.5) for h in (0.4, 0.2, 0.1, 0.05)]
        self.assertAlmostEqual(studies.observed_order(points, 0), 1.5, places=12)
        self.assertAlmostEqual(studies.observed_order([*points, (0.025, 0.001)], 0.002), 1.5, places=12)
        self.assertIsNone(studies.observed_order(points, points[1][1]))

    def test_histories_end_at_one_second(self):
        rows = studies.table(studies.HISTORIES)
        for scene in studies.studies()["histories"]["scenes"]:
            for run in studies.studies()["histories"]["runs"]:
                mine = [row for row in rows if (row["scene"], row["run"]) == (scene, run["label"])]
                self.assertEqual(mine[0]["energy"], 0)
                self.assertGreater(mine[-1]["time_s"], 0.98)

    def test_time_has_every_way_of_solving_at_every_step(self):
        for material in page.MATERIALS:
            rows = [row for row in studies.table(studies.TIME) if row["material"] == material]
            curves = page.time_curves(rows, studies.studies()["solvings"])
            self.assertEqual(len(curves), 3 + 4 * len(studies.studies()["solvings"]))
            for curve in curves:
                self.assertGreaterEqual(len(curve["rows"]), 4)

    def test_size_has_every_run_of_every_case(self):
        rows = studies.table(studies.SIZE)
        for case in sizes.cases():
            mine = [row for row in rows if sizes.key({**row, "side": f"{row['side']:g}"}) == sizes.key(case)]
            wanted = [(sizes.REFERENCE, "", "", case["rates_hz"][0])] + [
                tuple(run[name] for name in RUN_KEYS) for run in sizes.runs(case)]
            self.assertEqual([tuple(row[name] for name in RUN_KEYS) for row in mine], wanted, str(case))
            for row in mine:
                self.assertNotEqual(row["error_m"] == "", row["left_out"] == "", "no error without a reason")
                self.assertGreater(row["cpu_s_per_s"], 0)
                self.assertAlmostEqual(row["end_s"], case["end_s"], delta=1e-5 * case["end_s"])
                self.assertEqual(row["reference_cfl"], case["reference_cfl"])
                self.assertEqual(row["default_cpu_s_per_s"] == "", row["scheme"] == sizes.REFERENCE)

    def test_every_solver_is_run_with_every_implicit_scheme(self):
        said = studies.studies()
        implicit = [name for name, scheme in said["schemes"].items() if scheme.get("is_implicit")]
        for case in sizes.cases():
            if case["side"] == 15:
                found = {(run["scheme"], run["solver"]) for run in sizes.runs(case)}
                self.assertLessEqual({(scheme, way["solver"]) for scheme in implicit for way in said["ways"]}, found)

    def test_solvers_alone_are_run_beside_the_default(self):
        small, large = (next(case for case in sizes.cases() if case["side"] == side) for side in (15, 200))
        for rate in small["rates_hz"]:
            mine = [run for run in sizes.runs_of(small, ["JACOBI_CG", "ES_CGM"]) if run["tick_hz"] == rate]
            self.assertEqual(mine[0]["scheme"], "automatic")
            self.assertEqual({run["solver"] for run in mine[1:]}, {"JACOBI_CG", "ES_CGM"} if rate == 60 else {"JACOBI_CG"})
        self.assertEqual(sizes.runs_of(large, ["JACOBI_CG"]), [])
        self.assertEqual(sizes.runs_of(large, []), sizes.runs(large))

    def test_times_of_two_runs_are_compared_by_the_default_of_each(self):
        def row(scheme, solver, time, of_default):
            return {"material": "soft", "side": 15, "cut": "after", "scheme": scheme, "solver": solver, "tick_hz": 60,
                    "cpu_s_per_s": time, "default_cpu_s_per_s": of_default}
        rows = [row(sizes.REFERENCE, "", 9.0, ""), row("automatic", "", 2.0, 2.0), row("BDF2", "DIRECT", 6.0, 2.0),
                row("BDF2", "PLAIN_CG", 30.0, 3.0), {**row("BDF2", "DIRECT", 5.0, 1.0), "side": 200}]
        found = sizes.of_every_solver(rows)
        self.assertEqual([row["cpu_s_per_s"] for row in found], [2.0, 6.0, 20.0])
        self.assertEqual({row["default_cpu_s_per_s"] for row in found}, {2.0})

    def test_threads_has_every_run_that_is_compared(self):
        rows = studies.table(studies.THREADS)
        wanted = [sizes.row_key(case, run) for case in sizes.cases() for run in sizes.compared(case)]
        self.assertEqual([tuple(f"{row[name]:g}" if isinstance(row[name], float) else row[name] for name in sizes.KEYS)
                          for row in rows], wanted)
        of_size = {tuple(row[name] for name in sizes.KEYS): row for row in studies.table(studies.SIZE)}
        for row in sizes.with_errors(rows, of_size.values()):
            alone = of_size[tuple(row[name] for name in sizes.KEYS)]
            self.assertNotEqual(row["error_m"], "")
            self.assertEqual((row["vertices"], row["end_s"]), (alone["vertices"], alone["end_s"]))
            self.assertGreater(min(row["one_cpu_s_per_s"], row["two_cpu_s_per_s"]), 0)
            self.assertGreaterEqual(row["rounds"], 3)

    def test_a_second_thread_gains_what_both_take_less(self):
        self.assertEqual(sizes.gain({"one_wall_s_per_s": 3.0, "two_wall_s_per_s": 2.0}), 1.5)

    def test_what_dominates_is_faster_and_no_farther_off(self):
        def row(scheme, time, error, side=15, tick_hz=60):
            return {"material": "soft", "side": side, "cut": "after", "scheme": scheme, "tick_hz": tick_hz, "cpu_s_per_s": time,
                    "default_cpu_s_per_s": 1.0, "error_m": error}
        default = row("automatic", 1.0, 1e-3)
        others = [row("as fast", 0.95, 1e-4), row("nearer", 1.1, 1e-5), row("farther", 0.1, 1.1e-3),
                  row("other sheet", 0.1, 1e-5, side=30), row("no error", 0.1, ""), row("long ticks", 0.1, 1e-5, tick_hz=30)]
        self.assertEqual(sizes.dominating([default, *others], default), [])
        self.assertEqual(sizes.nearest_within([default, *others], default, 2), others[1])
        self.assertIsNone(sizes.nearest_within([default, *others[2:]], default, 2))
        better = [row("far better", 0.1, 1e-4), row("as near", 0.5, 1.01e-3)]
        self.assertEqual(sizes.dominating([default, *others, *reversed(better)], default), better)


class Page(unittest.TestCase):
    def test_the_page_is_made_of_the_tables(self):
        self.assertEqual(page.PAGE.read_text(), page.text(), "draw.py was not run after a change")

    def test_pictures_are_made_of_the_tables(self):
        pictures = page.digests()
        for name, digest in pictures.items():
            said = re.search(rb"made of ([0-9a-f]{16})", (studies.HERE / f"{name}.png").read_bytes())
            self.assertEqual(said[1].decode(), digest, f"{name}.png: draw.py was not run after a change")
        self.assertEqual(set(pictures), {file.stem for file in studies.HERE.glob("*.png")})
        for name in pictures:
            self.assertIn(f"](plots/{name}.png)", page.text())


class Measured(unittest.TestCase):
    def test_the_coarsest_meshes_give_the_same_errors(self):
        for study in studies.studies()["convergence"]:
            columns = measure.CONVERGENCE_COLUMNS
            known = {row["curve"]: row for row in rows_of(study) if row["fineness"] == study["fineness"][0]}
            for row in measure.convergence(OPTIONS.bin, study, study["fineness"][0]):
                now = dict(zip(columns, row))
                with self.subTest(study=study["name"], curve=now["curve"]):
                    then = known[now["curve"]]
                    self.assertEqual(now["vertices"], then["vertices"])
                    self.assertAlmostEqual(float(now["error"]), then["error"], delta=SAME * abs(then["error"]))

    def test_the_coarsest_profiles_are_the_same(self):
        for study in studies.studies()["profiles"]:
            known = [row for row in studies.table(studies.PROFILES)
                     if (row["study"], row["fineness"]) == (study["name"], study["fineness"][0])]
            found = measure.profile(OPTIONS.bin, study, study["fineness"][0])
            self.assertEqual(len(found), len(known))
            for now, then in zip(found, known):
                self.assertAlmostEqual(float(now[-1]), then["found"], delta=SAME * abs(then["found"]))

    def test_drifts_are_the_same(self):
        runs = {run["label"]: run for run in studies.studies()["histories"]["runs"]}
        table = studies.table(studies.HISTORIES)
        for scene, label in (("free", "explicit"), ("swinging", "explicit undamped"), ("free", "implicit Euler")):
            with self.subTest(scene=scene, run=label):
                now = [abs(float(row[3])) for row in measure.history(OPTIONS.bin, scene, runs[label])]
                then = [abs(row["energy"]) for row in table if (row["scene"], row["run"]) == (scene, label)]
                self.assertLess(max(now), SAME_DRIFT * max(then))
                self.assertGreater(max(now), max(then) / SAME_DRIFT)

    def test_the_longest_steps_give_the_same_errors(self):
        table = {tuple(row[key] for key in ("integrator", "precision", "solver", "newton_iterations", "step_s")): row
                 for row in studies.table(studies.TIME) if row["material"] == "soft"}
        columns, rows = measure.time_rows(OPTIONS.bin, "soft", "--coarsest")
        for row in rows:
            now = {key: studies.number(value) for key, value in zip(columns, row)}
            then = table[tuple(now[key] for key in ("integrator", "precision", "solver", "newton_iterations", "step_s"))]
            if now["steps_not_converged"] in ("", 0):  # what an unsolved step gives depends on how it was not solved
                self.assertAlmostEqual(now["error_fine_m"], then["error_fine_m"],
                                       delta=SAME_IN_TIME * then["error_fine_m"], msg=str(row))

    def test_the_smallest_sheets_give_the_same_errors(self):
        table = {tuple(row[name] for name in sizes.KEYS): row for row in studies.table(studies.SIZE)}
        for cut in sizes.CUTS:
            case = next(case for case in sizes.cases() if sizes.key(case) == ("soft", "15", cut))
            wanted = [run for run in sizes.runs(case) if run["tick_hz"] == case["rates_hz"][0] and is_quick(case, run)]
            for what, row in sizes.measure(OPTIONS.bin, case, wanted):
                now = {key: studies.number(value) for key, value in zip(sizes.COLUMNS, row)}
                then = table[tuple(now[name] for name in sizes.KEYS)]
                self.assertEqual(now["vertices"], then["vertices"])
                self.assertEqual(now["integrator"], then["integrator"])
                if now["scheme"] != sizes.REFERENCE:
                    self.assertAlmostEqual(now["error_m"], then["error_m"], delta=SAME_IN_TIME * then["error_m"], msg=what)

    def test_two_threads_end_the_smallest_sheets_as_one_does(self):
        """size_errors fails where they do not."""
        case = next(case for case in sizes.cases() if sizes.key(case) == ("soft", "15", "after"))
        rows = [dict(zip(sizes.THREADS_COLUMNS, row)) for _, row in sizes.measure_threads(OPTIONS.bin, case)]
        self.assertEqual([row["scheme"] for row in rows], [run["scheme"] for run in sizes.compared(case)])
        for row in rows:
            self.assertGreater(float(row["two_wall_s_per_s"]), 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="where kerf, scene_errors, time_errors and size_errors are")
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
