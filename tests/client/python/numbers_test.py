"""Arrays and numbers of NumPy are taken wherever numbers or points are; and how things show themselves."""

import pickle
import unittest

import kerf
import numpy
import support
from support import AsyncCase, Case

LINE = [[-0.1, 0.3], [1.1, 0.35]]


class Arguments(Case):
    def forms(self, rows):
        """The same rows of numbers in every form and type that holds them."""
        exact = numpy.array(rows)
        yield rows
        yield [tuple(row) for row in rows]
        for kind in ("f8", "f4", ">f8"):
            yield exact.astype(kind)
        yield numpy.asfortranarray(exact)
        yield numpy.vstack([exact, exact])[: len(rows)]
        yield [exact[0], *rows[1:]]

    def test_points_of_curves(self):
        for points in self.forms(LINE):
            curve = kerf.polyline(*points)
            self.assertEqual(len(curve.polyline.points), 2)
            self.assertAlmostEqual(kerf.polyline(points).polyline.points[1].y, 0.35, places=6)
            self.assertEqual(len(kerf.Path(points[0]).line(points[1]).line(points).curve().path.subpaths[0].segments), 3)
            self.assertAlmostEqual(kerf.box(*points).box.max.x, 1.1, places=6)
            self.assertAlmostEqual(kerf.nearest(points[1]).nearest.y, 0.35, places=6)
        whole = numpy.array([[0, 0], [1, 1]])
        for kind in ("i4", "i8", "u1", "f2", "?"):
            self.assertEqual(kerf.polyline(whole.astype(kind)).polyline.points[1].x, 1)
        self.assertEqual(self.pieces_after(kerf.polyline(numpy.array(LINE, "f4"))), 2)

    def test_single_numbers(self):
        for kind in (numpy.float64, numpy.float32, numpy.float16, numpy.int32, numpy.uint8, lambda number: numpy.array(number, "f4")):
            one = kind(1)
            self.assertEqual(kerf.circle(numpy.array([0.5, 0.5], "f4"), one).circle.radius_m, 1)
            ellipse = kerf.ellipse((0.5, 0.5), one, one, rotation_deg=one).ellipse
            self.assertEqual((ellipse.semi_axis_x_m, ellipse.semi_axis_y_m), (1, 1))
            arc = kerf.Path((one, one)).arc((0, 0), one, one, rotation_deg=one).curve().path.subpaths[0].segments[0].arc
            self.assertEqual(arc.semi_axis_y_m, 1)
            self.assertEqual(kerf.wind((one, 0, 0), air_density=float(one)).velocity_mps.x, 1)
            self.assertEqual(kerf.camera((one, one, one), (0, 0, 0)).eye.z, 1)

    def test_options_of_cuts_and_views(self):
        cut = kerf.cut(kerf.circle((0.5, 0.5), 0.1), tolerance=numpy.float32(0.5), max_new_triangles=numpy.int64(100),
                       dash=numpy.array([0.25, 0.5], "f4"), fit=numpy.array([0, 0, 1, 1]), relax=numpy.bool_(False))
        self.assertEqual((cut.tolerance, cut.max_new_triangles, list(cut.dash), cut.relax), (0.5, 100, [0.25, 0.5], False))
        matrix = numpy.arange(16.0).reshape(4, 4)
        by_columns = matrix.T.ravel()
        for form in (matrix, matrix.tolist(), by_columns, by_columns.astype("f4"), by_columns.tolist()):
            view = kerf.view_of_matrices(form, form, numpy.array([640, 360]))
            self.assertEqual((list(view.view), view.width_px), (by_columns.tolist(), 640))

    def test_vertices(self):
        for ids in ((1, 2), ([1, 2],), (numpy.array([1, 2]),), (numpy.array([1, 2], "u2"),), (numpy.int64(1), 2), (range(1, 3),)):
            self.assertEqual(list(kerf.vertices(*ids).vertices.vertices), [1, 2])
        with self.assertRaises(TypeError):
            kerf.vertices(numpy.array([1.5]))

    def test_calls(self):
        self.assertEqual(self.sheet.step(numpy.int64(2)).tick, 2)
        self.sheet.grab("hand", numpy.int64(3), numpy.array([0.0, 0.1, 0.2], "f4"), numpy.float32(10))
        self.sheet.drag("hand", numpy.array([0, 0, 1]))
        self.sheet.release("hand")
        with self.sheet.holding(numpy.array([0.5, 0.5], "f4")) as hand:
            hand.move(numpy.zeros(3))
        self.sheet.set_gravity(numpy.array([0, 0, -1], "i4"))
        self.assertAlmostEqual(self.sheet.get().scene.gravity_mps2.z, -1)
        self.sheet.set_material({"density_kgpm3": numpy.float32(300)})
        made = self.server.create_sheet("", grid=numpy.array([5, 6]), size_m=numpy.array([1, 2], "f4"),
                                        parts=[(numpy.array([0, 0, 0.5, 0.5]), {"preset": "silk"})], paused=True)
        self.assertEqual(made.get().num_vertices, 30)
        made.delete()


class Showing(Case):
    def test_what_is_short(self):
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        state, frame = self.sheet.state(), next(self.sheet.watch(strains=True, probes=[kerf.probe("all", "energy")]))
        analysis = self.sheet.analyze(modes=2)
        stepped = self.sheet.step(1, state=True, probes=[kerf.probe("all", "energy")])
        for thing in (state, frame, analysis, analysis.tables["modes"], stepped, frame.probes, self.server, self.sheet):
            text = repr(thing)
            self.assertLess(len(text), 300, text)
            self.assertNotIn("\n", text)
        self.assertRegex(repr(frame), r"^Frame\(tick 0: \d+ vertices, \d+ triangles, 2 pieces\)$")
        self.assertEqual(repr(analysis.tables["modes"]), "Table('modes', 2 rows: mode, eigenvalue_per_s2, frequency_hz)")

    def test_pictures_in_notebooks(self):
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        state, frame = self.sheet.state(), next(self.sheet.watch())
        for thing in (state, frame):
            png = thing._repr_png_()
            self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(thing._repr_png_(), png)
            self.assertIn("2 pieces", thing._repr_html_())
        pixels = kerf.decode_image(state._repr_png_())
        self.assertEqual(pixels.shape, (270, 360, 3))
        drawn = (pixels != 255).any(axis=2)
        self.assertGreater(drawn.mean(), 0.3)
        self.assertGreaterEqual(len(numpy.unique(pixels[drawn], axis=0)), 2)  # a colour for each piece
        self.assertIn(self.sheet.name, self.sheet._repr_html_())
        self.assertIn("<table>", self.sheet.analyze(modes=2).tables["modes"]._repr_html_())
        gone = self.server.sheet("gone")
        self.assertIsNone(gone._repr_html_())

    def test_sheets_of_other_shapes_are_drawn(self):
        for scale in (1e-6, 1.0, 1e6):
            for axes in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
                positions = (numpy.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) * scale)[:, axes]
                state = kerf.State(0, 1, "", positions, positions, positions[:, :2], numpy.array([[0, 1, 2], [0, 2, 3]], "i4"),
                                   numpy.array([0, 0], "i4"))
                drawn = (kerf.decode_image(state._repr_png_()) != 255).any(axis=2)
                self.assertGreater(drawn.mean(), 0.5)
        empty = kerf.State(0, 1, "", positions, positions, positions[:, :2], numpy.empty((0, 3), "i4"), numpy.empty(0, "i4"))
        self.assertTrue((kerf.decode_image(empty._repr_png_()) == 255).all())

    def test_values_survive_a_pickle(self):
        values = self.sheet.measure([kerf.probe("all", "energy")])
        again = pickle.loads(pickle.dumps(values))
        self.assertEqual(dict(again), dict(values))


class AsyncShowing(AsyncCase):
    async def test_a_sheet_of_asyncio_shows_no_picture(self):
        self.assertFalse(hasattr(self.sheet, "_repr_html_"))
        self.assertEqual(repr(self.sheet), f"<kerf.Sheet {self.sheet.name}>")


if __name__ == "__main__":
    unittest.main()
