"""deploy/test: runs steps, shows how far they are, runs the rest after a failure, and ends with what failed."""

import datetime
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import failures
from processes import Command, end_as_interrupted, interrupt_once
from progress import Memory, StepProgress, in_words
from schedule import failed_needs, may_begin, time_left
from steps import LONG, ROOT, SETS, STEPS, with_needs

LOGS = ROOT / "build/test-logs"
EVERY = 30.0  # seconds between two lines of progress where the output is no terminal
LONGEST_SILENCE = 900.0  # seconds without a line of output after which a step hangs and is ended
TURN = 0.2  # seconds of lines of one step before another that runs beside it is looked at

USAGE = f"""deploy/test builds Kerf and proves it. What it installs is listed in deploy/setup.

  deploy/test             {', '.join(SETS[''])}: what a user runs to believe in Kerf
  deploy/test quick       {', '.join(SETS['quick'])}: what an engineer runs before each commit
  deploy/test deep        {', '.join(SETS['deep'])}
  deploy/test long NAME   a proof of an hour or more; its result is written to tests/long/NAME.md
  deploy/test STEP...     these steps, and those that they need

Steps:
""" + "\n".join(f"  {step.name:<12}{step.proves}" for step in STEPS.values()) + """

Proofs by name, not part of CI:
""" + "\n".join(f"  {name:<18}{proof.proves} ({proof.takes})" for name, proof in LONG.items()) + """

Logs are in build/test-logs: one run at a time in a checkout. Ends with status 0 where everything passed, 1 where something
failed, 2 where the words were none of these."""


class Screen:
    """One line that is written over on a terminal; elsewhere a line now and then."""

    def __init__(self):
        self.out = sys.stdout
        self.is_terminal = self.out.isatty()
        self.last = time.monotonic()

    def say(self, text):
        self.out.write(("\r\x1b[K" if self.is_terminal else "") + text + "\n")
        self.out.flush()

    def progress(self, text):
        now = time.monotonic()
        if self.is_terminal:
            if now - self.last < 0.2:
                return
            self.out.write("\r\x1b[K" + text[: shutil.get_terminal_size().columns - 1])
            self.out.flush()
        elif now - self.last < EVERY:
            return
        else:
            self.say(text)
        self.last = now


def run_step(step):
    """Runs the commands of a step into its log; returns whether all ended well. Yields their lines, and None where there is
    none for a while."""
    log = LOGS / f"{step.name}.log"
    for old in (log, LOGS / f"{step.name}.xml"):
        old.unlink(missing_ok=True)
    environment = {**os.environ, "LOG": str(LOGS / step.name)}
    with log.open("w", errors="replace") as file:
        for command in step.commands:
            file.write(f"$ {command}\n")
            file.flush()
            heard = time.monotonic()
            with Command(command, environment, ROOT) as running:
                for line in running:
                    if line is not None:
                        heard = time.monotonic()
                        file.write(line)
                    elif time.monotonic() - heard > LONGEST_SILENCE:
                        file.write(f"ended: it printed nothing for {in_words(LONGEST_SILENCE)} minutes\n")
                        return False
                    yield line
                if running.status != 0:
                    return False
    return True


class RunningStep:
    """A step whose commands run, and how far it is."""

    def __init__(self, step, head, expected):
        self.step = step
        self.head = head
        self.progress = StepProgress(expected)
        self.lines = run_step(step)
        self.passed = None  # until it has ended
        self.error = None  # such as a full disk

    def advance(self):
        """Takes the lines that are there, and waits a little where there is none; whether the step still runs."""
        try:
            until = time.monotonic() + TURN
            while time.monotonic() < until:
                line = next(self.lines)
                if line is None:
                    break
                self.progress.line(line)
        except StopIteration as end:
            self.passed = end.value
        except OSError as error:
            self.passed, self.error = False, error
        return self.passed is None

    def __str__(self):
        counted = self.progress.counted
        return self.head + (f" {counted[0]}/{counted[1]}" if counted else "")


def summary_of(step):
    """A line of the log that says how much was done, such as a count of tests."""
    text = (LOGS / f"{step.name}.log").read_text(errors="replace")
    plain = re.sub(r"\x1b\[[0-9;]*m", "", text)
    found = re.findall(r"(?:100% tests passed.*out of (\d+))|(?:Tests +(\d+) passed)|(?:^(\d+) passed, 0 failed)", plain, re.MULTILINE)
    return f", {''.join(found[-1])} passed" if found else ""


def report(step, failed, say):
    for failure in failed:
        say(f"  {failure.name}" + (f"\n    at    {failure.where}" if failure.where else "")
            + (f"\n    alone {failure.alone}" if failure.alone else ""))
        if failure.excerpt:
            say("\n".join("      | " + line for line in failure.excerpt.splitlines()))
    say(f"    log   {os.path.relpath(LOGS / step.name, ROOT)}.log")


def run(names):
    """Runs steps; the number of those that did not pass."""
    LOGS.mkdir(parents=True, exist_ok=True)
    memory = Memory(LOGS / "seconds.json")
    screen = Screen()
    steps = with_needs(names)
    heads = {step.name: f"[{number}/{len(steps)}] {step.name}" for number, step in enumerate(steps, start=1)}
    started = time.monotonic()
    waiting, running, passed, failed, took = list(steps), [], [], {}, {}

    def begin():
        """Begins each step that may run now, in their order, and passes over those that need one that failed."""
        while waiting:
            step, ended = waiting[0], [*passed, *failed]
            missing = failed_needs(step, passed, ended)
            if missing:
                failed[step.name] = []
                screen.say(f"{heads[step.name]} NOT RUN: {' and '.join(missing)} failed")
            elif may_begin(step, [other.step for other in running], ended):
                screen.say(f"{heads[step.name]}: {step.proves}")
                running.append(RunningStep(step, heads[step.name], memory.expected(step)))
            else:
                return
            waiting.pop(0)

    def end(ended):
        """Notes how a step ended."""
        step, seconds = ended.step, ended.progress.elapsed()
        took[step.name] = seconds
        if ended.error:
            screen.say(f"{ended.head}: {ended.error}")
        if ended.passed:
            passed.append(step.name)
            memory.note(step, seconds)
            screen.say(f"{ended.head} passed in {in_words(seconds)}{summary_of(step)}")
        else:
            failed[step.name] = failures.of_step(step, LOGS / f"{step.name}.log", LOGS / f"{step.name}.xml")
            screen.say(f"{ended.head} FAILED after {in_words(seconds)}")
            report(step, failed[step.name], screen.say)

    try:
        while waiting or running:
            begin()
            for each in list(running):
                if not each.advance():
                    running.remove(each)
                    end(each)
            left = time_left([(each.step, each.progress.left()) for each in running], waiting, [*passed, *failed], memory.expected)
            if running:
                screen.progress(f"{', '.join(map(str, running))}, {in_words(time.monotonic() - started)} so far, "
                                f"about {in_words(left)} left")
    finally:
        for each in running:
            each.lines.close()
    screen.say("")
    for step in steps:
        outcome = "passed" if step.name in passed else "FAILED" if step.name in took else "not run"
        screen.say(f"  {step.name:<12}{outcome:<8}{in_words(took.get(step.name, 0)):>6}")
    screen.say(f"  {'in all':<20}{in_words(time.monotonic() - started):>6}")
    for name, each in failed.items():
        for failure in each:
            screen.say(f"FAILED in {name}: {failure.name}" + (f", run alone by: {failure.alone}" if failure.alone else ""))
    screen.say(f"{len(passed)} passed, {len(failed)} failed")
    return len(failed)


def prove(name):
    """Runs one of the long proofs and writes its page; its exit status."""
    proof = LONG[name]
    started = time.monotonic()
    print(f"{proof.proves}; takes {proof.takes}", flush=True)
    lines = []
    with Command(proof.command, cwd=ROOT) as command:
        for line in command:
            if line is not None:
                print(line, end="", flush=True)
                lines.append(line.rstrip("\n").rpartition("\r")[2] + "\n")  # what a line of progress ended as
    status = command.status
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    outcome = "passed" if status == 0 else f"FAILED (status {status})"
    page = ROOT / f"tests/long/{name}.md"
    page.write_text(f"# {name}\n\nProves: {proof.proves}.\n\n```sh\ndeploy/test long {name}    # {proof.takes}\n```\n\n"
                    f"Last result: **{outcome}**, {datetime.date.today()}, commit {commit}, "
                    f"{in_words(time.monotonic() - started)} minutes.\n\n```\n{''.join(lines[-60:])}```\n")
    print(f"written to {os.path.relpath(page, ROOT)}")
    return 1 if status else 0


def set_up():
    """Installs what is missing; whether that went well."""
    return subprocess.run([ROOT / "deploy/setup", "test"], check=False).returncode == 0


def main(arguments):
    if "-h" in arguments or "--help" in arguments:
        print(USAGE)
        return 0
    if arguments[:1] == ["long"]:
        if len(arguments) == 2 and arguments[1] in LONG:
            return prove(arguments[1]) if set_up() else 1
        wrong = f"there is no proof '{arguments[1]}'; " if len(arguments) > 1 and arguments[1] not in LONG else ""
        print(f"deploy/test long: {wrong}say which one proof: {', '.join(LONG)}; deploy/test --help tells what they prove",
              file=sys.stderr)
        return 2
    names = SETS[""] if not arguments else SETS[arguments[0]] if len(arguments) == 1 and arguments[0] in SETS else arguments
    unknown = [name for name in names if name not in STEPS]
    if unknown and unknown[0] in (*SETS, "long") and unknown[0]:
        print(f"deploy/test: {unknown[0]} stands alone: deploy/test {unknown[0]}" + (" NAME" if unknown[0] == "long" else ""),
              file=sys.stderr)
        return 2
    if unknown:
        print(f"deploy/test: there is no step '{unknown[0]}'; there are {', '.join(STEPS)}; "
              f"or say quick, deep, long NAME or nothing", file=sys.stderr)
        return 2
    if not set_up():
        return 1
    return 1 if run(names) else 0


if __name__ == "__main__":
    interrupt_once()
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        print("\ndeploy/test: interrupted; its processes have ended", file=sys.stderr)
        end_as_interrupted()
