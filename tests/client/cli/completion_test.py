"""Tab completion in the shells themselves: what bash, zsh and fish offer once they have read `kerf completion SHELL`."""

import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import time
import unittest

import cli_case
from cli_case import Case, address, closed_port, kerf, main, path, setUpModule, tearDownModule


def environment():
    return {**os.environ, "PATH": os.path.dirname(cli_case.OPTIONS.kerf) + ":" + os.environ["PATH"],
            "KERF_SERVER": address(), "HOME": path("home"), "TERM": "dumb", "ZDOTDIR": path("home"),
            "XDG_CONFIG_HOME": path("home"), "XDG_DATA_HOME": path("home")}


# Splits the line into words as readline does, '=' and ':' apart, and prints what the function answers.
ASK_BASH = r'''
source <(kerf completion bash)
COMP_LINE=$1 COMP_POINT=${#1} COMP_WORDS=("${@:2}") COMP_CWORD=$(($# - 2))
compopt() { :; }  # works within a completion only
_kerf 2>&1
printf '%s\n' "${COMPREPLY[@]}"
'''


class Bash(Case):
    @classmethod
    def setUpClass(cls):
        os.makedirs(path("files/folder"))
        os.makedirs(path("home"), exist_ok=True)
        pathlib.Path(path("files/scene.json")).write_text("{}")
        for name in ("alpha", "alps", "beta"):
            kerf("sheet", "create", name, "--grid", "3x3")

    def offered(self, line, words=None):
        words = line.split(" ") if words is None else words
        done = subprocess.run(["bash", "--norc", "-c", ASK_BASH, "bash", line] + words, capture_output=True, text=True,
                              env=environment(), cwd=path("files"), timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def test_commands(self):
        commands = self.offered("kerf ")
        for command in ("sheet", "cut", "undo", "watch", "render", "images", "run", "analyze", "completion"):
            self.assertIn(command, commands)
        self.assertNotIn("__complete", commands)
        self.assertEqual(self.offered("kerf ren"), ["render"])
        self.assertEqual(self.offered("kerf sheet cr"), ["create"])
        self.assertEqual(self.offered("kerf store "), ["info", "prune", "delete", "backup"])
        self.assertEqual(self.offered("kerf --json sheet pa"), ["pause"])
        self.assertEqual(self.offered("kerf nonsense cr"), [])

    def test_options_of_the_command_and_of_kerf(self):
        self.assertEqual(self.offered("kerf sheet create a --gr"), ["--grid"])
        self.assertEqual(self.offered("kerf cut demo --tip"), ["--tip-size", "--tip-grading"])
        self.assertEqual(self.offered("kerf cut demo --bez"), ["--bezier"])  # of an option group
        self.assertEqual(self.offered("kerf sheet list --js"), ["--json"])
        self.assertEqual(self.offered("kerf --json sheet list --js"), [])  # given already
        self.assertEqual(self.offered("kerf sheet create a --part x --par"), ["--part"])  # may be given again
        self.assertEqual(self.offered("kerf sheet list --grid"), [])

    def test_values(self):
        self.assertEqual(self.offered("kerf sheet create a --pin "), ["top", "corners", "none"])
        self.assertEqual(self.offered("kerf cut a --method el"), ["element"])
        self.assertEqual(self.offered("kerf images a --format "), ["jpeg", "png"])
        self.assertIn("tr-bdf2", self.offered("kerf run scene.json --integrator "))
        self.assertEqual(self.offered("kerf completion "), ["bash", "zsh", "fish"])
        self.assertEqual(self.offered("kerf sheet create a --material de"), ["demo", "denim"])
        self.assertEqual(self.offered("kerf sheet create a --pin=to", ["kerf", "sheet", "create", "a", "--pin", "=", "to"]),
                         ["top"])
        self.assertEqual(self.offered("kerf sheet create a --pin=", ["kerf", "sheet", "create", "a", "--pin", "="]),
                         ["top", "corners", "none"])

    def test_names_of_sheets_are_asked_for(self):
        self.assertEqual(self.offered("kerf cut al"), ["alpha", "alps"])
        self.assertEqual(self.offered("kerf sheet step be"), ["beta"])
        self.assertEqual(self.offered("kerf sheet create al"), [])  # a new one's name
        self.assertEqual(self.offered("kerf sheet step beta "), [])  # a number
        host, port = address().split(":")
        apart = ["kerf", "--server", host, ":", port, "undo", "be"]
        self.assertEqual(self.offered(f"kerf --server {address()} undo be", apart), ["beta"])
        host, port = closed_port().split(":")
        nobody = ["kerf", "--server", host, ":", port, "undo", "be"]
        self.assertEqual(self.offered(f"kerf --server {closed_port()} undo be", nobody), [])

    def test_files_and_folders(self):
        self.assertEqual(sorted(self.offered("kerf run ")), ["folder", "scene.json"])
        self.assertEqual(self.offered("kerf run scene.json --csv "), ["folder"])
        self.assertEqual(self.offered("kerf sheet create a --scene sc"), ["scene.json"])


class Terminal:
    """An interactive shell at a terminal of its own."""

    def __init__(self, command):
        self.process, self.handle = pty.fork()
        if self.process == 0:
            os.chdir(path("home"))
            os.execvpe(command[0], command, environment())
        self.text = ""

    def type(self, text):
        os.write(self.handle, text.encode())

    def wait_for(self, pattern, seconds=60):
        """Until what the shell has written since the last call has the pattern in it."""
        deadline = time.monotonic() + seconds
        while not re.search(pattern, self.text):
            ready, _, _ = select.select([self.handle], [], [], max(0, deadline - time.monotonic()))
            if not ready:
                raise AssertionError(f"no {pattern!r} in what the terminal shows: {self.text!r}")
            self.text += os.read(self.handle, 4096).decode(errors="replace")
        shown, self.text = self.text, ""
        return shown

    def close(self):
        os.close(self.handle)
        os.waitpid(self.process, 0)


class AtTheTerminal(Case):
    @classmethod
    def setUpClass(cls):
        os.makedirs(path("home"), exist_ok=True)
        pathlib.Path(path("home/.zshrc")).write_text("")  # or zsh asks whether to make one
        kerf("sheet", "create", "lonely-sheet", "--grid", "3x3")

    def completes(self, command, begin):
        """Types half a line and Tab; Enter runs what has become of it."""
        terminal = Terminal(command)
        try:
            terminal.type(begin + "; echo read'y'\n")
            terminal.wait_for("ready")
            terminal.type("kerf sheet ge\tlon\t\n")
            terminal.wait_for(r"sheets/lonely-sheet +\w+ +tick")
        finally:
            terminal.close()

    def test_bash(self):
        self.completes(["bash", "--norc", "--noprofile", "-i"], "source <(kerf completion bash)")

    @unittest.skipUnless(shutil.which("zsh"), "there is no zsh here")
    def test_zsh(self):
        self.completes(["zsh", "-i"], "autoload -U compinit && compinit -u; source <(kerf completion zsh)")

    @unittest.skipUnless(shutil.which("fish"), "there is no fish here")
    def test_fish(self):
        self.completes(["fish", "--no-config", "-i"], "kerf completion fish | source")


if __name__ == "__main__":
    main(__doc__)
