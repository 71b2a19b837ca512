#!/usr/bin/env python3
"""The figures of tests/bench/notes/load.md: kerfd and `kerf load` on this machine, scenario by scenario.

  tests/bench/load_scenarios.py --bin build/release/bin [--only NAME] [--duration SECONDS]

Prints a row a run, as Markdown. Counts are checked that must hold on any machine: no error, no frame without its cut, no
sheet that ticks asleep, and no more than stalled readers may cost. A row that breaks one ends the program with code 1.
"""

import argparse
import contextlib
import json
import pathlib
import signal
import subprocess
import sys

OPTIONS = None
BROKEN = []


@contextlib.contextmanager
def server(*options, draws=False):
    """A kerfd on free ports; gives its addresses and process id."""
    options = [*options] if draws else ["--no-render", *options]
    process = subprocess.Popen([OPTIONS.bin / "kerfd", "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none",
                                "--max-connections-per-address", "0", *options],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        ready = json.loads(process.stdout.readline())
        yield {"grpc": ready["grpc"], "http": ready["http"].removeprefix("http://"), "pid": str(process.pid)}
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=30)


def load(running, *options, duration=None):
    command = [OPTIONS.bin / "kerf", "--server", running["grpc"], "--json", "load", "--http", running["http"],
               "--server-pid", running["pid"], "--duration", str(duration or OPTIONS.duration), *map(str, options)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{command} left with {done.returncode}")
    return json.loads(done.stdout)


def must(holds, what):
    if not holds:
        BROKEN.append(what)
        print(f"BROKEN: {what}", file=sys.stderr)


def ms(histogram, *names):
    return " / ".join(f"{histogram[name] / 1000:.1f}" for name in names)


def row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def head(*cells):
    row(*cells)
    print("|" + "---|" * len(cells), flush=True)


def control(report):
    return ms(report["control_us"], "p50", "p99", "max")


def capacity():
    """Finds how many sheets of 32 x 32 vertices run at 60 Hz, and what happens beyond, without admission control."""
    head("sheets", "real time: least / median / most", "slipped", "overruns of ticks", "server cores", "CPU a tick, ms", "sheets that two cores carry", "load", "control: p50 / p99 / max, ms")
    for sheets in OPTIONS.sheets:
        with server("--max-sheets", "1000", "--max-load", "0") as running:
            report = load(running, "--sheets", sheets, "--viewers", 0, "--warm-up", 3)
        found = report["sheets"]
        pace = found["real_time_factor"]
        tick_ms = 1000 * report["server_cores"] * report["measured_s"] / max(found["ticks"], 1)
        must(found["running"] == sheets and not report["errors"], f"{sheets} sheets run: {found['running']}, {report['errors']}")
        row(sheets, f"{pace['least']:.3f} / {pace['median']:.3f} / {pace['most']:.3f}", found["slipped"],
            f"{found['overruns']} of {found['ticks']}", f"{report['server_cores']:.2f}", f"{tick_ms:.2f}",
            f"{2000 / 60 / tick_ms:.0f}", f"{report['probes'][-1]['load']:.2f}", control(report))


def admission():
    """200 sheets are asked for; those beyond the load are refused."""
    head("asked for", "made", "refused", "real time: least / median / most", "words of the server")
    with server("--max-sheets", "1000") as running:
        report = load(running, "--sheets", 200, "--viewers", 0, "--warm-up", 3)
    found = report["sheets"]
    pace = found["real_time_factor"]
    must(set(found["refusals"]) <= {"OVERLOADED"}, f"refused for {found['refusals']}")
    row(200, found["made"], found["refusals"], f"{pace['least']:.3f} / {pace['median']:.3f} / {pace['most']:.3f}", found["first_refusal"])


def sleepers():
    """Sheets that sleep."""
    head("sheets", "vertices", "ticks", "server cores", "memory, kB a sheet", "list: pages, ms", "made in, s")
    for sheets, grid in ((200, "32x32"), (10000, "4x4")):
        with server("--max-sheets", "10000") as running:
            empty = load(running, "--sheets", 1, "--still", "--viewers", 0, duration=0.1)
            report = load(running, "--sheets", sheets, "--grid", grid, "--still", "--viewers", 0, "--warm-up", 5)
        found = report["sheets"]
        must(found["made"] == sheets and found["ticks"] == 0 and not report["errors"], f"{found['made']} asleep, {found['ticks']} ticks, {report['errors']}")
        grown = report["probes"][-1]["server_resident_bytes"] - empty["probes"][-1]["server_resident_bytes"]
        row(sheets, grid, found["ticks"], f"{report['server_cores']:.5f}", f"{grown / sheets / 1000:.1f}",
            f"{found['list_pages']}, {1000 * found['list_s']:.0f}", f"{found['creation_s']:.1f}")


def readers():
    """One reader of a 10,000-vertex sheet at 60 Hz: beside the server and far away; quick and slow."""
    head("reader", "way, each direction", "frames/s", "age when decoded: p50 / p99, ms", "age of what is shown: p50 / p99, ms", "control: p50 / p99 / max, ms")
    for way in ((), ("--way", 25), ("--way", 100), ("--way", 25, "--way-rate", 1000)):
        for name, role, options in (("60 Hz", "viewers", ("--viewers", 1)),
                                    ("holds each 0.1 s", "slow readers", ("--viewers", 0, "--slow-readers", 1, "--hold", 0.1)),
                                    ("holds each 0.5 s", "slow readers", ("--viewers", 0, "--slow-readers", 1, "--hold", 0.5))):
            with server() as running:
                report = load(running, "--grid", "100x100", *options, *way)
            of = report["readers"][role]
            must(of["readers"] == 1 and not of["ends"], f"{name} {way}: {of['ends']}")
            row(name, " ".join(map(str, way)) or "none", f"{of['frames'] / report['window_s']:.1f}", ms(of["age_us"], "p50", "p99"),
                ms(of["shown_us"], "p50", "p99"), control(report))


def crowd():
    """60 viewers of one 10,000-vertex sheet at 30 Hz."""
    head("transport", "frames/s each", "kB/s each", "age when decoded: p50 / p99, ms", "server cores", "client cores", "control: p50 / p99 / max, ms")
    for transport in ("grpc", "ws"):
        with server() as running:
            report = load(running, "--grid", "100x100", "--viewers", 60, "--viewer-rate", 30, "--transport", transport)
        of = report["readers"]["viewers"]
        must(of["readers"] == 60 and not of["ends"], f"crowd: {of['readers']} joined, {of['ends']}")
        each = 60 * report["window_s"]
        row(transport, f"{of['frames'] / each:.1f}", f"{of['bytes'] / each / 1000:.0f}", ms(of["age_us"], "p50", "p99"),
            f"{report['server_cores']:.2f}", f"{report['client_cores']:.2f}", control(report))


def stalled():
    """A viewer of a 10,000-vertex sheet, alone and beside 100 that stall; by turns."""
    head("beside it", "frames/s", "age when decoded: p50 / p99, ms", "server memory grows by, MB", "stalled ones, how they ended", "control: p50 / p99 / max, ms")
    for count in (0, 100, 0, 100):
        with server() as running:
            report = load(running, "--grid", "100x100", "--viewers", 1, "--stalled-readers", count, "--warm-up", 3, duration=max(OPTIONS.duration, 13))
        of = report["readers"]["viewers"]
        ends = report["readers"]["stalled readers"]
        first = report["probes"][0]["server_resident_bytes"]
        most = max(probe["server_resident_bytes"] for probe in report["probes"])
        must(not of["ends"], f"the viewer was ended: {of['ends']}")
        must(ends["readers"] == count and ends["ends"] == ({"TOO_SLOW": count} if count else {}), f"stalled: {ends['readers']}, {ends['ends']}")
        must(most - first <= 100e6, f"{count} stalled readers cost {(most - first) / 1e6:.1f} MB")
        row(f"{count} stalled", f"{of['frames'] / report['window_s']:.1f}", ms(of["age_us"], "p50", "p99"), f"{(most - first) / 1e6:.1f}",
            ends["ends"] or "-", control(report))


def pictures():
    """Viewers of one sheet in pictures of 640 x 360 that the server draws: the same view, so that each is drawn once."""
    head("viewers", "pictures/s each", "kB/s each", "age when it came: p50 / p99, ms", "ticks a second", "server cores",
         "control: p50 / p99 / max, ms")
    for viewers in (1, 4, 16):
        with server(draws=True) as running:
            report = load(running, "--viewers", 0, "--image-viewers", viewers)
        of = report["readers"]["image viewers"]
        must(of["readers"] == viewers and not of["ends"], f"pictures: {of['readers']} joined, {of['ends']}")
        each = viewers * report["window_s"]
        row(viewers, f"{of['frames'] / each:.1f}", f"{of['bytes'] / each / 1000:.0f}", ms(of["age_us"], "p50", "p99"),
            f"{report['sheets']['ticks'] / report['measured_s']:.1f}", f"{report['server_cores']:.2f}", control(report))


def cuts():
    """Cuts of watched sheets."""
    head("sheets", "cuts/s", "applied", "ticks to it: p50 / p99 / max", "reply: p50 / p99, ms", "frame that shows it: p50 / p99, ms",
         "shown without it", "join: p50 / max, ms", "control: p50 / p99 / max, ms")
    for sheets, rate, grid in ((1, 10, "32x32"), (1, 10, "100x100"), (8, 40, "32x32")):
        with server() as running:
            report = load(running, "--sheets", sheets, "--grid", grid, "--viewers", sheets, "--cuts-per-second", rate)
        of = report["cuts"]
        must(of["seen_without"] == 0 and not report["errors"], f"cuts: {of['seen_without']} shown without, {report['errors']}")
        ticks = of["reply_ticks"]
        row(f"{sheets} of {grid}", rate, f"{of['applied']} of {of['sent']}", f"{ticks['p50']} / {ticks['p99']} / {ticks['max']}",
            ms(of["reply_us"], "p50", "p99"), ms(of["seen_us"], "p50", "p99"), of["seen_without"],
            ms(report["readers"]["viewers"]["join_us"], "p50", "max"), control(report))


SCENARIOS = {scenario.__name__: scenario for scenario in (capacity, admission, sleepers, readers, crowd, stalled, pictures, cuts)}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of kerf and kerfd")
    parser.add_argument("--only", choices=SCENARIOS, action="append", help="scenario; repeatable")
    parser.add_argument("--duration", type=float, default=10.0, help="seconds that each run measures")
    parser.add_argument("--sheets", type=int, nargs="+", default=[16, 32, 48, 64, 96, 128, 192], help="of `capacity`")
    OPTIONS = parser.parse_args()
    for name in OPTIONS.only or SCENARIOS:
        print(f"\n{name}: {SCENARIOS[name].__doc__}\n", flush=True)
        SCENARIOS[name]()
    sys.exit(1 if BROKEN else 0)
