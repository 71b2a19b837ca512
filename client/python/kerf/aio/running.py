"""A sheet's time: its clock, its state and analyses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, Optional, Union, overload

from kerf.aio.part import SheetPart
from kerf.analyses import analyze_request
from kerf.arrays import Analysis, State, analysis_of, state_of
from kerf.probes import AnyProbe, Values, as_probes, probe, values_of
from kerf.regions import Place, vertices
from kerf.steps import Stepped, one_stepped, steps_request
from kerf.v1 import sheets_pb2

if TYPE_CHECKING:
    from kerf.arrays import Floats


class Running(SheetPart):
    """Time."""

    async def get(self) -> sheets_pb2.Sheet:
        """Returns the sheet as it is now: tick, counts, state hash, run state, settings in force.

        >>> (await sheet.get()).num_vertices
        400
        """
        return await self._call(self._server.sheet_service.GetSheet, sheets_pb2.GetSheetRequest(name=self.name))

    async def pause(self) -> sheets_pb2.Sheet:
        """Stops the clock; cuts and grabs then take effect at once, without time passing.

        >>> (await sheet.pause()).run_state == kerf.v1.sheets_pb2.Sheet.PAUSED
        True
        """
        return await self._call(self._server.sheet_service.PauseSheet, sheets_pb2.PauseSheetRequest(name=self.name))

    async def resume(self) -> sheets_pb2.Sheet:
        """Resumes the clock.

        >>> (await sheet.resume()).run_state == kerf.v1.sheets_pb2.Sheet.RUNNING
        True
        """
        return await self._call(self._server.sheet_service.ResumeSheet, sheets_pb2.ResumeSheetRequest(name=self.name))

    @overload
    async def step(self, ticks: int = 1) -> sheets_pb2.Sheet: ...
    @overload
    async def step(self, ticks: int = 1, *, state: Literal[True], probes: Iterable[AnyProbe] = ()) -> Stepped: ...
    @overload
    async def step(self, ticks: int = 1, *, state: bool = False, probes: Iterable[AnyProbe]) -> Stepped: ...
    async def step(
        self, ticks: int = 1, *, state: bool = False, probes: Optional[Iterable[AnyProbe]] = None
    ) -> Union[sheets_pb2.Sheet, Stepped]:
        """Runs a paused sheet for exactly this many ticks, 1..100000, as fast as the server can; returns when they are
        done.

        state: the answer has the exact state after the last tick, in the same call. probes: up to 64 of kerf.probe(),
        measured then. With one of them the answer is a Stepped; it needs NumPy. Raises FailedPrecondition if the sheet is
        running. If the call exceeds its time limit, stepping stops after the tick in progress.

        >>> before = (await sheet.get()).tick
        >>> (await sheet.step(10)).tick - before
        10
        >>> after = await sheet.step(2, state=True, probes=[kerf.probe("tip", "position", points=(0, 0))])
        >>> after.probes["tip"].tolist() == after.state.positions[0].tolist()
        True
        """
        if state or probes is not None:
            request = steps_request([self.name], ticks, state, probes or ())
            return one_stepped(await self._call(self._server.sheet_service.StepSheets, request))
        message = sheets_pb2.StepSheetRequest(name=self.name, ticks=ticks)
        return await self._call(self._server.sheet_service.StepSheet, message)

    async def set_speed(self, speed: float) -> sheets_pb2.Sheet:
        """Sets slow motion or time lapse: simulated seconds per second of wall time, 0.01..4; 1 is live. The results of
        ticks are the same, bit for bit; step() ignores the speed.

        >>> (await sheet.set_speed(0.1)).speed
        0.1
        """
        request = sheets_pb2.SetSheetSpeedRequest(name=self.name, speed=speed)
        return await self._call(self._server.sheet_service.SetSheetSpeed, request)

    async def reset(self) -> sheets_pb2.Sheet:
        """Plays the scene again from its beginning, without cuts; the tick keeps counting. undo() undoes the reset.

        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        >>> (await sheet.reset()).pieces
        1
        """
        return await self._call(self._server.sheet_service.ResetSheet, sheets_pb2.ResetSheetRequest(name=self.name))

    async def delete(self) -> None:
        """Removes the sheet from the server; its streams end with NotFound."""
        await self._call(self._server.sheet_service.DeleteSheet, sheets_pb2.DeleteSheetRequest(name=self.name))

    async def state(self) -> State:
        """Returns the exact state, as NumPy arrays of 64-bit floats. Raises ImportError without python3-numpy.

        >>> (await sheet.state()).positions[380].tolist()
        [0.0, 0.0, 1.0]
        """
        request = sheets_pb2.GetSheetStateRequest(name=self.name)
        return state_of(await self._call(self._server.sheet_service.GetSheetState, request))

    async def measure(self, probes: Iterable[AnyProbe]) -> Values:
        """Measures probes on the sheet as it is now, running or not. Needs NumPy.

        >>> (await sheet.measure([kerf.probe("all", "extent")]))["all.x"]
        1.0
        """
        message = sheets_pb2.AnalyzeSheetRequest(name=self.name, probes=as_probes(probes))
        message.analysis.dynamic.SetInParent()
        table = (await self._call(self._server.sheet_service.AnalyzeSheet, message)).tables[0]
        return values_of(table.columns[1:], table.rows[0].values[1:])

    async def force(self, place: Optional[Place] = None) -> Floats:
        """Returns the force that holds the pinned vertices of a place, newtons, 3 numbers, in the world; None: of all
        pinned vertices together. It does not include the force that moves them. Needs NumPy.

        >>> weight = await sheet.force("top")
        >>> weight.shape
        (3,)
        """
        if place is None:
            place = vertices(*(await self.get()).pinned_vertices)
        return (await self.measure([probe("force", "reaction", place=place)]))["force"]

    async def analyze(
        self,
        *,
        modes: int = 0,
        about_equilibrium: bool = False,
        ticks: Optional[int] = None,
        measure_every: int = 1,
        request: Optional[Mapping[str, Any]] = None,
    ) -> Analysis:
        """Analyses a copy of the sheet as it is now. Returns its equilibrium; with `modes` this many (1..200) of its
        lowest vibrations; with `ticks` its motion in the next so many ticks (0: its present state). Needs NumPy.

        request: kerf.v1.AnalyzeSheetRequest as a mapping, for load steps, probes and positions. With it only ticks
        and measure_every may be given; the mapping must then have no analysis. The tables of the answer hold the
        vibrations ("modes") and the measurements of the probes ("probes"). Motion is measured at the start, after
        each `measure_every` ticks and at the end. Raises ValueError if two analyses are requested, ResourceExhausted
        beyond 100,000 vertices.

        >>> (await sheet.analyze(modes=3)).tables["modes"]["frequency_hz"].shape
        (3,)
        >>> probes = [{"name": "all", "quantity": "ENERGY"}]
        >>> (await sheet.analyze(ticks=5, request={"probes": probes})).tables["probes"].values.shape
        (6, 6)
        """
        message = analyze_request(self.name, modes, about_equilibrium, ticks, measure_every, request)
        return analysis_of(await self._call(self._server.sheet_service.AnalyzeSheet, message))
