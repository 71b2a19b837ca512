"""Exceptions for refusals of the server: one class per gRPC status code."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, Optional, Tuple

import grpc
from google.rpc import error_details_pb2, status_pb2


class Error(Exception):
    """A refusal. Nothing was changed.

    code: the status, "INVALID_ARGUMENT"; see the subclasses. reason: stable, for programs, "CURVE_NOT_FINITE"; empty
    if the server was not reached. message: for people, with the remedy. field: path of the request's field at fault,
    "cut.curve.circle.radius_m"; may be empty. metadata: numbers of the refusal by name, as text; may be empty.
    retry_after_s: seconds after which the same call may work; None: a repeat fails unless something changes.

    >>> error = Error("RESOURCE_EXHAUSTED", "QUEUE_FULL", "64 commands are waiting", retry_after_s=0.1)
    >>> str(error)
    '64 commands are waiting (RESOURCE_EXHAUSTED, QUEUE_FULL; may work in 0.1 s)'
    """

    def __init__(
        self,
        code: str,
        reason: str,
        message: str,
        field: str = "",
        *,
        metadata: Optional[Mapping[str, str]] = None,
        retry_after_s: Optional[float] = None,
    ) -> None:
        where = f" [field: {field}]" if field else ""
        why = f"{code}, {reason}" if reason else code
        when = "" if retry_after_s is None else f"; may work in {retry_after_s:g} s"
        super().__init__(f"{message}{where} ({why}{when})")
        self.code = code
        self.reason = reason
        self.message = message
        self.field = field
        self.metadata = dict(metadata or {})
        self.retry_after_s = retry_after_s

    def __reduce__(self) -> Tuple[Any, ...]:
        # pickle, copy and process pools make an exception again from its args. Here these are only the sentence, so all
        # parts are given.
        made = functools.partial(type(self), metadata=self.metadata, retry_after_s=self.retry_after_s)
        return made, (self.code, self.reason, self.message, self.field)


class InvalidArgument(Error):
    """The request can never work, in any state of the sheet."""


class NotFound(Error):
    """Names a sheet that does not exist."""


class AlreadyExists(Error):
    """A sheet with this name already exists."""


class ResourceExhausted(Error):
    """A limit is reached or a queue is full. The call may work later: see retry_after_s."""


class FailedPrecondition(Error):
    """The request does not fit the present state: to step a running sheet, or to undo when nothing was cut."""


class Unauthenticated(Error):
    """The server does not know the caller: the token is missing, unknown or over. Also ends the streams of a token that
    was withdrawn."""


class PermissionDenied(Error):
    """The token does not allow the call, or does not reach the sheet."""


class Unavailable(Error):
    """No server answers, or the server is stopping, or it has no renderer."""


class DeadlineExceeded(Error):
    """The client's own time limit ran out. A cut may still have been made; a repeat with the same request_id gets its
    answer."""


class DataLoss(Error):
    """The data received is faulty: a damaged recording, or a frame that does not follow those before it."""


class Internal(Error):
    """A fault of the server."""


_CLASSES: dict[str, type[Error]] = {
    "INVALID_ARGUMENT": InvalidArgument,
    "NOT_FOUND": NotFound,
    "ALREADY_EXISTS": AlreadyExists,
    "RESOURCE_EXHAUSTED": ResourceExhausted,
    "FAILED_PRECONDITION": FailedPrecondition,
    "UNAUTHENTICATED": Unauthenticated,
    "PERMISSION_DENIED": PermissionDenied,
    "UNAVAILABLE": Unavailable,
    "DEADLINE_EXCEEDED": DeadlineExceeded,
    "DATA_LOSS": DataLoss,
    "INTERNAL": Internal,
}


def error_of(failure: Any, address: str) -> Error:
    """Returns the error for a failed call, with the reason, field and delay from its details. failure: grpc.RpcError of
    a blocking or asyncio channel."""
    code: str = failure.code().name
    message: str = failure.details() or ""
    reason = field = ""
    metadata: Mapping[str, str] = {}
    retry_after_s: Optional[float] = None
    for key, value in failure.trailing_metadata() or ():
        if key != "grpc-status-details-bin":
            continue
        for detail in status_pb2.Status.FromString(value).details:
            info, request = error_details_pb2.ErrorInfo(), error_details_pb2.BadRequest()
            retry = error_details_pb2.RetryInfo()
            if detail.Unpack(info):
                reason, metadata = info.reason, info.metadata
            elif detail.Unpack(request) and request.field_violations:
                field = request.field_violations[0].field
            elif detail.Unpack(retry):
                retry_after_s = retry.retry_delay.ToNanoseconds() / 1e9
    if code == "RESOURCE_EXHAUSTED" and "larger than max" in message:  # gRPC's own words
        reason = "MESSAGE_TOO_LARGE"
        message += ": send less in one call, for example a batch of cuts in parts, or a mesh file as an upload"
    if code == "UNAVAILABLE" and not reason:
        if "SSL_ERROR_SSL" in message or "is not in peer certificate" in message:  # gRPC's own words
            reason = "TLS_FAILED"
            message = (
                "TLS with the server failed: its certificate is of another authority or for another name, or it has no "
                f"TLS ({message})"
            )
        elif any(words in message for words in ("Socket closed", "reset by peer", "Broken pipe")):
            message += "; a server that asks for TLS, or for a certificate, closes connections like this"
    if reason == "TOKEN_MISSING":
        message += "; give it to connect() as token_file, or name its file in KERF_TOKEN_FILE"
    if code == "UNIMPLEMENTED" and not reason:
        message = f"the Kerf server at {address} has no such call: it is older than this package; {message}"
    if code == "UNAVAILABLE" and not reason:
        return no_server(address, message)
    return _CLASSES.get(code, Error)(code, reason, message, field, metadata=metadata, retry_after_s=retry_after_s)


def no_server(address: str, why: str) -> Unavailable:
    message = f"no Kerf server answers at {address}: start one with deploy/run, or name another ({why})"
    return Unavailable("UNAVAILABLE", "", message)


def connection_closed(address: str) -> Error:
    """Returns the error of a stream whose connection this side has closed."""
    return Error("CANCELLED", "", f"the connection to {address} was closed")


def cut_off(address: str) -> Unavailable:
    """Returns the error of a stream that the server broke off because it could not write, not even the reason."""
    return Unavailable("UNAVAILABLE", "TOO_SLOW", f"the server at {address} ended the stream: it was not read in time")


def is_cancelled(failure: Any) -> bool:
    """Returns True if a call failed because one of its sides broke it off."""
    return bool(failure.code() == grpc.StatusCode.CANCELLED)


def is_out_of_time(failure: Any) -> bool:
    """Returns True if a call failed because its time limit ran out."""
    return bool(failure.code() == grpc.StatusCode.DEADLINE_EXCEEDED)
