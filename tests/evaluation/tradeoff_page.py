"""Draws run time against error, and writes the tables of tradeoff.md, from rows of tradeoff.json."""

import pathlib
import re

import draw
import page

PAGE = pathlib.Path(__file__).resolve().parent / "tradeoff.md"
LOOKS = {"Kerf as it comes": ("#0072b2", "*"), "Kerf, explicit": ("#0072b2", "o"), "Kerf, TR-BDF2": ("#56b4e9", "s"), "Kerf, implicit Euler": ("#7a5c00", "v"),
         "thesis": ("#d55e00", "D"), "Bullet soft body": ("#009e73", "^"), "Bullet deformable": ("#cc79a7", "P"),
         "Rapier soft body": ("#000000", "X")}
FAMILIES = ["Kerf", *LOOKS]
PANELS = [("swing-soft", 50, 0, "soft cloth, 2,500 vertices"), ("swing-soft", 50, 10, "the same after 10 random cuts"),
          ("swing-wool", 50, 0, "wool, 2,500 vertices")]
NAMES = {"swing-soft": "swing, soft", "swing-wool": "swing, wool", "swing-paper": "swing, paper", "drape": "drape on a ball"}


def is_of(row, panel):
    return (row["scene"], row.get("side"), row.get("cuts")) == panel[:3]


def panel(axes, rows, title):
    for family, (colour, marker) in LOOKS.items():
        some = [row for row in rows if row["family"] == family and row.get("rms_mm")]
        if some:
            star = {"markersize": 17, "markeredgecolor": "white", "zorder": 3} if marker == "*" else {}
            axes.plot([row["cpu_s_per_s"] for row in some], [row["rms_mm"] for row in some], marker, color=colour, label=family, **star)
    axes.axvline(1.0, color="#999999", linewidth=0.9)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(title)
    axes.set_xlabel("CPU seconds for a second of motion")


def plot(rows):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    with plt.rc_context({**draw.SETTINGS, "lines.markersize": 6}):
        figure, axes = plt.subplots(1, 3, figsize=(10.2, 3.8), layout="constrained", sharey=True)
        for each, shown in zip(axes, PANELS):
            panel(each, [row for row in rows if is_of(row, shown)], shown[3])
        axes[0].set_ylabel("error of positions, mm")
        axes[0].annotate("real time", (1.0, 0.02), xycoords=("data", "axes fraction"), rotation=90, fontsize=8, color="#777777",
                         ha="right", va="bottom")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=4)
        draw.save(figure, "tradeoff", drawn(rows))
    plt.close("all")


def motion(rows):
    """The default, the best and the cheapest of each family, scene by scene."""
    lines = []
    keys = list(dict.fromkeys((row["scene"], row["side"], row["cuts"]) for row in rows if row.get("side")))
    for scene, side, cuts in keys:
        some = [row for row in rows if (row["scene"], row.get("side"), row.get("cuts")) == (scene, side, cuts)]
        default = next(row for row in some if row["default"])
        line = [NAMES[scene], f"{side} x {side}", str(cuts) if cuts else "-", pair(default)]
        for families in (("Kerf, explicit",), ("Kerf, TR-BDF2", "Kerf, implicit Euler"), ("thesis",),
                         ("Bullet soft body", "Bullet deformable"), ("Rapier soft body",)):
            found = [row for row in some if row["family"] in families and "rms_mm" in row]
            line.append(pair(min(found, key=lambda row: row["rms_mm"])) if found else "-")
        lines.append(line)
    return page.table(["scene", "vertices", "cuts", "Kerf as it comes", "explicit, best", "implicit, best", "thesis's method, best", "Bullet, best",
                       "Rapier, best"], lines)


def pair(row):
    return f"{page.number(row['cpu_s_per_s'], 2)} s, {page.number(row['rms_mm'], 2)} mm"


def cut(rows):
    names = {"Kerf": "Kerf as it comes", "thesis": "thesis's method", "Rapier soft body": "Rapier"}
    lines = [[names[row["family"]], page.number(row["new_vertices"], 2), page.number(row["cut_ms"], 2),
              *(f"{page.number(row[key], 2)} mm" for key in ("curve_mean_mm", "curve_largest_mm", "lips_largest_mm"))]
             for row in rows if row["scene"] == "cut"]
    return page.table(["program", "new vertices", "CPU, ms", "curve to cut, mean", "curve to cut, farthest", "cut to curve, farthest"],
                      lines)


def static(rows):
    lines = []
    for row in rows:
        if row["scene"] not in ("slit", "flap", "kirigami"):
            continue
        name = f"{row['scene']}, {row['family']}" + (" as it comes" if row["default"] else "")
        lines.append([name, row["setting"], f"{row['vertices']:,}", page.number(row["cpu_s"], 2), f"{row['error_percent']:.2g} %"]
                     if "cpu_s" in row else [name, row["setting"], "-", "-", row["failed"]])
    return page.table(["scene", "size", "vertices", "CPU, s", "worst error"], lines)


def crumple(rows):
    lines = [[row["family"] + ", " + row["setting"], f"{row['pairs']:,}", page.number(row["cpu_s_per_s"], 2)]
             for row in rows if row["scene"] == "crumple"]
    return page.table(["program", "pairs that pass through each other", "CPU seconds for a second"], lines)


def text(rows):
    tables = {"motion": motion, "cut": cut, "static": static, "crumple": crumple}
    return re.sub(r"(<!-- table (\w+) -->\n).*?(<!-- end -->)", lambda match: match[1] + tables[match[2]](rows) + "\n" + match[3],
                  PAGE.read_text(), flags=re.S)


def drawn(rows):
    """Rows that the picture shows."""
    return [row for row in rows if row.get("rms_mm") and any(is_of(row, panel) for panel in PANELS)]


def stale(rows):
    """Names of the files that write() would change."""
    return ([PAGE.name] if text(rows) != PAGE.read_text() else []) + draw.stale("tradeoff", drawn(rows))


def write(rows):
    plot(rows)
    PAGE.write_text(text(rows))
