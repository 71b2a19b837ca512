"""The studies that tests/accuracy/plots measures and draws: studies.json, the tables beside it, and their references."""

import csv
import hashlib
import json
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
REFERENCES = ROOT / "tests/data/reference"
SCENES = ROOT / "tests/data/scenes/reference"

CONVERGENCE = "convergence.csv"
PROFILES = "profiles.csv"
HISTORIES = "histories.csv"
TIME = "time.csv"
SIZE = "size.csv"
THREADS = "threads.csv"


def studies():
    return json.loads((HERE / "studies.json").read_text())


def expectation(scene):
    return json.loads((SCENES / f"{scene}.expect.json").read_text())


def name_of_check(check):
    """As expectation.cc has it."""
    return check["quantity"] + (f": {check['column']}" if "column" in check else "")


def quantity(scene, name):
    """Returns the quantity of the scene's reference that a check of this name is about."""
    wanted = expectation(scene)
    case = json.loads((REFERENCES / f"{wanted['reference']}.json").read_text())
    about = next(check["quantity"] for check in wanted["checks"] if name_of_check(check) == name)
    return next(each for each in case["quantities"] if each["name"] == about)


def table(name, folder=HERE):
    """Rows by column; numbers as such."""
    with open(folder / name, newline="") as file:
        return [{key: number(value) for key, value in row.items()} for row in csv.DictReader(file)]


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def points(rows, curve):
    """(edge length over the root of the area, |error|, vertices, CPU seconds) of a curve, coarsest first."""
    mine = [row for row in rows if row["curve"] == curve["label"]]
    return [(row["edge"], abs(row["error"]), int(row["vertices"]), row["cpu_s"])
            for row in sorted(mine, key=lambda row: row["fineness"])]


def observed_order(found, uncertainty):
    """Exponent of the edge length, by least squares of the logarithms, of the points above the uncertainty of what they
    are compared with; None where fewer than three are."""
    logs = [(math.log(point[0]), math.log(point[1])) for point in found if point[1] > uncertainty]
    if len(logs) < 3:
        return None
    mean_x, mean_y = (sum(log[k] for log in logs) / len(logs) for k in (0, 1))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)


def digest(description, rows):
    """Returns a hash of all that a picture is made of; it stands in the picture's metadata."""
    return hashlib.sha256(json.dumps([description, rows], sort_keys=True).encode()).hexdigest()[:16]
