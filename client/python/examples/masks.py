"""Computes which piece each pixel of a picture shows, by drawing the triangles of a sheet with NumPy."""

from __future__ import annotations

import math
from typing import Any, Tuple

import kerf
import numpy

Vector = Tuple[float, float, float]


def piece_mask(state: kerf.State, eye: Vector, target: Vector, fov_deg: float, size_px: Tuple[int, int]) -> Any:
    """Returns height x width uint8: 0 where the picture shows no sheet, else 1 + the place of the piece among the
    sorted labels, at most 255. The camera is as in Sheet.render(), with up along +z; colliders hide nothing."""
    corners = _to_pixels(state.positions, eye, target, fov_deg, size_px)[state.triangles]
    numbers = numpy.minimum(1 + numpy.searchsorted(numpy.unique(state.pieces), state.pieces), 255)
    mask = numpy.zeros(size_px[::-1], dtype="u1")
    nearest = numpy.zeros(size_px[::-1])  # 1 / distance, which is linear in the picture
    for triangle, number in zip(corners, numbers):
        _draw(triangle, number, mask, nearest)
    return mask


def _to_pixels(points: Any, eye: Vector, target: Vector, fov_deg: float, size_px: Tuple[int, int]) -> Any:
    """Projects N x 3 points of the world, metres. Returns N x 3: x and y in pixels, y down, and 1 / distance along the
    view."""
    forward = numpy.subtract(target, eye)
    forward = forward / numpy.linalg.norm(forward)
    right = numpy.cross(forward, (0, 0, 1))
    right = right / numpy.linalg.norm(right)
    axes = numpy.stack([right, numpy.cross(right, forward), forward], axis=1)
    x, y, depth = ((points - numpy.array(eye)) @ axes).T
    focal = size_px[1] / 2 / math.tan(math.radians(fov_deg) / 2)
    return numpy.stack([size_px[0] / 2 + focal * x / depth, size_px[1] / 2 - focal * y / depth, 1 / depth], axis=1)


def _draw(triangle: Any, number: int, mask: Any, nearest: Any) -> None:
    """Writes `number` into the pixels whose centres are inside the triangle, where it is nearer than what was drawn
    before."""
    low = numpy.maximum(numpy.floor(triangle[:, :2].min(axis=0)), 0).astype(int)
    high = numpy.minimum(numpy.ceil(triangle[:, :2].max(axis=0)), mask.shape[::-1]).astype(int)
    (ax, ay, a), (bx, by, b), (cx, cy, c) = triangle.tolist()
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if (high <= low).any() or area == 0:
        return
    y, x = numpy.mgrid[low[1] : high[1], low[0] : high[0]] + 0.5
    of_b = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
    of_c = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
    near = a + of_b * (b - a) + of_c * (c - a)
    window = numpy.s_[low[1] : high[1], low[0] : high[0]]
    drawn = (of_b >= 0) & (of_c >= 0) & (of_b + of_c <= 1) & (near > nearest[window])
    mask[window][drawn] = number
    nearest[window][drawn] = near[drawn]
