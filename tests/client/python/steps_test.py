"""Steps that answer with states and values, of one sheet and of many."""

import unittest

import kerf
import numpy
import support
from support import AsyncCase, Case

TIP = kerf.probe("tip", "position", points=(0.5, 0.0))


class Steps(Case):
    def test_one_call_does_what_two_do(self):
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        stepped = self.sheet.step(3, state=True, probes=[TIP])
        state = self.sheet.state()
        self.assertEqual((stepped.tick, stepped.topology_version, stepped.failure), (3, state.topology_version, ""))
        for name in ("tick", "topology_version", "state_hash"):
            self.assertEqual(getattr(stepped.state, name), getattr(state, name))
        for name in ("positions", "velocities", "material_positions", "triangles", "pieces"):
            numpy.testing.assert_array_equal(getattr(stepped.state, name), getattr(state, name))
        numpy.testing.assert_array_equal(stepped.probes["tip"], self.sheet.measure([TIP])["tip"])
        self.assertIsNone(self.sheet.step(1, probes=[TIP]).state)
        self.assertIsNone(self.sheet.step(1, state=True).probes)
        self.assertEqual(self.sheet.step(1).tick, 6)

    def test_many_sheets_are_stepped_in_one_call(self):
        others = [self.server.create_sheet(f"many-{number}", grid=(5, 4 + number), paused=True) for number in range(5)]
        for other in others:
            self.addCleanup(other.delete)
        stepped = self.server.step(iter([*others, self.sheet]), 2, state=True, probes=[TIP])
        self.assertEqual([len(each.state.positions) for each in stepped], [20, 25, 30, 35, 40, 400])
        self.assertEqual([each.tick for each in stepped], [2] * 6)
        for each, sheet in zip(stepped, [*others, self.sheet]):
            self.assertEqual(each.state.state_hash, sheet.get().state_hash)
        self.assertEqual([each.tick for each in self.server.step(others, 3)], [5] * 5)

    def test_refusals_leave_all_as_they_were(self):
        running = self.server.create_sheet("runs", grid=(4, 4))
        self.addCleanup(running.delete)
        for sheets, reason, field in (([self.sheet, running], "NOT_PAUSED", "names[1]"),
                                      ([self.sheet, self.server.sheet("gone")], "SHEET_NOT_FOUND", "names[1]"),
                                      ([self.sheet, self.sheet], "NAMED_TWICE", "names[1]"), ([], "OUT_OF_RANGE", "names")):
            with self.assertRaises(kerf.Error) as caught:
                self.server.step(sheets, 1)
            self.assertEqual((caught.exception.reason, caught.exception.field), (reason, field))
        self.assertEqual(self.sheet.get().tick, 0)

    def test_a_deadline_ends_the_steps(self):
        other = self.server.create_sheet("as-well", grid=(20, 20), paused=True)
        self.addCleanup(other.delete)
        with kerf.connect(support.ADDRESS, timeout_s=0.2) as hurried:
            with self.assertRaises(kerf.DeadlineExceeded):
                hurried.step([hurried.sheet(self.sheet.id), hurried.sheet(other.id)], 100_000)
        for sheet in (self.sheet, other):
            while True:  # until its last tick is done
                try:
                    before = sheet.step(1).tick
                    break
                except kerf.FailedPrecondition as refused:
                    self.assertEqual(refused.reason, "STEPPING")
            self.assertLess(before, 100_000)
            self.assertEqual(sheet.get().tick, before)


class AsyncSteps(AsyncCase):
    async def test_the_same_for_asyncio(self):
        (stepped,) = await self.server.step([self.sheet], 2, state=True)
        self.assertEqual((stepped.tick, stepped.state.state_hash), (2, (await self.sheet.get()).state_hash))
        self.assertEqual((await self.sheet.step(1, probes=[TIP])).probes["tip"].shape, (3,))


if __name__ == "__main__":
    unittest.main()
