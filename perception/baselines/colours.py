"""What the baselines know of each colour, all of it learned, kept in one JSON file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from contracts import FloatArray, InputError
from contracts.arrays import freeze
from perception.baselines.mixture import CHANNELS, Mixture

SHIPPED = Path(__file__).parents[1] / "models" / "baselines.json"
"""The palette's colours, learned by ``make model``."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """A box of colours: ``low`` to ``high`` in each of three channels, both included.

    A circular channel whose ``low`` exceeds its ``high`` runs across its origin.
    """

    low: FloatArray
    high: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "low", shape=(CHANNELS,))
        freeze(self, "high", shape=(CHANNELS,))


@dataclass(frozen=True, eq=False)
class PlainColour:
    """One vehicle's colour as each of the baselines describes it.

    label: the colour's name.
    hsv: range of OpenCV's 8-bit hue, saturation, value; hue is circular.
    ratios: range of the component ratios, see ``colour_ratio.component_ratios``.
    mixture: of the colours of its pixels, BGR. density_min: least log density of a pixel that belongs to it.
    """

    label: str
    hsv: Bounds
    ratios: Bounds
    mixture: Mixture
    density_min: float

    def __post_init__(self) -> None:
        if not self.label:
            raise InputError("PlainColour.label is empty; name the colour")
        if not np.isfinite(self.density_min):
            raise InputError(f"PlainColour {self.label!r}: density_min = {self.density_min} must be finite")


@dataclass(frozen=True, eq=False)
class PlainColours:
    """All colours, labels unique."""

    colours: tuple[PlainColour, ...]

    def __post_init__(self) -> None:
        labels = [colour.label for colour in self.colours]
        if not labels:
            raise InputError("PlainColours: there is no colour in it; learn one with `gantry learn --baselines`")
        if len(set(labels)) != len(labels):
            raise InputError(f"PlainColours: labels must be unique, got {labels}")

    def save(self, path: Path) -> None:
        """Write to a JSON file, one line for each colour."""
        lines = b",\n".join(msgspec.json.encode(colour, enc_hook=_encode) for colour in self.colours)
        path.write_bytes(b'{"colours":[\n' + lines + b"\n]}\n")

    @classmethod
    def load(cls, path: Path = SHIPPED) -> "PlainColours":
        """Read from a JSON file; InputError names the file and what is wrong in it."""
        try:
            return msgspec.json.decode(path.read_bytes(), type=cls, dec_hook=lambda _, value: np.array(value))
        except OSError as error:
            raise InputError(f"{path}: cannot be read as colours of the baselines: {error.strerror}") from error
        except (msgspec.MsgspecError, InputError, ValueError) as error:
            raise InputError(f"{path}: these are no colours of the baselines: {error}") from error


def _encode(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        raise NotImplementedError(f"{type(value).__name__} has no JSON form")
    return np.round(value, 6).tolist()
