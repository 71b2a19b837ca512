"""Shared by the tests of kerfd on a folder of kept sheets."""

import argparse
import pathlib
import signal
import subprocess
import tempfile
import unittest

from server import Server, line_cut, scene

OPTIONS = {}  # Paths of programs, by name.


class Case(unittest.TestCase):
    """Has a folder for kept sheets and ends the servers that it started."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.store = self.folder / "store"
        self.running = []

    def tearDown(self):
        for server in self.running:
            server.end(signal.SIGKILL)

    def start(self, *options, environment=None, data=True):
        data_options = ("--data", str(self.store)) if data else ()
        server = Server(OPTIONS["kerfd"], *data_options, *map(str, options), environment=environment)
        self.running.append(server)
        return server

    def stop(self, server):
        """Ends a server in order and returns the text of standard error."""
        self.running.remove(server)
        text = server.end()
        self.assertEqual(server.process.returncode, 0, text)
        return text

    def kill(self, server):
        self.running.remove(server)
        server.end(signal.SIGKILL)

    def done(self, server, method, message):
        answer = server.call(method, message)
        self.assertNotIn("refused", answer)
        return answer

    def make(self, server, name, side=8):
        return self.done(server, "SheetService/CreateSheet", {"sheet_id": name, "scene": scene(side)})

    def cut(self, server, name, height=0.4):
        answer = self.done(server, "CutService/CreateCut", line_cut(f"sheets/{name}", (-1, height), (2, height)))
        self.assertEqual(answer["status"], "APPLIED")
        return answer["name"]

    def cuts(self, server, name):
        listed = self.done(server, "CutService/ListCuts", {"parent": f"sheets/{name}"})
        return [each["result"]["name"] for each in listed.get("cuts", [])]

    def get(self, server, name):
        return server.call("SheetService/GetSheet", {"name": f"sheets/{name}"})

    def names(self, server):
        return [each["name"] for each in self.done(server, "SheetService/ListSheets", {}).get("sheets", [])]

    def run_kerfd(self, *arguments):
        return subprocess.run([OPTIONS["kerfd"], *map(str, arguments)], capture_output=True, text=True, timeout=60, check=False)

    def refused(self, says, *arguments):
        """Expects that kerfd does not start, and says why on one line."""
        refused = self.run_kerfd(*arguments)
        self.assertEqual((refused.returncode, refused.stdout), (2, ""), arguments)
        self.assertIn(says, refused.stderr)
        self.assertEqual(refused.stderr.count("\n"), 1)


def main(description, *programs):
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    for name in ("kerfd", "kerf", *programs):
        parser.add_argument(f"--{name}", required=True)
    options, rest = parser.parse_known_args()
    OPTIONS.update(vars(options))
    unittest.main(module="__main__", argv=[description, *rest])
