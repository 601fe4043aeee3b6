"""What perception knows of the vehicles it looks for: one model per colour, kept in one JSON file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from contracts import FloatArray, InputError, frozen_array
from contracts.arrays import freeze
from perception.hue_saturation import SHAPE

SHIPPED = Path(__file__).parent / "models" / "rail.json"
"""Models of the palette's colours, learned by ``make model``."""

Pair = tuple[float, float]

BOTH = "both"  # both ends of a roof's axis were measured
SINGLE = "single"  # one end was, the other follows from the learned size
ROUGH = "rough"  # none was: the silhouette's middle
REGIMES = (BOTH, SINGLE, ROUGH)
PARTS = 10_000  # of one, in a file


@dataclass(frozen=True, eq=False)
class ColourModel:
    """A vehicle of one colour, all of it learned; in metres, so that it serves any camera.

    label: the colour's name.
    histogram: (HUE_BINS, SATURATION_BINS) share of the roof's pixels that falls into each bin under the light that
        puts most there, background suppressed; the sum over all bins is therefore more than 1.
    roof_size_m: long and short side of the roof.
    roof_height_m: height above ground of the roof, on which the anchor lies.
    fill_min: least area of the silhouette over that of its smallest rotated rectangle.
    anchor_moments_px2: by regime of measurement, the anchor's mean squared error along the long and the short side.
    """

    label: str
    histogram: FloatArray
    roof_size_m: Pair
    roof_height_m: float
    fill_min: float
    anchor_moments_px2: dict[str, Pair]

    def __post_init__(self) -> None:
        if not self.label:
            raise InputError("ColourModel.label is empty; name the colour")
        freeze(self, "histogram", shape=SHAPE)
        if self.histogram.min() < 0 or self.histogram.sum() <= 0:
            raise InputError(f"ColourModel {self.label!r}: the histogram must hold shares >= 0, not all of them 0")
        long_m, short_m = frozen_array(self.roof_size_m, name="ColourModel.roof_size_m", shape=(2,))
        if not 0 < short_m <= long_m:
            raise InputError(
                f"ColourModel {self.label!r}: roof_size_m = ({long_m}, {short_m}) must be positive, long side first"
            )
        if not 0 <= self.fill_min <= 1:
            raise InputError(f"ColourModel {self.label!r}: fill_min must lie in [0, 1]")
        if not np.isfinite(self.roof_height_m):
            raise InputError(f"ColourModel {self.label!r}: roof_height_m = {self.roof_height_m} must be finite")
        moments = [value for pair in self.anchor_moments_px2.values() for value in pair]
        if set(self.anchor_moments_px2) != set(REGIMES) or not np.isfinite(moments).all() or min(moments) <= 0:
            wanted = ", ".join(REGIMES)
            raise InputError(f"ColourModel {self.label!r}: anchor_moments_px2 needs finite positive pairs for {wanted}")


@dataclass(frozen=True, eq=False)
class ColourModels:
    """The models of all colours, labels unique.

    focal_px, height_m: of the camera that they were learned from; what a detector takes for its own if told nothing.
    """

    models: tuple[ColourModel, ...]
    focal_px: float
    height_m: float

    def __post_init__(self) -> None:
        labels = [model.label for model in self.models]
        if not labels:
            raise InputError("ColourModels: there is no model in it; learn one with `gantry learn`")
        if len(set(labels)) != len(labels):
            raise InputError(f"ColourModels: labels must be unique, got {labels}")
        highest_m = max(model.roof_height_m for model in self.models)
        if not (self.focal_px > 0 and np.isfinite(self.focal_px) and highest_m < self.height_m < np.inf):
            raise InputError(
                f"ColourModels: a camera of focal_px = {self.focal_px} at height_m = {self.height_m} sees no roof"
            )

    def save(self, path: Path) -> None:
        """Write to a JSON file, one line for each model; histograms as [hue bin, saturation bin, parts in 10,000]."""
        lines = b",\n".join(msgspec.json.encode(model, enc_hook=_encode) for model in self.models)
        camera = f'"focal_px":{self.focal_px!r},"height_m":{self.height_m!r}'
        path.write_bytes(f"{{{camera},".encode() + b'"models":[\n' + lines + b"\n]}\n")

    @classmethod
    def load(cls, path: Path) -> "ColourModels":
        """Read from a JSON file; InputError names the file and what is wrong in it."""
        try:
            return msgspec.json.decode(path.read_bytes(), type=cls, dec_hook=_decode)
        except OSError as error:
            raise InputError(f"{path}: cannot be read as colour models: {error.strerror}") from error
        except (msgspec.MsgspecError, InputError) as error:
            raise InputError(f"{path}: these are no colour models: {error}") from error


def _encode(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        raise NotImplementedError(f"{type(value).__name__} has no JSON form")
    whole = np.rint(value * PARTS).astype(np.int64)
    return [[hue, saturation, int(whole[hue, saturation])] for hue, saturation in np.argwhere(whole).tolist()]


def _decode(_: type, value: Any) -> FloatArray:
    bins = frozen_array(value, name="histogram", shape=(None, 3), dtype=np.int64)
    if (bins[:, :2] < 0).any() or (bins[:, :2] >= SHAPE).any():
        raise InputError(f"histogram has a bin outside {SHAPE[0]} x {SHAPE[1]}")
    counts = np.zeros(SHAPE)
    counts[bins[:, 0], bins[:, 1]] = bins[:, 2] / PARTS
    return counts
