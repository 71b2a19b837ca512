"""Makes kerf.v1.StepSheetsRequest, and reads its answers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import List, Optional

from kerf.arrays import State, state_of
from kerf.errors import FailedPrecondition
from kerf.probes import AnyProbe, Values, as_probes, values_of
from kerf.v1 import sheets_pb2


@dataclass(frozen=True)
class Stepped:
    """A sheet after the ticks of Sheet.step(state=True) or Server.step().

    >>> sheet.step(10, state=True).state.positions.shape
    (400, 3)
    """

    tick: int  # ticks done
    topology_version: int  # grows by one with each cut, undo and reset
    state: Optional[State]  # None: not requested
    probes: Optional[Values]  # None: not requested
    failure: str  # text for people: why the sheet ended early; empty if it did not


def steps_request(
    names: List[str], ticks: int, state: bool, probes: Iterable[AnyProbe]
) -> sheets_pb2.StepSheetsRequest:
    return sheets_pb2.StepSheetsRequest(names=names, ticks=ticks, states=state, probes=as_probes(probes))


def stepped_of(reply: sheets_pb2.StepSheetsResponse) -> List[Stepped]:
    columns = list(reply.probe_columns)
    return [
        Stepped(
            each.tick,
            each.topology_version,
            state_of(each.state) if each.HasField("state") else None,
            values_of(columns, each.probe_values) if columns else None,
            each.failure,
        )
        for each in reply.sheets
    ]


def one_stepped(reply: sheets_pb2.StepSheetsResponse) -> Stepped:
    """Returns the only sheet. Raises FailedPrecondition if it failed, as StepSheet does."""
    (stepped,) = stepped_of(reply)
    if stepped.failure:
        raise FailedPrecondition("FAILED_PRECONDITION", "SHEET_FROZEN", stepped.failure)
    return stepped
