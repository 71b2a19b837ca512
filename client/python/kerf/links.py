"""Links that open the viewer."""

from __future__ import annotations

from typing import Any

from kerf.v1 import access_service_pb2

_SCOPES = {"view": access_service_pb2.SCOPE_VIEW, "cut": access_service_pb2.SCOPE_CUT, "admin": access_service_pb2.SCOPE_ADMIN}


def scope_value(scope: str) -> Any:
    if scope not in _SCOPES:
        raise ValueError(f"scope is {scope!r}; must be one of {', '.join(_SCOPES)}")
    return _SCOPES[scope]
