"""Lists the attacks; each is called again and again, by some threads at once, until the server has ended."""

import dataclasses
import itertools
import json
import os
import random
import select
import socket
import struct
import subprocess
import time
import typing

from clients import (CONTINUATION, DATA, END_HEADERS, END_STREAM, HEADERS, LINGER_NOT, PING, PREFACE, RST_STREAM, SETTINGS, Caller,
                     call_headers, connect, drain, frame, header, length, open_http2, open_websocket, reason, request_bytes,
                     websocket_frame)

CREATE = "/kerf.v1.SheetService/CreateSheet"
FINE_DISC = {"outline": {"boundary": {"circle": {"center": {"x": 0.5, "y": 0.5}, "radius_m": 0.5}}, "edge_length_m": 0.0015}}
numbers = itertools.count()


def grid(side, **fields):
    return {"columns": side, "rows": side, "width_m": 1, "height_m": 1, **fields}


def connections(target, number):
    """Opens connections and closes them at once, each second one by a reset."""
    for turn in range(200):
        with connect(target.grpc, f"127.0.{1 + number}.{1 + turn}") as peer:
            if turn % 2:
                peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER_NOT)
        target.count("opened")


def hold(target, address, wanted, say=None):
    """Holds connections, replaces those that the server closes, and says a byte on each now and then."""
    held = []
    while True:
        while len(held) < wanted:
            held.append(connect(address))
            target.count("opened")
        ended, _, _ = select.select(held, [], [], 0)
        for peer in ended:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER_NOT)
            held.remove(peer)
            peer.close()
        target.count("closed by server", len(ended))
        for peer in held if say else ():
            try:
                peer.sendall(say())
                target.count("bytes")
            except OSError:
                pass  # found closed in the next turn
        time.sleep(0.5)


def idle(target, number):
    hold(target, (target.http, target.grpc)[number], 200)


def slowloris(target, _):
    hold(target, target.http, 120, lambda: random.choice(b"GEThost:xyz").to_bytes(1, "big"))


def ask_for(target, scene, wait_s):
    """Asks for a sheet and hangs up after some seconds; without a number, waits for the answer."""
    with connect(target.http) as peer:
        peer.sendall(request_bytes(CREATE, json.dumps({"sheet_id": f"a-{next(numbers)}", "scene": scene}).encode()))
        target.count("asked")
        peer.settimeout(wait_s)
        try:
            answer = peer.recv(1 << 16)
        except TimeoutError:
            target.count("given up")
            return
    try:
        message = json.loads(answer.partition(b"\r\n\r\n")[2])
    except ValueError:
        target.count("answered without a message")
        return
    target.count(reason(int(answer[9:12]), message))
    if "name" in message:
        Caller(target.http).call("SheetService/DeleteSheet", name=message["name"])


def abandoned_outlines(target, _):
    ask_for(target, FINE_DISC, 0.5)


def abandoned_grids(target, number):
    """Two ask and hang up, two wait until the answer or the end."""
    pattern = ("UNIFORM_DIAGONALS", "JITTERED_DELAUNAY")[number % 2]
    ask_for(target, {"grid": grid(700, pattern=pattern)}, 0.5 if number < 2 else None)


def recorded(target):
    """Records a sheet that runs alone, and gives the bytes."""
    file = target.folder / f"{random.getrandbits(48):x}.rec"
    subprocess.run([target.kerf, "run", target.folder / "v0.json", "--ticks", "200", "--record", file], check=True,
                   stdout=subprocess.DEVNULL)
    return file.read_bytes()


def recordings(target, number):
    """Sends recordings that are torn, changed in a bit, or made of random bytes."""
    good = recorded(target)
    caller = Caller(target.http)
    while True:
        kind = random.choice(("garbage", "torn", "flipped", "flipped"))
        body = bytearray(os.urandom(5000) if kind == "garbage" else good)
        if kind == "torn":
            body = body[:random.randrange(1, len(body))]
        elif kind == "flipped":
            body[random.randrange(len(body))] ^= 1 << random.randrange(8)
        name = f"a-{number}-{next(numbers)}"
        status, message = caller.post(f"/recordings?sheet={name}", bytes(body))
        target.count(f"{kind}: {reason(status, message)}")
        if status == 200:
            caller.call("SheetService/DeleteSheet", name=f"sheets/{name}")


def pings(target, _):
    with open_websocket(target.http) as peer:
        while True:
            peer.sendall(websocket_frame(9, b"0123456789") * 200)
            target.count("pings", 200)
            if not drain(peer):
                target.count("closed by server")
                return


def malformed(target, _):
    """Sends random bytes and frames, some after a right preface."""
    with connect(target.grpc, f"127.0.{random.randrange(1, 200)}.2", 1.0) as peer:
        kind = random.choice(("bytes", "preface and bytes", "torn preface", "frames", "huge frame", "settings and pings"))
        target.count(kind)
        if kind == "bytes":
            peer.sendall(os.urandom(3000))
        elif kind == "torn preface":
            peer.sendall(PREFACE[:random.randrange(len(PREFACE))])
        else:
            peer.sendall(PREFACE + frame(SETTINGS, 0, 0))
        if kind == "preface and bytes":
            peer.sendall(os.urandom(3000))
        elif kind == "frames":
            peer.sendall(b"".join(frame(random.randrange(12), random.randrange(256), random.randrange(6),
                                        os.urandom(random.randrange(40))) for _ in range(50)))
        elif kind == "huge frame":
            peer.sendall(frame(DATA, 0, 1, bytes((1 << 24) - 1)))
        elif kind == "settings and pings":
            peer.sendall((frame(SETTINGS, 0, 0, struct.pack(">HI", 1, 4096)) + frame(PING, 0, 0, bytes(8))) * 2000)
        drain(peer)


def reset_call(target, stream, with_message):
    """Makes a call that is reset at once; after a message, the server begins it."""
    if with_message:
        call = frame(HEADERS, END_HEADERS, stream, target.headers) + frame(DATA, END_STREAM, stream, bytes(5))
    else:
        call = frame(HEADERS, END_HEADERS | END_STREAM, stream, target.headers)
    return call + frame(RST_STREAM, 0, stream, struct.pack(">I", 8))


def rapid_reset(target, number):
    """Resets calls at once; on half of the connections after a message."""
    with open_http2(target.grpc) as peer:
        target.count("connections")
        for first in range(1, 1 << 30, 200):
            peer.sendall(b"".join(reset_call(target, stream, number % 2) for stream in range(first, first + 200, 2)))
            target.count("resets", 100)
            if not drain(peer):
                target.count("closed by server")
                return


def header_flood(target, _):
    """Sends headers without an end."""
    more = frame(CONTINUATION, 0, 1, header(b"x-flood", b"x" * 16000))
    with open_http2(target.grpc) as peer:
        target.count("connections")
        peer.sendall(frame(HEADERS, 0, 1, target.headers))
        while True:
            peer.sendall(more)
            target.count("frames of 16 kB")
            if not drain(peer):
                target.count("closed by server")
                return


def endless_header(target, number):
    """Sends one header of a gigabyte, in frames of 16 kB; or integers of HPACK without an end."""
    start, more = ((b"\0" + length(1 << 30), b"x" * 16000), (b"\0\x7f", b"\x80" * 16000))[number % 2]
    with open_http2(target.grpc) as peer:
        target.count("connections")
        peer.sendall(frame(HEADERS, 0, 1, target.headers + start))
        while True:
            peer.sendall(frame(CONTINUATION, 0, 1, more))
            target.count("frames of 16 kB")
            if not drain(peer):
                target.count("closed by server")
                return


def wrong_headers(target, _):
    """Sends headers with values that gRPC does not know, and others beyond its limit of 8 kB after them."""
    name = random.choice(("te", ":scheme", ":path", "content-type", "grpc-encoding", "grpc-timeout", "grpclb_client_stats",
                          "x-bin"))
    filler = header(b"x-flood", b"x" * random.choice((10, 9000, 14000)))
    with open_http2(target.grpc) as peer:
        peer.sendall(frame(HEADERS, END_HEADERS | END_STREAM, 1, call_headers(target.token, **{name: b"=?"}) + filler))
        target.count(name)
        peer.settimeout(0.05)
        peer.recv(1 << 16)


JSON_BODIES = (
    ("2 MiB", "SheetService/CreateSheet", b'{"scene":{"inline":{"material_positions":[' + b"1," * (1 << 20) + b"1]}}}"),
    ("long list", "SheetService/CreateSheet", b'{"scene":{"inline":{"material_positions":[' + b"1," * 500_000 + b"1]}}}"),
    ("long text", "SheetService/CreateSheet", b'{"scene":{"obj":{"text":"' + b"v 0 0 0\\n" * 100_000 + b'"}}}'),
    ("deep lists", "SheetService/CreateSheet", b'{"scene":' + b"[" * 1_000_000),
    ("deep fields", "SheetService/CreateSheet", b'{"scene":' * 90_000 + b"1" + b"}" * 90_000),
    ("NaN", "SheetService/CreateSheet", json.dumps({"scene": {"grid": {**grid(9), "width_m": float("nan")}}}).encode()),
    ("NaN as text", "SheetService/CreateSheet", json.dumps({"scene": {"grid": {**grid(9), "width_m": "NaN"}}}).encode()),
    ("unknown sheet", "SheetService/GetSheet", b'{"name":"sheets/none"}'),
    ("unknown field", "SheetService/GetSheet", b'{"nome":"sheets/v0"}'),
    ("unknown call", "SheetService/Attack", b"{}"),
)


def json_floods(target, _):
    caller = Caller(target.http)
    while True:
        name, method, body = random.choice(JSON_BODIES)
        status, message = caller.post(f"/kerf.v1.{method}", body)
        target.count(f"{name}: {reason(status, message)}")


def churn(target, number):
    """Makes a sheet, cuts it three times, looks at it and deletes it."""
    caller = Caller(target.http)
    name = f"a-{number}-{next(numbers)}"
    answer = caller.call("SheetService/CreateSheet", sheet_id=name, scene={"grid": grid(30)})
    target.count(f"sheets: {reason(*answer)}")
    if answer[0] != 200:
        return
    for x in (0.2, 0.5, 0.8):
        line = [{"x": x, "y": 0.3}, {"x": x + 0.1, "y": 0.7}]
        answer = caller.call("CutService/CreateCut", parent=f"sheets/{name}", cut={"curve": {"polyline": {"points": line}}})
        target.count(f"cuts: {reason(*answer)}")
    with open_websocket(target.http) as peer:
        peer.sendall(watch(name))
        peer.recv(1 << 16)
    caller.call("SheetService/DeleteSheet", name=f"sheets/{name}")
    caller.close()


def memory(target, number):
    """Makes implicit sheets until one is refused, then deletes them."""
    caller = Caller(target.http)
    names = []
    while True:
        name = f"a-{number}-{next(numbers)}"
        scene = {"grid": grid(100), "integrator": {"kind": "IMPLICIT_EULER", "solver": "DIRECT"}}
        status, message = caller.call("SheetService/CreateSheet", sheet_id=name, scene=scene)
        target.count(reason(status, message))
        if status != 200:
            break
        names.append(name)
    for name in names:
        caller.call("SheetService/DeleteSheet", name=f"sheets/{name}")
    caller.close()


def descriptors(target, number):
    """Holds 100 connections of HTTP while others open and close those of gRPC."""
    if number == 0:
        hold(target, target.http, 100)
    for _ in range(100):
        with connect(target.grpc) as peer:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER_NOT)
        target.count("short connections")
    time.sleep(0.1)


def watch(name):
    """Makes the message that starts a stream of a sheet, with eight uncompressed frames in flight."""
    start = b"\x0a" + length_of(f"sheets/{name}".encode()) + b"\x10\x08\x20\x02"
    return websocket_frame(2, b"\x0a" + length_of(start))


def length_of(content):
    return bytes((len(content),)) + content


def stalled_viewers(target, number):
    """Each second viewer acknowledges what it has not read, so that the server fills the connection."""
    viewers = [open_websocket(target.http, 4096) for _ in range(10)]
    for turn, viewer in enumerate(viewers):
        viewer.sendall(watch(f"v{(number + turn) % 9}"))
        target.count("viewers")
    for sequence in range(1, 128):
        for viewer in viewers[::2]:
            viewer.sendall(websocket_frame(2, b"\x12\x02\x08" + bytes((sequence,))))
            target.count("acknowledgements")
        time.sleep(0.1)


@dataclasses.dataclass(frozen=True)
class Attack:
    run: typing.Callable  # takes the target and the number of the thread
    threads: int
    limit: str = ""  # words of bash before the server starts
    most_mb: int = 600  # high water of the server's memory
    left_to_proxy: bool = False  # gRPC 1.51 has no defence against it; sheets have


ATTACKS = {
    "connections": Attack(connections, 4),
    "idle": Attack(idle, 2),
    "slowloris": Attack(slowloris, 1),
    "abandoned-outlines": Attack(abandoned_outlines, 4),
    "abandoned-grids": Attack(abandoned_grids, 4, most_mb=4000),
    "recordings": Attack(recordings, 4),
    "pings": Attack(pings, 8),
    "malformed": Attack(malformed, 4),
    "rapid-reset": Attack(rapid_reset, 4, left_to_proxy=True),
    "header-flood": Attack(header_flood, 4, left_to_proxy=True),
    "endless-header": Attack(endless_header, 4, left_to_proxy=True),
    "wrong-headers": Attack(wrong_headers, 4),
    "json": Attack(json_floods, 8),
    "churn": Attack(churn, 4),
    "memory": Attack(memory, 2, "ulimit -v 700000"),
    "descriptors": Attack(descriptors, 3, "ulimit -n 64"),
    "stalled-viewers": Attack(stalled_viewers, 5),
}
