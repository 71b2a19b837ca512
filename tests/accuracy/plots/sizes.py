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
OTHER_SYSTEM = ("ES_CGM", "AS_CGM")  # solvers: what they find is no solution of the step's equations
SAME_TIME = 0.9  # -; noise of run times: only less than this part of a time is less
SAME_ERROR = 1.02  # -; errors up to this many times another are no larger
REACHED = 1e-9  # s; what a run may be short of its end
MOST_CPU_S = 60  # of a run, which then ends short of its time

KEYS = ["material", "side", "cut", "scheme", "solver", "newton_limit", "tick_hz"]
COLUMNS = [*KEYS, "end_s", "reference_cfl", "vertices", "integrator", "substeps", "solves", "linear_iterations",
           "ticks_not_converged", "ticks_repaired", "cpu_s_per_s", "default_cpu_s_per_s", "error_m", "left_out"]
THREADS_COLUMNS = [*KEYS, "end_s", "vertices", "rounds", "one_wall_s_per_s", "one_cpu_s_per_s", "two_wall_s_per_s",
                   "two_cpu_s_per_s"]


def cases():
    """Returns material and side of each case, whether it is cut, and what `sizes` says about how it is measured."""
    return [{"material": material, "side": size["side"], "cut": cut, **size[material]}
            for size in studies.studies()["sizes"] for material in MATERIALS for cut in CUTS]


def key(case):
    """As the first columns of its rows have it."""
    return (case["material"], str(case["side"]), case["cut"])


def runs(case):
    """Returns the runs of a case: scheme, solver, Newton iterations, rate of ticks; the integrator as a scene has it."""
    said, found = studies.studies(), []
    for rate in case["rates_hz"]:
        ways = [way for way in said["ways"] if case["side"] <= way.get("largest_side", case["side"])
                and rate <= way.get("highest_rate_hz", rate)]
        for name, scheme in said["schemes"].items():
            for way in ways if scheme.get("is_implicit") else [{}]:
                solving = {key: way[key] for key in ("solver", "newton_iterations") if way}
                found.append({"scheme": name, "solver": way.get("solver", ""), "tick_hz": rate,
                              "newton_limit": way.get("newton_iterations", ""),
                              "integrator": {**scheme["integrator"], **solving}})
    return [run for run in found if is_wanted(case, run)]


def runs_of(case, solvers):
    """The runs with one of these solvers and the default beside them; nothing where there is none; all where none is named."""
    mine = [run for run in runs(case) if run["solver"] in solvers]
    rates = {run["tick_hz"] for run in mine}
    beside = [run for run in runs(case) if run["scheme"] == "automatic" and run["tick_hz"] in rates]
    return sorted(beside + mine, key=lambda run: run["tick_hz"]) if solvers else runs(case)


def row_key(case, run):
    return (*key(case), *(str(run[column]) for column in KEYS[3:]))


def reference_of(run):
    return {**run, "scheme": REFERENCE, "solver": "", "newton_limit": ""}


def in_order(rows):
    """Takes rows by their keys, and returns those of cases and runs that are measured, in the order of these."""
    wanted = [row_key(case, run) for case in cases() for run in [reference_of(runs(case)[0]), *runs(case)]]
    return [rows[each] for each in wanted if each in rows]


def is_wanted(case, run):
    if run["solver"] and "only" in case:
        return name_of(run) in case["only"]
    return run["scheme"] not in case.get("without", [])


def scene(case, run):
    ticks = round(case["end_s"] * run["tick_hz"])
    assert abs(ticks - case["end_s"] * run["tick_hz"]) < 1e-6, case
    return {"grid": {"columns": case["side"], "rows": case["side"], "width_m": 1, "height_m": 1},
            "placement": {"x_axis": {"x": 1}, "y_axis": {"y": 1}}, "pins": [{"edge": "TOP_CORNERS"}],
            "material": MATERIALS[case["material"]], "integrator": run["integrator"], "tick_rate_hz": run["tick_hz"],
            "ticks": ticks,
            "commands": [{"tick": 1, "command": {"cut": {"curve": SLIT}}}] if case["cut"] == "after" else []}


def found_of(tools, options, case, wanted, scenes):
    """Yields (run, what size_errors says of it) as they are found; `wanted`: the runs that it reports."""
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / f"{i}.json" for i in range(len(scenes))]
        for file, content in zip(files, scenes):
            file.write_text(json.dumps(content))
        with subprocess.Popen([tools / "size_errors", *options, *files], stdout=subprocess.PIPE, text=True) as program:
            for run, line in zip(wanted, program.stdout):
                yield run, json.loads(line)
        if program.returncode != 0:
            raise RuntimeError(f"size_errors: {case}")


def measure(tools, case, wanted=None):
    """Yields (what was run, its row of size.csv), the reference first, as they are found. Of `wanted`, by default all, the
    default integrator comes first at each rate: rows have its time, too."""
    wanted = wanted or runs(case)
    reference = reference_of(wanted[0])
    default_cpu_s_per_s = {}
    for run, found in found_of(tools, [str(case["reference_cfl"]), str(MOST_CPU_S)], case, [reference, *wanted],
                               [scene(case, run) for run in wanted]):
        if run["scheme"] == "automatic":
            default_cpu_s_per_s[run["tick_hz"]] = cpu_s_per_s(found)
        yield title(case, run), row(case, run, found, default_cpu_s_per_s.get(run["tick_hz"], ""))


def compared(case):
    """The runs of a case that are compared on one thread and two: the default and what `threads` names, of the case if it
    has such, at its longest ticks; none where that is null."""
    named = case.get("threads", studies.studies()["threads"])
    if named is None:
        return []
    first = [run for run in runs(case) if run["tick_hz"] == case["rates_hz"][0]]
    return [run for run in first if run["scheme"] == "automatic" or name_of(run) in named]


def measure_threads(tools, case):
    """Yields (what was run, its row of threads.csv)."""
    wanted = compared(case)
    for run, found in found_of(tools, ["--threads"], case, wanted, [scene(case, run) for run in wanted]):
        simulated = {"one_wall_s": 1, "one_cpu_s": 1, "two_wall_s": 2, "two_cpu_s": 1}  # sheets while that time passes
        shown = {f"{key}_per_s": f"{found[key] / sheets / found['simulated_s']:.4g}" for key, sheets in simulated.items()}
        given = {**case, **found, **run, **shown, "end_s": f"{case['end_s']:.6g}"}
        yield title(case, run), [str(given[column]) for column in THREADS_COLUMNS]


def title(case, run):
    return f"{case['material']}, {case['side']} x {case['side']}, {case['cut']} a cut: {label(run)}"


def name_of(run):
    """As `only` and `threads` of a case have it."""
    return f"{run['scheme']} {run['solver']} {run['newton_limit']}"


def label(run):
    said = [str(run[key]) for key in ("scheme", "solver", "newton_limit") if run[key] != ""]
    return f"{' '.join(said)}, {run['tick_hz']:g} Hz"


def why_no_error(case, run, found):
    if run["scheme"] == REFERENCE:
        return "it is the reference"
    if case["end_s"] - found["simulated_s"] > REACHED:
        in_time = f" in {MOST_CPU_S} s of CPU time" if found["cpu_s"] > MOST_CPU_S else ""
        return f"came to {found['simulated_s']:.4g} s alone{in_time}"
    return ""


def cpu_s_per_s(found):
    return f"{found['cpu_s'] / found['simulated_s']:.4g}" if found["simulated_s"] > 0 else ""


def row(case, run, found, default_cpu_s_per_s):
    why = why_no_error(case, run, found)
    given = {**case, **found, **run, "end_s": f"{case['end_s']:.6g}", "left_out": why, "integrator": chosen(found["integrator"]),
             "cpu_s_per_s": cpu_s_per_s(found), "default_cpu_s_per_s": default_cpu_s_per_s,
             "error_m": "" if why else f"{found['error_m']:.5g}"}
    return [str(given[column]) for column in COLUMNS]


def chosen(description):
    """Returns the integrator that an automatic one chose, by its description; "" for any other."""
    return description.split(": ")[1].split(";")[0] if description.startswith("automatic") else ""


def dominating(rows, default):
    """Returns the rows that dominate the default, the fastest first: they are faster and have no larger error."""
    return sorted((row for row in rivals(rows, default) if row["cpu_s_per_s"] < SAME_TIME * default["cpu_s_per_s"]
                   and row["error_m"] <= SAME_ERROR * default["error_m"]), key=lambda row: row["cpu_s_per_s"])


def nearest_within(rows, default, times):
    """Returns the row with the least error among those that take at most `times` the time of the default. None: that is the
    default's."""
    near = [row for row in rivals(rows, default) if row["cpu_s_per_s"] <= times * default["cpu_s_per_s"]
            and SAME_ERROR * row["error_m"] < default["error_m"]]
    return min(near, key=lambda row: row["error_m"], default=None)


def rivals(rows, default):
    """Returns the rows of the default's case that have an error and are no default. Their ticks are as long or shorter: longer
    ones would do less. Times are those of scaled()."""
    mine = [row for row in rows if all(row[column] == default[column] for column in ("material", "side", "cut"))
            and row["error_m"] != "" and row["tick_hz"] >= default["tick_hz"]]
    return [row for row in scaled(mine) if row["scheme"] != "automatic"]


def defaults(rows):
    return [row for row in rows if row["scheme"] == "automatic" and row["error_m"] != ""]


def of_every_solver(rows):
    """Those of sheets that every solver for sparse matrices is run on, with the times of scaled()."""
    sides = {row["side"] for row in rows if row["solver"] == "PLAIN_CG"}
    return scaled([row for row in rows if row["side"] in sides])


def scaled(rows):
    """All but references; times as many times the default's of the table as they were of the default's in the same run:
    tables are made in several."""
    of_default = {case_of(row): row["cpu_s_per_s"] for row in rows if row["scheme"] == "automatic"}
    return [{**row, "cpu_s_per_s": row["cpu_s_per_s"] / row["default_cpu_s_per_s"] * of_default[case_of(row)],
             "default_cpu_s_per_s": of_default[case_of(row)]}
            for row in rows if row["scheme"] != REFERENCE]


def case_of(row):
    """With its ticks."""
    return tuple(row[column] for column in ("material", "side", "cut", "tick_hz"))


def with_errors(threads, rows):
    """Rows of threads.csv with the errors of the same runs in size.csv."""
    known = {tuple(row[column] for column in KEYS): row["error_m"] for row in rows}
    return [{**row, "error_m": known[tuple(row[column] for column in KEYS)]} for row in threads]


def gain(row):
    """Returns the gain by a second thread: how many sheets are stepped in the time of one."""
    return row["one_wall_s_per_s"] / row["two_wall_s_per_s"]
