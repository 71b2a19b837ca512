"""What the server refuses, as exceptions: one class a gRPC status code."""

from __future__ import annotations

import grpc
from google.rpc import error_details_pb2, status_pb2


class Error(Exception):
    """A refusal. Nothing was changed.

    code: the status, "INVALID_ARGUMENT"; see the subclasses. reason: stable, for programs, "CURVE_NOT_FINITE"; empty where
    the server was not reached. message: for people, says what to do. field: path of the request's field at fault,
    "cut.curve.circle.radius_m"; may be empty.
    """

    def __init__(self, code: str, reason: str, message: str, field: str = "") -> None:
        where = f" [field: {field}]" if field else ""
        why = f"{code}, {reason}" if reason else code
        super().__init__(f"{message}{where} ({why})")
        self.code = code
        self.reason = reason
        self.message = message
        self.field = field


class InvalidArgument(Error):
    """Would never work, whatever the state."""


class NotFound(Error):
    """Names a sheet that does not exist."""


class AlreadyExists(Error):
    """Names a sheet that does."""


class ResourceExhausted(Error):
    """A limit, or a full queue: may work later."""


class FailedPrecondition(Error):
    """The right request in the wrong state: to step a running sheet, to undo where nothing was cut."""


class Unavailable(Error):
    """No server answers, it is going down, or it has no renderer."""


class DeadlineExceeded(Error):
    """The client's own time limit ran out. A cut may have been made all the same."""


class Internal(Error):
    """A fault of the server."""


_CLASSES: dict[str, type[Error]] = {
    "INVALID_ARGUMENT": InvalidArgument,
    "NOT_FOUND": NotFound,
    "ALREADY_EXISTS": AlreadyExists,
    "RESOURCE_EXHAUSTED": ResourceExhausted,
    "FAILED_PRECONDITION": FailedPrecondition,
    "UNAVAILABLE": Unavailable,
    "DEADLINE_EXCEEDED": DeadlineExceeded,
    "INTERNAL": Internal,
}


def error_of(failure: grpc.RpcError, address: str) -> Error:
    """The refusal that a failed call brought, with what its details say."""
    code: str = failure.code().name
    message: str = failure.details() or ""
    reason = field = ""
    for key, value in failure.trailing_metadata() or ():
        if key != "grpc-status-details-bin":
            continue
        for detail in status_pb2.Status.FromString(value).details:
            info, request = error_details_pb2.ErrorInfo(), error_details_pb2.BadRequest()
            if detail.Unpack(info):
                reason = info.reason
            elif detail.Unpack(request) and request.field_violations:
                field = request.field_violations[0].field
    if code == "UNAVAILABLE" and not reason:
        message = f"no Kerf server answers at {address}: {message}"
    return _CLASSES.get(code, Error)(code, reason, message, field)
