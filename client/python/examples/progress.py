"""A progress bar on the terminal; it shows nothing if the output is no terminal."""

from __future__ import annotations

import sys
import time

_WIDTH = 30


class Progress:
    """Shows how much of `total` is done, and an estimate of the time left."""

    def __init__(self, total: int, what: str, done: int = 0) -> None:
        self._total = total
        self._what = what
        self._already = done
        self._done = done
        self._began = time.monotonic()

    def advance(self, note: str = "") -> None:
        self._done += 1
        if not sys.stderr.isatty():
            return
        filled = _WIDTH * self._done // self._total
        left_s = (time.monotonic() - self._began) / (self._done - self._already) * (self._total - self._done)
        bar = "#" * filled + "." * (_WIDTH - filled)
        sys.stderr.write(f"\r[{bar}] {self._done}/{self._total} {self._what}, {left_s:.0f} s left {note:<24.24}")
        if self._done == self._total:
            sys.stderr.write("\n")
        sys.stderr.flush()
