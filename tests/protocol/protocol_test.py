"""reader.pl, which knows proto/README.md alone, sees what the server's exact state says: frame by frame, through steps, cuts, a strip
that is removed, undos, a fall out of the box and a reset."""

import argparse
import base64
import json
import pathlib
import re
import signal
import struct
import subprocess
import sys
import unittest
import urllib.request

FOLDER = pathlib.Path(__file__).resolve().parent
PAGE = FOLDER.parents[1] / "proto/README.md"
OPTIONS = None
PROCESS = None
HTTP = None


def setUpModule():
    global PROCESS, HTTP
    PROCESS = subprocess.Popen([OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none", "--max-load", "0"],
                               stdout=subprocess.PIPE, text=True)
    HTTP = json.loads(PROCESS.stdout.readline())["http"].removeprefix("http://")


def tearDownModule():
    PROCESS.send_signal(signal.SIGTERM)
    PROCESS.stdout.close()
    if PROCESS.wait(timeout=20) != 0:
        raise AssertionError(f"kerfd left with {PROCESS.returncode} after SIGTERM")


def call(method, **message):
    request = urllib.request.Request(f"http://{HTTP}/kerf.v1.{method}", json.dumps(message).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=60) as reply:
        return json.load(reply)


def rows(content, kind, columns):
    """The rows of a packed array in base64."""
    return list(struct.iter_unpack(f"<{columns}{kind}", base64.b64decode(content)))


class Reader:
    """reader.pl at work."""

    def __init__(self, sheet):
        self.process = subprocess.Popen(["perl", FOLDER / "reader.pl", HTTP, sheet], stdout=subprocess.PIPE, text=True)

    def close(self):
        self.process.kill()
        self.process.stdout.close()
        self.process.wait()

    def frame(self):
        """The next one: what its first line says, and its vertices and triangles."""
        words = self.process.stdout.readline().split()[1:]
        head = dict(zip(words[:12:2], map(int, words[1:12:2])))
        head["box"] = [float(word) for word in words[13:]]
        lines = [self.process.stdout.readline().split() for _ in range(head["vertices"] + head["triangles"])]
        head["positions"] = [tuple(map(float, line[1:])) for line in lines if line[0] == "v"]
        head["corners"] = [tuple(int(word) - 1 for word in line[1:]) for line in lines if line[0] == "f"]
        return head

    def rest(self):
        """The lines to its end, and its exit status."""
        lines = self.process.stdout.read().splitlines()
        return lines, self.process.wait(timeout=20)


class Protocol(unittest.TestCase):
    def setUp(self):
        self.name = call("SheetService/CreateSheet", paused=True, scene={
            "grid": {"columns": 12, "rows": 9, "width_m": 1.2, "height_m": 0.9}, "pins": [{"edge": "TOP"}]})["name"]
        self.reader = Reader(self.name)
        self.addCleanup(self.reader.close)
        self.frames = []

    def expect_state(self):
        """The frame of the sheet as it is now, sooner or later, has its exact triangles, and its positions to half a quantum."""
        state = call("SheetService/GetSheetState", name=self.name)
        now = (int(state["tick"]), state["topology_version"])
        while not self.frames or (self.frames[-1]["tick"], self.frames[-1]["topology"]) != now:
            self.frames.append(self.reader.frame())
        frame = self.frames[-1]
        self.assertEqual(frame["corners"], [slot for slot in rows(state["triangles"], "i", 3) if slot[0] >= 0])
        positions = rows(state["positions"], "d", 3)
        self.assertEqual(len(frame["positions"]), len(positions))
        half = [(high - low) / 131070 * (1 + 1e-9) for low, high in zip(frame["box"], frame["box"][3:])]
        for vertex in {corner for triangle in frame["corners"] for corner in triangle}:
            for axis in range(3):
                self.assertLessEqual(abs(frame["positions"][vertex][axis] - positions[vertex][axis]), half[axis])

    def cut(self, **cut):
        self.assertEqual(call("CutService/CreateCut", parent=self.name, cut=cut)["status"], "APPLIED")

    def test_the_reader_sees_what_the_server_has(self):
        self.expect_state()
        for _ in range(5):
            call("SheetService/StepSheet", name=self.name, ticks=1)
            self.expect_state()
        self.cut(curve={"circle": {"center": {"x": 0.4, "y": 0.4}, "radius_m": 0.2}})
        self.expect_state()
        self.cut(curve={"polyline": {"points": [{"x": 0.7, "y": 0.2}, {"x": 1.0, "y": 0.5}]}}, width_m=0.05)
        self.expect_state()
        call("SheetService/StepSheet", name=self.name, ticks=60)
        self.expect_state()
        self.assertGreater(len({tuple(frame["box"]) for frame in self.frames}), 1)
        call("CutService/UndoCut", parent=self.name)
        self.expect_state()
        call("SheetService/ResetSheet", name=self.name)
        self.expect_state()
        deltas = [frame["base"] >= 0 for frame in self.frames]
        patched = [after["topology"] != before["topology"] for before, after in zip(self.frames, self.frames[1:])]
        self.assertIn((True, True), zip(deltas[1:], patched), "a delta with a patch")
        self.assertIn((False, True), zip(deltas[1:], patched), "a keyframe with the full topology")
        call("SheetService/DeleteSheet", name=self.name)
        lines, status = self.reader.rest()
        self.assertEqual((lines[-2:], status), (["# ended 1 the sheet was deleted", "# closed 1000 "], 0))

    def test_a_refusal_closes_with_its_reason(self):
        reader = Reader("sheets/none")
        self.addCleanup(reader.close)
        lines, status = reader.rest()
        self.assertEqual((len(lines), status), (1, 0))
        self.assertRegex(lines[0], r"^# closed 1008 SHEET_NOT_FOUND: ")

    def test_files_that_the_page_names_are_there(self):
        for file in re.findall(r"\]\(([^)#]+)", PAGE.read_text()):
            self.assertTrue((PAGE.parent / file).is_file(), file)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kerfd", required=True)
    OPTIONS, others = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + others)
