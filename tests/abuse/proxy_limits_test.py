#!/usr/bin/python3
"""Tests what deploy/haproxy.cfg keeps from kerfd: old TLS, large headers, silence, and too much from one address.

    proxy_limits_test.py --kerfd KERFD --kerf KERF --work FOLDER
"""

import argparse
import contextlib
import concurrent.futures
import http.client
import pathlib
import queue
import select
import shutil
import socket
import ssl
import subprocess
import sys
import threading
import time
import unittest

from clients import END_HEADERS, END_STREAM, HEADERS, answers_of, call_headers, connect, drain, frame, header, open_http2
from guarded import ROOT, Browser, Guarded, reason_of, start_proxy

OPTIONS = None
PATIENCE_S = 30
server = None


def setUpModule():
    global server
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    subprocess.run([ROOT / "client/python/generate", OPTIONS.work], check=True)
    sys.path.insert(0, str(OPTIONS.work))
    server = Guarded(OPTIONS.kerfd, OPTIONS.kerf)
    unittest.addModuleCleanup(server.stop)


def closed_by_server(peers, wanted):
    """Waits until the server has closed so many of the connections; gives how many it has."""
    left = set(peers)
    poll = select.poll()
    by_number = {peer.fileno(): peer for peer in peers}
    for peer in peers:
        poll.register(peer, select.POLLIN)
    while len(peers) - len(left) < wanted:
        ready = poll.poll(1000 * PATIENCE_S)
        if not ready:
            break
        for number, _ in ready:
            try:
                lives = drain(by_number[number])
            except OSError:
                lives = False
            if not lives:
                poll.unregister(number)
                left.remove(by_number[number])
    return len(peers) - len(left)


class Transport(unittest.TestCase):
    def shake_hands(self, version):
        context = server.proxy.context("h2")
        context.set_ciphers("ALL:@SECLEVEL=0")  # so that this side would take the old ones
        context.minimum_version = context.maximum_version = version
        with connect((*server.grpc[:2], context)) as peer:
            return peer.version(), peer.selected_alpn_protocol()

    def test_old_versions_of_tls_are_refused(self):
        self.assertEqual(self.shake_hands(ssl.TLSVersion.TLSv1_2), ("TLSv1.2", "h2"))
        self.assertEqual(self.shake_hands(ssl.TLSVersion.TLSv1_3), ("TLSv1.3", "h2"))
        for version in (ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1):
            with self.assertRaisesRegex(ssl.SSLError, "PROTOCOL_VERSION"):
                self.shake_hands(version)

    def test_who_asks_for_nothing_is_cut_off_and_a_silent_stream_is_not(self):
        import kerf
        client = self.enterContext(kerf.connect(**server.honest, token=server.tokens["admin"]))
        sheet = client.create_sheet("silent", grid=(4, 4), paused=True)
        self.addCleanup(sheet.delete)
        stream = self.watch(client, sheet.name)  # by itself, as sheet.watch() begins again where it is cut
        self.assertEqual(next(stream).frame.tick, 0)
        silent = [connect(server.grpc[:2]), connect(server.grpc[:2]), connect(server.grpc), open_http2(server.grpc),
                  open_http2(server.grpc), connect(server.http), connect(server.http)]
        for peer in silent:
            self.addCleanup(peer.close)
        silent[1].sendall(b"\x16\x03\x01\x02\x00\x01\x00")  # the beginning of TLS
        silent[4].sendall(frame(HEADERS, END_HEADERS | END_STREAM, 1, call_headers())[:20])
        silent[6].sendall(b"GET /healthz HTTP/1.1\r\nHost: loc")
        self.assertEqual(closed_by_server(silent, len(silent)), len(silent))
        sheet.step(1)
        self.assertEqual(next(stream).frame.tick, 1)

    def watch(self, client, name):
        from kerf.v1 import stream_pb2
        requests = queue.Queue()
        self.addCleanup(requests.put, None)
        # Its window holds all frames of the test, so none is acknowledged.
        requests.put(stream_pb2.WatchRequest(start=stream_pb2.WatchStart(name=name, window=8)))
        return client.stream_service.Watch(iter(requests.get, None), timeout=2 * PATIENCE_S)


class Requests(unittest.TestCase):
    def test_large_headers_are_refused(self):
        with Browser(server.proxy) as browser:
            self.assertEqual(browser.ask("/healthz", x_filler="x" * 5000)[0], 200)
            self.assertEqual(browser.ask("/healthz", x_filler="x" * 6000)[0], 431)
        with Browser(server.proxy) as browser, self.assertRaises((http.client.HTTPException, OSError)):
            if browser.ask("/healthz", x_filler="x" * 20000)[0] == 400:
                raise http.client.HTTPException()

    def test_headers_that_gRPC_does_not_stand_are_refused(self):
        self.assertEqual(self.answer_to(), 200)
        for name in ("grpclb_client_stats", "te", ":scheme", ":path"):
            with self.subTest(name):
                self.assertIn(self.answer_to(**{name: b"=?"}), (0, 400, 404))
        self.assertEqual(self.answer_to(x_filler=b"x" * 9000), 431)
        self.assertEqual(self.answer_to(x_filler=b"x" * 14000), 431)

    def answer_to(self, **changed):
        with open_http2(server.grpc) as peer:
            peer.sendall(frame(HEADERS, END_HEADERS | END_STREAM, 1, call_headers(server.token, **changed)))
            return next(answers_of(peer))

    def test_two_tokens_are_refused(self):
        field = header(b"authorization", f"Bearer {server.token}".encode())
        with open_http2(server.grpc) as peer:
            peer.sendall(frame(HEADERS, END_HEADERS | END_STREAM, 1, call_headers(server.token) + field))
            self.assertEqual(next(answers_of(peer)), 400)


class Addresses(unittest.TestCase):
    """Each test has an address of its own."""

    def tearDown(self):
        with Browser(server.proxy) as browser:
            self.assertEqual(browser.ask("/healthz")[0], 200)

    def test_have_64_connections(self):
        peers = []
        for _ in range(80):
            with contextlib.suppress(ConnectionError):  # closed within connect() already
                peers.append(self.enterContext(connect(server.grpc[:2], "127.0.0.10")))
        wanted = len(peers) - 64
        self.assertEqual(closed_by_server(peers, wanted), wanted)

    def test_have_128_calls(self):
        headers = call_headers(server.token, **{":path": b"/kerf.v1.StreamService/Watch"})
        calls = b"".join(frame(HEADERS, END_HEADERS, stream, headers) for stream in range(1, 101, 2))
        peers = [self.enterContext(open_http2(server.grpc, "127.0.0.11")) for _ in range(3)]
        for peer in peers:
            peer.sendall(calls)
        refused = queue.Queue()
        for peer in peers:
            threading.Thread(target=lambda peer=peer: [refused.put(each) for each in answers_of(peer) if each], daemon=True).start()
        self.assertEqual([refused.get(timeout=PATIENCE_S) for _ in range(22)], 22 * [429])
        for peer in peers:
            peer.shutdown(socket.SHUT_RDWR)
        end = time.monotonic() + PATIENCE_S
        with Browser(server.proxy, "127.0.0.11") as browser:  # calls that have ended do not count
            while (status := browser.ask("/healthz")[0]) == 429 and time.monotonic() < end:
                pass
            self.assertEqual(status, 200)

    def test_log_in_wrongly_five_times_a_minute(self):
        def wrong(_):
            with Browser(server.proxy, "127.0.0.12") as browser:
                status, headers, body = browser.log_in("kerf_view_wrong")
                return status, headers["retry-after"], reason_of(body)

        with concurrent.futures.ThreadPoolExecutor(20) as pool:
            answers = list(pool.map(wrong, range(40)))
        self.assertEqual({each: answers.count(each) for each in answers},
                         {(401, None, "TOKEN_UNKNOWN"): 5, (429, "60", "TOO_MANY_LOGINS"): 35})
        with Browser(server.proxy, "127.0.0.13") as browser:  # good logins do not count
            self.assertEqual([browser.log_in(server.tokens["view"])[0] for _ in range(20)], 20 * [200])

    def test_that_ask_for_too_much_lose_the_connection(self):
        proxy = start_proxy(self, server, KERF_PROXY_REQUESTS="20")
        with Browser(proxy, "127.0.0.14") as browser, self.assertRaises((http.client.HTTPException, OSError)):
            for _ in range(2000):
                browser.ask("/healthz")
        with Browser(proxy, "127.0.0.15") as browser:
            self.assertEqual(browser.ask("/healthz")[0], 200)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("kerfd", "kerf", "work"):
        parser.add_argument(f"--{name}", required=True, type=pathlib.Path)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(module="__main__", argv=[sys.argv[0], *rest])
