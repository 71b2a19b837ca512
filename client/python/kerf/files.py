"""Files that appear whole or not at all."""

from __future__ import annotations

import codecs
import contextlib
import os
import pathlib
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


CHUNK_BYTES = 512 << 10  # a server takes messages of up to 1 MiB


def chunks_of(content: bytes) -> Iterator[bytes]:
    return (content[at : at + CHUNK_BYTES] for at in range(0, len(content), CHUNK_BYTES))
