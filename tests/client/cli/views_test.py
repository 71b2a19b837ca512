"""`kerf render`, `export` and `watch` against a real kerfd."""

import json
import math
import os
import pathlib
import struct

from cli_case import Case, below_a_file, kerf, main, path, setUpModule, tearDownModule


class Views(Case):
    @classmethod
    def setUpClass(cls):
        kerf("sheet", "create", "view", "--grid", "20x20")

    def test_render(self):
        done = kerf("render", "view", "--out", path("frame.png"), "--size", "320x200")
        if "renderer" in done.stderr:
            self.skipTest(done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(pathlib.Path(path("frame.png")).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        reply = self.json_of("render", "view", "--out", path("frame.jpg"), "--size", "320x200")
        self.assertEqual((reply["width_px"], reply["height_px"], reply["media_type"]), (320, 200, "image/jpeg"))
        self.assertEqual(pathlib.Path(path("frame.jpg")).read_bytes()[:2], b"\xff\xd8")
        near, flat = (self.json_of("render", "view", "--out", path(name), "--size", "64x64", *how) and
                      pathlib.Path(path(name)).read_bytes()
                      for name, how in (("near.png", ("--view", "0.5,-1,0.5 0.5,0,0.5", "--fov", "30")),
                                        ("flat.png", ("--undeformed", "--wireframe"))))
        self.assertNotEqual(near, flat)
        colours = set()
        for by in ("sides", "pieces", "strains"):
            self.json_of("render", "view", "--out", path("by.png"), "--size", "64x64", "--color-by", by)
            colours.add(open(path("by.png"), "rb").read())
        self.assertEqual(len(colours), 3)
        self.json_of("render", "view", "--out", path("dark.png"), "--size", "64x64", "--dark")
        self.assertNotEqual(open(path("dark.png"), "rb").read(), open(path("by.png"), "rb").read())
        self.refused("render", "view", "--out", path("a.png"), "--color-by", "mood", code=2, says="--color-by")
        self.refused("render", "view", "--out", path("a.png"), "--view", "0,0,0 0,0,0", says="CAMERA_SINGULAR")
        self.refused("render", "view", "--out", path("a.png"), "--view", "0,0,0", code=2, says="--view")
        self.refused("render", "view", "--out", path("a.png"), "--fov", "30", code=2)
        self.refused("render", "view", "--out", path("a.png"), "--size", "9999x10", says="width_px")
        self.refused("render", "view", "--out", path("a.gif"), code=2, says="--out")
        self.refused("render", "view", "--out", below_a_file("a.png"), says="no-folder/a.png")
        self.assertFalse(os.path.exists(path("a.png")))

    def test_export(self):
        self.assertEqual(kerf("export", "view", "--out", path("view.obj")).returncode, 0)
        lines = pathlib.Path(path("view.obj")).read_text().splitlines()
        self.assertEqual(sum(line.startswith("v ") for line in lines), 400)
        self.assertEqual(sum(line.startswith("f ") for line in lines), 722)
        for line in lines:
            if line.startswith("v "):
                self.assertTrue(all(math.isfinite(float(number)) for number in line.split()[1:]))
        self.assertEqual(kerf("export", "view", "--out", path("view.glb")).returncode, 0)
        file = pathlib.Path(path("view.glb")).read_bytes()
        self.assertEqual(struct.unpack("<4sII", file[:12]), (b"glTF", 2, len(file)))
        gltf = json.loads(file[20:20 + struct.unpack("<I", file[12:16])[0]])
        self.assertEqual([accessor["count"] for accessor in gltf["accessors"]], [400, 400, 400, 400, 3 * 722])

    def test_watch(self):
        done = kerf("--json", "watch", "view", "--frames", "5")
        self.assertEqual(done.returncode, 0, done.stderr)
        frames = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([frame["sequence"] for frame in frames], [1, 2, 3, 4, 5])
        self.assertEqual(frames[0]["kind"], "keyframe")
        ticks = [frame["tick"] for frame in frames]
        self.assertEqual(ticks, sorted(set(ticks)))
        self.refused("watch", "nobody", "--frames", "1", says="NOT_FOUND")


if __name__ == "__main__":
    main(__doc__)
