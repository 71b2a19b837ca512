"""An address at which no server answers: a port of this machine that the process has bound, but does not listen on."""

import socket

_held = []


def closed_port():
    """Returns HOST:PORT; the port stays bound until the process ends."""
    if not _held:
        held = socket.socket()
        held.bind(("127.0.0.1", 0))
        _held.append(held)
    return f"127.0.0.1:{_held[0].getsockname()[1]}"
