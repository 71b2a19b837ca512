"""Probes: what is measured on a sheet, and the values that come back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, List, Literal, Optional, Union

from google.protobuf import json_format

from kerf.arrays import numpy_module
from kerf.curves import Point, is_point, rows_of, vec2
from kerf.cuts import enum_value
from kerf.regions import Place, as_region
from kerf.v1 import analysis_pb2

if TYPE_CHECKING:
    from kerf.arrays import Floats

Quantity = Literal[
    "displacement",
    "position",
    "velocity",
    "reaction",
    "strain",
    "stress",
    "energy",
    "momentum",
    "angular_momentum",
    "centre_of_mass",
    "opening",
    "extent",
    "intersections",
]
# A probe made by probe(), or kerf.v1.Probe as a mapping.
AnyProbe = Union[analysis_pb2.Probe, Mapping[str, Any]]


def probe(
    name: str,
    quantity: Quantity,
    *,
    points: Optional[Any] = None,
    place: Optional[Place] = None,
    reduce: Optional[Literal["each", "mean", "sum", "min", "max"]] = None,
    side: Optional[Point] = None,
    recovery: Literal["of_triangles", "patch"] = "of_triangles",
    stress_measure: Literal["biot", "cauchy"] = "biot",
) -> analysis_pb2.Probe:
    """Returns a probe for Sheet.watch(), step(), measure() and Server.step().

    name: lower case letters, digits and underscores; the values are called "name.x" and so on. points: one point or
    several, metres in material coordinates, as tuples or an array of shape (n, 2). place: the name of an edge or a
    region; "reaction" needs one. Quantities of the whole sheet, such as "energy", take neither. reduce: how several
    places become one value; None: each point by itself, the mean of a place, the sum of reactions. side: measures on the
    side of a cut on which this point is. recovery, stress_measure: of strain and stress, see
    proto/kerf/v1/analysis.proto, which also has all units.

    >>> tip = probe("tip", "position", points=(0.5, 0.0))
    >>> sheet.measure([tip, probe("all", "energy")]).columns[:4]
    ['tip.x', 'tip.y', 'tip.z', 'all.kinetic']
    """
    message = analysis_pb2.Probe(name=name, quantity=enum_value(analysis_pb2.Probe.Quantity, "quantity", quantity))
    if points is not None:
        message.points.extend(vec2(point) for point in rows_of(([points] if is_point(points) else points,), 2))
    if place is not None:
        message.region.CopyFrom(as_region(place))
    if reduce is not None:
        message.reduce = enum_value(analysis_pb2.Probe.Reduce, "reduce", reduce)
    if side is not None:
        message.side.CopyFrom(vec2(side))
    if recovery != "of_triangles":
        message.recovery = enum_value(analysis_pb2.Probe.Recovery, "recovery", recovery)
    if stress_measure != "biot":
        message.stress_measure = enum_value(analysis_pb2.Probe.StressMeasure, "stress_measure", stress_measure)
    return message


def as_probes(probes: Iterable[AnyProbe]) -> List[analysis_pb2.Probe]:
    """Converts probes to messages. Raises TypeError if one is no probe, ValueError if a mapping is not a kerf.v1.Probe."""
    if isinstance(probes, (str, Mapping, analysis_pb2.Probe)):
        raise TypeError("give a list of probes")
    return [_as_probe(each) for each in probes]


def _as_probe(given: AnyProbe) -> analysis_pb2.Probe:
    if isinstance(given, analysis_pb2.Probe):
        return given
    if not isinstance(given, Mapping):
        raise TypeError(f"a probe is made by kerf.probe(), or is a mapping, not {type(given).__name__}")
    try:
        return json_format.ParseDict(dict(given), analysis_pb2.Probe())
    except json_format.ParseError as wrong:
        raise ValueError(f"probe: {wrong}") from None


class Values(Mapping[str, Any]):
    """Values of probes at one tick, by name: a number for a column such as "tip.x", an array for all columns of a probe
    such as "tip". NaN where there was nothing to measure.

    >>> values = sheet.measure([probe("tip", "position", points=(0.5, 0.0))])
    >>> values["tip.y"], values["tip"].shape
    (0.0, (3,))
    """

    def __init__(self, columns: Sequence[str], values: Floats) -> None:
        self.columns = columns  # names of all values
        self.array = values  # the values, in the order of `columns`

    def __getitem__(self, name: str) -> Any:
        """Returns a number, or the array of a probe's numbers. Raises KeyError with the names of all columns."""
        if name in self.columns:
            return float(self.array[self.columns.index(name)])
        own = [number for number, column in enumerate(self.columns) if column.startswith((f"{name}.", f"{name}["))]
        if not own:
            raise KeyError(f"there is no probe {name!r}; there are {', '.join(self.columns)}")
        return self.array[own]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def __repr__(self) -> str:
        shown = [f"{column}={value:.6g}" for column, value in zip(self.columns[:8], self.array)]
        return f"Values({', '.join(shown)}{', ...' if len(self.columns) > 8 else ''})"


def values_of(columns: Sequence[str], values: Iterable[float]) -> Values:
    array = numpy_module().array(values, dtype="f8")
    array.setflags(write=False)
    return Values(columns, array)
