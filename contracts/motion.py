"""How objects on the ground move at one moment: velocity, state, and direction of travel."""

from dataclasses import dataclass
from enum import StrEnum
from math import cos, pi, sin

import numpy as np

from contracts.arrays import BoolArray, FloatArray, IntArray, freeze
from contracts.errors import InputError
from contracts.ground import GroundTracks


class Compass(StrEnum):
    """A vehicle's direction of travel, as paper R tells it."""

    NORTH = "north"
    SOUTH = "south"
    WEST = "west"
    EAST = "east"

    @property
    def heading_rad(self) -> float:
        """Counter-clockwise from east."""
        return {Compass.EAST: 0.0, Compass.NORTH: pi / 2, Compass.WEST: pi, Compass.SOUTH: -pi / 2}[self]


def compass(heading_rad: float) -> Compass:
    """The nearest of the four directions; opposite headings give opposite directions."""
    east, north = cos(heading_rad), sin(heading_rad)
    if abs(east) >= abs(north):
        return Compass.EAST if east > 0 else Compass.WEST
    return Compass.NORTH if north > 0 else Compass.SOUTH


class MotionState(StrEnum):
    """Whether an object moves."""

    UNKNOWN = "unknown"  # not seen for long enough, or too slow for the noise to tell
    STANDING = "standing"
    MOVING = "moving"


@dataclass(frozen=True, eq=False)
class Motions:
    """The motion of the N objects of a ``GroundTracks``, row for row.

    time_ns: of the frame.
    ids, labels: N identities and names.
    velocities_mps: (N, 2) east and north at this very moment; NaN where not valid.
    velocity_covs_m2ps2: (N, 2, 2) their covariance; NaN where not valid.
    states: N states.
    directions: N compass directions of travel; None unless moving.
    valid: (N,) whether the velocity is known.
    Raises InputError where rows contradict each other: a direction of what does not move, a motion without a direction.
    """

    time_ns: int
    ids: IntArray
    labels: tuple[str, ...]
    velocities_mps: FloatArray
    velocity_covs_m2ps2: FloatArray
    states: tuple[MotionState, ...]
    directions: tuple[Compass | None, ...]
    valid: BoolArray

    def __post_init__(self) -> None:
        n = len(self.labels)
        for name in ("labels", "states", "directions"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        freeze(self, "ids", shape=(n,), dtype=np.int64)
        freeze(self, "velocities_mps", shape=(n, 2), finite=False)
        freeze(self, "velocity_covs_m2ps2", shape=(n, 2, 2), finite=False)
        freeze(self, "valid", shape=(n,), dtype=np.bool_)
        if not len(self.states) == len(self.directions) == n:
            raise InputError(f"Motions of {n} objects: {len(self.states)} states, {len(self.directions)} directions")
        for state, direction in zip(self.states, self.directions, strict=True):
            if state not in list(MotionState) or (direction is not None and direction not in list(Compass)):
                raise InputError(f"Motions: {state!r} is no MotionState or {direction!r} no Compass")
            if (state == MotionState.MOVING) != (direction is not None):
                raise InputError(f"Motions: an object that is {state} cannot have the direction {direction}")

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def speeds_mps(self) -> FloatArray:
        """(N,) length of the velocity; NaN where not valid."""
        return np.asarray(np.hypot(self.velocities_mps[:, 0], self.velocities_mps[:, 1]))

    @property
    def headings_rad(self) -> FloatArray:
        """(N,) direction of travel, counter-clockwise from east, in (-pi, pi]; NaN unless valid and moving."""
        moving = np.array([state == MotionState.MOVING for state in self.states], np.bool_)
        return np.where(moving, np.arctan2(self.velocities_mps[:, 1], self.velocities_mps[:, 0]), np.nan)

    @property
    def speed_sigmas_mps(self) -> FloatArray:
        """(N,) standard deviation of the speed, to first order: along the velocity."""
        return self._sigmas(self.velocities_mps)

    @property
    def heading_sigmas_rad(self) -> FloatArray:
        """(N,) standard deviation of the heading, to first order: across the velocity, over the speed."""
        across = np.column_stack([-self.velocities_mps[:, 1], self.velocities_mps[:, 0]])
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self._sigmas(across) / self.speeds_mps)

    def _sigmas(self, directions: FloatArray) -> FloatArray:
        """Standard deviation of the velocity along each of ``directions`` (N, 2); NaN for one without length."""
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = directions / np.hypot(directions[:, 0], directions[:, 1])[:, None]
        variances = np.einsum("na,nab,nb->n", unit, self.velocity_covs_m2ps2, unit)
        return np.asarray(np.sqrt(np.maximum(variances, 0.0)))

    @classmethod
    def unknown(cls, ground: GroundTracks) -> "Motions":
        """Nothing is known yet of how the objects of ``ground`` move."""
        n = len(ground)
        return cls(
            time_ns=ground.time_ns,
            ids=ground.ids,
            labels=ground.labels,
            velocities_mps=np.full((n, 2), np.nan),
            velocity_covs_m2ps2=np.full((n, 2, 2), np.nan),
            states=(MotionState.UNKNOWN,) * n,
            directions=(None,) * n,
            valid=np.zeros(n, np.bool_),
        )
