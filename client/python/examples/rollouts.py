"""Tries several cuts from one saved state of a hanging sheet, and compares how far each lets it be pulled down.

The sheet is saved once. Before each trial it goes back to that state, so that the trials differ by their cut alone. The
best one is repeated at the end and gives the same bits.
"""

from __future__ import annotations

import argparse
from typing import List, Tuple

import kerf
from progress import Progress

_SLIT_M = 0.6  # length of each slit, across the middle of a sheet of 1 m x 1 m
_PULL_N_PER_M = 40.0


def rollout(sheet: kerf.Sheet, height_m: float, ticks: int) -> Tuple[float, str]:
    """Goes back to the saved state, cuts a slit at this height, 0..1, and pulls. Returns the lowest z, m, and the state
    hash."""
    sheet.restore_state("start")
    sheet.cut(kerf.polyline((0.5 - _SLIT_M / 2, height_m), (0.5 + _SLIT_M / 2, height_m)))
    with sheet.holding((0.5, 0.02), (0.5, 0.0, -0.5), stiffness_npm=_PULL_N_PER_M):
        sheet.step(ticks)
    # Reads the state once the hand has let go: its name, which the hash includes, is new each time.
    state = sheet.state()
    return float(state.positions[:, 2].min()), state.state_hash


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50051", help="HOST:PORT (default: %(default)s)")
    parser.add_argument("--trials", type=int, default=10, help="how many slits (default: %(default)s)")
    parser.add_argument("--ticks", type=int, default=60, help="of each trial (default: %(default)s)")
    options = parser.parse_args()
    if options.trials < 1 or options.ticks < 1:
        parser.error("--trials and --ticks are at least 1")

    heights = [(i + 0.5) / options.trials for i in range(options.trials)]
    outcomes: List[Tuple[float, float, str]] = []
    progress = Progress(options.trials, "trials")
    with kerf.connect(options.server) as server:
        with server.temporary_sheet(grid=(25, 25), pins=["top"], paused=True) as sheet:
            sheet.step(30)
            saved = sheet.save_state("start")
            for height in heights:
                lowest, state_hash = rollout(sheet, height, options.ticks)
                outcomes.append((lowest, height, state_hash))
                progress.advance(f"slit at {height:.2f} m")
            again = rollout(sheet, min(outcomes)[1], options.ticks)

    print(f"{len(outcomes)} trials from tick {saved.tick}, state {saved.state_hash}")
    for lowest, height, state_hash in outcomes:
        print(f"slit at {height:.2f} m: lowest point {lowest:.4f} m, state {state_hash}")
    best = min(outcomes)
    print(f"the slit at {best[1]:.2f} m gives most; again: {'the same bits' if again[1] == best[2] else 'OTHER BITS'}")


if __name__ == "__main__":
    main()
