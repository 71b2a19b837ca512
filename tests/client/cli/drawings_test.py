"""Drawings by `kerf cut`, `kerf inspect` and `kerf sheet create --outline`."""

import gzip
import json
import pathlib

from cli_case import Case, kerf, main, path, setUpModule, tearDownModule


class Drawings(Case):
    def setUp(self):
        self.id = "drawing-" + self._testMethodName.replace("_", "-")[:40].rstrip("-")
        self.json_of("sheet", "create", self.id, "--grid", "20x20")
        self.json_of("sheet", "pause", self.id)

    def test_drawings_are_chosen_and_placed(self):
        pathlib.Path(path("two.svg")).write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="400mm" height="200mm" viewBox="0 0 400 200"><g id="Cut">'
            '<rect x="50" y="50" width="100" height="100" stroke="red" fill="none"/></g><path d="M0 0H400" fill="none"/>'
            '<circle cx="300" cy="100" r="50" stroke="blue" fill="none"/></svg>')
        pieces = lambda *options: self.json_of("cut", self.id, path("two.svg"), *options)["pieces"]
        self.assertEqual(pieces(), 3)
        self.json_of("undo", self.id)
        self.assertEqual(pieces("--only", "stroke=red", "--true-size", "--at", "0.1,0.1"), 2)
        square = min(self.json_of("pieces", self.id)["pieces"], key=lambda piece: piece["area_m2"])
        self.assertAlmostEqual(square["area_m2"], 0.01, places=5)
        self.assertAlmostEqual(square["centroid"]["x"], 0.2, places=5)
        self.json_of("undo", self.id)
        self.assertEqual(pieces("--only", "stroke=red", "--only", "layer=Cut", "--fit-page"), 2)
        square = min(self.json_of("pieces", self.id)["pieces"], key=lambda piece: piece["area_m2"])
        self.assertAlmostEqual(square["area_m2"], 0.225 ** 2, places=5)
        refused = kerf("--json", "cut", self.id, path("two.svg"), "--only", "stroke=green")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("stroke=blue", json.loads(refused.stderr)["error"]["message"])
        for options in (("--at", "1,2"), ("--true-size", "--fit-page"), ("--true-size", "--unit", "yards"), ("--join", "much")):
            self.assertEqual(kerf("cut", self.id, path("two.svg"), *options).returncode, 2, options)
        self.assertEqual(kerf("cut", self.id, "--circle", "0.5,0.5,0.1", "--all-shapes").returncode, 2)

    def test_drawings_in_other_encodings(self):
        text = '<svg xmlns="http://www.w3.org/2000/svg"><circle id="Gr\u00f6\u00dfe" r="40"/></svg>'
        picture = '<image href="data:image/png;base64,' + "A" * 1_500_000 + '"/>'
        for content in (text.encode("iso-8859-1"), text.encode("utf-16"), text.encode("utf-8-sig"), gzip.compress(text.encode()),
                        text.replace("<circle", picture + "<circle").encode()):
            pathlib.Path(path("letters.svg")).write_bytes(content)
            self.assertEqual(self.json_of("cut", self.id, path("letters.svg"), "--only", "#Gr\u00f6\u00dfe")["pieces"], 2)
            self.json_of("undo", self.id)
        pathlib.Path(path("letters.svg")).write_bytes(b"\xff\xfe\xff")
        refused = kerf("--json", "cut", self.id, path("letters.svg"))
        self.assertEqual(json.loads(refused.stderr)["error"]["reason"], "SVG_MALFORMED")

    def test_ends_are_joined_and_gaps_of_rounding_are_no_news(self):
        pathlib.Path(path("gap.svg")).write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><path d="M1 1H99V99H1V1.05" fill="none" stroke="red"/></svg>')
        reply = self.json_of("cut", self.id, path("gap.svg"))
        self.assertEqual((reply["pieces"], reply["joined_ends"]), (2, 1))
        self.json_of("undo", self.id)
        text = kerf("cut", self.id, path("gap.svg"), "--join", "0").stdout
        self.assertIn("note: 2 ends nearly meet", text)
        self.assertIn("--join", text)
        self.json_of("undo", self.id)
        self.assertIn("ends joined to another line", kerf("--verbose", "cut", self.id, path("gap.svg"), "--join", "2mm").stdout)
        self.json_of("undo", self.id)
        kerf("cut", self.id, "--path", "M 0.1,0.1 h 0.3 v 0.3 h -0.3 z")
        self.assertNotIn("gaps closed", kerf("--verbose", "cut", self.id, "--path", "M 0.4,0.1 h 0.3 v 0.3 h -0.3 z").stdout)

    def test_dxf_and_what_is_in_a_drawing(self):
        groups = ("0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES 0 CIRCLE 8 Cut 62 1 10 100 20 100 40 50 "
                  "0 LINE 8 Fold 10 0 20 0 11 200 21 0 0 ENDSEC 0 EOF")
        pathlib.Path(path("plate.dxf")).write_text("\n".join(groups.split()) + "\n")
        report = json.loads(kerf("--json", "inspect", path("plate.dxf"), server=False).stdout)
        self.assertEqual((report["format"], report["lines"], report["closed_lines"]), ("DXF", 2, 1))
        self.assertEqual([group["selector"] for group in report["groups"]],
                         ["layer=Cut", "layer=Fold", "stroke=red", "stroke=black"])
        self.assertIn("layer=Fold", kerf("inspect", path("plate.dxf"), server=False).stdout)
        self.assertEqual(self.json_of("cut", self.id, path("plate.dxf"), "--only", "layer=Cut", "--true-size")["pieces"], 2)
        pathlib.Path(path("binary.dxf")).write_bytes(b"AutoCAD Binary DXF\r\n\x1a\0")
        self.assertIn("save it as a DXF of text", kerf("cut", self.id, path("binary.dxf")).stderr)

    def test_outlines_take_another_unit(self):
        pathlib.Path(path("square.svg")).write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><rect x="1" y="1" width="4" height="2"/></svg>')
        for number, (options, area_m2) in enumerate(((("--unit", "cm"), 8e-4), (("--unit", "cm", "--scale", "10"), 0.08))):
            name = f"{self.id}-unit-{number}"
            self.json_of("sheet", "create", name, "--outline", path("square.svg"), *options)
            self.assertAlmostEqual(self.json_of("pieces", name)["pieces"][0]["area_m2"], area_m2, places=12)
        refused = kerf("sheet", "create", self.id + "-no", "--outline", path("square.svg"), "--up", "y")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--up", refused.stderr)

    def test_outlines_of_drawings_are_sheets(self):
        pathlib.Path(path("panels.svg")).write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="400mm" height="200mm" viewBox="0 0 400 200">'
            '<path stroke="red" fill="none" d="M10 10H190V190H10Z M60 60V140H140V60Z M210 10H390V190H210Z"/>'
            '<path stroke="blue" d="M0 0H9"/></svg>')
        made = self.json_of("sheet", "create", self.id + "-out", "--outline", path("panels.svg"), "--only", "stroke=red",
                            "--edge", "20mm", "--pin", "none", "--paused")
        self.assertEqual(made["pieces"], 2)
        areas = sorted(piece["area_m2"] for piece in self.json_of("pieces", self.id + "-out")["pieces"])
        self.assertAlmostEqual(areas[0], 0.18 ** 2 - 0.08 ** 2, places=9)
        self.assertAlmostEqual(areas[1], 0.18 ** 2, places=9)
        self.assertEqual(kerf("sheet", "create", "x", "--only", ".a").returncode, 2)


if __name__ == "__main__":
    main(__doc__)
