"""Calls for asyncio, over grpc.aio. kerf/transport.py has the same functions for calls that block."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Coroutine, Iterable
from typing import Any, Optional

import grpc

from kerf import forks
from kerf.channel_options import CHANNEL_OPTIONS
from kerf.credentials import Secrets
from kerf.errors import connection_closed, cut_off, error_of, is_cancelled, is_out_of_time


IS_ASYNC = True


def open_channel(address: str, secrets: Secrets) -> grpc.aio.Channel:
    forks.check()
    if secrets.use_tls:
        return grpc.aio.secure_channel(address, secrets.channel_credentials(), options=CHANNEL_OPTIONS)
    return grpc.aio.insecure_channel(address, options=CHANNEL_OPTIONS)


async def close_channel(channel: grpc.aio.Channel) -> None:
    await channel.close()


async def call_unary(method: Any, request: Any, timeout_s: Optional[float], address: str) -> Any:
    """Makes a unary call. Raises kerf.Error if it fails."""
    forks.check()
    try:
        return await method(request, timeout=timeout_s)
    except grpc.RpcError as failure:
        raise error_of(failure, address) from None


async def call_sending(method: Any, requests: Iterable[Any], timeout_s: Optional[float], address: str) -> Any:
    """Makes a call whose request is sent in parts. Raises kerf.Error if it fails."""
    return await call_unary(method, iter(requests), timeout_s, address)


async def pause(duration_s: float) -> None:
    await asyncio.sleep(duration_s)


class Stream:
    """One call with many answers. Its one request is `request`; without it, the requests are those of send()."""

    def __init__(self, method: Any, address: str, *, request: Any = None, duration_s: Optional[float] = None) -> None:
        self._address = address
        self._closed = True  # until there is a call
        # A queue, because a direct write to a call that the server has ended never returns.
        self._requests: asyncio.Queue[Any] = asyncio.Queue()
        forks.check()
        try:
            self._call = method(_until_none(self._requests) if request is None else request, timeout=duration_s)
        except grpc.aio.UsageError:  # the channel was closed
            raise connection_closed(address) from None
        self._closed = False
        self._reading: Optional[asyncio.Future[Any]] = None  # reads the next answer, also after its caller is cancelled
        self.out_of_time = False  # True if it ended because duration_s was over

    def __del__(self) -> None:
        # A dropped stream must not leave behind the task that waits for requests. Without a running loop there is no
        # task.
        with contextlib.suppress(RuntimeError):
            self._end()

    async def send(self, request: Any) -> None:
        """Sends a request; does nothing if the stream has ended: receive() then raises the reason."""
        self._requests.put_nowait(request)

    async def receive(self) -> Any:
        """Returns the next answer; None when the stream has ended without an error. Raises kerf.Error if it failed."""
        if self._reading is None:
            self._reading = asyncio.ensure_future(self._call.read())
        reading = self._reading
        # A cancelled read would end the whole call. So a caller that is cancelled here leaves its read to the next
        # caller.
        await asyncio.wait((reading,))
        self._reading = None
        if reading.cancelled():  # cancelled with the call, by close() or because the connection was closed
            if self._closed:
                return None
            raise connection_closed(self._address)
        try:
            answer = reading.result()
        except grpc.RpcError as failure:
            self.out_of_time = is_out_of_time(failure)
            if self.out_of_time or (self._closed and is_cancelled(failure)):
                return None
            if is_cancelled(failure):
                raise cut_off(self._address) from None
            raise error_of(failure, self._address) from None
        return None if answer is grpc.aio.EOF else answer

    async def close(self) -> None:
        self._end()

    def _end(self) -> None:
        if not self._closed:
            self._closed = True
            self._requests.put_nowait(None)
            self._call.cancel()
            if self._reading is not None:  # its caller was cancelled, so its exception is consumed here
                self._reading.add_done_callback(lambda reading: reading.cancelled() or reading.exception())


async def _until_none(requests: asyncio.Queue[Any]) -> AsyncIterator[Any]:
    while (request := await requests.get()) is not None:
        yield request


class Shown:
    """Shows a sheet in notebooks, but only that of the blocking surface, because a notebook awaits nothing."""


class Background:
    """Work that runs beside the caller, as a task."""

    def __init__(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        self._task = asyncio.ensure_future(work())

    async def finished(self) -> None:
        """Waits until the work is done; raises what it raised."""
        await self._task
