"""The same from asyncio: each kind of call and stream once; package_test compares the two surfaces."""

import asyncio
import socket

import kerf
import kerf.aio
import support
from support import closed_port, path


class Asynchronous(support.AsyncCase):
    async def test_calls(self):
        self.assertIn(self.sheet.id, [sheet.id for sheet in await self.server.sheets()])
        result = await self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        self.assertEqual((result.pieces, len(await self.sheet.pieces()), len(await self.sheet.cuts())), (2, 2, 1))
        self.assertEqual((await self.sheet.undo()).pieces, 1)
        self.assertEqual((await self.sheet.step(3)).state_hash, (await self.sheet.state()).state_hash)
        self.assertEqual((await self.sheet.analyze(modes=2)).tables["modes"].values.shape, (2, 3))
        with self.assertRaises(kerf.InvalidArgument) as caught:
            await self.sheet.cut(kerf.circle((0.5, 0.5), -1))
        self.assertEqual(caught.exception.field, "cut.curve.circle.radius_m")
        async with kerf.aio.connect(closed_port()) as nobody:
            with self.assertRaisesRegex(kerf.Unavailable, f"no Kerf server answers at {closed_port()}"):
                await nobody.info()

    async def test_calls_at_once(self):
        async def cut_one(index):
            async with self.server.temporary_sheet(grid=(10, 10), paused=True) as sheet:
                return (await sheet.cut(kerf.circle((0.5, 0.5), 0.1 + 0.01 * index))).pieces

        self.assertEqual(await asyncio.gather(*map(cut_one, range(8))), [2] * 8)

    async def test_hands(self):
        async with self.sheet.holding(0, (0.0, 0.3, 0.0)) as hand:
            await self.sheet.step(10)
            await hand.move((0.0, 0.4, 0.0))
        with self.assertRaises(kerf.NotFound):
            await self.sheet.release(hand.grab_id)

    async def test_frames(self):
        async with self.sheet.watch(strains=True) as frames:
            first = await frames.__anext__()
            await self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
            second = await frames.__anext__()
            self.assertEqual(second.topology_version, first.topology_version + 1)
            await self.sheet.step(20)
            third = await frames.__anext__()
            self.assertEqual((third.tick, third.stats.skipped), ((await self.sheet.get()).tick, 19))
            waiting = asyncio.ensure_future(frames.__anext__())
            await asyncio.sleep(0)
            await frames.aclose()
            with self.assertRaises(StopAsyncIteration):
                await waiting
        self.assertEqual([frame.tick async for frame in self.sheet.watch(duration_s=0.2)], [third.tick])
        self.assertEqual([frame.tick async for frame in self.sheet.subscribe(max_frames=1)], [third.tick])

    async def test_a_subscription(self):
        frames = self.sheet.subscribe(rate_hz=10)
        first = await frames.__anext__()
        for _ in range(2):
            now = (await self.sheet.step(20)).tick
            async for frame in frames:
                if frame.tick == now:
                    break
            # Each has all there is.
            self.assertTrue((abs(frame.positions - (await self.sheet.state()).positions) <= frame.resolution / 2 + 1e-12).all())
        self.assertGreater(now, first.tick)
        waiting = asyncio.ensure_future(frames.__anext__())
        await asyncio.sleep(0)
        await frames.aclose()
        with self.assertRaises(StopAsyncIteration):
            await waiting
        self.assertEqual([frame async for frame in frames], [])
        with self.assertRaises(kerf.NotFound):
            await self.server.sheet("py-aio-nobody").subscribe().__anext__()
        other = await self.server.create_sheet("py-aio-subscribed", grid=(4, 4), paused=True)
        async with other.subscribe() as frames:
            await frames.__anext__()
            await other.delete()
            with self.assertRaises(kerf.NotFound) as caught:
                await frames.__anext__()
        self.assertEqual(caught.exception.reason, "SHEET_DELETED")

    async def test_a_cancelled_task_stays_cancelled(self):
        frames = self.sheet.watch()
        await frames.__anext__()
        waiting = asyncio.ensure_future(frames.__anext__())
        await asyncio.sleep(0)
        waiting.cancel()
        with self.assertRaises(asyncio.CancelledError):
            await waiting
        await frames.aclose()

    async def test_a_wait_that_ran_out_loses_nothing(self):
        async with self.sheet.watch() as frames:
            first = await frames.__anext__()
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(frames.__anext__(), 0.2)
            await self.sheet.step(1)
            self.assertEqual((await frames.__anext__()).tick, first.tick + 1)

    async def test_a_connection_that_is_closed_ends_the_loops_of_others(self):
        other = kerf.aio.connect(support.ADDRESS)
        frames = other.sheet(self.sheet.id).watch()
        await frames.__anext__()
        waiting = asyncio.ensure_future(frames.__anext__())
        await asyncio.sleep(0.1)
        await other.aclose()
        with self.assertRaisesRegex(kerf.Error, "was closed") as caught:
            await waiting
        self.assertEqual(caught.exception.code, "CANCELLED")
        await frames.aclose()

    async def test_nobody_answers(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            async with kerf.aio.connect(f"127.0.0.1:{silent.getsockname()[1]}") as server:
                with self.assertRaisesRegex(kerf.Unavailable, "no Kerf server answers"):
                    await server.sheet("a").watch(duration_s=0.3).__anext__()

    async def test_a_hand_is_let_go_of_with_its_sheet(self):
        other = await self.server.create_sheet("py-aio-held", grid=(4, 4), paused=True)
        with self.assertRaisesRegex(ValueError, "of the user"):
            async with other.holding(0):
                await other.delete()
                raise ValueError("of the user")
        async with self.sheet.holding(0):
            await self.sheet.reset()

    async def test_recorder(self):
        async with self.sheet.recorder(path("aio.npz")) as recorder:
            last = await self.sheet.step(5)
        run = kerf.load_run(path("aio.npz"))
        self.assertEqual((len(run), run[-1].tick), (recorder.num_frames, last.tick))

    async def test_deleted_sheet(self):
        other = await self.server.create_sheet("py-aio-gone", grid=(4, 4), paused=True)
        frames = other.watch()
        await frames.__anext__()
        await other.delete()
        with self.assertRaises(kerf.NotFound):
            await frames.__anext__()
