"""Spaces of kerf.env where Gymnasium is not installed: boxes with the part of its interface that learners use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Tuple

from kerf.arrays import numpy_module

if TYPE_CHECKING:
    from kerf.arrays import Float32s


class Box:
    """Arrays of 32-bit floats of one shape, each number between two limits.

    >>> Box(-1.0, 1.0, (3,)).contains(numpy.zeros(3, "f4"))
    True
    """

    def __init__(self, low: float, high: float, shape: Tuple[int, ...]) -> None:
        numpy = numpy_module()
        self.shape = shape
        self.dtype = numpy.dtype("f4")
        self.low: Float32s = numpy.full(shape, low, dtype="f4")
        self.high: Float32s = numpy.full(shape, high, dtype="f4")
        self._random = numpy.random.default_rng()

    def seed(self, seed: Optional[int] = None) -> Optional[int]:
        """Begins the samples again."""
        self._random = numpy_module().random.default_rng(seed)
        return seed

    def sample(self) -> Float32s:
        """Returns a random array; of a space without limits, from the normal distribution."""
        numpy = numpy_module()
        if not numpy.isfinite(self.low).all() or not numpy.isfinite(self.high).all():
            return self._random.normal(size=self.shape).astype("f4")
        return self._random.uniform(self.low, self.high).astype("f4")

    def contains(self, array: Any) -> bool:
        """Returns True for an array of this shape and type within the limits."""
        numpy = numpy_module()
        fits = isinstance(array, numpy.ndarray) and array.shape == self.shape and array.dtype == self.dtype
        return fits and bool((array >= self.low).all() and (array <= self.high).all())

    def __contains__(self, array: Any) -> bool:
        return self.contains(array)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Box) or self.shape != other.shape:
            return False
        return bool((self.low == other.low).all() and (self.high == other.high).all())

    def __repr__(self) -> str:
        return f"Box({self.low.min():g}, {self.high.max():g}, {self.shape}, float32)"


def make_box(low: float, high: float, shape: Tuple[int, ...]) -> Any:
    """Returns Gymnasium's box if it is installed, else one of this module."""
    try:
        from gymnasium.spaces import Box as GymnasiumBox
    except ImportError:
        return Box(low, high, shape)
    return GymnasiumBox(low, high, shape, dtype=numpy_module().float32)
