"""Pictures of sheets in notebooks, drawn from their arrays with NumPy alone."""

from __future__ import annotations

import base64
import html
import importlib
import struct
import zlib
from typing import TYPE_CHECKING, Any, Tuple

if TYPE_CHECKING:
    from kerf.arrays import Bytes, Floats, Ints

_SIZE_PX = (360, 270)
_MARGIN_PX = 10
_MOST_SAMPLES = 1_000_000
_BACKGROUND = (255, 255, 255)
_COLORS = ((78, 121, 167), (242, 142, 43), (89, 161, 79), (225, 87, 89), (118, 183, 178), (176, 122, 161), (237, 201, 72))


def _numpy() -> Any:
    return importlib.import_module("numpy")


class Pictured:
    """A sheet at a tick, with a short repr, and a picture of itself in notebooks."""

    tick: int
    topology_version: int
    positions: Floats
    triangles: Ints
    pieces: Ints

    def __repr__(self) -> str:
        return f"{type(self).__name__}(tick {self.tick}: {self._counts()})"

    def _repr_png_(self) -> bytes:
        return sheet_png(self.positions, self.triangles, self.pieces)

    def _repr_html_(self) -> str:
        return picture_html(self._repr_png_(), f"Tick {self.tick}: {self._counts()}")

    def _counts(self) -> str:
        num_pieces = len(_numpy().unique(self.pieces))
        pieces = f"{num_pieces} {'piece' if num_pieces == 1 else 'pieces'}"
        return f"{len(self.positions)} vertices, {len(self.triangles)} triangles, {pieces}"


def picture_html(png: bytes, caption: str) -> str:
    encoded = base64.b64encode(png).decode("ascii")
    return f'<figure><img src="data:image/png;base64,{encoded}"><figcaption>{html.escape(caption)}</figcaption></figure>'


def sheet_png(positions: Floats, triangles: Ints, pieces: Ints) -> bytes:
    """Returns a small picture as a PNG file: the sheet across its widest plane, z up, each piece in a colour of its own."""
    numpy = _numpy()
    width, height = _SIZE_PX
    pixels = numpy.full((height, width, 3), _BACKGROUND, dtype="u1")
    if len(triangles):
        corners = _on_screen(positions)[triangles]  # T x 3 x (x, y, depth), pixels
        colors = _shaded(corners, pieces)
        places, owners = _samples(corners)
        order = numpy.argsort(places[:, 2], kind="stable")  # the nearest is painted last
        column = numpy.clip(places[order, 0].astype("i4"), 0, width - 1)
        row = numpy.clip(places[order, 1].astype("i4"), 0, height - 1)
        pixels[row, column] = colors[owners[order]]
    return _png(pixels)


def _on_screen(positions: Floats) -> Any:
    """Projects positions to pixels across the plane in which the sheet is widest; the third number grows towards the
    viewer."""
    numpy = _numpy()
    centred = positions - positions.mean(axis=0)
    toward = numpy.linalg.eigh(centred.T @ centred)[1][:, 0]
    toward = toward if toward[1] < 0 or (toward[1] == 0 and toward[2] > 0) else -toward
    up = numpy.array([0.0, 0.0, 1.0]) if abs(toward[2]) < 0.8 else numpy.array([0.0, 1.0, 0.0])
    right = numpy.cross(up, toward)
    right /= numpy.linalg.norm(right)
    up = numpy.cross(toward, right)
    flat = centred @ numpy.stack([right, -up, toward], axis=1)
    low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
    room = numpy.array(_SIZE_PX) - 2 * _MARGIN_PX
    scale = (room / numpy.maximum(high - low, 1e-9 * max(1.0, float(abs(flat).max())))).min()
    flat[:, :2] -= (low + high) / 2
    flat *= scale
    flat[:, :2] += numpy.array(_SIZE_PX) / 2
    return flat


def _shaded(corners: Any, pieces: Ints) -> Bytes:
    """Returns a colour for each triangle: that of its piece, darker where it is seen from the side."""
    numpy = _numpy()
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = numpy.maximum(numpy.linalg.norm(normals, axis=1), 1e-30)
    light = 0.45 + 0.55 * abs(normals[:, 2]) / lengths
    colors = numpy.array(_COLORS)[numpy.asarray(pieces) % len(_COLORS)]
    return (colors * light[:, None]).astype("u1")


def _samples(corners: Any) -> Tuple[Any, Any]:
    """Returns points that cover the triangles pixel by pixel, and the triangle of each."""
    numpy = _numpy()
    edges = abs(corners - numpy.roll(corners, 1, axis=1))[:, :, :2].max(axis=(1, 2))
    most = int((2 * _MOST_SAMPLES / len(corners)) ** 0.5) + 2
    parts = int(numpy.clip(1.5 * edges.max() + 2, 2, most))
    i, j = numpy.meshgrid(numpy.arange(parts), numpy.arange(parts))
    inside = i + j < parts
    a, b = i[inside] / (parts - 1), j[inside] / (parts - 1)
    weights = numpy.stack([1 - a - b, a, b], axis=1)
    places = numpy.einsum("sk,tkd->tsd", weights, corners).reshape(-1, 3)
    return places, numpy.repeat(numpy.arange(len(corners)), len(weights))


def _png(pixels: Bytes) -> bytes:
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
