"""Draws the figures of the evaluation as small PNGs beside this script, from rows of results.json."""

import hashlib
import io
import json
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
COLOURS = {"no optimisation": "#cc79a7", "thesis": "#d55e00", "default": "#0072b2"}
LABELS = {"no optimisation": "thesis, without bisection", "thesis": "thesis's method", "default": "Kerf"}
SETTINGS = {"font.size": 9.5, "axes.grid": True, "grid.color": "#e4e4e4", "grid.linewidth": 0.7, "axes.spines.top": False,
            "axes.spines.right": False, "lines.linewidth": 1.4, "lines.markersize": 4, "legend.frameon": False}


def digest(rows):
    return hashlib.sha256(json.dumps(rows, sort_keys=True).encode()).hexdigest()[:16]


def save(figure, name, rows):
    """Keeps 64 colours, which makes a picture some three times smaller, and says which rows it is made of."""
    import PIL.Image
    import PIL.PngImagePlugin
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=90, bbox_inches="tight")
    picture = PIL.Image.open(drawn).convert("RGB").quantize(64, dither=PIL.Image.Dither.NONE)
    said = PIL.PngImagePlugin.PngInfo()
    said.add_text("Description", f"made of {digest(rows)}")
    picture.save(HERE / f"{name}.png", optimize=True, pnginfo=said)


def stale(name, rows):
    """The picture's file, if it is not made of these rows."""
    return [] if f"made of {digest(rows)}".encode() in (HERE / f"{name}.png").read_bytes() else [f"{name}.png"]


def levels(plt, rows):
    """Figures 5.2 to 5.5."""
    rows = sorted(rows, key=lambda row: row["run"])
    runs = [row["run"] for row in rows]
    figure, axes = plt.subplots(2, 2, figsize=(8.4, 5.4), layout="constrained", sharex=True)
    for panel, title, pick in (
            (axes[0][0], "mean longest / shortest edge of new triangles", lambda row: row["new_shapes"]["edge_ratio"]["mean"]),
            (axes[0][1], "new triangles", lambda row: row["new"]),
            (axes[1][0], "condition number of A, uncut 10", lambda row: row["condition"]["a10"])):
        panel.plot(runs, [pick(row["before"]) for row in rows], "o-", color=COLOURS["no optimisation"],
                   label=LABELS["no optimisation"])
        panel.plot(runs, [pick(row) for row in rows], "s-", color=COLOURS["thesis"], label=LABELS["thesis"])
        panel.set_title(title)
    for panel in (axes[0][1], axes[1][0]):
        panel.set_yscale("log")
    axes[0][0].legend()
    axes[0][0].set_xticks(range(2, 21, 2))
    axes[1][1].plot(runs, [100 * row["new_shapes"]["area_ratio"]["mean"] for row in rows], "s-", color=COLOURS["thesis"])
    axes[1][1].set_title("mean area of new triangles, % of an uncut one")
    for panel in axes[1]:
        panel.set_xlabel("run; the limit falls from 12 to 1.5")
    save(figure, "levels", rows)


def sizes(plt, rows):
    """Figures 5.7 and 5.8."""
    figure, axes = plt.subplots(2, 3, figsize=(9.2, 5.4), layout="constrained")
    for column, family in enumerate(("single", "intersecting", "multiple")):
        for way, colour in COLOURS.items():
            some = sorted((row for row in rows if row["family"] == family and row["way"] == way), key=lambda row: row["size"])
            crossed = [row["crossed"] for row in some]
            axes[0][column].plot(crossed, [row["new"] for row in some], "o-", color=colour, label=LABELS[way])
            axes[1][column].plot(crossed, [row["new_shapes"]["edge_ratio"]["mean"] for row in some], "o-", color=colour)
        axes[0][column].set_title(f"{family}: new triangles")
        axes[1][column].set_title("mean longest / shortest edge")
        axes[1][column].set_yscale("log")
        axes[1][column].set_yticks([1.5, 2, 3, 5, 10, 20], ["1.5", "2", "3", "5", "10", "20"])
        axes[1][column].minorticks_off()
        axes[1][column].set_xlabel("triangles crossed")
    axes[0][0].legend()
    save(figure, "sizes", rows)


def detailed(plt, rows):
    """Figures 5.11 and 5.12."""
    figure, axes = plt.subplots(2, 3, figsize=(9.2, 5.2), layout="constrained")
    for column, group in enumerate(("single", "intersecting", "punch")):
        for way in ("thesis", "default"):
            some = sorted((row for row in rows if row["group"] == group and row["way"] == way), key=lambda row: row["number"])
            numbers = [row["number"] for row in some]
            axes[0][column].plot(numbers, [row["vertices"] - 225 for row in some], "o-", color=COLOURS[way], label=LABELS[way])
            if all("ticks" in row for row in some):
                axes[1][column].plot(numbers, [1e3 / row["ticks"]["during_ms"] for row in some], "o-", color=COLOURS[way])
        axes[0][column].set_title(f"{group}: new vertices")
        axes[1][column].set_title("ticks a second, with the cut")
        axes[1][column].set_yscale("log")
        axes[1][column].axhline(30, color="#999999", linewidth=0.9)
        axes[1][column].set_xlabel("pattern")
    axes[0][2].legend(loc="upper left")
    save(figure, "detailed", rows)


def kirigami(plt, rows):
    """Figures 5.17 to 5.20."""
    if not all("ticks" in row for row in rows):
        return
    figure, axes = plt.subplots(1, 3, figsize=(9.6, 3.0), layout="constrained")
    for way in ("thesis", "default"):
        some = sorted((row for row in rows if row["way"] == way), key=lambda row: row["number"])
        numbers = [row["number"] for row in some]
        axes[0].plot(numbers, [row["dimension"] for row in some], "o-", color=COLOURS[way], label=LABELS[way])
        axes[1].plot(numbers, [1e3 / row["ticks"]["during_ms"] for row in some], "o-", color=COLOURS[way])
        axes[2].plot(numbers, [1e3 / row["ticks"]["after_ms"] for row in some], "o-", color=COLOURS[way])
    for panel, title in zip(axes, ("rows of the matrix", "ticks a second, with the slit", "ticks a second, after it")):
        panel.set_title(title)
        panel.set_xlabel("slit")
    for panel in axes[1:]:
        panel.set_yscale("log")
        panel.axhline(30, color="#999999", linewidth=0.9)
    axes[0].legend()
    save(figure, "kirigami", rows)


def lips(plt, rows):
    """Figure 5.6."""
    from matplotlib.collections import LineCollection, PolyCollection
    figure, axes = plt.subplots(1, 3, figsize=(9.2, 2.4), layout="constrained")
    for panel, row in zip(axes, rows):
        panel.add_collection(PolyCollection([list(zip(each[::2], each[1::2])) for each in row["triangles"]], facecolors="#f2f2f2",
                                            edgecolors="#8a8a8a", linewidths=0.4))
        panel.add_collection(LineCollection([[each[:2], each[2:]] for each in row["lips"]], colors=COLOURS[row["way"]], linewidths=1.0))
        panel.set_title(LABELS[row["way"]])
        panel.set_aspect("equal")
        panel.autoscale_view()
        panel.axis("off")
    save(figure, "lips", rows)


def curves(plt, rows):
    """Figure 5.9."""
    figure, axes = plt.subplots(3, 4, figsize=(6.4, 4.9), layout="constrained")
    for panel, row in zip(axes.flat, rows):
        for curve in row["curves"]:
            panel.plot([x for x, _ in curve], [y for _, y in curve], color=COLOURS["default"])
        panel.set(xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[], aspect="equal")
        panel.set_title(f"{row['family']}, size {row['size']}", fontsize=8.5)
        for side in ("top", "right"):
            panel.spines[side].set_visible(True)
    save(figure, "curves", rows)


PICTURES = (levels, sizes, detailed, kirigami, lips, curves)


def rows_of(part, rows):
    return [row for row in rows if row["experiment"] == part.__name__]


def all_stale(rows):
    return [file for part in PICTURES for file in stale(part.__name__, rows_of(part, rows))]


def draw_all(rows):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    with plt.rc_context(SETTINGS):
        for part in PICTURES:
            if some := rows_of(part, rows):
                part(plt, some)
    plt.close("all")
