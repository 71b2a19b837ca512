"""Random cuts, the same for the same seed, for the examples robot.py and dataset.py."""

from __future__ import annotations

import math
import random
from typing import List, Tuple

import kerf
from kerf.v1 import geometry_pb2, scene_pb2

KINDS = ("line", "wave", "circle", "ellipse", "crescent", "strip")


def random_cut(chance: random.Random) -> Tuple[str, scene_pb2.Cut]:
    """Returns one of KINDS and a random cut of this kind, for a sheet of 1 m x 1 m."""
    kind = chance.choice(KINDS)
    if kind == "line":
        start, end = _across(chance)
        return kind, kerf.cut(kerf.polyline(start, end))
    if kind == "wave":
        start, end = _across(chance)
        return kind, kerf.cut(kerf.bezier(start, _point(chance, 0), _point(chance, 0), end))
    if kind == "circle":
        return kind, kerf.cut(kerf.circle(_point(chance, 0.15), chance.uniform(0.03, 0.12)))
    if kind == "ellipse":
        longer, shorter = chance.uniform(0.08, 0.15), chance.uniform(0.03, 0.07)
        return kind, kerf.cut(kerf.ellipse(_point(chance, 0.2), longer, shorter, chance.uniform(0, 180)))
    if kind == "crescent":
        return kind, kerf.cut(_crescent(chance))
    x, y = _point(chance, 0.2)
    dx, dy = chance.uniform(-0.15, 0.15), chance.uniform(-0.15, 0.15)
    return kind, kerf.cut(kerf.polyline((x - dx, y - dy), (x + dx, y + dy)), width_m=chance.uniform(0.01, 0.03))


def _point(chance: random.Random, margin: float) -> Tuple[float, float]:
    return chance.uniform(margin, 1 - margin), chance.uniform(margin, 1 - margin)


def _across(chance: random.Random) -> List[Tuple[float, float]]:
    """Returns two points a little outside two different sides of the sheet."""
    ends = []
    for side in chance.sample(range(4), 2):
        along = chance.uniform(0.1, 0.9)
        ends.append([(along, -0.05), (1.05, along), (along, 1.05), (-0.05, along)][side])
    return ends


def _crescent(chance: random.Random) -> geometry_pb2.Curve:
    """Returns a closed curve of two arcs between the same ends, one flatter than the other."""
    (x, y), size, turn = _point(chance, 0.2), chance.uniform(0.05, 0.12), chance.uniform(0, 2 * math.pi)
    dx, dy = size * math.cos(turn), size * math.sin(turn)
    path = kerf.Path((x - dx, y - dy)).arc((x + dx, y + dy), size, counter_clockwise=False)
    return path.arc((x - dx, y - dy), 1.4 * size, counter_clockwise=True).close().curve()
