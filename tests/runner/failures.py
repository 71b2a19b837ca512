"""Finds what failed in a step, where, and how to run it alone, from the step's log and, of ctest, from its report."""

import dataclasses
import json
import re
import shlex
import subprocess
import xml.etree.ElementTree

from steps import ROOT

EXCERPT = 30  # lines


@dataclasses.dataclass(frozen=True)
class Failure:
    name: str
    alone: str  # a command that runs it alone, from the root of the repository
    where: str = ""  # file:line, if it is known
    excerpt: str = ""  # lines of its output


def relative(text):
    """The same with paths from the root of the repository."""
    return re.sub(r"(?:\.\./)+(?=(?:tests|server|client|render|web)/)", "", text.replace(f"{ROOT}/", ""))


def last_lines(text, count=EXCERPT):
    return "\n".join(text.rstrip().splitlines()[-count:])


def of_gtest(program, output):
    """Each failed test of a GoogleTest program that ran to its end; what crashed it has no such line."""
    failures = []
    # Output of a test ends with the line that says it failed.
    for chunk in re.split(r"(?<=ms\))\n", output):
        failed = re.search(r"^\[  FAILED  \] (\S+?),? .*ms\)$", chunk, re.MULTILINE)
        if not failed:
            continue
        place = re.search(r"^(\S+\.(?:cc|h):\d+): Failure", chunk, re.MULTILINE)
        failures.append(Failure(failed[1], f"{program} --gtest_filter='{failed[1]}'", relative(place[1]) if place else "",
                                relative(last_lines(chunk))))
    return failures


def of_unittest(command, output):
    """Each failed test of a Python program."""
    failures = []
    for chunk in output.split("=" * 70 + "\n")[1:]:
        failed = re.match(r"(?:FAIL|ERROR): (\w+) \((\S+)\)", chunk)
        if not failed:
            continue
        # Preparations of a class have its tests after them; else the id's last words are class and test.
        wanted = failed[2].split(".")[-1] + ".*" if failed[1] in ("setUpClass", "tearDownClass") else ".".join(failed[2].split(".")[-2:])
        places = re.findall(r'File "([^"]+)", line (\d+)', chunk)
        ours = [place for place in places if place[0].startswith(str(ROOT))]
        failures.append(Failure(failed[2], f"{command} -k '*.{wanted}'",
                                relative(":".join(ours[0])) if ours else "", relative(last_lines(chunk))))
    return failures


def commands(preset):
    """Command lines by test, as one would type them."""
    listed = subprocess.run(["ctest", "--preset", preset, "--show-only=json-v1"], cwd=ROOT, capture_output=True, text=True)
    tests = json.loads(listed.stdout)["tests"] if listed.returncode == 0 else []
    quiet = ("--gtest_brief=1", "-v")
    return {test["name"]: [relative(word) for word in test.get("command", []) if word not in quiet] for test in tests}


def of_ctest(preset, report, log="", environment=""):
    """Each failed test in ctest's report (JUnit's format), by the names that the test programs themselves have for them. The
    log says how it ended; the environment is that of the step."""
    try:
        cases = xml.etree.ElementTree.parse(report).getroot().iter("testcase")
    except (OSError, xml.etree.ElementTree.ParseError):
        return []
    # Reads how each ended, such as Failed, Timeout, Exception: SegFault, Not Run.
    ends = dict(re.findall(r"^ *\d+/\d+ Test +#\d+: (\S+) \.*\*\*\*(.+?) +[\d.]+ sec", log, re.MULTILINE))
    failed = [case for case in cases if case.get("status") == "fail" or ends.get(case.get("name")) == "Not Run"]
    lines = commands(preset) if failed else {}
    before = environment + " " if environment else ""
    found = []
    for case in failed:
        name = case.get("name")
        output = case.findtext("system-out") or ""
        command = lines.get(name, [])
        if "-k" in command:
            command = command[:command.index("-k")] + command[command.index("-k") + 2:]
        inner = of_unittest(before + shlex.join(command), output) or of_gtest(before + (command[0] if command else name), output)
        found += inner
        # A program that crashed or was ended after a failed test has more to say than that test.
        whole = "\nRan " in output or re.search(r"^\[=+\] .* ran\.", output, re.MULTILINE)
        if not (inner and whole):
            found.append(Failure(f"{name} ({ends.get(name, 'failed').lower()})",
                                 f"{before}ctest --preset {preset} -R '^{re.escape(name)}$'", "", relative(last_lines(output))))
    return found


def of_compiler(step, log):
    """Each file that the compiler refused, or clang-format."""
    failures = {}
    for place, message in re.findall(r"^(\S+\.(?:cc|h|ts):\d+(?::\d+)?): (?:fatal )?error: (.*)$", log, re.MULTILINE):
        where = relative(place)
        file = where.split(":")[0]
        if "-Wclang-format-violations" in message:
            failures.setdefault(file, Failure(f"formatting of {file}", f"clang-format -i {file}", where))
        else:
            failures.setdefault(file, Failure(f"compiling {file}", f"deploy/test {step}", where, message))
    return list(failures.values())


def of_browser(log):
    """Each failed step of the browser tests; those that were not run after it are left out."""
    failures = []
    for failed in re.finditer(r"^\[\d+/\d+\] FAILED +(.*?) \([\d.]+ s\)\n((?:(?!\[\d+/).*\n)*)", log, re.MULTILINE):
        again = re.search(r"^  again: +(.*)$", failed[2], re.MULTILINE)
        place = re.search(r"\(?file://(\S+?:\d+)(?::\d+)?\)?", failed[2])
        failures.append(Failure(failed[1], relative(again[1]) if again else "tests/e2e/run build/release/bin/kerfd",
                                relative(place[1]) if place else "", relative(last_lines(failed[2]))))
    return failures


def of_vitest(log):
    """Each failed test of the viewer's units."""
    plain = re.sub(r"\x1b\[[0-9;]*m", "", log)
    failures = {}
    for path, name in re.findall(r"^ FAIL +(\S+\.test\.ts) (?:> (.*)|\[.*)$", plain, re.MULTILINE):
        pattern = re.sub(r"([\\^$.|?*+()\[\]{}])", r"\\\1", name.replace(" > ", " "))
        alone = f"npx vitest run {path}" + (f" -t {shlex.quote(pattern)}" if name else "")
        failures[path, name] = Failure(name or f"{path} cannot be loaded", f"(cd web && {alone})", f"web/{path}")
    return list(failures.values())


def of_step(step, log_file, report):
    """Finds what failed in a step; its last lines where nothing more exact can be read from them."""
    whole = Failure(f"step {step.name}", f"deploy/test {step.name}")
    try:
        log = log_file.read_text(errors="replace")
        found = of_ctest(step.preset, report, log, step.environment) if step.preset else []
        found = found or of_browser(log) or of_vitest(log) or of_compiler(step.name, log)
    except (OSError, ValueError, LookupError, TypeError) as error:  # A log cut short must not end the steps after it.
        return [dataclasses.replace(whole, excerpt=f"its output could not be read: {error}")]
    return found or [dataclasses.replace(whole, excerpt=relative(last_lines(log)))]
