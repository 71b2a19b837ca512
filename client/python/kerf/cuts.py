"""Cuts: a curve and how it is to be cut, as kerf.v1.Cut; and lists of them in files."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Dict, List, Literal, Optional, Tuple, TypedDict, Union

from google.protobuf import json_format

from kerf.curves import vec2
from kerf.v1 import conditions_pb2, cuts_pb2, geometry_pb2, scene_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Outcomes of a cut: CutResult.status.
APPLIED = cuts_pb2.CutResult.APPLIED
NO_INTERSECTION = cuts_pb2.CutResult.NO_INTERSECTION  # misses the sheet; nothing changed
SCHEDULED = cuts_pb2.CutResult.SCHEDULED  # waits for its tick

Vector = Tuple[float, float, float]
Fit = Union[Literal["sheet"], Tuple[float, float, float, float]]


class CutOptions(TypedDict, total=False):
    """Holds the options of a cut besides its curve; those left out have their defaults. Ranges: proto/kerf/v1/scene.proto."""

    tolerance: float  # largest distance of the curve to the lips, as a share of the edge length there
    tolerance_m: float  # replaces `tolerance`, metres
    min_angle_deg: float  # smallest angle wanted in new triangles
    max_new_triangles: int
    method: Literal["neighbourhood", "element"]
    quality: Literal["default", "fine"]
    tip_edge_length_m: float  # edge length wanted at the tips: the cut's ends inside the sheet
    tip_grading: float  # growth of edges with each ring of triangles around a tip
    relax: bool  # False: no old vertex moves in material space
    fit: Fit  # box into which the curve is scaled and moved: low x, low y, high x, high y; or "sheet"
    dash: Sequence[float]  # lengths cut and left in turn, metres
    dash_offset: float
    width_m: float  # width of the strip removed around the curve; result.removed describes what was removed
    view: scene_pb2.View  # picture of the sheet in whose pixels the curve is
    component: str  # name of the component in whose coordinates the curve is; it alone is cut
    join_m: float  # ends of lines closer than this to another line, a lip or the border are joined to it


def cut(curve: geometry_pb2.Curve, **options: Unpack[CutOptions]) -> scene_pb2.Cut:
    """Returns a cut to be made later, for example as one of a batch.

    >>> fine = cut(kerf.circle((0.5, 0.5), 0.1), tolerance=0.01)
    >>> sheet.cut_all([fine, kerf.circle((0.2, 0.2), 0.1)]).pieces
    3
    """
    fields: Dict[str, Any] = dict(options)
    unknown = fields.keys() - CutOptions.__annotations__.keys()
    if unknown:
        raise TypeError(f"a cut has no option {min(unknown)!r}; there are {', '.join(CutOptions.__annotations__)}")
    if "method" in fields:
        fields["method"] = enum_value(scene_pb2.Cut.Method, "method", fields["method"])
    if "quality" in fields:
        fields["quality"] = enum_value(scene_pb2.Cut.Quality, "quality", fields["quality"])
    if "relax" in fields:
        fields["relax"] = bool(fields["relax"])
    if "fit" in fields:
        fields["fit"] = _as_box(fields["fit"])
    return scene_pb2.Cut(curve=curve, **fields)


def vec3(vector: Vector) -> geometry_pb2.Vec3:
    x, y, z = vector
    return geometry_pb2.Vec3(x=float(x), y=float(y), z=float(z))


def camera(
    eye: Vector, target: Vector, up: Optional[Vector] = None, *, vertical_fov_deg: float = 0.0
) -> geometry_pb2.Camera:
    """Returns a perspective camera in the world, metres. up: absent: +z. vertical_fov_deg: 0: 40 degrees.

    >>> camera((0.5, -2, 0.5), (0.5, 0, 0.5)).eye.y
    -2.0
    """
    return geometry_pb2.Camera(
        eye=vec3(eye),
        target=vec3(target),
        up=None if up is None else vec3(up),
        vertical_fov_deg=vertical_fov_deg,
    )


def view(
    camera: geometry_pb2.Camera,
    size_px: Tuple[float, float] = (640, 360),
    *,
    layers: str = "nearest",
    piece: Optional[int] = None,
    depth_m: Tuple[float, float] = (0.0, 0.0),
) -> scene_pb2.View:
    """Returns a view for cutting on a picture, as Sheet.render() draws it with the same camera and size. Pixel (0, 0)
    is its top left corner.

    layers: "nearest", "all", "one_piece" (the piece with the label `piece`; without it, the piece seen where the
    curve first meets the sheet) or "depth_range" (between the two distances `depth_m` from the camera).

    >>> through = view(camera((0.5, -2, 0.5), (0.5, 0, 0.5)), (640, 640), layers="all")
    >>> sheet.cut(kerf.polyline((0, 320), (640, 320)), view=through).pieces
    2
    """
    return _with_layers(scene_pb2.View(camera=camera), size_px, layers, piece, depth_m)


def view_of_matrices(
    view: Sequence[Any],
    projection: Sequence[Any],
    size_px: Tuple[float, float],
    *,
    layers: str = "nearest",
    piece: Optional[int] = None,
    depth_m: Tuple[float, float] = (0.0, 0.0),
) -> scene_pb2.View:
    """Returns a view as view() does, from two 4 x 4 matrices: 16 numbers each, column by column as in OpenGL and WebGL,
    or arrays of shape (4, 4) that multiply columns."""
    made = scene_pb2.View(view=_by_columns(view), projection=_by_columns(projection))
    return _with_layers(made, size_px, layers, piece, depth_m)


def save_cuts(path: "str | os.PathLike[str]", cuts: Iterable[scene_pb2.Cut]) -> None:
    """Writes cuts as JSON, as `kerf cuts --export` does.

    >>> save_cuts(path, [cut(kerf.circle((0.5, 0.5), 0.1))])
    >>> sheet.apply_cuts(path).applied
    1
    """
    text = json_format.MessageToJson(scene_pb2.CutBatch(cuts=cuts), preserving_proto_field_name=True)
    pathlib.Path(path).write_text(text + "\n", encoding="utf-8")


def load_cuts(path: "str | os.PathLike[str]") -> List[scene_pb2.Cut]:
    """Reads what save_cuts() or `kerf cuts --export` wrote. Raises ValueError if the file holds something else."""
    try:
        batch = json_format.Parse(pathlib.Path(path).read_text(encoding="utf-8-sig"), scene_pb2.CutBatch())
    except json_format.ParseError as wrong:
        raise ValueError(f"{os.fspath(path)}: {wrong}") from None
    return list(batch.cuts)


def _by_columns(matrix: Sequence[Any]) -> List[float]:
    """Returns the 16 numbers of a matrix column by column. Four rows are taken as rows."""
    if len(matrix) != 4:
        return [float(number) for number in matrix]
    return [float(row[column]) for column in range(4) for row in matrix]


def _as_box(fit: Fit) -> conditions_pb2.MaterialBox:
    if isinstance(fit, str):
        if fit != "sheet":
            raise ValueError(f"fit is {fit!r}; must be low x, low y, high x, high y, or 'sheet'")
        return conditions_pb2.MaterialBox()
    low_x, low_y, high_x, high_y = fit
    return conditions_pb2.MaterialBox(min=vec2((low_x, low_y)), max=vec2((high_x, high_y)))


def _with_layers(
    made: scene_pb2.View, size_px: Tuple[float, float], layers: str, piece: Optional[int], depth_m: Tuple[float, float]
) -> scene_pb2.View:
    made.width_px, made.height_px = size_px
    made.layers = enum_value(scene_pb2.View.Layers, "layers", layers)
    if piece is not None:
        made.piece = piece
    made.nearest_m, made.farthest_m = depth_m
    return made


def enum_value(enum: Any, option: str, name: str) -> Any:
    names = [key for key in enum.keys() if not key.endswith("UNSPECIFIED")]
    if name.upper() not in names:
        raise ValueError(f"{option} is {name!r}; must be one of {', '.join(key.lower() for key in names)}")
    return enum.Value(name.upper())


def as_cut(what: Union[geometry_pb2.Curve, scene_pb2.Cut], options: CutOptions) -> scene_pb2.Cut:
    """Converts a curve with options to a cut. Raises TypeError if `what` is neither curve nor cut, or if it is a cut
    and options are given too."""
    if isinstance(what, geometry_pb2.Curve):
        return cut(what, **options)
    if not isinstance(what, scene_pb2.Cut):
        raise TypeError(f"give a curve or a kerf.cut(), not {type(what).__name__}")
    if options:
        raise TypeError("give the options to kerf.cut(), which made this cut")
    return what
