#!/usr/bin/env python3
"""Measures what the sheets of a busy tenant take from those of another: the pace of both, with tenants and without.

    fair_turns.py KERFD [SECONDS]

Two runs stand side by side: in each, many sheets of `busy-` need more than all workers, and a few of `calm-` need little.
"""

import hashlib
import pathlib
import signal
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "durable"))
from server import Server, scene  # noqa: E402

BUSY, BUSY_SIDE = 24, 70
CALM, CALM_SIDE = 4, 30


def token_file(folder, tenants):
    """Writes tokens of which one reaches everything, with its text."""
    token = "kerf_bench_" + 43 * "A"
    path = pathlib.Path(folder) / "tokens"
    limits = "sheets=0 vertices=0 workers=0 cuts-per-s=0"
    lines = [f"tenant busy {limits}", f"tenant calm {limits}"] if tenants else []
    path.write_text("\n".join([*lines, f"bench {hashlib.sha256(token.encode()).hexdigest()} scope=admin", ""]))
    return path, token


def run(kerfd, seconds, tenants):
    with tempfile.TemporaryDirectory() as folder:
        path, token = token_file(folder, tenants)
        server = Server(kerfd, "--data", "none", "--tokens", str(path), "--workers", "2", token=token)
        try:
            for name, count, side in (("calm", CALM, CALM_SIDE), ("busy", BUSY, BUSY_SIDE)):
                for number in range(count):
                    server.call("SheetService/CreateSheet", {"sheet_id": f"{name}-{number}", "scene": scene(side, rest_damping=False)})
            before, begin = ticks(server), time.monotonic()
            time.sleep(seconds)
            after, passed = ticks(server), time.monotonic() - begin
            pace = {name: sum(after[sheet] - before[sheet] for sheet in after if sheet.startswith(name)) / (60.0 * passed)
                    for name in ("calm", "busy")}
            return pace["calm"] / CALM, pace["busy"] / BUSY
        finally:
            server.end(signal.SIGKILL)


def ticks(server):
    listed = server.call("SheetService/ListSheets", {"page_size": 100})["sheets"]
    return {sheet["name"].split("/")[1]: int(sheet["tick"]) for sheet in listed}


def main():
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 20.0
    print(f"busy: {BUSY} sheets of {BUSY_SIDE} x {BUSY_SIDE}; calm: {CALM} of {CALM_SIDE} x {CALM_SIDE}; 2 workers, {seconds:g} s")
    print("part of 60 ticks a second that each sheet made")
    print("               calm   busy")
    for tenants in (False, True):
        calm, busy = run(sys.argv[1], seconds, tenants)
        print(f"{'with tenants' if tenants else 'without     '}  {calm:6.3f} {busy:6.3f}", flush=True)


if __name__ == "__main__":
    main()
