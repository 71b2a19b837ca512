"""Curves to cut along, as kerf.v1.Curve: metres in material coordinates, or pixels of a picture for a cut with a view."""

from __future__ import annotations

import gzip
import math
import os
import pathlib
import re
import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, TypedDict, Union

from kerf.v1 import geometry_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

Point = Tuple[float, float]


def vec2(point: Point) -> geometry_pb2.Vec2:
    x, y = point
    return geometry_pb2.Vec2(x=float(x), y=float(y))


def rows_of(points: Sequence[Any], width: int) -> List[Any]:
    """Returns points that are given one by one, or as one array or list of them, as rows of numbers."""
    given = points[0] if len(points) == 1 else points
    try:
        rows = [tuple(float(number) for number in row) for row in given]
    except (TypeError, ValueError):
        rows = []
    if not rows or any(len(row) != width for row in rows):
        wanted = "x, y" if width == 2 else "x, y, weight"
        raise ValueError(f"points must be ({wanted}), one by one or as an array of shape (n, {width}), not {given!r:.200}")
    return rows


def is_point(points: Any) -> bool:
    """Returns True for two numbers: one point, not several."""
    return len(points) == 2 and not any(hasattr(number, "__len__") and getattr(number, "shape", None) != () for number in points)


def polyline(*points: Any) -> geometry_pb2.Curve:
    """Returns straight pieces; closed if the last point equals the first. 2..4096 points, one by one or as an array of
    shape (n, 2).

    >>> sheet.cut(polyline((-0.1, 0.3), (1.1, 0.35))).pieces
    2
    """
    return geometry_pb2.Curve(polyline=geometry_pb2.Polyline(points=[vec2(point) for point in rows_of(points, 2)]))


def bezier(*points: Any) -> geometry_pb2.Curve:
    """Returns n cubic Bezier pieces joined end to start, from 3 n + 1 points; n in 1..64. Points are given as for
    polyline().

    >>> sheet.cut(bezier((-0.1, 0.3), (0.3, 0.6), (0.7, 0.1), (1.1, 0.4))).pieces
    2
    """
    return geometry_pb2.Curve(bezier=geometry_pb2.CubicBezier(points=[vec2(point) for point in rows_of(points, 2)]))


def rational(*points: Any) -> geometry_pb2.Curve:
    """Returns a rational Bezier curve of three (quadratic) or four (cubic) points x, y, weight. Weights are in
    1e-6..1e6.

    >>> sheet.cut(rational((-0.1, 0.9, 1), (0.5, 0.5, 3), (1.1, 0.9, 1))).pieces
    2
    """
    rows = rows_of(points, 3)
    if len(rows) not in (3, 4):
        raise ValueError(f"a rational curve has 3 points or 4, not {len(rows)}")
    path = Path(rows[0][:2])
    weights = [float(weight) for _, _, weight in rows]
    if len(rows) == 3:
        path.quadratic(rows[1][:2], rows[2][:2], weights=weights)
    else:
        path.cubic(rows[1][:2], rows[2][:2], rows[3][:2], weights=weights)
    return path.curve()


def circle(center: Point, radius: float) -> geometry_pb2.Curve:
    """Returns a full circle: a punch.

    >>> sheet.cut(circle((0.5, 0.5), 0.2)).pieces
    2
    """
    return geometry_pb2.Curve(circle=geometry_pb2.Circle(center=vec2(center), radius_m=float(radius)))


def ellipse(center: Point, semi_axis_x: float, semi_axis_y: float, rotation_deg: float = 0.0) -> geometry_pb2.Curve:
    """Returns a full ellipse; the rotation is counter-clockwise.

    >>> sheet.cut(ellipse((0.5, 0.5), 0.3, 0.1, rotation_deg=30)).pieces
    2
    """
    return geometry_pb2.Curve(
        ellipse=geometry_pb2.Ellipse(
            center=vec2(center),
            semi_axis_x_m=float(semi_axis_x),
            semi_axis_y_m=float(semi_axis_y),
            rotation_rad=math.radians(rotation_deg),
        )
    )


class Reading(TypedDict, total=False):
    """Chooses what of a drawing is cut, and how large."""

    # cuts only shapes that one of these names: "stroke=red", "fill=#00f", "layer=NAME", ".CLASS" or "#ID"
    only: Union[str, Sequence[str]]
    all_shapes: bool  # True: also shapes that are hidden or paint nothing
    true_size: bool  # True: the drawing keeps its own size, and the lower left corner of its page lies at `at`
    at: Point  # metres; only with true_size; default (0, 0)
    fit_page: bool  # True: the page is fitted, rather than the outlines
    unit_m: float  # metres of a unit of the drawing's coordinates, instead of its own


def svg(drawing: "str | bytes", **reading: Unpack[Reading]) -> geometry_pb2.Curve:
    """Returns the outlines of an SVG drawing, given as text or as the bytes of a file. These may be in any encoding of
    XML, or compressed by gzip. Embedded pictures and fonts are left out. Without the option `fit` of the cut, and without
    true_size, the drawing is fitted into the sheet.

    >>> drawing = '<svg xmlns="http://www.w3.org/2000/svg"><circle r="40"/></svg>'
    >>> sheet.cut(svg(drawing), fit=(0.1, 0.1, 0.3, 0.3)).pieces
    2
    >>> sheet.cut(svg(drawing, true_size=True, at=(0.5, 0.5))).pieces
    3
    """
    message = geometry_pb2.Svg(reading=_reading_of(reading))
    if isinstance(drawing, str):
        message.text = without_embedded_data(drawing)
    else:
        fill_svg(message, drawing)
    return geometry_pb2.Curve(svg=message)


def dxf(drawing: bytes, **reading: Unpack[Reading]) -> geometry_pb2.Curve:
    """Returns the outlines of a DXF drawing, given as the bytes of its file, as svg() does."""
    # Compressed, the largest file fits into a request.
    is_large = len(drawing) > 512 << 10 and not drawing.startswith(b"\x1f\x8b")
    data = gzip.compress(drawing) if is_large else drawing
    return geometry_pb2.Curve(dxf=geometry_pb2.Dxf(data=data, reading=_reading_of(reading)))


def svg_file(path: "str | os.PathLike[str]", **reading: Unpack[Reading]) -> geometry_pb2.Curve:
    """Returns the outlines of a drawing in an SVG file of this machine, as svg() does. Raises OSError."""
    return svg(pathlib.Path(path).read_bytes(), **reading)


def dxf_file(path: "str | os.PathLike[str]", **reading: Unpack[Reading]) -> geometry_pb2.Curve:
    """Returns the outlines of a drawing in a DXF file of this machine, as dxf() does. Raises OSError."""
    return dxf(pathlib.Path(path).read_bytes(), **reading)


def _reading_of(options: Reading) -> Optional[geometry_pb2.DrawingReading]:
    if not options:
        return None
    fields: Dict[str, Any] = dict(options)
    unknown = fields.keys() - Reading.__annotations__.keys()
    if unknown:
        raise TypeError(f"a drawing has no option {min(unknown)!r}; there are {', '.join(Reading.__annotations__)}")
    if isinstance(fields.get("only"), str):
        fields["only"] = [fields["only"]]
    if "at" in fields:
        fields["at"] = vec2(fields["at"])
    return geometry_pb2.DrawingReading(**fields)


def fill_svg(message: geometry_pb2.Svg, content: bytes) -> None:
    """Sets the content of an SVG file: as text if it is UTF-8, else as it is."""
    if content.startswith(b"\x1f\x8b"):
        try:
            content = gzip.decompress(content)
        except (OSError, EOFError, zlib.error):
            pass  # The server says what is wrong with it.
    try:
        message.text = without_embedded_data(content.decode("utf-8-sig"))
    except UnicodeDecodeError:
        message.data = content


def without_embedded_data(text: str) -> str:
    """Empties data URIs, which hold pictures and fonts that are not cut."""
    return re.sub(r"""(["']\s*data:)[^"']*(?=["'])|(\(\s*data:)[^)]*(?=\))""", lambda uri: uri[1] or uri[2], text)


class Path:
    """Builds a curve of one or more lines, each of straight, Bezier and arc pieces. Each method returns the path, so
    that calls chain:

        kerf.Path((0.1, 0.1)).line((0.3, 0.1)).arc((0.3, 0.3), 0.1).close().move((0.6, 0.6)).line((0.8, 0.7)).curve()

    >>> half_disc = Path((0.4, 0.5)).line((0.6, 0.5)).arc((0.4, 0.5), 0.1).close()
    >>> sheet.cut(half_disc.curve()).pieces
    2
    """

    def __init__(self, start: Point) -> None:
        self._path = geometry_pb2.Path()
        self.move(start)

    def move(self, start: Point) -> Path:
        """Begins a line that is not joined to the one before."""
        self._path.subpaths.add(start=vec2(start))
        return self

    def line(self, *ends: Any) -> Path:
        """Adds straight pieces to each of the points in turn, given one by one or as an array of shape (n, 2)."""
        for end in rows_of(([ends[0]],) if len(ends) == 1 and is_point(ends[0]) else ends, 2):
            self._segments().add(line=vec2(end))
        return self

    def quadratic(self, control: Point, end: Point, *, weights: Sequence[float] = ()) -> Path:
        """Adds a quadratic Bezier piece. weights: those of start, control and end; none: all equal."""
        segment = geometry_pb2.Path.Quadratic(control=vec2(control), end=vec2(end), weights=weights)
        self._segments().add(quadratic=segment)
        return self

    def cubic(self, control_1: Point, control_2: Point, end: Point, *, weights: Sequence[float] = ()) -> Path:
        """Adds a cubic Bezier piece. weights: those of start, both controls and end; none: all equal."""
        segment = geometry_pb2.Path.Cubic(
            control_1=vec2(control_1), control_2=vec2(control_2), end=vec2(end), weights=weights
        )
        self._segments().add(cubic=segment)
        return self

    def arc(
        self,
        end: Point,
        semi_axis_x: float,
        semi_axis_y: Optional[float] = None,
        *,
        rotation_deg: float = 0.0,
        large: bool = False,
        counter_clockwise: bool = True,
    ) -> Path:
        """Adds an arc of an ellipse, or of a circle if there is one semi-axis. large: takes the longer way round."""
        segment = geometry_pb2.Path.Arc(
            semi_axis_x_m=float(semi_axis_x),
            semi_axis_y_m=float(semi_axis_x if semi_axis_y is None else semi_axis_y),
            rotation_rad=math.radians(rotation_deg),
            large=large,
            counter_clockwise=counter_clockwise,
            end=vec2(end),
        )
        self._segments().add(arc=segment)
        return self

    def close(self) -> Path:
        """Ends the line where it began."""
        self._path.subpaths[-1].closed = True
        return self

    def curve(self) -> geometry_pb2.Curve:
        """Returns all lines as one curve. At most 10000 segments."""
        return geometry_pb2.Curve(path=self._path)

    def _segments(self) -> Any:
        return self._path.subpaths[-1].segments
