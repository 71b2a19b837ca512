"""Recording frames into files, and reading them."""

import os
import pathlib
import time

import kerf
import numpy
from kerf import files, runs
from kerf.frames import FrameDecoder
from support import Case, path

import frames_test


class Recording(Case):
    def test_what_is_done_in_the_with_is_in_the_file(self):
        with self.sheet.recorder(path("run.npz"), strains=True) as recorder:
            self.sheet.step(5)
            self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
            last = self.sheet.step(5)
        state = self.sheet.state()
        with kerf.load_run(path("run.npz")) as run:
            self.assertEqual((len(run), len(run.ticks)), (recorder.num_frames, recorder.num_frames))
            self.assertEqual((run.ticks[-1], run[-1].tick), (last.tick, last.tick))
            self.assertTrue((numpy.diff(run.ticks) >= 0).all())
            final = run[-1]
            self.assertLess(abs(final.positions - state.positions).max(), 1e-4)
            numpy.testing.assert_array_equal(final.triangles, state.triangles)
            numpy.testing.assert_array_equal(final.pieces, state.pieces)
            numpy.testing.assert_array_equal(final.material_positions, state.material_positions.astype("f4"))
            self.assertEqual(final.strains.shape, (len(state.positions),))
            self.assertEqual(run.topology_versions[-1], state.topology_version)
        self.assertFalse(os.path.exists(path("run.npz.part")))

    def test_an_exception_leaves_the_frames_until_then(self):
        with self.assertRaisesRegex(RuntimeError, "inside"):
            with self.sheet.recorder(path("broken.npz")) as recorder:
                self.sheet.step(3)
                patience = time.monotonic() + 60
                while not recorder.num_frames and time.monotonic() < patience:
                    time.sleep(0.01)
                self.assertTrue(recorder.num_frames)
                raise RuntimeError("inside")
        self.assertEqual(len(kerf.load_run(path("broken.npz"))), recorder.num_frames)

    def test_failures_are_told(self):
        with self.assertRaises(FileNotFoundError):
            with self.sheet.recorder(path("nowhere/run.npz")):
                pass
        with self.assertRaises(kerf.NotFound):
            with self.server.sheet("py-nobody").recorder(path("nobody.npz")):
                pass
        self.assertFalse(os.path.exists(path("nobody.npz")))

    def test_devices_and_links_stay_what_they_are(self):
        os.symlink("/dev/full", path("device"))
        with self.assertRaisesRegex(OSError, "regular file"):
            with self.sheet.recorder(path("device")):
                pass
        with self.assertRaisesRegex(OSError, "No space"):
            with files.whole_file(path("device")) as file:
                file.write(b"x")
        self.assertTrue(os.path.islink(path("device")))
        pathlib.Path(path("target")).write_bytes(b"of before")
        os.symlink(path("target"), path("link"))
        with files.whole_file(path("link")) as file:
            file.write(b"new")
        self.assertTrue(os.path.islink(path("link")))
        self.assertEqual(pathlib.Path(path("target")).read_bytes(), b"new")

    def test_a_run_of_nothing_leaves_the_one_before(self):
        pathlib.Path(path("kept.npz")).write_bytes(b"of before")
        with self.assertRaises(kerf.NotFound):
            with self.server.sheet("py-nobody").recorder(path("kept.npz")):
                pass
        self.assertEqual(pathlib.Path(path("kept.npz")).read_bytes(), b"of before")
        self.assertFalse(os.path.exists(path("kept.npz.part")))


class Files(Case):
    def test_frames_come_back_in_order_with_their_topologies(self):
        decoder = FrameDecoder()
        first = decoder.decode(frames_test.full_frame())
        second = decoder.decode(frames_test.patched_frame())
        writer = runs.RunWriter(path("small.npz"))
        for frame in (first, first, second):
            writer.add(frame)
        with self.assertRaisesRegex(ValueError, "tick 7 follows that of tick 8"):
            writer.add(first)
        writer.close()
        writer.close()
        run = kerf.load_run(path("small.npz"))
        self.assertEqual(([frame.tick for frame in run], run.topology_versions), ([7, 7, 8], [3, 4]))
        self.assertEqual([frame.topology_changed for frame in run], [True, False, True])
        for frame, written in zip(run, (first, first, second)):
            numpy.testing.assert_array_equal(frame.triangles, written.triangles)
            numpy.testing.assert_allclose(frame.positions, written.positions, rtol=1e-6)
        self.assertEqual([frame.tick for frame in run[1:]], [7, 8])
        with self.assertRaises(IndexError):
            run[3]

    def test_another_topology_of_an_equal_version_is_written(self):
        decoder = FrameDecoder()
        first = decoder.decode(frames_test.full_frame())
        again = frames_test.full_frame()
        again.sequence, again.epoch = 2, "another"
        second = decoder.decode(again)
        writer = runs.RunWriter(path("again.npz"))
        writer.add(first)
        writer.add(second)
        writer.close()
        self.assertEqual(kerf.load_run(path("again.npz")).topology_versions, [3, 3])

    def test_long_runs_are_written_chunk_by_chunk(self):
        frame = FrameDecoder().decode(frames_test.full_frame())
        writer = runs.RunWriter(path("long.npz"))
        original, runs._CHUNK_BYTES = runs._CHUNK_BYTES, 3 * frame.positions.nbytes
        try:
            for _ in range(10):
                writer.add(frame)
        finally:
            runs._CHUNK_BYTES = original
        writer.close()
        with numpy.load(path("long.npz")) as arrays:
            chunks = [arrays[name].shape for name in arrays.files if name.startswith("positions")]
        self.assertEqual(chunks, [(4, 4, 3), (4, 4, 3), (2, 4, 3)])
        self.assertEqual(len(list(kerf.load_run(path("long.npz")))), 10)

    def test_other_files_are_refused(self):
        pathlib.Path(path("text.npz")).write_text("hello")
        numpy.savez(path("other.npz"), a=numpy.zeros(3))
        numpy.save(path("array.npz.npy"), numpy.zeros(3))
        for name in ("text.npz", "other.npz", "array.npz.npy"):
            with self.subTest(name=name), self.assertRaises(ValueError):
                kerf.load_run(path(name))
        with self.assertRaises(FileNotFoundError):
            kerf.load_run(path("absent.npz"))
