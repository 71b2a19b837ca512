"""Makes kerf.v1.AnalyzeSheetRequest from the arguments of Sheet.analyze()."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Optional

from google.protobuf import json_format

from kerf.v1 import sheets_pb2


def analyze_request(
    name: str,
    modes: int,
    about_equilibrium: bool,
    ticks: Optional[int],
    measure_every: int,
    request: Optional[Mapping[str, Any]],
) -> sheets_pb2.AnalyzeSheetRequest:
    """Raises ValueError if two analyses are requested, or if `request` is not an AnalyzeSheetRequest."""
    if ticks is not None and modes:
        raise ValueError("give either ticks, or modes")
    if request is not None and (modes or about_equilibrium or (ticks is not None and "analysis" in request)):
        raise ValueError("give the analysis either in the request, or beside it")
    try:
        message = json_format.ParseDict(dict(request or {}), sheets_pb2.AnalyzeSheetRequest())
    except json_format.ParseError as wrong:
        raise ValueError(f"request: {wrong}") from None
    if ticks is not None:
        message.analysis.dynamic.ticks = ticks
        message.analysis.dynamic.measure_every = measure_every
    elif modes:
        message.analysis.modes.count = modes
        if about_equilibrium:
            message.analysis.modes.about.SetInParent()
    elif request is None:
        message.analysis.static.SetInParent()
    message.name = name
    return message
