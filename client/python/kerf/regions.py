"""Parts of a sheet, as kerf.v1.Region, to be pinned, held or measured. Metres in material coordinates."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import Any, List, Literal, Tuple, Union

from kerf.curves import Point, vec2
from kerf.cuts import Vector, enum_value, vec3
from kerf.v1 import conditions_pb2, geometry_pb2, scene_pb2

Edge = Literal["top", "bottom", "left", "right", "corners", "top_corners"]
# A name of an edge, or a region made by one of the functions here.
Place = Union[Edge, conditions_pb2.Region]


def edge(name: Edge) -> conditions_pb2.Region:
    """An edge of the sheet, or its corners.

    >>> edge("top_corners").edge == conditions_pb2.Region.TOP_CORNERS
    True
    """
    return conditions_pb2.Region(edge=enum_value(conditions_pb2.Region.Edge, "edge", name))


def box(low: Point, high: Point) -> conditions_pb2.Region:
    """All vertices in a closed box.

    >>> tick = sheet.set_pins([box((0, 0), (0.06, 0.06))])
    >>> list(sheet.get().pinned_vertices)
    [0, 1, 20, 21]
    """
    return conditions_pb2.Region(box=conditions_pb2.MaterialBox(min=vec2(low), max=vec2(high)))


def vertices(*ids: Any) -> conditions_pb2.Region:
    """The vertices with these ids, given one by one or as an array or list of them.

    >>> tick = sheet.set_pins([vertices(7, 8)])
    >>> list(sheet.get().pinned_vertices)
    [7, 8]
    """
    given = ids[0] if len(ids) == 1 and hasattr(ids[0], "__iter__") else ids
    return conditions_pb2.Region(vertices=conditions_pb2.VertexList(vertices=map(operator.index, given)))


def nearest(point: Point) -> conditions_pb2.Region:
    """The one vertex that is nearest to the point.

    >>> tick = sheet.set_pins([nearest((1, 1))])
    >>> list(sheet.get().pinned_vertices)
    [399]
    """
    return conditions_pb2.Region(nearest=vec2(point))


def along(curve: geometry_pb2.Curve, within: float = 0.0) -> conditions_pb2.Region:
    """All vertices closer to the curve than `within` metres, 0..1e4; 0: a twentieth of the edge length there.

    >>> tick = sheet.set_pins([along(kerf.polyline((0, 0), (1, 0)))])
    >>> len(sheet.get().pinned_vertices)
    20
    """
    return conditions_pb2.Region(curve=conditions_pb2.MaterialCurve(curve=curve, within_m=within))


def whole() -> conditions_pb2.Region:
    """The whole sheet.

    >>> tick = sheet.set_pins([whole()])
    >>> len(sheet.get().pinned_vertices)
    400
    """
    return conditions_pb2.Region(all=True)


def of_component(name: str, place: Place) -> conditions_pb2.Region:
    """A part of one component of the scene, in its own coordinates.

    >>> of_component("ribbon", "left").component
    'ribbon'
    """
    region = conditions_pb2.Region()
    region.CopyFrom(as_region(place))
    region.component = name
    return region


def as_regions(places: Iterable[Place]) -> List[conditions_pb2.Region]:
    """Converts places to regions. Raises TypeError if one is neither text nor region, ValueError if no edge has this
    name."""
    if isinstance(places, (str, conditions_pb2.Region)):
        raise TypeError(f"give a list of places: [{places!r}]")
    return [as_region(place) for place in places]


def as_region(place: Place) -> conditions_pb2.Region:
    """Converts a place to a region. Raises as as_regions() does."""
    if isinstance(place, str):
        return edge(place)
    if not isinstance(place, conditions_pb2.Region):
        raise TypeError(f"a place is the name of an edge or a region such as kerf.box(), not {type(place).__name__}")
    return place


def wind(velocity: Vector, *, air_density: float = 0.0, drag: float = 0.0) -> scene_pb2.Wind:
    """Returns moving air, for Sheet.set_wind(). velocity: metres/second, of magnitude at most 1000; air_density:
    kg/m^3, 0..100, 0: 1.2; drag: coefficient, 0..10, 0: 1.

    >>> wind((3, 0, 0)).velocity_mps.x
    3.0
    """
    return scene_pb2.Wind(velocity_mps=vec3(velocity), air_density_kgpm3=air_density, drag_coefficient=drag)
