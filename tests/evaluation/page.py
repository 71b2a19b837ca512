"""Writes the tables of the evaluation's pages, between lines `<!-- table NAME -->` and `<!-- end -->`."""

import pathlib
import re
import statistics

import published

HERE = pathlib.Path(__file__).resolve().parent
WAYS = (("no optimisation", "without bisection"), ("thesis", "thesis's method"), ("default", "Kerf"))


def number(value, digits=3):
    if value < 1:
        return f"{value:.{digits}g}"
    if value >= 1e5:
        mantissa, exponent = f"{value:.{digits - 2}e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{float(f'{value:.{digits}g}'):,.{max(0, digits - 1 - max(0, len(str(int(value))) - 1)) if value < 100 else 0}f}"


def spread(values):
    mean = statistics.fmean(values)
    return f"{number(mean)} ± {number(statistics.pstdev(values), 2)}" if len(values) > 1 else number(mean)


def median_and_worst(values):
    return f"{number(statistics.median(values))} ({number(max(values))})"


def table(header, lines):
    return "\n".join(["| " + " | ".join(header) + " |", "|" + "---|" * len(header)] +
                     ["| " + " | ".join(line) + " |" for line in lines])


def times_of(rows, pick):
    values = [pick(row) for row in rows if "ticks" in row]
    return number(statistics.fmean(values)) if values else "-"


def patterns(rows):
    """Tables 5.1 and 5.2."""
    lines = []
    for pattern, printed in published.PATTERNS.items():
        lines.append([f"**({pattern})** printed", "{} ± {}".format(*printed["crossed"]), "-",
                      "{} ± {}".format(*printed["edge_ratio"]), "-", "{} ± {}".format(*printed["area_ratio"]),
                      number(printed["condition"][0]), str(printed["cg_ms"]), "-", str(printed["fps_during"])])
        for way, name in WAYS:
            some = [row for row in rows if row["experiment"] == "patterns" and row.get("pattern") == pattern and row["way"] == way]
            solved = [row["solve"] for row in some if "solve" in row]
            lines.append([name, spread([row["crossed"] for row in some]), spread([row["new"] for row in some]),
                          "{} ± {}".format(number(statistics.fmean(row["new_shapes"]["edge_ratio"]["mean"] for row in some)),
                                           number(statistics.fmean(row["new_shapes"]["edge_ratio"]["deviation"] for row in some))),
                          number(max(row["new_shapes"]["edge_ratio"]["worst"] for row in some)),
                          "{} ± {}".format(number(statistics.fmean(row["new_shapes"]["area_ratio"]["mean"] for row in some)),
                                           number(statistics.fmean(row["new_shapes"]["area_ratio"]["deviation"] for row in some))),
                          median_and_worst([row["condition"]["a10"] for row in some]),
                          number(statistics.fmean(solve["ms"] for solve in solved)) if solved else "-",
                          number(statistics.fmean(solve["residual"] for solve in solved), 2) if solved else "-",
                          times_of(some, lambda row: 1e3 / row["ticks"]["during_ms"])])
    return table(["pattern", "crossed", "new", "edge ratio", "worst", "area ratio", "condition", "CG, ms", "its residual",
                  "ticks/s, during"], lines)


def other_conditions(rows):
    lines = []
    for pattern in published.PATTERNS:
        for way, name in WAYS:
            some = [row for row in rows if row["experiment"] == "patterns" and row.get("pattern") == pattern and row["way"] == way]
            lines.append([f"({pattern}) {name}"] + [median_and_worst([row["condition"][key] for row in some])
                                                  for key in ("a10", "a", "scaled", "shape")] +
                         [number(statistics.fmean(row["new_shapes"]["aspect"]["mean"] for row in some)),
                          number(min(row["new_shapes"]["angle_deg"]["worst"] for row in some)),
                          f"{100 * statistics.fmean(row['new_shapes']['slivers'] for row in some):.1f} %"])
    return table(["pattern", "A, uncut 10", "A, 1/60 s", "A scaled", "shape", "longest edge / height", "least angle",
                  "below 3 % of the area"], lines)


def detailed(rows):
    """Table 5.3."""
    lines = []
    for group, printed in published.DETAILED.items():
        for who, vertices in (("manteaux", "drawn"), ("thesis", "vertices")):
            fps = printed[who]["fps"]
            lines.append([f"**{group}** " + {"manteaux": "Manteaux et al., printed", "thesis": "thesis, printed"}[who],
                          "{:,} to {:,}".format(*printed[who][vertices]) + (" drawn" if vertices == "drawn" else ""),
                          *(f"{each:g}" for each in fps), number(fps[1] / fps[0], 2)])
        for way, name in WAYS[1:]:
            some = [row for row in rows if row["experiment"] == "detailed" and row["group"] == group and row["way"] == way]
            lines.append([name, "225 to " + number(statistics.fmean(row["vertices"] for row in some))] + ticks([row["ticks"] for row in some if "ticks" in row]))
            drawn = [row for row in some if "ticks_as_drawn" in row]
            if drawn:
                lines.append([f"{name}, as many vertices as they draw", f"{drawn[0]['drawn_side'] ** 2:,} at first"] +
                             ticks([row["ticks_as_drawn"] for row in drawn]))
    return table(["cuts", "vertices", "before", "during", "after", "during / before"], lines)


def ticks(measured):
    """Ticks a second, means of the patterns."""
    if not measured:
        return ["-"] * 4
    rates = [statistics.fmean(1e3 / each[key] for each in measured) for key in ("before_ms", "during_ms", "after_ms")]
    lowest = min(each["before_ms"] / each["during_ms"] for each in measured)
    return [number(rate) for rate in rates] + [f"{number(rates[1] / rates[0], 2)}, lowest {number(lowest, 2)}"]


def roots(rows):
    """Table 5.4."""
    lines = []
    for solver, printed in published.ROOTS.items():
        both = [printed[key] if isinstance(printed[key], str) else " to ".join(number(each) for each in printed[key])
                for key in ("condition", "cg_ms")]
        lines.append([f"{solver}, printed", "6,400", both[0], both[1], "-", "-", "-"])
    rows = [row for row in rows if row["experiment"] == "roots"]
    for way, name in WAYS[1:]:
        some = [row for row in rows if row["side"] == 80 and row["way"] == way]
        solved = [row["solve"] for row in some if "solve" in row]
        lines.append([f"cg, cut by {name}", "6,400", median_and_worst([row["condition"]["a10"] for row in some])] + solves(solved))
    small = [row for row in rows if row["side"] != 80]
    for solver in [each["solver"] for each in small[0]["solves"]]:
        some = [each for row in small for each in row["solves"] if each["solver"] == solver]
        condition = median_and_worst([row["condition"]["a10"] for row in small])
        is_same = not solver.startswith(("es-cgm", "as-cgm"))
        lines.append([f"{solver}, cut by thesis's method", number(small[0]["side"] ** 2), condition if is_same else "another matrix"] + solves(some))
    return table(["solver", "vertices at first", "condition", "ms", "iterations", "residual", "error of x"], lines)


def solves(some):
    if not some:
        return ["-"] * 4
    return [number(statistics.fmean(each["ms"] for each in some)), f"{statistics.fmean(each['iterations'] for each in some):,.0f}",
            *(f"{statistics.fmean(each[key] for each in some):.1e}" for key in ("residual", "error"))]


def kirigami(rows):
    """Figure 5.20: shares of the tick with a slit."""
    lines = []
    for way, name in WAYS[1:]:
        some = [row for row in rows if row["experiment"] == "kirigami" and row["way"] == way]
        timed = [row["ticks"] for row in some if "ticks" in row]
        if not timed:
            continue
        whole = statistics.fmean(each["during_ms"] for each in timed)
        shares = [f"{100 * statistics.fmean(each['stages_ms'][stage] for each in timed) / whole:.1f} %" for stage in ("cut", "update", "step")]
        lines.append([name, f"{some[0]['dimension']:,} to {some[-1]['dimension']:,}", *shares,
                      number(statistics.fmean(1e3 / each["during_ms"] for each in timed)),
                      number(min(1e3 / each["during_ms"] for each in timed)),
                      number(statistics.fmean(1e3 / each["after_ms"] for each in timed)),
                      str(sum(each["unconverged_ticks"] for each in timed))])
    low, high = published.KIRIGAMI["dimension"]
    lines.insert(0, ["thesis, printed", f"{low:,} to {high:,}", "-", "-", "-", "-", "above 20 up to the 6th cut", "30.9; AS-CGM 41.2", "-"])
    return table(["way", "rows of the matrix", "cut", "update", "step", "ticks/s, during", "lowest", "after", "solves not converged"], lines)


TABLES = {each.__name__: each for each in (patterns, other_conditions, detailed, roots, kirigami)}


def texts(rows):
    """Each page, and what it holds with tables of these rows."""
    for path in sorted(HERE.glob("*.md")):
        yield path, re.sub(r"(<!-- table (\w+) -->\n).*?(<!-- end -->)",
                           lambda match: match[1] + TABLES[match[2]](rows) + "\n" + match[3] if match[2] in TABLES else match[0],
                           path.read_text(), flags=re.S)


def stale(rows):
    """Names of the pages that write_all() would change."""
    return [path.name for path, text in texts(rows) if text != path.read_text()]


def write_all(rows):
    for path, text in texts(rows):
        path.write_text(text)
