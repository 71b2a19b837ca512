"""Lets `pip install client/python` install what client/python/generate makes. Needs protoc and grpc_python_plugin."""

import pathlib
import re
import subprocess

import setuptools
from setuptools.command.build_py import build_py

HERE = pathlib.Path(__file__).resolve().parent


class Generate(build_py):
    """Runs client/python/generate in place of copying the sources, because some of them have to be made."""

    def run(self) -> None:
        subprocess.run([HERE / "generate", self.build_lib], check=True)


def version() -> str:
    """Returns the version of the whole project."""
    found = re.search(r"^project\(kerf VERSION ([0-9.]+) ", (HERE / "../../CMakeLists.txt").read_text(), re.MULTILINE)
    if found is None:
        raise SystemExit("CMakeLists.txt names no version")
    return found.group(1)


setuptools.setup(version=version(), packages=["kerf"], cmdclass={"build_py": Generate})
