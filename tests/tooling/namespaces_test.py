#!/usr/bin/env python3
"""A namespace is named for the folder of its files: `kerf::linear` for server/core/linear, `kerf::fem` for all below
server/core/fem.

Forward declarations may open any namespace. The program alone is run from anywhere: `namespaces_test.py -v`."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Folders whose namespace has another name.
NAMED = {"server/base": "kerf", "client/cpp": "kerf::client"}
OPENED = re.compile(r"^namespace ([\w:]+) \{(.*?)^\}", re.M | re.S)
COMMENT = re.compile(r"//[^\n]*")
FORWARD = re.compile(r"\b(?:template <[^<>]*>\s*)?(?:class|struct|enum class) \w+(?: : [\w:]+)?;")


def namespace_of(file):
    """Returns the namespace of a source, given by its path from the root."""
    folder = pathlib.PurePosixPath(file).parent
    for parent in [folder, *folder.parents]:
        if str(parent) in NAMED:
            return NAMED[str(parent)]
    parts = folder.parts
    if parts[0] == "render":
        return "kerf::render"
    rings = ("core", "service")
    return "kerf::" + (parts[2] if parts[0] == "server" and parts[1] in rings else parts[1])


def faults(file, source):
    """Returns the namespaces of Kerf that a source defines something in, though its folder has another one."""
    return [f"{file}: opens {name}, its folder is {namespace_of(file)}"
            for name, body in OPENED.findall(COMMENT.sub("", source))
            if name.split("::")[0] == "kerf" and name != namespace_of(file) and FORWARD.sub("", body).strip()]


class Namespaces(unittest.TestCase):
    maxDiff = None

    def test_every_file_opens_the_namespace_of_its_folder(self):
        found, num_files = [], 0
        for top in ("server", "render", "client"):
            for path in sorted((ROOT / top).rglob("*")):
                if path.suffix in (".h", ".cc"):
                    found += faults(path.relative_to(ROOT).as_posix(), path.read_text())
                    num_files += 1
        self.assertEqual(found, [])
        self.assertGreater(num_files, 500)

    def test_it_finds_a_namespace_of_another_folder(self):
        own = "namespace kerf::linear {\nint x;\n}  // namespace kerf::linear\n"
        declared = "namespace kerf::linear {\nclass RowStore;  // of rows\nenum class Kind : int;\n}\n"
        self.assertEqual(faults("server/core/linear/x.h", own), [])
        self.assertEqual(len(faults("server/core/fem/model/x.h", own)), 1)
        self.assertEqual(faults("server/core/fem/model/x.h", declared), [])
        self.assertEqual(len(faults("server/base/x.h", own)), 1)

    def test_it_knows_the_namespace_of_a_folder(self):
        for file, wanted in [("server/base/x.h", "kerf"), ("server/app/x.cc", "kerf::app"),
                             ("server/core/mesh/build/x.h", "kerf::mesh"), ("server/service/ws/x.h", "kerf::ws"),
                             ("client/cli/x.h", "kerf::cli"), ("client/cpp/kerf/x.h", "kerf::client"),
                             ("render/x.h", "kerf::render")]:
            self.assertEqual(namespace_of(file), wanted)


if __name__ == "__main__":
    unittest.main()
