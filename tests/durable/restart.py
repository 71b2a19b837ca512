#!/usr/bin/env python3
"""Prints how long a kerfd with many running sheets takes to start again after SIGKILL, and after SIGTERM.

    restart.py KERFD --sheets 64 --columns 50 --seconds 25

Each sheet is held at its upper edge and has one cut. The sheets may need more than the machine has: they run as fast as they can.
"""
import argparse
import json
import signal
import subprocess
import tempfile
import time
import urllib.request


class Server:
    def __init__(self, kerfd, folder):
        begin = time.perf_counter()
        self.process = subprocess.Popen(
            [kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--no-render", "--max-load", "0", "--data", folder],
            stdout=subprocess.PIPE, text=True)
        self.http = json.loads(self.process.stdout.readline())["http"]
        self.seconds = time.perf_counter() - begin

    def call(self, method, message):
        request = urllib.request.Request(f"{self.http}/kerf.v1.{method}", json.dumps(message).encode(),
                                         {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=60) as response:
            return json.loads(response.read())

    def sheets(self):
        return self.call("SheetService/ListSheets", {"page_size": 1000})["sheets"]

    def end(self, how):
        begin = time.perf_counter()
        self.process.send_signal(how)
        self.process.wait()
        return time.perf_counter() - begin


def make_sheets(server, options):
    grid = {"columns": options.columns, "rows": options.columns, "width_m": 1, "height_m": 1}
    curve = {"polyline": {"points": [{"x": 0.2, "y": 0.5}, {"x": 0.7, "y": 0.4}]}}
    for i in range(options.sheets):
        server.call("SheetService/CreateSheet", {"sheet_id": f"a{i}", "scene": {"grid": grid, "pins": [{"edge": "TOP"}]}})
        server.call("CutService/CreateCut", {"parent": f"sheets/a{i}", "cut": {"curve": curve}})


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kerfd")
    parser.add_argument("--sheets", type=int, default=64)
    parser.add_argument("--columns", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=25)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        server = Server(options.kerfd, folder + "/store")
        make_sheets(server, options)
        time.sleep(options.seconds)
        server.end(signal.SIGKILL)
        server = Server(options.kerfd, folder + "/store")
        assert len(server.sheets()) == options.sheets
        print(f"ready after SIGKILL: {server.seconds:.1f} s")
        time.sleep(5)
        print(f"ended by SIGTERM:    {server.end(signal.SIGTERM):.1f} s")
        server = Server(options.kerfd, folder + "/store")
        print(f"ready after it:      {server.seconds:.1f} s")
        server.end(signal.SIGTERM)


if __name__ == "__main__":
    main()
