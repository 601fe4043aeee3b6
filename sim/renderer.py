"""The one interface that every renderer has."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import cv2
import numpy as np

from contracts import ImageArray
from contracts.truth import Truth

Window = tuple[slice, slice]  # rows and columns of an image, bounded


class RendererName(StrEnum):
    """The renderers that there are. ``layered`` is fast; ``full`` draws everything anew and is its oracle."""

    LAYERED = "layered"
    FULL = "full"


@dataclass(frozen=True, eq=False)
class Still:
    """What stands still in each pixel of a pinhole's picture.

    kinds: (H, W) uint8, 0 for nothing and k + 1 for ``names[k]``; the same array from frame to frame.
    upright: names of what stands, and may hide something, rather than lies on the ground.
    """

    kinds: ImageArray
    names: tuple[str, ...]
    upright: frozenset[str]


@dataclass(frozen=True, eq=False)
class Rendered:
    """A clean picture through a pinhole, before lens and sensor.

    image: (H, W, 3) uint8 BGR.
    instances: (H, W) uint8, 0 for background and k + 1 for row k of the truth; never antialiased.
    still: a picture without vehicles that the renderer keeps, unchanged, from frame to frame; None if it keeps none.
    things: what stands still, where the renderer tells it.
    windows: the only parts in which ``image`` differs from ``still`` and ``instances`` from 0.
    """

    image: ImageArray
    instances: ImageArray
    still: ImageArray | None = None
    windows: tuple[Window, ...] = ()
    things: Still | None = None


def blended(pictures: Sequence[tuple[float, Rendered]]) -> Rendered:
    """The picture under one light or two, from those under each of them and their weights, which sum to 1."""
    (weight, picture), *second = pictures
    for other_weight, other in second:
        image = cv2.addWeighted(picture.image, weight, other.image, other_weight, 0.0)
        picture = Rendered(np.asarray(image, np.uint8), picture.instances, things=picture.things)
    return picture


class Renderer(Protocol):
    """Draws the world through named pinhole cameras; the picture depends on the state alone, not on earlier ones."""

    def render(self, state: Truth, camera: str) -> Rendered:
        """The world at ``state`` (its ``time_ns`` decides the light) as ``camera``'s pinhole sees it."""
        ...

    def close(self) -> None:
        """Give the graphics memory back; the renderer is of no use afterwards."""
        ...
