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

Range = tuple[float, float]

BOTH = "both"  # both ends of a roof's axis were measured
SINGLE = "single"  # one end was, the other follows from the learned size
ROUGH = "rough"  # none was: the silhouette's middle
REGIMES = (BOTH, SINGLE, ROUGH)


@dataclass(frozen=True, eq=False)
class ColourModel:
    """A vehicle of one colour as it shows in an image, all of it learned.

    label: the colour's name.
    histogram: (HUE_BINS, SATURATION_BINS) pixels that one vehicle puts into each bin, background suppressed.
    area_px: least and largest area of the silhouette, roof and visible walls, in pixels.
    side_ratio: least and largest short / long side of the silhouette's smallest rotated rectangle.
    rectangularity_min: least area of the silhouette over that of its rectangle.
    roof_long_px, roof_short_px: least and largest long and short side of the roof.
    roof_height_m: height above ground of the roof, on which the anchor lies.
    anchor_moments_px2: by regime of measurement, the anchor's mean squared error along the long and the short side.
    """

    label: str
    histogram: FloatArray
    area_px: Range
    side_ratio: Range
    rectangularity_min: float
    roof_long_px: Range
    roof_short_px: Range
    roof_height_m: float
    anchor_moments_px2: dict[str, Range]

    def __post_init__(self) -> None:
        if not self.label:
            raise InputError("ColourModel.label is empty; name the colour")
        freeze(self, "histogram", shape=SHAPE)
        if self.histogram.min() < 0 or self.histogram.sum() <= 0:
            raise InputError(f"ColourModel {self.label!r}: the histogram must hold counts >= 0, not all of them 0")
        for name in ("area_px", "side_ratio", "roof_long_px", "roof_short_px"):
            low, high = frozen_array(getattr(self, name), name=f"ColourModel.{name}", shape=(2,))
            if not 0 < low <= high:
                raise InputError(f"ColourModel {self.label!r}: {name} = ({low}, {high}) must be 0 < low <= high")
        if not 0 <= self.rectangularity_min <= 1:
            raise InputError(f"ColourModel {self.label!r}: rectangularity_min must lie in [0, 1]")
        if not np.isfinite(self.roof_height_m):
            raise InputError(f"ColourModel {self.label!r}: roof_height_m = {self.roof_height_m} must be finite")
        moments = [value for pair in self.anchor_moments_px2.values() for value in pair]
        if set(self.anchor_moments_px2) != set(REGIMES) or not np.isfinite(moments).all() or min(moments) <= 0:
            wanted = ", ".join(REGIMES)
            raise InputError(f"ColourModel {self.label!r}: anchor_moments_px2 needs finite positive pairs for {wanted}")

    @property
    def roof_size_px(self) -> Range:
        """Usual long and short side of the roof."""
        return sum(self.roof_long_px) / 2, sum(self.roof_short_px) / 2


@dataclass(frozen=True, eq=False)
class ColourModels:
    """The models of all colours, labels unique."""

    models: tuple[ColourModel, ...]

    def __post_init__(self) -> None:
        labels = [model.label for model in self.models]
        if not labels:
            raise InputError("ColourModels: there is no model in it; learn one with `gantry learn`")
        if len(set(labels)) != len(labels):
            raise InputError(f"ColourModels: labels must be unique, got {labels}")

    def save(self, path: Path) -> None:
        """Write to a JSON file, one line for each model; histograms as [hue bin, saturation bin, pixels]."""
        lines = b",\n".join(msgspec.json.encode(model, enc_hook=_encode) for model in self.models)
        path.write_bytes(b'{"models":[\n' + lines + b"\n]}\n")

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
    whole = np.rint(value).astype(np.int64)
    return [[hue, saturation, int(whole[hue, saturation])] for hue, saturation in np.argwhere(whole).tolist()]


def _decode(_: type, value: Any) -> FloatArray:
    bins = frozen_array(value, name="histogram", shape=(None, 3), dtype=np.int64)
    if (bins[:, :2] < 0).any() or (bins[:, :2] >= SHAPE).any():
        raise InputError(f"histogram has a bin outside {SHAPE[0]} x {SHAPE[1]}")
    counts = np.zeros(SHAPE)
    counts[bins[:, 0], bins[:, 1]] = bins[:, 2]
    return counts
