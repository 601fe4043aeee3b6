"""What the owner of a camera hands in: places in the image whose places on the map are known."""

from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, FloatArray, InputError
from contracts.arrays import freeze, frozen_array


@dataclass(frozen=True, eq=False)
class PointPicks:
    """N points picked in the image with their places on the map.

    names: what they are, for messages.
    pixels: (N, 2), the first pixel's centre at (0, 0).
    points_m: (N, 3) local metres: east, north, up.
    sigmas_m: (N,) standard deviation per axis of the map's own point; 0 where the map is exact.
    """

    names: tuple[str, ...]
    pixels: FloatArray
    points_m: FloatArray
    sigmas_m: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        n = len(self.names)
        freeze(self, "pixels", shape=(n, 2))
        freeze(self, "points_m", shape=(n, 3))
        freeze(self, "sigmas_m", shape=(n,))
        if (self.sigmas_m < 0).any():
            raise InputError("PointPicks.sigmas_m holds a negative standard deviation")

    @classmethod
    def exact(cls, pixels: FloatArray, points_m: FloatArray) -> "PointPicks":
        """Picks on an exact map, named by their numbers."""
        return cls(tuple(f"pick {i + 1}" for i in range(len(pixels))), pixels, points_m, np.zeros(len(pixels)))

    def __len__(self) -> int:
        return len(self.names)

    def chosen(self, which: BoolArray) -> "PointPicks":
        """Those where the mask ``which`` (N,) says so."""
        numbers = np.flatnonzero(which)
        names = tuple(self.names[i] for i in numbers)
        return PointPicks(names, self.pixels[numbers], self.points_m[numbers], self.sigmas_m[numbers])


@dataclass(frozen=True, eq=False)
class LinePicks:
    """N pixels, each picked somewhere on a line of the map.

    names: the lines' names, one for each pixel.
    pixels: (N, 2).
    lines_m: N polylines (M_i, 3), M_i >= 2; local metres. The first and last stretch go on beyond their ends.
    sigmas_m: (N,) standard deviation of the map's line across itself.
    """

    names: tuple[str, ...]
    pixels: FloatArray
    lines_m: tuple[FloatArray, ...]
    sigmas_m: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        n = len(self.names)
        freeze(self, "pixels", shape=(n, 2))
        freeze(self, "sigmas_m", shape=(n,))
        if len(self.lines_m) != n:
            raise InputError(f"{len(self.lines_m)} lines for {n} pixels on lines")
        if (self.sigmas_m < 0).any():
            raise InputError("LinePicks.sigmas_m holds a negative standard deviation")
        lines = tuple(frozen_array(line, name="a line", shape=(None, 3)) for line in self.lines_m)
        for name, line in zip(self.names, lines, strict=True):
            if len(line) < 2 or not (np.linalg.norm(np.diff(line, axis=0), axis=1) > 0).all():
                raise InputError(f'line "{name}" needs at least two different points, each unlike the one before')
        object.__setattr__(self, "lines_m", lines)

    @classmethod
    def none(cls) -> "LinePicks":
        """No line was picked."""
        return cls((), np.empty((0, 2)), (), np.empty(0))

    def __len__(self) -> int:
        return len(self.names)
