"""Streams of pictures: each of the newest tick, from where the script looks; blocking and for asyncio."""

import asyncio

import kerf
import numpy
import support
from support import Case, running, until

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

    def test_a_paused_stream_has_no_pictures_until_it_goes_on_with_the_newest(self):
        with self.sheet.watch_images((64, 64)) as images:
            first = next(images)
            images.pace(paused=True)
            waiting = running(lambda: next(images))  # whose acknowledgement comes after the pace
            for _ in range(5):
                now = self.sheet.step(1).tick
            images.pace()
            newest = waiting()
            self.assertEqual((newest.tick, newest.stats.skipped), (now, now - first.tick - 1))
            self.sheet.step(1)
            self.assertEqual(next(images).tick, now + 1)

    def test_a_rate_leaves_out_ticks_until_another_rate(self):
        with self.sheet.watch_images((64, 64)) as images:
            next(images)
            images.pace(rate_hz=0.001)
            now = self.sheet.step(1).tick
            self.assertEqual(next(images).tick, now)  # of the new rate, which allows one at once
            last = now + 20
            waiting = running(lambda: until(images, last))
            while now < last:
                now = self.sheet.step(1).tick
            images.pace()
            few = waiting()
            # One more where 1000 seconds of the server's clock were over meanwhile.
            self.assertLessEqual(len(few), 2)
            self.assertEqual(sum(image.stats.skipped + 1 for image in few), 20)

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
    async def asyncSetUp(self):
        await super().asyncSetUp()
        if (renderer := (await self.server.info()).renderer).startswith("none"):
            self.skipTest(renderer)

    async def test_pictures(self):
        async with self.sheet.watch_images((64, 48), camera=kerf.camera(**CAMERA)) as images:
            first = await images.__anext__()
            self.assertEqual((first.array().shape, first.tick), ((48, 64, 3), (await self.sheet.get()).tick))
            await self.sheet.step(20)
            self.assertEqual((await images.__anext__()).tick, (await self.sheet.get()).tick)

    async def test_a_paused_stream_has_no_pictures_until_it_goes_on_with_the_newest(self):
        async with self.sheet.watch_images((64, 64)) as images:
            await images.__anext__()
            await images.pace(paused=True)
            waiting = asyncio.ensure_future(images.__anext__())
            await asyncio.sleep(0)  # it acknowledges, after the pace
            for _ in range(5):
                now = (await self.sheet.step(1)).tick
            await images.pace()
            self.assertEqual((await waiting).tick, now)
