"""Raw frames into arrays, without a server: patches, quantisation, and what does not fit."""

import struct
import unittest

import kerf
import numpy
from kerf.frames import FrameDecoder
from kerf.v1 import geometry_pb2, stream_pb2


def packed(kind, *values):
    return struct.pack(f"<{len(values)}{kind}", *values)


def full_frame(**changes):
    """A square of two triangles in a box of 1 m x 2 m x 0 m, and a slot without material."""
    frame = stream_pb2.Frame(
        sequence=1, tick=7, base_tick=-1, topology_version=3, num_vertices=4, encoding=stream_pb2.RAW, epoch="e",
        box=geometry_pb2.Box3(max=geometry_pb2.Vec3(x=1, y=2)),
        positions=packed("H", 0, 0, 9, 65535, 0, 9, 65535, 65535, 9, 0, 65535, 9))
    frame.topology.CopyFrom(stream_pb2.TopologyPatch(
        base_version=-1, num_slots=3, triangles=packed("i", 0, 1, 2, -1, -1, -1, 0, 2, 3), pieces=packed("i", 0, -1, 0),
        material_positions=packed("f", 0, 0, 1, 0, 1, 1, 0, 1), num_pieces=1, num_listed_slots=3, num_listed_vertices=4))
    for name, value in changes.items():
        setattr(frame, name, value)
    return frame


def patched_frame(**changes):
    """The next: the second triangle is another piece with a corner of its own, in the slot that was empty."""
    frame = stream_pb2.Frame(
        sequence=2, tick=8, base_tick=-1, topology_version=4, num_vertices=5, encoding=stream_pb2.RAW,
        positions=packed("H", *range(15)))
    frame.topology.CopyFrom(stream_pb2.TopologyPatch(
        base_version=3, num_slots=3, slots=packed("I", 1, 2), triangles=packed("i", 4, 2, 3, -1, -1, -1),
        pieces=packed("i", 1, -1), vertices=packed("I", 4), material_positions=packed("f", 0.5, 0.25)))
    for name, value in changes.items():
        setattr(frame, name, value)
    return frame


class Decoding(unittest.TestCase):
    def test_a_full_frame(self):
        frame = FrameDecoder().decode(full_frame())
        self.assertEqual((frame.tick, frame.topology_version, frame.topology_changed), (7, 3, True))
        self.assertEqual(frame.positions.tolist(), [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]])
        self.assertEqual(frame.triangles.tolist(), [[0, 1, 2], [0, 2, 3]])
        self.assertEqual(frame.pieces.tolist(), [0, 0])
        self.assertEqual(frame.material_positions.tolist(), [[0, 0], [1, 0], [1, 1], [0, 1]])
        self.assertEqual(frame.resolution.tolist(), [1 / 65535, 2 / 65535, 0])
        self.assertIsNone(frame.strains)
        self.assertEqual([str(array.dtype) for array in (frame.positions, frame.triangles, frame.material_positions)],
                         ["float64", "int32", "float32"])

    def test_a_patch_changes_only_what_it_lists_and_no_earlier_frame(self):
        decoder = FrameDecoder()
        first = decoder.decode(full_frame())
        second = decoder.decode(patched_frame())
        self.assertEqual(second.triangles.tolist(), [[0, 1, 2], [4, 2, 3]])
        self.assertEqual(second.pieces.tolist(), [0, 1])
        self.assertEqual(second.material_positions.tolist(), [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.25]])
        self.assertEqual(first.triangles.tolist(), [[0, 1, 2], [0, 2, 3]])
        third = patched_frame(sequence=3, tick=9)
        third.ClearField("topology")
        decoded = decoder.decode(third)
        self.assertFalse(decoded.topology_changed)
        self.assertIs(decoded.triangles, second.triangles)
        for array in (decoded.positions, decoded.triangles, decoded.pieces, decoded.material_positions):
            with self.assertRaises(ValueError):
                array[0] = 0

    def test_strains_are_finest_about_zero(self):
        frame = FrameDecoder().decode(full_frame(strains=packed("b", 127, -127, 0, 1), strain_scale=0.5))
        numpy.testing.assert_allclose(frame.strains, [0.5, -0.5, 0, 0.5 / 127 ** 2], rtol=1e-6)

    def test_another_stream_goes_on_where_the_last_one_ended(self):
        decoder = FrameDecoder()
        decoder.decode(full_frame())
        self.assertEqual((decoder.epoch, decoder.topology_version), ("e", 3))
        decoder.begin_stream()
        resumed = decoder.decode(patched_frame(sequence=1, epoch="e"))
        self.assertEqual(resumed.topology_version, 4)

    def test_what_does_not_fit_is_told(self):
        for changes, why in (
                ({"sequence": 2}, "frame 2 follows frame 0"),
                ({"encoding": stream_pb2.COMPACT}, "not raw"),
                ({"base_tick": 6}, "not raw"),
                ({"positions": b"1234567"}, "buffer size"),
                ({"positions": packed("H", 1, 2, 3)}, "1 positions of 4"),
                ({"num_vertices": 2, "positions": packed("H", *range(6))}, "vertex 3 of 2"),
                ({"strains": b"1", "strain_scale": 1}, "1 strains of 4")):
            with self.subTest(why=why), self.assertRaisesRegex(kerf.DataLoss, why):
                FrameDecoder().decode(full_frame(**changes))

    def test_patches_that_do_not_fit_are_told(self):
        def wrong_patch(**changes):
            frame = patched_frame()
            for name, value in changes.items():
                setattr(frame.topology, name, value)
            return frame

        for frame, why in (
                (patched_frame(topology_version=9, sequence=3), "frame 3 follows"),
                (wrong_patch(base_version=2), "of topology 2, not 3"),
                (wrong_patch(num_slots=2), "leaves 2 of 3 rows"),
                (wrong_patch(slots=packed("I", 1, 8)), "out of bounds"),
                (wrong_patch(vertices=packed("I", 9)), "out of bounds"),
                (wrong_patch(pieces=packed("i", 1, 2, 3)), "shape mismatch")):
            with self.subTest(why=why):
                decoder = FrameDecoder()
                decoder.decode(full_frame())
                with self.assertRaisesRegex(kerf.DataLoss, why) as caught:
                    decoder.decode(frame)
                self.assertEqual(caught.exception.reason, "FRAME_MALFORMED")
        decoder = FrameDecoder()
        decoder.decode(full_frame())
        bare = patched_frame()
        bare.ClearField("topology")
        with self.assertRaisesRegex(kerf.DataLoss, "topology 4 comes without its patch"):
            decoder.decode(bare)
