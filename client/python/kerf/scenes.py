"""Scenes: what sheets are made from, as kerf.v1.Scene."""

from __future__ import annotations

import json
import operator
import os
import pathlib
from collections.abc import Iterable, Mapping
from typing import Any, Literal, Tuple, TypedDict, Union

from google.protobuf import json_format

from kerf.files import CHUNK_BYTES, text_of, unpacked
from kerf.regions import Place, as_regions
from kerf.v1 import scene_pb2

AnyScene = Union[scene_pb2.Scene, Mapping[str, Any], str, "os.PathLike[str]"]
# A preset, the JSON form of kerf.v1.Material as a dict, or the message.
AnyMaterial = Union[str, Mapping[str, Any], scene_pb2.Material]
Part = Tuple[Tuple[float, float, float, float], AnyMaterial]

_REST_SHAPES = {
    "auto": scene_pb2.REST_SHAPE_UNSPECIFIED,
    "flat": scene_pb2.REST_SHAPE_FLAT,
    "surface": scene_pb2.REST_SHAPE_SURFACE,
}

_UP_AXES = {
    "z": scene_pb2.MeshReading.Z_UP,
    "y": scene_pb2.MeshReading.Y_UP,
    "x": scene_pb2.MeshReading.X_UP,
}


class SheetOptions(TypedDict, total=False):
    """Holds the options of Server.create_sheet(); those left out have their defaults."""

    grid: Tuple[int, int]  # columns and rows of vertices; default (50, 50)
    size_m: Tuple[float, float]  # width and height, metres; default (1, 1)
    mesh_file: "Union[str, os.PathLike[str]]"  # .obj or .ply; replaces grid and size_m
    # The rest shape of a mesh file: "flat" (its texture coordinates, or its plane), "surface" (its positions, curved
    # as they are), or "auto", the default: flat where the file allows it.
    rest: Literal["auto", "flat", "surface"]
    unit_m: float  # metres of a unit of the mesh file, such as 1e-3 for millimetres; default 1
    up: Literal["x", "y", "z"]  # the axis of the mesh file that points up in the world; default "z"
    objects: Iterable[str]  # objects and groups of an OBJ file that are read; default: all
    # Joins vertices of the mesh file at most this far apart, and to sides of other faces, metres; 0 joins none. Default:
    # those that agree as exactly as the file is written.
    join_m: float
    ignore_texture: bool  # reads the mesh file as if it had no texture coordinates
    pins: Iterable[Place]  # default ["top"]
    material: AnyMaterial  # a preset listed by Server.info(), or numbers, {"youngs_modulus_pa": 1e6}
    # Parts of other materials, each a box (x0, y0, x1, y1) in metres on the undeformed sheet and a material. Where
    # parts overlap, the later one counts.
    parts: Iterable[Part]
    paused: bool  # the sheet is created paused; default False


def scene_with(options: SheetOptions) -> scene_pb2.Scene:
    """Makes a scene. Raises TypeError for an unknown option, ValueError for a value that its option cannot have."""
    unknown = options.keys() - SheetOptions.__annotations__.keys()
    if unknown:
        raise TypeError(f"a sheet has no option {min(unknown)!r}; there are {', '.join(SheetOptions.__annotations__)}")
    scene = scene_pb2.Scene(
        pins=as_regions(options.get("pins", ["top"])),
        material=as_material(options.get("material", "")),
    )
    for (x0, y0, x1, y1), material in options.get("parts", ()):
        part = scene.materials.add(material=as_material(material))
        part.region.box.min.x, part.region.box.min.y = x0, y0
        part.region.box.max.x, part.region.box.max.y = x1, y1
    if "mesh_file" in options:
        _add_mesh_file(scene, pathlib.Path(options["mesh_file"]), options)
    else:
        scene.grid.CopyFrom(_grid_of(options.get("grid", (50, 50)), options.get("size_m", (1.0, 1.0))))
    return scene


def _grid_of(grid: Any, size_m: Any) -> scene_pb2.GridMesh:
    try:
        columns, rows = (operator.index(count) for count in grid)
    except (TypeError, ValueError):
        raise ValueError(f"grid is {grid!r}; must be columns and rows, two whole numbers") from None
    try:
        width, height = (float(side) for side in size_m)
    except (TypeError, ValueError):
        raise ValueError(f"size_m is {size_m!r}; must be width and height, two numbers") from None
    return scene_pb2.GridMesh(columns=columns, rows=rows, width_m=width, height_m=height)


def as_material(material: AnyMaterial) -> scene_pb2.Material:
    """Converts a preset or dict to the message. Raises ValueError if the dict is no material.

    >>> as_material({"youngs_modulus_pa": 1e6}).youngs_modulus_pa
    1000000.0
    """
    if isinstance(material, scene_pb2.Material):
        return material
    if isinstance(material, str):
        return scene_pb2.Material(preset=material)
    try:
        return json_format.ParseDict(dict(material), scene_pb2.Material())
    except json_format.ParseError as wrong:
        raise ValueError(f"material: {wrong}") from None


def as_scene(scene: AnyScene) -> scene_pb2.Scene:
    """Converts a message, its JSON form, or the path of a scene file. Raises ValueError if the JSON is no scene; OSError."""
    if isinstance(scene, scene_pb2.Scene):
        return scene
    try:
        if isinstance(scene, Mapping):
            return json_format.ParseDict(scene, scene_pb2.Scene())
        return json_format.Parse(pathlib.Path(scene).read_text(encoding="utf-8-sig"), scene_pb2.Scene())
    except (json_format.ParseError, json.JSONDecodeError) as wrong:
        name = "scene" if isinstance(scene, Mapping) else os.fspath(scene)
        raise ValueError(f"{name}: {wrong}") from None


def take_large_mesh(scene: scene_pb2.Scene) -> bytes:
    """Removes the mesh file from a scene and returns it if it is too large for one message; else returns nothing."""
    if len(scene.ply.data) > CHUNK_BYTES:
        content = scene.ply.data
        scene.ply.ClearField("data")
        return content
    if len(scene.obj.text) > CHUNK_BYTES:
        content = scene.obj.text.encode("utf-8")
        scene.obj.ClearField("text")
        return content
    return b""


def _add_mesh_file(scene: scene_pb2.Scene, file: pathlib.Path, options: SheetOptions) -> None:
    rest, up = options.get("rest", "auto"), options.get("up", "z")
    if rest not in _REST_SHAPES:
        raise ValueError(f"rest is {rest!r}; must be one of {', '.join(_REST_SHAPES)}")
    if up not in _UP_AXES:
        raise ValueError(f"up is {up!r}; must be one of {', '.join(_UP_AXES)}")
    mesh: "scene_pb2.PlyMesh | scene_pb2.ObjMesh"
    kind = file.with_suffix("").suffix.lower() if file.suffix.lower() == ".gz" else file.suffix.lower()
    if kind == ".ply":
        scene.ply.data = unpacked(file)
        mesh = scene.ply
    elif kind == ".obj":
        scene.obj.text = text_of(unpacked(file))
        mesh = scene.obj
    else:
        raise ValueError(f"{file}: the name of a mesh file ends in .obj or .ply, with .gz after it if it is compressed")
    mesh.rest_shape = _REST_SHAPES[rest]
    mesh.reading.up_axis = _UP_AXES[up]
    mesh.reading.unit_m = options.get("unit_m", 1.0)
    mesh.reading.objects.extend(options.get("objects", ()))
    mesh.reading.ignore_texture_coordinates = options.get("ignore_texture", False)
    if "join_m" in options:
        mesh.reading.join_m = options["join_m"]
