"""Kerf from asyncio: the same as the package kerf, except that calls to the server are awaited.

    import asyncio, kerf, kerf.aio

    async def main():
        async with kerf.aio.connect("127.0.0.1:50051") as server:
            flag = await server.create_sheet("flag", grid=(60, 40), size_m=(1.5, 1.0), pins=["corners"])
            print((await flag.cut(kerf.circle((0.5, 0.5), 0.2))).pieces)
            async for frame in flag.watch(rate_hz=10):
                print(frame.tick, frame.positions.mean(axis=0))

    asyncio.run(main())

Connect inside a running loop. Curves, cuts, regions, errors and all else that does not call a server are in kerf.
client/python/make_blocking makes kerf.blocking from the modules here.
"""

from kerf.aio.client import Server, connect
from kerf.aio.interaction import Hand
from kerf.aio.recorder import Recorder
from kerf.aio.sheet import Sheet
from kerf.aio.streams import FrameStream, ImageStream, Subscription

__all__ = [
    "FrameStream",
    "Hand",
    "ImageStream",
    "Recorder",
    "Server",
    "Sheet",
    "Subscription",
    "connect",
]
