"""Addresses at which no server answers: ports of this machine that the process has bound, but does not listen on."""

import socket

_held = []


def held_port():
    """Returns HOST:PORT, another one by each call, for a server that is started there, and again after it has ended.

    The port stays bound until the process ends, so no other program is given it in between.
    """
    held = socket.socket()
    held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    held.bind(("127.0.0.1", 0))
    _held.append(held)
    return f"127.0.0.1:{held.getsockname()[1]}"


_closed = held_port()


def closed_port():
    """Returns HOST:PORT, the same one by each call, where no server is ever started."""
    return _closed
