"""Runs: frames of a sheet in a file that NumPy reads."""

from __future__ import annotations

import errno
import json
import os
import zipfile
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Dict, List, Tuple, Union, overload

from kerf.arrays import numpy_module
from kerf.files import real_target
from kerf.frames import Frame

if TYPE_CHECKING:
    from kerf.arrays import Longs

_FORMAT = {"format": "kerf-run", "version": 1}
_CHUNK_BYTES = 8 << 20  # bytes of positions kept in memory before they are written


class RunWriter:
    """Writes frames to an .npz file as they come, with at most some 8 MiB of them in memory. The file exists, complete,
    when close() returns; until then the data is in FILE.part.

    The file's arrays: `meta` is JSON as bytes; `ticks` has the ticks of the N frames. Topology number K has
    `triangles_K` (T x 3), `pieces_K` (T) and `material_positions_K` (V x 2). Its frames are in chunks J:
    `positions_K_J` (frames x V x 3 float32, metres) and, if the frames had strains, `strains_K_J` (frames x V
    float32).
    """

    def __init__(self, path: "str | os.PathLike[str]") -> None:
        self._path = real_target(path)
        if self._path.exists() and not self._path.is_file():
            raise OSError(errno.EINVAL, "a run must go to a regular file", str(self._path))
        self._part = self._path.with_name(self._path.name + ".part")
        # Not compressed: positions hardly get smaller, and the time is better spent on frames.
        self._file = zipfile.ZipFile(self._part, "w", zipfile.ZIP_STORED)
        self._ticks: List[int] = []
        self._chunks: List[Dict[str, int]] = []  # of each: its topology, its number there, its number of frames
        self._triangles: Any = None  # of the topology written last
        self._topologies: List[int] = []  # versions of the topologies
        self._waiting: List[Frame] = []

    def add(self, frame: Frame) -> None:
        """Adds a frame. Raises ValueError if its tick is before the tick of the frame added last, OSError if the disk
        is full."""
        if self._ticks and frame.tick < self._ticks[-1]:
            raise ValueError(f"the frame of tick {frame.tick} follows that of tick {self._ticks[-1]}")
        if frame.triangles is not self._triangles:
            self._flush()
            self._add_topology(frame)
        elif self._waiting and len(self._waiting) * frame.positions.nbytes > _CHUNK_BYTES:
            self._flush()
        self._ticks.append(frame.tick)
        self._waiting.append(frame)

    def close(self) -> None:
        """Ends the file and gives it its name. Idempotent."""
        if self._file.fp is None:
            return
        self._flush()
        meta = {**_FORMAT, "chunks": self._chunks, "topology_versions": self._topologies}
        self._write("meta", numpy_module().frombuffer(json.dumps(meta).encode(), dtype="u1"))
        self._write("ticks", numpy_module().array(self._ticks, dtype="i8"))
        self._file.close()
        self._part.replace(self._path)

    def discard(self) -> None:
        """Removes the unfinished file; an earlier file stays."""
        self._file.close()
        self._part.unlink(missing_ok=True)

    def _add_topology(self, frame: Frame) -> None:
        number = len(self._topologies)
        self._topologies.append(frame.topology_version)
        self._triangles = frame.triangles
        self._write(f"triangles_{number}", frame.triangles)
        self._write(f"pieces_{number}", frame.pieces)
        self._write(f"material_positions_{number}", frame.material_positions)

    def _flush(self) -> None:
        if not self._waiting:
            return
        numpy, topology = numpy_module(), len(self._topologies) - 1
        chunk = sum(each["topology"] == topology for each in self._chunks)
        self._chunks.append({"topology": topology, "chunk": chunk, "frames": len(self._waiting)})
        positions = numpy.stack([frame.positions for frame in self._waiting]).astype("f4")
        self._write(f"positions_{topology}_{chunk}", positions)
        if all(frame.strains is not None for frame in self._waiting):
            self._write(f"strains_{topology}_{chunk}", numpy.stack([frame.strains for frame in self._waiting]))
        self._waiting = []

    def _write(self, name: str, array: Any) -> None:
        with self._file.open(name + ".npy", "w", force_zip64=True) as entry:
            numpy_module().lib.format.write_array(entry, array)


class Run(Sequence[Frame]):
    """The frames of a file written by Sheet.recorder(), by number. A frame is read when it is accessed.

    >>> run = load_run(path)
    >>> len(run) == len(run.ticks), run[-1].tick == run.ticks[-1]
    (True, True)
    """

    def __init__(self, arrays: Any, path: str) -> None:
        self._arrays = arrays
        meta = json.loads(bytes(arrays["meta"]))
        if meta.get("format") != _FORMAT["format"]:
            raise ValueError(f"{path}: is not a run of kerf")
        if meta["version"] != _FORMAT["version"]:
            raise ValueError(f"{path}: is of version {meta['version']}; this package reads {_FORMAT['version']}")
        self.ticks: Longs = arrays["ticks"]  # N, ticks of the frames; other ticks were not recorded
        self.topology_versions: List[int] = meta["topology_versions"]  # versions of all topologies, in order
        self._frames: List[Tuple[int, int, int]] = [
            (chunk["topology"], chunk["chunk"], row) for chunk in meta["chunks"] for row in range(chunk["frames"])
        ]
        self._kept: Dict[str, Any] = {}  # arrays of the chunk and the topology read last

    def __len__(self) -> int:
        return len(self._frames)

    def __repr__(self) -> str:
        span = f", ticks {self.ticks[0]}..{self.ticks[-1]}" if len(self) else ""
        return f"<kerf.Run of {len(self)} frames{span}>"

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> List[Frame]: ...
    def __getitem__(self, index: Union[int, slice]) -> Union[Frame, List[Frame]]:
        """Returns a frame, or a list of frames for a slice. Raises IndexError."""
        if isinstance(index, slice):
            return [self[each] for each in range(*index.indices(len(self)))]
        number = range(len(self))[index]
        topology, chunk, row = self._frames[number]
        strains = f"strains_{topology}_{chunk}"
        return Frame(
            int(self.ticks[number]),
            self.topology_versions[topology],
            self._read(f"positions_{topology}_{chunk}")[row].astype("f8"),
            self._read(f"triangles_{topology}"),
            self._read(f"pieces_{topology}"),
            self._read(f"material_positions_{topology}"),
            self._read(strains)[row] if strains in self._arrays else None,
            number == 0 or self._frames[number - 1][0] != topology,
            None,
            None,
        )

    def __iter__(self) -> Iterator[Frame]:
        return (self[number] for number in range(len(self)))

    def close(self) -> None:
        """Closes the file; frames already read stay valid."""
        self._arrays.close()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _read(self, name: str) -> Any:
        if name not in self._kept:
            # Keeps one chunk at a time, because a long run may not fit into memory.
            kind = name.partition("_")[0]
            self._kept = {kept: array for kept, array in self._kept.items() if kept.partition("_")[0] != kind}
            self._kept[name] = self._arrays[name]
            self._kept[name].setflags(write=False)
        return self._kept[name]


def load_run(path: "str | os.PathLike[str]") -> Run:
    """Loads a file written by Sheet.recorder(). Raises ValueError if the file is something else, OSError if it cannot
    be read."""
    name = os.fspath(path)
    try:
        return Run(numpy_module().load(name, allow_pickle=False), name)
    except (zipfile.BadZipFile, KeyError, IndexError, TypeError, json.JSONDecodeError) as wrong:
        raise ValueError(f"{name}: is not a run of kerf ({wrong})") from None
