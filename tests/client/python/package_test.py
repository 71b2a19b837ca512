"""The package itself: types, documentation, that both surfaces are the same, what it needs."""

import doctest
import graphlib
import importlib
import inspect
import os
import pathlib
import pkgutil
import re
import shutil
import subprocess
import unittest

import kerf
import kerf.aio
import kerf.blocking
import numpy
import support
from support import ROOT, Case, path

MADE_OF = ("client", "connection", "sheet", "cutting", "running", "interaction", "viewing", "streams", "recorder", "transport")
RENAMED = {"__aenter__": "__enter__", "__aexit__": "__exit__", "__aiter__": "__iter__", "__anext__": "__next__",
           "aclose": "close"}


def modules_of(name):
    """The module that awaits and the one that blocks."""
    blocking = "kerf.transport" if name == "transport" else f"kerf.blocking.{name}"
    return importlib.import_module(f"kerf.aio.{name}"), importlib.import_module(blocking)


def surface(module):
    """Returns each class and function that the module defines, by its public name: its signature, and whether it is awaited."""
    found = {}
    for name, value in vars(module).items():
        if name.startswith("_") or getattr(value, "__module__", None) != module.__name__:
            continue
        members = vars(value).items() if inspect.isclass(value) else [("", value)]
        for member, function in members:
            if inspect.isfunction(function) and (not member.startswith("_") or member.startswith("__")):
                key = f"{name}.{RENAMED.get(member, member)}"
                found[key] = (signature_of(function), inspect.iscoroutinefunction(function))
    return found


def signature_of(function):
    """Returns the signature that callers see; types that differ only in being awaited read the same."""
    signature = str(inspect.signature(function))
    for words, plain in ((r"AsyncIterator", "Iterator"), (r"Awaitable\[(\w+)\]", r"\1"),
                         (r"Coroutine\[Any, Any, (\w+)\]", r"\1"), (r"grpc\.aio\.Channel", "grpc.Channel")):
        signature = re.sub(words, plain, signature)
    return signature


class Surfaces(unittest.TestCase):
    def test_both_have_the_same_members_with_the_same_signatures(self):
        total = 0
        for name in MADE_OF:
            awaited, blocking = modules_of(name)
            of_awaited, of_blocking = surface(awaited), surface(blocking)
            self.assertEqual({key: value[0] for key, value in of_awaited.items()},
                             {key: value[0] for key, value in of_blocking.items()}, name)
            self.assertEqual([key for key, (_, is_awaited) in of_blocking.items() if is_awaited], [], name)
            total += len(of_awaited)
        self.assertGreater(total, 60)

    def test_no_module_of_aio_imports_itself_through_others(self):
        folder = ROOT / "client/python/kerf/aio"
        imports = {file.stem: re.findall(r"^ *from kerf\.aio\.(\w+) import", file.read_text(), re.MULTILINE)
                   for file in folder.glob("*.py") if file.stem != "__init__"}
        self.assertIn("connection", imports["client"])
        graphlib.TopologicalSorter(imports).prepare()  # raises CycleError

    def test_everything_of_aio_is_in_kerf(self):
        self.assertEqual(set(kerf.aio.__all__) - set(kerf.__all__), set())
        made = {value.__module__.rpartition(".")[2] for value in map(kerf.aio.__dict__.get, kerf.aio.__all__)}
        self.assertLessEqual(made, set(MADE_OF))
        for name in kerf.__all__:
            self.assertTrue(hasattr(kerf, name), name)


class Documentation(Case):
    def test_everything_public_is_documented(self):
        # Drawn from files, the counterpart of what has an example, or calls for which the server has to keep sheets.
        without_example = {"svg_file", "dxf", "dxf_file", "load_cuts", "load_run", "view_of_matrices", "Sheet.drag", "Sheet.release",
                           "Sheet.delete", "Sheet.watch_images", "Server.close", "Server.replay", "Server.store_info",
                           "Server.prune_store", "Server.delete_set_aside", "Server.backup_store", "Server.access",
                           "Server.create_link"}
        for name in kerf.__all__:
            value = getattr(kerf, name)
            if inspect.isfunction(value):
                self.assert_documented(name, value, without_example)
            elif inspect.isclass(value) and value.__module__.startswith("kerf."):
                self.assertTrue(value.__doc__, name)
                for member, function in inspect.getmembers(value, inspect.isfunction):
                    if not member.startswith("_") and function.__module__.startswith("kerf."):
                        is_main = value in (kerf.Sheet, kerf.Server)
                        self.assert_documented(f"{name}.{member}", function, without_example if is_main else None)

    def test_the_readme_works_as_it_stands(self):
        self.needs_renderer()
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / "client/python/README.md").read_text(), re.DOTALL)
        self.assertEqual(len(blocks), 3)
        folder = pathlib.Path(path("readme"))
        folder.mkdir()
        (folder / "drawing.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><circle r="40"/></svg>')
        refusal = "import kerf\nserver = kerf.connect()\nsheet = server.sheet('flag')\n" + blocks[2]
        for script in (blocks[0], blocks[1], refusal):
            script = script.replace('connect("127.0.0.1:50051")', "connect()")
            done = support.run_python("-c", script.replace("connect()", f'connect("{support.ADDRESS}")'), cwd=folder)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, "INVALID_ARGUMENT RADIUS_NOT_POSITIVE cut.curve.circle.radius_m\n")
        self.server.sheet("flag").delete()

    def test_the_page_of_scripts_works_as_it_stands(self):
        page = (ROOT / "client/python/scripts.md").read_text()
        steps, environments, local = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        with self.server.temporary_sheet(grid=(6, 6), paused=True) as other:
            names = {"kerf": kerf, "server": self.server, "sheet": self.sheet, "other": other}
            exec(steps, names)
            self.assertEqual((names["stepped"].tick, self.sheet.get().tick, other.get().tick), (4, 12, 4))
        exec(environments.replace("127.0.0.1:50051", support.ADDRESS), names)
        self.assertEqual(names["info"]["tick"], 4)
        names["env"].close()
        names["envs"].close()
        exec(local, {"kerf": kerf})

    def assert_documented(self, name, function, without_example):
        """without_example: names that need none; None: no function here needs one."""
        self.assertTrue(function.__doc__, name)
        if without_example is not None and name not in without_example:
            self.assertIn(">>>", function.__doc__, name)

    def test_examples_in_docstrings(self):
        names = [module.name for package in (kerf, kerf.blocking)
                 for module in pkgutil.iter_modules(package.__path__, package.__name__ + ".") if not module.ispkg]
        has_renderer = not self.server.info().renderer.startswith("none")
        attempted = 0
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
        for name in names:
            for test in doctest.DocTestFinder(exclude_empty=True).find(importlib.import_module(name)):
                if not test.examples or (not has_renderer and "render(" in test.docstring):
                    continue
                with self.subTest(of=test.name), self.server.temporary_sheet(grid=(20, 20), paused=True) as sheet:
                    test.globs.update(kerf=kerf, numpy=numpy, server=self.server, sheet=sheet, address=support.ADDRESS,
                                      path=path("doctest.npz"))
                    if test.name.endswith("load_run") or test.name.endswith("runs.Run"):
                        with sheet.recorder(path("doctest.npz")):
                            sheet.step(2)
                    told = []
                    self.assertEqual(runner.run(test, out=told.append).failed, 0, "".join(told))
                    attempted += len(test.examples)
        self.assertGreater(attempted, 50)


class Package(unittest.TestCase):
    def test_without_numpy_all_else_works(self):
        script = ("import sys\nsys.modules['numpy'] = None\nimport kerf, kerf.aio\n"
                  f"with kerf.connect('{support.ADDRESS}') as server:\n"
                  "    with server.temporary_sheet(grid=(5, 5), paused=True) as sheet:\n"
                  "        print(sheet.cut(kerf.circle((0.5, 0.5), 0.2)).pieces)\n"
                  "        try:\n            sheet.state()\n"
                  "        except ImportError as missing:\n            print(missing)\n")
        done = support.run_python("-c", script)
        self.assertEqual(done.returncode, 0, done.stderr)
        pieces, missing = done.stdout.splitlines()
        self.assertEqual(pieces, "2")
        self.assertIn("apt install python3-numpy", missing)

    def test_pip_installs_it(self):
        # From a copy: building leaves files beside the sources.
        for name in ("client/python", "proto"):
            shutil.copytree(ROOT / name, path(f"sources/{name}"))
        shutil.copy(ROOT / "CMakeLists.txt", path("sources"))
        done = support.run_python("-m", "pip", "install", "--no-index", "--no-build-isolation", "--no-deps",
                                  "--target", path("installed"), path("sources/client/python"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        script = "import importlib.metadata, kerf, kerf.aio; print(kerf.__file__, importlib.metadata.version('kerf'))"
        told = subprocess.run([support.PYTHON, "-c", script], capture_output=True, text=True, cwd=path("installed"))
        self.assertEqual(told.stdout.split(), [path("installed/kerf/__init__.py"), kerf.__version__], told.stderr)

    def test_version_is_that_of_the_build(self):
        self.assertIn(f"project(kerf VERSION {kerf.__version__} ", (ROOT / "CMakeLists.txt").read_text())
        with kerf.connect(support.ADDRESS) as server:
            self.assertEqual(server.info().version, kerf.__version__)

    def test_types(self):
        examples = ROOT / "client/python/examples"

        def checked(*what):
            return subprocess.run(["mypy", "--config-file", ROOT / "client/python/mypy.ini", *what], capture_output=True,
                                  text=True, cwd=path("package"), env={**os.environ, "MYPYPATH": str(examples)})
        for what in (["-p", "kerf"], sorted(examples.glob("*.py"))):
            done = checked(*what)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        pathlib.Path(path("wrong.py")).write_text(
            "import kerf, kerf.aio\nsheet = kerf.connect().sheet('a')\nsheet.cut(kerf.circle((0, 0), 1), tolerence=1)\n"
            "sheet.cut(kerf.circle((0, 0), 1), tolerance='much')\nsheet.cut(kerf.circle(0, 1))\n"
            "kerf.aio.connect().sheet('a').cut(kerf.circle((0, 0), 1)).pieces\nsheet.watch(rate='fast')\n")
        done = checked(path("wrong.py"))
        self.assertEqual(done.stdout.count("error:"), 5, done.stdout)
