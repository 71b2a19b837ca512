"""`kerf load` against a real kerfd; what it measures is tested in tests/client/load."""

import json
import pathlib
import signal
import socket
import subprocess

import cli_case
from cli_case import Case, address, below_a_file, closed_port, kerf, main, path, setUpModule, tearDownModule


class Load(Case):
    SMALL = ("load", "--grid", "6x6", "--warm-up", "0.1", "--duration", "0.5")

    def loaded(self):
        return [sheet["name"] for sheet in self.json_of("sheet", "list")["sheets"] if "load" in sheet["name"]]

    def test_json_text_and_html(self):
        report = self.json_of(*self.SMALL, "--sheets", "2", "--viewers", "3", "--cuts-per-second", "8", "--html", path("load.html"))
        self.assertEqual((report["sheets"]["made"], report["readers"]["viewers"]["readers"], report["cuts"]["sent"]), (2, 3, 4))
        self.assertEqual(report["errors"], {})
        page = pathlib.Path(path("load.html")).read_text()
        self.assertEqual(page.count("<svg"), page.count("</svg>"))
        self.assertGreater(page.count("<svg"), 2)
        self.assertIn("4 of 4" if report["cuts"]["applied"] == 4 else f"{report['cuts']['applied']} of 4", page)
        done = kerf(*self.SMALL)
        self.assertEqual(done.returncode, 0, done.stderr)
        for word in ("sheets     1 of 1", "real time", "a thread that only sleeps", "p99.9"):
            self.assertIn(word, done.stdout)
        self.assertEqual(done.stderr, "")  # no line that is written over and over unseen
        self.assertEqual(self.loaded(), [])

    def test_interrupted_it_tells_what_it_has_and_deletes_its_sheets(self):
        process = subprocess.Popen([cli_case.OPTIONS.kerf, "--server", address(), "--json", "load", "--grid", "6x6", "--duration", "600"],
                                   stdout=subprocess.PIPE, text=True)
        while not self.loaded():
            pass
        process.send_signal(signal.SIGINT)
        report = json.loads(process.communicate(timeout=60)[0])
        self.assertEqual(process.returncode, 0)
        self.assertTrue(report["interrupted"])
        self.assertEqual(self.loaded(), [])

    def test_a_report_of_before_stays_where_no_server_answers(self):
        report = pathlib.Path(path("before.html"))
        report.write_text("of before")
        done = kerf("--server", closed_port(), *self.SMALL, "--html", str(report), server=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"no server answers at {closed_port()}", done.stderr)
        self.assertEqual(report.read_text(), "of before")

    def test_where_no_reader_sees_anything_that_is_an_error(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:  # accepts, and says nothing
            http = f"127.0.0.1:{silent.getsockname()[1]}"
            done = kerf("--json", *self.SMALL, "--transport", "ws", "--http", http, "--viewers", "2")
        report = json.loads(done.stdout)
        self.assertEqual(sum(count for what, count in report["errors"].items() if what.startswith("viewers ")), 2)
        self.assertIn("2 of 2 viewers never received a frame", " ".join(report["warnings"]))
        self.assertEqual((done.returncode, json.loads(done.stderr)["error"]["reason"]), (1, "NO_READER"))

    def test_wrong_options_are_refused_before_anything_is_made(self):
        for options, says in ((("--sheets", "10001"), "1..10000"), (("--grid", "big"), "50x50"), (("--duration", "0"), "0.1..1800"),
                              (("--viewers", "-1"), "0..1000"), (("--transport", "ws"), "--http"), (("--prefix", "Load"), "--prefix"),
                              (("--image-size", "1x1"), "16..4096")):
            self.refused("load", *options, code=2, says=says)
        self.refused(*self.SMALL, "--html", below_a_file("report.html"), says="no-folder/report.html")
        self.assertEqual(self.loaded(), [])


if __name__ == "__main__":
    main(__doc__)
