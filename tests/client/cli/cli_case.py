"""Shared by the tests of the `kerf` command: a real kerfd of their own, and calls of `kerf` as a shell user makes them."""

import argparse
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/support"))
from closed_port import closed_port, held_port  # pylint: disable=unused-import

# The server and the token of whoever runs the tests are not theirs to touch.
for variable in ("KERF_SERVER", "KERF_TOKEN_FILE", "KERF_TLS_CA", "KERF_TLS_CERT", "KERF_TLS_KEY", "KERF_VIEWER"):
    os.environ.pop(variable, None)
SMALL_SCENE = {
    "sheet_id": "small",
    "grid": {"columns": 12, "rows": 12, "width_m": 1.0, "height_m": 1.0},
    "pins": [{"edge": "TOP"}],
    "ticks": 20,
    "commands": [
        {"tick": 5, "command": {"cut": {"curve": {"polyline": {"points": [{"x": -0.1, "y": 0.4}, {"x": 1.1, "y": 0.6}]}}}}}
    ],
}
OPTIONS = None
SERVER = None  # its ready line: "grpc" and "http"
PROCESS = None


def kerf(*arguments, server=True, timeout=120, stdout=subprocess.PIPE):
    command = [OPTIONS.kerf]
    if server:
        command += ["--server", SERVER["grpc"]]
    return subprocess.run(command + list(arguments), stdout=stdout, stderr=subprocess.PIPE, text=True, timeout=timeout)


def setUpModule(*options):
    """options: more of kerfd's. Without --data nothing is kept."""
    global SERVER, PROCESS
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    os.makedirs(OPTIONS.work)
    PROCESS, SERVER = start_server("127.0.0.1:0", *options)


def start_server(listen, *options):
    """Starts another kerfd; returns the process and its ready line."""
    kept = () if "--data" in options else ("--data", "none")
    process = subprocess.Popen(
        [OPTIONS.kerfd, "--listen", listen, "--http", "127.0.0.1:0", "--max-load", "0", *kept, *options], stdout=subprocess.PIPE, text=True)
    return process, json.loads(process.stdout.readline())


def stop_server(process):
    process.send_signal(signal.SIGTERM)
    process.stdout.close()
    if process.wait(timeout=20) != 0:
        raise AssertionError(f"kerfd left with {process.returncode} after SIGTERM")


def tearDownModule():
    stop_server(PROCESS)


def address():
    """Returns the address of the gRPC services."""
    return SERVER["grpc"]


def path(name):
    """Returns the path of a file in the test's own folder."""
    return os.path.join(OPTIONS.work, name)


def below_a_file(name):
    """A path at which nothing can be, whatever lies on this machine."""
    pathlib.Path(path("no-folder")).write_text("")
    return path(f"no-folder/{name}")


def scene_file(name, **changes):
    """Writes a scene file: a small sheet that is cut at tick 5 of 20. `changes` replace fields, or leave them out (None)."""
    content = {name: value for name, value in {**SMALL_SCENE, **changes}.items() if value is not None}
    pathlib.Path(path(name)).write_text(json.dumps(content))
    return path(name)


def panel(kind, faces=((0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7))):
    """A PLY file: a square of 3 m with a square hole of 1 m, flat on the ground."""
    points = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)]
    header = (f"ply\nformat {kind} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n").encode()
    if kind == "ascii":
        rows = [f"{x} {y} 0" for x, y in points] + [f"3 {a} {b} {c}" for a, b, c in faces]
        return header + ("\n".join(rows) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    return (header + b"".join(struct.pack(order + "3f", x, y, 0) for x, y in points)
            + b"".join(struct.pack(order + "B3i", 3, *face) for face in faces))


class Case(unittest.TestCase):
    def json_of(self, *arguments):
        done = kerf("--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def refused(self, *arguments, code=1, says=""):
        done = kerf(*arguments)
        self.assertEqual(done.returncode, code, f"{arguments}: {done.stdout}{done.stderr}")
        self.assertIn(says, done.stderr)
        self.assertEqual(done.stdout, "")
        return done


def main(description, add_options=lambda parser: None):
    global OPTIONS
    parser = argparse.ArgumentParser(description=description)
    add_options(parser)
    parser.add_argument("--kerf", required=True)
    parser.add_argument("--kerfd", required=True)
    parser.add_argument("--work", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(module="__main__", argv=[sys.argv[0]] + rest)
