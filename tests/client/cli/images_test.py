"""`kerf images` against a real kerfd."""

import json
import os
import pathlib
import pty
import signal
import subprocess

import cli_case
from cli_case import Case, address, kerf, main, path, setUpModule, tearDownModule


def size_of(picture):
    """Returns width and height of a PNG, or of a baseline JPEG of this server."""
    if picture[:8] == b"\x89PNG\r\n\x1a\n":
        return int.from_bytes(picture[16:20], "big"), int.from_bytes(picture[20:24], "big")
    at = 2
    while picture[at + 1] != 0xC0:
        at += 2 + int.from_bytes(picture[at + 2:at + 4], "big")
    return int.from_bytes(picture[at + 7:at + 9], "big"), int.from_bytes(picture[at + 5:at + 7], "big")


def pictures_in(folder):
    return sorted(os.listdir(path(folder)))


class Images(Case):
    @classmethod
    def setUpClass(cls):
        kerf("sheet", "create", "film", "--grid", "12x12", "--pin", "top")

    def setUp(self):
        done = kerf("render", "film", "--out", path("probe.png"), "--size", "16x16")
        if "renderer" in done.stderr:
            self.skipTest(done.stderr)

    def command(self, *arguments):
        return [cli_case.OPTIONS.kerf, "--server", address(), "images", "film", "--size", "64x48", *arguments]

    def test_numbered_pictures(self):
        done = kerf("images", "film", "--out", path("new"), "--size", "96x64", "--rate", "50", "--count", "5")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(pictures_in("new"), [f"picture-{i:06d}.jpg" for i in range(1, 6)])
        contents = [pathlib.Path(path("new"), name).read_bytes() for name in pictures_in("new")]
        self.assertEqual({size_of(content) for content in contents}, {(96, 64)})
        self.assertEqual(len(set(contents)), 5, "it falls")
        self.assertRegex(done.stdout, r"^5 pictures in \S+/new, 0\.0 MB, ticks \d+ to \d+, \d+ skipped\n$")
        self.assertEqual(done.stderr, "")

    def test_json_lines_and_png(self):
        done = kerf("--json", "images", "film", "--out", path("png"), "--size", "64x48", "--format", "png", "--count", "3",
                    "--color-by", "strains", "--wireframe", "--view", "0.5,-2,0.5 0.5,0,0.5")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line["sequence"] for line in lines], [1, 2, 3])
        ticks = [line["tick"] for line in lines]
        self.assertEqual(ticks, sorted(set(ticks)))
        for line, name in zip(lines, pictures_in("png")):
            self.assertEqual(line["file"], os.path.join(path("png"), name))
            content = pathlib.Path(line["file"]).read_bytes()
            self.assertEqual((len(content), size_of(content)), (line["bytes"], (line["width_px"], line["height_px"])))

    def test_an_interrupt_ends_it_in_order(self):
        process = subprocess.Popen([*self.command("--out", path("live")), "--json"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        first = json.loads(process.stdout.readline())
        process.send_signal(signal.SIGINT)
        rest = process.stdout.read().splitlines()
        self.assertEqual(process.wait(timeout=20), 0)
        self.assertEqual(len(pictures_in("live")), 1 + len(rest))
        self.assertEqual(first["sequence"], 1)

    def test_progress_at_a_terminal(self):
        ours, theirs = pty.openpty()
        process = subprocess.Popen(self.command("--out", path("watched"), "--count", "20"), stdout=subprocess.PIPE,
                                   stderr=theirs, text=True)
        self.addCleanup(process.stdout.close)
        os.close(theirs)
        shown = b""
        try:
            while chunk := os.read(ours, 65536):
                shown += chunk
        except OSError:  # how a terminal reports its end
            pass
        self.assertIn("20 pictures", process.stdout.read())
        self.assertEqual(process.wait(timeout=20), 0)
        self.assertIn(b" of 20, tick ", shown)
        self.assertTrue(shown.endswith(b"\r\x1b[K"), "nothing is left of it")
        os.close(ours)

    def test_a_sheet_that_is_deleted(self):
        kerf("sheet", "create", "gone", "--grid", "5x5")
        process = subprocess.Popen([cli_case.OPTIONS.kerf, "--server", address(), "--json", "images", "gone", "--out", path("gone")],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        process.stdout.readline()
        kerf("sheet", "delete", "gone")
        _, said = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 1)
        self.assertIn("the server ended the stream", said)

    def test_refusals(self):
        out = ("--out", path("refused"))
        self.refused("images", "film", code=2, says="--out")
        self.refused("images", "nobody", *out, says="NOT_FOUND")
        self.refused("images", "film", *out, "--size", "9999x10", says="width_px")
        self.refused("images", "film", *out, "--size", "big", code=2, says="--size")
        self.refused("images", "film", *out, "--format", "gif", code=2, says="--format")
        self.refused("images", "film", *out, "--quality", "101", code=2, says="--quality")
        self.refused("images", "film", *out, "--rate", "0", code=2, says="--rate")
        self.refused("images", "film", *out, "--count", "-1", code=2, says="--count")
        self.refused("images", "film", *out, "--view", "0,0,0 0,0,0", says="CAMERA_SINGULAR")
        self.assertEqual(pictures_in("refused"), [])
        # As of any file that kerf writes: where the folder that it lies in is not, it is not made.
        for command in (("images",), ("render", "--size", "16x16")):
            self.refused(*command, "film", "--out", path("absent/film.png"), says=path("absent/film.png"))
        self.assertFalse(os.path.exists(path("absent")))
        pathlib.Path(path("file")).write_text("")
        self.refused("images", "film", "--out", path("file"), says=path("file"))
        pathlib.Path(path("refused/picture-000001.jpg")).write_text("of an earlier stream")
        self.refused("images", "film", *out, says="picture-000001.jpg already exists")
        self.assertEqual(pathlib.Path(path("refused/picture-000001.jpg")).read_text(), "of an earlier stream")

    def test_help(self):
        said = kerf("images", "--help", server=False).stdout
        for option in ("--out", "--size", "--rate", "--count", "--format", "--quality", "--color-by", "--view"):
            self.assertIn(option, said)


if __name__ == "__main__":
    main(__doc__)
