"""Records a sheet while a script continues."""

from __future__ import annotations

import os
from collections.abc import Awaitable, Callable
from typing import Optional

from kerf.aio.transport import Background
from kerf.aio.streams import FrameStream
from kerf.runs import RunWriter


class Recorder:
    """Writes frames of a sheet to a file while a `with` lasts; made by Sheet.recorder()."""

    def __init__(
        self, frames: FrameStream, path: "str | os.PathLike[str]", tick_now: Callable[[], Awaitable[int]]
    ) -> None:
        self._frames = frames
        self._path = path
        self._tick_now = tick_now
        self._writer: Optional[RunWriter] = None
        self._pump: Optional[Background] = None
        self._last_tick = -1  # tick of the last frame in the file
        self._until: Optional[int] = None  # tick with which the pump ends; None: no end yet
        self.num_frames = 0  # frames in the file so far

    async def __aenter__(self) -> Recorder:
        self._writer = RunWriter(self._path)
        self._pump = Background(self._record)
        return self

    async def __aexit__(self, kind: Optional[type], *_: object) -> None:
        assert self._pump is not None and self._writer is not None
        try:
            if kind is None:
                # Sets _until before it reads _last_tick; the pump does the opposite, so that at least one of the two
                # sees the other's value.
                self._until = await self._tick_now()
                if self._last_tick >= self._until:
                    await self._frames.aclose()
                await self._pump.finished()
        finally:
            await self._frames.aclose()
            try:
                await self._pump.finished()
            finally:
                if self.num_frames:
                    self._writer.close()
                else:
                    self._writer.discard()  # an empty run would replace an older file

    async def _record(self) -> None:
        assert self._writer is not None
        async for frame in self._frames:
            self._writer.add(frame)
            self.num_frames += 1
            self._last_tick = frame.tick
            if self._until is not None and frame.tick >= self._until:
                return
