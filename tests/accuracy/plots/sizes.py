"""Sheets of 1 m x 1 m that fall from the horizontal, two corners held, from 225 to 102,400 vertices, before and after a cut;
what `sizes` of studies.json says is measured of each."""

import json
import pathlib
import subprocess
import tempfile

import motion
import studies

REFERENCE = "reference"  # explicit steps without damping, in double
CUTS = ("before", "after")
MATERIALS = {"soft": motion.MATERIAL, "wool": {"preset": "wool"}}
# An S across the middle, half as wide as the sheet.
SLIT = {"bezier": {"points": [{"x": x, "y": y} for x, y in ((0.25, 0.5), (0.4, 0.9), (0.6, 0.1), (0.75, 0.5))]}}
SAME_TIME = 0.9  # -; noise of run times: only less than this part of a time is less
SAME_ERROR = 1.02  # -; errors up to this many times another are no larger
REACHED = 1e-9  # s; what a run may be short of its end

KEYS = ["material", "side", "cut", "scheme", "solver", "newton_limit", "tick_hz"]
COLUMNS = [*KEYS, "end_s", "reference_cfl", "vertices", "integrator", "substeps", "solves", "linear_iterations",
           "ticks_not_converged", "ticks_repaired", "cpu_s_per_s", "error_m", "left_out"]


def cases():
    """Of each what `sizes` says of it: material, side, whether it is cut, and how it is measured."""
    return [{"material": material, "side": size["side"], "cut": cut, **size[material]}
            for size in studies.studies()["sizes"] for material in MATERIALS for cut in CUTS]


def key(case):
    """As the first columns of its rows have it."""
    return (case["material"], str(case["side"]), case["cut"])


def runs(case):
    """What is run of a case: scheme, solver, Newton iterations, rate of ticks; the integrator as a scene has it."""
    said, found = studies.studies(), []
    for rate in case["rates_hz"]:
        for name, scheme in said["schemes"].items():
            for way in said["ways"] if scheme.get("is_implicit") else [{}]:
                solving = {key: way[key] for key in ("solver", "newton_iterations") if way}
                found.append({"scheme": name, "solver": way.get("solver", ""), "tick_hz": rate,
                              "newton_limit": way.get("newton_iterations", ""),
                              "integrator": {**scheme["integrator"], **solving}})
    return [run for run in found if is_wanted(case, run)]


def is_wanted(case, run):
    if run["solver"] and "only" in case:
        return f"{run['scheme']} {run['solver']} {run['newton_limit']}" in case["only"]
    return run["scheme"] not in case.get("without", [])


def scene(case, run):
    ticks = round(case["end_s"] * run["tick_hz"])
    assert abs(ticks - case["end_s"] * run["tick_hz"]) < 1e-6, case
    return {"grid": {"columns": case["side"], "rows": case["side"], "width_m": 1, "height_m": 1},
            "placement": {"x_axis": {"x": 1}, "y_axis": {"y": 1}}, "pins": [{"edge": "TOP_CORNERS"}],
            "material": MATERIALS[case["material"]], "integrator": run["integrator"], "tick_rate_hz": run["tick_hz"],
            "ticks": ticks,
            "commands": [{"tick": 1, "command": {"cut": {"curve": SLIT}}}] if case["cut"] == "after" else []}


def measure(tools, case):
    """Yields (what was run, its row of size.csv), the reference first, as they are found."""
    wanted = runs(case)
    reference = {**wanted[0], "scheme": REFERENCE, "solver": "", "newton_limit": ""}
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / f"{i}.json" for i in range(len(wanted))]
        for file, run in zip(files, wanted):
            file.write_text(json.dumps(scene(case, run)))
        with subprocess.Popen([tools / "size_errors", str(case["reference_cfl"]), *files], stdout=subprocess.PIPE,
                              text=True) as program:
            for run, line in zip([reference, *wanted], program.stdout):
                yield f"{case['material']}, {case['side']} x {case['side']}, {case['cut']} a cut: {label(run)}", \
                    row(case, run, json.loads(line))
        if program.returncode != 0:
            raise RuntimeError(f"size_errors: {case}")


def label(run):
    said = [str(run[key]) for key in ("scheme", "solver", "newton_limit") if run[key] != ""]
    return f"{' '.join(said)}, {run['tick_hz']:g} Hz"


def why_no_error(case, run, found):
    if run["scheme"] == REFERENCE:
        return "it is the reference"
    if case["end_s"] - found["simulated_s"] > REACHED:
        return f"came to {found['simulated_s']:.4g} s alone"
    return ""


def row(case, run, found):
    why = why_no_error(case, run, found)
    given = {**case, **found, **run, "end_s": f"{case['end_s']:.6g}", "left_out": why, "integrator": chosen(found["integrator"]),
             "cpu_s_per_s": f"{found['cpu_s'] / found['simulated_s']:.4g}" if found["simulated_s"] > 0 else "",
             "error_m": "" if why else f"{found['error_m']:.5g}"}
    return [str(given[column]) for column in COLUMNS]


def chosen(description):
    """Of what an automatic integrator says of itself, which one it is; else nothing."""
    return description.split(": ")[1].split(";")[0] if description.startswith("automatic") else ""


def dominating(rows, default):
    """What dominates the default: faster, and with no larger error; the fastest first."""
    return sorted((row for row in rivals(rows, default) if row["cpu_s_per_s"] < SAME_TIME * default["cpu_s_per_s"]
                   and row["error_m"] <= SAME_ERROR * default["error_m"]), key=lambda row: row["cpu_s_per_s"])


def nearest_within(rows, default, times):
    """Of what takes at most so many times the default's time the one with the least error; None where that is the default's."""
    near = [row for row in rivals(rows, default) if row["cpu_s_per_s"] <= times * default["cpu_s_per_s"]
            and SAME_ERROR * row["error_m"] < default["error_m"]]
    return min(near, key=lambda row: row["error_m"], default=None)


def rivals(rows, default):
    """Of its case what has an error and is no default, with its ticks or shorter ones: longer ones would do less."""
    return [row for row in rows if all(row[column] == default[column] for column in ("material", "side", "cut"))
            and row["scheme"] != "automatic" and row["error_m"] != "" and row["tick_hz"] >= default["tick_hz"]]


def defaults(rows):
    return [row for row in rows if row["scheme"] == "automatic" and row["error_m"] != ""]
