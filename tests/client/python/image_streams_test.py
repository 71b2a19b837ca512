"""Streams of pictures: each of the newest tick, from where the script looks; blocking and for asyncio."""

import kerf
import numpy
import support
from support import Case

CAMERA = dict(eye=(0.5, -2, 0.5), target=(0.5, 0, 0.5))


class Streaming(Case):
    def setUp(self):
        super().setUp()
        self.needs_renderer()
        self.camera = kerf.camera(**CAMERA)

    def test_pictures_are_those_of_render(self):
        with self.sheet.watch_images((96, 64), codec="png", camera=self.camera) as images:
            image = next(images)
        self.assertEqual((image.tick, image.codec, image.key, image.size_px), (self.sheet.get().tick, "png", True, (96, 64)))
        self.assertEqual(image.camera.target, self.camera.target)
        rendered = kerf.decode_image(self.sheet.render((96, 64), camera=self.camera))
        numpy.testing.assert_array_equal(image.array(), rendered)

    def test_a_slow_loop_skips_ticks_and_never_lags(self):
        with self.sheet.watch_images((64, 64)) as images:
            self.assertEqual(next(images).data[:2], b"\xff\xd8")
            for _ in range(3):
                now = self.sheet.step(20).tick
                image = next(images)
                self.assertEqual((image.tick, image.codec), (now, "jpeg"))
                self.assertEqual(image.array().shape, (64, 64, 3))

    def test_looking_from_elsewhere(self):
        with self.sheet.watch_images((64, 64), codec="png", camera=self.camera) as images:
            before = next(images).array()
            images.look((80, 48), camera=kerf.camera((1.5, -1.5, 0.5), (0.5, 0, 0.5)), wireframe=True)
            after = next(images)
            self.assertEqual(after.size_px, (80, 48))
            self.assertNotEqual(after.array().shape, before.shape)

    def test_colours(self):
        self.sheet.cut(kerf.polyline((0.5, -0.1), (0.5, 1.1)))

        def halves(color_by):
            with self.sheet.watch_images((96, 96), codec="png", camera=self.camera, color_by=color_by) as images:
                picture = next(images).array().astype(int)
            return abs(picture[48, 36] - picture[48, 60]).max()

        self.assertLess(halves("sides"), halves("pieces"))

    def test_a_dark_backdrop_and_the_scale_of_strains(self):
        self.sheet.step(5)
        options = {"camera": self.camera, "color_by": "strains", "dark": True}
        with self.sheet.watch_images((64, 64), codec="png", **options) as images:
            dark = next(images)
            self.assertGreater(dark.strain_end, 0)
            self.assertLess(dark.array()[1, 1].max(), 60)
            images.look((64, 64), camera=self.camera)
            light = next(images)
            self.assertEqual(light.strain_end, 0)
            self.assertGreater(light.array()[1, 1].min(), 200)

    def test_vp8(self):
        with self.sheet.watch_images((64, 64), codec="vp8", bitrate_kbps=200) as images:
            try:
                first = next(images)
            except kerf.Unavailable as none:
                self.skipTest(str(none))
            self.sheet.step(1)
            second = next(images)
        self.assertEqual((first.codec, first.key, second.key), ("vp8", True, False))

    def test_how_streams_end(self):
        images = self.sheet.watch_images((64, 64))
        next(images)
        images.close()
        self.assertEqual(list(images), [])
        with self.assertRaises(kerf.NotFound):
            next(self.server.sheet("py-nobody").watch_images())
        with self.assertRaises(kerf.InvalidArgument) as caught:
            next(self.sheet.watch_images((9, 64)))
        self.assertEqual(caught.exception.reason, "OUT_OF_RANGE")


class Asynchronous(support.AsyncCase):
    async def test_pictures(self):
        if (await self.server.info()).renderer.startswith("none"):
            self.skipTest("no renderer")
        async with self.sheet.watch_images((64, 48), camera=kerf.camera(**CAMERA)) as images:
            first = await images.__anext__()
            self.assertEqual((first.array().shape, first.tick), ((48, 64, 3), (await self.sheet.get()).tick))
            await self.sheet.step(20)
            self.assertEqual((await images.__anext__()).tick, (await self.sheet.get()).tick)
