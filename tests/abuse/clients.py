"""Makes clients of bare sockets, which may also say what no library would."""

import base64
import http.client
import json
import os
import socket
import ssl
import struct

PATIENCE_S = 20.0
LINGER_NOT = struct.pack("ii", 1, 0)  # closes by a reset, which leaves no port waiting
BIND_WITHOUT_PORT = 24  # IP_BIND_ADDRESS_NO_PORT, which Python has no name for

# Kinds and flags of HTTP/2's frames, RFC 9113.
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, RST_STREAM, SETTINGS, PING, GOAWAY, CONTINUATION = 0, 1, 3, 4, 6, 7, 9
END_STREAM, END_HEADERS = 1, 4


def connect(address, source="127.0.0.2", patience_s=PATIENCE_S, receive_buffer=None):
    """Connects from another loopback address than the measurements have, as limits count by address.

    `address`: host and port, then the context of TLS where the server speaks it."""
    peer = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        peer.setsockopt(socket.IPPROTO_IP, BIND_WITHOUT_PORT, 1)
        peer.bind((source, 0))
        if receive_buffer is not None:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        peer.settimeout(patience_s)
        peer.connect(address[:2])
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for context in address[2:]:
            peer = context.wrap_socket(peer, server_hostname="localhost")
    except OSError:
        peer.close()
        raise
    return peer


def drain(peer):
    """Reads what has come, without waiting; false where the server has closed."""
    peer.setblocking(False)
    try:
        while True:
            if not peer.recv(1 << 16):
                return False
    except (BlockingIOError, ssl.SSLWantReadError):
        return True
    finally:
        peer.settimeout(PATIENCE_S)


class Caller:
    """Calls the JSON API on one connection, which is made again where it has ended."""

    def __init__(self, address, source="127.0.0.2"):
        self.connection = http.client.HTTPConnection(*address, timeout=PATIENCE_S, source_address=(source, 0))

    def post(self, target, body):
        """Gives the status and the message of the answer."""
        try:
            self.connection.request("POST", target, body, {"Content-Type": "application/json"})
            answer = self.connection.getresponse()
            text = answer.read()
        except (OSError, http.client.HTTPException):
            self.connection.close()
            raise
        try:
            return answer.status, json.loads(text or b"{}")
        except ValueError:
            return answer.status, {}

    def call(self, method, **fields):
        return self.post(f"/kerf.v1.{method}", json.dumps(fields).encode())

    def close(self):
        self.connection.close()


def reason(status, message):
    """Names an outcome: "made" for success, else the reason of the error."""
    if status == 200:
        return "made"
    details = message.get("details") or [{}]
    return details[0].get("reason", f"status {status}")


def request_bytes(target, body):
    return f"POST {target} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body


def open_websocket(address, receive_buffer=None, headers="", source="127.0.0.2"):
    """Shakes hands at /watch. `headers`: whole lines."""
    peer = connect(address, source, receive_buffer=receive_buffer)
    key = base64.b64encode(os.urandom(16)).decode()
    peer.sendall(("GET /watch HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                  f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: kerf.v1\r\n{headers}\r\n").encode())
    answer = b""
    while b"\r\n\r\n" not in answer:
        part = peer.recv(1)
        if not part:
            break
        answer += part
    if not answer.startswith(b"HTTP/1.1 101"):
        peer.close()
        raise ConnectionRefusedError(answer[:40].decode(errors="replace"))
    return peer


def websocket_frame(opcode, payload):
    """Makes a masked frame of at most 125 bytes, whose mask is zero."""
    return bytes((0x80 | opcode, 0x80 | len(payload))) + bytes(4) + payload


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + bytes((kind, flags)) + struct.pack(">I", stream) + payload


def length(number):
    """Codes an integer as HPACK does with a prefix of seven bits."""
    if number < 127:
        return bytes((number,))
    number -= 127
    coded = b"\x7f"
    while number >= 128:
        coded += bytes((0x80 | number % 128,))
        number //= 128
    return coded + bytes((number,))


def header(name, value):
    """Codes a literal of HPACK without indexing."""
    return b"\0" + length(len(name)) + name + length(len(value)) + value


CALL_FIELDS = {b":method": b"POST", b":scheme": b"http", b":path": b"/kerf.v1.SheetService/ListSheets",
               b":authority": b"localhost", b"te": b"trailers", b"content-type": b"application/grpc"}


def call_headers(token="", **changed):
    """Codes the headers of a call, with others in place of them or after them."""
    known = {b"authorization": f"Bearer {token}".encode()} if token else {}
    fields = {**CALL_FIELDS, **known, **{name.encode(): value for name, value in changed.items()}}
    return b"".join(header(name, value) for name, value in fields.items())


def open_http2(address, source="127.0.0.2"):
    peer = connect(address, source)
    peer.sendall(PREFACE + frame(SETTINGS, 0, 0))
    return peer


def frames_of(peer):
    """Reads frames until the server closes; gives the kind, the stream and the content of each."""
    data = b""
    while part := peer.recv(1 << 16):
        data += part
        while len(data) >= 9 and len(data) >= (end := 9 + int.from_bytes(data[:3], "big")):
            yield data[3], int.from_bytes(data[5:9], "big"), data[9:end]
            data = data[end:]


# Statuses by their index in HPACK's table, RFC 7541.
STATUSES = {0x88: 200, 0x89: 204, 0x8A: 206, 0x8B: 304, 0x8C: 400, 0x8D: 404, 0x8E: 500}


def answers_of(peer):
    """Gives the HTTP status of each answer as HAProxy codes it, or 0 for a call that is reset or a connection that ends."""
    for kind, _, content in frames_of(peer):
        if kind == HEADERS:
            yield STATUSES.get(content[0]) or int(content[2:5])
        elif kind in (RST_STREAM, GOAWAY):
            yield 0
    yield 0
