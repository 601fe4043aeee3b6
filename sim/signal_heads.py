"""The heads of traffic signals: three lights side by side on an arm over the road's edge, here drawn unlit."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from contracts import FloatArray
from sim.lights import Rgb
from sim.poles import STEEL, bar
from sim.road_network import RoadNetwork
from sim.road_scene import PartKind, StillPart
from sim.signals import Aspect, SignalHead
from sim.traffic_spec import WARM_UP_S

_ARM_M = 2.2
_UP = np.array([0.0, 0.0, 1.0])
_HEAD_M, _HALF_LENGTH_M = 0.36, 0.55
_EVERY_M, _LENS_M, _THROUGH_M = 0.35, 0.28, 0.38  # lights: apart, across, and from the one face to the other
_HOUSING: Rgb = (0.10, 0.11, 0.11)
_DARK: dict[Aspect, Rgb] = {
    Aspect.RED: (0.16, 0.05, 0.05),
    Aspect.AMBER: (0.15, 0.11, 0.04),
    Aspect.GREEN: (0.04, 0.12, 0.09),
}


def head_parts(name: str, position_m: FloatArray, inward: FloatArray) -> Iterator[StillPart]:
    """A head at ``position_m`` (3,) on an arm that points ``inward`` (3,), its lights off."""
    tip = position_m + _ARM_M * inward
    yield StillPart(f"{name}/arm", PartKind.POLE, bar(position_m + 0.3 * _UP, tip + 0.3 * _UP, 0.08), STEEL)
    housing = bar(tip - _HALF_LENGTH_M * inward, tip + _HALF_LENGTH_M * inward, _HEAD_M)
    yield StillPart(f"{name}/head", PartKind.POLE, housing, _HOUSING)
    for aspect, middle in zip(Aspect, _lights_m(position_m, inward), strict=True):
        foot, half = middle - 0.5 * _LENS_M * _UP, 0.5 * _LENS_M * inward
        lens = bar(foot - half, foot + half, _THROUGH_M, _LENS_M)
        yield StillPart(f"{name}/light/{aspect}", PartKind.POLE, lens, _DARK[aspect])


def head_of(network: RoadNetwork, lanes: Sequence[str], position_m: FloatArray, inward: FloatArray) -> SignalHead:
    """What the head there shows, which governs these lanes."""
    governed = [c for c in network.connections if c.signal and c.from_lane in lanes]
    program = network.signals.get(governed[0].signal) if governed else None
    if program is not None:
        program = replace(program, offset_ns=program.offset_ns - round(WARM_UP_S * 1e9))  # SUMO begins before the run
    facing = np.array([-inward[1], inward[0], 0.0])
    return SignalHead(_lights_m(position_m, inward), facing, tuple(c.link for c in governed), program)


def _lights_m(position_m: FloatArray, inward: FloatArray) -> FloatArray:
    """Middles of red, amber and green, (3, 3)."""
    middle = position_m + _ARM_M * inward + 0.5 * _HEAD_M * _UP
    return middle + _EVERY_M * np.arange(-1, 2)[:, None] * inward
