"""Files that appear whole or not at all."""

from __future__ import annotations

import codecs
import contextlib
import gzip
import io
import os
import pathlib
import zlib
from collections.abc import Iterator
from typing import IO


@contextlib.contextmanager
def whole_file(path: "str | os.PathLike[str]") -> Iterator[IO[bytes]]:
    """Opens a file for writing as FILE.part, which gets its name when the `with` is left without an exception. A device
    or pipe is written to directly."""
    target = real_target(path)
    if target.exists() and not target.is_file():
        with open(target, "wb") as device:
            yield device
        return
    part = target.with_name(target.name + ".part")
    try:
        with open(part, "wb") as file:
            yield file
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def real_target(path: "str | os.PathLike[str]") -> pathlib.Path:
    """Returns the target of a link, so that the link is kept."""
    return pathlib.Path(os.path.realpath(path) if os.path.islink(path) else path)


def text_of(content: bytes) -> str:
    """Decodes a text file: UTF-8 or UTF-16 by its byte order mark, else UTF-8, else ISO-8859-1."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("iso-8859-1")


_MAX_UNPACKED_BYTES = 64 << 20  # of a mesh file


def unpacked(file: pathlib.Path) -> bytes:
    """Returns the content of a mesh file, decompressed if gzip compressed it."""
    content = file.read_bytes()
    if not content.startswith(b"\x1f\x8b"):
        return content
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(content)) as packed:
            content = packed.read(_MAX_UNPACKED_BYTES + 1)
    except (OSError, EOFError, zlib.error):
        raise ValueError(f"{file}: the gzip data of the file is damaged or cut off") from None
    if len(content) > _MAX_UNPACKED_BYTES:
        raise ValueError(f"{file}: the file has more than 64 MiB when decompressed")
    if content.startswith(b"\x1f\x8b"):
        raise ValueError(f"{file}: the file was compressed twice by gzip; decompress it once")
    return content


CHUNK_BYTES = 512 << 10  # a server takes messages of up to 1 MiB


def chunks_of(content: bytes) -> Iterator[bytes]:
    return (content[at : at + CHUNK_BYTES] for at in range(0, len(content), CHUNK_BYTES))
