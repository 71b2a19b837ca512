"""Cuts of a sheet, undo and redo, and pieces."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Iterable
from typing import TYPE_CHECKING, List, Union

from kerf.aio.part import SheetPart
from kerf.cuts import CutOptions, as_cut, load_cuts, save_cuts
from kerf.v1 import cuts_pb2, geometry_pb2, scene_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

_PAGE = 1000


class Cutting(SheetPart):
    """Cuts."""

    async def cut(
        self,
        what: Union[geometry_pb2.Curve, scene_pb2.Cut],
        *,
        at_tick: int = 0,
        request_id: str = "",
        **options: Unpack[CutOptions],
    ) -> cuts_pb2.CutResult:
        """Cuts along a curve, or makes a cut of kerf.cut(): whole or not at all, at the next tick; at once on a paused
        sheet.

        at_tick: the tick at whose start the cut is made instead. The answer is then SCHEDULED; later the cut is in
        cuts() or in refused(). request_id: a repeat with the same id and body gets the same answer and cuts nothing.
        A curve that misses the sheet is no error: the status is NO_INTERSECTION. Raises InvalidArgument,
        ResourceExhausted, FailedPrecondition.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2), tolerance=0.01)
        >>> result.status == kerf.APPLIED, result.pieces
        (True, 2)
        """
        request = cuts_pb2.CreateCutRequest(
            parent=self.name, cut=as_cut(what, options), at_tick=at_tick, request_id=request_id
        )
        return await self._call(self._server.cut_service.CreateCut, request)

    async def cut_all(
        self, cuts: Iterable[Union[geometry_pb2.Curve, scene_pb2.Cut]], *, at_tick: int = 0, request_id: str = ""
    ) -> cuts_pb2.CreateCutsResponse:
        """Makes many cuts as one, on one tick and as one step to undo: all of them or none. 1..4096 cuts.

        >>> slits = [kerf.polyline((0.2, y), (0.8, y)) for y in (0.3, 0.5, 0.7)]
        >>> (await sheet.cut_all(slits)).applied
        3
        """
        request = cuts_pb2.CreateCutsRequest(
            parent=self.name, cuts=[as_cut(each, {}) for each in cuts], at_tick=at_tick, request_id=request_id
        )
        return await self._call(self._server.cut_service.CreateCuts, request)

    async def undo(self) -> cuts_pb2.UndoResult:
        """Undoes the last cut, batch of cuts or reset. Raises FailedPrecondition: NOTHING_TO_UNDO, UNDO_FORGOTTEN.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        >>> (await sheet.undo()).pieces
        1
        """
        return await self._call(self._server.cut_service.UndoCut, cuts_pb2.UndoCutRequest(parent=self.name))

    async def redo(self) -> cuts_pb2.UndoResult:
        """Redoes what was undone last. Raises FailedPrecondition: NOTHING_TO_REDO.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        >>> undone = await sheet.undo()
        >>> (await sheet.redo()).pieces
        2
        """
        return await self._call(self._server.cut_service.RedoCut, cuts_pb2.RedoCutRequest(parent=self.name))

    async def cuts(self) -> List[cuts_pb2.ListCutsResponse.Entry]:
        """Returns the cuts applied since the last reset and not undone, oldest first. Each entry has the `cut` as
        applied and its `result`.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        >>> [entry.cut.curve.circle.radius_m for entry in await sheet.cuts()]
        [0.2]
        """
        return [entry async for page in self._pages_of_cuts() for entry in page.cuts]

    async def cancel(self, name: str) -> cuts_pb2.ScheduledCuts:
        """Cancels cuts that wait for their tick. name: `scheduled_name` of the cutting call's answer, or `name` of an
        entry of waiting().

        Raises FailedPrecondition: SCHEDULED_CUTS_SETTLED if they no longer wait.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2), at_tick=(await sheet.get()).tick + 60)
        >>> cancelled = await sheet.cancel(result.scheduled_name)
        >>> await sheet.waiting()
        []
        """
        request = cuts_pb2.CancelScheduledCutsRequest(name=name)
        return await self._call(self._server.cut_service.CancelScheduledCuts, request)

    async def waiting(self) -> List[cuts_pb2.ScheduledCuts]:
        """Returns the cuts that wait for their tick, by tick.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2), at_tick=(await sheet.get()).tick + 60)
        >>> [each.name == result.scheduled_name for each in await sheet.waiting()]
        [True]
        """
        return await self._scheduled(cuts_pb2.ScheduledCuts.WAITING)

    async def refused(self) -> List[cuts_pb2.ScheduledCuts]:
        """Returns the newest scheduled cuts that were refused at their tick, with reason, message and field.

        >>> await sheet.refused()
        []
        """
        return await self._scheduled(cuts_pb2.ScheduledCuts.REFUSED)

    async def export_cuts(self, path: "str | os.PathLike[str]") -> int:
        """Writes the sheet's cuts to a JSON file, for apply_cuts() or `kerf cuts --apply`. Returns their number.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        >>> await sheet.export_cuts(path)
        1
        """
        cuts = [entry.cut for entry in await self.cuts()]
        save_cuts(path, cuts)
        return len(cuts)

    async def apply_cuts(self, path: "str | os.PathLike[str]", *, at_tick: int = 0) -> cuts_pb2.CreateCutsResponse:
        """Makes all cuts of a file, or none. Raises ValueError if the file is no list of cuts.

        >>> kerf.save_cuts(path, [kerf.cut(kerf.circle((0.5, 0.5), 0.2))])
        >>> (await sheet.apply_cuts(path)).pieces
        2
        """
        return await self.cut_all(load_cuts(path), at_tick=at_tick)

    async def pieces(self) -> List[cuts_pb2.Piece]:
        """Returns the sheet's present pieces, by id, with parent, area, mass and centroid.

        >>> [round(piece.area_m2, 9) for piece in await sheet.pieces()]
        [1.0]
        """
        request = cuts_pb2.ListPiecesRequest(parent=self.name, page_size=_PAGE)
        pieces: List[cuts_pb2.Piece] = []
        while True:
            page = await self._call(self._server.cut_service.ListPieces, request)
            pieces += page.pieces
            if not page.next_page_token:
                return pieces
            request.page_token = page.next_page_token

    async def _pages_of_cuts(self) -> AsyncIterator[cuts_pb2.ListCutsResponse]:
        request = cuts_pb2.ListCutsRequest(parent=self.name, page_size=_PAGE)
        while True:
            page = await self._call(self._server.cut_service.ListCuts, request)
            yield page
            if not page.next_page_token:
                return
            request.page_token = page.next_page_token

    async def _scheduled(self, state: int) -> List[cuts_pb2.ScheduledCuts]:
        request = cuts_pb2.ListCutsRequest(parent=self.name, page_size=1)
        first = await self._call(self._server.cut_service.ListCuts, request)
        return [each for each in first.scheduled if each.state == state]
