#!/usr/bin/env python3
"""Attacks a kerfd in many ways, and proves that nine sheets beside the attack take the same ticks, at the same pace.

  tests/abuse/attacks.py KERFD KERF [--seconds 12] [--only NAME]

Ends with status 1 where a row does not hold. Attacks that are left to a proxy may take memory and the port of gRPC.
`--only soak --seconds 1200` looks for growing memory, and runs by name alone.
"""

import argparse
import dataclasses
import pathlib
import statistics
import sys
import time

from kinds import ATTACKS
from soak import soak
from victims import INFO_PATIENCE_S, Server, attacked

LEAST_PACE = 98.0  # per cent of the controls' ticks
MOST_STOP_S = 10.0
HEAD = ("attack", "did", "ticks least / mean %", "identical", "info ms", "SIGTERM", "VmHWM MB", "")


@dataclasses.dataclass
class Row:
    name: str
    did: dict = dataclasses.field(default_factory=dict)
    rates: list = dataclasses.field(default_factory=list)  # ticks a second, by victim
    identical: int = 0
    infos: list = dataclasses.field(default_factory=list)  # milliseconds, or nothing
    stopped: tuple = (None, 0.0)
    high_mb: float = 0.0
    most_mb: int = 600
    left_to_proxy: bool = False
    fault: str = ""

    def paces(self, rate):
        return [100 * each / rate for each in self.rates] or [0.0]

    def faults(self, rate):
        """Says what does not hold; empty where all does. Sheets must hold in any case."""
        return [text for broken, text in (
            (self.fault, self.fault), (min(self.paces(rate)) < LEAST_PACE, "slow"), (self.identical < 9, "replays")) if broken]

    def transport_faults(self):
        """Says what does not hold of the process and its port; a proxy is to keep some attacks from both."""
        status, stop_s = self.stopped
        return [text for broken, text in (
            (not self.infos or None in self.infos, f"no info in {INFO_PATIENCE_S} s"), (status != 0, "exit status"),
            (stop_s > MOST_STOP_S, "stops late"), (self.high_mb > self.most_mb, "memory")) if broken]

    def breaks(self, rate):
        return bool(self.faults(rate) or (self.transport_faults() and not self.left_to_proxy))

    def verdict(self, rate):
        found = "; ".join(self.faults(rate) + self.transport_faults())
        if found and not self.breaks(rate):
            return "left to a proxy: " + found
        return found or "holds"

    def cells(self, rate):
        status, stop_s = self.stopped
        paces = self.paces(rate)
        did = ", ".join(f"{number:,} {what}" for what, number in sorted(self.did.items()))
        infos = " ".join("none" if each is None else str(each) for each in self.infos)
        return (self.name, did or "nothing", f"{min(paces):.1f} / {statistics.mean(paces):.1f}", f"{self.identical}/9", infos,
                f"{status}, {stop_s:.1f} s", f"{self.high_mb:.0f}", self.verdict(rate))


def measure(server, attack, seconds, row):
    """Fills in a row, as far as the server lets it."""
    before = server.samples()
    with attacked(server, attack) as counts:
        started = time.monotonic()
        for share in (0.25, 0.5, 0.75):
            time.sleep(max(0.0, started + share * seconds - time.monotonic()))
            row.infos.append(server.info_ms())
        time.sleep(max(0.0, started + seconds - time.monotonic()))
        after = server.samples()
        row.did = counts()
        row.high_mb = server.memory_mb("VmHWM")
        row.stopped = server.stop()
    row.rates = [(after[name][1] - tick) / (after[name][0] - at) for name, (at, tick) in before.items()]
    row.identical = server.identical({name: tick for name, (_, tick) in after.items()})


def run(options, name):
    row = Row(name)
    attack = ATTACKS.get(name)
    if attack:
        row.most_mb = attack.most_mb
        row.left_to_proxy = attack.left_to_proxy
    with Server(options.kerfd, options.kerf, attack.limit if attack else "") as server:
        try:
            measure(server, attack, options.seconds, row)
        except RuntimeError as error:
            row.fault = f"{error}; {server.errors()}"
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kerfd", type=pathlib.Path)
    parser.add_argument("kerf", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=12.0)
    parser.add_argument("--only", choices=[*ATTACKS, "soak"])
    options = parser.parse_args()
    if options.only == "soak":
        with Server(options.kerfd, options.kerf) as server:
            return 0 if soak(server, options.seconds) else 1
    names = ["control", *([options.only] if options.only else ATTACKS), "control"]
    rows = []
    for number, name in enumerate(names, start=1):
        print(f"[{number}/{len(names)}] {name}", flush=True)
        rows.append(run(options, name))
    rates = [rate for row in rows if row.name == "control" for rate in row.rates]
    rate = statistics.mean(rates) if rates else 1.0
    for index, row in enumerate(rows):
        if row.faults(rate) == ["slow"]:  # another program may have had the machine
            print(f"[again] {row.name}: {min(row.paces(rate)):.1f} % of the controls' ticks", flush=True)
            rows[index] = run(options, row.name)
    print("\n| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    for row in rows:
        print("| " + " | ".join(row.cells(rate)) + " |")
    broken = [row.name for row in rows if row.breaks(rate)]
    print(f"\n{len(rows) - len(broken)} hold, {len(broken)} do not{': ' if broken else ''}{', '.join(broken)}")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
