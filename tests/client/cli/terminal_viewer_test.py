"""client/examples/terminal_viewer at a terminal: it draws the sheet, follows the window's size, and q or Ctrl-C quits."""

import fcntl
import os
import pty
import re
import select
import struct
import termios
import time

import cli_case
from cli_case import ROOT, Case, address, kerf, main, setUpModule, tearDownModule


class Viewer:
    def __init__(self, *arguments, rows, columns):
        self.process, self.handle = pty.fork()
        if self.process == 0:
            program = os.path.join(os.path.dirname(cli_case.OPTIONS.kerf), "terminal_viewer")
            os.execv(program, [program, *arguments])
        self.resize(rows, columns)
        self.text = ""

    def resize(self, rows, columns):
        fcntl.ioctl(self.handle, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def picture(self, columns, seconds=60):
        """The first whole picture of so many columns: what stands between a start and the status line."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            for picture in re.findall(r"\x1b\[H(.*?)\x1b\[0m tick \d+, pieces \d+", self.text, re.DOTALL):
                if picture.count("▀") % columns == 0 and picture.count("▀") // columns > 1:
                    self.text = ""
                    return picture
            if select.select([self.handle], [], [], 1)[0]:
                self.text += os.read(self.handle, 1 << 16).decode(errors="replace")
        raise AssertionError(f"no picture of {columns} columns: {self.text[-300:]!r}")

    def quit(self, key=b"q"):
        os.write(self.handle, key)
        while True:
            try:
                if not os.read(self.handle, 1 << 16):
                    break
            except OSError:
                break
        self.modes = termios.tcgetattr(self.handle)[3]  # that it left behind
        os.close(self.handle)
        return os.waitstatus_to_exitcode(os.waitpid(self.process, 0)[1])


class TerminalViewer(Case):
    def test_draws_resizes_and_quits(self):
        kerf("sheet", "create", "shown", "--grid", "20x20", "--pin", "corners")
        viewer = Viewer("shown", address(), rows=24, columns=81)
        picture = viewer.picture(81)
        self.assertEqual(picture.count("▀"), 81 * 23)
        greys = {int(grey) for grey in re.findall(r"38;5;(\d+)", picture)}
        self.assertIn(234, greys)            # around the sheet
        self.assertTrue(greys - {234})       # the sheet
        self.assertTrue(all(234 <= grey <= 255 for grey in greys))
        viewer.resize(10, 47)
        self.assertEqual(viewer.picture(47).count("▀"), 47 * 9)
        self.assertEqual(viewer.quit(), 0)

    def test_ctrl_c_quits_and_leaves_the_terminal_as_it_was(self):
        kerf("sheet", "create", "left", "--grid", "20x20", "--pin", "corners")
        viewer = Viewer("left", address(), rows=24, columns=81)
        viewer.picture(81)
        self.assertEqual(viewer.quit(b"\x03"), 0)
        self.assertTrue(viewer.modes & termios.ECHO and viewer.modes & termios.ICANON and viewer.modes & termios.ISIG)

    def test_says_what_is_wrong(self):
        viewer = Viewer("nobody", address(), rows=24, columns=81)
        shown = b""
        try:
            while piece := os.read(viewer.handle, 4096):
                shown += piece
        except OSError:
            pass
        self.assertIn("SHEET_NOT_FOUND", shown.decode())
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(viewer.process, 0)[1]), 1)

    def test_has_sixty_lines_at_most(self):
        lines = (ROOT / "client/examples/terminal_viewer.cc").read_text().splitlines()
        code = [line for line in lines if line.strip() and not line.strip().startswith("//")]
        self.assertLessEqual(len(code), 60)


if __name__ == "__main__":
    main(__doc__)
