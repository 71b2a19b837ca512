#!/usr/bin/python3
"""Checks the front doors: the headers that are installed are those that <kerf/kerf.h> and <kerf/client.h> include, and few."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_HEADERS = 15  # of each library, the front door among them
DOORS = {"core": "server/core/kerf/kerf.h", "client": "client/cpp/kerf/client.h"}
OUTSIDE = {"core": ("Eigen/",), "client": ("google/protobuf/", "grpcpp/", "kerf/v1/")}  # besides the standard library


def includes(path):
    return re.findall(r'^#include ([<"][^>"]+)[>"]', (ROOT / path).read_text(), re.MULTILINE)


def reached(path):
    """Returns the headers of this repository that `path` includes, at any depth, and itself."""
    found, todo = set(), [path]
    while todo:
        header = todo.pop()
        if header not in found:
            found.add(header)
            todo.extend(name[1:] for name in includes(header) if (ROOT / name[1:]).is_file())
    return found


def installed(part):
    text = (ROOT / "server/cmake/kerf_install.cmake").read_text()
    call = re.search(rf"kerf_install_part\({part} .*?\)", text, re.DOTALL).group(0)
    return set(re.findall(r"\S+\.h\b", call))


class PublicHeaders(unittest.TestCase):
    def test_what_is_installed_is_what_the_front_doors_include(self):
        for part, door in DOORS.items():
            self.assertEqual(installed(part) | {door}, reached(door), part)

    def test_they_are_few(self):
        for part, door in DOORS.items():
            self.assertLessEqual(len(reached(door)), MOST_HEADERS, part)

    def test_nothing_else_is_needed_than_the_documentation_says(self):
        for part, door in DOORS.items():
            for header in sorted(reached(door)):
                for name in includes(header):
                    if (ROOT / name[1:]).is_file():
                        continue
                    is_standard = name.startswith("<") and "/" not in name and not name.endswith(".h")
                    self.assertTrue(is_standard or name[1:].startswith(OUTSIDE[part]), f"{header} includes {name[1:]}")


if __name__ == "__main__":
    unittest.main()
