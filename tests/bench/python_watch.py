#!/usr/bin/python3
"""Measures the cost of watching a sheet in a Python script: frames a second, CPU time and bytes a frame, raw and compact.

  client/python/generate && PYTHONPATH=client/python tests/bench/python_watch.py --kerfd build/release/bin/kerfd

Each sheet swings by itself, at 60 ticks a second as far as the machine goes. "CPU" is the process time of the script, the
threads of gRPC included; "decode" the part of it that makes arrays of a message; "read" what only taking the messages of
the compact encoding costs, without decoding them.
"""

import argparse
import json
import pathlib
import signal
import subprocess
import sys
import time

import kerf
from kerf.frames import FrameDecoder
from kerf.v1 import stream_pb2

SIDES = (50, 100)


def watched(sheet, frames):
    """Frames a second and CPU time a frame, us, of the loop a user writes."""
    with sheet.watch() as stream:
        next(stream)
        wall, cpu = time.monotonic(), time.process_time()
        skipped = sum(next(stream).stats.skipped for _ in range(frames))
        wall, cpu = time.monotonic() - wall, time.process_time() - cpu
    return frames / wall, 1e6 * cpu / frames, skipped


def messages(server, sheet, encoding, frames):
    """The messages of a stream, acknowledged, and the CPU time a message, us."""
    stream = kerf.transport.Stream(server.stream_service.Watch, server.address)
    stream.send(stream_pb2.WatchRequest(start=stream_pb2.WatchStart(name=sheet.name, window=1, encoding=encoding)))
    cpu, taken = time.process_time(), []
    while len(taken) < frames:
        taken.append(stream.receive().frame)
        stream.send(stream_pb2.WatchRequest(ack=stream_pb2.WatchAck(sequence=taken[-1].sequence, held_us=1)))
    cpu = time.process_time() - cpu
    stream.close()
    return taken, 1e6 * cpu / frames


def decoded(taken):
    """CPU time of decoding a message, us."""
    decoder = FrameDecoder()
    decoder.decode(taken[0])
    cpu = time.process_time()
    for message in taken[1:]:
        decoder.decode(message)
    return 1e6 * (time.process_time() - cpu) / (len(taken) - 1)


def mean_bytes(taken):
    return sum(message.ByteSize() for message in taken[1:]) / (len(taken) - 1)


def measure(server, side, frames):
    with server.temporary_sheet(grid=(side, side), pins=["top_corners"]) as sheet:
        rate_hz, cpu_us, skipped = watched(sheet, frames)
        raw, raw_us = messages(server, sheet, stream_pb2.RAW, frames)
        compact, compact_us = messages(server, sheet, stream_pb2.COMPACT, frames)
        print(f"{side * side:8d} {rate_hz:9.1f} {skipped:8d} {cpu_us:8.0f} {decoded(raw):10.0f} {raw_us:8.0f} "
              f"{mean_bytes(raw):10.0f} {compact_us:13.0f} {mean_bytes(compact):14.0f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kerfd", type=pathlib.Path, required=True)
    parser.add_argument("--frames", type=int, default=300, help="of each measurement (default: %(default)s)")
    options = parser.parse_args()
    process = subprocess.Popen([options.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        print("vertices  frames/s  skipped  CPU, us  decode, us  raw: read, us  bytes  compact: read, us  bytes")
        with kerf.connect(json.loads(process.stdout.readline())["grpc"]) as server:
            for side in SIDES:
                measure(server, side, options.frames)
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=20)


if __name__ == "__main__":
    sys.exit(main())
