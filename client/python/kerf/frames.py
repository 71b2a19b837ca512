"""Frames of a live sheet as NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, List, Optional

from kerf.arrays import numpy_module, packed
from kerf.errors import DataLoss
from kerf.notebooks import Pictured
from kerf.probes import Values, values_of
from kerf.v1 import stream_pb2

if TYPE_CHECKING:
    from kerf.arrays import Float32s, Floats, Ints


@dataclass(frozen=True, repr=False)
class Frame(Pictured):
    """A sheet of V vertices and T triangles after one tick. The arrays are read-only; triangles, pieces and material
    positions are the same objects in all frames until the topology changes.

    >>> frame = next(sheet.watch())
    >>> frame.positions.shape, frame.triangles.shape
    ((400, 3), (722, 3))
    """

    tick: int
    topology_version: int  # grows by one with each cut, undo and reset
    positions: Floats  # V x 3, metres, world, rounded to `resolution`; Sheet.state() has them exactly
    triangles: Ints  # T x 3, vertex ids, counter-clockwise in material coordinates
    pieces: Ints  # T, the label of each triangle's piece: Piece.id of Sheet.pieces()
    material_positions: Float32s  # V x 2, metres, on the undeformed sheet
    strains: Optional[Float32s]  # V, principal strains of the largest magnitude, 0.01: 1 % longer; None: not requested
    topology_changed: bool  # True if it changed since the frame before on this stream, and in the first frame
    resolution: Optional[Floats]  # 3, metres: distance of neighbouring coordinates along x, y, z; None in a loaded run
    stats: Optional[stream_pb2.FrameStats]  # see proto/kerf/v1/stream.proto; None in a loaded run
    probes: Optional[Values] = None  # values of watch(probes=); None: not requested


class FrameDecoder:
    """Converts the raw frames of one stream to arrays, in the order of the stream."""

    def __init__(self) -> None:
        self.epoch = ""
        self.topology_version = -1
        self._sequence = 0
        self._slots: Any = None  # S x 3 int32, -1 without material
        self._slot_pieces: Any = None  # S int32
        self._materials: Any = None  # V x 2 float32
        self._triangles: Any = None
        self._pieces: Any = None
        self._columns: List[str] = []  # names of the values of probes

    def begin_stream(self) -> None:
        """Expects the first frame of a new stream, whose start named epoch and topology_version."""
        self._sequence = 0
        self._columns = []

    def decode(self, message: stream_pb2.Frame) -> Frame:
        """Converts one frame. Raises DataLoss if it does not follow the frame before, or if its arrays have the wrong
        size."""
        if message.sequence != self._sequence + 1:
            raise _unreadable(f"frame {message.sequence} follows frame {self._sequence}")
        if message.encoding != stream_pb2.RAW or message.base_tick >= 0:
            raise _unreadable("it is not raw")
        changed = message.HasField("topology")
        try:
            if changed:
                self._patch(message)
            elif message.topology_version != self.topology_version:
                raise _unreadable(f"topology {message.topology_version} comes without its patch")
            positions = packed(message.positions, "<u2", 3)
            if len(positions) != message.num_vertices or len(self._materials) != message.num_vertices:
                raise _unreadable(f"it has {len(positions)} positions of {message.num_vertices}")
            strains = self._strains(message)
            probes = self._probes(message)
        except (ValueError, IndexError) as wrong:
            raise _unreadable(str(wrong)) from None
        self._sequence = message.sequence
        self.topology_version = message.topology_version
        self.epoch = message.epoch or self.epoch
        low, resolution = _box(message)
        return Frame(
            message.tick,
            message.topology_version,
            _read_only(positions * resolution + low),
            self._triangles,
            self._pieces,
            self._materials,
            strains,
            changed,
            resolution,
            message.stats,
            probes,
        )

    def _patch(self, message: stream_pb2.Frame) -> None:
        numpy, patch = numpy_module(), message.topology
        full = patch.base_version < 0
        if not full and patch.base_version != self.topology_version:
            raise _unreadable(f"its patch is of topology {patch.base_version}, not {self.topology_version}")
        triangles, pieces = packed(patch.triangles, "<i4", 3), packed(patch.pieces, "<i4", 1)
        materials = packed(patch.material_positions, "<f4", 2)
        if full:
            self._slots, self._slot_pieces, self._materials = triangles, pieces, materials
        else:
            # Makes copies, because frames returned before keep their arrays.
            self._slots = _resized(self._slots, patch.num_slots, -1)
            self._slot_pieces = _resized(self._slot_pieces, patch.num_slots, -1)
            self._materials = _resized(self._materials, message.num_vertices, numpy.nan)
            slots = packed(patch.slots, "<u4", 1)
            self._slots[slots] = triangles
            self._slot_pieces[slots] = pieces
            self._materials[packed(patch.vertices, "<u4", 1)] = materials
        if len(self._slots) != patch.num_slots or len(self._slot_pieces) != patch.num_slots:
            raise _unreadable(f"its patch has {len(self._slots)} slots of {patch.num_slots}")
        has_material = self._slots[:, 0] >= 0
        self._triangles = _read_only(self._slots[has_material])
        self._pieces = _read_only(self._slot_pieces[has_material])
        if self._triangles.size and self._triangles.max() >= message.num_vertices:
            raise _unreadable(f"a triangle has vertex {self._triangles.max()} of {message.num_vertices}")
        self._materials = _read_only(self._materials)

    def _probes(self, message: stream_pb2.Frame) -> Optional[Values]:
        if message.probe_columns:
            self._columns = list(message.probe_columns)
        if len(message.probe_values) != len(self._columns):
            raise _unreadable(f"it has {len(message.probe_values)} values of {len(self._columns)} columns")
        return values_of(self._columns, message.probe_values) if self._columns else None

    def _strains(self, message: stream_pb2.Frame) -> Any:
        if message.strain_scale == 0:
            return None
        shares = packed(message.strains, "i1", 1).astype("f4") / 127
        if len(shares) != message.num_vertices:
            raise _unreadable(f"it has {len(shares)} strains of {message.num_vertices}")
        return _read_only(shares * abs(shares) * numpy_module().float32(message.strain_scale))


def _box(message: stream_pb2.Frame) -> Any:
    """Returns the lowest corner of the frame's box and the distance of neighbouring coordinates, 3 numbers each,
    metres."""
    low, high = (numpy_module().array([end.x, end.y, end.z]) for end in (message.box.min, message.box.max))
    return low, _read_only((high - low) / 65535)


def _resized(array: Any, rows: int, fill: float) -> Any:
    """Returns a copy with this number of rows, the new ones filled with `fill`. Rows are only added, because slots and
    vertices keep their numbers."""
    if rows < len(array):
        raise _unreadable(f"its patch leaves {rows} of {len(array)} rows")
    made = numpy_module().full((rows, *array.shape[1:]), fill, dtype=array.dtype)
    made[: len(array)] = array
    return made


def _read_only(array: Any) -> Any:
    array.setflags(write=False)
    return array


def _unreadable(why: str) -> DataLoss:
    return DataLoss("DATA_LOSS", "FRAME_MALFORMED", f"a frame of the stream cannot be read: {why}; watch the sheet again")
