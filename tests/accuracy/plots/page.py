"""The page tests/accuracy/PLOTS.md: its text, of the tables beside this script and words.json."""

import json

import sizes
import studies

PAGE = studies.HERE.parent / "PLOTS.md"
MATERIALS = ("soft", "wool")
DEFAULT_SOLVER = "block-jacobi-cg"


def two_digits(value):
    """Without an exponent where that is short."""
    return f"{float(f'{value:.2g}'):,g}" if 1e-4 < value < 1e6 else f"{value:.2g}"


def percent(value):
    return f"{100 * value:.2g} %"


def order_text(found, uncertainty):
    """Gives the order that is seen even where the reference allows none."""
    order = studies.observed_order(found, uncertainty)
    return f"order {order:.1f}" if order is not None else f"(order {studies.observed_order(found, 0):.1f})"


def pictures():
    """Returns the subject and the rows of each picture."""
    said = studies.studies()
    convergence, profiles, histories, time, size, threads = (
        studies.table(name) for name in (studies.CONVERGENCE, studies.PROFILES, studies.HISTORIES, studies.TIME, studies.SIZE,
                                         studies.THREADS))
    curves = [next(curve for curve in study["curves"] if curve["scene"] == said["run_time"][study["name"]])
              | {"study": study["name"]} for study in said["convergence"] if study["name"] in said["run_time"]]
    return {
        "convergence": [(study, [row for row in convergence if row["study"] == study["name"]])
                        for study in said["convergence"]],
        "profiles": [(study, [row for row in profiles if row["study"] == study["name"]]) for study in said["profiles"]],
        "histories": [(scene, [row for row in histories if row["scene"] == scene])
                      for scene in said["histories"]["scenes"]],
        "time": [(material, [row for row in time if row["material"] == material]) for material in MATERIALS],
        "shown": said["solvings"],
        "size": [(material, [row for row in size if row["material"] == material]) for material in MATERIALS],
        "solvers": [(material, sizes.of_every_solver([row for row in size if row["material"] == material]))
                    for material in MATERIALS],
        "threads": sizes.with_errors(threads, size),
        "run_time": (curves, [row for row in convergence for curve in curves
                              if (row["study"], row["curve"]) == (curve["study"], curve["label"])]),
    }


def digests():
    """Returns the digest that each picture must have in its metadata, by the name of the picture."""
    drawn = pictures()
    found = {study["name"]: studies.digest(study, rows) for study, rows in drawn["convergence"] + drawn["profiles"]}
    found |= {f"history_{scene}": studies.digest(scene, rows) for scene, rows in drawn["histories"]}
    found |= {f"time_{material}": studies.digest([material, drawn["shown"]], rows) for material, rows in drawn["time"]}
    found["work_precision"] = studies.digest(drawn["shown"], [row for _, rows in drawn["time"] for row in rows])
    found |= {f"size_{material}": studies.digest([material, studies.studies()["ways"]], rows) for material, rows in drawn["size"]}
    found |= {f"solvers_{material}": studies.digest([material, studies.studies()["ways"]], rows)
              for material, rows in drawn["solvers"]}
    found["threads"] = studies.digest("threads", drawn["threads"])
    found["run_time"] = studies.digest(*drawn["run_time"])
    return found


def integrator_of(row):
    return row["integrator"] + (" mixed" if row["precision"] == "mixed" else "")


def time_curves(rows, shown):
    """Returns the rows of each integrator and of each way of solving that is shown, longest steps first."""
    curves = []
    for name in dict.fromkeys(integrator_of(row) for row in rows):
        mine = [row for row in rows if integrator_of(row) == name]
        if mine[0]["solver"] == "none":
            curves.append({"integrator": name, "style": "-", "is_implicit": False, "rows": mine})
            continue
        for way in shown:
            some = [row for row in mine if all(row[key] == way[key] for key in ("solver", "newton_iterations"))]
            curves.append({"integrator": name, "style": way["style"], "is_implicit": True, "rows": some})
    return curves


def convergence_table(study, rows):
    lines = ["| | reference, known to | vertices | error, coarsest to finest | observed order |", "|---|---|---|---|---|"]
    for curve in study["curves"]:
        found = studies.points(rows, curve)
        uncertainty = studies.quantity(curve["scene"], curve["quantity"])["uncertainty_rel"]
        known = "exact" if uncertainty < 1e-8 else percent(uncertainty)
        lines.append(f"| {curve['label']} | {studies.expectation(curve['scene'])['reference']}, {known} "
                     f"| {found[0][2]} to {found[-1][2]} | {', '.join(percent(point[1]) for point in found)} "
                     f"| {order_text(found, uncertainty).replace('order ', '')} |")
    return lines


def history_table(rows):
    has_momenta = rows[0]["momentum"] != ""
    titles = ["energy at the end"] + (["momentum, largest change", "angular momentum, largest change"] if has_momenta else [])
    lines = ["| | " + " | ".join(titles) + " |", "|---" * (len(titles) + 1) + "|"]
    for run in dict.fromkeys(row["run"] for row in rows):
        mine = [row for row in rows if row["run"] == run]
        cells = [f"{mine[-1]['energy']:+.1e}"]
        if has_momenta:
            cells += [f"{max(row[what] for row in mine):.1e}" for what in ("momentum", "angular_momentum")]
        lines.append(f"| {run} | " + " | ".join(cells) + " |")
    return lines


def time_table(rows):
    """Orders are those of the runs solved to the end, except explicit ones."""
    lines = ["| | step (ms) | error solved to the end (mm) | order | error as by default (mm) | of that left by solving (mm) |",
             "|---|---|---|---|---|---|"]
    for name in dict.fromkeys(integrator_of(row) for row in rows):
        mine = [row for row in rows if integrator_of(row) == name]
        is_explicit = mine[0]["solver"] == "none"
        solved = mine if is_explicit else [row for row in mine if row["newton_iterations"] == 100]
        default = mine if is_explicit else [row for row in mine if row["solver"] == DEFAULT_SOLVER]
        order = studies.observed_order([(row["step_s"], row["error_fine_m"]) for row in solved], 0)

        def ends(of, what):
            return " to ".join(f"{1e3 * row[what]:.2g}" for row in (of[0], of[-1]))
        lines.append(f"| {name} | {ends(solved, 'step_s')} | {'-' if is_explicit else ends(solved, 'error_fine_m')} | {order:.2f} "
                     f"| {ends(default, 'error_fine_m')} | {'-' if is_explicit else ends(default, 'error_same_step_m')} |")
    return lines


def scheme_of(row):
    solving = f", {row['solver'].replace('_', ' ').lower()}, {row['newton_limit']:g} Newton" if row["solver"] else ""
    return f"{row['scheme']}{solving}"


def against(default, other):
    return (f"{scheme_of(other)}, {1e3 / other['tick_hz']:.3g} ms: {other['cpu_s_per_s'] / default['cpu_s_per_s']:.2g} x the time, "
            f"{other['error_m'] / default['error_m']:.2g} x the error")


def size_table(rows):
    lines = ["| vertices | cut | tick (ms) | compared at (ms) | the default is | error (mm) | CPU s a s | on the front "
             "| nearest in twice the time |", "|---|---|---|---|---|---|---|---|---|"]
    for row in sizes.defaults(rows):
        better, nearest = sizes.dominating(rows, row), sizes.nearest_within(rows, row, 2)
        lines.append(f"| {row['vertices']:g} | {row['cut']} | {1e3 / row['tick_hz']:.3g} | {1e3 * row['end_s']:.3g} "
                     f"| {row['integrator']} | {1e3 * row['error_m']:.2g} | {row['cpu_s_per_s']:.2g} "
                     f"| {f'no: {against(row, better[0])}' if better else 'yes'} "
                     f"| {against(row, nearest) if nearest else 'the default'} |")
    return lines


def front_words(rows):
    """Says by the table whether the defaults lie on the front."""
    found = [(row, sizes.dominating(rows, row)) for row in sizes.defaults(rows)]
    off = [better for _, better in found if better]
    lines = [f"The default lies on the front in **{len(found) - len(off)} of {len(found)}** cases: nothing else with ticks as long or "
             "shorter takes less than", f"{sizes.SAME_TIME:g} of its time for no larger error (up to "
             f"{100 * (sizes.SAME_ERROR - 1):.0f} %)."]
    if off:
        lines.append(f"In {len(off)} something else is better; the table names the fastest.")
    return [*lines, ""]


def left_out_words(rows):
    left_out = dict.fromkeys((row["side"], row["cut"], scheme_of(row), row["tick_hz"], row["left_out"]) for row in rows
                             if row["left_out"] and row["scheme"] != sizes.REFERENCE)
    lines = [f"Without an error: {side:g} x {side:g}, {cut} the cut, {scheme}, {hz:g} Hz, which {why}."
             for side, cut, scheme, hz, why in left_out]
    return ["", *lines] if lines else []


def size_section(material, rows, words):
    """Both what is said of each material and what was left out."""
    shown = [way["solver"] for way in studies.studies()["ways"] if "style" in way]
    return section(words["titles"][f"size_{material}"], f"size_{material}", words,
                   [*front_words(rows), *size_table(rows), *left_out_words([row for row in rows if row["solver"] in ["", *shown]])])


SOLVERS_TABLE_SCHEME = "TR-BDF2"


def solvers_of(ways):
    """The ways of solving that differ by their solver alone."""
    return [way for way in ways if way["newton_iterations"] == 2]


def solvers_table(rows):
    """One scheme at the longest ticks: times the default's time, and the error."""
    solvers = {way["solver"]: solver_label(way) for way in solvers_of(studies.studies()["ways"])}
    lines = ["| vertices | cut | the default | " + " | ".join(solvers.values()) + " |", "|---" * (3 + len(solvers)) + "|"]
    for default in sizes.defaults(rows):
        mine = {row["solver"]: row for row in rows if row["scheme"] == SOLVERS_TABLE_SCHEME and row["newton_limit"] == 2
                and all(row[key] == default[key] for key in ("side", "cut", "tick_hz"))}
        if default["tick_hz"] == min(row["tick_hz"] for row in rows if row["side"] == default["side"]):
            lines.append(f"| {default['vertices']:g} | {default['cut']} | {1e3 * default['error_m']:.2g} mm | "
                         + " | ".join(beside_default(mine.get(solver)) for solver in solvers) + " |")
    return lines


def beside_default(row):
    if row is None:
        return "-"
    error = "no error" if row["error_m"] == "" else f"{two_digits(1e3 * row['error_m'])} mm"
    return f"{two_digits(row['cpu_s_per_s'] / row['default_cpu_s_per_s'])} x, {error}"


def solver_label(way):
    return way["label"].replace(", 2 Newton steps", "")


def scheme_in_threads(row):
    return "the default" if row["scheme"] == "automatic" else scheme_of(row).replace(", 2 Newton", "")


def threads_table(rows):
    lines = ["| | vertices | cut | | error (mm) | one thread, wall s a s | two, wall s a s and sheet | gain | CPU time, two over one |",
             "|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        lines.append(f"| {row['material']} | {row['vertices']:g} | {row['cut']} | {scheme_in_threads(row)} "
                     f"| {two_digits(1e3 * row['error_m'])} | {two_digits(row['one_wall_s_per_s'])} "
                     f"| {two_digits(row['two_wall_s_per_s'])} | {sizes.gain(row):.2f} "
                     f"| {row['two_cpu_s_per_s'] / row['one_cpu_s_per_s']:.2f} |")
    return lines


def section(title, name, words, table=()):
    return [f"## {title}", "", f"![{title}](plots/{name}.png)", "", *words[name], "", *table, *([""] if table else [])]


def text():
    words = json.loads((studies.HERE / "words.json").read_text())
    drawn = pictures()
    lines = ["# Accuracy in pictures", "", *words["start"], ""]
    after = {study["after"]: study for study, _ in drawn["profiles"]}
    profiles = dict((study["name"], rows) for study, rows in drawn["profiles"])
    for study, rows in drawn["convergence"]:
        lines += section(study["title"], study["name"], words, convergence_table(study, rows))
        if study["name"] in after:
            shown = after[study["name"]]
            assert profiles[shown["name"]]
            lines += section(shown["title"], shown["name"], words)
    lines += section("Error against run time, at rest", "run_time", words)
    for scene, rows in drawn["histories"]:
        lines += section(words["titles"][scene], f"history_{scene}", words, history_table(rows))
    for material, rows in drawn["time"]:
        lines += section(words["titles"][material], f"time_{material}", words, time_table(rows))
    lines += section("Error against run time, in motion", "work_precision", words)
    for material, rows in drawn["size"]:
        lines += size_section(material, rows, words)
    for material, rows in drawn["solvers"]:
        lines += section(words["titles"][f"solvers_{material}"], f"solvers_{material}", words,
                         [*solvers_table(rows), *left_out_words(rows)])
    lines += section("Error against run time, on one thread and two", "threads", words, threads_table(drawn["threads"]))
    return "\n".join(lines).rstrip() + "\n"
