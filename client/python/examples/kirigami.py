"""Cuts a grid of slits into a sheet, pulls it open, and saves pictures of it on the way.

The sheet is as thin as paper and as soft as rubber: the folds of a pulled sheet depend on its thickness, not its
stiffness, and a soft sheet takes fewer steps.
"""

from __future__ import annotations

import argparse
import pathlib
from typing import Any, Dict, List

import kerf
from kerf.v1 import geometry_pb2

_WIDTH_M = 0.3
_HEIGHT_M = 0.4
_MARGIN_M = 0.04  # strip without slits at the held edge and at the pulled edge
_SECONDS = 1.0  # duration of the pull


def slits(rows: int, columns: int) -> List[geometry_pb2.Curve]:
    """Returns rows of slits across the pull. Every other row is shifted by half a slit and its gap, so that its outer
    slits are open at the sides."""
    pitch = _WIDTH_M / columns
    length = 0.75 * pitch
    made = []
    for row in range(rows):
        y = _MARGIN_M + (_HEIGHT_M - 2 * _MARGIN_M) * (row + 0.5) / rows
        shift = 0.0 if row % 2 else -pitch / 2
        for column in range(columns + 1 - row % 2):
            middle = pitch * (column + 0.5) + shift
            made.append(kerf.polyline((middle - length / 2, y), (middle + length / 2, y)))
    return made


def scene(vertices: int, pull_m: float) -> Dict[str, Any]:
    """Returns the scene of a sheet in the plane y = 0 that is held at its top. Its bottom edge moves down by pull_m
    within _SECONDS."""
    columns = max(8, round((vertices * _WIDTH_M / _HEIGHT_M) ** 0.5))
    rows = round(columns * _HEIGHT_M / _WIDTH_M)
    way = {"times": [0, _SECONDS], "factors": [0, 1]}
    return {
        "grid": {"columns": columns, "rows": rows, "width_m": _WIDTH_M, "height_m": _HEIGHT_M},
        "material": {
            "youngs_modulus_pa": 1e6,
            "poissons_ratio": 0.4,
            "thickness_m": 2e-4,
            "density_kgpm3": 1000,
            "mass_damping_per_s": 5,
        },
        # Tiny, only to decide to which side the strips leave the plane.
        "gravity_mps2": {"y": 0.05},
        "constraints": [
            {"region": {"edge": "TOP"}},
            {"region": {"edge": "BOTTOM"}, "displacement_m": {"z": -pull_m}, "history": way},
        ],
    }


def save_picture(sheet: kerf.Sheet, file: pathlib.Path, pull_m: float, color_by: kerf.ColorBy = "sides") -> None:
    eye = (_WIDTH_M / 2 - 0.35, -1.0, _HEIGHT_M / 2 + 0.1)
    camera = kerf.camera(eye, (_WIDTH_M / 2, 0, (_HEIGHT_M - pull_m) / 2), vertical_fov_deg=32)
    file.write_bytes(sheet.render((720, 720), camera=camera, color_by=color_by))
    print(f"  {file}")


def pull_open(sheet: kerf.Sheet, pull_m: float, folder: pathlib.Path) -> None:
    ticks = round(_SECONDS * sheet.get().tick_rate_hz)
    for quarter in range(1, 5):
        sheet.step(ticks * quarter // 4 - ticks * (quarter - 1) // 4)
        save_picture(sheet, folder / f"pulled-{quarter}.png", pull_m)
    save_picture(sheet, folder / "strains.png", pull_m, "strains")
    with sheet.watch(strains=True) as frames:
        frame = next(frames)
    low, high = frame.positions.min(axis=0), frame.positions.max(axis=0)
    strain = 0.0 if frame.strains is None else float(frame.strains.max())
    print(f"height {high[2] - low[2]:.4f} m of {_HEIGHT_M} m, depth {high[1] - low[1]:.4f} m, largest strain {100 * strain:.2f} %")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50051", help="HOST:PORT (default: %(default)s)")
    parser.add_argument("--rows", type=int, default=12, help="of slits (default: %(default)s)")
    parser.add_argument("--columns", type=int, default=5, help="slits a row (default: %(default)s)")
    parser.add_argument("--pull", type=float, default=0.2, help="of its height, 0.01..0.5 (default: %(default)s)")
    parser.add_argument("--vertices", type=int, default=1200, help="before the cuts (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("kirigami"), help="folder (default: %(default)s)")
    options = parser.parse_args()
    if not (1 <= options.rows <= 100 and 1 <= options.columns <= 40 and 0.01 <= options.pull <= 0.5):
        parser.error("--rows is 1..100, --columns 1..40 and --pull 0.01..0.5")
    options.out.mkdir(parents=True, exist_ok=True)
    pull_m = options.pull * _HEIGHT_M

    with kerf.connect(options.server) as server:
        with server.temporary_sheet(scene(options.vertices, pull_m), paused=True) as sheet:
            done = sheet.cut_all(slits(options.rows, options.columns))
            print(f"{done.applied} slits, {sheet.get().num_triangles} triangles, pieces: {done.pieces}")
            flat = options.out / "slits.png"
            flat.write_bytes(sheet.render((720, 720), undeformed=True, wireframe=True))
            print(f"  {flat}")
            pull_open(sheet, pull_m, options.out)


if __name__ == "__main__":
    main()
