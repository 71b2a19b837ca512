"""Connections in the child of a fork.

gRPC has threads, which a fork does not copy; with its fork support it makes others in the child. Blocking connections
are then opened again there. Those of kerf.aio cannot be.
"""

from __future__ import annotations

import os
import weakref
from typing import Protocol, Tuple

from kerf import grpc_environment
from kerf.errors import Unavailable


class _Connection(Protocol):
    def _open(self) -> None: ...


class _Process:
    """Holds what is known of this process and those that it was forked from."""

    def __init__(self) -> None:
        self.connections: "weakref.WeakSet[_Connection]" = weakref.WeakSet()
        self.surfaces: Tuple[bool, bool] = (False, False)  # has connections that block; has some for asyncio
        self.why_not = ""  # why no call can be made; empty: calls can be made

    def after_fork(self) -> None:
        blocks, is_async = self.surfaces
        if is_async:
            self.why_not = (
                "gRPC's asyncio does not survive a fork: start processes by multiprocessing.get_context('spawn'), or use "
                "kerf.connect() in place of kerf.aio"
            )
        elif blocks and not grpc_environment.SURVIVES_FORKS:
            self.why_not = (
                "gRPC's threads did not survive a fork: import kerf before grpc, set GRPC_ENABLE_FORK_SUPPORT=1, or start "
                "processes by multiprocessing.get_context('spawn')"
            )
        else:
            for connection in list(self.connections):
                connection._open()


_process = _Process()
os.register_at_fork(after_in_child=_process.after_fork)


def watch(connection: _Connection, *, is_async: bool) -> None:
    """Has a new connection opened again in children that are forked from now on."""
    blocks, has_async = _process.surfaces
    _process.surfaces = (blocks or not is_async, has_async or is_async)
    _process.connections.add(connection)


def check() -> None:
    """Raises Unavailable in a child in which no call can be made."""
    if _process.why_not:
        raise Unavailable("UNAVAILABLE", "FORKED", _process.why_not)


def stream_of_parent() -> Unavailable:
    """Returns the error of a stream that was opened before the fork."""
    return Unavailable("UNAVAILABLE", "FORKED", "the parent opened this stream before a fork: open another in the child")
