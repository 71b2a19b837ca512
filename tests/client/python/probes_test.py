"""Values of probes: with frames, and by themselves."""

import unittest

import kerf
import numpy
from support import AsyncCase, Case

TIP = kerf.probe("tip", "position", points=(0.5, 0.0))


class Probes(Case):
    def test_a_frame_has_the_values_of_its_tick(self):
        with self.sheet.watch(probes=[TIP, kerf.probe("all", "energy")]) as frames:
            for tick in range(4):
                frame = next(frames)
                self.assertEqual(frame.tick, tick)
                measured = self.sheet.measure([TIP, kerf.probe("all", "energy")])
                self.assertEqual(frame.probes.columns, measured.columns)
                numpy.testing.assert_array_equal(frame.probes.array, measured.array)
                self.sheet.step(1)
            self.assertLess(frame.probes["tip.z"], 1)
            numpy.testing.assert_array_equal(frame.probes["tip"], frame.probes.array[:3])
            self.assertEqual(set(frame.probes), set(measured.columns))
            with self.assertRaisesRegex(KeyError, "no probe 'top'; there are tip.x"):
                frame.probes["top"]
        self.assertIsNone(next(self.sheet.watch()).probes)

    def test_values_of_every_form_of_points(self):
        rows = numpy.array([[0.0, 0.0], [0.5, 0.25]], dtype="f4")
        for points in (rows, rows.tolist(), [tuple(row) for row in rows], list(rows)):
            values = self.sheet.measure([kerf.probe("p", "position", points=points)])
            self.assertEqual((list(values)[0], values["p"].shape), ("p[0].x", (6,)))
        for point in (rows[1], (0.5, 0.25), [numpy.float32(0.5), 0.25]):
            self.assertEqual(list(self.sheet.measure([kerf.probe("p", "position", points=point)])), ["p.x", "p.y", "p.z"])
        mapping = {"name": "p", "quantity": "POSITION", "points": [{"x": 0.5, "y": 0.25}]}
        numpy.testing.assert_array_equal(
            self.sheet.measure([mapping]).array, self.sheet.measure([kerf.probe("p", "position", points=(0.5, 0.25))]).array)

    def test_the_force_at_an_edge_and_at_all_pins(self):
        self.sheet.step(200)
        top, pins = self.sheet.force("top"), self.sheet.force()
        numpy.testing.assert_allclose(top, pins)
        self.assertGreater(top[2], 0)
        self.sheet.set_pins([kerf.nearest((0, 1)), kerf.nearest((1, 1))])
        left, both = self.sheet.force(kerf.nearest((0, 1))), self.sheet.force()
        self.assertLess(numpy.linalg.norm(left), numpy.linalg.norm(both))

    def test_what_is_no_probe(self):
        with self.assertRaisesRegex(ValueError, "quantity is 'weight'; must be one of displacement"):
            kerf.probe("p", "weight")
        with self.assertRaisesRegex(TypeError, "give a list of probes"):
            self.sheet.watch(probes=TIP)
        with self.assertRaisesRegex(TypeError, "made by kerf.probe"):
            self.sheet.measure(["tip"])
        with self.assertRaisesRegex(ValueError, "quantities"):
            self.sheet.measure([{"name": "p", "quantities": 3}])
        with self.assertRaises(kerf.InvalidArgument) as caught:
            next(self.sheet.watch(probes=[kerf.probe("far", "position", points=(7, 0))]))
        self.assertEqual((caught.exception.reason, caught.exception.field), ("POINT_OUTSIDE", "start.probes[0].points[0]"))


class AsyncProbes(AsyncCase):
    async def test_the_same_for_asyncio(self):
        async with self.sheet.watch(probes=[TIP]) as frames:
            async for frame in frames:
                break
        numpy.testing.assert_array_equal(frame.probes["tip"], (await self.sheet.measure([TIP]))["tip"])
        self.assertEqual((await self.sheet.force("top")).shape, (3,))


if __name__ == "__main__":
    unittest.main()
