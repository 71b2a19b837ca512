"""Streams that a server broke off because it could not write to them: over connections whose windows do not grow, unread
frames soon fill them."""

import asyncio
import time
import unittest
import unittest.mock
import urllib.request

import kerf
import kerf.aio
import support
from kerf.channel_options import CHANNEL_OPTIONS

# A connection for each, so that none takes the window of another.
NARROW = [*CHANNEL_OPTIONS, ("grpc.http2.bdp_probe", 0), ("grpc.use_local_subchannel_pool", 1)]


class CutOff(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        self.process, self.address = support.start_server()
        self.addCleanup(support.stop_server, self.process)
        self.sheet = self.connect().create_sheet("large", grid=(200, 200), paused=True)

    def connect(self):
        server = kerf.connect(self.address)
        self.addCleanup(server.close)
        return server

    def narrow(self):
        with unittest.mock.patch("kerf.transport.CHANNEL_OPTIONS", NARROW):
            return self.connect().sheet("large")

    def aio_narrow(self):
        with unittest.mock.patch("kerf.aio.transport.CHANNEL_OPTIONS", NARROW):
            server = kerf.aio.connect(self.address)
        self.addAsyncCleanup(server.aclose)
        return server.sheet("large")

    def step_until_no_streams(self, gauge="kerf_watch_streams"):
        direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        deadline = time.monotonic() + 60
        while True:
            self.sheet.step(1)
            with direct.open(self.process.http + "/metrics") as metrics:
                if f"\n{gauge} 0\n" in metrics.read().decode():
                    return
            self.assertLess(time.monotonic(), deadline, "there still are streams that nobody reads")
            time.sleep(0.1)

    async def asyncSetUp(self):
        asyncio.get_running_loop().slow_callback_duration = 60  # most calls here block

    async def test_frames_go_on_and_subscriptions_say_why_they_do_not(self):
        frames = self.narrow().watch(window=8, duration_s=120)
        aio_frames = self.aio_narrow().watch(window=8, duration_s=120)
        subscription, aio_subscription = self.narrow().subscribe(rate_hz=10), self.aio_narrow().subscribe(rate_hz=10)
        first, aio_first = next(frames), await aio_frames.__anext__()
        next(subscription)
        await aio_subscription.__anext__()
        streams = (frames._stream, aio_frames._stream)
        self.step_until_no_streams()  # nothing is read for 10 seconds
        now = self.sheet.step(5).tick
        # Whole frames that had come before may still be first.
        second = next(frame for frame in frames if frame.tick >= now)
        async for aio_second in aio_frames:
            if aio_second.tick >= now:
                break
        for before, after in ((first, second), (aio_first, aio_second)):
            self.assertEqual((after.tick, after.topology_changed), (now, False))
            self.assertIs(after.triangles, before.triangles)  # what it had was asked for no more
        self.assertIsNot(frames._stream, streams[0])
        self.assertIsNot(aio_frames._stream, streams[1])
        self.sheet.step(1)
        self.assertEqual((next(frames).tick, (await aio_frames.__anext__()).tick), (now + 1, now + 1))
        with self.assertRaisesRegex(kerf.Unavailable, "was not read in time") as caught:
            list(subscription)
        with self.assertRaisesRegex(kerf.Unavailable, "was not read in time") as aio_caught:
            async for _ in aio_subscription:
                pass
        self.assertEqual((caught.exception.reason, aio_caught.exception.reason), ("TOO_SLOW", "TOO_SLOW"))
        frames.close()
        await aio_frames.aclose()

    async def test_pictures_go_on_as_they_were_last_asked_for(self):
        if (renderer := self.connect().info().renderer).startswith("none"):
            self.skipTest(renderer)
        options = {"codec": "png", "window": 8, "duration_s": 120}
        images = self.narrow().watch_images((64, 48), **options)
        aio_images = self.aio_narrow().watch_images((64, 48), **options)
        next(images)
        await aio_images.__anext__()
        images.look((800, 600))
        await aio_images.look((800, 600))
        streams = (images._stream, aio_images._stream)
        self.step_until_no_streams("kerf_image_streams")
        now = self.sheet.step(5).tick
        # Whole pictures that had come before may still be first.
        image = next(image for image in images if image.tick >= now)
        async for aio_image in aio_images:
            if aio_image.tick >= now:
                break
        for after in (image, aio_image):
            self.assertEqual((after.tick, after.size_px, after.array().shape), (now, (800, 600), (600, 800, 3)))
        self.assertIsNot(images._stream, streams[0])
        self.assertIsNot(aio_images._stream, streams[1])
        self.sheet.step(1)
        self.assertEqual((next(images).tick, (await aio_images.__anext__()).tick), (now + 1, now + 1))
        images.close()
        await aio_images.aclose()
