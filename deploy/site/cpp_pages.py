"""Writes the pages of the C++ libraries: every header that is installed, with its comments, a page a library."""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
INSTALLED = ROOT / "server/cmake/kerf_install.cmake"
TITLES = {"core": "Simulation library", "client": "Client library"}


def headers():
    """Returns the installed headers of each library that has a front door: paths from the root, the front door first."""
    found = {}
    for part, arguments in re.findall(r"^ *kerf_install_part\((\w+)([^()]*)\)", INSTALLED.read_text(encoding="utf-8"), re.MULTILINE):
        door = re.search(r"\bDOOR (\S+)", arguments)
        if door:
            doors = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / door[1] / "kerf").glob("*.h"))
            found[part] = list(dict.fromkeys(doors + re.findall(r"\S+\.h\b", arguments)))
    return found


def as_included(header):
    """Returns how a program includes a header: the front door is installed below kerf/."""
    return re.sub(r".*/(kerf/[^/]+)$", r"\1", header)


def title_and_line(title, line):
    return f"{title}\n{line * len(title)}\n\n"


def references():
    """Returns the text of each page by its path."""
    texts, pages = {}, ""
    for part, files in headers().items():
        text = title_and_line(TITLES.get(part, part), "=")
        text += f"``find_package(kerf COMPONENTS {part})``; link ``kerf::{part}``, and include ``<{as_included(files[0])}>``, which includes the others.\n\n"
        for header in files:
            code = (ROOT / header).read_text(encoding="utf-8").strip().removeprefix("#pragma once").strip("\n")
            lines = "\n".join(f"   {line}".rstrip() for line in code.split("\n"))
            text += f"{title_and_line(as_included(header), '-')}.. code-block:: cpp\n\n{lines}\n\n"
        texts[f"reference/cpp/{part}.rst"] = text
        pages += f"   {part}\n"
    texts["reference/cpp/index.rst"] = (
        f"{title_and_line('C++ headers', '=')}The headers that ``cmake --install`` installs, with their comments. "
        f":doc:`/client/cpp/README` introduces the libraries.\n\n.. toctree::\n   :maxdepth: 2\n\n{pages}")
    return texts
