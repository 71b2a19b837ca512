#!/usr/bin/python3
"""Draws server/rings.svg, the rooms of server/ and who includes whom, from the #include lines of its sources.

Rooms are the folders below server/ in the table of server/README.md. A line leads from a room to one that it includes; lines that follow
from others are left out. A room stands above everything that it includes.

    tests/tooling/rings.py          # writes the picture; pages_test.py compares it
"""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
PICTURE = ROOT / "server/rings.svg"
PAGE = ROOT / "server/README.md"  # has the include table
RINGS = ("base", "core", "service", "app")  # from the innermost outwards
COLOURS = {"base": "#e9e4f5", "core": "#dcebf7", "service": "#e2f2e1", "app": "#fbeedd"}
# Places rooms from left to right, 0..1, so that few lines meet boxes. Others stand at the right border.
COLUMNS = {"base": 0.5, "linear": 0.6, "mesh": 0.24, "mesh/refine": 0.17, "mesh/build": 0.15, "cut": 0.43, "contact": 0.31,
           "fem/element": 0.68, "fem/model": 0.68, "fem/leapfrog": 0.78, "fem/statics": 0.58, "fem/step": 0.78, "scene": 0.45,
           "sheet": 0.45, "analysis": 0.38, "kerf": 0.2, "codec": 0.07, "svg": 0.27, "host": 0.72, "wire": 0.45, "offline": 0.2, "stream": 0.45, "picture": 0.52,
           "api": 0.52, "local": 0.22, "rpc": 0.38, "ws": 0.66, "app": 0.52}
WIDTH, ROW, BOX_HEIGHT, MARGIN = 720, 50, 26, 12
LETTER = 7.4  # of the labels, px


def rooms():
    """Returns the folders of server/ that the include table has, such as "core/mesh/refine"."""
    table = PAGE.read_text().split("\n## Who may include whom\n")[1].split("\n## ")[0]
    paths = [f"{ring}{name}" for name in re.findall(r"^\| ([\w/]+) \|", table, re.MULTILINE) for ring in ("", "core/", "service/")]
    return [path for path in paths if (ROOT / "server" / path).is_dir()]


def room_of(path, names):
    """Returns the room that a path below server/ lies in: the longest that fits, or None."""
    return max((name for name in names if path.startswith(name + "/")), key=len, default=None)


def includes(names):
    """Returns, for each room, the set of other rooms that its sources include."""
    found = {name: set() for name in names}
    for file in sorted((ROOT / "server").rglob("*")):
        if file.suffix not in (".h", ".cc", ".inc"):
            continue
        room = room_of(str(file.relative_to(ROOT / "server")), names)
        for path in re.findall(r'^\s*#\s*include "server/([^"]+)"', file.read_text(), re.MULTILINE):
            found[room].add(room_of(path, names))
    return {room: others - {room} for room, others in found.items()}


def reach(room, arrows):
    """Returns every room that `room` includes, directly or through others."""
    seen, waiting = set(), [room]
    while waiting:
        for other in arrows[waiting.pop()] - seen:
            seen.add(other)
            waiting.append(other)
    return seen


def without_what_follows(arrows):
    """Leaves out each arrow that a path of other arrows makes, too."""
    return {room: {to for to in others if not any(to in reach(via, arrows) for via in others - {to})}
            for room, others in arrows.items()}


def ring_of(room):
    return room.split("/")[0]


def rows_of(arrows):
    """Returns each room's row, counted from the bottom: above all that it includes, and above all rings within its own."""
    rows, first = {}, 0
    for ring in RINGS:
        inside = [room for room in arrows if ring_of(room) == ring]
        assert all(ring_of(to) in RINGS[:RINGS.index(ring) + 1] for room in inside for to in arrows[room]), "a ring looks outwards"
        while any(room not in rows for room in inside):
            ready = [room for room in inside if room not in rows and arrows[room] <= rows.keys()]
            assert ready, f"a circle of rooms in {ring}"
            for room in ready:
                rows[room] = max([first, *(rows[to] + 1 for to in arrows[room] if ring_of(to) == ring)])
        first = max(rows.values()) + 1
    return rows


def places(rows):
    """Returns the centre of each room, px."""
    top = max(rows.values())
    return {room: (WIDTH * COLUMNS.get(label_of(room), 0.9), ROW * (top - row) + ROW / 2 + MARGIN) for room, row in rows.items()}


def label_of(room):
    return room.split("/", 1)[-1]


def picture():
    arrows = includes(rooms())
    rows = rows_of(arrows)
    arrows = without_what_follows(arrows)
    centres = places(rows)
    height = ROW * (max(rows.values()) + 1) + 2 * MARGIN
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
             'font-family="sans-serif" font-size="13">',
             f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>']
    for ring in RINGS:
        levels = [rows[room] for room in rows if ring_of(room) == ring]
        top = ROW * (max(rows.values()) - max(levels)) + MARGIN + 2
        height_of_ring = ROW * (max(levels) - min(levels) + 1) - 4
        lines.append(f'<rect x="{MARGIN}" y="{top}" width="{WIDTH - 2 * MARGIN}" height="{height_of_ring}" rx="8" fill="{COLOURS[ring]}"/>')
        if ring not in rows:
            lines.append(f'<text x="{WIDTH - MARGIN - 10}" y="{top + 22}" text-anchor="end" font-weight="bold" fill="#56606e">{ring}</text>')
    for room, others in sorted(arrows.items()):
        for to in sorted(others):
            (x1, y1), (x2, y2) = centres[room], centres[to]
            x2 = x1 if to == "base" else x2
            y1, y2 = y1 + BOX_HEIGHT / 2, y2 - BOX_HEIGHT / 2
            bend = (y2 - y1) / 2
            lines.append(f'<path d="M{x1:.0f} {y1:.0f}C{x1:.0f} {y1 + bend:.0f} {x2:.0f} {y2 - bend:.0f} {x2:.0f} {y2:.0f}" fill="none" '
                         'stroke="#7b8794" stroke-width="1.2"/>')
    for room, (x, y) in sorted(centres.items()):
        width = WIDTH - 4 * MARGIN if room == "base" else max(60, LETTER * len(label_of(room)) + 20)
        lines += [f'<rect x="{x - width / 2:.0f}" y="{y - BOX_HEIGHT / 2:.0f}" width="{width:.0f}" height="{BOX_HEIGHT}" rx="5" '
                  'fill="#ffffff" stroke="#3c4858"/>',
                  f'<text x="{x:.0f}" y="{y + 5:.0f}" text-anchor="middle" fill="#1c2430">{label_of(room)}</text>']
    return "\n".join([*lines, "</svg>", ""])


if __name__ == "__main__":
    PICTURE.write_text(picture())
