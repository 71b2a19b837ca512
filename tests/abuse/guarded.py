"""Runs a kerfd with two sheets that never rest, and before it HAProxy with deploy/haproxy.cfg, on free ports."""

import http.client
import json
import math
import os
import pathlib
import signal
import socket
import ssl
import subprocess
import tempfile
import time
import urllib.request

from victims import address_of, scene

ROOT = pathlib.Path(__file__).resolve().parents[2]
HAPROXY = "/usr/sbin/haproxy"
HOST = "sheets.example.org"  # as which browsers know the proxy
CALM = ("v0", "v1")  # of victims.scene(); v0 has cuts
TICKS_PER_S = 60
SCOPES = ("view", "cut", "admin")


def make_keys(folder, kerf):
    """Makes certificates and a token of each scope; gives the tokens."""
    subprocess.run([ROOT / "deploy/certificates", folder, HOST], check=True)
    tokens = {}
    for scope in SCOPES:
        file = folder / f"{scope}.token"
        if not file.exists():
            subprocess.run([kerf, "token", "new", scope, "--scope", scope, "--file", folder / "tokens", "--out", file],
                           check=True, stdout=subprocess.DEVNULL)
        tokens[scope] = file.read_text().strip()
    return tokens


def free_socket():
    """Listens on a free port, for a HAProxy that inherits it."""
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    listener.listen(1024)
    return listener


class Proxy:
    """HAProxy with the shipped file before a kerfd, or before none."""

    def __init__(self, folder, listener, ready, **environment):
        self.port = listener.getsockname()[1]
        variables = {"KERF_PROXY_LISTEN": f"fd@{listener.fileno()}", "KERF_PROXY_CERT": str(folder / "server.crt"),
                     "KERF_PROXY_SOCKET": f"kerf-{os.getpid()}-{self.port}", "KERF_LISTEN": ready["grpc"],
                     "KERF_HTTP": ready["http"].removeprefix("http://"), **environment}
        self.errors = open(folder / "haproxy.errors", "a+")
        self.process = subprocess.Popen([HAPROXY, "-db", "-f", ROOT / "deploy/haproxy.cfg"], env={**os.environ, **variables},
                                        pass_fds=[listener.fileno()], stdout=self.errors, stderr=self.errors)
        self.authority = str(folder / "ca.crt")

    def context(self, *protocols):
        made = ssl.create_default_context(cafile=self.authority)
        made.set_alpn_protocols(protocols)
        return made

    def address(self, *protocols):
        return "127.0.0.1", self.port, self.context(*protocols)

    def options(self):
        """Gives the options of kerf.connect()."""
        return {"address": f"localhost:{self.port}", "tls_ca": self.authority}

    def stop(self):
        stop(self.process)
        self.errors.close()


class Browser:
    """One connection of HTTP/1.1 through a proxy."""

    def __init__(self, proxy, source="127.0.0.1"):
        self.connection = http.client.HTTPSConnection("localhost", proxy.port, timeout=30, context=proxy.context("http/1.1"),
                                                      source_address=(source, 0))

    def ask(self, target, message=None, **headers):
        """Gives the status, the headers and the body of the answer."""
        body = None if message is None else json.dumps(message)
        known = {"Content-Type": "application/json"} if body else {}
        self.connection.request("POST" if body else "GET", target, body,
                                {**known, **{name.replace("_", "-"): value for name, value in headers.items()}})
        answer = self.connection.getresponse()
        return answer.status, answer.headers, answer.read().decode()

    def log_in(self, token, **headers):
        return self.ask("/login", {"token": token}, **headers)

    def close(self):
        self.connection.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def reason_of(body):
    """Gives the reason of a refusal by kerfd, or by the proxy in its place."""
    return next(detail["reason"] for detail in json.loads(body)["details"] if "reason" in detail)


def start_proxy(test, server, ready=None, **environment):
    """Starts one more HAProxy for a test, before the same kerfd or before another server."""
    with free_socket() as listener:
        proxy = Proxy(server.folder, listener, ready or server.ready, **environment)
    test.addCleanup(proxy.stop)
    return proxy


class Guarded:
    """Shows attacks the addresses `grpc` and `http`: those of the proxy, or with `direct` of kerfd itself."""

    def __init__(self, kerfd, kerf, direct=False):
        self.kerf = kerf
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.tokens = make_keys(self.folder, kerf)
        self.token = self.tokens["view"]  # that the attacker has
        for number, name in enumerate(CALM):
            (self.folder / f"{name}.json").write_text(json.dumps(scene(number)))
        scenes = [self.folder / f"{name}.json" for name in CALM]
        self.proxy = None
        listener = None if direct else free_socket()
        behind = [] if direct else ["--allow-origin", f"https://{HOST}", "--behind-proxy"]
        self.errors = open(self.folder / "kerfd.errors", "w")
        self.process = subprocess.Popen(
            [kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none", "--no-render", "--max-load", "0",
             "--tokens", self.folder / "tokens", *behind, "--scene", *scenes], stdout=subprocess.PIPE, stderr=self.errors, text=True)
        self.ready = json.loads(self.process.stdout.readline())
        self.grpc, self.http = address_of(self.ready["grpc"]), address_of(self.ready["http"].removeprefix("http://"))
        self.honest = {"address": self.ready["grpc"]}
        if listener:
            self.proxy = Proxy(self.folder, listener, self.ready)
            listener.close()
            self.grpc, self.http = self.proxy.address("h2"), self.proxy.address("http/1.1")
            self.honest = self.proxy.options()

    def call(self, method, patience_s=60, **fields):
        """Makes a call as JSON on kerfd's own port; tries again where the server is too busy to answer."""
        headers = {"Content-Type": "application/json", "Authorization": f"Bearer {self.tokens['admin']}"}
        request = urllib.request.Request(f"{self.ready['http']}/kerf.v1.{method}", json.dumps(fields).encode(), headers)
        end = time.monotonic() + patience_s
        while True:
            try:
                with urllib.request.urlopen(request, timeout=patience_s) as answer:
                    return json.load(answer)
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.02)

    def ticks(self):
        """Notes the time and the tick of each sheet."""
        return [(time.monotonic(), int(self.call("SheetService/GetSheet", name=f"sheets/{name}")["tick"])) for name in CALM]

    def hashes(self, seconds):
        """Stops the sheets, steps them to a tick that depends on the length of the run alone, and gives their hashes there."""
        last = math.ceil((seconds + 30) * TICKS_PER_S)
        found = []
        for name in CALM:
            tick = int(self.call("SheetService/PauseSheet", name=f"sheets/{name}")["tick"])
            if tick >= last:
                raise RuntimeError(f"{name} is at tick {tick} already, beyond {last}")
            self.call("SheetService/StepSheet", name=f"sheets/{name}", ticks=last - tick)
            sheet = self.call("SheetService/GetSheet", name=f"sheets/{name}")
            found.append((sheet["tick"], sheet["state_hash"]))
        return found

    def forget_peak(self):
        """Begins the high water of kerfd's memory from what it has now."""
        pathlib.Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def stop(self):
        if self.proxy:
            self.proxy.stop()
        status = stop(self.process)
        self.process.stdout.close()
        self.errors.close()
        self.kept.cleanup()
        return status

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()


def stop(process):
    """Ends a process in order, or after a minute by force; gives its status."""
    process.send_signal(signal.SIGTERM)
    try:
        return process.wait(60)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def cpu_s(process):
    """Gives the processor time that a process has taken."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
