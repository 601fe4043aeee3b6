"""What stands still along a road, in numbers: surfaces, paint, buildings, trees, poles, and the lamps that light it."""

from dataclasses import dataclass
from enum import StrEnum

from contracts import FloatArray
from contracts.arrays import freeze
from sim.lights import Rgb
from sim.meshes import Mesh
from sim.signals import Shown, SignalHead


class PartKind(StrEnum):
    """What a part is; the names by which the truth says what hides something."""

    GROUND = "ground"
    ROAD = "road"
    PAVEMENT = "pavement"
    PAINT = "paint"
    BUILDING = "building"
    TREE = "tree"
    POLE = "pole"

    @property
    def upright(self) -> bool:
        """Whether it stands on the ground and can hide something, rather than lie there."""
        return self in _UPRIGHT


_UPRIGHT = frozenset((PartKind.BUILDING, PartKind.TREE, PartKind.POLE))
KIND_CODES = {kind: code for code, kind in enumerate(PartKind, start=1)}  # in maps of kinds; 0 is the sky


@dataclass(frozen=True, eq=False)
class StillPart:
    """One thing of one matte colour.

    adorns: whether it lies on another upright part, as a window on a wall, and hides nothing more.
    shining: what it sends out by itself while lamps are on, 1 being level 255.
    """

    name: str
    kind: PartKind
    mesh: Mesh
    rgb: Rgb
    adorns: bool = False
    shining: Rgb = (0.0, 0.0, 0.0)

    @property
    def hides(self) -> bool:
        """Whether something can be hidden behind it and by nothing else."""
        return self.kind.upright and not self.adorns


@dataclass(frozen=True, eq=False)
class RoadScene:
    """All that stands still.

    parts: names are unique. lamps_m: (L, 3) luminaires of the streetlamps. seed: of the surfaces' mottle.
    signals: what stands still of them is among the parts; what they show changes.
    """

    parts: tuple[StillPart, ...]
    lamps_m: FloatArray
    seed: int = 0
    signals: tuple[SignalHead, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "lamps_m", shape=(None, 3))

    def shown(self, time_ns: int) -> Shown:
        """What the signals show at a moment."""
        return tuple(head.shown(time_ns) for head in self.signals)
