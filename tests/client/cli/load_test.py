"""`kerf load` against a real kerfd; what it measures is tested in tests/client/load."""

import csv
import io
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

    def test_conditions_have_exit_codes_of_their_own(self):
        cuts = (*self.SMALL, "--cuts-per-second", "20")
        for conditions, code, says in ((("cuts_sent<10", "errors>0"), 0, ""), (("cuts_sent>=10",), 3, "cuts_sent>=10: failed, 10"),
                                       ((" cut_p99>1s ",), 4, "10 values, where at least 100 are needed"),
                                       (("cut_p99>1s", "cuts_sent>1"), 3, "cuts_sent>1: failed")):
            done = kerf(*cuts, *(word for condition in conditions for word in ("--fail-if", condition)))
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            self.assertIn(says, done.stderr)
            self.assertIn(f"  {conditions[0].strip()}: ", done.stdout)
        self.refused("load", "--fail-if", "cut_p98>1ms", code=2, says="there is no metric cut_p98; did you mean cut_p")
        self.refused("load", "--fail-if", "cut_p99>1kB", code=2, says="units ms, s, us, not \"kB\"")
        listed = kerf("load", "--help", server=False).stdout
        for metric in ("cut_shown", "real_time_least", "server_memory"):
            self.assertIn(f"  {metric} ", listed)

    def test_csv_and_two_reports_side_by_side(self):
        one = kerf("--json", *self.SMALL, "--cuts-per-second", "10", "--csv", path("run.csv"), "--csv-summary", path("summary.csv"))
        rows = list(csv.DictReader(io.StringIO(pathlib.Path(path("run.csv")).read_text())))
        self.assertEqual([(row["from_s"], row["to_s"], row["sheets"]) for row in rows], [("0", "0.5", "1")])
        summary = {row["metric"]: row for row in csv.DictReader(io.StringIO(pathlib.Path(path("summary.csv")).read_text()))}
        report = json.loads(one.stdout)
        self.assertEqual(float(summary["ticks"]["value"]), report["sheets"]["ticks"])
        self.assertEqual(list(summary), list(report["metrics"]))
        pathlib.Path(path("a.json")).write_text(one.stdout)
        pathlib.Path(path("b.json")).write_text(kerf("--json", *self.SMALL, "--sheets", "2", "--cuts-per-second", "20").stdout)
        done = kerf("load", "--compare", path("a.json"), path("b.json"), "--html", path("both.html"), server=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("differs sheets: 1 and 2", done.stdout)
        self.assertRegex(done.stdout, r"\ncuts_sent +5 +10 +2\n")
        self.assertIn("second / first", pathlib.Path(path("both.html")).read_text())
        compared = json.loads(kerf("--json", "load", "--compare", path("a.json"), path("b.json"), server=False).stdout)
        self.assertEqual(compared["settings"][0], {"name": "sheets", "first": 1, "second": 2})
        for condition, code, says in (("cuts_sent>1.9x", 3, "cuts_sent>1.9x: failed, 2x"), ("cuts_sent>2x", 0, ""), ("cut_p99>0.01x", 4, "of too few values"),
                                      ("image_age_p50>2x", 4, "there is no ratio"), ("cuts_sent>1", 2, "1.2x")):
            done = kerf("load", "--compare", path("a.json"), path("b.json"), "--fail-if", condition, server=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(says, done.stderr)
        done = kerf("--json", "load", "--compare", path("a.json"), path("b.json"), "--fail-if", "cuts_sent>1.9x", server=False)
        self.assertEqual((done.returncode, done.stderr, json.loads(done.stdout)["fail_if"][0]["verdict"]), (3, "", "failed"))
        self.refused("load", "--fail-if", "cuts_sent>1.2x", code=2, says="--compare")
        self.refused("load", "--compare", path("a.json"), path("run.csv"), says="run.csv is no report")
        self.refused("load", "--compare", path("a.json"), path("none.json"), says="none.json")

    def test_a_scenario_is_a_file_of_options(self):
        pathlib.Path(path("scenario.json")).write_text(json.dumps(
            {"sheets": 2, "grid": "6x6", "duration": 0.5, "warm-up": 0, "still": True, "fail-if": ["errors>0", "ticks<0"], "prefix": "scenario"}))
        report = self.json_of("load", "--scenario", path("scenario.json"), "--sheets", "1")
        self.assertEqual((report["plan"]["sheets"], report["plan"]["columns"], report["plan"]["still"], report["plan"]["prefix"]), (1, 6, True, "scenario"))
        self.assertEqual([one["condition"] for one in report["fail_if"]], ["errors>0", "ticks<0"])
        for content, says in (({"sheet": 1}, 'no option "sheet"; did you mean sheets?'), ([], "no JSON object"), ({"sheets": "many"}, "many"),
                              ({"still": 3}, "true or false"), ({"sheets": [1, 2]}, "wrong kind"), ({"compare": ["a", "b"]}, "no option"),
                              ({"transport": "tcp"}, "tcp")):
            pathlib.Path(path("wrong.json")).write_text(json.dumps(content))
            self.refused("load", "--scenario", path("wrong.json"), says=says)
        pathlib.Path(path("wrong.json")).write_text("{")
        self.refused("load", "--scenario", path("wrong.json"), says="parse error")

    def test_the_shipped_scenario_has_the_options_that_there_are(self):
        scenario = cli_case.ROOT / "deploy/examples/load.json"
        report = self.json_of("load", "--scenario", str(scenario), "--stages", "300ms:2,200ms:0", "--fail-if", "errors>0")
        self.assertEqual((report["plan"]["cut_kind"], report["plan"]["sheets"], report["plan"]["viewers"]), ("mixed", 4, 2))

    def test_stages_of_sheets(self):
        report = self.json_of("load", "--grid", "6x6", "--warm-up", "0", "--stages", "0s:2,900ms:2", "--stages-of", "sheets")
        self.assertEqual((report["sheets"]["made"], report["sheets"]["running"], report["plan"]["duration_s"]), (2, 2, 0.9))
        self.refused("load", "--stages", "10:4", code=2, says="such as 10s:4")

    def test_wrong_options_are_refused_before_anything_is_made(self):
        for options, says in ((("--sheets", "10001"), "1..10000"), (("--grid", "big"), "50x50"), (("--duration", "0"), "0.1..1800"),
                              (("--viewers", "-1"), "0..1000"), (("--transport", "ws"), "--http"), (("--prefix", "Load"), "--prefix"),
                              (("--image-size", "1x1"), "16..4096")):
            self.refused("load", *options, code=2, says=says)
        self.refused(*self.SMALL, "--csv", below_a_file("run.csv"), says="no-folder/run.csv")
        self.refused(*self.SMALL, "--html", below_a_file("report.html"), says="no-folder/report.html")
        self.assertEqual(self.loaded(), [])


if __name__ == "__main__":
    main(__doc__)
