"""Motion along the track within one internal step: constant acceleration, and perhaps a dead stop on the way."""

from dataclasses import dataclass, replace
from math import copysign, inf, sqrt


@dataclass(frozen=True)
class Glide:
    """Distance and speed in closed form, so that a state between two steps is as exact as at their ends.

    speed_mps: at the beginning; negative backwards. It does not change its sign on the way.
    stop_s: the time of an impact; at rest from then on.
    """

    speed_mps: float
    acceleration_mps2: float
    stop_s: float = inf

    def travelled_m(self, time_s: float) -> float:
        """Signed way after ``time_s``."""
        t = min(time_s, self.stop_s)
        return t * (self.speed_mps + self.acceleration_mps2 * t / 2.0)

    def speed_at(self, time_s: float) -> float:
        """Signed speed after ``time_s``."""
        return 0.0 if time_s >= self.stop_s else self.speed_mps + self.acceleration_mps2 * time_s

    def top_speed_mps(self, until_s: float) -> float:
        """Greatest speed without its sign up to ``until_s``."""
        return max(abs(self.speed_mps), abs(self.speed_mps + self.acceleration_mps2 * until_s))

    def time_at(self, way_m: float) -> float:
        """When ``way_m`` (signed, within the glide's own way) has been travelled."""
        if way_m == 0.0:
            return 0.0
        square = self.speed_mps**2 + 2.0 * self.acceleration_mps2 * way_m
        return 2.0 * way_m / (self.speed_mps + copysign(sqrt(max(square, 0.0)), way_m))

    def stopped_at(self, time_s: float) -> "Glide":
        """The same motion with a dead stop at ``time_s``, or earlier if there was one already."""
        return replace(self, stop_s=min(self.stop_s, time_s))
