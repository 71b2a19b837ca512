#!/usr/bin/env python3
"""Faults of the disk through kerfd: it hangs, is full, or fails. A preloaded library makes them, see disk_faults.cc.

    faults_test.py --kerfd KERFD --kerf KERF --faults LIBRARY
"""

import concurrent.futures
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

from kept_case import OPTIONS, Case, main
from server import PATIENCE_S, line_cut, reason, scene

ROOT = pathlib.Path(__file__).resolve().parents[2]
POLL_S = 0.05
TICKS = 120  # Ticks of a running sheet while a fault lasts, 2 s.
HAND = 27  # Vertex that a hand holds.


class Watcher:
    """Collects the frames of a sheet on a thread."""

    def __init__(self, grpc, name):
        import kerf  # From the generated package.
        self.frames = []
        self.server = kerf.connect(grpc)
        self.stream = self.server.sheet(name).watch()
        self.thread = threading.Thread(target=self.collect)
        self.thread.start()

    def collect(self):
        for frame in self.stream:
            self.frames.append(frame)

    def close(self):
        self.stream.close()
        self.thread.join()
        self.server.close()

    def shows(self, version):
        """True if a frame has shown this topology or a later one."""
        return any(frame.topology_version >= version for frame in list(self.frames))


class Faults(Case):
    @classmethod
    def setUpClass(cls):
        package = cls.enterClassContext(tempfile.TemporaryDirectory())
        subprocess.run([ROOT / "client/python/generate", package], check=True)
        sys.path.insert(0, package)

    def setUp(self):
        super().setUp()
        self.control = self.folder / "control"
        self.threads = concurrent.futures.ThreadPoolExecutor(max_workers=64)
        self.num_requests = 0

    def tearDown(self):
        self.end_fault()
        super().tearDown()
        self.threads.shutdown()

    def start_faulty(self, *options):
        return self.start(*options, environment={"LD_PRELOAD": OPTIONS["faults"], "KERF_FAULT_FOLDER": str(self.store),
                                                 "KERF_FAULT_CONTROL": str(self.control)})

    def begin_fault(self, word):
        written = self.folder / "written"
        written.write_text(word)
        written.rename(self.control)

    def end_fault(self):
        self.control.unlink(missing_ok=True)

    def wait_until(self, is_true, what):
        end = time.monotonic() + PATIENCE_S
        while not is_true():
            self.assertLess(time.monotonic(), end, f"waited in vain until {what}")
            time.sleep(POLL_S)

    def make_running(self, server, name="a"):
        """Makes a sheet in a wind, which never rests."""
        self.done(server, "SheetService/CreateSheet",
                  {"sheet_id": name, "scene": scene(wind={"velocity_mps": {"y": 4}})})

    def watch(self, server, name="a"):
        watcher = Watcher(server.ready["grpc"], name)
        self.wait_until(lambda: watcher.frames, "a frame came")
        return watcher

    def counted(self, server, what):
        """Returns a count of all sheets together. Unlike those of a sheet, it is never held back."""
        with urllib.request.urlopen(server.ready["http"] + "/metrics", timeout=PATIENCE_S) as page:
            return int(re.search(rf"(?m)^kerf_{what}_total (\d+)", page.read().decode()).group(1))

    def ticks(self, server):
        return self.counted(server, "ticks")

    def wait_for_ticks(self, server, number):
        begin = self.ticks(server)
        self.wait_until(lambda: self.ticks(server) >= begin + number, f"{number} ticks were done")

    def later(self, server, method, message):
        return self.threads.submit(server.call, method, message)

    def cut_later(self, server, name="a"):
        """Sends one more cut, short and in a place of its own. Returns the answer to come and the request."""
        self.num_requests += 1
        height = 0.05 + 0.012 * (self.num_requests % 70)
        message = line_cut(f"sheets/{name}", (0.31, height), (0.69, height + 0.005), request_id=f"cut-{self.num_requests}")
        return self.later(server, "CutService/CreateCut", message), message

    def cut_until_refused(self, server, expected):
        """Sends cuts until one is refused. Returns those that were done and have no answer."""
        done_before = self.counted(server, "cuts")
        sent = []

        def is_refused():
            sent.append(self.cut_later(server))
            return any(answer.done() for answer, _ in sent)

        def is_settled():
            return sum(not answer.done() for answer, _ in sent) == self.counted(server, "cuts") - done_before

        self.wait_until(is_refused, f"a cut was refused with {expected}")
        self.wait_until(is_settled, "all other cuts were done or refused")
        waiting = [each for each in sent if not each[0].done()]
        for answer in (answer for answer, _ in sent if answer.done()):
            self.assertEqual(reason(answer.result()), expected)
            kinds = [detail["@type"] for detail in answer.result()["refused"]["details"]]
            self.assertIn("type.googleapis.com/google.rpc.RetryInfo", kinds)
        return waiting

    def check_nothing_gets_out(self, server, waiting):
        """Checks for a second of ticks that neither these cuts nor a list of them is answered."""
        listed = self.later(server, "CutService/ListCuts", {"parent": "sheets/a"})
        self.wait_for_ticks(server, TICKS // 2)
        self.assertFalse(any(answer.done() for answer, _ in waiting), "answered too early")
        self.assertFalse(listed.done(), "listed too early")

    def check_answered(self, server, waiting):
        """Checks that each cut is done, in the order of their numbers, and that the list has no others."""
        answers = [answer.result(PATIENCE_S) for answer, _ in waiting]
        self.assertEqual({answer.get("status") for answer in answers}, {"APPLIED"})
        number = lambda answer: int(answer["name"].rsplit("/", 1)[1])
        answers.sort(key=number)
        ticks = [int(answer["tick"]) for answer in answers]
        self.assertEqual(ticks, sorted(ticks))
        self.assertEqual(self.cuts(server, "a"), [answer["name"] for answer in answers])

    def test_a_hanging_disk_costs_no_tick_and_a_hand_is_shown(self):
        server = self.start_faulty()
        beside = self.start("--data", "none", data=False)
        for each in (server, beside):
            self.make_running(each)
        self.done(server, "InteractionService/GrabPoint", {"name": "sheets/a", "grab": {"grab_id": "hand", "vertex": HAND}})
        watcher = self.watch(server)
        self.begin_fault("hang")
        before = self.ticks(server), self.ticks(beside)
        drag = self.later(server, "InteractionService/DragPoint",
                          {"name": "sheets/a", "drag": {"grab_id": "hand", "target": {"x": 0.5, "y": -0.5, "z": 2}}})
        self.wait_until(lambda: watcher.frames[-1].positions[HAND][2] > 0.3, "the hand was shown")
        saved = self.later(server, "SheetService/SaveState", {"parent": "sheets/a", "state_id": "kept"})
        first = watcher.frames[-1].tick
        self.wait_for_ticks(server, TICKS)
        self.wait_until(lambda: watcher.frames[-1].tick >= first + TICKS, "the frames went on")
        done, done_beside = self.ticks(server) - before[0], self.ticks(beside) - before[1]
        self.assertGreater(done, 0.8 * done_beside, "the pace of a server without a disk")
        self.assertFalse(drag.done() or saved.done(), "answered too early")
        self.end_fault()
        self.assertIn("tick", drag.result())
        self.assertEqual(saved.result()["name"], "sheets/a/states/kept")
        watcher.close()

    def test_an_edit_waits_for_a_hanging_disk_unseen_and_later_ones_are_refused(self):
        server = self.start_faulty()
        self.make_running(server)
        watcher = self.watch(server)
        version = watcher.frames[-1].topology_version
        self.begin_fault("hang")
        waiting = self.cut_until_refused(server, "STORAGE_STALLED")
        self.assertTrue(waiting)
        self.check_nothing_gets_out(server, waiting)
        self.assertFalse(watcher.shows(version + 1), "shown too early")
        listed, = self.done(server, "SheetService/ListSheets", {})["sheets"]
        self.assertEqual(listed.get("topology_version", 0), version)
        self.end_fault()
        self.check_answered(server, waiting)
        self.wait_until(lambda: watcher.shows(version + len(waiting)), "the cuts were shown")
        watcher.close()
        self.kill(server)
        self.check_answered(self.start(), waiting)

    def test_a_full_disk_refuses_changes_until_there_is_room(self):
        server = self.start_faulty()
        self.make_running(server)
        answered = [self.cut_later(server)]
        answered[0][0].result()
        self.begin_fault("full")
        waiting = self.cut_until_refused(server, "STORAGE_FULL")
        self.assertTrue(waiting)
        self.check_nothing_gets_out(server, waiting)
        self.end_fault()
        self.check_answered(server, answered + waiting)
        last = []

        def is_done():
            last[:] = [self.cut_later(server)]
            return "status" in last[0][0].result()

        self.wait_until(is_done, "cuts were taken once more")
        self.kill(server)
        self.check_answered(self.start(), answered + waiting + last)

    def test_kerfd_ends_if_the_disk_fails_and_every_answer_is_kept(self):
        for fault in ("no-sync", "no-write"):
            with self.subTest(fault):
                self.store = self.folder / fault
                server = self.start_faulty()
                self.make_running(server)
                answered = [self.cut_later(server) for _ in range(3)]
                for answer, _ in answered:
                    answer.result()
                self.begin_fault(fault)
                lost, request = self.cut_later(server)
                errors = server.ended()
                self.running.remove(server)
                self.assertEqual(server.process.returncode, 70, errors)
                self.assertIn("kerfd: the kept sheets cannot be written any more", errors)
                self.assertIsNone(lost.result())
                self.end_fault()
                server = self.start_faulty()
                self.assertTrue({answer.result()["name"] for answer, _ in answered} <= set(self.cuts(server, "a")))
                again = self.later(server, "CutService/CreateCut", request)
                self.check_answered(server, [*answered, (again, request)])


if __name__ == "__main__":
    main(__doc__, "faults")
