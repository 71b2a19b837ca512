"""Undo, batches, lists of cuts, cuts that wait for their tick."""

import pathlib
import subprocess

import kerf
import support
from support import Case, path


class Lists(Case):
    def test_undo_and_redo(self):
        result = self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        ids = [piece.id for piece in self.sheet.pieces()]
        self.assertEqual(len(ids), 2)
        self.assertEqual(sum(piece.parent for piece in self.sheet.pieces()), 2)
        undone = self.sheet.undo()
        self.assertEqual((undone.pieces, list(undone.cuts)), (1, [result.name]))
        self.assertEqual(self.sheet.cuts(), [])
        self.assertEqual(self.sheet.redo().pieces, 2)
        self.assertEqual([piece.id for piece in self.sheet.pieces()], ids)

    def test_a_batch_is_one_step(self):
        line = kerf.polyline((-0.1, 0.4), (1.1, 0.6))
        done = self.sheet.cut_all([line, kerf.cut(kerf.circle((0.3, 0.2), 0.1), tolerance=0.01), kerf.circle((7, 7), 1)])
        self.assertEqual((done.status, done.applied, done.pieces, len(done.results)), (kerf.APPLIED, 2, 3, 3))
        self.assertEqual([entry.cut.tolerance for entry in self.sheet.cuts()], [0.02, 0.01])
        self.assertEqual(self.sheet.undo().pieces, 1)

    def test_more_pieces_and_cuts_than_a_page(self):
        holes = [kerf.circle((0.02 + 0.96 * (i % 33) / 32, 0.02 + 0.96 * (i // 33) / 32), 0.004) for i in range(1024)]
        self.assertEqual(self.sheet.cut_all(holes).applied, 1024)
        self.assertEqual(len(self.sheet.pieces()), 1025)
        self.assertEqual(len(self.sheet.cuts()), 1024)

    def test_cuts_are_carried_to_another_sheet(self):
        self.sheet.cut(kerf.circle((0.3, 0.7), 0.1))
        self.sheet.cut(kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5)), quality="fine")
        self.sheet.cut(kerf.polyline((-0.1, 0.3), (1.1, 0.35)))
        self.sheet.undo()
        self.assertEqual(self.sheet.export_cuts(path("cuts.json")), 2)
        other = self.server.create_sheet("py-other", grid=(20, 20), paused=True)
        self.addCleanup(other.delete)
        self.assertEqual(other.apply_cuts(path("cuts.json")).applied, 2)
        self.assertEqual(other.get().num_triangles, self.sheet.get().num_triangles)
        # The same file as the shell's.
        def exported_by_shell(sheet):
            subprocess.run([support.OPTIONS.kerf, "--server", support.ADDRESS, "cuts", sheet.id, "--export", path("shell.json")], check=True)
            return kerf.load_cuts(path("shell.json"))
        self.assertEqual(exported_by_shell(self.sheet), kerf.load_cuts(path("cuts.json")))
        other.undo()
        self.assertEqual(other.cut_all(exported_by_shell(self.sheet)).applied, 2)
        pathlib.Path(path("none.json")).write_text('{"cuts": [{"curve": {"spline": 1}}]}')
        with self.assertRaisesRegex(ValueError, "none.json.*spline"):
            other.apply_cuts(path("none.json"))
        with self.assertRaises(FileNotFoundError):
            other.apply_cuts(path("absent.json"))

    def test_scheduled_cuts(self):
        tick = self.sheet.get().tick
        result = self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), at_tick=tick + 2)
        self.assertEqual((result.status, result.tick), (kerf.SCHEDULED, tick + 2))
        self.sheet.cut_all([kerf.cut(kerf.circle((0.2, 0.2), 0.1), max_new_triangles=1)], at_tick=tick + 2)
        self.assertEqual([waiting.tick for waiting in self.sheet.waiting()], [tick + 2, tick + 2])
        other = self.sheet.cut(kerf.circle((0.5, 0.5), 0.3), at_tick=tick + 2).scheduled_name
        self.assertEqual(self.sheet.waiting()[-1].name, other)
        self.assertEqual(self.sheet.cancel(other).cuts[0].curve.circle.radius_m, 0.3)
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "SCHEDULED_CUTS_SETTLED", "", self.sheet.cancel, other)
        self.assertEqual([self.sheet.step().pieces, self.sheet.step().pieces], [1, 2])
        self.assertEqual(self.sheet.waiting(), [])
        refused = self.sheet.refused()
        self.assertEqual([(each.tick, each.reason) for each in refused], [(tick + 2, "CUT_ELEMENT_BUDGET")])
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "TICK_PAST", "at_tick",
                     self.sheet.cut, kerf.circle((0.5, 0.5), 0.2), at_tick=tick + 2)

    def test_a_repeated_request_cuts_once(self):
        first = self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), request_id="once")
        self.assertEqual(self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), request_id="once"), first)
        self.assertEqual(len(self.sheet.cuts()), 1)
