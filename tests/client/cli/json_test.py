"""`--json` everywhere: every command that `kerf` has answers with JSON and nothing else on standard output."""

import json
import pathlib

import cli_case
from cli_case import Case, kerf, main, path, scene_file, tearDownModule

# Calls each command; a new one has to be added. {work} is the test's folder.
CALLS = {
    "access": "access",
    "analyze": "analyze still",
    "completion": "completion bash",
    "cut": "cut still --circle 0.5,0.5,0.2",
    "cuts": "cuts still",
    "doctor": "doctor --data none",
    "export": "export still --out {work}/still.obj",
    "images": "images still --out {work}/film --size 64x64 --count 1",
    "info": "info",
    "inspect": "inspect {work}/ring.svg",
    "load": "load --grid 4x4 --duration 0.2",
    "open": "open still",
    "pieces": "pieces still",
    "redo": "redo still",
    "render": "render still --out {work}/still.png --size 64x64",
    "replay": "replay {work}/small.rec",
    "run": "run {work}/small.json --record {work}/small.rec",
    "sheet create": "sheet create made --grid 4x4",
    "sheet delete": "sheet delete made",
    "sheet forget": "sheet forget still before",
    "sheet get": "sheet get still",
    "sheet list": "sheet list",
    "sheet material": "sheet material still denim",
    "sheet self-contact": "sheet self-contact still on --friction 0.5",
    "sheet grab": "sheet grab live hand --at 0.5,0.5 --to 0.5,0,0.5",
    "sheet drag": "sheet drag live hand 0.5,-0.2,0.5",
    "sheet release": "sheet release live hand",
    "sheet pins": "sheet pins still left 0.9,0,1,0.1",
    "sheet gravity": "sheet gravity still 0,0,-1.62",
    "sheet wind": "sheet wind still 0,5,0",
    "sheet pause": "sheet pause still",
    "sheet play": "sheet play {work}/still.rec --id played",
    "sheet record": "sheet record still --out {work}/still.rec",
    "sheet reset": "sheet reset still",
    "sheet restore": "sheet restore still before",
    "sheet resume": "sheet resume live",
    "sheet save": "sheet save still before",
    "sheet speed": "sheet speed live 0.5",
    "sheet states": "sheet states still",
    "sheet step": "sheet step still 2",
    "store backup": "store backup monday",
    "store info": "store info",
    "store prune": "store prune",
    "token new": "token new alice --file {work}/tokens",
    "undo": "undo still",
    "version": "version",
    "watch": "watch live --frames 1",
}
# Commands for which this test has nothing; they refuse in JSON, and their own tests see the other answer.
REFUSALS = {"store delete": ("store delete 1", "SET_ASIDE_NOT_FOUND")}
# The rest may have any order.
FIRST = ["sheet pause", "analyze", "cut", "cuts", "undo", "redo", "run", "sheet create", "sheet record",
         "sheet save", "sheet restore", "sheet grab", "sheet drag"]


def setUpModule():
    cli_case.setUpModule("--data", path("data"))


def commands(*before):
    """All commands that Tab offers, down to those that have none below them: commands say what they do, values do not."""
    offered = kerf("__complete", *before, "", server=False).stdout.splitlines()[1:]
    words = [line.split("\t")[0] for line in offered if "\t" in line]
    return [name for word in words for name in commands(*before, word)] or [" ".join(before)]


class Json(Case):
    def test_every_command_answers_with_json(self):
        scene_file("small.json")
        pathlib.Path(path("ring.svg")).write_text('<svg xmlns="http://www.w3.org/2000/svg"><circle r="40"/></svg>')
        self.json_of("sheet", "create", "still", "--grid", "6x6")
        self.json_of("sheet", "create", "live", "--grid", "6x6")
        everything = commands()
        self.assertEqual(sorted(everything), sorted([*CALLS, *REFUSALS]), "CALLS of this test has to name each command of kerf")
        for call, reason in REFUSALS.values():
            refused = kerf("--json", *call.split(" "))
            self.assertEqual((refused.returncode, json.loads(refused.stderr)["error"]["reason"]), (1, reason))
        for command in FIRST + [each for each in sorted(CALLS) if each not in FIRST]:
            with self.subTest(command):
                done = kerf("--json", *CALLS[command].format(work=cli_case.OPTIONS.work).split(" "))
                if command in ("images", "render") and "RENDERER_UNAVAILABLE" in done.stderr:
                    continue
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                documents = done.stdout.splitlines() if command in ("images", "watch") else [done.stdout]
                self.assertTrue(documents)
                for document in documents:
                    self.assertIsInstance(json.loads(document), dict)

    def test_the_other_ways_of_a_command(self):
        self.json_of("sheet", "create", "ways", "--grid", "6x6")
        self.json_of("cut", "ways", "--circle", "0.5,0.5,0.2")
        written = self.json_of("cuts", "ways", "--export", path("ways.json"))
        self.assertEqual(written, {"file": path("ways.json"), "cuts": 1})
        self.assertEqual(len(json.loads(pathlib.Path(path("ways.json")).read_text())["cuts"]), 1)
        self.json_of("undo", "ways")
        self.assertEqual(self.json_of("cuts", "ways", "--apply", path("ways.json"))["applied"], 1)
        self.assertEqual(self.json_of("completion", "zsh")["shell"], "zsh")
        self.assertIn("__kerf_complete", self.json_of("completion", "fish")["script"])


if __name__ == "__main__":
    main(__doc__)
