"""Runs the lines of the pages for users that call kerf, kerfd, curl and grpcurl, as they stand there, one after the other. The
server has the demo scene. The ports, and programs that lie elsewhere, are put in place of those of the text. The programs,
presets and files of other lines must exist. Python and the program in C++ of the tutorial are run, too."""

import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import unittest
import urllib.request

import cli_case
from cli_case import ROOT, Case, address, main, path, tearDownModule
from reflection import Reflection

PAGES = ("README.md", "client/tutorial.md", "deploy/troubleshooting.md", "client/howto.md", "client/cli/README.md", "client/files.md",
         "client/drawings.md")
# Their lines build and test, which no test can do.
PAGES_FOR_DEVELOPERS = ("CONTRIBUTING.md", "server/README.md", "tests/bench/README.md", "tests/bench/performance.md",
                        "tests/stability/README.md")
PROGRAMS = ("kerf", "kerfd", "curl", "grpcurl")
SHELL = ("cd", "export")
BUILD_TOOLS = ("clang-tidy", "cmake", "ctest")
MOST_LETTERS = 140  # of a line in a block
# Each of these lines begins a part, which needs nothing that lines before it made. Lines before the first are part 1; the
# last part also has the other tests.
PARTS = (("client/howto.md", "kerf cut demo --bezier"), ("client/cli/README.md", "kerf cut demo --bezier"),
         ("client/cli/README.md", "kerf render demo --out frame.png --size"), ("client/cli/README.md", "kerf sheet material demo"),
         ("client/cli/README.md", "kerf sheet create flag"))
# Lines that need the cuts of lines before them. The others find the scene as it was, which costs less to step than a cut one.
AFTER_CUTS = ("kerf cut", "kerf undo", "kerf pieces")


def setUpModule():
    cli_case.setUpModule("--scene", str(ROOT / "deploy/scenes/demo.json"), "--data", path("data"))
    for folder in ("deploy", "tests", "proto"):
        os.symlink(ROOT / folder, path(folder))


def blocks(page):
    """The lines of each fenced shell block, a line that continues put together."""
    texts = re.findall(r"```sh\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    return [text.replace("\\\n", " ").splitlines() for text in texts]


def commands(page):
    """The lines of a page's shell blocks, without comments that have a line of their own."""
    return [line for block in blocks(page) for line in block if line and not line.startswith("#")]


def lines_of(page):
    return [line for line in commands(page) if line.split(" ")[0] in PROGRAMS]


def lines():
    """The commands of all pages."""
    return [line for page in PAGES for line in lines_of(page)]


def first_lines():
    """The commands that README.md has a newcomer paste, each with what it prints."""
    block = next(block for block in blocks("README.md") if block[0].startswith("export PATH"))
    return [(command, output.removeprefix("# ")) for command, output in zip(block[1::2], block[2::2])]


def part_lines():
    """Those of the part that --part names."""
    every = [(page, line) for page in PAGES for line in lines_of(page)]
    starts = [0, *(next(i for i, (page, line) in enumerate(every) if page == of and line.startswith(start)) for of, start in PARTS),
              len(every)]
    part = cli_case.OPTIONS.part
    return [line for _, line in every[starts[part - 1]:starts[part]]]


def post(method, **message):
    request = urllib.request.Request(f"{cli_case.SERVER['http']}/kerf.v1.SheetService/{method}", json.dumps(message).encode(),
                                     {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=60) as reply:
        return json.load(reply)


def let_run(line):
    """Those sheets that the line names, and pauses the rest: a machine with few cores is not to step all of them all the time."""
    for sheet in post("ListSheets").get("sheets", []):
        runs = re.search(rf"\b{sheet['name'].removeprefix('sheets/')}\b", line)
        post("ResumeSheet" if runs else "PauseSheet", name=sheet["name"])


def with_ports(line):
    http = cli_case.SERVER["http"].removeprefix("http://")
    return line.replace("127.0.0.1:8080", http).replace("127.0.0.1:50051", address())


def is_server(line):
    """Tells whether the line starts a server, which only a signal ends."""
    return line.startswith("kerfd ") and not re.search(r"--(help|version|list-render-devices)\b", line)


def likeness(output):
    """A pattern of this output: numbers are those of another moment and another machine, and so are the gaps after them."""
    numbers = re.sub(r"\d[\d.]*", lambda _: r"\d[\d.e-]*", re.escape(output).replace(r"\.", "."))
    return re.sub(r"(\\ )+", " +", numbers)


class Readme(Case):
    def run_server(self, line):
        """Starts it on free ports, and stops it once it is ready."""
        command = [cli_case.OPTIONS.kerfd, *shlex.split(line, comments=True)[1:], "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
            ready = server.stdout.readline()
            server.send_signal(signal.SIGTERM)
            _, errors = server.communicate(timeout=60)
        return subprocess.CompletedProcess(command, server.returncode, ready, errors)

    def run_line(self, line):
        environment = {**os.environ, "KERF_SERVER": address(), "PATH": os.path.dirname(cli_case.OPTIONS.kerf) + ":" + os.environ["PATH"]}
        # curl: an answer that tells of an error ends the call with one.
        shell = "curl() { command curl --fail-with-body \"$@\"; }\n" + with_ports(line)
        return subprocess.run(["bash", "-c", shell], cwd=path("."), env=environment, capture_output=True, text=True, timeout=300)

    def test_every_line_does_what_it_says(self):
        self.assertGreater(sum(line.startswith("kerf ") for line in lines()), 40)
        self.assertGreaterEqual(sum(line.startswith("curl ") for line in lines()), 2)
        for line in part_lines():
            if line.startswith("grpcurl "):
                continue
            with self.subTest(line):
                if not line.startswith(AFTER_CUTS):
                    post("ResetSheet", name="sheets/demo")
                let_run(line)
                done = self.run_server(line) if is_server(line) else self.run_line(line)
                if "RENDERER_UNAVAILABLE" in done.stderr:
                    continue
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertTrue(done.stdout + done.stderr)

    def test_the_first_lines_print_what_the_page_says(self):
        self.assertEqual(len(first_lines()), 6)
        post("ResetSheet", name="sheets/demo")
        let_run("demo")
        for command, output in first_lines():
            with self.subTest(command):
                done = self.run_line(command)
                if "RENDERER_UNAVAILABLE" in done.stderr:
                    continue
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertRegex(done.stdout, f"(?m)^{likeness(output)}$")

    def test_other_lines_name_what_there_is(self):
        """Lines that build, install or test are not run here."""
        lists = "\n".join(file.read_text() for top in ("client", "server", "tests") for file in (ROOT / top).rglob("CMakeLists.txt"))
        presets = {preset["name"] for preset in json.loads((ROOT / "CMakePresets.json").read_text())["testPresets"]}
        for page in PAGES + PAGES_FOR_DEVELOPERS:
            for line in commands(page):
                with self.subTest(f"{page}: {line}"):
                    for preset in re.findall(r"--preset (\w+)", line):
                        self.assertIn(preset, presets)
                    for call in re.split(r" && ", line.split(" #")[0].strip()):
                        words = [word for word in call.split() if not re.match(r"[A-Z_]+=", word)]
                        if not words or words[0] in PROGRAMS + SHELL + BUILD_TOOLS or shutil.which(words[0]):
                            continue
                        if words[0].startswith("build/"):
                            self.assertRegex(lists, rf"\b{os.path.basename(words[0])}\b")
                        else:
                            self.assertTrue(os.access(ROOT / words[0], os.X_OK), words[0])

    def test_python_of_the_tutorial(self):
        package = path("package")
        subprocess.run([ROOT / "client/python/generate", package], check=True, capture_output=True, timeout=300)
        text = (ROOT / "client/tutorial.md").read_text()
        block, = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        for script in (["-c", block.replace("connect()", f'connect("{address()}")')],
                       [ROOT / "client/python/examples/cut_example.py", "--server", address()]):
            done = subprocess.run([sys.executable, *script], env={**os.environ, "PYTHONPATH": package}, capture_output=True, text=True,
                                  timeout=300)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(done.stdout)

    def test_program_of_the_tutorial(self):
        """Its lines are those of embed_core.cc, and it prints what the page says."""
        text = (ROOT / "client/tutorial.md").read_text()
        program = (ROOT / "client/examples/embed_core.cc").read_text().splitlines()
        for line in re.search(r"```cpp\n(.*?)```", text, re.DOTALL).group(1).splitlines():
            self.assertIn(line, program)
        embed_core = pathlib.Path(cli_case.OPTIONS.kerf).with_name("embed_core")
        done = subprocess.run([embed_core], capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        printed = re.search(r"```text\n(.*?), state hash", text, re.DOTALL).group(1)
        self.assertRegex(done.stdout, likeness(printed))

    def test_lines_fit_the_page_and_files_are_there(self):
        for page in PAGES:
            text = (ROOT / page).read_text()
            for block in re.findall(r"```\w*\n(.*?)```", text, re.DOTALL):
                for line in block.splitlines():
                    self.assertLessEqual(len(line), MOST_LETTERS, line)
            for file in re.findall(r"\b(?:deploy|tests/data)/[\w/-]+\.\w+", text):
                self.assertTrue((ROOT / file).is_file(), f"{page} names {file}")

    def test_page_of_options_lists_those_of_kerfd(self):
        text = (ROOT / "server/configuration.md").read_text()
        table = re.search(r"^\| option \|.*?\n\n", text, re.DOTALL | re.MULTILINE).group()
        listed = re.findall(r"`(--[\w-]+)", "\n".join(line.split("|")[1] for line in table.splitlines() if line))
        printed = subprocess.run([cli_case.OPTIONS.kerfd, "--help"], capture_output=True, text=True, timeout=60, check=True).stdout
        self.assertEqual(sorted(listed), sorted(re.findall(r"^  (?:-\w,)?(--[\w-]+)", printed, re.MULTILINE)))

    def test_curl_answers_are_json(self):
        for line in lines():
            if line.startswith("curl "):
                with self.subTest(line):
                    self.assertIsInstance(json.loads(self.run_line(line).stdout), dict)

    @unittest.skipUnless(shutil.which("grpcurl"), "there is no grpcurl here; the next test makes its calls")
    def test_grpcurl(self):
        for line in lines():
            if line.startswith("grpcurl "):
                with self.subTest(line):
                    done = self.run_line(line)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertTrue(done.stdout)

    def test_what_grpcurl_asks_is_answered(self):
        """Each of its lines taken apart, and made by reflection as grpcurl makes it."""
        server = Reflection(address())
        self.addCleanup(server.close)
        kinds = set()
        for line in lines():
            if not line.startswith("grpcurl "):
                continue
            words = shlex.split(with_ports(line), comments=True)[1:]
            self.assertEqual(words.pop(0), "-plaintext")
            data = {}
            if words[0] == "-d":
                data = json.loads(words[1])
                words = words[2:]
            self.assertEqual(words.pop(0), address())
            with self.subTest(line):
                kinds.add("call" if "/" in words[0] else words[0])
                if words == ["list"]:
                    self.assertIn("kerf.v1.CutService", server.list())
                elif words[0] == "describe":
                    self.assertEqual(server.describe(words[1]).full_name, words[1])
                else:
                    self.assertTrue(server.call(words[0], data))
        self.assertEqual(kinds, {"list", "describe", "call"})


class ByReflection(Case):
    @classmethod
    def setUpClass(cls):
        cls.server = Reflection(address())

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def test_every_service_is_listed_and_described(self):
        services = [name for name in self.server.list() if name.startswith("kerf.v1.")]
        declared = re.findall(r"^service (\w+)", "".join(file.read_text() for file in (ROOT / "proto/kerf/v1").glob("*.proto")),
                              re.MULTILINE)
        self.assertEqual(sorted(services), sorted("kerf.v1." + name for name in declared))
        for service in services:
            self.assertTrue(self.server.describe(service).methods)
        self.assertIn("radius_m", self.server.describe("kerf.v1.Circle").fields_by_name)
        with self.assertRaises(LookupError):
            self.server.describe("kerf.v1.Spline")

    def test_calls_made_by_what_was_described(self):
        made = self.server.call("kerf.v1.SheetService/CreateSheet", {
            "sheet_id": "reflected", "paused": True, "scene": {"grid": {"columns": 6, "rows": 6, "width_m": 1, "height_m": 1}}})
        self.assertEqual((made[0]["name"], made[0]["num_vertices"]), ("sheets/reflected", 36))
        cut = self.server.call("kerf.v1.CutService/CreateCut", {"parent": "sheets/reflected", "cut": {"curve": {"circle": {
            "center": {"x": 0.5, "y": 0.5}, "radius_m": 0.2}}}})
        self.assertEqual((cut[0]["status"], cut[0]["pieces"]), ("APPLIED", 2))
        frames = self.server.call("kerf.v1.StreamService/Subscribe", {"name": "sheets/demo", "max_rate_hz": 10, "max_frames": 2})
        self.assertEqual([answer["frame"]["sequence"] for answer in frames if "frame" in answer], ["1", "2"])


def load_tests(loader, tests, _):
    """The last part has all tests, the others the lines alone."""
    if cli_case.OPTIONS.part == len(PARTS) + 1:
        return tests
    return unittest.TestSuite([Readme("test_every_line_does_what_it_says")])


if __name__ == "__main__":
    main(__doc__, lambda parser: parser.add_argument("--part", type=int, choices=range(1, len(PARTS) + 2), required=True))
