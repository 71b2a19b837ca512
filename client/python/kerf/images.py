"""Pictures that the server drew."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Optional, Tuple

from kerf.arrays import needed, numpy_module
from kerf.cuts import enum_value
from kerf.v1 import geometry_pb2, render_pb2, stream_pb2

if TYPE_CHECKING:
    from kerf.arrays import Bytes

ColorBy = Literal["sides", "pieces", "strains"]
Codec = Literal["jpeg", "png", "vp8"]
_CODECS = {render_pb2.IMAGE_JPEG: "jpeg", render_pb2.IMAGE_PNG: "png", render_pb2.IMAGE_VP8: "vp8"}


@dataclass(frozen=True, repr=False)
class Image:
    """One picture of an image stream."""

    tick: int  # tick of the sheet in the picture
    data: bytes  # encoded as `codec`
    codec: str  # "jpeg", "png": the bytes of a file; "vp8": a frame of one stream, RFC 6386, without a container
    key: bool  # False: decoding needs the picture before (VP8 only)
    size_px: Tuple[int, int]  # width, height
    camera: geometry_pb2.Camera  # camera that the picture was drawn with
    stats: stream_pb2.FrameStats  # see proto/kerf/v1/stream.proto
    strain_end: float  # with color_by="strains": the colours span the strains -strain_end..strain_end; else 0

    def __repr__(self) -> str:
        width, height = self.size_px
        return f"Image(tick {self.tick}: {self.codec}, {width} x {height}, {len(self.data)} bytes)"

    def _repr_png_(self) -> Optional[bytes]:
        return self.data if self.codec == "png" else None

    def _repr_jpeg_(self) -> Optional[bytes]:
        return self.data if self.codec == "jpeg" else None

    def array(self) -> Bytes:
        """Returns the picture as height x width x 3 uint8, red, green, blue, top row first.

        Raises ValueError for a VP8 frame, ImportError if Pillow is not installed (python3-pil).
        """
        if self.codec == "vp8":
            raise ValueError("a VP8 frame is not a picture by itself: request codec='jpeg' or 'png', or use a VP8 decoder")
        return decode_image(self.data)


def decode_image(data: bytes) -> Bytes:
    """Converts the PNG or JPEG bytes of Sheet.render() to height x width x 3 uint8, red, green, blue, top row first.

    Raises ImportError if Pillow is not installed (python3-pil), ValueError if the bytes are no picture.

    >>> decode_image(sheet.render((64, 48))).shape
    (48, 64, 3)
    """
    pillow = needed("PIL.Image", "python3-pil")
    try:
        with pillow.open(io.BytesIO(data), formats=("PNG", "JPEG")) as picture:
            return numpy_module().asarray(picture.convert("RGB"))
    except OSError as wrong:
        raise ValueError(f"these {len(data)} bytes are not a PNG or JPEG picture: {wrong}") from None


def image_of(message: render_pb2.Image) -> Image:
    return Image(
        message.tick,
        message.data,
        _CODECS[message.codec],
        message.key,
        (message.width_px, message.height_px),
        message.camera,
        message.stats,
        message.strain_end,
    )


def codec_value(codec: str) -> Any:
    names = {name: value for value, name in _CODECS.items()}
    if codec not in names:
        raise ValueError(f"codec is {codec!r}; must be one of {', '.join(names)}")
    return names[codec]


def image_view(
    size_px: Tuple[int, int],
    camera: Optional[geometry_pb2.Camera],
    wireframe: bool,
    undeformed: bool,
    color_by: str,
    jpeg_quality: int,
    bitrate_kbps: int,
    dark: bool,
) -> render_pb2.ImageView:
    return render_pb2.ImageView(
        width_px=size_px[0],
        height_px=size_px[1],
        camera=camera,
        wireframe=wireframe,
        undeformed=undeformed,
        color_by=enum_value(render_pb2.ColorBy, "color_by", color_by),
        jpeg_quality=jpeg_quality,
        bitrate_kbps=bitrate_kbps,
        dark=dark,
    )
