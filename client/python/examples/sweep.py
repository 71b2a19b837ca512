"""Opens slits of several lengths in a strip under tension, and plots how far they open against fracture mechanics.

A strip of width W pulled with a stress s is slit across its middle by 2 a. The slit's middle opens by 4 s a / E in an endless
sheet, and by V(2 a / W) times as much in the strip: H. Tada, P. C. Paris, G. R. Irwin, "The Stress Analysis of Cracks Handbook",
3rd edition (2000), 2.1, to within 0.6 %: at 1/4 and 1/2 of the width it is 0.19 % and 0.24 % below finite elements that are good
to 0.06 % (tests/data/reference/05a, 05b). Strains are small and the strip stays in its plane.
"""

from __future__ import annotations

import argparse
import csv
import math
import pathlib
from typing import Any, Dict, List, Tuple

import kerf
from progress import Progress

_WIDTH_M = 0.2
_HEIGHT_M = 0.6
_YOUNGS_MODULUS_PA = 1e7
_THICKNESS_M = 1e-3
_STRESS_PA = 1e3


def tada(share: float) -> float:
    """Returns V of a slit whose length is this share of the strip's width, 0 < share < 1."""
    polynomial = -0.071 - 0.535 * share + 0.169 * share**2 - 0.090 * share**3 + 0.020 * share**4
    return polynomial - 1.071 / share * math.log(1 - share)


def expected_m(share: float) -> float:
    return 4 * _STRESS_PA * (share * _WIDTH_M / 2) / _YOUNGS_MODULUS_PA * tada(share)


def scene(columns: int) -> Dict[str, Any]:
    force_n = _STRESS_PA * _WIDTH_M * _THICKNESS_M
    return {
        "grid": {"columns": columns, "rows": 3 * columns - 2, "width_m": _WIDTH_M, "height_m": _HEIGHT_M},
        "material": {
            "youngs_modulus_pa": _YOUNGS_MODULUS_PA,
            "poissons_ratio": 0.3,
            "thickness_m": _THICKNESS_M,
            "density_kgpm3": 1000,
        },
        "gravity_mps2": {},
        "planar": True,
        "constraints": [
            {"region": {"edge": "BOTTOM"}, "z": True},
            {"region": {"nearest": {"x": _WIDTH_M / 2, "y": 0}}},
        ],
        "loads": [{"edge": {"region": {"edge": "TOP"}, "force_n": {"z": force_n}}}],
    }


def opening_m(sheet: kerf.Sheet, share: float, edge_m: float) -> float:
    """Returns the opening at rest, in its middle, of a slit whose length is this share of the width. edge_m: length of
    edges away from the slit."""
    sheet.reset()
    middle, half = _WIDTH_M / 2, share * _WIDTH_M / 2
    slit = kerf.polyline((middle - half, _HEIGHT_M / 2), (middle + half, _HEIGHT_M / 2))
    sheet.cut(slit, tip_edge_length_m=edge_m / 50, tip_grading=1.1)
    probe = {"name": "slit", "quantity": "OPENING", "points": [{"x": middle, "y": _HEIGHT_M / 2}]}
    found = sheet.analyze(request={"analysis": {"static": {}}, "probes": [probe]})
    if found.static is None or not found.static.converged:
        raise SystemExit(f"no equilibrium of a slit of {share:g} of the width: {found.static}")
    return float(found.tables["probes"]["slit.normal"][-1])


def plot(rows: List[Tuple[float, float, float]], file: pathlib.Path) -> None:
    try:
        import matplotlib
    except ImportError:
        print("no plot without matplotlib: apt install python3-matplotlib")
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(
        2, 1, sharex=True, figsize=(7, 6), gridspec_kw={"height_ratios": [3, 1]}, layout="constrained"
    )
    shares = [row[0] for row in rows]
    fine = [shares[0] + (shares[-1] - shares[0]) * i / 200 for i in range(201)]
    above.plot(fine, [1e6 * expected_m(share) for share in fine], "k-", label="Tada, Paris, Irwin")
    above.plot(shares, [1e6 * row[1] for row in rows], "o", color="tab:red", label="Kerf")
    above.set_ylabel("opening in the middle, micrometres")
    above.set_title(f"A slit across a strip under {_STRESS_PA:g} Pa")
    above.legend()
    below.axhspan(-0.6, 0.6, color="0.85", label="what the formula promises")
    below.plot(shares, [100 * (row[1] / row[2] - 1) for row in rows], "o", color="tab:red")
    below.set_ylabel("difference, %")
    below.set_xlabel("length of the slit over the width")
    below.legend()
    figure.savefig(file, dpi=110)
    print(f"  {file}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50051", help="HOST:PORT (default: %(default)s)")
    parser.add_argument("--lengths", type=int, default=9, help="of slits, 2..100 (default: %(default)s)")
    parser.add_argument("--columns", type=int, default=31, help="of vertices across, 9..101 (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("sweep"), help="folder (default: %(default)s)")
    options = parser.parse_args()
    if not (2 <= options.lengths <= 100 and 9 <= options.columns <= 101):
        parser.error("--lengths is 2..100 and --columns 9..101")
    options.out.mkdir(parents=True, exist_ok=True)

    rows = []
    progress = Progress(options.lengths, "slits")
    with kerf.connect(options.server) as server:
        with server.temporary_sheet(scene(options.columns), paused=True) as sheet:
            for number in range(options.lengths):
                share = 0.1 + 0.6 * number / (options.lengths - 1)
                rows.append((share, opening_m(sheet, share, _WIDTH_M / (options.columns - 1)), expected_m(share)))
                progress.advance()
    print("length/width  opening, um  expected, um  difference")
    for share, found, expected in rows:
        print(f"{share:12.3f} {1e6 * found:12.4f} {1e6 * expected:13.4f} {100 * (found / expected - 1):10.2f} %")
    with open(options.out / "sweep.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("length_over_width", "opening_m", "expected_m"), *rows])
    print(f"  {options.out / 'sweep.csv'}")
    plot(rows, options.out / "sweep.png")


if __name__ == "__main__":
    main()
