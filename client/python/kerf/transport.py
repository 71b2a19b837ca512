"""Calls that block, over grpc. kerf/aio/transport.py has the same functions for asyncio; all other modules come from
one source."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Iterable
from typing import Any, Optional

import grpc

from kerf import forks
from kerf.channel_options import CHANNEL_OPTIONS
from kerf.credentials import Secrets
from kerf.errors import Error, connection_closed, cut_off, error_of, is_cancelled, is_out_of_time
from kerf.notebooks import picture_html


_CHANNEL_CLOSED = "Channel closed!"  # grpc's details of calls that end because their channel was closed


IS_ASYNC = False


def open_channel(address: str, secrets: Secrets) -> grpc.Channel:
    forks.check()
    if secrets.use_tls:
        return grpc.secure_channel(address, secrets.channel_credentials(), options=CHANNEL_OPTIONS)
    return grpc.insecure_channel(address, options=CHANNEL_OPTIONS)


def close_channel(channel: grpc.Channel) -> None:
    channel.close()


def _check_forks(method: Any) -> None:
    if not getattr(method, "is_local", False):  # as kerf.local_server marks what needs no gRPC
        forks.check()


def call_unary(method: Any, request: Any, timeout_s: Optional[float], address: str) -> Any:
    """Makes a unary call. Raises kerf.Error if it fails."""
    _check_forks(method)
    try:
        return method(request, timeout=timeout_s)
    except grpc.RpcError as failure:
        raise error_of(failure, address) from None


def call_sending(method: Any, requests: Iterable[Any], timeout_s: Optional[float], address: str) -> Any:
    """Makes a call whose request is sent in parts. Raises kerf.Error if it fails."""
    return call_unary(method, iter(requests), timeout_s, address)


def pause(duration_s: float) -> None:
    time.sleep(duration_s)


class Stream:
    """One call with many answers. Its one request is `request`; without it, the requests are those of send()."""

    def __init__(self, method: Any, address: str, *, request: Any = None, duration_s: Optional[float] = None) -> None:
        self._address = address
        self._closed = True  # until there is a call
        self._pid = os.getpid()
        self._requests: queue.SimpleQueue[Any] = queue.SimpleQueue()
        _check_forks(method)
        try:
            self._call = method(iter(self._requests.get, None) if request is None else request, timeout=duration_s)
        except ValueError:  # from grpc: the channel was closed
            raise connection_closed(address) from None
        self._closed = False
        self.out_of_time = False  # True if it ended because duration_s was over

    def __del__(self) -> None:
        # A dropped stream must not leave behind the thread that waits for requests.
        self.close()

    def send(self, request: Any) -> None:
        """Sends a request; does nothing if the stream has ended: receive() then raises the reason."""
        self._requests.put(request)

    def receive(self) -> Any:
        """Returns the next answer; None when the stream has ended without an error. Raises kerf.Error if it failed."""
        if self._pid != os.getpid():
            raise forks.stream_of_parent()
        try:
            return next(self._call)
        except StopIteration:
            return None
        except grpc.RpcError as failure:
            self.out_of_time = is_out_of_time(failure)
            if self.out_of_time or (self._closed and is_cancelled(failure)):
                return None
            if is_cancelled(failure):
                is_ours = failure.details() == _CHANNEL_CLOSED
                raise (connection_closed(self._address) if is_ours else cut_off(self._address)) from None
            raise error_of(failure, self._address) from None

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._requests.put(None)
            if self._pid == os.getpid():  # the call of a parent is not this process's to end
                self._call.cancel()


class Shown:
    """Shows a sheet in notebooks. That of kerf.aio does not, because a notebook awaits nothing."""

    def _repr_html_(self) -> Optional[str]:
        """Returns a picture of the sheet as it is now; None, which shows the repr, if the server does not answer."""
        sheet: Any = self
        try:
            state = sheet.state()
        except (Error, ImportError):
            return None
        return picture_html(state._repr_png_(), f"{sheet.name}, {state!r}")


class Background:
    """Work that runs beside the caller, on a thread."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._work = work
        self._failure: Optional[BaseException] = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._work()
        except BaseException as failure:  # raised by finished()
            self._failure = failure

    def finished(self) -> None:
        """Waits until the work is done; raises what it raised."""
        self._thread.join()
        if self._failure is not None:
            raise self._failure
