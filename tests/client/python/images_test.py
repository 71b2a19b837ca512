"""Pictures: one by one, as arrays, coloured; and where there is no Pillow."""

import unittest
from unittest import mock

import kerf
from kerf import images
from kerf.v1 import render_pb2
from support import Case


class Pictures(Case):
    def setUp(self):
        super().setUp()
        self.needs_renderer()

    def test_files_of_both_formats(self):
        picture = self.sheet.render((320, 200), wireframe=True)
        self.assertEqual(picture[:8], b"\x89PNG\r\n\x1a\n")
        near = self.sheet.render((64, 64), camera=kerf.camera((0.5, -1, 0.5), (0.5, 0, 0.5)), format="jpeg")
        self.assertEqual(near[:2], b"\xff\xd8")
        self.assertNotEqual(self.sheet.render((64, 64), undeformed=True), self.sheet.render((64, 64)))
        self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", "OUT_OF_RANGE", "width_px", self.sheet.render, (9, 9))
        with self.assertRaisesRegex(ValueError, "format is 'gif'; must be one of png, jpeg"):
            self.sheet.render(format="gif")

    def test_arrays(self):
        camera = kerf.camera((0.5, -2, 0.5), (0.5, 0, 0.5))
        png = kerf.decode_image(self.sheet.render((96, 64), camera=camera))
        jpeg = kerf.decode_image(self.sheet.render((96, 64), camera=camera, format="jpeg", jpeg_quality=95))
        self.assertEqual((png.shape, str(png.dtype), jpeg.shape), ((64, 96, 3), "uint8", (64, 96, 3)))
        self.assertLess(abs(png.astype(int) - jpeg).mean(), 6)
        # The sheet is in the middle; the corner shows something else.
        self.assertGreater(abs(png[32, 48].astype(int) - png[2, 2]).max(), 20)
        self.assertGreater(png[2, 2].min(), 200)
        dark = kerf.decode_image(self.sheet.render((96, 64), camera=camera, dark=True))
        self.assertLess(dark[2, 2].max(), 60)

    def test_colours_of_pieces(self):
        self.sheet.cut(kerf.polyline((0.5, -0.1), (0.5, 1.1)))
        camera = kerf.camera((0.5, -2, 0.5), (0.5, 0, 0.5))

        def halves(color_by):
            picture = kerf.decode_image(self.sheet.render((96, 96), camera=camera, color_by=color_by)).astype(int)
            return abs(picture[48, 36] - picture[48, 60]).max()

        self.assertGreater(halves("pieces"), 40)
        with self.assertRaisesRegex(ValueError, "color_by is 'age'; must be one of sides, pieces, strains"):
            self.sheet.render(color_by="age")


class Decoding(unittest.TestCase):
    def image(self, codec, data):
        return images.image_of(render_pb2.Image(tick=3, codec=codec, key=True, width_px=4, height_px=2, data=data))

    def test_what_is_no_picture(self):
        with self.assertRaisesRegex(ValueError, "these 4 bytes are not a PNG or JPEG picture"):
            kerf.decode_image(b"Kerf")
        image = self.image(render_pb2.IMAGE_VP8, b"\x01")
        self.assertEqual((image.tick, image.codec, image.size_px), (3, "vp8", (4, 2)))
        with self.assertRaisesRegex(ValueError, "a VP8 frame is not a picture by itself"):
            image.array()
        with self.assertRaisesRegex(ValueError, "codec is 'gif'; must be one of jpeg, png, vp8"):
            images.codec_value("gif")

    def test_without_pillow(self):
        with mock.patch.dict("sys.modules", {"PIL.Image": None}):
            with self.assertRaisesRegex(ImportError, "apt install python3-pil"):
                kerf.decode_image(b"Kerf")
