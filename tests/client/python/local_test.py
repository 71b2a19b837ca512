"""A server in the same process: the same results as over gRPC, and clear words for what it lacks."""

import pathlib
import threading
import unittest

import kerf
import numpy
import support
from support import Case


class Local(Case):
    def setUp(self):
        super().setUp()
        self.local = kerf.local(workers=2)
        self.addCleanup(self.local.close)
        self.own = self.local.create_sheet("own", grid=(20, 20), paused=True)

    def test_it_computes_what_a_server_does(self):
        results = []
        for sheet in (self.sheet, self.own):
            result = sheet.cut(kerf.circle((0.5, 0.5), 0.2))
            stepped = sheet.step(5, state=True, probes=[kerf.probe("tip", "position", points=(0.5, 0.0))])
            sheet.undo()
            results.append((result.pieces, stepped.state, stepped.probes["tip"], sheet.step(1).state_hash))
        (pieces, state, tip, last), (own_pieces, own_state, own_tip, own_last) = results
        self.assertEqual((pieces, state.state_hash, last), (own_pieces, own_state.state_hash, own_last))
        numpy.testing.assert_array_equal(state.positions, own_state.positions)
        numpy.testing.assert_array_equal(tip, own_tip)
        self.assertIn("in this process", repr(self.local))
        self.assertEqual(self.local.info().version, self.server.info().version)

    def test_refusals_are_those_of_a_server(self):
        errors = []
        for sheet in (self.sheet, self.own):
            with self.assertRaises(kerf.InvalidArgument) as caught:
                sheet.cut(kerf.circle((0.5, 0.5), -1.0))
            errors.append((caught.exception.reason, caught.exception.field, str(caught.exception)))
        self.assertEqual(errors[0], errors[1])
        with self.assertRaises(kerf.NotFound):
            self.local.sheet("gone").get()
        with self.assertRaisesRegex(ValueError, "1 to 256 workers"):
            kerf.local(workers=257)

    def test_it_has_no_streams_and_says_what_to_use(self):
        with self.assertRaises(kerf.Unavailable) as caught:
            next(self.own.watch())
        self.assertEqual(caught.exception.reason, "NO_STREAMS")
        recording = pathlib.Path(support.path("empty.kerf"))
        recording.write_bytes(b"")
        for call in (lambda: self.own.record(support.path("own.kerf")), lambda: self.local.replay(recording, "again")):
            with self.assertRaisesRegex(kerf.Unavailable, "NO_STREAMS"):
                call()
        self.assertIn("step(state=True)", str(caught.exception))

    def test_it_draws_if_asked(self):
        self.needs_renderer()
        with kerf.local(render=True) as drawing:
            picture = drawing.create_sheet("drawn", grid=(5, 5), paused=True).render(size_px=(64, 48))
        self.assertTrue(picture)

    def test_clocks_run(self):
        self.own.resume()
        while self.own.get().tick < 3:
            pass
        self.own.pause()

    def test_large_meshes_are_uploaded(self):
        file = pathlib.Path(support.path("large.obj"))
        file.write_text("#" * (2 << 20) + "\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        self.assertEqual(self.local.create_sheet("mesh", mesh_file=file).get().num_vertices, 4)

    def test_a_time_limit_ends_a_step(self):
        sheet = self.local.create_sheet("slow", grid=(60, 60), paused=True)
        self.local.timeout_s = 0.2
        with self.assertRaises(kerf.DeadlineExceeded):
            sheet.step(100_000)

    def test_threads_share_it(self):
        ticks = []

        def work(number):
            sheet = self.local.create_sheet(f"t{number}", grid=(5, 5), paused=True)
            ticks.append([sheet.step(1).tick for _ in range(20)][-1])

        threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(ticks, [20] * 4)

    def test_close_waits_for_calls(self):
        answered = []
        stepping = threading.Thread(target=lambda: answered.append(self.own.step(2000).tick))
        stepping.start()
        while self.own.get().tick == 0:
            pass
        self.local.close()
        stepping.join()
        self.assertEqual(answered, [2000])
        self.local.close()
        with self.assertRaisesRegex(ValueError, "was closed"):
            self.own.get()

    def test_the_child_of_a_fork_starts_another(self):
        lines = support.run_python("-c", (
            "import grpc, os, kerf\nother = kerf.connect()\nserver = kerf.local()\nsheet = server.create_sheet('a', grid=(4, 4), paused=True)\n"
            "if os.fork() == 0:\n"
            "    try:\n        sheet.step(1)\n    except kerf.Unavailable as refusal:\n        print(refusal.reason, flush=True)\n"
            "    with kerf.local() as other:\n"
            "        print(other.create_sheet('b', grid=(4, 4), paused=True).step(3).tick, flush=True)\n    os._exit(0)\n"
            "os.wait()\nprint(sheet.step(1).tick)\n"), timeout=120)
        self.assertEqual(lines.stdout.split(), ["FORKED", "3", "1"], lines.stderr)

    def test_without_the_library_it_says_how_to_get_it(self):
        done = support.run_python("-c", "import os\nos.environ['KERF_LIBRARY'] = '/dev/null/none'\nimport kerf\nkerf.local()")
        self.assertIn("needs libkerf_local.so", done.stderr)
        self.assertIn("ImportError", done.stderr)

    def test_environments_use_it(self):
        import kerf.env
        env = kerf.env.SheetEnv(self.local, grid=(8, 8))
        self.addCleanup(env.close)
        first, _ = env.reset(seed=1)
        second, *_ = env.step(env.action_space.sample() * 0)
        self.assertEqual(first.shape, second.shape)


if __name__ == "__main__":
    unittest.main()
