"""Actions on a sheet: grabs, pins, gravity, wind, material, self-contact."""

from __future__ import annotations

import contextlib
import operator
import secrets
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any, Optional, SupportsIndex, Union, cast

from kerf.aio.part import SheetPart
from kerf.curves import Point, vec2
from kerf.cuts import Vector, vec3
from kerf.errors import NotFound
from kerf.regions import Place, as_regions
from kerf.scenes import AnyMaterial, as_material
from kerf.v1 import interaction_pb2, scene_pb2


class Interaction(SheetPart):
    """Acts on the sheet. Each method returns the tick at which it took effect."""

    async def grab(
        self, grab_id: str, point: Union[SupportsIndex, Point], target: Optional[Vector] = None, stiffness_npm: float = 0.0
    ) -> int:
        """Ties a vertex (int) or a material point by a spring to a target in the world, metres; absent: the point's
        present place.

        grab_id: 1..63 bytes, unique among the sheet's at most 64 grabs. stiffness_npm: newtons/metre, up to 1e6; 0:
        as stiff as is stable. holding() grabs for the time of a `with`.

        >>> tick = await sheet.grab("corner", 0, (0.0, 0.2, 0.1))
        >>> tick = await sheet.drag("corner", (0.0, 0.3, 0.1))
        >>> tick = await sheet.release("corner")
        """
        grab = scene_pb2.Grab(grab_id=grab_id, stiffness_npm=stiffness_npm)
        if isinstance(point, SupportsIndex) and not hasattr(point, "__len__"):
            grab.vertex = operator.index(point)
        else:
            grab.material.CopyFrom(vec2(cast(Point, point)))
        if target is not None:
            grab.target.CopyFrom(vec3(target))
        return await self._interact("GrabPoint", interaction_pb2.GrabPointRequest(name=self.name, grab=grab))

    async def drag(self, grab_id: str, target: Vector) -> int:
        """Moves the target of a grab. Raises NotFound: GRAB_NOT_FOUND."""
        drag = scene_pb2.Drag(grab_id=grab_id, target=vec3(target))
        return await self._interact("DragPoint", interaction_pb2.DragPointRequest(name=self.name, drag=drag))

    async def release(self, grab_id: str) -> int:
        """Ends a grab. Raises NotFound: GRAB_NOT_FOUND."""
        release = scene_pb2.Release(grab_id=grab_id)
        return await self._interact("ReleasePoint", interaction_pb2.ReleasePointRequest(name=self.name, release=release))

    @asynccontextmanager
    async def holding(
        self, point: Union[SupportsIndex, Point], target: Optional[Vector] = None, *, stiffness_npm: float = 0.0
    ) -> AsyncIterator[Hand]:
        """Returns a hand that holds a point as grab() does, until the `with` is left.

        >>> async with sheet.holding((0.5, 0.5)) as hand:
        ...     tick = await hand.move((0.5, 0.2, 0.6))
        """
        hand = Hand(self, f"hand-{secrets.token_hex(6)}")
        await self.grab(hand.grab_id, point, target, stiffness_npm)
        try:
            yield hand
        finally:
            with contextlib.suppress(NotFound):  # if a reset ended the grab, or the sheet was deleted
                await self.release(hand.grab_id)

    async def set_pins(self, pins: Iterable[Place]) -> int:
        """Replaces all pins; the vertices are held where they are now. Without places the sheet is free. At most 64
        places.

        Raises InvalidArgument: REGION_EMPTY if a place has no vertices; the pins then stay as they were.

        >>> tick = await sheet.set_pins(["left", kerf.box((0.9, 0.0), (1.0, 0.1)), kerf.vertices(7, 8)])
        """
        request = interaction_pb2.SetSheetPinsRequest(
            name=self.name, set_pins=scene_pb2.SetPins(pins=as_regions(pins))
        )
        return await self._interact("SetSheetPins", request)

    async def set_gravity(self, gravity_mps2: Vector) -> int:
        """Sets gravity: metres/second^2, of magnitude at most 1e4.

        >>> tick = await sheet.set_gravity((0, 0, -1.62))
        """
        gravity = scene_pb2.SetGravity(gravity_mps2=vec3(gravity_mps2))
        request = interaction_pb2.SetSheetGravityRequest(name=self.name, set_gravity=gravity)
        return await self._interact("SetSheetGravity", request)

    async def set_wind(self, wind: Optional[scene_pb2.Wind]) -> int:
        """Sets the air around the sheet, made by kerf.wind(); None: no air at all.

        >>> tick = await sheet.set_wind(kerf.wind((0, 5, 0)))
        """
        request = interaction_pb2.SetSheetWindRequest(name=self.name, set_wind=scene_pb2.SetWind(wind=wind))
        return await self._interact("SetSheetWind", request)

    async def set_material(self, material: AnyMaterial, *, part: Optional[int] = None) -> int:
        """Sets the material of all of the sheet or of one part: a preset, or numbers as a dict, whose absent values
        come from the dict's preset. Positions, cuts and the undo history stay; reset() restores the first material.

        part: index of a part that the sheet was made with; -1: the sheet outside all parts; None: all of it. Raises
        InvalidArgument: SHEET_TOO_STIFF, and FailedPrecondition: MATERIAL_SHARED if another part had the same
        material when the sheet was created.

        >>> tick = await sheet.set_material("rubber")
        >>> tick = await sheet.set_material({"preset": "rubber", "thickness_m": 5e-4})
        """
        change = scene_pb2.SetMaterial(material=as_material(material), part=part)
        request = interaction_pb2.SetSheetMaterialRequest(name=self.name, set_material=change)
        return await self._interact("SetSheetMaterial", request)

    async def set_self_contact(
        self,
        on: Optional[bool] = None,
        *,
        friction: Optional[float] = None,
        thickness_m: Optional[float] = None,
        material_thickness: bool = False,
    ) -> int:
        """Turns contact of the sheet with itself on or off, or changes its settings. None leaves a setting as it is;
        reset() restores the first ones.

        friction: Coulomb's coefficient, 0..10. thickness_m: distance that folds and pieces keep, metres,
        1e-6..0.1; at first the greatest thickness of the sheet's materials. material_thickness: returns to that, and
        excludes thickness_m. Raises FailedPrecondition: SELF_CONTACT_PLANAR if the sheet is planar.

        >>> tick = await sheet.set_self_contact(True, friction=0.5)
        >>> tick = await sheet.set_self_contact(False)
        """
        change = scene_pb2.SetSelfContact(
            friction=friction, thickness_m=thickness_m, material_thickness=material_thickness
        )
        if on is not None:
            change.mode = scene_pb2.SelfContact.ON if on else scene_pb2.SelfContact.OFF
        request = interaction_pb2.SetSheetSelfContactRequest(name=self.name, set_self_contact=change)
        return await self._interact("SetSheetSelfContact", request)

    async def _interact(self, method: str, request: Any) -> int:
        reply = await self._call(getattr(self._server.interaction_service, method), request)
        return int(reply.tick)


@dataclass(frozen=True)
class Hand:
    """A hand that holds a point of a sheet; made by Sheet.holding()."""

    sheet: Interaction
    grab_id: str

    async def move(self, target: Vector) -> int:
        """Moves the hand to a point of the world, metres. Returns the tick at which the move took effect."""
        return await self.sheet.drag(self.grab_id, target)
