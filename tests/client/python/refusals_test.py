"""Refusals: by the server, and before anything is sent."""

import asyncio
import copy
import math
import pickle

import kerf
import kerf.aio
import support
from support import Case, closed_port


class Refusals(Case):
    def test_each_names_code_reason_and_field(self):
        circle = kerf.circle((0.5, 0.5), 0.1)
        snake = kerf.bezier((0.2, 0.5), (0.4, 0.8), (0.6, 0.2), (0.8, 0.5))
        for reason, field, curve, options in (
                ("RADIUS_NOT_POSITIVE", "cut.curve.circle.radius_m", kerf.circle((0.5, 0.5), -1), {}),
                ("CURVE_NOT_FINITE", "cut.curve.polyline.points[1].x", kerf.polyline((0, 0), (math.nan, 1)), {}),
                ("CURVE_WEIGHT", "cut.curve.path.subpaths[0].segments[0].quadratic.weights[1]",
                 kerf.rational((0, 0, 1), (1, 1, 0), (1, 0, 1)), {}),
                ("SVG_MALFORMED", "cut.curve.svg", kerf.svg("<svg><g></svg>"), {}),
                ("OUT_OF_RANGE", "cut.tolerance", circle, {"tolerance": 9}),
                ("TOLERANCE_TOO_SMALL", "cut.curve", snake, {"tolerance_m": 1e-9}),
                ("FIT_EMPTY", "cut.fit.max.x", circle, {"fit": (0, 0, 0, 1)}),
                ("CAMERA_SINGULAR", "cut.view.camera.up", circle, {"view": kerf.view(kerf.camera((0, 0, 0), (0, 0, 0)))})):
            with self.subTest(reason=reason):
                self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", reason, field, self.sheet.cut, curve, **options)
        self.refused(kerf.ResourceExhausted, "RESOURCE_EXHAUSTED", "CUT_ELEMENT_BUDGET", "cut",
                     self.sheet.cut, circle, max_new_triangles=1)
        self.refused(kerf.ResourceExhausted, "RESOURCE_EXHAUSTED", "CUT_ELEMENT_BUDGET", "cuts[1]",
                     self.sheet.cut_all, [circle, kerf.cut(kerf.circle((0.2, 0.2), 0.1), max_new_triangles=1)])
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "NOTHING_TO_UNDO", "", self.sheet.undo)
        self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "NOTHING_TO_REDO", "", self.sheet.redo)
        self.refused(kerf.NotFound, "NOT_FOUND", "SHEET_NOT_FOUND", "name", self.server.sheet("nobody").get)
        self.refused(kerf.AlreadyExists, "ALREADY_EXISTS", "SHEET_EXISTS", "sheet_id",
                     self.server.create_sheet, self.sheet.id)

    def test_misuse_is_told_before_anything_is_sent(self):
        circle = kerf.circle((0.5, 0.5), 0.1)
        with self.assertRaisesRegex(TypeError, "no option 'tolerence'; there are tolerance, "):
            self.sheet.cut(circle, tolerence=0.1)
        with self.assertRaisesRegex(TypeError, "kerf.cut"):
            self.sheet.cut(kerf.cut(circle), tolerance=0.1)
        with self.assertRaisesRegex(TypeError, "not str"):
            self.sheet.cut("M0 0L1 1")
        with self.assertRaisesRegex(ValueError, "method is 'best'; must be one of neighbourhood, element"):
            self.sheet.cut(circle, method="best")
        with self.assertRaisesRegex(ValueError, "fit is 'page'"):
            self.sheet.cut(circle, fit="page")
        with self.assertRaisesRegex(ValueError, "must be one of nearest, all, one_piece, depth_range"):
            kerf.view(kerf.camera((0, 0, 1), (0, 0, 0)), layers="some")

    def test_a_miss_is_no_error(self):
        result = self.sheet.cut(kerf.circle((7, 7), 1))
        self.assertEqual((result.status, result.pieces, result.name), (kerf.NO_INTERSECTION, 1, ""))

    def test_a_second_cut_beside_a_first_tells_of_the_gap_closed(self):
        first = self.sheet.cut(kerf.polyline((0.2, 0.43), (0.8, 0.43)))
        self.assertEqual((first.closed_gaps, first.widest_gap_m, first.merged_segments), (0, 0.0, 0))
        second = self.sheet.cut(kerf.polyline((0.2, 0.43001), (0.8, 0.43001)))
        self.assertEqual(second.status, kerf.NO_INTERSECTION)
        self.assertGreater(second.closed_gaps, 0)
        self.assertAlmostEqual(second.widest_gap_m, 1e-5, delta=1e-7)

    def test_no_server(self):
        with kerf.connect(closed_port()) as nobody, self.assertRaises(kerf.Unavailable) as caught:
            nobody.info()
        self.assertEqual((caught.exception.code, caught.exception.reason), ("UNAVAILABLE", ""))
        self.assertIn(f"no Kerf server answers at {closed_port()}", str(caught.exception))

    def test_refusals_can_be_pickled_and_copied(self):
        with self.assertRaises(kerf.InvalidArgument) as caught:
            self.sheet.cut(kerf.circle((0.5, 0.5), -1))
        full = kerf.ResourceExhausted("RESOURCE_EXHAUSTED", "QUEUE_FULL", "64 wait", "cut", metadata={"limit": "64"}, retry_after_s=0.1)
        for error in (caught.exception, full):
            for again in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
                self.assertIs(type(again), type(error))
                self.assertEqual((str(again), vars(again)), (str(error), vars(error)))

    def test_a_server_without_such_a_call(self):
        missing = self.server._channel.unary_unary("/kerf.v1.SheetService/FoldSheet", bytes, bytes)
        with self.assertRaisesRegex(kerf.Error, "has no such call: it is older than this package") as caught:
            self.server.call(missing, b"")
        self.assertEqual(caught.exception.code, "UNIMPLEMENTED")

    def test_what_grpc_refuses_as_too_large_is_told_how_to_send(self):
        # A cut of 4096 points, and so often that they are more than 1 MiB: refused before any of Kerf sees it.
        long = kerf.polyline(*((0.1 + index / 10000, 0.5) for index in range(4096)))
        says = "larger than max.*: send less in one call, for example a batch of cuts in parts, or a mesh file as an upload"
        too_large = self.refused(kerf.ResourceExhausted, "RESOURCE_EXHAUSTED", "MESSAGE_TOO_LARGE", "",
                                 self.sheet.cut_all, [long] * 15)
        self.assertRegex(too_large.message, says)
        self.assertIsNone(too_large.retry_after_s)  # it would be too large again

        async def from_asyncio():
            async with kerf.aio.connect(support.ADDRESS) as server:
                await server.sheet(self.sheet.id).cut_all([long] * 15)

        with self.assertRaisesRegex(kerf.ResourceExhausted, says) as caught:
            asyncio.run(from_asyncio())
        self.assertEqual(caught.exception.reason, "MESSAGE_TOO_LARGE")

    def test_a_busy_server_says_when_to_try_again(self):
        # More calls than may wait for their tick.
        far = self.sheet.get().tick + 1000
        with self.assertRaises(kerf.ResourceExhausted) as caught:
            for _ in range(100):
                self.sheet.cut(kerf.circle((0.5, 0.5), 0.1), at_tick=far)
        self.assertGreater(caught.exception.retry_after_s, 0)
        self.assertIn("may work in", str(caught.exception))

    def test_a_time_limit(self):
        with kerf.connect(support.ADDRESS, timeout_s=0.0001) as hasty, self.assertRaises(kerf.DeadlineExceeded):
            hasty.sheet(self.sheet.id).step(100000)
