#!/usr/bin/env python3
"""Prints how long a kerfd with many running sheets takes to start again after SIGKILL, and after SIGTERM.

    restart.py KERFD --sheets 64 --columns 50 --seconds 25

Each sheet is held at its upper edge and has one cut. The sheets may need more than the machine has: they run as fast as they can.
"""
import argparse
import signal
import tempfile
import time

from server import Server, line_cut, scene


def started(*command):
    """Starts a server. Returns it with the seconds until it was ready."""
    begin = time.perf_counter()
    return Server(*command), time.perf_counter() - begin


def ended(server, how):
    """Ends a server. Returns the seconds that this took."""
    begin = time.perf_counter()
    server.end(how)
    return time.perf_counter() - begin


def make_sheets(server, options):
    for i in range(options.sheets):
        server.call("SheetService/CreateSheet", {"sheet_id": f"a{i}", "scene": scene(options.columns)})
        server.call("CutService/CreateCut", line_cut(f"sheets/a{i}", (0.2, 0.5), (0.7, 0.4)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kerfd")
    parser.add_argument("--sheets", type=int, default=64)
    parser.add_argument("--columns", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=25)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        command = (options.kerfd, "--data", folder + "/store")
        server, _ = started(*command)
        make_sheets(server, options)
        time.sleep(options.seconds)
        server.end(signal.SIGKILL)
        server, seconds = started(*command)
        assert len(server.call("SheetService/ListSheets", {"page_size": 1000})["sheets"]) == options.sheets
        print(f"ready after SIGKILL: {seconds:.1f} s")
        time.sleep(5)
        print(f"ended by SIGTERM:    {ended(server, signal.SIGTERM):.1f} s")
        server, seconds = started(*command)
        print(f"ready after it:      {seconds:.1f} s")
        server.end(signal.SIGTERM)


if __name__ == "__main__":
    main()
