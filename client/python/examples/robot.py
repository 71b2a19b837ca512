"""A robot that cuts a sheet at random while it moves: every kind of cut, undo, hands that pull, gusts of wind.

The same seed makes the same cuts at the same ticks, and so the same sheet, bit for bit. The state hash printed at
the end shows it.
"""

from __future__ import annotations

import argparse
import collections
import pathlib
import random
import secrets
from typing import Counter, Optional

import kerf
from progress import Progress
from random_cuts import random_cut


class Robot:
    """Acts on a paused sheet of 1 m x 1 m, one action after another, and counts the outcomes."""

    def __init__(self, sheet: kerf.Sheet, seed: int) -> None:
        self._sheet = sheet
        self._chance = random.Random(seed)
        self.counts: Counter[str] = collections.Counter()

    def cut(self) -> str:
        """Cuts once, and lets some ticks pass; returns the outcome."""
        kind, cut = random_cut(self._chance)
        try:
            result = self._sheet.cut(cut)
            outcome = f"{kind} cut" if result.status == kerf.APPLIED else "missed"
        except kerf.Error as refusal:
            # Refused cuts are part of the experiment.
            outcome = f"refused, {refusal.reason}"
        self.counts[outcome] += 1
        self._disturb()
        self._sheet.step(self._chance.randint(1, 4))
        return outcome

    def _disturb(self) -> None:
        what = self._chance.random()
        if what < 0.1:
            self._sheet.set_wind(kerf.wind((0, self._chance.uniform(-4, 4), 0)))
            self.counts["gust of wind"] += 1
        elif what < 0.2:
            self._pull()
        elif what < 0.25 and self._sheet.cuts():
            self._sheet.undo()
            self.counts["undone"] += 1

    def _pull(self) -> None:
        state = self._sheet.state()
        vertex = int(self._chance.choice(state.triangles.ravel()))
        x, y, z = state.positions[vertex].tolist()
        with self._sheet.holding(vertex, (x, y + self._chance.uniform(-0.1, 0.1), z)):
            self._sheet.step(4)
        self.counts["pulled"] += 1


def report(sheet: kerf.Sheet, robot: Robot, seed: int, picture: Optional[pathlib.Path]) -> None:
    for outcome, count in sorted(robot.counts.items()):
        print(f"{count:6d}  {outcome}")
    areas = [piece.area_m2 for piece in sheet.pieces()]
    print(f"{len(areas)} pieces; the largest has {max(areas):.4f} m^2 of {sum(areas):.4f} m^2")
    now = sheet.get()
    print(f"tick {now.tick}, {now.num_triangles} triangles, state {now.state_hash}; again with --seed {seed}")
    if picture is not None:
        picture.write_bytes(sheet.render((720, 720), color_by="pieces"))
        print(picture)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50051", help="HOST:PORT (default: %(default)s)")
    parser.add_argument("--cuts", type=int, default=100, help="how many (default: %(default)s)")
    parser.add_argument("--seed", type=int, help="of an earlier run (default: another each time)")
    parser.add_argument("--vertices", type=int, default=400, help="of the sheet at first, 16..100000 (default: %(default)s)")
    parser.add_argument("--picture", type=pathlib.Path, help="a PNG file of how it ends")
    options = parser.parse_args()
    if options.cuts < 1 or not 16 <= options.vertices <= 100000:
        parser.error("--cuts is at least 1 and --vertices 16..100000")
    seed = secrets.randbelow(10**6) if options.seed is None else options.seed
    print(f"seed {seed}")

    side = round(options.vertices**0.5)
    # Implicit, because slivers between cuts that nearly meet would need thousands of explicit substeps per tick.
    scene = {
        "grid": {"columns": side, "rows": side, "width_m": 1, "height_m": 1},
        "pins": [{"edge": "TOP_CORNERS"}],
        "integrator": {"kind": "IMPLICIT_EULER"},
    }
    progress = Progress(options.cuts, "cuts")
    with kerf.connect(options.server) as server:
        with server.temporary_sheet(scene, paused=True) as sheet:
            robot = Robot(sheet, seed)
            for _ in range(options.cuts):
                progress.advance(robot.cut())
            report(sheet, robot, seed, options.picture)


if __name__ == "__main__":
    main()
