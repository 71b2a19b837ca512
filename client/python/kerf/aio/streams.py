"""Streams of a sheet: frames and pictures, each the newest at the time when the loop asks for it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Optional, Tuple

from kerf.aio.transport import Stream, pause
from kerf.errors import Error, NotFound, Unavailable, no_server
from kerf.frames import Frame, FrameDecoder
from kerf.images import ColorBy, Image, image_of, image_view
from kerf.v1 import geometry_pb2, render_pb2, stream_pb2

if TYPE_CHECKING:
    from typing_extensions import Self


_RETRY_AFTER_S = 0.25
_IS_BACK_AFTER_S = 30.0  # longer than gRPC tries to connect: a stream open for longer has a server


class _Loop:
    """The base class of streams: a loop over what arrives, and a `with` that ends the stream."""

    async def aclose(self) -> None:
        raise NotImplementedError

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    def __aiter__(self) -> Self:
        return self


class AcknowledgedStream(_Loop):
    """The base class of streams with acknowledgements. The answer held by a loop is acknowledged when it asks for the
    next. The server thus sends no more than the loop can take. It ends a stream that acknowledges nothing for 10
    seconds; the stream is then reopened without notice to the loop. If the server is lost, reopening is tried for
    reconnect_s."""

    _answer = ""  # field of responses that the loop gets

    def __init__(
        self, method: Any, address: str, request: Any, duration_s: Optional[float], reconnect_s: float
    ) -> None:
        self._reconnect_s = reconnect_s
        self._lost_at: Optional[float] = None  # time when the server was lost; None: not lost
        self._opened_at = 0.0
        self._method = method
        self._address = address
        self._request = request  # class of requests, for acknowledgements
        self._ends_at = None if duration_s is None else time.monotonic() + duration_s
        self._stream: Optional[Stream] = None
        self._pace: Optional[stream_pb2.WatchPace] = None  # last request of pace()
        self._closed = False
        self._sequence = 0  # number of the answer that the loop holds; 0: none
        self._arrived_ns = 0  # time of the last answer; 0: none has come

    async def aclose(self) -> None:
        """Ends the stream; idempotent. A loop over it ends."""
        self._closed = True
        stream = self._stream  # a loop on another thread may be reopening it
        if stream is not None:
            await stream.close()

    async def pace(self, rate_hz: float = 0.0, *, paused: bool = False) -> None:
        """Sets the rate from now on, as rate_hz of watch(). paused: nothing comes until the next call of pace()."""
        self._pace = stream_pb2.WatchPace(max_rate_hz=rate_hz, paused=paused)
        await self._send(self._request(pace=self._pace))

    async def _send(self, request: Any) -> None:
        """Sends a request if a stream is open; otherwise the next one begins with the settings and acknowledges nothing."""
        stream = self._stream
        if stream is not None:
            await stream.send(request)

    async def _open(self) -> Stream:
        self._opened_at = time.monotonic()
        left_s = None if self._ends_at is None else max(0.0, self._ends_at - self._opened_at)
        stream = Stream(self._method, self._address, duration_s=left_s)
        self._stream = stream
        self._sequence = 0
        await stream.send(self._first())
        if self._pace is not None:
            await stream.send(self._request(pace=self._pace))
        if self._closed:  # closed in the meantime by another thread
            await stream.close()
        return stream

    def _first(self) -> Any:
        raise NotImplementedError

    def _expects_answer(self) -> bool:
        """Returns True if no answer has come so far, though a server sends the first one at once."""
        return not self._arrived_ns and not (self._pace is not None and self._pace.paused)

    async def _next(self) -> Any:
        """Returns the next answer; ends the loop when the stream has ended without an error."""
        if self._sequence:
            held_us = 1 + (time.monotonic_ns() - self._arrived_ns) // 1000
            await self._send(self._request(ack=stream_pb2.WatchAck(sequence=self._sequence, held_us=held_us)))
            self._sequence = 0
        while not self._closed:
            stream = self._stream
            if stream is None:
                stream = await self._open()
            try:
                response = await stream.receive()
                if response is not None and response.WhichOneof("kind") == "ended":
                    raise _ended(response.ended)
            except Unavailable as failure:
                if not await self._waits_for_server(failure):
                    raise
                continue
            if response is None:
                is_new = time.monotonic() - self._opened_at < _IS_BACK_AFTER_S
                if stream.out_of_time and self._lost_at is not None and is_new:
                    raise no_server(self._address, "it was lost and has not come back")
                if stream.out_of_time and self._expects_answer():
                    raise no_server(self._address, "nothing came before the time ran out")
                break
            self._lost_at = None
            if response.WhichOneof("kind") == self._answer:
                answer = getattr(response, self._answer)
                self._arrived_ns = time.monotonic_ns()
                self._sequence = answer.sequence
                return answer
        raise StopAsyncIteration

    async def _waits_for_server(self, failure: Unavailable) -> bool:
        """Returns True if a stream with this failure is to be reopened; waits a while first if the server was lost."""
        is_slow = failure.reason == "TOO_SLOW"
        if not is_slow:
            now = time.monotonic()
            # Counts the server as back after a while, because a paused stream has no messages.
            if self._lost_at is None or now - self._opened_at > _IS_BACK_AFTER_S:
                self._lost_at = now
            is_over = now - self._lost_at >= self._reconnect_s or (self._ends_at is not None and now >= self._ends_at)
            if failure.reason not in ("", "SERVER_STOPPING") or is_over:
                return False
        stream, self._stream = self._stream, None
        assert stream is not None
        await stream.close()
        if not is_slow:
            await pause(_RETRY_AFTER_S)
        return True


class FrameStream(AcknowledgedStream):
    """Frames of a sheet; made by Sheet.watch(). Loop over them; a `with` ends the stream."""

    _answer = "frame"

    def __init__(
        self,
        method: Any,
        address: str,
        start: stream_pb2.WatchStart,
        duration_s: Optional[float],
        reconnect_s: float,
    ) -> None:
        super().__init__(method, address, stream_pb2.WatchRequest, duration_s, reconnect_s)
        self._start = start
        self._decoder = FrameDecoder()

    async def __anext__(self) -> Frame:
        message = await self._next()
        return self._decoder.decode(message)

    def _first(self) -> stream_pb2.WatchRequest:
        self._decoder.begin_stream()
        if self._decoder.epoch:
            self._start.epoch = self._decoder.epoch
            self._start.topology_version = self._decoder.topology_version
        return stream_pb2.WatchRequest(start=self._start)


class ImageStream(AcknowledgedStream):
    """Pictures of a sheet; made by Sheet.watch_images(). Loop over them; a `with` ends the stream."""

    _answer = "image"

    def __init__(
        self,
        method: Any,
        address: str,
        start: render_pb2.WatchImagesStart,
        duration_s: Optional[float],
        reconnect_s: float,
    ) -> None:
        super().__init__(method, address, render_pb2.WatchImagesRequest, duration_s, reconnect_s)
        self._start = start

    async def __anext__(self) -> Image:
        message = await self._next()
        return image_of(message)

    async def look(
        self,
        size_px: Tuple[int, int] = (640, 360),
        *,
        camera: Optional[geometry_pb2.Camera] = None,
        wireframe: bool = False,
        undeformed: bool = False,
        color_by: ColorBy = "sides",
        jpeg_quality: int = 0,
        bitrate_kbps: int = 0,
        dark: bool = False,
    ) -> None:
        """Sets the view from the next picture on; the arguments are as in Sheet.watch_images()."""
        view = image_view(size_px, camera, wireframe, undeformed, color_by, jpeg_quality, bitrate_kbps, dark)
        self._start.view.CopyFrom(view)
        await self._send(render_pb2.WatchImagesRequest(view=view))

    def _first(self) -> render_pb2.WatchImagesRequest:
        return render_pb2.WatchImagesRequest(start=self._start)


class Subscription(_Loop):
    """Frames of a sheet at a low rate; made by Sheet.subscribe(). Loop over them; a `with` ends the stream."""

    def __init__(self, method: Any, address: str, request: stream_pb2.SubscribeRequest) -> None:
        self._stream = Stream(method, address, request=request)
        self._decoder = FrameDecoder()

    async def aclose(self) -> None:
        """Ends the subscription; idempotent."""
        await self._stream.close()

    async def __anext__(self) -> Frame:
        response = await self._stream.receive()
        if response is None:
            raise StopAsyncIteration
        if response.HasField("ended"):
            raise _ended(response.ended)
        return self._decoder.decode(response.frame)


def _ended(ended: stream_pb2.Ended) -> Error:
    """Returns the reason why the server ended a stream, as the error that the next call would raise."""
    reason = stream_pb2.Ended.Reason.Name(ended.reason)
    if ended.reason == stream_pb2.Ended.SHEET_DELETED:
        return NotFound("NOT_FOUND", reason, ended.message or "the sheet was deleted")
    return Unavailable("UNAVAILABLE", reason, ended.message or "the server ended the stream")
