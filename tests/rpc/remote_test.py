#!/usr/bin/env python3
"""Tests what `deploy/run --remote` puts together: certificates, a token, TLS on both ports, and clients that use them.

    remote_test.py --kerfd KERFD --kerf KERF --work FOLDER
"""

import argparse
import json
import os
import pathlib
import shutil
import signal
import ssl
import stat
import subprocess
import sys
import unittest
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPTIONS = None


def path(name=""):
    return os.path.join(OPTIONS.work, name)


def run(*command, code=0):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60)
    if done.returncode != code:
        raise AssertionError(f"{command}: {done.returncode} {done.stdout}{done.stderr}")
    return done


def setUpModule():
    shutil.rmtree(OPTIONS.work, ignore_errors=True)


class Remote(unittest.TestCase):
    def test_a_viewer_and_a_script_get_in_and_nobody_else(self):
        run(ROOT / "deploy/certificates", path(), "sheets.example.org", "192.0.2.7")
        for name in ("ca.key", "server.key", "client.key"):
            self.assertEqual(stat.S_IMODE(os.stat(path(name)).st_mode), 0o600)
        run(OPTIONS.kerf, "token", "new", "owner", "--scope", "admin", "--file", path("tokens"), "--out", path("owner.token"))
        guards = ["--tls-cert", path("server.crt"), "--tls-key", path("server.key"), "--tls-client-ca", path("ca.crt"), "--tokens",
                  path("tokens")]
        addresses = ["--listen", "0.0.0.0:0", "--http", "0.0.0.0:0"]
        for left_out in range(0, len(guards), 2):
            refused = run(OPTIONS.kerfd, *addresses, *guards[:left_out], *guards[left_out + 2:], "--data", "none", code=2)
            self.assertEqual(refused.stderr.count("\n"), 1, refused.stderr)
        server = subprocess.Popen([OPTIONS.kerfd, *addresses, *guards, "--no-render", "--data", "none", "--max-load", "0"],
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            ready = json.loads(server.stdout.readline())
            self.check(f"127.0.0.1:{ready['grpc'].split(':')[-1]}", f"https://127.0.0.1:{ready['http'].split(':')[-1]}")
        finally:
            server.send_signal(signal.SIGTERM)
            server.stdout.close()
            self.assertEqual(server.wait(timeout=30), 0)

    def check(self, grpc, http):
        trust = ["--server", grpc, "--token-file", path("owner.token"), "--tls-ca", path("ca.crt")]
        certificate = ["--tls-cert", path("client.crt"), "--tls-key", path("client.key")]
        run(OPTIONS.kerf, *trust, *certificate, "sheet", "create", "demo", "--grid", "4x4", "--paused")
        run(OPTIONS.kerf, *trust, "sheet", "list", code=1)
        self.assertIn("TOKEN_MISSING", run(OPTIONS.kerf, "--server", grpc, *trust[4:], *certificate, "sheet", "list", code=1).stderr)
        url = run(OPTIONS.kerf, *trust, *certificate, "open", "demo", "--viewer", http).stdout.strip()
        self.assertTrue(url.startswith(f"{http}/?sheet=demo#code="), url)
        login = self.post(f"{http}/login", {"code": url.split("#code=")[1]})
        cookie = login.headers["set-cookie"]
        self.assertRegex(cookie, r"^__Host-kerf=[\w-]{43}; Path=/; Max-Age=\d+; Secure; HttpOnly; SameSite=Strict$")
        headers = {"Cookie": cookie.split(";")[0], "x-kerf-csrf": "1", "Origin": http}
        sheets = json.load(self.post(f"{http}/kerf.v1.SheetService/ListSheets", {}, headers))
        self.assertEqual([sheet["name"] for sheet in sheets["sheets"]], ["sheets/demo"])
        with self.assertRaises(urllib.error.HTTPError) as refused:
            self.post(f"{http}/kerf.v1.SheetService/ListSheets", {})
        self.assertEqual(refused.exception.code, 401)
        refused.exception.close()
        with self.assertRaises(urllib.error.URLError):  # a client that does not know the authority
            urllib.request.urlopen(f"{http}/healthz", timeout=30)

    def post(self, url, message, headers=None):
        request = urllib.request.Request(url, json.dumps(message).encode(), {"Content-Type": "application/json", **(headers or {})})
        response = urllib.request.urlopen(request, timeout=30, context=ssl.create_default_context(cafile=path("ca.crt")))
        self.addCleanup(response.close)
        return response

    def test_certificates_that_are_good_stay(self):
        folder = path("kept")
        run(ROOT / "deploy/certificates", folder, "a.example.org")
        texts = {file.name: file.read_text() for file in pathlib.Path(folder).iterdir()}
        run(ROOT / "deploy/certificates", folder, "a.example.org")
        self.assertEqual({file.name: file.read_text() for file in pathlib.Path(folder).iterdir()}, texts)
        run(ROOT / "deploy/certificates", folder, "b.example.org")
        changed = {file.name for file in pathlib.Path(folder).iterdir() if file.read_text() != texts[file.name]}
        self.assertEqual(changed, {"server.crt", "server.key", "server.names"})
        run("openssl", "verify", "-CAfile", f"{folder}/ca.crt", "-verify_hostname", "b.example.org", f"{folder}/server.crt")
        for wrong in ("", "a b", "a,DNS:evil", "$(id)"):
            self.assertIn("neither a host name nor an address", run(ROOT / "deploy/certificates", folder, wrong, code=2).stderr)
        self.assertIn("say FOLDER NAME", run(ROOT / "deploy/certificates", folder, code=2).stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("kerfd", "kerf", "work"):
        parser.add_argument(f"--{name}", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(module="__main__", argv=[sys.argv[0], *rest])
