"""Makes a data set of pictures of cut sheets, for training: what is seen, which piece each pixel belongs to, what was cut.

  FOLDER/images/000000.png   what a camera sees
  FOLDER/masks/000000.png    the same size, grey: 0 no sheet, 1, 2, ... the pieces, as the label's `pieces` number them
  FOLDER/labels/000000.json  cuts (kind and curve), pieces (id, area, box in pixels), camera, seed, state hash
  FOLDER/train.txt, val.txt  the names, four fifths and one fifth
  FOLDER/dataset.json        how it was made

Each sample depends only on --seed and its number. The same command continues an interrupted run, and with a larger
--samples adds to the data set.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import random
from typing import Any, Dict, List, Tuple

import kerf
import numpy
from google.protobuf import json_format
from PIL import Image

from masks import piece_mask
from progress import Progress
from random_cuts import KINDS, random_cut

_FOV_DEG = 40.0
_TARGET = (0.5, 0.0, 0.45)
_TRIES = 50  # most attempts per cut wanted
_MATERIALS = ("demo", "denim", "skin", "rubber")


def make_sample(server: kerf.Server, chance: random.Random, how: Dict[str, Any]) -> Tuple[bytes, Any, Dict[str, Any]]:
    """Returns picture, mask and label of a sheet that was cut at random and has moved a little afterwards."""
    grid, size_px = (how["grid"], how["grid"]), (how["size_px"], how["size_px"])
    material = chance.choice(_MATERIALS)
    eye = (0.5 + chance.uniform(-0.5, 0.5), -1.9, 0.5 + chance.uniform(-0.3, 0.3))
    with server.temporary_sheet(grid=grid, pins=["top"], material=material, paused=True) as sheet:
        cuts = _cut_at_random(sheet, chance, chance.randint(1, how["max_cuts"]))
        # The wind blows along the view: pieces that fell in the plane of the sheet would have no clear front and back.
        sheet.set_wind(kerf.wind((0, chance.choice((-1, 1)) * chance.uniform(3, 6), 0)))
        sheet.step(chance.randint(5, 14))
        picture = sheet.render(size_px, camera=kerf.camera(eye, _TARGET, vertical_fov_deg=_FOV_DEG))
        state = sheet.state()
        pieces = sheet.pieces()
    mask = piece_mask(state, eye, _TARGET, _FOV_DEG, size_px)
    label = {
        "material": material,
        "cuts": cuts,
        "pieces": [_piece_label(piece, 1 + place, mask) for place, piece in enumerate(pieces)],
        "camera": {"eye": eye, "target": _TARGET, "vertical_fov_deg": _FOV_DEG},
        "tick": state.tick,
        "state_hash": state.state_hash,
    }
    return picture, mask, label


def _cut_at_random(sheet: kerf.Sheet, chance: random.Random, wanted: int) -> List[Dict[str, Any]]:
    """Makes random cuts until `wanted` were applied; returns their labels."""
    cuts: List[Dict[str, Any]] = []
    for _ in range(_TRIES * wanted):
        kind, cut = random_cut(chance)
        try:
            if sheet.cut(cut).status != kerf.APPLIED:
                continue
        except (kerf.InvalidArgument, kerf.FailedPrecondition, kerf.ResourceExhausted):
            continue  # the cut is refused: another is drawn
        curve = json_format.MessageToDict(cut.curve, preserving_proto_field_name=True)
        cuts.append({"kind": kind, "curve": curve, "width_m": cut.width_m})
        if len(cuts) == wanted:
            return cuts
    raise SystemExit(f"{len(cuts)} of {wanted} cuts after {_TRIES * wanted} tries: take fewer --max-cuts or a larger --grid")


def _piece_label(piece: Any, number: int, mask: Any) -> Dict[str, Any]:
    """Returns the label of a piece. box_px: left, top, right, bottom of its visible part, the last two excluded; None
    if no part is visible."""
    rows, columns = numpy.nonzero(mask == number)
    box = [int(each) for each in (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)] if len(rows) else None
    return {"mask": number, "id": piece.id, "area_m2": piece.area_m2, "box_px": box, "pixels": len(rows)}


def write_sample(folder: pathlib.Path, name: str, picture: bytes, mask: Any, label: Dict[str, Any]) -> None:
    """Writes a sample, its label last and whole or not at all: if the label exists, the sample is complete."""
    (folder / "images" / f"{name}.png").write_bytes(picture)
    Image.fromarray(mask).save(folder / "masks" / f"{name}.png")
    part = folder / "labels" / f"{name}.json.part"
    part.write_text(json.dumps(label, indent=1) + "\n", encoding="utf-8")
    part.rename(part.with_suffix(""))


def open_folder(folder: pathlib.Path, how: Dict[str, Any]) -> None:
    """Makes the folders, or checks that existing ones were made in the same way."""
    about = folder / "dataset.json"
    if about.exists():
        before = json.loads(about.read_text(encoding="utf-8"))
        for name, value in how.items():
            if before.get(name) != value:
                raise SystemExit(f"{folder} was made with {name} {before.get(name)}, not {value}: take another --out")
    for each in ("images", "masks", "labels"):
        (folder / each).mkdir(parents=True, exist_ok=True)
    about.write_text(json.dumps(how, indent=1) + "\n", encoding="utf-8")


def write_lists(folder: pathlib.Path, names: List[str]) -> None:
    for file, wanted in (("train.txt", False), ("val.txt", True)):
        listed = [name for name in names if (int(name) % 5 == 4) == wanted]
        (folder / file).write_text("".join(f"{name}\n" for name in listed), encoding="utf-8")
        print(f"  {folder / file}: {len(listed)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50051", help="HOST:PORT (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("dataset"), help="folder (default: %(default)s)")
    parser.add_argument("--samples", type=int, default=100, help="in all (default: %(default)s)")
    parser.add_argument("--size", type=int, default=256, help="pixels a side, 16..1024 (default: %(default)s)")
    parser.add_argument("--grid", type=int, default=30, help="vertices a side, 8..200 (default: %(default)s)")
    parser.add_argument("--max-cuts", type=int, default=4, help="a sample, 1..20 (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="(default: %(default)s)")
    options = parser.parse_args()
    if not (options.samples >= 1 and 16 <= options.size <= 1024 and 8 <= options.grid <= 200 and 1 <= options.max_cuts <= 20):
        parser.error("a number is out of range: see --help")
    how = {"format": 1, "seed": options.seed, "size_px": options.size, "grid": options.grid}
    how |= {"max_cuts": options.max_cuts, "kinds": list(KINDS)}

    names = [f"{number:06d}" for number in range(options.samples)]
    with kerf.connect(options.server) as server:
        server.info()  # fails before anything is written if no server answers
        open_folder(options.out, how)
        missing = [name for name in names if not (options.out / "labels" / f"{name}.json").exists()]
        print(f"{len(names) - len(missing)} of {len(names)} samples are there")
        progress = Progress(len(names), "samples", len(names) - len(missing))
        for name in missing:
            seed = f"{options.seed}/{name}"
            picture, mask, label = make_sample(server, random.Random(seed), how)
            write_sample(options.out, name, picture, mask, {"seed": seed, **label})
            progress.advance()
    write_lists(options.out, names)


if __name__ == "__main__":
    main()
