"""Looking at a sheet: frames as arrays, pictures, files."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Literal, Optional, Tuple

from kerf.aio.part import SheetPart
from kerf.aio.recorder import Recorder
from kerf.aio.streams import FrameStream, ImageStream, Subscription
from kerf.aio.transport import Stream
from kerf.cuts import enum_value
from kerf.files import whole_file
from kerf.images import Codec, ColorBy, codec_value, image_view
from kerf.probes import AnyProbe, as_probes
from kerf.v1 import geometry_pb2, render_pb2, sheets_pb2, stream_pb2


class Viewing(SheetPart):
    """Looks."""

    def watch(
        self,
        *,
        rate_hz: float = 0.0,
        window: int = 1,
        strains: bool = False,
        probes: Iterable[AnyProbe] = (),
        duration_s: Optional[float] = None,
        reconnect_s: float = 0.0,
    ) -> FrameStream:
        """Streams frames as NumPy arrays, each the newest when the loop asks for it: a slow loop skips ticks and never
        lags behind.

        rate_hz: most frames a second, 0.001..1000; 0: every tick. window: frames sent and not acknowledged, 1..8.
        With 1 a frame is sent when the loop asks for it; more keep a fast loop busy over a slow connection; 0: the
        server chooses. strains: frames have the strains of the vertices. probes: up to 64 of kerf.probe(), measured on
        the sheet of each frame; Frame.probes has the values. duration_s: the stream ends after this
        time, with Unavailable if no frame came. None: it ends when closed, with NotFound if the sheet is deleted, or
        with Unavailable if the server stops. reconnect_s: how long to retry a lost server; a restarted one continues
        with a keyframe, and its ticks begin again. A paused sheet gives a frame when something changes. Needs NumPy.

        >>> async with sheet.watch(rate_hz=30, strains=True) as frames:
        ...     async for frame in frames:
        ...         print(frame.positions.shape, frame.strains.shape, frame.topology_changed)
        ...         break
        (400, 3) (400,) True
        >>> async with sheet.watch(probes=[kerf.probe("pull", "reaction", place="top")]) as frames:
        ...     async for frame in frames:
        ...         print(frame.probes["pull.z"] >= 0)
        ...         break
        True
        """
        start = stream_pb2.WatchStart(
            name=self.name,
            window=window,
            max_rate_hz=rate_hz,
            encoding=stream_pb2.RAW,
            strains=strains,
            probes=as_probes(probes),
        )
        return FrameStream(self._server.stream_service.Watch, self._server.address, start, duration_s, reconnect_s)

    def subscribe(self, *, rate_hz: float = 1.0, max_frames: int = 0) -> Subscription:
        """Streams frames at a low rate, 0.001..10 Hz, without acknowledgements: unread frames wait, so that a slow loop
        lags behind. Use it for steady logging, and watch() for all else. max_frames: the stream ends after this
        many; 0: no limit.

        >>> async for frame in sheet.subscribe(max_frames=1):
        ...     frame.positions.shape
        (400, 3)
        """
        request = stream_pb2.SubscribeRequest(name=self.name, max_rate_hz=rate_hz, max_frames=max_frames)
        return Subscription(self._server.stream_service.Subscribe, self._server.address, request)

    def watch_images(
        self,
        size_px: Tuple[int, int] = (640, 360),
        *,
        codec: Codec = "jpeg",
        camera: Optional[geometry_pb2.Camera] = None,
        rate_hz: float = 0.0,
        window: int = 1,
        wireframe: bool = False,
        undeformed: bool = False,
        color_by: ColorBy = "sides",
        jpeg_quality: int = 0,
        bitrate_kbps: int = 0,
        dark: bool = False,
        duration_s: Optional[float] = None,
        reconnect_s: float = 0.0,
    ) -> ImageStream:
        """Streams pictures that the server draws, each of the newest tick when the loop asks for it; skipped ticks are
        not drawn.

        size_px: 16..4096 each. codec: "jpeg", "png", or "vp8", which has a tenth of the bytes but needs a decoder in
        the program. camera: see kerf.camera(); absent: shows the whole sheet. wireframe, undeformed, color_by, dark:
        as in render(). jpeg_quality: 1..100, 0: 80. bitrate_kbps: of VP8, 50..50000; 0: chosen by the size. The rest
        is as in watch(). Raises Unavailable if the server has no renderer.
        """
        view = image_view(size_px, camera, wireframe, undeformed, color_by, jpeg_quality, bitrate_kbps, dark)
        start = render_pb2.WatchImagesStart(
            name=self.name, window=window, max_rate_hz=rate_hz, codec=codec_value(codec), view=view
        )
        return ImageStream(self._server.render_service.WatchImages, self._server.address, start, duration_s, reconnect_s)

    def recorder(self, path: "str | os.PathLike[str]", *, rate_hz: float = 0.0, strains: bool = False) -> Recorder:
        """Records frames into an .npz file while a `with` lasts; kerf.load_run() reads the file.

        rate_hz, strains: as in watch(). The last frame of the file is of the tick at which the `with` was left, or
        later. Ticks that passed faster than they could be sent are left out: `ticks` of the run lists those
        recorded. Raises OSError if the file cannot be written. After an exception inside the `with` the file has the
        frames until then; without any frame, an earlier file stays.

        >>> async with sheet.recorder(path):
        ...     stepped = await sheet.step(30)
        >>> kerf.load_run(path)[-1].tick == stepped.tick
        True
        """
        return Recorder(self.watch(rate_hz=rate_hz, strains=strains), path, self._tick)

    async def render(
        self,
        size_px: Tuple[int, int] = (640, 360),
        *,
        camera: Optional[geometry_pb2.Camera] = None,
        wireframe: bool = False,
        undeformed: bool = False,
        color_by: ColorBy = "sides",
        format: Literal["png", "jpeg"] = "png",
        jpeg_quality: int = 0,
        dark: bool = False,
    ) -> bytes:
        """Returns a picture of the sheet, drawn by the server, as the bytes of a file. Raises Unavailable if the server
        has no renderer.

        size_px: 16..4096 each. camera: see kerf.camera(); absent: shows the whole sheet. undeformed: shows the sheet
        flat with its cuts, at the material coordinates x, y, 0. color_by: "sides" (woven, front and back differ),
        "pieces" or "strains". jpeg_quality: 1..100, 0: 85. dark: draws before a dark background. kerf.decode_image()
        converts the bytes to an array.

        >>> (await sheet.render((64, 48)))[:4]
        b'\\x89PNG'
        """
        request = render_pb2.RenderImageRequest(
            name=self.name,
            width_px=size_px[0],
            height_px=size_px[1],
            camera=camera,
            wireframe=wireframe,
            undeformed=undeformed,
            color_by=enum_value(render_pb2.ColorBy, "color_by", color_by),
            format=enum_value(render_pb2.RenderImageRequest.Format, "format", format),
            jpeg_quality=jpeg_quality,
            dark=dark,
        )
        return bytes((await self._call(self._server.render_service.RenderImage, request)).image)

    async def obj(self) -> bytes:
        """Returns the sheet as it is now, as a Wavefront OBJ file.

        >>> (await sheet.obj()).count(b"\\nv ")
        400
        """
        request = sheets_pb2.ExportSheetRequest(name=self.name)
        return bytes((await self._call(self._server.sheet_service.ExportSheet, request)).content)

    async def gltf(self) -> bytes:
        """Returns the sheet as it is now, as a binary glTF 2.0 file (.glb): y up, a colour for each piece.

        >>> (await sheet.gltf())[:4]
        b'glTF'
        """
        request = sheets_pb2.ExportSheetRequest(name=self.name, format=sheets_pb2.ExportSheetRequest.GLTF)
        return bytes((await self._call(self._server.sheet_service.ExportSheet, request)).content)

    async def record(self, path: "str | os.PathLike[str]") -> int:
        """Writes the recording of the sheet's run, from its scene to now, for `kerf replay` and Server.replay().
        Returns the number of bytes. The file appears only when it is complete. Raises FailedPrecondition:
        RECORDING_TOO_LONG, and OSError.

        >>> await sheet.record(path) > 0
        True
        """
        request = sheets_pb2.GetSheetRecordingRequest(name=self.name)
        stream = Stream(self._server.sheet_service.GetSheetRecording, self._server.address, request=request)
        try:
            with whole_file(path) as file:
                while (chunk := await stream.receive()) is not None:
                    file.write(chunk.content)
                return file.tell()
        finally:
            await stream.close()

    async def _tick(self) -> int:
        reply = await self._call(self._server.sheet_service.GetSheet, sheets_pb2.GetSheetRequest(name=self.name))
        return int(reply.tick)
