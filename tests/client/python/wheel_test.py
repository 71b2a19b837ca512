"""The wheel: it installs without an index and without the compiler of Protocol Buffers, and runs the README's lines."""

import os
import pathlib
import platform
import re
import shutil
import subprocess
import unittest
import zipfile

import kerf
import support
from support import ROOT, path


class Wheels(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        for folder in ("wheel", "wheel-again"):
            shutil.rmtree(path(folder), ignore_errors=True)
            subprocess.run([support.PYTHON, ROOT / "client/python/build_wheel", path(folder)], check=True,
                           capture_output=True)
        (cls.wheel,) = pathlib.Path(path("wheel")).iterdir()

    def test_the_same_sources_give_the_same_bytes(self):
        self.assertEqual(self.wheel.name, f"kerf-{kerf.__version__}-py3-none-any.whl")
        self.assertEqual(self.wheel.read_bytes(), (pathlib.Path(path("wheel-again")) / self.wheel.name).read_bytes())

    def test_it_has_all_of_the_package_and_nothing_else(self):
        package = pathlib.Path(path("package"))
        made = {str(file.relative_to(package)) for file in package.rglob("*") if file.suffix in (".py", ".pyi", ".typed")}
        with zipfile.ZipFile(self.wheel) as archive:
            names = {name for name in archive.namelist() if ".dist-info/" not in name}
        self.assertEqual(names, made)

    def install(self, wheel, environment):
        """Installs a wheel into a new environment that has Debian's packages, and no program or index to help."""
        shutil.rmtree(environment, ignore_errors=True)
        bare = {"PATH": path("no-programs"), "HOME": path("home"), "PIP_NO_CACHE_DIR": "1"}
        for command in ([support.PYTHON, "-m", "venv", "--system-site-packages", "--without-pip", environment],
                        [support.PYTHON, "-m", "pip", "--python", f"{environment}/bin/python", "install", "--no-index",
                         str(wheel)]):
            done = subprocess.run(command, capture_output=True, text=True, env=bare)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def run_installed(self, environment, lines, **options):
        """Runs lines of Python in an environment, and returns what they print."""
        left_out = ("PYTHONPATH", "KERF_LIBRARY")
        done = subprocess.run([f"{environment}/bin/python", "-c", lines], capture_output=True, text=True,
                              env={key: value for key, value in os.environ.items() if key not in left_out}, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_with_the_library_inside_it_needs_no_server(self):
        folder, environment = path("wheel-with-library"), path("environment-with-library")
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run([support.PYTHON, ROOT / "client/python/build_wheel", folder, os.environ["KERF_LIBRARY"]], check=True,
                       capture_output=True)
        (wheel,) = pathlib.Path(folder).iterdir()
        self.assertEqual(wheel.name, f"kerf-{kerf.__version__}-py3-none-linux_{platform.machine()}.whl")
        self.install(wheel, environment)
        lines = "import kerf\nwith kerf.local() as own: print(own.create_sheet('a', grid=(4, 4), paused=True).step(2).tick)"
        self.assertEqual(self.run_installed(environment, lines), "2\n")

    def test_it_installs_alone_and_runs_the_readme(self):
        environment = path("environment")
        self.install(self.wheel, environment)
        work = pathlib.Path(path("readme-of-wheel"))
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        (work / "drawing.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><circle cx="20" cy="20" r="9"/></svg>')
        block = re.findall(r"```python\n(.*?)```", (ROOT / "client/python/README.md").read_text(), re.DOTALL)[0]
        renderer = kerf.connect(support.ADDRESS)
        self.addCleanup(renderer.close)
        if renderer.info().renderer.startswith("none"):
            block = re.sub(r".*sheet\.render.*\n", "", block)
        process, address = support.start_server()
        self.addCleanup(lambda: support.stop_server(process))
        lines = "import kerf; print(kerf.__file__)\n" + block.replace("127.0.0.1:50051", address)
        printed = self.run_installed(environment, lines, cwd=work)
        self.assertTrue(printed.startswith(environment), printed)


if __name__ == "__main__":
    unittest.main()
