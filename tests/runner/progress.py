"""Reads from the output of a step's commands how far it is, and says how long the rest will take."""

import json
import re
import time

# ninja, the browser tests and each_file.py; ctest.
COUNTS = re.compile(r"^(?:\[(\d+)/(\d+)\]|\s*(\d+)/(\d+) Test )")


def count_in(line):
    """(done, all) where a line tells it, or nothing."""
    found = COUNTS.match(line)
    if not found:
        return None
    done, total = (int(number) for number in found.groups() if number is not None)
    return (done, total) if total > 0 else None


def in_words(seconds):
    """Minutes and seconds, as 4:05."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


class Memory:
    """Seconds that each step took when it last passed in this checkout, in a file."""

    def __init__(self, path):
        self.path = path
        try:
            self.seconds = {name: float(seconds) for name, seconds in json.loads(path.read_text()).items()}
        except (OSError, ValueError, AttributeError, TypeError):
            self.seconds = {}  # a guess is good enough

    def expected(self, step):
        return self.seconds.get(step.name, step.seconds)

    def note(self, step, seconds):
        self.seconds[step.name] = round(seconds, 1)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.seconds, indent=1))


class StepProgress:
    """One step as it runs."""

    def __init__(self, expected, clock=time.monotonic):
        self.expected = expected
        self.clock = clock
        self.started = clock()
        self.counted = None
        self.counted_from = self.started

    def line(self, text):
        """Takes a line of the step's output."""
        counted = count_in(text)
        if counted and (self.counted is None or counted[1] != self.counted[1]):
            self.counted_from = self.clock()  # another command counts from here
        self.counted = counted or self.counted

    def elapsed(self):
        return self.clock() - self.started

    def left(self):
        """Seconds that the step will still take: as it took the last time, or by what is done once that is past."""
        rest = self.expected - self.elapsed()
        done, total = self.counted or (0, 0)
        # A count that has just begun says little, and one that is full is that of a command before the one that runs.
        if done == total or self.clock() - self.counted_from < 5.0:
            return max(rest, 0.0)
        by_count = (self.clock() - self.counted_from) * (total - done) / max(done, 1)
        # The count is an upper bound when it starts slowly; a warm build is soon far ahead of what was expected.
        return max(min(rest, by_count) if rest > 0 else by_count, 0.0)
