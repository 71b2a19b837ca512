"""NumPy arrays of what the server sends. NumPy is imported when the first array is made, so that all else works without
it."""

from __future__ import annotations

import html
import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, List, Optional

from kerf.notebooks import Pictured
from kerf.v1 import analysis_pb2, sheets_pb2

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

    Floats = NDArray[numpy.float64]
    Float32s = NDArray[numpy.float32]
    Ints = NDArray[numpy.int32]
    Longs = NDArray[numpy.int64]
    Bytes = NDArray[numpy.uint8]


def needed(module: str, package: str) -> Any:
    """Imports a module that only some calls need. If it is missing, raises ImportError with the name of the Debian
    package."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        raise ImportError(f"this call needs {module} ({missing}): apt install {package}") from None


def numpy_module() -> Any:
    return needed("numpy", "python3-numpy")


def packed(content: bytes, kind: str, columns: int) -> Any:
    """Returns a packed array as N x columns, or N if columns is 1. It is a read-only view without a copy. kind: NumPy's
    type, such as "<f8"."""
    flat = numpy_module().frombuffer(content, dtype=kind)
    return flat if columns == 1 else flat.reshape(-1, columns)


@dataclass(frozen=True, repr=False)
class State(Pictured):
    """The exact state of a sheet with V vertices and T triangles after a tick, in the solver's 64-bit floats.

    >>> sheet.state().positions.shape
    (400, 3)
    """

    tick: int
    topology_version: int  # grows by one with each cut, undo and reset
    state_hash: str  # 16 hex digits; equal for equal states
    positions: Floats  # V x 3, metres, world
    velocities: Floats  # V x 3, metres/second
    material_positions: Floats  # V x 2, metres, on the undeformed sheet
    triangles: Ints  # T x 3, vertex ids, counter-clockwise in material coordinates
    pieces: Ints  # T, the label of each triangle's piece: Piece.id of Sheet.pieces()


def state_of(reply: sheets_pb2.SheetState) -> State:
    slots = packed(reply.triangles, "<i4", 3)
    has_material = slots[:, 0] >= 0
    return State(
        reply.tick,
        reply.topology_version,
        reply.state_hash,
        packed(reply.positions, "<f8", 3),
        packed(reply.velocities, "<f8", 3),
        packed(reply.material_positions, "<f8", 2),
        slots[has_material],
        packed(reply.pieces, "<i4", 1)[has_material],
    )


@dataclass(frozen=True, repr=False)
class Table:
    """Numbers over time or load, one row for each moment. NaN where there was nothing to measure.

    >>> table = Table("modes", ["mode", "frequency_hz"], numpy.array([[1, 2.5], [2, 4.0]]))
    >>> table["frequency_hz"].tolist()
    [2.5, 4.0]
    >>> table["frequency"]
    Traceback (most recent call last):
    KeyError: "table 'modes' has no column 'frequency'; there are mode, frequency_hz"
    """

    name: str  # "probes" or "modes"
    columns: List[str]  # the first is "time_s", "load" or "mode"; those of a probe are "name.x" and so on
    values: Floats  # rows x columns

    def __repr__(self) -> str:
        columns = ", ".join(self.columns[:8]) + (", ..." if len(self.columns) > 8 else "")
        return f"Table({self.name!r}, {len(self.values)} rows: {columns})"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{html.escape(column)}</th>" for column in self.columns)
        rows = "".join(f"<tr>{''.join(f'<td>{number:.6g}</td>' for number in row)}</tr>" for row in self.values[:20])
        more = f"<p>{len(self.values) - 20} more rows</p>" if len(self.values) > 20 else ""
        return f"<table><tr>{head}</tr>{rows}</table>{more}"

    def __getitem__(self, column: str) -> Floats:
        """Returns one column. Raises KeyError with the names of all columns."""
        if column not in self.columns:
            raise KeyError(f"table {self.name!r} has no column {column!r}; there are {', '.join(self.columns)}")
        return self.values[:, self.columns.index(column)]


@dataclass(frozen=True, repr=False)
class Analysis:
    """Holds the results of Sheet.analyze(), for a copy of the sheet."""

    tick: int  # of the sheet when it was copied
    topology_version: int  # of the sheet when it was copied
    tables: Dict[str, Table]  # by name: "probes" if there were some, and "modes"
    static: Optional[analysis_pb2.StaticResult]  # result of an equilibrium analysis
    dynamic: Optional[analysis_pb2.DynamicResult]  # result of `ticks`
    positions: Optional[Floats]  # V x 3, metres; None unless requested

    def __repr__(self) -> str:
        parts = [repr(table) for table in self.tables.values()]
        if self.static is not None:
            parts.append("static, converged" if self.static.converged else "static, not converged")
        if self.dynamic is not None:
            parts.append(f"dynamic, {self.dynamic.ticks} ticks")
        return f"Analysis(tick {self.tick}: {'; '.join(parts)})"


def analysis_of(reply: sheets_pb2.AnalyzeSheetResponse) -> Analysis:
    return Analysis(
        reply.tick,
        reply.topology_version,
        {table.name: _table_of(table) for table in reply.tables},
        reply.static if reply.HasField("static") else None,
        reply.dynamic if reply.HasField("dynamic") else None,
        packed(reply.positions, "<f8", 3) if reply.positions else None,
    )


def _table_of(table: analysis_pb2.Table) -> Table:
    rows: Sequence[Sequence[float]] = [row.values for row in table.rows]
    columns = list(table.columns)
    values = numpy_module().array(rows, dtype="f8").reshape(len(rows), len(columns))
    return Table(table.name, columns, values)
