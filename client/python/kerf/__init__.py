"""Kerf from Python: sheets that are cut while they move.

    import kerf

    with kerf.connect("127.0.0.1:50051") as server:
        flag = server.create_sheet("flag", grid=(60, 40), size_m=(1.5, 1.0), pins=["corners"])
        result = flag.cut(kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5)), tolerance=0.01)
        print(result.pieces, result.deviation_m)
        for frame in flag.watch(rate_hz=10):
            print(frame.tick, frame.positions.mean(axis=0))

Lengths are metres in material coordinates: a grid spans (0, 0) to (width, height), y up. Replies are messages of
kerf.v1, described field by field in proto/kerf/v1, or NumPy arrays. A refusal of the server is raised as kerf.Error,
with its code, reason, message and field. kerf.aio has the same for asyncio.
"""

from kerf import grpc_environment as _grpc_environment  # before grpc
from kerf.arrays import Analysis, State, Table
from kerf.blocking.client import Server, connect
from kerf.blocking.interaction import Hand
from kerf.blocking.recorder import Recorder
from kerf.blocking.sheet import Sheet
from kerf.blocking.streams import FrameStream, ImageStream, Subscription
from kerf.curves import (
    Path,
    Point,
    Reading,
    bezier,
    circle,
    dxf,
    dxf_file,
    ellipse,
    polyline,
    rational,
    svg,
    svg_file,
)
from kerf.cuts import APPLIED, NO_INTERSECTION, SCHEDULED, CutOptions, camera, cut, load_cuts, save_cuts, view, view_of_matrices
from kerf.errors import (
    AlreadyExists,
    DataLoss,
    DeadlineExceeded,
    Error,
    FailedPrecondition,
    Internal,
    InvalidArgument,
    NotFound,
    PermissionDenied,
    ResourceExhausted,
    Unauthenticated,
    Unavailable,
)
from kerf.frames import Frame
from kerf.images import Codec, ColorBy, Image, decode_image
from kerf.local_server import local
from kerf.probes import AnyProbe, Quantity, Values, probe
from kerf.regions import Edge, Place, along, box, edge, nearest, of_component, vertices, whole, wind
from kerf.runs import Run, load_run
from kerf.scenes import SheetOptions
from kerf.steps import Stepped
from kerf.version import __version__

__all__ = [
    "APPLIED",
    "NO_INTERSECTION",
    "SCHEDULED",
    "AlreadyExists",
    "Analysis",
    "AnyProbe",
    "Codec",
    "ColorBy",
    "CutOptions",
    "DataLoss",
    "DeadlineExceeded",
    "Edge",
    "Error",
    "FailedPrecondition",
    "Frame",
    "FrameStream",
    "Hand",
    "Image",
    "ImageStream",
    "Internal",
    "InvalidArgument",
    "NotFound",
    "Path",
    "PermissionDenied",
    "Place",
    "Point",
    "Quantity",
    "Reading",
    "Recorder",
    "ResourceExhausted",
    "Run",
    "Server",
    "Sheet",
    "SheetOptions",
    "State",
    "Stepped",
    "Subscription",
    "Table",
    "Unauthenticated",
    "Unavailable",
    "Values",
    "__version__",
    "along",
    "bezier",
    "box",
    "camera",
    "circle",
    "connect",
    "cut",
    "decode_image",
    "dxf",
    "dxf_file",
    "edge",
    "ellipse",
    "load_cuts",
    "load_run",
    "local",
    "nearest",
    "of_component",
    "polyline",
    "probe",
    "rational",
    "save_cuts",
    "svg",
    "svg_file",
    "vertices",
    "view",
    "view_of_matrices",
    "whole",
    "wind",
]
