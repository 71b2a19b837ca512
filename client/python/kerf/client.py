"""A server and its sheets."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterable, Mapping
from types import TracebackType
from typing import Any, List, Literal, Optional, Tuple, Type, Union

import grpc
from google.protobuf import json_format

from kerf.errors import error_of
from kerf.sheet import Sheet
from kerf.v1 import (
    conditions_pb2,
    cuts_pb2_grpc,
    interaction_pb2_grpc,
    render_pb2_grpc,
    scene_pb2,
    server_pb2,
    server_pb2_grpc,
    sheets_pb2,
    sheets_pb2_grpc,
)

_MAX_RECEIVE_BYTES = 256 << 20  # the exact state of half a million vertices fits

Edge = Literal["top", "bottom", "left", "right", "corners", "top_corners"]
RestShape = Literal["auto", "flat", "surface"]


def connect(address: str = "127.0.0.1:50051", *, timeout_s: Optional[float] = None) -> Server:
    """A server by its gRPC address; use it in a `with`, or close() it. Nothing is sent yet.

    timeout_s: how long a call may take before it raises DeadlineExceeded; None: as long as it needs.
    """
    return Server(address, timeout_s=timeout_s)


class Server:
    def __init__(self, address: str, *, timeout_s: Optional[float] = None) -> None:
        # Never through a proxy of the environment: Kerf servers are near.
        options = [("grpc.max_receive_message_length", _MAX_RECEIVE_BYTES), ("grpc.enable_http_proxy", 0)]
        self._channel = grpc.insecure_channel(address, options=options)
        self._timeout_s = timeout_s
        self.address = address
        # The generated stubs, for what has no method here.
        self.sheet_service = sheets_pb2_grpc.SheetServiceStub(self._channel)
        self.cut_service = cuts_pb2_grpc.CutServiceStub(self._channel)
        self.interaction_service = interaction_pb2_grpc.InteractionServiceStub(self._channel)
        self.render_service = render_pb2_grpc.RenderServiceStub(self._channel)
        self.server_service = server_pb2_grpc.ServerServiceStub(self._channel)

    def __enter__(self) -> Server:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def close(self) -> None:
        self._channel.close()

    def call(self, method: Any, request: Any) -> Any:
        """Calls a unary method of a stub, and raises kerf.Error where the server refuses."""
        try:
            return method(request, timeout=self._timeout_s)
        except grpc.RpcError as failure:
            raise error_of(failure, self.address) from None

    def info(self) -> server_pb2.ServerInfo:
        """Version, renderer, limits, material presets."""
        return self.call(self.server_service.GetServerInfo, server_pb2.GetServerInfoRequest())

    def sheet(self, sheet_id: str) -> Sheet:
        """A sheet that there is, by its id; nothing is asked of the server yet."""
        return Sheet(self, sheet_id)

    def sheets(self) -> List[Sheet]:
        request = sheets_pb2.ListSheetsRequest(page_size=1000)
        found: List[Sheet] = []
        while True:
            page = self.call(self.sheet_service.ListSheets, request)
            found += [Sheet(self, each.name.removeprefix("sheets/")) for each in page.sheets]
            if not page.next_page_token:
                return found
            request.page_token = page.next_page_token

    def create_sheet(
        self,
        sheet_id: str = "",
        *,
        grid: Tuple[int, int] = (50, 50),
        size_m: Tuple[float, float] = (1.0, 1.0),
        mesh_file: "Union[str, os.PathLike[str], None]" = None,
        rest: RestShape = "auto",
        pins: Iterable[Edge] = ("top",),
        material: str = "",
        parts: Iterable[Tuple[Tuple[float, float, float, float], str]] = (),
        paused: bool = False,
    ) -> Sheet:
        """A rectangle of grid[0] x grid[1] vertices, or the mesh of an .obj or .ply file (grid and size_m do not count then).

        rest: what the rest shape of a mesh file is: "flat" (its texture coordinates, or its plane), "surface" (its
        positions, curved as they are), or "auto", flat where the file allows it.
        parts: of other materials, each a box (x0, y0, x1, y1) in metres on the undeformed sheet and a preset; a later one over
        those before.
        material: a preset; info() lists them. For anything else: create_scene(). Raises ValueError where the file's name
        has another ending; a server takes calls of up to 1 MiB.
        """
        columns, rows = grid
        scene = scene_pb2.Scene(
            pins=[conditions_pb2.Region(edge=conditions_pb2.Region.Edge.Value(each.upper())) for each in pins],
            material=scene_pb2.Material(preset=material),
        )
        for (x0, y0, x1, y1), preset in parts:
            part = scene.materials.add(material=scene_pb2.Material(preset=preset))
            part.region.box.min.x, part.region.box.min.y = x0, y0
            part.region.box.max.x, part.region.box.max.y = x1, y1
        if mesh_file is None:
            scene.grid.CopyFrom(scene_pb2.GridMesh(columns=columns, rows=rows, width_m=size_m[0], height_m=size_m[1]))
        else:
            _add_mesh_file(scene, pathlib.Path(mesh_file), rest)
        return self.create_scene(scene, sheet_id, paused=paused)

    def create_scene(
        self,
        scene: "Union[scene_pb2.Scene, Mapping[str, Any], str, os.PathLike[str]]",
        sheet_id: str = "",
        *,
        paused: bool = False,
        request_id: str = "",
    ) -> Sheet:
        """A sheet from a scene: a message, its JSON form as a dict, or the path of a scene file.

        Raises ValueError where the JSON is no scene. Files that the scene names are not read: a server refuses those.
        """
        request = sheets_pb2.CreateSheetRequest(
            sheet_id=sheet_id, scene=_as_scene(scene), paused=paused, request_id=request_id
        )
        made = self.call(self.sheet_service.CreateSheet, request)
        return Sheet(self, made.name.removeprefix("sheets/"))


def _add_mesh_file(scene: scene_pb2.Scene, file: pathlib.Path, rest: RestShape) -> None:
    rest_shape = {
        "auto": scene_pb2.REST_SHAPE_UNSPECIFIED,
        "flat": scene_pb2.REST_SHAPE_FLAT,
        "surface": scene_pb2.REST_SHAPE_SURFACE,
    }[rest]
    if file.suffix.lower() == ".ply":
        scene.ply.data = file.read_bytes()
        scene.ply.rest_shape = rest_shape
    elif file.suffix.lower() == ".obj":
        # All that counts in it is ASCII; names and comments may be in any encoding.
        scene.obj.text = file.read_text(encoding="ascii", errors="replace")
        scene.obj.rest_shape = rest_shape
    else:
        raise ValueError(f"{file}: the name of a mesh file ends in .obj or .ply")


def _as_scene(scene: "Union[scene_pb2.Scene, Mapping[str, Any], str, os.PathLike[str]]") -> scene_pb2.Scene:
    if isinstance(scene, scene_pb2.Scene):
        return scene
    try:
        if isinstance(scene, Mapping):
            return json_format.ParseDict(scene, scene_pb2.Scene())
        return json_format.Parse(pathlib.Path(scene).read_text(encoding="utf-8"), scene_pb2.Scene())
    except (json_format.ParseError, json.JSONDecodeError) as wrong:
        name = "scene" if isinstance(scene, Mapping) else os.fspath(scene)
        raise ValueError(f"{name}: {wrong}") from None
