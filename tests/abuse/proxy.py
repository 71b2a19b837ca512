#!/usr/bin/python3
"""Attacks a kerfd through HAProxy with deploy/haproxy.cfg, or with --direct on its own ports.

  tests/abuse/proxy.py --kerfd KERFD [--seconds 60] [--attack NAME] [--direct]

Each attack has a kerfd of its own with two sheets that never rest, and a client that cuts and steps a third one. Prints a row
an attack. Ends with status 1 where kerfd's memory grew by more than 16 MiB, or a hash differs from those without an attack.
"""

import argparse
import dataclasses
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

from floods import FLOODS
from guarded import Guarded, cpu_s
from victims import attacked, fork, memory_mb

MOST_GROWTH_MIB = 16.0
ROUND_S = 0.1  # of the honest client
CALLS_A_ROUND = 4
PATIENCE_S = 10.0  # of its calls
SETTLE_S = 1.0  # in which the first rounds take the memory that honest clients need
HEAD = ("attack", "did", "kerfd MiB, before", "peak", "grew", "end", "hashes", "calls served", "slowest ms", "ticks %",
        "HAProxy MiB", "CPU s: kerfd", "HAProxy")


@dataclasses.dataclass
class Row:
    name: str
    did: dict = dataclasses.field(default_factory=dict)
    before_mib: float = 0.0
    peak_mib: float = 0.0
    end_mib: float = 0.0
    hashes: list = dataclasses.field(default_factory=list)
    served: int = 0
    failed: int = 0
    slowest_ms: float = 0.0
    rate: float = 0.0  # ticks a second of the slower sheet
    proxy_mib: float = 0.0
    kerfd_cpu_s: float = 0.0
    proxy_cpu_s: float = 0.0
    fault: str = ""

    def grew_mib(self):
        return self.peak_mib - self.before_mib

    def faults(self, control):
        """Says what does not hold; empty where all does. The pace of ticks and calls depends on the machine."""
        return [text for broken, text in (
            (self.fault, self.fault), (self.grew_mib() > MOST_GROWTH_MIB, "memory"),
            (self.hashes != control.hashes or not self.hashes, "hashes")) if broken]

    def cells(self, control):
        did = ", ".join(f"{number:,} {what}" for what, number in sorted(self.did.items())) or "nothing"
        served = f"{self.served} of {self.served + self.failed}" if self.failed else str(self.served)
        cells = (self.name, did, f"{self.before_mib:.0f}", f"{self.peak_mib:.0f}", f"{self.grew_mib():+.1f}", f"{self.end_mib:.0f}",
                 "equal" if self.hashes == control.hashes else "DIFFER", served, f"{self.slowest_ms:.0f}",
                 f"{100 * self.rate / (control.rate or 1):.1f}", f"{self.proxy_mib:.0f}", f"{self.kerfd_cpu_s:.1f}",
                 f"{self.proxy_cpu_s:.1f}")
        return "| " + " | ".join(cells) + " |"


def serve(package, options, pipe):
    """Cuts and steps a sheet again and again from one saved state, which must give the same bits each time."""
    sys.path.insert(0, str(package))
    import kerf
    counts = {"served": 0, "failed": 0, "slowest_ms": 0.0, "hashes": set()}
    sheet, is_said = None, False
    while not pipe.poll(0.0 if sheet is None else ROUND_S):
        started = time.monotonic()
        try:
            if sheet is None:
                server = kerf.connect(timeout_s=PATIENCE_S, **options)
                sheet = server.create_sheet("honest", grid=(12, 12), paused=True)
                sheet.save_state("start")
            sheet.restore_state("start")
            sheet.cut(kerf.circle((0.5, 0.5), 0.2))
            sheet.step(5)
            counts["hashes"].add(sheet.get().state_hash)
            counts["served"] += CALLS_A_ROUND
        except kerf.Error as error:
            counts["failed"] += CALLS_A_ROUND
            counts["error"] = str(error)[:200]
            if sheet is None:
                time.sleep(ROUND_S)
        counts["slowest_ms"] = max(counts["slowest_ms"], 1000 * (time.monotonic() - started) / CALLS_A_ROUND)
        if counts["served"] and not is_said:
            is_said = True
            pipe.send("served")
    pipe.recv()
    pipe.send(counts)


class Honest:
    """The honest client in a process of its own."""

    def __init__(self, package, server):
        self.pipe, there = fork.Pipe()
        options = {**server.honest, "token": server.tokens["admin"]}
        self.process = fork.Process(target=serve, args=(package, options, there), daemon=True)
        self.process.start()
        if not self.pipe.poll(60) or self.pipe.recv() != "served":
            raise RuntimeError("the honest client was not served at all")

    def counts(self):
        self.pipe.send("counts")
        if not self.pipe.poll(60):
            raise RuntimeError("the honest client does not answer")
        return self.pipe.recv()


def peaks(process, stopped, found):
    while not stopped.wait(0.1):
        found.append(memory_mb(process, "VmRSS"))


def measure(options, package, name, row):
    with Guarded(options.kerfd, options.kerf, options.direct) as server:
        honest = Honest(package, server)
        time.sleep(SETTLE_S)
        attack = FLOODS.get(name)
        server.forget_peak()
        row.before_mib = memory_mb(server.process, "VmRSS")
        stopped, sizes = threading.Event(), [0.0]
        proxy = server.proxy and server.proxy.process
        if proxy:
            threading.Thread(target=peaks, args=(proxy, stopped, sizes), daemon=True).start()
        begun = [cpu_s(process) if process else 0.0 for process in (server.process, proxy)]
        before = server.ticks()
        with attacked(server, attack) as counts:
            time.sleep(options.seconds)
            row.did = counts()
            after = server.ticks()
            ended = [cpu_s(process) if process else 0.0 for process in (server.process, proxy)]
            row.peak_mib = memory_mb(server.process, "VmHWM")
            row.end_mib = memory_mb(server.process, "VmRSS")
            found = honest.counts()
        stopped.set()
        row.rate = min((tick - first) / (at - begin) for (begin, first), (at, tick) in zip(before, after))
        row.kerfd_cpu_s, row.proxy_cpu_s = (end - begin for begin, end in zip(begun, ended))
        row.proxy_mib = max(sizes)
        row.served, row.failed, row.slowest_ms = found["served"], found["failed"], found["slowest_ms"]
        row.hashes = server.hashes(options.seconds) + sorted(found["hashes"])
        if found["failed"]:
            print(f"{name}: {found['error']}", file=sys.stderr)


def run(options, package, name):
    row = Row(name)
    try:
        measure(options, package, name, row)
    except (RuntimeError, OSError) as error:
        row.fault = f"{type(error).__name__}: {error}"
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kerfd", type=pathlib.Path, required=True)
    parser.add_argument("--kerf", type=pathlib.Path, help="the command, beside kerfd")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--attack", choices=FLOODS, action="append")
    parser.add_argument("--direct", action="store_true", help="without a proxy")
    options = parser.parse_args()
    options.kerf = options.kerf or options.kerfd.with_name("kerf")
    broken = []
    with tempfile.TemporaryDirectory() as package:
        subprocess.run([pathlib.Path(__file__).resolve().parents[2] / "client/python/generate", package], check=True)
        print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD), flush=True)
        control = run(options, package, "control")
        for name in ("control", *(options.attack or FLOODS)):
            row = control if name == "control" else run(options, package, name)
            print(row.cells(control), flush=True)
            if row.faults(control):
                broken.append(f"{name} ({'; '.join(row.faults(control))})")
    print(f"\n{'all hold' if not broken else 'broken: ' + ', '.join(broken)}")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
