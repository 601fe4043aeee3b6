"""How legs and arms move: each piece of a limb keeps its place between two joints, whose places the stride decides.

A stride is driven by the way that somebody has gone, never by time: who stands has still legs.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contracts import FloatArray
from contracts.truth import Truth

Place = tuple[float, float]  # x ahead and z up, in the plane in which limbs move
Joint = Callable[[float], Place]  # its place at a phase of the stride, radians

_STRIDE = 0.83  # two steps, over the height of who walks
_DEVELOPMENT_M = 5.0  # way of a bicycle for one turn of its pedals, in a middle gear


@dataclass(frozen=True)
class Bone:
    """Two joints; a piece between them is turned and stretched as they move."""

    upper: Joint
    lower: Joint

    def moved(self, scale: FloatArray, shift: FloatArray) -> "Bone":
        """The bone of a body that is scaled by (3,) about the origin, then shifted by (3,)."""
        return Bone(_moved(self.upper, scale, shift), _moved(self.lower, scale, shift))

    def pose(self, phase_rad: float, size_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """From the beginning of a stride to a phase: (3, 3) and (3,), in a unit box of true size (3,), metres."""
        length, _, height = size_m.tolist()
        (old_x, old_z), (x, z) = self.upper(0.0), self.upper(phase_rad)
        before, now = (_between(self.upper(t), self.lower(t), length, height) for t in (0.0, phase_rad))
        ratio = now / before  # its angle is the turn, its size the stretch
        c, s, t = ratio.real, ratio.imag * height / length, ratio.imag * length / height
        turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [t, 0.0, c]])
        return turn, np.array([x - c * old_x + s * old_z, 0.0, z - t * old_x - c * old_z])


def carried(joint: Joint) -> Bone:
    """What goes with a joint, and does not turn."""
    return Bone(joint, lambda phase: (joint(phase)[0], joint(phase)[1] - 1.0))


def fixed(place: Place) -> Joint:
    """A joint that does not move."""
    return lambda _: place


def later(joint: Joint, by_rad: float) -> Joint:
    """A joint that is so much ahead in its stride."""
    return lambda phase: joint(phase + by_rad)


def phase_rad(state: Truth, row: int) -> float:
    """How far in their stride somebody is; 0 where the truth does not say how far they have come."""
    if state.travelled_m is None:
        return 0.0
    stride_m = _DEVELOPMENT_M if state.kinds[row] == "bicycle" else _STRIDE * float(state.sizes_m[row, 2])
    return 2.0 * np.pi * float(state.travelled_m[row]) / stride_m


def _between(upper: Place, lower: Place, length: float, height: float) -> complex:
    """From joint to joint, metres, x ahead real and z up imaginary."""
    return complex((lower[0] - upper[0]) * length, (lower[1] - upper[1]) * height)


def _moved(joint: Joint, scale: FloatArray, shift: FloatArray) -> Joint:
    (scale_x, _, scale_z), (shift_x, _, shift_z) = scale.tolist(), shift.tolist()

    def moved(phase: float) -> Place:
        x, z = joint(phase)
        return scale_x * x + shift_x, scale_z * z + shift_z

    return moved
