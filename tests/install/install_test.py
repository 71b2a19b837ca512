"""Kerf installed, and used by a project outside of it: client/examples, configured with find_package(kerf) against the installed
tree, compiled, and its example that needs no server run."""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

OPTIONS = None


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=540, **options)


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(OPTIONS.work, ignore_errors=True)
        cls.prefix = os.path.join(OPTIONS.work, "installed")
        done = run("cmake", "--install", OPTIONS.build, "--prefix", cls.prefix, "--component", "devel")
        assert done.returncode == 0, done.stderr

    def configure(self, source, name):
        folder = os.path.join(OPTIONS.work, name)
        return folder, run("cmake", "-S", source, "-B", folder, "-G", "Ninja", "-DCMAKE_PREFIX_PATH=" + self.prefix,
                           "-DCMAKE_BUILD_TYPE=Release")

    def test_the_examples_build_outside_and_run(self):
        source = os.path.join(OPTIONS.work, "examples")
        shutil.copytree(OPTIONS.examples, source)  # nothing of the repository is near
        folder, done = self.configure(source, "build")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        done = run("cmake", "--build", folder)
        self.assertEqual(done.returncode, 0, done.stdout)
        file = os.path.join(OPTIONS.work, "cloth.obj")
        done = run(os.path.join(folder, "embed_core"), file)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("cut into 2 pieces", done.stdout)
        self.assertEqual(done.stdout, run(OPTIONS.embed_core).stdout)  # the same bits as the one built in the tree
        lines = pathlib.Path(file).read_text().splitlines()
        self.assertGreater(sum(line.startswith("v ") for line in lines), 1600)
        self.assertGreater(sum(line.startswith("f ") for line in lines), 3042)

    def test_headers_do_without_the_source_tree(self):
        for header in pathlib.Path(self.prefix, "include/kerf").rglob("*.h"):
            self.assertNotIn(OPTIONS.source, header.read_text(errors="replace"), header)
        for file in pathlib.Path(self.prefix).rglob("*.cmake"):
            self.assertNotIn(OPTIONS.source, file.read_text(), file)

    def test_a_component_that_there_is_not_is_refused_by_name(self):
        source = os.path.join(OPTIONS.work, "wants_more")
        os.makedirs(source, exist_ok=True)
        pathlib.Path(source, "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(wants LANGUAGES CXX)\nfind_package(kerf REQUIRED COMPONENTS viewer)\n")
        _, done = self.configure(source, "wants_more_build")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no component viewer", " ".join(done.stderr.split()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--build", "--work", "--source", "--examples", "--embed-core"):
        parser.add_argument(option, required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
