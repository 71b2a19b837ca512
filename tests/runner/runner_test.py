"""deploy/test itself: what is read from logs and reports, the time left, and that the rest runs after a failure."""

import contextlib
import importlib.machinery
import importlib.util
import io
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import failures  # noqa: E402: from this folder
import processes  # noqa: E402
import progress  # noqa: E402
import schedule  # noqa: E402
import steps  # noqa: E402
from steps import ROOT, Step  # noqa: E402

loader = importlib.machinery.SourceFileLoader("runner_main", str(HERE / "__main__.py"))
runner = importlib.util.module_from_spec(importlib.util.spec_from_loader("runner_main", loader))
loader.exec_module(runner)

GTEST = """Running main() from ./googletest/src/gtest_main.cc
../../tests/fem/model_test.cc:41: Failure
Expected equality of these values:
  1
  2
[  FAILED  ] Model.HasMass (3 ms)
../../tests/fem/model_test.cc:60: Failure
Value of: false
[  FAILED  ] Sizes/Model.Grows/2, where GetParam() = 9 (12 ms)
"""
GTEST_END = "[==========] 9 tests from 2 test suites ran. (20 ms total)\n[  PASSED  ] 7 tests.\n"
UNITTEST = f"""test_a (__main__.Cuts.test_a) ... ok
======================================================================
FAIL: test_b (__main__.Cuts.test_b)
----------------------------------------------------------------------
Traceback (most recent call last):
  File "/usr/lib/python3.11/unittest/case.py", line 57, in testPartExecutor
    yield
  File "{ROOT}/tests/client/cli/cuts_test.py", line 12, in test_b
    self.assertEqual(1, 2)
AssertionError: 1 != 2

----------------------------------------------------------------------
Ran 2 tests in 0.1s
"""
BROWSER = f"""[1/3] passed   the page opens (1.0 s)
[2/3] FAILED   a cut is made (2.0 s)
Error: no piece
    at check (file://{ROOT}/tests/e2e/harness.mjs:80:25)
  picture: {ROOT}/build/e2e/failed.png
  again:   {ROOT}/tests/e2e/run build/release/bin/kerfd watching
[3/3] not run  a cut is undone
1 passed, 2 failed
"""
VITEST = """ ❯ test/theme.test.ts (2 tests | 1 failed) 4ms
 FAIL  test/theme.test.ts > the theme > is kept
AssertionError: expected 1 to be 2
 FAIL  test/views.test.ts [ test/views.test.ts ]
"""
# As CTest 3.25 writes it: how a test ended is in its output alone.
JUNIT = """<?xml version="1.0"?><testsuite tests="6" failures="5">
<testcase name="fem_tests_1" status="fail"><failure message=""/><system-out>{gtest}</system-out></testcase>
<testcase name="fem_tests_2" status="fail"><failure message=""/><system-out>{crashed}</system-out></testcase>
<testcase name="cli_cuts_test" status="fail"><failure message=""/><system-out>{unittest}</system-out></testcase>
<testcase name="wire_tests_1" status="fail"><failure message=""/><system-out>terminate called</system-out></testcase>
<testcase name="svg_tests_1" status="notrun"><system-out>Unable to find executable</system-out></testcase>
<testcase name="mesh_tests_1" status="run"><system-out/></testcase></testsuite>"""
CTEST = """ 1/6 Test  #1: fem_tests_1 ......................***Failed    0.17 sec
 2/6 Test  #2: fem_tests_2 ......................***Exception: SegFault  0.17 sec
 3/6 Test #30: cli_cuts_test ....................***Failed    1.00 sec
 4/6 Test  #4: wire_tests_1 .....................***Timeout 120.01 sec
 5/6 Test  #5: svg_tests_1 ......................***Not Run   0.00 sec
 6/6 Test  #6: mesh_tests_1 .....................   Passed    0.00 sec
"""


class Failures(unittest.TestCase):
    def test_gtest(self):
        first, second = failures.of_gtest("build/release/bin/fem_tests", GTEST)
        self.assertEqual((first.name, first.where), ("Model.HasMass", "tests/fem/model_test.cc:41"))
        self.assertEqual(first.alone, "build/release/bin/fem_tests --gtest_filter='Model.HasMass'")
        self.assertIn("Expected equality", first.excerpt)
        self.assertEqual((second.name, second.where), ("Sizes/Model.Grows/2", "tests/fem/model_test.cc:60"))
        self.assertEqual(failures.of_gtest("x", "terminate called\n"), [])

    def test_unittest(self):
        (failure,) = failures.of_unittest("/usr/bin/python3 tests/client/cli/cuts_test.py", UNITTEST)
        self.assertEqual((failure.name, failure.where), ("__main__.Cuts.test_b", "tests/client/cli/cuts_test.py:12"))
        self.assertTrue(failure.alone.endswith("cuts_test.py -k '*.Cuts.test_b'"))
        prepared = UNITTEST.replace("FAIL: test_b (__main__.Cuts.test_b)", "ERROR: setUpClass (__main__.Cuts)")
        (failure,) = failures.of_unittest("python3 a.py", prepared)
        self.assertEqual(failure.alone, "python3 a.py -k '*.Cuts.*'")

    def test_ctest(self):
        with tempfile.TemporaryDirectory() as folder, \
                mock.patch.object(failures, "commands", return_value={
                    "fem_tests_1": ["bin/fem_tests"], "fem_tests_2": ["bin/fem_tests"],
                    "cli_cuts_test": ["python3", "a.py", "-k", "test_b"]}):
            report = pathlib.Path(folder, "report.xml")
            report.write_text(JUNIT.format(gtest=GTEST + GTEST_END, crashed=GTEST + "terminate called", unittest=UNITTEST))
            found = failures.of_ctest("release", report, CTEST)
            seeded = failures.of_ctest("release", report, CTEST, "KERF_SEED=7")
        two = ["Model.HasMass", "Sizes/Model.Grows/2"]
        self.assertEqual([failure.name for failure in found],
                         [*two, *two, "fem_tests_2 (exception: segfault)", "__main__.Cuts.test_b", "wire_tests_1 (timeout)",
                          "svg_tests_1 (not run)"])
        self.assertEqual(found[5].alone, "python3 a.py -k '*.Cuts.test_b'")
        self.assertEqual(found[6].alone, "ctest --preset release -R '^wire_tests_1$'")
        self.assertEqual(seeded[0].alone, "KERF_SEED=7 bin/fem_tests --gtest_filter='Model.HasMass'")
        self.assertEqual(seeded[6].alone, "KERF_SEED=7 ctest --preset release -R '^wire_tests_1$'")
        self.assertEqual(failures.of_ctest("release", pathlib.Path("/proc/none")), [])

    def test_browser_and_viewer(self):
        (failure,) = failures.of_browser(BROWSER)
        self.assertEqual((failure.name, failure.where), ("a cut is made", "tests/e2e/harness.mjs:80"))
        self.assertEqual(failure.alone, "tests/e2e/run build/release/bin/kerfd watching")
        failure, unloaded = failures.of_vitest(VITEST)
        self.assertEqual((failure.where, failure.alone),
                         ("web/test/theme.test.ts", "(cd web && npx vitest run test/theme.test.ts -t 'the theme is kept')"))
        self.assertEqual(unloaded.alone, "(cd web && npx vitest run test/views.test.ts)")

    def test_compiler_and_what_is_not_known(self):
        log = f"{ROOT}/server/core/mesh/a.cc:3:7: error: no such thing\n{ROOT}/server/core/mesh/a.cc:9:1: error: another\n"
        (failure,) = failures.of_compiler("build", log)
        self.assertEqual((failure.where, failure.alone, failure.excerpt), ("server/core/mesh/a.cc:3:7", "deploy/test build", "no such thing"))
        (failure,) = failures.of_compiler("format", "server/a.cc:3:4: error: code should be clang-formatted [-Wclang-format-violations]\n")
        self.assertEqual((failure.name, failure.alone), ("formatting of server/a.cc", "clang-format -i server/a.cc"))
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder, "log")
            log.write_text("one\ntwo\n")
            (failure,) = failures.of_step(Step("x", "", (), 1), log, log / "none")
            self.assertEqual((failure.alone, failure.excerpt), ("deploy/test x", "one\ntwo"))


@mock.patch.object(processes, "PATIENCE", 0.3)
class Processes(unittest.TestCase):
    def lines_of(self, command):
        with processes.Command(command) as running:
            lines = [line for line in running if line]
        return running.status, lines

    @staticmethod
    def runs(pid):
        """Returns whether a process runs; one that has ended may still be listed until its parent has looked."""
        try:
            return "State:\tZ" not in pathlib.Path(f"/proc/{pid.strip()}/status").read_text()
        except OSError:
            return False

    @classmethod
    def kill(cls, pid):
        if cls.runs(pid):
            os.kill(int(pid), signal.SIGKILL)

    def test_a_command_runs_to_its_end(self):
        self.assertEqual(self.lines_of("echo a; printf b; exit 3"), (3, ["a\n", "b"]))

    def test_last_lines_are_read_by_one_who_looks_seldom(self):
        lines = []
        with processes.Command("sleep 0.3; echo last") as running:
            for line in running:
                lines.append(line)
                if line is None:
                    running.process.wait()
        self.assertIn("last\n", lines)

    def test_nothing_that_it_left_behind_lives_on(self):
        status, (child,) = self.lines_of("(trap '' TERM; echo $BASHPID; exec >/dev/null; sleep 1000) & sleep 0.2; exit 4")
        self.assertEqual(status, 4)
        self.assertFalse(self.runs(child))
        status, (child,) = self.lines_of("sleep 1000 & echo $!")  # it holds the pipe open
        self.assertEqual(status, 0)
        self.assertFalse(self.runs(child))

    def test_what_interrupts_ends_all(self):
        with self.assertRaises(KeyboardInterrupt), processes.Command("echo $$; sleep 1000") as running:
            child = next(line for line in running if line)
            raise KeyboardInterrupt
        self.assertFalse(self.runs(child))

    def test_a_second_interrupt_does_not_stop_the_ending(self):
        with tempfile.TemporaryDirectory() as folder:
            asked = pathlib.Path(folder, "asked")
            stubborn = f"trap 'echo > {asked}' TERM; echo $$; while :; do sleep 0.01 || :; done"
            program = (f"import processes\nprocesses.PATIENCE = 0.5\nprocesses.interrupt_once()\n"
                       f"with processes.Command({stubborn!r}) as running:\n    for line in running:\n"
                       f"        if line: print(line, end='', flush=True)\n")
            with subprocess.Popen([sys.executable, "-c", program], cwd=HERE, text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL) as interrupted:
                child = interrupted.stdout.readline()
                self.assertTrue(self.runs(child))
                self.addCleanup(self.kill, child)
                interrupted.send_signal(signal.SIGINT)
                while not asked.exists() and interrupted.poll() is None:
                    time.sleep(0.01)
                self.assertTrue(asked.exists())
                for another in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                    interrupted.send_signal(another)
            self.assertFalse(self.runs(child))

    def test_a_process_of_another_session_does_not_hold_up_the_end(self):
        with mock.patch.object(processes, "PATIENCE", 0.3), processes.Command("setsid sleep 1000 & echo $!; exit 5") as running:
            child = next(line for line in running if line)
            self.addCleanup(self.kill, child)
            self.assertEqual(list(filter(None, running)), [])
        self.assertEqual(running.status, 5)


class Progress(unittest.TestCase):
    def test_counts(self):
        self.assertEqual(progress.count_in("[12/300] Building CXX object"), (12, 300))
        self.assertEqual(progress.count_in(" 7/89 Test #7: mesh_tests_1 ....   Passed    1.00 sec"), (7, 89))
        self.assertIsNone(progress.count_in("Running main()"))

    def test_time_left(self):
        now = 0.0
        step = progress.StepProgress(100.0, lambda: now)
        self.assertEqual(step.left(), 100.0)
        now = 20.0
        self.assertEqual(step.left(), 80.0)
        step.line("[50/100] a warm build is sooner done than expected")
        now = 30.0
        self.assertLess(step.left(), 70.0)
        now = 150.0
        self.assertGreater(step.left(), 0.0)
        self.assertEqual(progress.in_words(245), "4:05")

    def test_what_a_step_took_is_expected_the_next_time(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "logs/seconds.json")
            step = Step("a", "", (), 50)
            self.assertEqual(progress.Memory(path).expected(step), 50)
            progress.Memory(path).note(step, 7.04)
            self.assertEqual(progress.Memory(path).expected(step), 7.0)
            path.write_text("{")
            self.assertEqual(progress.Memory(path).expected(step), 50)


class Steps(unittest.TestCase):
    def test_sets_name_steps_and_needs_come_first(self):
        for names in steps.SETS.values():
            ordered = [step.name for step in steps.with_needs(names)]
            self.assertEqual(len(ordered), len(set(ordered)))
            for step in map(steps.STEPS.get, ordered):
                for needed in step.needs:
                    self.assertLess(ordered.index(needed), ordered.index(step.name))
        used = {step.name for names in steps.SETS.values() for step in steps.with_needs(names)}
        self.assertEqual(used, set(steps.STEPS))

    def test_every_long_proof_has_a_page(self):
        self.assertEqual(sorted(page.stem for page in (ROOT / "tests/long").glob("*.md")), sorted(steps.LONG))


class Schedule(unittest.TestCase):
    def test_a_step_waits_for_its_needs_and_for_those_that_it_does_not_run_beside(self):
        build, tests = Step("build", "", (), 100), Step("tests", "", (), 60, ("build",))
        browser = Step("browser", "", (), 80, ("build",), beside=("tests",))
        self.assertTrue(schedule.may_begin(build, [], []))
        self.assertFalse(schedule.may_begin(tests, [], []))
        self.assertTrue(schedule.may_begin(tests, [], ["build"]))
        self.assertTrue(schedule.may_begin(browser, [tests], ["build"]))
        self.assertTrue(schedule.may_begin(tests, [browser], ["build"]))
        self.assertFalse(schedule.may_begin(build, [tests], []))
        self.assertEqual(schedule.failed_needs(tests, [], []), [])
        self.assertEqual(schedule.failed_needs(tests, [], ["build"]), ["build"])
        self.assertEqual(schedule.failed_needs(tests, ["build"], ["build"]), [])

    def test_time_left_is_that_of_steps_side_by_side(self):
        build, tests = Step("build", "", (), 100), Step("tests", "", (), 60, ("build",))
        browser = Step("browser", "", (), 80, ("build",), beside=("tests",))
        trials = Step("trials", "", (), 30, ("build",))

        def left(running, waiting, ended=()):
            return schedule.time_left(running, waiting, ended, lambda step: step.seconds)

        self.assertEqual(left([(build, 40.0)], [tests, browser, trials]), 40 + 80 + 30)
        self.assertEqual(left([(tests, 20.0), (browser, 10.0)], [trials], ["build"]), 20 + 30)
        self.assertEqual(left([], [tests]), 0.0)
        self.assertEqual(left([], []), 0.0)


class Run(unittest.TestCase):
    def run_steps(self, *some):
        names = [step.name for step in some]
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(runner, "LOGS", pathlib.Path(folder)), \
                mock.patch.dict(steps.STEPS, {step.name: step for step in some}, clear=True), \
                contextlib.redirect_stdout(io.StringIO()) as out:
            failed = runner.run(names)
        return failed, out.getvalue()

    def test_the_rest_runs_after_a_failure_but_not_what_needs_it(self):
        failed, out = self.run_steps(
            Step("a", "works", ("true", "echo '3 passed, 0 failed'"), 1), Step("b", "breaks", ("echo why; false", "echo not reached"), 1),
            Step("c", "needs b", ("true",), 1, ("b",)), Step("d", "works, too", ("true",), 1))
        self.assertEqual(failed, 2)
        self.assertIn("[1/4] a passed in 0:00, 3 passed", out)
        self.assertIn("[2/4] b FAILED", out)
        self.assertIn("      | why", out)
        self.assertNotIn("not reached", out)
        self.assertIn("[3/4] c NOT RUN: b failed", out)
        self.assertIn("[4/4] d passed", out)
        self.assertIn("FAILED in b: step b, run alone by: deploy/test b", out)
        self.assertEqual(out.splitlines()[-1], "2 passed, 2 failed")

    def test_steps_run_side_by_side_where_they_may(self):
        with tempfile.TemporaryDirectory() as folder:
            # Each waits for a word that the other writes, so neither ends without the other.
            def meets(mine, others):
                return f"echo here > {folder}/{mine}; until [[ -s {folder}/{others} ]]; do sleep 0.01; done; echo met"

            first = Step("a", "meets b", (meets("a", "b"),), 1)
            second = Step("b", "meets a", (meets("b", "a"),), 1, beside=("a",))
            third = Step("c", "comes after both", (f"test -s {folder}/a; test -s {folder}/b; false",), 1)
            failed, out = self.run_steps(first, second, third, Step("d", "needs c", ("true",), 1, ("c",)))
        self.assertEqual(failed, 2)
        self.assertLess(out.index("[2/4] b: meets a"), out.index("[1/4] a passed"))
        self.assertLess(out.index("[2/4] b passed"), out.index("[3/4] c: comes after both"))
        self.assertIn("[4/4] d NOT RUN: c failed", out)

    def test_what_interrupts_ends_every_step(self):
        with tempfile.TemporaryDirectory() as folder:
            both = (Step("a", "sleeps", (f"echo $$ > {folder}/a; sleep 1000",), 1),
                    Step("b", "sleeps, too", (f"echo $$ > {folder}/b; sleep 1000",), 1, beside=("a",)))

            def interrupt(_):
                pids[:] = [path.read_text() for path in map(pathlib.Path, (f"{folder}/a", f"{folder}/b")) if path.exists()]
                if len(pids) == 2 and all(pids):
                    raise KeyboardInterrupt

            pids = []
            with mock.patch.object(runner.Screen, "progress", side_effect=interrupt):
                try:
                    self.run_steps(*both)
                    self.fail("it was not interrupted")
                except KeyboardInterrupt:  # Its frames still hold the steps here, so only the run itself can have ended them.
                    self.assertEqual([Processes.runs(pid) for pid in pids], [False, False])

    def test_neither_a_lost_log_nor_a_full_disk_ends_the_run(self):
        failed, out = self.run_steps(Step("a", "loses its log", ('rm "$LOG.log"; false',), 1), Step("b", "works", ("true",), 1))
        self.assertEqual(failed, 1)
        self.assertIn("its output could not be read", out)
        self.assertIn("[2/2] b passed", out)

        def fill_the_disk(_):
            yield "a line"
            raise OSError(28, "No space left on device")

        with mock.patch.object(runner, "run_step", fill_the_disk):
            failed, out = self.run_steps(Step("a", "fills the disk", ("true",), 1), Step("b", "too", ("true",), 1))
        self.assertEqual(failed, 2)
        self.assertIn("[1/2] a: [Errno 28] No space left on device", out)

    def test_a_step_that_hangs_is_ended(self):
        with mock.patch.object(runner, "LONGEST_SILENCE", 0.5):
            failed, out = self.run_steps(Step("a", "hangs", ("echo last words; sleep 1000",), 1), Step("b", "works", ("true",), 1))
        self.assertEqual(failed, 1)
        self.assertIn("      | last words", out)
        self.assertIn("ended: it printed nothing for 0:00 minutes", out)
        self.assertIn("[2/2] b passed", out)

    def test_wrong_words_are_refused(self):
        for words in (["no-such-step"], ["long"], ["long", "no-such-proof"], ["quick", "deep"]):
            with contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(runner.main(words), 2)
            self.assertIn("deploy/test", said.getvalue())


if __name__ == "__main__":
    unittest.main()
