"""Kerf from Python: sheets that are cut while they move.

    import kerf

    with kerf.connect("127.0.0.1:50051") as server:
        flag = server.create_sheet("flag", grid=(60, 40), size_m=(1.5, 1.0), pins=["corners"])
        result = flag.cut(kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5)), tolerance=0.01)
        print(result.pieces, result.deviation_m)
        flag.undo()

Lengths are metres in material coordinates: a grid spans (0, 0) to (width, height), y up. Replies are the messages of
kerf.v1 as they come, described field by field in proto/kerf/v1. What the server refuses is raised as kerf.Error, with its
code, reason, message and field.
"""

from kerf.client import Server, connect
from kerf.curves import Path, Point, bezier, circle, ellipse, polyline, rational, svg, svg_file
from kerf.cuts import APPLIED, NO_INTERSECTION, SCHEDULED, CutOptions, camera, cut, load_cuts, save_cuts, view, view_of_matrices
from kerf.errors import (
    AlreadyExists,
    DeadlineExceeded,
    Error,
    FailedPrecondition,
    Internal,
    InvalidArgument,
    NotFound,
    ResourceExhausted,
    Unavailable,
)
from kerf.sheet import Sheet, State

__all__ = [
    "APPLIED",
    "NO_INTERSECTION",
    "SCHEDULED",
    "AlreadyExists",
    "CutOptions",
    "DeadlineExceeded",
    "Error",
    "FailedPrecondition",
    "Internal",
    "InvalidArgument",
    "NotFound",
    "Path",
    "Point",
    "ResourceExhausted",
    "Server",
    "Sheet",
    "State",
    "Unavailable",
    "bezier",
    "camera",
    "circle",
    "connect",
    "cut",
    "ellipse",
    "load_cuts",
    "polyline",
    "rational",
    "save_cuts",
    "svg",
    "svg_file",
    "view",
    "view_of_matrices",
]
