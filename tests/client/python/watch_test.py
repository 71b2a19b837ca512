"""Live frames as arrays: what they hold, that a slow loop does not lag, and how streams end."""

import json
import pathlib
import socket
import threading
import time
import unittest.mock

import kerf
import numpy
import support
from support import Case, running, until


class Watching(Case):
    def test_a_frame_is_the_state_within_its_resolution(self):
        self.sheet.cut(kerf.polyline((-0.1, 0.3), (1.1, 0.35)))
        self.sheet.cut(kerf.circle((0.5, 0.7), 0.1))
        self.sheet.step(5)
        state = self.sheet.state()
        with self.sheet.watch(strains=True) as frames:
            frame = next(frames)
        self.assertEqual((frame.tick, frame.topology_version), (state.tick, state.topology_version))
        self.assertTrue((abs(frame.positions - state.positions) <= frame.resolution / 2 + 1e-12).all())
        numpy.testing.assert_array_equal(frame.triangles, state.triangles)
        numpy.testing.assert_array_equal(frame.pieces, state.pieces)
        numpy.testing.assert_array_equal(frame.material_positions, state.material_positions.astype("f4"))
        self.assertEqual((frame.strains.shape, frame.stats.pieces), ((len(state.positions),), 3))
        self.assertGreater(frame.strains.max(), 0)
        self.assertTrue((numpy.diff(numpy.unique(frame.pieces)) == 1).all())

    def test_ticks_and_topologies_come_as_they_happen(self):
        with self.sheet.watch() as frames:
            first = next(frames)
            self.sheet.step(1)
            second = next(frames)
            self.assertEqual((second.tick, second.topology_changed), (first.tick + 1, False))
            self.assertIs(second.triangles, first.triangles)
            self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
            third = next(frames)
            self.assertEqual((third.topology_changed, third.topology_version), (True, first.topology_version + 1))
            self.assertEqual(len(numpy.unique(third.pieces)), 2)
            self.sheet.undo()
            self.assertEqual(len(numpy.unique(next(frames).pieces)), 1)
            self.assertEqual(len(numpy.unique(third.pieces)), 2)  # is not changed by those after it

    def test_a_slow_loop_skips_ticks_and_never_lags(self):
        with self.sheet.watch() as frames:
            next(frames)
            for _ in range(5):
                self.sheet.step(20)  # the loop is busy for 20 ticks
                now = self.sheet.get().tick
                frame = next(frames)
                self.assertEqual((frame.tick, frame.stats.skipped), (now, 19))

    def test_acknowledgements_tell_how_long_a_frame_was_held(self):
        sent = []
        frames = self.sheet.watch(window=0)
        self.addCleanup(frames.close)
        next(frames)
        original = frames._stream.send
        frames._stream.send = lambda request: (sent.append(request), original(request))
        self.sheet.step(1)
        next(frames)
        self.assertEqual(sent[0].ack.sequence, 1)
        self.assertGreater(sent[0].ack.held_us, 1)

    def test_a_stream_that_was_ended_as_too_slow_goes_on(self):
        frames = self.sheet.watch()
        self.addCleanup(frames.close)
        first = next(frames)
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        # The message of a server after 10 seconds without an acknowledgement.
        ended = kerf.v1.stream_pb2.WatchResponse(
            ended=kerf.v1.stream_pb2.Ended(reason=kerf.v1.stream_pb2.Ended.TOO_SLOW))
        stream = frames._stream
        stream.receive = lambda: ended
        second = next(frames)
        self.assertIsNot(frames._stream, stream)
        # The patch from where it was, not everything again.
        self.assertEqual((second.topology_version, second.topology_changed), (first.topology_version + 1, True))
        self.assertEqual(frames._start.topology_version, first.topology_version)
        self.sheet.step(1)
        self.assertEqual(next(frames).tick, self.sheet.get().tick)

    def test_a_pace_outlives_the_stream_that_it_was_set_on(self):
        frames = self.sheet.watch()
        self.addCleanup(frames.close)
        next(frames)
        frames.pace(rate_hz=5)
        stream = type(frames._stream)
        frames._stream.close()
        frames._stream = None
        frames._sequence = 0
        with unittest.mock.patch.object(stream, "send", autospec=True, side_effect=stream.send) as send:
            next(frames)
        sent = [call.args[1] for call in send.call_args_list]
        self.assertEqual([each.WhichOneof("kind") for each in sent], ["start", "pace"])
        self.assertEqual(sent[1].pace.max_rate_hz, 5)

    def test_a_paused_stream_has_no_frames_until_it_goes_on_with_the_newest(self):
        with self.sheet.watch() as frames:
            first = next(frames)
            frames.pace(paused=True)
            waiting = running(lambda: next(frames))  # whose acknowledgement comes after the pace
            for _ in range(20):
                now = self.sheet.step(1).tick
            frames.pace()
            newest = waiting()
            self.assertEqual((newest.tick, newest.stats.skipped), (now, now - first.tick - 1))
            self.sheet.step(1)
            self.assertEqual(next(frames).tick, now + 1)

    def test_a_rate_leaves_out_ticks_until_another_rate(self):
        with self.sheet.watch() as frames:
            next(frames)
            frames.pace(rate_hz=0.001)
            now = self.sheet.step(1).tick
            self.assertEqual(next(frames).tick, now)  # of the new rate, which allows one at once
            last = now + 20
            waiting = running(lambda: until(frames, last))
            while now < last:
                now = self.sheet.step(1).tick
            frames.pace()
            few = waiting()
            # One more where 1000 seconds of the server's clock were over meanwhile.
            self.assertLessEqual(len(few), 2)
            self.assertEqual(sum(frame.stats.skipped + 1 for frame in few), 20)
            self.sheet.step(1)
            self.assertEqual(next(frames).tick, last + 1)

    def test_rates_that_there_are(self):
        with self.sheet.watch(rate_hz=1000) as frames:
            self.assertEqual(next(frames).tick, self.sheet.get().tick)
        with self.assertRaises(kerf.InvalidArgument) as caught:
            next(self.sheet.watch(rate_hz=5000))
        self.assertEqual((caught.exception.reason, caught.exception.field), ("OUT_OF_RANGE", "start.max_rate_hz"))

    def test_nobody_answers(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            with kerf.connect(f"127.0.0.1:{silent.getsockname()[1]}") as server:
                with self.assertRaisesRegex(kerf.Unavailable, "no Kerf server answers"):
                    list(server.sheet("a").watch(duration_s=0.3))

    def test_a_connection_that_is_closed_ends_the_loops_of_others(self):
        other = kerf.connect(support.ADDRESS)
        frames = other.sheet(self.sheet.id).watch()
        next(frames)
        waiting = running(lambda: next(frames))
        other.close()
        self.assertEqual(waiting().code, "CANCELLED")

    def test_how_streams_end(self):
        self.assertEqual([frame.tick for frame in self.sheet.watch(duration_s=0.2)], [self.sheet.get().tick])
        frames = self.sheet.watch()
        next(frames)
        waiting = running(lambda: next(frames, "closed"))
        frames.close()
        self.assertEqual(waiting(), "closed")
        self.assertEqual(list(frames), [])
        other = self.server.create_sheet("py-to-be-deleted", grid=(4, 4), paused=True)
        frames = other.watch()
        next(frames)
        other.delete()
        with self.assertRaises(kerf.NotFound) as caught:
            next(frames)
        self.assertEqual(caught.exception.reason, "SHEET_DELETED")
        with self.assertRaises(kerf.NotFound) as caught:
            next(other.watch())
        self.assertEqual(caught.exception.reason, "SHEET_NOT_FOUND")

    def test_a_server_that_stops_says_so(self):
        process, address = support.start_server()
        with kerf.connect(address) as server:
            frames = server.create_sheet("s", grid=(4, 4), paused=True).watch()
            next(frames)
            support.stop_server(process)
            with self.assertRaises(kerf.Unavailable) as caught:
                next(frames)
            self.assertEqual(caught.exception.reason, "SERVER_STOPPING")
            with self.assertRaisesRegex(kerf.Unavailable, "start one with deploy/run"):
                server.info()

    def test_a_stream_that_is_dropped_leaves_no_thread(self):
        before = threading.active_count()
        for _ in range(5):
            for _frame in self.sheet.watch():
                break
        for thread in threading.enumerate()[before:]:
            thread.join(timeout=20)
        self.assertEqual(threading.active_count(), before)

    def test_subscribing(self):
        frames = list(self.sheet.subscribe(rate_hz=10, max_frames=1))
        self.assertEqual([frame.positions.shape for frame in frames], [(400, 3)])
        self.sheet.resume()
        ticks = [frame.tick for frame in self.sheet.subscribe(rate_hz=10, max_frames=3)]
        self.assertEqual((len(ticks), ticks), (3, sorted(set(ticks))))
        with self.assertRaises(kerf.InvalidArgument):
            next(self.sheet.subscribe(rate_hz=60))
        with self.sheet.subscribe() as open_end:
            next(open_end)
        self.assertEqual(list(open_end), [])


class Restarts(unittest.TestCase):
    """A server that is started again at the same address, with the same scene."""

    def setUp(self):
        pathlib.Path(support.path("again.json")).write_text(
            json.dumps({"grid": {"columns": 5, "rows": 5, "width_m": 1, "height_m": 1}}))
        self.scene = ("--scene", support.path("again.json"))
        self.process, self.address = support.start_server(support.held_port(), *self.scene)
        self.addCleanup(lambda: support.stop_server(self.process))
        self.server = kerf.connect(self.address)
        self.addCleanup(self.server.close)
        self.sheet = self.server.sheet("again")

    def test_frames_go_on_with_the_next_server(self):
        pauses = []

        def pause(duration_s):
            """Waits between two tries. The server is started the third time, when two of them have found none."""
            pauses.append(duration_s)
            if len(pauses) == 3:
                self.process, _ = support.start_server(self.address, *self.scene)
            time.sleep(duration_s)

        shapes = []
        with unittest.mock.patch("kerf.blocking.streams.pause", pause):
            with self.sheet.watch(reconnect_s=60, duration_s=120) as frames:
                for frame in frames:
                    if not frame.topology_changed:
                        continue
                    shapes.append(frame.positions.shape)
                    if len(shapes) == 2:
                        break
                    support.stop_server(self.process)
        self.assertEqual(shapes, [(25, 3)] * 2)
        self.assertGreaterEqual(len(pauses), 3)

    def test_or_end_when_the_time_for_that_is_over(self):
        for reconnect_s, least in ((0.0, 0), (0.6, 2)):
            with unittest.mock.patch("kerf.blocking.streams.pause", wraps=time.sleep) as pause:
                with self.assertRaises(kerf.Unavailable):
                    with self.sheet.watch(reconnect_s=reconnect_s, duration_s=120) as frames:
                        for _ in frames:
                            support.stop_server(self.process)
            self.assertGreaterEqual(pause.call_count, least)
            self.process, _ = support.start_server(self.address, *self.scene)

    def test_a_limited_time_that_ends_without_a_server_is_no_end_of_the_frames(self):
        with self.assertRaises(kerf.Unavailable):
            with self.sheet.watch(reconnect_s=60, duration_s=1) as frames:
                for _ in frames:
                    support.stop_server(self.process)
        self.process, _ = support.start_server(self.address, *self.scene)
