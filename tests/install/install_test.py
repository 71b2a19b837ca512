"""Kerf installed, and used by a project outside of it: client/examples, configured with find_package(kerf) against the installed
tree, compiled, and its example that needs no server run."""

import argparse
import os
import pathlib
import re
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


class Programs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.prefix = pathlib.Path(OPTIONS.work, "everything")
        shutil.rmtree(cls.prefix, ignore_errors=True)
        done = run("cmake", "--install", OPTIONS.build, "--prefix", cls.prefix)
        assert done.returncode == 0, done.stderr

    def ninja(self, *arguments):
        done = run(OPTIONS.ninja, "-C", OPTIONS.build, "-t", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def in_build(self, name):
        return os.path.normpath(os.path.join(OPTIONS.build, name))

    def test_what_deploy_run_builds_is_all_that_is_installed(self):
        script = pathlib.Path(OPTIONS.source, "deploy/run").read_text()
        targets = re.search(r"cmake --build --preset release --target (.*)", script).group(1).split()
        commands = "\n".join(self.ninja("commands", *targets))
        outputs = {self.in_build(line.rsplit(":", 1)[0]) for line in self.ninja("targets", "all")}
        taken = set()
        for file in pathlib.Path(OPTIONS.build).rglob("cmake_install.cmake"):
            for call in re.findall(r"file\(INSTALL [^)]*\)", file.read_text()):
                taken.update(self.in_build(name) for name in re.findall(r'"(/[^"]+)"', call))
        self.assertIn(self.in_build("client/manual/kerf.1"), taken)
        for file in sorted(taken & outputs):
            self.assertIn(os.path.relpath(file, OPTIONS.build), commands)  # a command names what it makes

    def test_programs_and_completion_are_there(self):
        done = run(self.prefix / "bin/kerf", "--version")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.prefix / "bin/kerfd").is_file())
        for name in ("bash-completion/completions/kerf", "zsh/site-functions/_kerf", "fish/vendor_completions.d/kerf.fish"):
            self.assertIn("kerf", (self.prefix / "share" / name).read_text())
        done = run("bash", "-c", f"source {self.prefix}/share/bash-completion/completions/kerf && complete -p kerf")
        self.assertIn("-F _kerf kerf", done.stdout)

    def test_manual_pages_are_there(self):
        for name in ("kerf", "kerfd"):
            page = self.prefix / f"share/man/man1/{name}.1"
            self.assertTrue(page.read_text().startswith(".TH"), page)
            if shutil.which("man"):
                done = run("man", "--local-file", page, env={**os.environ, "MANPAGER": "cat"})
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("EXIT STATUS" if name == "kerf" else "kerfd", done.stdout)

    def test_the_viewer_has_all_its_files_with_their_times(self):
        """Tests a viewer that was built. kerfd ignores an encoding that is older than its file."""
        built = pathlib.Path(OPTIONS.source, "web/dist")
        for file in built.rglob("*"):
            if file.is_file():
                copy = self.prefix / "share/kerf/web" / file.relative_to(built)
                self.assertEqual(copy.read_bytes(), file.read_bytes())
                self.assertEqual(int(copy.stat().st_mtime), int(file.stat().st_mtime))

    def test_the_documentation_has_all_its_files(self):
        """Tests a site that deploy/docs has built."""
        built = pathlib.Path(OPTIONS.source, "build/docs/site")
        for file in built.rglob("*"):
            if file.is_file():
                self.assertEqual((self.prefix / "share/kerf/docs" / file.relative_to(built)).read_bytes(), file.read_bytes())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--build", "--work", "--source", "--examples", "--embed-core", "--ninja"):
        parser.add_argument(option, required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
