#!/usr/bin/python3
"""Draws the tables beside this script as small PNGs and writes the page tests/accuracy/PLOTS.md around the pictures.

    apt-get install python3-matplotlib        # nothing else in Kerf needs it
    tests/accuracy/plots/draw.py

The same tables give the same bytes with the same Matplotlib. Each picture tells in its metadata what it is made of.
"""

import io
import math

import page
import sizes
import studies

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a5c00", "#56b4e9", "#000000", "#e69f00"]
MARKERS = "osD^vPX*"
INTEGRATORS = ["explicit", "explicit mixed", "explicit undamped", "implicit Euler", "TR-BDF2", "BDF2", "trapezoidal",
               "trapezoidal solved"]
DOTS_PER_INCH = 90
GUIDE = {"color": "#999999", "linewidth": 0.9}
SETTINGS = {
    "font.size": 10, "font.family": "sans-serif", "axes.grid": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.7, "axes.spines.top": False, "axes.spines.right": False,
    "lines.linewidth": 1.5, "lines.markersize": 5, "legend.frameon": False, "axes.titlesize": 10.5,
}


def look_of(integrator):
    i = INTEGRATORS.index(integrator)
    return {"color": COLOURS[i], "marker": MARKERS[i]}


def save(plt, figure, name):
    """Keeps 128 colours, which makes a picture three times smaller than all of them."""
    import PIL.Image
    import PIL.PngImagePlugin
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DOTS_PER_INCH)
    plt.close(figure)
    comment = PIL.PngImagePlugin.PngInfo()
    comment.add_text("Description", f"made of {page.digests()[name]}")
    picture = PIL.Image.open(drawn).convert("RGB").quantize(128, method=PIL.Image.Quantize.MAXCOVERAGE, dither=PIL.Image.Dither.NONE)
    picture.save(studies.HERE / f"{name}.png", optimize=True, pnginfo=comment)


def legend_beside(axes):
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), labelspacing=0.8)


def guide(axes, order, at):
    """A line of this slope up to twice the x of `at` = (x, y)."""
    x, y = at
    axes.plot([x, 2 * x], [y, y * 2 ** order], **GUIDE)
    axes.annotate(f"order {order}", (2 * x, y * 2 ** order), color="#777777", fontsize=8.5,
                  textcoords="offset points", xytext=(4, -3), bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8})


def label_decades(axis, text, subs):
    """Numbers as text(value) at these multiples of powers of ten."""
    import matplotlib.ticker as ticker
    axis.set_major_locator(ticker.LogLocator(subs=subs))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: text(value)))
    axis.set_minor_formatter(ticker.NullFormatter())


def label_errors(axes):
    bottom, top = axes.get_ylim()
    label_decades(axes.yaxis, lambda value: f"{100 * value:g} %", (1,) if top > 40 * bottom else (1, 2, 5))
    axes.set_ylabel("relative error")


def draw_convergence(plt, study, rows):
    figure, axes = plt.subplots(figsize=(8.2, 4), layout="constrained")
    lowest = 1.0
    for i, curve in enumerate(study["curves"]):
        found = studies.points(rows, curve)
        uncertainty = studies.quantity(curve["scene"], curve["quantity"])["uncertainty_rel"]
        x, y = [point[0] for point in found], [point[1] for point in found]
        axes.loglog(x, y, color=COLOURS[i], marker=MARKERS[i],
                    label=f"{curve['label']}\n{page.order_text(found, uncertainty)}")
        if uncertainty > min(y) / 3:
            axes.loglog([min(x) / 1.15, max(x) * 1.15], 2 * [uncertainty], color=COLOURS[i], linestyle=":", linewidth=1)
        lowest = min(lowest, *y)
    for order in (1, 2):
        guide(axes, order, (axes.get_xlim()[1] / 3.2, 0.6 * lowest))
    label_decades(axes.xaxis, "{:g}".format, (1, 2, 5))
    axes.set_xlabel("side of a cell / √(area of the sheet)")
    label_errors(axes)
    axes.set_title(study["title"], loc="left")
    legend_beside(axes)
    save(plt, figure, study["name"])


def draw_profile(plt, study, rows):
    figure, axes = plt.subplots(figsize=(8.2, 4), layout="constrained")
    for i, fineness in enumerate(study["fineness"]):
        mine = [row for row in rows if row["fineness"] == fineness]
        x = [row["along"] * study["x_scale"] for row in mine]
        if i == 0:
            axes.plot(x, [row["expected"] * study["y_scale"] for row in mine], color="#000000", linewidth=4, alpha=0.25,
                      label="reference")
        axes.plot(x, [row["found"] * study["y_scale"] for row in mine], color=COLOURS[i], marker=MARKERS[i],
                  linestyle="--", linewidth=1, label=f"cells × {fineness:g}")
    axes.set_ylim(bottom=0)
    axes.set_xlabel(study["x_label"])
    axes.set_ylabel(study["y_label"])
    axes.set_title(study["title"], loc="left")
    legend_beside(axes)
    save(plt, figure, study["name"])


DASHED = ("explicit undamped", "explicit mixed", "trapezoidal solved")  # may cover another
HISTORY_PANELS = {"energy": "|E − E₀| / largest kinetic energy", "momentum": "|p − p₀| / |p₀|",
                  "angular_momentum": "|L − L₀| / |L₀|"}


def draw_history(plt, scene, rows):
    panels = [what for what in HISTORY_PANELS if rows[0][what] != ""]
    is_square = len(panels) == 3  # and the legend
    figure, all_axes = plt.subplots(*((2, 2) if is_square else (1, 1)), figsize=(8.6, 7) if is_square else (8.2, 4),
                                    layout="constrained", squeeze=False)
    for axes, what in zip(all_axes.flat, panels):
        for run in dict.fromkeys(row["run"] for row in rows):
            mine = [row for row in rows if row["run"] == run and row[what] != 0]
            axes.semilogy([row["time_s"] for row in mine], [abs(row[what]) for row in mine], color=look_of(run)["color"],
                          linestyle="--" if run in DASHED else "-", label=run)
        axes.set_title(HISTORY_PANELS[what], loc="left")
        axes.set_xlabel("time (s)")
    if is_square:
        all_axes[1][1].axis("off")
        all_axes[1][1].legend(*all_axes[0][0].get_legend_handles_labels(), loc="center", labelspacing=0.8)
    else:
        legend_beside(all_axes[0][0])
    save(plt, figure, f"history_{scene}")


def legend_of_time(plt, axes, curves, shown):
    """Colours are integrators, line styles how their equations are solved."""
    names = dict.fromkeys(curve["integrator"] for curve in curves)
    lines = [plt.Line2D([], [], label=name, **look_of(name)) for name in names]
    lines += [plt.Line2D([], [], label=each["label"], color="#555555", linestyle=each["style"]) for each in shown]
    axes.legend(handles=lines, loc="center left", bbox_to_anchor=(1.02, 0.5), labelspacing=0.8)


def draw_errors(axes, curve, x, what):
    """In mm; hollow where a step had to be repaired."""
    look, y = look_of(curve["integrator"]), [1e3 * row[what] for row in curve["rows"]]
    axes.loglog(x, y, linestyle=curve["style"], **look)
    repaired = [i for i, row in enumerate(curve["rows"]) if row["steps_repaired"] not in ("", 0)]
    axes.loglog([x[i] for i in repaired], [y[i] for i in repaired], linestyle="none", markerfacecolor="white", **look)


def draw_time(plt, material, rows, shown):
    """Left: against the same steps, solved to the end. Right: against the fine reference."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
    shown = [each for each in shown if not each.get("run_time_only")]
    curves = page.time_curves(rows, shown)
    for curve in curves:
        x = [1e3 * row["step_s"] for row in curve["rows"]]
        if curve["is_implicit"]:
            draw_errors(left, curve, x, "error_same_step_m")
        draw_errors(right, curve, x, "error_fine_m")
    left.set_title(f"{material}: what solving leaves of a step", loc="left")
    right.set_title(f"{material}: in all, against the fine reference", loc="left")
    left.set_ylabel("largest error of a vertex at 0.3 s (mm)")
    for axes in (left, right):
        axes.set_xlabel("step (ms)")
    legend_of_time(plt, right, curves, shown)
    save(plt, figure, f"time_{material}")


def draw_work_precision(plt, rows, shown):
    figure, both = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained", sharey=True)
    for axes, material in zip(both, page.MATERIALS):
        curves = page.time_curves([row for row in rows if row["material"] == material], shown)
        for curve in curves:
            draw_errors(axes, curve, [1e3 * row["cpu_s"] for row in curve["rows"]], "error_fine_m")
        axes.set_title(material, loc="left")
        axes.set_xlabel("CPU time of 0.3 s (ms)")
    both[0].set_ylabel("largest error of a vertex at 0.3 s (mm)")
    legend_of_time(plt, both[1], curves, shown)
    save(plt, figure, "work_precision")


DEFAULT = {"color": "#d4007f", "marker": "*", "markersize": 15, "markerfacecolor": "none", "markeredgewidth": 1.6,
           "linestyle": "none", "zorder": 5}


def draw_runs(axes, rows, **look):
    """CPU seconds a simulated second against error, a point for each tick."""
    axes.loglog([row["cpu_s_per_s"] for row in rows], [1e3 * row["error_m"] for row in rows], **look)


def finish_size_panel(axes, rows):
    draw_runs(axes, sizes.defaults(rows), **DEFAULT)
    axes.axvline(1, **GUIDE)
    axes.margins(y=0.15)


def draw_size_panel(axes, rows, ways):
    """A line for each integrator and way of solving."""
    for scheme in dict.fromkeys(row["scheme"] for row in rows if row["scheme"] not in (sizes.REFERENCE, "automatic")):
        for way in [{"solver": "", "newton_iterations": "", "style": "-"}, *ways]:
            mine = [row for row in rows if row["scheme"] == scheme and row["error_m"] != ""
                    and (row["solver"], row["newton_limit"]) == (way["solver"], way["newton_iterations"])]
            draw_runs(axes, mine, linestyle=way["style"], **look_of(scheme))
    finish_size_panel(axes, rows)


def draw_solvers_panel(axes, rows, ways):
    """A line for each integrator and solver; hollow where that solves a different system."""
    for scheme in dict.fromkeys(row["scheme"] for row in rows if row["scheme"].startswith("explicit")):  # no solver
        draw_runs(axes, [row for row in rows if row["scheme"] == scheme], marker=look_of(scheme)["marker"], color="#000000")
    for scheme in dict.fromkeys(row["scheme"] for row in rows if row["solver"]):
        for way in ways:
            mine = [row for row in rows if (row["scheme"], row["solver"], row["newton_limit"], row["error_m"] != "")
                    == (scheme, way["solver"], way["newton_iterations"], True)]
            draw_runs(axes, mine, marker=look_of(scheme)["marker"], **look_of_solver(ways, way))
    finish_size_panel(axes, rows)


def look_of_solver(ways, way):
    is_other = way["solver"] in sizes.OTHER_SYSTEM
    return {"color": COLOURS[ways.index(way)], "linewidth": 0.8, "markerfacecolor": "white" if is_other else None}


def draw_sizes(plt, name, rows, draw_panel, legend):
    """Left before, right after the cut; from above small to large sheets."""
    sides = list(dict.fromkeys(row["side"] for row in rows))
    figure, all_axes = plt.subplots(len(sides) + 1, len(sizes.CUTS), figsize=(9.5, 2.7 * len(sides) + 1), layout="constrained",
                                    sharex=True, sharey="row", height_ratios=[0.4] + len(sides) * [1])
    for axes in all_axes[0]:
        axes.axis("off")  # room for the legend
    for line, side in zip(all_axes[1:], sides):
        for axes, cut in zip(line, sizes.CUTS):
            mine = [row for row in rows if (row["side"], row["cut"]) == (side, cut)]
            draw_panel(axes, mine)
            if mine:
                axes.set_title(f"{mine[0]['vertices']:,.0f} vertices, {cut} the cut, at {1e3 * mine[0]['end_s']:.3g} ms", loc="left")
        bottom, top = line[0].get_ylim()
        margin = max(1, 10 / math.sqrt(top / bottom))  # two decades at least
        line[0].set_ylim(bottom / margin, top * margin)
        line[0].set_ylabel("largest error (mm)")
    all_axes[1][0].annotate("real time", (1, 0.93), xycoords=("data", "axes fraction"), color="#777777", fontsize=8.5,
                            textcoords="offset points", xytext=(4, 0))
    for axes in all_axes[-1]:
        axes.set_xlabel("CPU time of a simulated second (s)")
    figure.legend(handles=[*legend, plt.Line2D([], [], label="the default", **DEFAULT)], loc="upper center", ncols=4)
    save(plt, figure, name)


def schemes():
    return [name for name in studies.studies()["schemes"] if name != "automatic"]


def draw_size(plt, material, rows, ways):
    drawn = [way for way in ways if "style" in way]
    legend = [plt.Line2D([], [], label=name, **look_of(name)) for name in schemes()]
    legend += [plt.Line2D([], [], label=way["label"], color="#555555", linestyle=way["style"]) for way in drawn]
    draw_sizes(plt, f"size_{material}", rows, lambda axes, mine: draw_size_panel(axes, mine, drawn), legend)


def draw_solvers(plt, material, rows, ways):
    drawn = page.solvers_of(ways)
    legend = [plt.Line2D([], [], label=name, color="#000000" if name.startswith("explicit") else "#777777", linestyle="none",
                         marker=look_of(name)["marker"]) for name in schemes()]
    legend += [plt.Line2D([], [], label=page.solver_label(way), marker="o", **look_of_solver(drawn, way)) for way in drawn]
    draw_sizes(plt, f"solvers_{material}", rows, lambda axes, mine: draw_solvers_panel(axes, mine, drawn), legend)


def look_in_threads(row):
    if row["scheme"] == "automatic":
        return {"color": DEFAULT["color"], "marker": "*", "markersize": 10}
    return {**look_of(row["scheme"]), **({"color": COLOURS[0], "marker": "<"} if row["solver"] == "DIRECT" else {})}


def draw_threads_panel(axes, rows):
    """Draws a filled point for one thread and a hollow one for two, for each run."""
    for row in rows:
        look, error = look_in_threads(row), 1e3 * row["error_m"]
        axes.loglog([row["one_wall_s_per_s"], row["two_wall_s_per_s"]], [error, error], **look)
        axes.loglog([row["two_wall_s_per_s"]], [error], markerfacecolor="white", **look)
    axes.set_title(f"{rows[0]['material']}, {rows[0]['vertices']:,.0f}, {rows[0]['cut']} the cut", loc="left")
    for limits, set_limits, decades in ((axes.get_xlim(), axes.set_xlim, 3), (axes.get_ylim(), axes.set_ylim, 2)):
        middle, half = math.sqrt(limits[0] * limits[1]), max(10 ** (decades / 2), 2 * math.sqrt(limits[1] / limits[0]))
        set_limits(middle / half, middle * half)


def draw_threads(plt, rows):
    """Columns: material and cut; from above small to large sheets."""
    sides = list(dict.fromkeys(row["side"] for row in rows))
    columns = [(material, cut) for material in page.MATERIALS for cut in sizes.CUTS]
    figure, all_axes = plt.subplots(len(sides) + 1, len(columns), figsize=(12, 2.1 * len(sides) + 0.8), layout="constrained",
                                    height_ratios=[0.3] + len(sides) * [1])
    for line, side in zip(all_axes[1:], sides):
        for axes, column in zip(line, columns):
            mine = [row for row in rows if (row["side"], (row["material"], row["cut"])) == (side, column)]
            if mine:
                draw_threads_panel(axes, mine)
            else:
                axes.axis("off")
        line[0].set_ylabel("largest error (mm)")
    for axes in all_axes[0]:
        axes.axis("off")  # room for the legend
    for i, column in enumerate(columns):
        last = max(sides.index(row["side"]) for row in rows if (row["material"], row["cut"]) == column)
        all_axes[1 + last][i].set_xlabel("wall s of a simulated s and sheet")
    different = {(row["scheme"], row["solver"]): row for row in rows}
    legend = [plt.Line2D([], [], label=page.scheme_in_threads(row), **look_in_threads(row)) for row in different.values()]
    legend += [plt.Line2D([], [], label=label, color="#555555", marker="o", markerfacecolor=face, linestyle="none")
               for label, face in (("one thread", None), ("two threads, a sheet each", "white"))]
    figure.legend(handles=legend, loc="upper center", ncols=3)
    save(plt, figure, "threads")


def draw_run_time(plt, curves, rows):
    """Error against run time of one curve of each study."""
    figure, axes = plt.subplots(figsize=(8.2, 4), layout="constrained")
    for i, curve in enumerate(curves):
        found = studies.points(rows, curve)
        axes.loglog([point[3] for point in found], [point[1] for point in found], color=COLOURS[i], marker=MARKERS[i],
                    label=curve["label"])
    axes.set_xlabel("CPU time (s)")
    label_errors(axes)
    axes.set_title("Error against run time", loc="left")
    legend_beside(axes)
    save(plt, figure, "run_time")


def main():
    import matplotlib  # the test of the page needs it not
    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update(SETTINGS)
    drawn = page.pictures()
    for study, rows in drawn["convergence"]:
        draw_convergence(plt, study, rows)
    for study, rows in drawn["profiles"]:
        draw_profile(plt, study, rows)
    for scene, rows in drawn["histories"]:
        draw_history(plt, scene, rows)
    for material, rows in drawn["time"]:
        draw_time(plt, material, rows, drawn["shown"])
    draw_work_precision(plt, studies.table(studies.TIME), drawn["shown"])
    for material, rows in drawn["size"]:
        draw_size(plt, material, rows, studies.studies()["ways"])
    for material, rows in drawn["solvers"]:
        draw_solvers(plt, material, rows, studies.studies()["ways"])
    draw_threads(plt, drawn["threads"])
    draw_run_time(plt, *drawn["run_time"])
    page.PAGE.write_text(page.text())


if __name__ == "__main__":
    main()
