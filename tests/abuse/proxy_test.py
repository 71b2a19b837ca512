#!/usr/bin/python3
"""Tests deploy/haproxy.cfg before a kerfd: that callers get through as without it, and its check of JSON Web Tokens.

    proxy_test.py --kerfd KERFD --kerf KERF --work FOLDER
"""

import argparse
import http.server
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time
import unittest

from clients import END_HEADERS, HEADERS, answers_of, frame, header, open_http2, open_websocket, websocket_frame
from guarded import HAPROXY, HOST, ROOT, SCOPES, Browser, Guarded, reason_of, start_proxy
from json_web_tokens import make_key, make_token

OPTIONS = None
LIST = "/kerf.v1.SheetService/ListSheets"
ISSUER, AUDIENCE = "https://id.example.org", "https://sheets.example.org"
server = None


def setUpModule():
    global server
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    subprocess.run([ROOT / "client/python/generate", OPTIONS.work], check=True)
    sys.path.insert(0, str(OPTIONS.work))
    server = Guarded(OPTIONS.kerfd, OPTIONS.kerf)
    unittest.addModuleCleanup(server.stop)


class File(unittest.TestCase):
    def check(self, **environment):
        known = {"KERF_PROXY_CERT": str(server.folder / "server.crt"), **environment}
        return subprocess.run([HAPROXY, "-c", "-f", ROOT / "deploy/haproxy.cfg"], env={**os.environ, **known}, capture_output=True,
                              text=True)

    def test_is_accepted_and_wrong_variables_are_not(self):
        plain = self.check()
        self.assertEqual((plain.returncode, plain.stderr), (0, ""))
        variables, _ = variables_of_tokens("RS256")
        full = self.check(**variables, KERF_PROXY_LOG="/dev/log", KERF_PROXY_USER="root")
        self.assertEqual((full.returncode, full.stderr), (0, ""))
        for name in ("KERF_JWT_ISSUER", "KERF_JWT_AUDIENCE", "KERF_JWT_TOKENS"):
            refused = self.check(**{**variables, name: ""})
            self.assertEqual(refused.returncode, 1, name)
            self.assertIn("KERF_JWT_KEY needs", refused.stderr)
        for algorithm in ("HS256", "none", "RS512", ""):
            self.assertIn("RS256 or ES256", self.check(**{**variables, "KERF_JWT_ALGORITHM": algorithm}).stderr)
        self.assertEqual(self.check(KERF_PROXY_CERT="/none.crt").returncode, 1)


    def test_has_the_variables_and_defaults_of_its_page(self):
        text, page = ((ROOT / "deploy" / name).read_text() for name in ("haproxy.cfg", "proxy.md"))
        table = dict(re.findall(r"^\| (`KERF_.*?) \| (.*?) \|", page.split("## Variables")[1].split("## ")[0], re.MULTILINE))
        listed = {}
        for names, defaults in table.items():
            found = re.findall(r"\w+", names)
            listed.update(zip(found, re.findall(r"[^`, ]+", defaults) if defaults != "none" else [""] * len(found)))
        defaults = dict(re.findall(r"presetenv (\w+) (\S+)", text))
        self.assertEqual(listed, {**dict.fromkeys(re.findall(r"KERF_[A-Z_]+", text), ""), **defaults})


class Callers(unittest.TestCase):
    def test_grpc(self):
        import grpc
        import kerf
        with kerf.connect(**server.honest, token=server.tokens["cut"]) as client:
            self.assertEqual(sorted(sheet.name for sheet in client.sheets()), ["sheets/v0", "sheets/v1"])
            with self.assertRaises(kerf.PermissionDenied):
                client.create_sheet("mine", grid=(4, 4))
        with kerf.connect(**server.honest) as client:
            with self.assertRaises(kerf.Unauthenticated) as refused:
                client.sheets()
            self.assertEqual(refused.exception.reason, "TOKEN_MISSING")
        credentials = grpc.ssl_channel_credentials(pathlib.Path(server.proxy.authority).read_bytes())
        with grpc.secure_channel(server.honest["address"], credentials) as channel:
            self.assertEqual(channel.unary_unary("/grpc.health.v1.Health/Check")(b"", timeout=30), b"\x08\x01")
            with self.assertRaises(grpc.RpcError) as refused:
                channel.unary_unary("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo")(b"", timeout=30)
            self.assertEqual(refused.exception.code(), grpc.StatusCode.UNIMPLEMENTED)

    def test_json_and_files(self):
        with Browser(server.proxy) as browser:
            status, headers, body = browser.ask("/healthz")
            self.assertEqual((status, body, headers["strict-transport-security"]), (200, "ok\n", "max-age=2592000"))
            status, _, body = browser.ask(LIST, {})
            self.assertEqual((status, reason_of(body)), (401, "TOKEN_MISSING"))
            status, _, body = browser.ask(LIST, {}, Authorization=f"Bearer {server.tokens['view']}")
            self.assertEqual((status, len(json.loads(body)["sheets"])), (200, 2))

    def test_a_login_is_as_safe_as_one_over_tls_of_kerfd(self):
        browser = self.enterContext(Browser(server.proxy))
        page = {"Host": HOST, "Origin": f"https://{HOST}"}
        status, headers, _ = browser.log_in(server.tokens["cut"], **page)
        self.assertEqual(status, 200)
        self.assertRegex(headers["set-cookie"], r"^__Host-kerf=[\w-]{43}; Path=/; Max-Age=\d+; HttpOnly; SameSite=Strict; Secure$")
        cookie = headers["set-cookie"].split(";")[0]
        plain = cookie.removeprefix("__Host-")  # which a neighbour of the domain could set
        for status, reason, sent in (
                (200, "", {"Cookie": cookie, "x_kerf_csrf": "1", **page}),
                (200, "", {"Cookie": f"{plain}x; {cookie}", "x_kerf_csrf": "1", **page}),
                (401, "TOKEN_MISSING", {"Cookie": f"a=b; {plain}; {plain}", "x_kerf_csrf": "1", **page}),
                (403, "CSRF_HEADER_MISSING", {"Cookie": cookie, **page}),
                (403, "ORIGIN_NOT_ALLOWED", {"Cookie": cookie, "x_kerf_csrf": "1", **page, "Origin": "https://example.org"}),
                (403, "HOST_NOT_ALLOWED", {"Cookie": cookie, "x_kerf_csrf": "1", **page, "Host": "example.org"})):
            with self.subTest(sent):
                got, _, body = browser.ask(LIST, {}, **sent)
                self.assertEqual((got, reason_of(body) if reason else ""), (status, reason))
        status, headers, _ = browser.ask("/logout", {}, Cookie=cookie, x_kerf_csrf="1", **page)
        self.assertEqual(status, 200)
        self.assertRegex(headers["set-cookie"], r"^__Host-kerf=; Path=/; Max-Age=0;.*; Secure$")
        self.assertEqual(browser.ask(LIST, {}, Cookie=cookie, x_kerf_csrf="1", **page)[0], 401)

    def test_websockets_over_both_versions_of_http(self):
        from kerf.v1 import stream_pb2
        start = stream_pb2.WatchRequest(start=stream_pb2.WatchStart(name="sheets/v0")).SerializeToString()
        with open_websocket(server.http, headers=f"Authorization: Bearer {server.tokens['view']}\r\n") as peer:
            peer.sendall(websocket_frame(2, start))
            self.assertGreater(len(peer.recv(1 << 16)), 100)
        with self.assertRaisesRegex(ConnectionRefusedError, "401"):
            open_websocket(server.http)
        for token, status in ((server.tokens["view"], 200), ("kerf_view_none", 401)):
            fields = {":method": "CONNECT", ":protocol": "websocket", ":scheme": "https", ":path": "/watch", ":authority": "localhost",
                      "authorization": f"Bearer {token}", "sec-websocket-version": "13", "sec-websocket-protocol": "kerf.v1"}
            with open_http2(server.grpc) as peer:
                peer.sendall(frame(HEADERS, END_HEADERS, 1, b"".join(header(*map(str.encode, pair)) for pair in fields.items())))
                self.assertEqual(next(answers_of(peer)), status)


def variables_of_tokens(algorithm):
    """Makes what the check of JSON Web Tokens needs; gives the variables and the private key."""
    private, public = make_key(server.folder, algorithm)
    tokens = server.folder / "claims.map"
    tokens.write_text("".join(f"{scope} {server.tokens[scope]}\n" for scope in SCOPES))
    return {"KERF_JWT_KEY": str(public), "KERF_JWT_ALGORITHM": algorithm, "KERF_JWT_ISSUER": ISSUER, "KERF_JWT_AUDIENCE": AUDIENCE,
            "KERF_JWT_TOKENS": str(tokens)}, private


class JsonWebTokens(unittest.TestCase):
    def claims(self, **changed):
        known = {"iss": ISSUER, "aud": AUDIENCE, "exp": int(time.time()) + 600, "kerf_scope": "cut", **changed}
        return {name: value for name, value in known.items() if value is not None}

    def test_stand_for_tokens_of_kerf(self):
        for algorithm, other in (("RS256", "ES256"), ("ES256", "RS256")):
            variables, key = variables_of_tokens(algorithm)
            stranger, _ = make_key(server.folder / "keys", algorithm)
            proxy = start_proxy(self, server, **variables)
            now = int(time.time())
            good = make_token(algorithm, key, self.claims())
            answers = {
                "SHEET_NOT_FOUND": [good, make_token(algorithm, key, self.claims(kerf_scope="admin", nbf=now - 60)),
                                    make_token(algorithm, key, self.claims(aud=["other", AUDIENCE])), server.tokens["cut"]],
                "SCOPE_TOO_LOW": [make_token(algorithm, key, self.claims(kerf_scope="view"))],
                403: [make_token(algorithm, key, self.claims(kerf_scope=scope)) for scope in ("root", "", None, ["cut"])],
                401: [make_token(algorithm, key, self.claims(**wrong)) for wrong in (
                    {"exp": now - 1}, {"exp": None}, {"exp": "never"}, {"nbf": now + 600}, {"aud": "other"}, {"aud": None},
                    {"aud": ["other"]}, {"iss": f"{ISSUER}.evil"}, {"iss": None})] + [
                    make_token("none", key, self.claims()), make_token("none", key, self.claims(), algorithm),
                    make_token("HS256", pathlib.Path(variables["KERF_JWT_KEY"]), self.claims()),
                    make_token(algorithm, pathlib.Path(variables["KERF_JWT_KEY"]), self.claims(), "HS256"),
                    make_token(other, key, self.claims(), algorithm), make_token(algorithm, stranger, self.claims()),
                    good[:-6] + "AAAAAA", good.rsplit(".", 1)[0], good.rsplit(".", 1)[0] + ".", "nonsense", "a.b.c"]}
            with Browser(proxy) as browser:
                for wanted, tokens in answers.items():
                    for token in tokens:
                        with self.subTest(token, algorithm=algorithm):
                            status, _, body = browser.ask("/kerf.v1.CutService/UndoCut", {"parent": "sheets/none"},
                                                          Authorization=f"Bearer {token}")
                            self.assertEqual(status if isinstance(wanted, int) else reason_of(body), wanted)
            self.check_grpc(proxy, good)

    def check_grpc(self, proxy, good):
        import kerf
        with kerf.connect(**proxy.options(), token=good) as client:
            self.assertEqual(client.access().token_id, "cut")
        with kerf.connect(**proxy.options(), token=good + "x") as client, self.assertRaises(kerf.Unauthenticated):
            client.access()

    def test_forged_ones_end_no_connection_of_others(self):
        """HAProxy 2.6 leaves an error behind that the next use of TLS by the same thread takes for its own."""
        variables, key = variables_of_tokens("RS256")
        proxy = start_proxy(self, server, **variables)
        forged = make_token("RS256", key, self.claims())[:-6] + "AAAAAA"
        with Browser(proxy, "127.0.0.2") as stranger, Browser(proxy) as honest:
            honest.ask("/healthz")
            peer = honest.connection.sock
            for _ in range(200):
                self.assertEqual(stranger.ask("/healthz", Authorization=f"Bearer {forged}")[0], 401)
                self.assertEqual(honest.ask("/healthz")[0], 200)
            self.assertIs(honest.connection.sock, peer, "the connection was made again")


class Seen(http.server.BaseHTTPRequestHandler):
    """Keeps what a server behind the proxy gets."""

    protocol_version = "HTTP/1.1"
    headers_seen = None

    def do_GET(self):
        Seen.headers_seen = {name.lower(): value for name, value in self.headers.items()}
        self.send_response(200)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


class Headers(unittest.TestCase):
    def test_that_only_a_proxy_may_send_do_not_pass(self):
        behind = self.enterContext(http.server.ThreadingHTTPServer(("127.0.0.1", 0), Seen))
        threading.Thread(target=behind.serve_forever, daemon=True).start()
        self.addCleanup(behind.shutdown)
        proxy = start_proxy(self, server, {"grpc": server.ready["grpc"], "http": f"http://127.0.0.1:{behind.server_port}"})
        with Browser(proxy) as browser:
            self.assertEqual(browser.ask("/", x_kerf_tenant="a", x_kerf_node="b", x_kerf_csrf="1", X_Forwarded_For="192.0.2.1",
                                         Forwarded="for=192.0.2.1", X_Real_IP="192.0.2.1", Cookie="a=1; kerf=2; b=3")[0], 200)
        kept = {name: value for name, value in Seen.headers_seen.items() if name not in ("host", "accept-encoding", "connection")}
        self.assertEqual(kept, {"x-kerf-csrf": "1", "cookie": "a=1; b=3", "x-forwarded-for": "127.0.0.1"}, "the true address alone")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("kerfd", "kerf", "work"):
        parser.add_argument(f"--{name}", required=True, type=pathlib.Path)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(module="__main__", argv=[sys.argv[0], *rest])
