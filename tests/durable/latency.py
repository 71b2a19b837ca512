#!/usr/bin/python3
"""Measures how long a cut takes until its answer, and until the first frame that shows it, with and without kept sheets.

    client/python/generate && PYTHONPATH=client/python tests/durable/latency.py build/release/bin/kerfd --folder FOLDER

Two kerfd run side by side, one on a new folder below FOLDER, one with `--data none`. Each has a sheet of 50 x 50 vertices that
swings, and gets the same random cuts, in turns. Each is undone, so that all sheets cost the same. The clock begins as a cut is
sent, over gRPC.
"""

import argparse
import contextlib
import pathlib
import random
import tempfile
import threading
import time

import kerf
from kerf.v1 import stream_pb2
from server import PATIENCE_S, Server, scene

SIDE = 50
CUT_M = 0.15  # most along each axis


class Watcher:
    """Notes on a thread when each topology of a sheet was first shown."""

    def __init__(self, server, sheet):
        self.shown = {}
        self.changed = threading.Condition()
        self.stream = kerf.transport.Stream(server.stream_service.Watch, server.address)
        self.stream.send(stream_pb2.WatchRequest(start=stream_pb2.WatchStart(name=sheet.name, window=1)))
        self.thread = threading.Thread(target=self.collect)
        self.thread.start()

    def collect(self):
        while (response := self.stream.receive()) is not None:
            arrived = time.monotonic()
            frame = response.frame
            self.stream.send(stream_pb2.WatchRequest(ack=stream_pb2.WatchAck(sequence=frame.sequence, held_us=1)))
            with self.changed:
                self.shown.setdefault(frame.topology_version, arrived)
                self.changed.notify_all()

    def time_of(self, version):
        """Returns when this topology or a later one was first shown; waits for it."""
        with self.changed:
            if not self.changed.wait_for(lambda: max(self.shown, default=-1) >= version, PATIENCE_S):
                raise RuntimeError("the cut was not shown")
            return min(at for each, at in self.shown.items() if each >= version)

    def close(self):
        self.stream.close()
        self.thread.join()


class Side:
    """A kerfd with a sheet and a viewer, and the times of its cuts, in seconds."""

    def __init__(self, kerfd, data):
        self.process = Server(kerfd, "--data", data)
        self.server = kerf.connect(self.process.ready["grpc"])
        swinging = scene(SIDE, pins=[{"edge": "TOP_CORNERS"}])
        self.process.call("SheetService/CreateSheet", {"sheet_id": "a", "scene": swinging})
        self.sheet = self.server.sheet("a")
        self.watcher = Watcher(self.server, self.sheet)
        self.answers, self.frames = [], []

    def cut(self, begin, end):
        sent = time.monotonic()
        result = self.sheet.cut(kerf.polyline(begin, end))
        answered = time.monotonic()
        if kerf.v1.cuts_pb2.CutResult.Status.Name(result.status) != "APPLIED":
            return
        self.frames.append(self.watcher.time_of(result.topology_version) - sent)
        self.answers.append(answered - sent)
        self.sheet.undo()

    def close(self):
        self.watcher.close()
        self.server.close()
        self.process.end()


def milliseconds(times_s, share):
    """Returns the time that this share of all does not exceed."""
    return 1000 * sorted(times_s)[min(int(share * len(times_s)), len(times_s) - 1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kerfd", type=pathlib.Path)
    parser.add_argument("--folder", type=pathlib.Path, required=True, help="where the kept sheets go, on the disk to be measured")
    parser.add_argument("--cuts", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    numbers = random.Random(options.seed)
    with tempfile.TemporaryDirectory(dir=options.folder) as folder, contextlib.ExitStack() as ends:
        sides = {}
        for name, data in (("none", "none"), ("a folder", folder + "/store")):
            sides[name] = Side(options.kerfd, data)
            ends.callback(sides[name].close)
        for _ in range(options.cuts):
            begin = numbers.uniform(CUT_M, 1 - CUT_M), numbers.uniform(CUT_M, 1 - CUT_M)
            end = tuple(each + numbers.uniform(-CUT_M, CUT_M) for each in begin)
            for side in numbers.sample(list(sides.values()), 2):
                time.sleep(numbers.uniform(0, 0.05))  # Any moment between two ticks.
                side.cut(begin, end)
        print("| --data | cuts | answer p50 ms | p99 ms | first frame p50 ms | p99 ms |\n|---|---|---|---|---|---|")
        for name, side in sides.items():
            figures = [f"{milliseconds(times, share):.1f}" for times in (side.answers, side.frames) for share in (0.5, 0.99)]
            print(f"| {name} | {len(side.answers)} | {' | '.join(figures)} |")


main()
