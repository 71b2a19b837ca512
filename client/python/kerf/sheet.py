"""One sheet of a server: cutting it, running it, looking at it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, List, Literal, Optional, Tuple, Union

from google.protobuf import json_format

from kerf.curves import Point, vec2
from kerf.cuts import CutOptions, Vector, cut as make_cut, load_cuts, save_cuts, vec3
from kerf.v1 import conditions_pb2, cuts_pb2, geometry_pb2, interaction_pb2, render_pb2, scene_pb2, sheets_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from kerf.client import Server

_PAGE = 1000


@dataclass(frozen=True)
class State:
    """The exact state of a sheet after a tick: 64-bit floats as they are in the solver. The arrays are views (memoryview, and
    so ready for numpy.asarray) of V vertices and S triangle slots."""

    tick: int
    topology_version: int
    state_hash: str
    positions: memoryview  # V x 3 float64, metres, world
    velocities: memoryview  # V x 3 float64, metres/second
    material_positions: memoryview  # V x 2 float64, metres
    triangles: memoryview  # S x 3 int32; -1, -1, -1 for a slot without material
    pieces: memoryview  # S int32, the label of each slot's piece; -1 without material


class Sheet:
    """A sheet by its name. Every method is a call to the server and raises kerf.Error where that refuses."""

    def __init__(self, server: Server, sheet_id: str) -> None:
        self._server = server
        self.id = sheet_id
        self.name = f"sheets/{sheet_id}"

    def __repr__(self) -> str:
        return f"<kerf.Sheet {self.name}>"

    # Cuts ---------------------------------------------------------------------------------------------------------------

    def cut(
        self,
        what: Union[geometry_pb2.Curve, scene_pb2.Cut],
        *,
        at_tick: int = 0,
        request_id: str = "",
        **options: Unpack[CutOptions],
    ) -> cuts_pb2.CutResult:
        """Cuts along a curve, or as a cut says: whole or not at all, at the next tick; at once on a paused sheet.

        at_tick: at the start of that tick instead; the answer is SCHEDULED, what became of it is in cuts() or refused().
        request_id: a repeat with the same id and body gets the same answer and cuts nothing. A curve that misses the sheet is
        no error: the status is NO_INTERSECTION.
        """
        request = cuts_pb2.CreateCutRequest(
            parent=self.name, cut=_as_cut(what, options), at_tick=at_tick, request_id=request_id
        )
        return self._server.call(self._server.cut_service.CreateCut, request)

    def cut_all(
        self, cuts: Iterable[Union[geometry_pb2.Curve, scene_pb2.Cut]], *, at_tick: int = 0, request_id: str = ""
    ) -> cuts_pb2.CreateCutsResponse:
        """Many cuts as one, on one tick and one step to undo: all of them or none. 1..4096 cuts."""
        request = cuts_pb2.CreateCutsRequest(
            parent=self.name, cuts=[_as_cut(each, {}) for each in cuts], at_tick=at_tick, request_id=request_id
        )
        return self._server.call(self._server.cut_service.CreateCuts, request)

    def undo(self) -> cuts_pb2.UndoResult:
        """Takes the last cut or batch back. FailedPrecondition: NOTHING_TO_UNDO, UNDO_FORGOTTEN."""
        return self._server.call(self._server.cut_service.UndoCut, cuts_pb2.UndoCutRequest(parent=self.name))

    def redo(self) -> cuts_pb2.UndoResult:
        """Makes what was undone last again. FailedPrecondition: NOTHING_TO_REDO."""
        return self._server.call(self._server.cut_service.RedoCut, cuts_pb2.RedoCutRequest(parent=self.name))

    def cuts(self) -> List[cuts_pb2.ListCutsResponse.Entry]:
        """The cuts applied since the last reset and not undone, oldest first: `cut` as applied and its `result`."""
        return [entry for page in self._pages_of_cuts() for entry in page.cuts]

    def cancel(self, name: str) -> cuts_pb2.ScheduledCuts:
        """Takes back cuts that wait for their tick: by `scheduled_name` of the call's answer, or `name` of waiting()."""
        request = cuts_pb2.CancelScheduledCutsRequest(name=name)
        return self._server.call(self._server.cut_service.CancelScheduledCuts, request)

    def waiting(self) -> List[cuts_pb2.ScheduledCuts]:
        """The cuts that wait for their tick, by tick."""
        return self._scheduled(cuts_pb2.ScheduledCuts.WAITING)

    def refused(self) -> List[cuts_pb2.ScheduledCuts]:
        """The last scheduled cuts that were refused when their tick came, with reason, message and field."""
        return self._scheduled(cuts_pb2.ScheduledCuts.REFUSED)

    def export_cuts(self, path: "str | os.PathLike[str]") -> int:
        """Writes the sheet's cuts to a JSON file, for apply_cuts() or `kerf cuts --apply`; how many there are."""
        cuts = [entry.cut for entry in self.cuts()]
        save_cuts(path, cuts)
        return len(cuts)

    def apply_cuts(self, path: "str | os.PathLike[str]", *, at_tick: int = 0) -> cuts_pb2.CreateCutsResponse:
        """Makes all cuts of a file, or none. Raises ValueError where it is no list of cuts."""
        return self.cut_all(load_cuts(path), at_tick=at_tick)

    def pieces(self) -> List[cuts_pb2.Piece]:
        """The pieces that the sheet is in now, by id."""
        request = cuts_pb2.ListPiecesRequest(parent=self.name, page_size=_PAGE)
        pieces: List[cuts_pb2.Piece] = []
        while True:
            page = self._server.call(self._server.cut_service.ListPieces, request)
            pieces += page.pieces
            if not page.next_page_token:
                return pieces
            request.page_token = page.next_page_token

    def analyze(
        self,
        *,
        modes: int = 0,
        about_equilibrium: bool = False,
        ticks: Optional[int] = None,
        measure_every: int = 1,
        request: Optional[Mapping[str, Any]] = None,
    ) -> sheets_pb2.AnalyzeSheetResponse:
        """The equilibrium of the sheet as it is now, or with `modes` so many of its lowest vibrations, or with `ticks` what it
        does in so many ticks to come (0: how it is): on a copy.

        request: kerf.v1.AnalyzeSheetRequest as a mapping, for load steps and probes; beside it only ticks and measure_every
        may be given, and then it has no analysis of its own. `tables` of the answer holds what the probes measured ("probes",
        in time at the start, after each `measure_every` ticks and at the end) and the vibrations ("modes"): `columns`, and
        `rows` of `values`, one a column.
        """
        if ticks is not None and modes:
            raise ValueError("give either ticks, or modes")
        if request is not None and (modes or about_equilibrium or (ticks is not None and "analysis" in request)):
            raise ValueError("give the analysis either in the request, or beside it")
        message = json_format.ParseDict(dict(request or {}), sheets_pb2.AnalyzeSheetRequest())
        if ticks is not None:
            message.analysis.dynamic.ticks = ticks
            message.analysis.dynamic.measure_every = measure_every
        elif modes:
            message.analysis.modes.count = modes
            if about_equilibrium:
                message.analysis.modes.about.SetInParent()
        elif request is None:
            message.analysis.static.SetInParent()
        message.name = self.name
        return self._server.call(self._server.sheet_service.AnalyzeSheet, message)

    # Time ---------------------------------------------------------------------------------------------------------------

    def get(self) -> sheets_pb2.Sheet:
        """The sheet as it is now: tick, counts, state hash, run state, settings in force."""
        return self._server.call(self._server.sheet_service.GetSheet, sheets_pb2.GetSheetRequest(name=self.name))

    def pause(self) -> sheets_pb2.Sheet:
        return self._server.call(self._server.sheet_service.PauseSheet, sheets_pb2.PauseSheetRequest(name=self.name))

    def resume(self) -> sheets_pb2.Sheet:
        return self._server.call(self._server.sheet_service.ResumeSheet, sheets_pb2.ResumeSheetRequest(name=self.name))

    def step(self, ticks: int = 1) -> sheets_pb2.Sheet:
        """Runs a paused sheet by exactly so many ticks, 1..100000, as fast as the server can, and answers then."""
        request = sheets_pb2.StepSheetRequest(name=self.name, ticks=ticks)
        return self._server.call(self._server.sheet_service.StepSheet, request)

    def reset(self) -> sheets_pb2.Sheet:
        """Back to the initial state; the tick goes on counting."""
        return self._server.call(self._server.sheet_service.ResetSheet, sheets_pb2.ResetSheetRequest(name=self.name))

    def delete(self) -> None:
        self._server.call(self._server.sheet_service.DeleteSheet, sheets_pb2.DeleteSheetRequest(name=self.name))

    # Hands --------------------------------------------------------------------------------------------------------------
    # Each returns the tick at which it took effect.

    def grab(
        self, grab_id: str, point: Union[int, Point], target: Optional[Vector] = None, stiffness_npm: float = 0.0
    ) -> int:
        """Ties a vertex (int) or a material point to a target in the world, metres; absent: where it is now."""
        grab = scene_pb2.Grab(grab_id=grab_id, stiffness_npm=stiffness_npm)
        if isinstance(point, int):
            grab.vertex = point
        else:
            grab.material.CopyFrom(vec2(point))
        if target is not None:
            grab.target.CopyFrom(vec3(target))
        return self._interact("GrabPoint", interaction_pb2.GrabPointRequest(name=self.name, grab=grab))

    def drag(self, grab_id: str, target: Vector) -> int:
        drag = scene_pb2.Drag(grab_id=grab_id, target=vec3(target))
        return self._interact("DragPoint", interaction_pb2.DragPointRequest(name=self.name, drag=drag))

    def release(self, grab_id: str) -> int:
        release = scene_pb2.Release(grab_id=grab_id)
        return self._interact("ReleasePoint", interaction_pb2.ReleasePointRequest(name=self.name, release=release))

    def set_pins(self, pins: Iterable[conditions_pb2.Region]) -> int:
        """Replaces all pins; none releases the sheet."""
        request = interaction_pb2.SetSheetPinsRequest(name=self.name, set_pins=scene_pb2.SetPins(pins=pins))
        return self._interact("SetSheetPins", request)

    def set_gravity(self, gravity_mps2: Vector) -> int:
        gravity = scene_pb2.SetGravity(gravity_mps2=vec3(gravity_mps2))
        request = interaction_pb2.SetSheetGravityRequest(name=self.name, set_gravity=gravity)
        return self._interact("SetSheetGravity", request)

    def set_wind(self, wind: Optional[scene_pb2.Wind]) -> int:
        """None: no air at all."""
        request = interaction_pb2.SetSheetWindRequest(name=self.name, set_wind=scene_pb2.SetWind(wind=wind))
        return self._interact("SetSheetWind", request)

    # Looks --------------------------------------------------------------------------------------------------------------

    def render(
        self,
        size_px: Tuple[int, int] = (640, 360),
        *,
        camera: Optional[geometry_pb2.Camera] = None,
        wireframe: bool = False,
        undeformed: bool = False,
        format: Literal["png", "jpeg"] = "png",
        jpeg_quality: int = 0,
    ) -> bytes:
        """A picture of the sheet, drawn on the server: the bytes of a file. Unavailable where it has no renderer.

        camera: see kerf.camera(); absent: shows the whole sheet. undeformed: as it is cut, but flat, at its material
        coordinates x, y, 0.
        """
        request = render_pb2.RenderImageRequest(
            name=self.name,
            width_px=size_px[0],
            height_px=size_px[1],
            camera=camera,
            wireframe=wireframe,
            undeformed=undeformed,
            format=render_pb2.RenderImageRequest.Format.Value(format.upper()),
            jpeg_quality=jpeg_quality,
        )
        return bytes(self._server.call(self._server.render_service.RenderImage, request).image)

    def obj(self) -> bytes:
        """The sheet as it is now, as a Wavefront OBJ file."""
        request = sheets_pb2.ExportSheetRequest(name=self.name)
        return bytes(self._server.call(self._server.sheet_service.ExportSheet, request).content)

    def state(self) -> State:
        request = sheets_pb2.GetSheetStateRequest(name=self.name)
        reply = self._server.call(self._server.sheet_service.GetSheetState, request)
        return State(
            reply.tick,
            reply.topology_version,
            reply.state_hash,
            _array(reply.positions, "d", 3),
            _array(reply.velocities, "d", 3),
            _array(reply.material_positions, "d", 2),
            _array(reply.triangles, "i", 3),
            _array(reply.pieces, "i", 1),
        )

    def _interact(self, method: str, request: Any) -> int:
        reply = self._server.call(getattr(self._server.interaction_service, method), request)
        return int(reply.tick)

    def _pages_of_cuts(self) -> Iterable[cuts_pb2.ListCutsResponse]:
        request = cuts_pb2.ListCutsRequest(parent=self.name, page_size=_PAGE)
        while True:
            page = self._server.call(self._server.cut_service.ListCuts, request)
            yield page
            if not page.next_page_token:
                return
            request.page_token = page.next_page_token

    def _scheduled(self, state: int) -> List[cuts_pb2.ScheduledCuts]:
        first = next(iter(self._pages_of_cuts()))
        return [each for each in first.scheduled if each.state == state]


def _as_cut(what: Union[geometry_pb2.Curve, scene_pb2.Cut], options: CutOptions) -> scene_pb2.Cut:
    if isinstance(what, geometry_pb2.Curve):
        return make_cut(what, **options)
    if not isinstance(what, scene_pb2.Cut):
        raise TypeError(f"a curve or a kerf.cut() is cut, not {type(what).__name__}")
    if options:
        raise TypeError("give the options to kerf.cut(), which made this cut")
    return what


def _array(content: bytes, kind: Literal["d", "i"], columns: int) -> memoryview:
    if sys.byteorder != "little":
        raise NotImplementedError("states are little-endian")
    view = memoryview(content).cast(kind)
    return view if columns == 1 else view.cast("B").cast(kind, shape=(len(view) // columns, columns))
