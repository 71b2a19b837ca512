"""A server in the process that calls it: the same sheets and calls, without a network.

    import kerf

    with kerf.local() as server:
        sheet = server.create_sheet("flag", grid=(20, 20), pins=["top_corners"], paused=True)
        print(sheet.step(60, state=True).state.positions.mean(axis=0))

It loads libkerf_local.so, which `cmake --build` makes beside kerfd.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
import pathlib
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NoReturn, Optional, Tuple

import grpc
from google.rpc import status_pb2

from kerf.blocking.client import Server
from kerf.errors import Unavailable

_NAME = "libkerf_local.so"
_CODES = {code.value[0]: code for code in grpc.StatusCode}
_UPLOAD = "/kerf.v1.SheetService/UploadSheet"


class _Bytes(ctypes.Structure):
    """kerf_local_bytes of server/service/local/kerf_local.h"""

    _fields_ = [("data", ctypes.c_void_p), ("size", ctypes.c_size_t)]


def _find_library() -> str:
    """Returns what to load: the file of KERF_LIBRARY, that beside the package, or that of the system."""
    named = os.environ.get("KERF_LIBRARY")
    beside = pathlib.Path(__file__).with_name(_NAME)
    return named or (str(beside) if beside.exists() else _NAME)


@functools.lru_cache(maxsize=None)
def _library() -> Any:
    path = _find_library()
    try:
        library = ctypes.CDLL(path)
    except OSError as failure:
        raise ImportError(
            f"a server in this process needs {_NAME}, which is not there: build it with `ninja -C build/release kerf_local_c` "
            f"and name the file in KERF_LIBRARY, or use kerf.connect() ({failure})"
        ) from None
    answer = ctypes.POINTER(_Bytes)
    library.kerf_local_start.argtypes = (ctypes.c_int32, ctypes.c_int32, answer)
    library.kerf_local_start.restype = ctypes.c_void_p
    library.kerf_local_stop.argtypes = (ctypes.c_void_p,)
    library.kerf_local_stop.restype = None
    library.kerf_local_call.argtypes = (
        ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_double, answer,
    )  # fmt: skip
    library.kerf_local_upload_sheet.argtypes = (
        ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_double, answer,
    )  # fmt: skip
    library.kerf_local_free.argtypes = (_Bytes,)
    library.kerf_local_free.restype = None
    return library


def _taken(answer: _Bytes) -> bytes:
    """Returns a copy of what the library returned, and frees that."""
    try:
        return ctypes.string_at(answer.data, answer.size)
    finally:
        _library().kerf_local_free(answer)


class _Refusal(grpc.RpcError):  # type: ignore[misc]
    """A refusal in the form that grpc raises, which kerf.errors.error_of() reads."""

    def __init__(self, code: int, status: bytes) -> None:
        super().__init__()
        self._code = _CODES[code]
        self._status = status

    def code(self) -> grpc.StatusCode:
        return self._code

    def details(self) -> str:
        return str(status_pb2.Status.FromString(self._status).message)

    def trailing_metadata(self) -> Tuple[Tuple[str, bytes], ...]:
        return (("grpc-status-details-bin", self._status),)


class _Channel:
    """Makes the calls of generated stubs, as a grpc.Channel does."""

    def __init__(self, workers: int, render: bool) -> None:
        failure = _Bytes()
        self._server = _library().kerf_local_start(workers, int(render), ctypes.byref(failure))
        if not self._server:
            raise ValueError(status_pb2.Status.FromString(_taken(failure)).message)
        self._pid = os.getpid()
        self._changed = threading.Condition()
        self._num_calls = 0
        self._is_closed = False

    def __del__(self) -> None:
        if getattr(self, "_server", None):
            self.close()

    def close(self) -> None:
        """Ends all sheets, once the calls in progress are answered."""
        if self._pid != os.getpid():  # its threads are the parent's
            return
        with self._changed:
            was_closed, self._is_closed = self._is_closed, True
            self._changed.wait_for(lambda: self._num_calls == 0)
        if not was_closed:
            _library().kerf_local_stop(self._server)

    @contextlib.contextmanager
    def _calling(self) -> Iterator[None]:
        if self._pid != os.getpid():
            raise Unavailable(
                "UNAVAILABLE", "FORKED", "the threads of a server in a process do not survive a fork: start another in the child"
            )
        with self._changed:
            if self._is_closed:
                raise ValueError("the server in this process was closed")
            self._num_calls += 1
        try:
            yield
        finally:
            with self._changed:
                self._num_calls -= 1
                self._changed.notify_all()

    def _answer(self, code: int, answer: _Bytes) -> bytes:
        content = _taken(answer)
        if code:
            raise _Refusal(code, content)
        return content

    def unary_unary(
        self, path: str, request_serializer: Callable[[Any], bytes], response_deserializer: Callable[[bytes], Any], **_: Any
    ) -> Callable[..., Any]:
        name = path.encode()
        call_library = _library().kerf_local_call

        def call(request: Any, timeout: Optional[float] = None) -> Any:
            content, answer = request_serializer(request), _Bytes()
            with self._calling():
                code = call_library(self._server, name, content, len(content), _limit_of(timeout), ctypes.byref(answer))
            return response_deserializer(self._answer(code, answer))

        return _local(call)

    def stream_unary(
        self, path: str, request_serializer: Callable[[Any], bytes], response_deserializer: Callable[[bytes], Any], **_: Any
    ) -> Callable[..., Any]:
        def call(requests: Iterable[Any], timeout: Optional[float] = None) -> Any:
            first, *parts = requests
            start, file, answer = first.start.SerializeToString(), b"".join(part.chunk for part in parts), _Bytes()
            with self._calling():
                code = _library().kerf_local_upload_sheet(
                    self._server, start, len(start), file, len(file), _limit_of(timeout), ctypes.byref(answer)
                )
            return response_deserializer(self._answer(code, answer))

        return _local(call) if path == _UPLOAD else _refusing(path)

    def unary_stream(self, path: str, *_: Any, **__: Any) -> Callable[..., Any]:
        return _refusing(path)

    def stream_stream(self, path: str, *_: Any, **__: Any) -> Callable[..., Any]:
        return _refusing(path)


def _limit_of(timeout: Optional[float]) -> float:
    return -1.0 if timeout is None else timeout


def _local(call: Callable[..., Any]) -> Callable[..., Any]:
    """Marks a call that needs no thread of gRPC, so that it can be made in the child of a fork."""
    call.is_local = True  # type: ignore[attr-defined]
    return call


def _refusing(path: str) -> Callable[..., Any]:
    """Returns the call of a stream, which is refused."""

    def refuse(*_: Any, **__: Any) -> NoReturn:
        instead = "use step(state=True), state() or probes, or kerf.connect()"
        if path.endswith("Recording"):
            instead = "use kerf.connect()"
        raise Unavailable("UNAVAILABLE", "NO_STREAMS", f"a server in the same process has no {path}: {instead}")

    return _local(refuse)


class LocalServer(Server):
    """A server in this process; made by local()."""

    def __init__(self, workers: int, render: bool, timeout_s: Optional[float]) -> None:
        self._own = _Channel(workers, render)  # in the child of a fork, too, where it refuses calls
        super().__init__("this process", timeout_s=timeout_s)

    def __repr__(self) -> str:
        return "<kerf.Server in this process>"

    def _make_channel(self) -> Any:
        return self._own

    def _watch_forks(self) -> None:
        """Does nothing: the calls themselves refuse to be made in a child."""


def local(*, workers: int = 0, render: bool = False, timeout_s: Optional[float] = None) -> Server:
    """Starts a server in this process and returns it; use it in a `with`, or close it. It has all that kerf.connect() has
    except streams and recordings, keeps nothing, and takes calls from any thread.

    workers: threads that step sheets, 1..256; 0: one for each processor. render: draws pictures, if the machine can.
    timeout_s: as in connect(). Raises ImportError without libkerf_local.so; KERF_LIBRARY names that file. Raises
    ValueError if there cannot be so many workers. The child of a fork has none of the sheets and must start another.
    Ctrl-C is noticed once the call in progress is answered.

    >>> with kerf.local() as own:
    ...     own.create_sheet("flag", grid=(4, 4), paused=True).step(2).tick
    2
    """
    return LocalServer(workers, render, timeout_s)
