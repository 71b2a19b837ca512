"""pip install client/python: what client/python/generate makes is what is installed. Needs protoc and grpc_python_plugin."""

import pathlib
import re
import subprocess

import setuptools
from setuptools.command.build_py import build_py

HERE = pathlib.Path(__file__).resolve().parent


class Generate(build_py):
    """In place of copying the sources, of which some are still to be made."""

    def run(self) -> None:
        subprocess.run([HERE / "generate", self.build_lib], check=True)


def version() -> str:
    """That of the whole project."""
    found = re.search(r"^project\(kerf VERSION ([0-9.]+) ", (HERE / "../../CMakeLists.txt").read_text(), re.MULTILINE)
    if found is None:
        raise SystemExit("CMakeLists.txt names no version")
    return found.group(1)


setuptools.setup(version=version(), packages=["kerf"], cmdclass={"build_py": Generate})
