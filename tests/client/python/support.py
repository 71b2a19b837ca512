"""Shared by the tests of the Python package: the package as it is generated, and one kerfd for all of them."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/support"))
from closed_port import closed_port, held_port  # pylint: disable=unused-import

# The server and the token of whoever runs the tests are not theirs to touch.
for variable in ("KERF_SERVER", "KERF_TOKEN_FILE", "KERF_TLS_CA", "KERF_TLS_CERT", "KERF_TLS_KEY"):
    os.environ.pop(variable, None)
PYTHON = "/usr/bin/python3"
OPTIONS = None
ADDRESS = None
PROCESS = None


def begin(options):
    """Generates the package and starts the server; before any module of tests is imported."""
    global OPTIONS, ADDRESS, PROCESS
    OPTIONS = options
    shutil.rmtree(options.work, ignore_errors=True)
    os.makedirs(options.work)
    subprocess.run([ROOT / "client/python/generate", path("package")], check=True)
    sys.path.insert(0, path("package"))
    PROCESS, ADDRESS = start_server()


def start_server(listen="127.0.0.1:0", *options):
    kept = () if "--data" in options else ("--data", "none")
    process = subprocess.Popen(
        [OPTIONS.kerfd, "--listen", listen, "--http", "127.0.0.1:0", "--max-load", "0", *kept, *options], stdout=subprocess.PIPE, text=True)
    ready = json.loads(process.stdout.readline())
    process.http = ready["http"]
    return process, ready["grpc"]


def stop_server(process):
    process.send_signal(signal.SIGTERM)
    process.stdout.close()
    if process.wait(timeout=20) != 0:
        raise AssertionError(f"kerfd left with {process.returncode} after SIGTERM")


def path(name):
    return os.path.join(OPTIONS.work, name)


def run_python(*arguments, **options):
    """Debian's Python with the package on its path, to its end."""
    environment = {**os.environ, "PYTHONPATH": path("package"), "MPLBACKEND": "Agg", "MPLCONFIGDIR": path("matplotlib")}
    return subprocess.run([PYTHON, *map(str, arguments)], capture_output=True, text=True, env=environment, **options)


def running(work):
    """The work on a thread of its own; call what is returned to wait for its end and get what it came to."""
    import kerf
    results = []

    def run():
        try:
            results.append(work())
        except kerf.Error as error:
            results.append(error)

    thread = threading.Thread(target=run)
    thread.start()

    def result():
        thread.join(timeout=60)
        return results[0]

    return result


def until(stream, tick):
    """The frames or pictures that come, up to that of the tick."""
    seen = [next(stream)]
    while seen[-1].tick < tick:
        seen.append(next(stream))
    return seen


class Case(unittest.TestCase):
    """A connection, and a paused sheet of 20 x 20 vertices that is the test's own."""

    def setUp(self):
        import kerf
        self.server = kerf.connect(ADDRESS, timeout_s=300)
        self.addCleanup(self.server.close)
        self.sheet = self.server.create_sheet(
            "py-" + self._testMethodName.replace("_", "-")[:50], grid=(20, 20), paused=True)
        self.addCleanup(self.sheet.delete)

    def pieces_after(self, curve, **options):
        import kerf
        result = self.sheet.cut(curve, **options)
        self.assertEqual(result.status, kerf.APPLIED)
        return result.pieces

    def refused(self, kind, code, reason, field, call, *arguments, **options):
        """The refusal; nothing may have changed."""
        import kerf
        before = self.sheet.get().state_hash
        with self.assertRaises(kind) as caught:
            call(*arguments, **options)
        error = caught.exception
        self.assertIsInstance(error, kerf.Error)
        self.assertEqual((error.code, error.reason, error.field), (code, reason, field))
        self.assertIn(error.message, str(error))
        self.assertIn(reason, str(error))
        self.assertEqual(self.sheet.get().state_hash, before)
        return error

    def needs_renderer(self):
        renderer = self.server.info().renderer
        if renderer.startswith("none"):
            self.skipTest(renderer)


class AsyncCase(unittest.IsolatedAsyncioTestCase):
    """The same for asyncio."""

    async def asyncSetUp(self):
        import kerf.aio
        self.server = kerf.aio.connect(ADDRESS, timeout_s=300)
        self.addAsyncCleanup(self.server.aclose)
        self.sheet = await self.server.create_sheet(
            "py-aio-" + self._testMethodName.replace("_", "-")[:50], grid=(20, 20), paused=True)
        self.addAsyncCleanup(self.sheet.delete)
