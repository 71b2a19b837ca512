"""An address at which no server answers, on any machine: a port that this process holds and does not listen on."""

import socket

_held = []


def closed_port():
    """HOST:PORT; the port is held until the process ends."""
    if not _held:
        held = socket.socket()
        held.bind(("127.0.0.1", 0))
        _held.append(held)
    return f"127.0.0.1:{_held[0].getsockname()[1]}"
