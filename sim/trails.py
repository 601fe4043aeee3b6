"""The way that somebody's front end went, and where a point behind it is on that way.

SUMO keeps front ends on the middle of a lane. A driver keeps the front axle there: that of a bus lies more than 2 m
behind the front end, which swings out in a bend so that the tail cuts less of it.
"""

from math import cos, hypot, sin

Place = tuple[float, float, float, float]  # east, north, up in metres, slope (rise per metre)


class Trail:
    """Remembers as much of the way as lies within ``reach_m`` behind the front end; before it began it was straight."""

    def __init__(self, first: Place, heading_rad: float, reach_m: float) -> None:
        x, y, z, slope = first
        begin = (x - reach_m * cos(heading_rad), y - reach_m * sin(heading_rad), z - reach_m * slope, slope)
        self._places = [begin, first]
        self._reach_m = reach_m

    def take(self, place: Place) -> None:
        """The front end is at ``place`` now."""
        self._places.append(place)

    def end(self) -> Place:
        """Where the way lies ``reach_m`` behind the front end, measured along it on the ground plane."""
        left_m = self._reach_m
        for index in range(len(self._places) - 1, 0, -1):
            here, before = self._places[index], self._places[index - 1]
            side_m = hypot(here[0] - before[0], here[1] - before[1])
            if side_m >= left_m and side_m > 0.0:
                self._places = self._places[index - 1 :]
                share = left_m / side_m
                x, y, z, slope = (b + share * (a - b) for a, b in zip(before, here, strict=True))
                return x, y, z, slope
            left_m -= side_m
        return self._places[0]
