"""Starts a kerfd with nine sheets that never rest, and measures it."""

import contextlib
import json
import multiprocessing
import os
import pathlib
import re
import shlex
import signal
import subprocess
import tempfile
import threading
import time

from clients import Caller, call_headers

VICTIMS = [f"v{number}" for number in range(9)]
INFO_PATIENCE_S = 15
STOP_PATIENCE_S = 60
NICE = 10  # attackers take the time that the server leaves

fork = multiprocessing.get_context("fork")


def scene(number):
    """Makes a hanging sheet in a wind of its own; each fourth one cuts itself."""
    wind = {"velocity_mps": {"x": 0.3 * number, "y": 3 + 0.5 * number}}
    made = {"sheet_id": VICTIMS[number], "grid": {"columns": 12, "rows": 12, "width_m": 1, "height_m": 1},
            "pins": [{"edge": "TOP_CORNERS"}], "wind": wind}
    if number % 4 == 0:
        line = [{"x": 0.3, "y": 0.2}, {"x": 0.5, "y": 0.35}, {"x": 0.7, "y": 0.5}]
        disc = {"center": {"x": 0.3, "y": 0.7}, "radius_m": 0.1}
        made["commands"] = [{"tick": 120, "command": {"cut": {"curve": {"polyline": {"points": line}}}}},
                            {"tick": 360, "command": {"cut": {"curve": {"circle": disc}}}}]
    return made


class Server:
    """Runs kerfd with its victims, each recorded, in a folder of its own."""

    def __init__(self, kerfd, kerf, limit=""):
        self.kerf = kerf
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.records = self.folder / "records"
        self.records.mkdir()
        scenes = [self.folder / f"{name}.json" for name in VICTIMS]
        for number, file in enumerate(scenes):
            file.write_text(json.dumps(scene(number)))
        command = [kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none", "--no-render", "--max-load", "0",
                   "--record", self.records, "--scene", *scenes]
        words = f"{limit or ':'}; exec {shlex.join(map(str, command))}"
        with (self.folder / "errors").open("w") as errors:
            self.process = subprocess.Popen(["bash", "-c", words], stdout=subprocess.PIPE, stderr=errors, text=True)
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"kerfd ended at once: {self.errors()}")
        ready = json.loads(line)
        self.grpc = address_of(ready["grpc"])
        self.http = address_of(ready["http"].removeprefix("http://"))
        self.caller = Caller(self.http, "127.0.0.1")

    def errors(self):
        return (self.folder / "errors").read_text()[-400:]

    def memory_mb(self, field):
        return memory_mb(self.process, field)

    def samples(self):
        """Notes the time and the tick of each victim."""
        return {name: (time.monotonic(), int(self.sheet(name)["tick"])) for name in VICTIMS}

    def sheet(self, name):
        """Asks again where the server is too busy to answer, for some time."""
        patience = time.monotonic() + INFO_PATIENCE_S
        while True:
            try:
                status, message = self.caller.call("SheetService/GetSheet", name=f"sheets/{name}")
                if status == 200:
                    return message
            except OSError:
                message = "no answer"
            if time.monotonic() > patience:
                raise RuntimeError(f"GetSheet {name}: {message}")
            time.sleep(0.05)

    def info_ms(self):
        """Gives the milliseconds until `kerf info` has answered; nothing where it does not."""
        started = time.monotonic()
        try:
            done = subprocess.run([self.kerf, "--server", "%s:%d" % self.grpc, "info"], timeout=INFO_PATIENCE_S,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        except subprocess.TimeoutExpired:
            return None
        return round((time.monotonic() - started) * 1000) if done.returncode == 0 else None

    def stop(self):
        """Gives exit status and seconds after SIGTERM; kills a server that does not end."""
        started = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        try:
            status = self.process.wait(STOP_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        return status, time.monotonic() - started

    def identical(self, ticks):
        """Counts the victims whose recording reaches the tick that was seen and replays to the same bits."""
        count = 0
        for name in VICTIMS:
            files = list(self.records.glob(f"{name}-*.kerf"))
            if len(files) != 1:
                continue
            done = subprocess.run([self.kerf, "replay", files[0]], capture_output=True, text=True, check=False)
            found = re.match(r"identical, bit for bit: ([\d,]+) ticks", done.stdout)
            count += done.returncode == 0 and bool(found) and int(found.group(1).replace(",", "")) >= ticks[name]
        return count

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self.kept.cleanup()


def memory_mb(process, field):
    """Reads a size from /proc, such as VmRSS; 0 where the process has ended."""
    try:
        text = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return 0
    found = re.search(rf"^{field}:\s+(\d+) kB", text, re.MULTILINE)
    return int(found.group(1)) / 1024 if found else 0


def address_of(text):
    host, port = text.rsplit(":", 1)
    return host, int(port)


class Target:
    """Shows an attack the server, and keeps its counts."""

    def __init__(self, server):
        self.grpc, self.http, self.kerf, self.folder = server.grpc, server.http, server.kerf, server.folder
        self.token = getattr(server, "token", "")  # that the attacker has; empty where none is needed
        self.headers = call_headers(self.token)
        self.counts = {}
        self.lock = threading.Lock()

    def count(self, what, number=1):
        with self.lock:
            self.counts[what] = self.counts.get(what, 0) + number


def repeat(attack, target, number):
    while True:
        try:
            attack.run(target, number)
        except Exception as error:
            target.count(type(error).__name__)
            time.sleep(0.02)


def attack_until_killed(attack, target, asked):
    """Runs an attack's threads, and answers one question with the counts so far."""
    os.nice(NICE)
    for number in range(attack.threads):
        threading.Thread(target=repeat, args=(attack, target, number), daemon=True).start()
    asked.recv()
    with target.lock:
        asked.send(dict(target.counts))
    threading.Event().wait()


@contextlib.contextmanager
def attacked(server, attack):
    """Gives a function that returns the counts; the attack lasts as long as the block, even beyond the server."""
    if attack is None:
        yield dict
        return
    here, there = fork.Pipe()
    process = fork.Process(target=attack_until_killed, args=(attack, Target(server), there), daemon=True)
    process.start()

    def counts():
        here.send("counts")
        return here.recv()

    try:
        yield counts
    finally:
        process.kill()
        process.join()
