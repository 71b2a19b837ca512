#!/usr/bin/python3
"""Measures what the page tests/accuracy/PLOTS.md shows, into the tables beside this script; draw.py makes the page of them.

    cmake --preset release && cmake --build --preset release --target kerf scene_errors time_errors size_errors
    tests/accuracy/plots/measure.py                       # everything, most of an hour
    tests/accuracy/plots/measure.py convergence --only bending drape
    tests/accuracy/plots/measure.py size --only 'wool 50' --solvers PLAIN_CG JACOBI_CG
    tests/accuracy/plots/measure.py threads

convergence.csv   errors of scenes of tests/data/scenes/reference on coarser and finer meshes, against their references
profiles.csv      some of them row by row
histories.csv     energy and momenta of a sheet that nothing pushes, and the energy of one that swings
time.csv          errors of integrators over their step, and their run time (time_errors.cc)
size.csv          the same of ticks of sheets of all sizes, before and after a cut (sizes.py, size_errors.cc)
threads.csv       run times of some of them on one thread, and of two at once on two

`fineness` is the number of cells a length over that of the scene's file; `edge` the side of a cell over the root of the
sheet's area. Times (cpu_s) are of this machine; the rest is the same on all.
"""

import argparse
import csv
import io
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import motion
import sizes
import studies

sys.path.insert(0, str(studies.SCENES))
import generate  # noqa: E402

CONVERGENCE_COLUMNS = ["study", "curve", "fineness", "edge", "vertices", "error", "cpu_s"]
PROFILE_COLUMNS = ["study", "fineness", "along", "expected", "found"]
HISTORY_COLUMNS = ["scene", "run", "time_s", "energy", "momentum", "angular_momentum"]


class Progress:
    """A bar on standard error."""

    def __init__(self, total):
        self.total, self.done = total, 0

    def show(self, what):
        if sys.stderr.isatty():
            filled = 30 * self.done // self.total
            print(f"\r[{'#' * filled}{'.' * (30 - filled)}] {self.done}/{self.total} {what:50.50}", end="", file=sys.stderr)
        else:
            print(f"{self.done}/{self.total} {what}", file=sys.stderr)
        self.done += 1

    def end(self):
        self.show("done")
        if sys.stderr.isatty():
            print(file=sys.stderr)


def relative_edge(scene):
    """Side of a cell over the root of the sheet's area, before any cut."""
    if "grid" in scene:
        return 1 / math.sqrt((scene["grid"]["columns"] - 1) * (scene["grid"]["rows"] - 1))
    return 1 / math.sqrt(len(scene["inline"]["triangles"]) / 6)


def scene_errors(tools, name, fineness, curves, overrides):
    """Returns what scene_errors prints for a scene of this fineness, for the quantities of these curves alone."""
    scene = generate.scenes(fineness)[name]
    scene |= {**overrides, "material": scene["material"] | overrides.get("material", {})}
    wanted = studies.expectation(name)
    rows = {curve["quantity"]: curve.get("rows") for curve in curves}
    wanted["checks"] = [{**check, "rows": rows[studies.name_of_check(check)]} if rows[studies.name_of_check(check)] else check
                        for check in wanted["checks"] if studies.name_of_check(check) in rows]
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / f"{name}.expect.json", pathlib.Path(folder) / f"{name}.json"]
        for file, content in zip(files, (wanted, scene)):
            file.write_text(json.dumps(content))
        done = subprocess.run([tools / "scene_errors", *files], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{name}, fineness {fineness:g}: {done.stderr}")
    return {"edge": relative_edge(scene), **json.loads(done.stdout)}


def convergence(tools, study, fineness):
    """Rows of convergence.csv: one study on one fineness. Of checks of one name, both ends of a slit, the worse counts."""
    runs = {}
    for curve in study["curves"]:
        overrides = {**study.get("overrides", {}), **curve.get("overrides", {})}
        runs.setdefault((curve["scene"], json.dumps(overrides)), []).append(curve)
    rows = []
    for (name, overrides), curves in runs.items():
        found = scene_errors(tools, name, fineness, curves, json.loads(overrides))
        for curve in curves:
            error = max((check["error"] for check in found["checks"] if check["name"] == curve["quantity"]), key=abs)
            rows.append([study["name"], curve["label"], fineness, f"{found['edge']:.6g}", found["vertices"],
                         f"{error:.6g}", f"{found['cpu_s']:.3g}"])
    return rows


def profile(tools, study, fineness):
    """Rows of profiles.csv."""
    found = scene_errors(tools, study["scene"], fineness, [study], {})["checks"][0]
    reference = studies.quantity(study["scene"], study["quantity"])["table"]
    column = reference["columns"].index(study["along"])
    return [[study["name"], fineness, row[column], f"{expected:.6g}", f"{value:.6g}"]
            for row, expected, value in zip(reference["rows"], found["expected"], found["found"])]


def history(tools, scene, run, ticks=0):
    """Rows of histories.csv: change of the total energy over the largest kinetic one; of momentum and angular momentum over
    what they were, where nothing pushes (else empty)."""
    content = {**motion.SCENES[scene](), "integrator": run["integrator"]}
    with tempfile.TemporaryDirectory() as folder:
        file, out = pathlib.Path(folder) / "scene.json", pathlib.Path(folder) / "out.json"
        file.write_text(json.dumps(content))
        done = subprocess.run([tools / "kerf", "run", file, "--out", out, *(["--ticks", str(ticks)] if ticks else [])],
                              capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{scene}, {run['label']}: {done.stderr}")
        table = json.loads(out.read_text())["tables"][0]
    rows = [dict(zip(table["columns"], row["values"])) for row in table["rows"]]
    scale = max(row["energy.kinetic"] for row in rows)
    is_free = "momentum.x" in table["columns"]

    def change(row, what):
        now, first = ([each[f"{what}.{axis}"] for axis in "xyz"] for each in (row, rows[0]))
        return f"{math.dist(now, first) / math.hypot(*first):.4g}"
    return [[scene, run["label"], f"{row['time_s']:.6g}", f"{(row['energy.total'] - rows[0]['energy.total']) / scale:.4g}",
             *([change(row, "momentum"), change(row, "spin")] if is_free else ["", ""])]
            for row in rows[::motion.TICKS_A_ROW]]


def text_of(columns, rows):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([columns, *rows])
    return text.getvalue()


def write_each(out, columns, tasks):
    """Does the tasks, each a pair of what it is and what gives its rows, and writes them as they come."""
    progress, rows = Progress(len(tasks)), []
    for what, task in tasks:
        progress.show(what)
        rows += task()
        out.write_text(text_of(columns, rows))
    progress.end()


def merged(file, columns, rows, study_names):
    """With what the file already says of other studies."""
    kept = []
    if file.exists():
        with open(file, newline="") as old:
            kept = [row for row in list(csv.reader(old))[1:] if row[0] not in study_names]
    order = [study["name"] for study in studies.studies()["convergence"] + studies.studies()["profiles"]]
    return text_of(columns, sorted(kept + rows, key=lambda row: order.index(str(row[0]))))


def is_wanted(name, only):
    return any(part in name for part in only)


def measure_studies(tools, folder, kind, given):
    columns, file, measure = {"convergence": (CONVERGENCE_COLUMNS, folder / studies.CONVERGENCE, convergence),
                              "profiles": (PROFILE_COLUMNS, folder / studies.PROFILES, profile)}[kind]
    wanted = [study for study in studies.studies()[kind] if is_wanted(study["name"], given.only)]
    tasks = [(study, fineness) for study in wanted for fineness in study["fineness"]]
    progress, rows = Progress(max(1, len(tasks))), []
    for study, fineness in tasks:
        progress.show(f"{study['name']}, fineness {fineness:g}")
        rows += measure(tools, study, fineness)
    progress.end()
    file.write_text(merged(file, columns, rows, [study["name"] for study in wanted]))


def measure_histories(tools, folder, _):
    said = studies.studies()["histories"]
    write_each(folder / studies.HISTORIES, HISTORY_COLUMNS,
               [(f"{scene}, {run['label']}", lambda scene=scene, run=run: history(tools, scene, run))
                for scene in said["scenes"] for run in said["runs"]])


def time_rows(tools, material, *options):
    """Columns and rows of time.csv."""
    done = subprocess.run([tools / "time_errors", material, *options], capture_output=True, text=True, check=True)
    lines = list(csv.reader(io.StringIO(done.stdout)))
    return lines[0], lines[1:]


def measure_time(tools, folder, _):
    progress, rows = Progress(2), []
    for material in ("soft", "wool"):
        progress.show(f"integrators, {material}")
        columns, more = time_rows(tools, material)
        rows += more
    progress.end()
    (folder / studies.TIME).write_text(text_of(columns, rows))


def wanted_cases(given):
    return [case for case in sizes.cases() if is_wanted(f"{case['material']} {case['side']} {case['cut']}", given.only)]


def known_rows(file):
    """Returns the rows that a table of sizes has already, by keys."""
    if not file.exists():
        return {}
    with open(file, newline="") as old:
        return {tuple(row[:len(sizes.KEYS)]): row for row in list(csv.reader(old))[1:]}


def measure_size(tools, folder, given):
    """Writes after each case; what the file already says of others stays, and of other solvers where some are named."""
    out = folder / studies.SIZE
    known = known_rows(out)
    wanted = [case for case in wanted_cases(given) if sizes.runs_of(case, given.solvers)]
    progress = Progress(max(1, sum(1 + len(sizes.runs_of(case, given.solvers)) for case in wanted)))
    for case in wanted:
        for what, row in sizes.measure(tools, case, sizes.runs_of(case, given.solvers)):
            progress.show(what)
            if not given.solvers or row[sizes.KEYS.index("solver")] in given.solvers:
                known[tuple(row[:len(sizes.KEYS)])] = row
        out.write_text(text_of(sizes.COLUMNS, sizes.in_order(known)))
    progress.end()


def measure_threads(tools, folder, given):
    out = folder / studies.THREADS
    known = known_rows(out)
    wanted = [case for case in wanted_cases(given) if sizes.compared(case)]
    progress = Progress(max(1, sum(len(sizes.compared(case)) for case in wanted)))
    for case in wanted:
        for what, row in sizes.measure_threads(tools, case):
            progress.show(what)
            known[tuple(row[:len(sizes.KEYS)])] = row
        out.write_text(text_of(sizes.THREADS_COLUMNS, sizes.in_order(known)))
    progress.end()


MEASURES = {
    "convergence": lambda tools, folder, given: measure_studies(tools, folder, "convergence", given),
    "profiles": lambda tools, folder, given: measure_studies(tools, folder, "profiles", given),
    "histories": measure_histories,
    "time": measure_time,
    "size": measure_size,
    "threads": measure_threads,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", choices=[*MEASURES, []], help="which tables (default: all)")
    parser.add_argument("--only", nargs="+", default=[""], help="studies with one of these in their name, of convergence and "
                        "profiles; of size and threads 'wool 50 after' or a part of that")
    parser.add_argument("--solvers", nargs="+", default=[], help="of size: rows of these alone, as studies.json names them; the "
                        "default is run beside them, and what the table says of it stays")
    parser.add_argument("--bin", type=pathlib.Path, default=studies.ROOT / "build/release/bin", help="where the programs are")
    parser.add_argument("--out", type=pathlib.Path, default=studies.HERE, help="folder of the tables")
    given = parser.parse_args()
    for what in given.what or MEASURES:
        MEASURES[what](given.bin, given.out, given)


if __name__ == "__main__":
    main()
