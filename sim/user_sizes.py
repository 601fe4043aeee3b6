"""How long, wide and high road users are: each their own size, drawn from the seed.

Ranges are those of what is sold and driven in Europe and Korea, from makers' data sheets (for example Toyota Aygo to VW
Polo, VW Golf to Hyundai Grandeur, Hyundai Kona to Palisade, Renault Master to VW Crafter, Solaris Urbino 10.5 to
Mercedes Citaro); EU directive 96/53/EC keeps widths to 2.55 m. Heights of adults: NCD Risk Factor Collaboration 2016.
"""

from dataclasses import dataclass

import numpy as np

from sim.road_users import KINDS, Size
from sim.streams import stream

_TOGETHER = 0.7  # what is long tends to be wide and high: weight of the common draw against that of each measure

RANGES_M: dict[str, tuple[Size, Size]] = {
    "city_car": ((3.45, 1.56, 1.44), (4.06, 1.76, 1.60)),
    "saloon": ((4.25, 1.76, 1.41), (5.04, 1.89, 1.50)),
    "suv": ((4.15, 1.79, 1.57), (5.00, 1.98, 1.78)),
    "delivery_van": ((5.05, 1.98, 2.25), (5.99, 2.07, 2.65)),
    "minivan": ((4.85, 1.90, 1.75), (5.27, 2.00, 2.00)),
    "light_truck": ((5.60, 1.98, 2.45), (6.95, 2.22, 2.95)),
    "lorry": ((7.60, 2.42, 3.10), (9.60, 2.55, 3.75)),
    "city_bus": ((10.50, 2.47, 3.05), (12.14, 2.55, 3.35)),
    "bicycle": ((1.65, 0.52, 1.62), (1.90, 0.68, 1.88)),
    "motorcycle": ((1.85, 0.70, 1.55), (2.28, 0.90, 1.75)),
    "adult": ((0.34, 0.42, 1.50), (0.48, 0.58, 1.94)),
    "child": ((0.25, 0.31, 1.00), (0.35, 0.44, 1.50)),
    "stroller": ((1.34, 0.52, 1.52), (1.60, 0.64, 1.84)),
    "robot": ((0.66, 0.54, 0.52), (0.80, 0.66, 0.80)),
}
"""The smallest and the largest of each kind; half of them are smaller than ``Kind.size_m``."""


@dataclass(frozen=True)
class Sizes:
    """The sizes of all road users, always the same; ``seed`` decides them, and nothing else is drawn with it."""

    seed: int

    def of(self, kind: str, id_: str) -> Size:
        """Length, width and height of one user, to the millimetre."""
        rng = stream(self.seed, f"size/{id_}")
        common, own = rng.uniform(-1.0, 1.0), rng.triangular(-1.0, 0.0, 1.0, 3)
        where = _TOGETHER * common + (1.0 - _TOGETHER) * own  # (3,) -1 the smallest, 0 the usual, 1 the largest
        usual, (smallest, largest) = np.array(KINDS[kind].size_m), RANGES_M[kind]
        size = usual + np.where(where < 0, where * (usual - smallest), where * (largest - usual))
        length, width, height = size.round(3).tolist()
        return length, width, height
