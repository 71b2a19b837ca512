"""Progress bars and status lines: at a terminal only, and with neither --json nor --quiet."""

import json
import os
import pathlib
import pty
import select
import signal
import subprocess
import time

import cli_case
from cli_case import Case, address, kerf, main, path, scene_file, setUpModule, tearDownModule


def at_terminal(*arguments, streams=("stderr",), until=None, then=None):
    """Runs kerf with these streams at a terminal; (exit code, what stands on it, the other streams). When `until` has been written,
    `then` is sent: a signal."""
    master, slave = pty.openpty()
    pipes = {name: slave if name in streams else subprocess.PIPE for name in ("stdout", "stderr")}
    process = subprocess.Popen([cli_case.OPTIONS.kerf, "--server", address(), *arguments], **pipes)
    os.close(slave)
    shown, deadline = b"", time.monotonic() + 120
    while time.monotonic() < deadline:
        if not select.select([master], [], [], 1)[0]:
            continue
        try:
            piece = os.read(master, 4096)
        except OSError:  # the last writer is gone
            break
        if not piece:
            break
        shown += piece
        if until is not None and until in shown:
            process.send_signal(then)
            until = None
    rest = process.communicate(timeout=60)
    os.close(master)
    return process.returncode, shown.decode(), "".join(part.decode() for part in rest if part)


class Progress(Case):
    def setUp(self):
        self.scene = scene_file("long.json", grid={"columns": 40, "rows": 40, "width_m": 1, "height_m": 1}, ticks=200)

    def test_a_run_shows_how_far_it_is(self):
        code, shown, out = at_terminal("run", self.scene)
        self.assertEqual(code, 0, shown)
        self.assertRegex(shown, r"\[#*\.+\] +\d+ %")
        self.assertTrue(shown.endswith("\r\x1b[K"), repr(shown[-40:]))  # nothing of it is left
        self.assertIn("200 ticks", out)

    def test_not_with_json_or_quiet_or_elsewhere_than_at_a_terminal(self):
        for option in ("--json", "--quiet", "-q"):
            code, shown, _ = at_terminal("run", self.scene, option)
            self.assertEqual((code, shown), (0, ""))
        self.assertEqual(kerf("run", self.scene).stderr, "")

    def test_a_load_run(self):
        load = ("load", "--grid", "6x6", "--warm-up", "0.3", "--duration", "0.8")
        code, shown, out = at_terminal(*load)
        self.assertEqual(code, 0, shown)
        self.assertRegex(shown, r"\[#*\.+\] +\d+ %.*measuring  \d+ frames  0 cuts  0 errors")
        self.assertTrue(shown.endswith("\r\x1b[K"), repr(shown[-40:]))
        self.assertIn("sheets     1 of 1", out)
        for option in ("--json", "--quiet"):
            code, shown, _ = at_terminal(*load, option)
            self.assertEqual((code, shown), (0, ""))

    def test_a_step_of_many_ticks(self):
        self.json_of("sheet", "create", "stepped", "--grid", "40x40")
        self.json_of("sheet", "pause", "stepped")
        code, shown, out = at_terminal("sheet", "step", "stepped", "600")
        self.assertEqual(code, 0, shown)
        self.assertRegex(shown, r"\[#*\.*\] +\d+ %.*\d+ of 600 ticks")
        self.assertIn("sheets/stepped", out)
        code, shown, _ = at_terminal("sheet", "step", "stepped", "3", "--quiet")
        self.assertEqual((code, shown), (0, ""))

    def test_a_call_that_does_not_tell_shows_its_time(self):
        self.json_of("sheet", "create", "analysed", "--grid", "50x50")
        self.json_of("sheet", "pause", "analysed")
        code, shown, _ = at_terminal("analyze", "analysed", "--dynamic", "--ticks", "3000")
        self.assertEqual(code, 0, shown)
        self.assertRegex(shown, r"analysing \.\.\. \d+:\d\d")


class Watch(Case):
    @classmethod
    def setUpClass(cls):
        kerf("sheet", "create", "watched", "--grid", "20x20", "--pin", "corners")

    def test_a_status_line_that_is_drawn_over(self):
        code, shown, _ = at_terminal("watch", "watched", "--frames", "40", streams=("stdout",))
        self.assertEqual(code, 0, shown)
        lines = shown.replace("\r\n", "\n").rstrip("\n").split("\n")
        self.assertEqual(len(lines), 3, lines)  # the status line, over and over; two of summary
        self.assertGreater(lines[0].count("\r"), 1)
        self.assertRegex(lines[0], r"tick \d+ +\d+\.\d fps +[\d.]+ k?B/s +age p50 [\d.-]+ p95 [\d.-]+ ms +skipped \d+ +400 vertices 1 piece")
        self.assertRegex(lines[1], r"^40 frames in [\d.]+ s \([\d.]+ fps\), [\d.]+ k?B")
        self.assertRegex(lines[2], r"^age of frames: p50 .* ms, p95 .* ms, worst .* ms$")

    def test_a_line_a_frame_elsewhere(self):
        self.json_of("sheet", "reset", "watched")
        lines = kerf("watch", "watched", "--frames", "3").stdout.splitlines()
        self.assertEqual(len(lines), 5)
        self.assertIn("3 frames in", lines[3])
        self.assertEqual(kerf("watch", "watched", "--frames", "3", "--quiet").stdout, "")

    def test_ctrl_c_ends_it_with_the_summary(self):
        self.json_of("sheet", "reset", "watched")
        code, shown, _ = at_terminal("watch", "watched", streams=("stdout",), until=b"fps", then=signal.SIGINT)
        self.assertEqual(code, 0, shown)
        self.assertRegex(shown, r"\d+ frames? in")

    def test_a_rate_is_kept(self):
        self.json_of("sheet", "reset", "watched")
        done = kerf("--json", "watch", "watched", "--frames", "4", "--rate", "10")
        ticks = [json.loads(line)["tick"] for line in done.stdout.splitlines()]
        self.assertGreaterEqual(min(b - a for a, b in zip(ticks[1:], ticks[2:])), 5)  # of 60 ticks a second

    def test_a_server_that_is_back_is_watched_again(self):
        listen = cli_case.held_port()
        def scene(rows):
            grid = {"columns": 12, "rows": rows, "width_m": 1.0, "height_m": 1.0}
            return "--scene", scene_file("again.json", sheet_id="again", grid=grid, commands=None, ticks=None)
        server, _ = cli_case.start_server(listen, *scene(12))
        self.addCleanup(server.kill)
        command = [cli_case.OPTIONS.kerf, "--server", listen, "--json", "watch", "again", "--reconnect", "60"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as watching:
            self.assertEqual(json.loads(watching.stdout.readline())["num_vertices"], 144)
            cli_case.stop_server(server)
            # The sheet has another size, as its ticks may be later than those before.
            server, _ = cli_case.start_server(listen, *scene(13))
            self.addCleanup(cli_case.stop_server, server)
            while json.loads(watching.stdout.readline())["num_vertices"] == 144:
                pass
            watching.send_signal(signal.SIGINT)
            watching.communicate(timeout=60)
        self.assertEqual(watching.returncode, 0)


if __name__ == "__main__":
    main(__doc__)
