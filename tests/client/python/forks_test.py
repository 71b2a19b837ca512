"""Other processes: a child of a fork calls the server or says why it cannot, and a restarted server is found soon."""

import os
import time
import unittest

import kerf
import support
from support import Case

CHILD = """
import multiprocessing, os, sys
{first}
import kerf, kerf.aio

def tried(work):
    try:
        return work()
    except kerf.Error as error:
        return f"{{type(error).__name__}} {{error.reason}}: {{error.message}}"

def child(server, frames, results):
    def connects():
        with kerf.connect(server.address, timeout_s=60) as other:
            return other.info().version
    def watches():
        with server.sheet("{sheet}").watch(duration_s=60) as own:
            return next(own).tick
    results.put([tried(work) for work in (lambda: server.info().version, connects, watches, lambda: next(frames).tick)])

def main():
    with kerf.connect("{address}", timeout_s=60) as server, server.sheet("{sheet}").watch() as frames:
        next(frames)
        results = multiprocessing.get_context("fork").Queue()
        for _ in range(2):
            process = multiprocessing.get_context("fork").Process(target=child, args=(server, frames, results))
            process.start()
            print(results.get(timeout=100))
            process.join(100)
            assert process.exitcode == 0, process.exitcode
        server.sheet("{sheet}").step(1)
        print(next(frames).tick, server.info().version)

main()
"""

SPAWNED = """
import multiprocessing, sys
import kerf

def child(address, results):
    with kerf.connect(address, timeout_s=60) as server:
        results.put(server.info().version)

if __name__ == "__main__":
    server = kerf.connect("{address}", timeout_s=60)
    server.info()
    how = multiprocessing.get_context("spawn")
    results = how.Queue()
    process = how.Process(target=child, args=(server.address, results))
    process.start()
    print(results.get(timeout=100), server.info().version)
    process.join(100)
"""

ASYNC = """
import asyncio, os
import kerf, kerf.aio

async def main():
    async with kerf.aio.connect("{address}", timeout_s=60) as server:
        await server.info()
        pid = os.fork()
        if pid == 0:
            try:
                await server.info()
            except kerf.Unavailable as error:
                print(error.reason, error.message, flush=True)
            os._exit(0)
        os.waitpid(pid, 0)
        print((await server.info()).version)

asyncio.run(main())
"""


class Forks(Case):
    def lines_of(self, script, *, first=""):
        script = script.format(address=support.ADDRESS, sheet=self.sheet.id, first=first)
        file = support.path(f"{self._testMethodName}.py")
        with open(file, "w", encoding="utf-8") as out:
            out.write(script)
        done = support.run_python(file, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def test_a_child_of_a_fork_has_connections_of_its_own(self):
        version = kerf.__version__
        *children, parent = self.lines_of(CHILD)
        self.assertEqual(len(children), 2)
        for line in children:
            self.assertTrue(line.startswith(f"['{version}', '{version}', 0, 'Unavailable FORKED: the parent opened"), line)
        self.assertEqual(parent, f"1 {version}")

    def test_or_says_why_it_has_none(self):
        *children, parent = self.lines_of(CHILD, first="os.environ.pop('GRPC_ENABLE_FORK_SUPPORT', None); import grpc")
        for line in children:
            self.assertEqual(line.count("Unavailable FORKED: gRPC's threads did not survive a fork"), 3, line)
            self.assertIn("GRPC_ENABLE_FORK_SUPPORT=1", line)
        self.assertEqual(parent, f"1 {kerf.__version__}")

    def test_processes_that_are_spawned(self):
        self.assertEqual(self.lines_of(SPAWNED), [f"{kerf.__version__} {kerf.__version__}"])

    def test_asyncio_says_what_a_fork_does(self):
        child, parent = self.lines_of(ASYNC)
        self.assertIn("FORKED gRPC's asyncio does not survive a fork", child)
        self.assertEqual(parent, kerf.__version__)


class Restarts(unittest.TestCase):
    def test_a_server_that_is_back_is_found_within_two_seconds(self):
        self.assertEqual(os.environ["GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS"], "250")
        process, address = support.start_server(support.held_port())
        server = kerf.connect(address)
        self.addCleanup(server.close)
        server.info()

        def answers():
            try:
                return bool(server.info())
            except kerf.Unavailable:
                return False

        for downtimes in (3, 40):  # tries without a server, also more than gRPC's waits take to grow
            process.kill()
            process.wait()
            process.stdout.close()
            for _ in range(downtimes):
                self.assertFalse(answers())
                time.sleep(0.1)
            process, _ = support.start_server(address)
            pauses = 0
            while not answers():
                pauses += 1
                self.assertLess(pauses, 20, "it has been back for 2 s")
                time.sleep(0.1)
        support.stop_server(process)
