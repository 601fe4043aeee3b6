"""A smooth body drawn along behind SUMO's samples: bounded acceleration and yaw rate, whatever jumps SUMO makes.

The guide, the middle of the front axle, is the samples averaged with a Hann window; between two steps it is a cubic
with matching velocities. The body follows it as a vehicle does whose rear axle cannot slip: with that axle L behind the
guide and v the guide's velocity, d(heading)/dt = (v_y cos h - v_x sin h) / L (the tractrix; Rajamani 2012, ch. 2.2).
"""

from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np

from contracts import FloatArray
from sim.boxes import Box

HALF_WINDOW = 12  # samples on either side that the average takes in: 0.6 s
CRASH_MPS2 = 150.0  # of a body that touched another: the pulse of a car against a barrier, which crushes it a little

_WEIGHTS = np.hanning(2 * HALF_WINDOW + 3)[1:-1]
_WEIGHTS /= _WEIGHTS.sum()
SPAN = len(_WEIGHTS) + 2  # samples needed for position and velocity at their middle


@dataclass(frozen=True)
class Node:
    """The guide at a step: east, north, up, slope (rise per metre), and the velocity of the first two."""

    x_m: float
    y_m: float
    z_m: float
    slope: float
    vx_mps: float
    vy_mps: float


def node_of(samples: FloatArray, step_s: float) -> Node:
    """The guide in the middle of ``SPAN`` samples (SPAN, 4): x, y, z, slope."""
    before, here, after = (_WEIGHTS @ samples[k : k + len(_WEIGHTS)] for k in range(3))
    velocity = (after[:2] - before[:2]) / (2 * step_s)
    return Node(*map(float, here), *map(float, velocity))


@dataclass(frozen=True)
class Pose:
    """A body at a moment: centre of its footprint, heading, velocity of that centre, yaw rate."""

    x_m: float
    y_m: float
    z_m: float
    heading_rad: float
    vx_mps: float
    vy_mps: float
    yaw_radps: float

    def box(self, size_m: tuple[float, float, float]) -> Box:
        """Its footprint."""
        return Box(self.x_m, self.y_m, self.heading_rad, size_m[0], size_m[1])


@dataclass(frozen=True)
class Stretch:
    """A body's motion over one step. ``guide_m``: of the guide, the front axle, behind the front end."""

    begin: Node
    end: Node
    heading_rad: float
    end_heading_rad: float
    step_s: float
    length_m: float
    guide_m: float
    wheelbase_m: float

    @classmethod
    def following(
        cls,
        begin: Node,
        end: Node,
        heading_rad: float,
        *,
        step_s: float,
        length_m: float,
        guide_m: float,
        wheelbase_m: float,
    ) -> "Stretch":
        """The stretch that begins with ``heading_rad``: the tractrix by one Runge-Kutta step."""
        probe = cls(begin, end, heading_rad, heading_rad, step_s, length_m, guide_m, wheelbase_m)

        def rate(share: float, heading: float) -> float:
            _, _, vx, vy = probe.guide(share)
            return (vy * cos(heading) - vx * sin(heading)) / wheelbase_m

        k1 = rate(0.0, heading_rad)
        k2 = rate(0.5, heading_rad + k1 * step_s / 2)
        k3 = rate(0.5, heading_rad + k2 * step_s / 2)
        k4 = rate(1.0, heading_rad + k3 * step_s)
        turned = heading_rad + step_s * (k1 + 2 * k2 + 2 * k3 + k4) / 6
        return cls(begin, end, heading_rad, turned, step_s, length_m, guide_m, wheelbase_m)

    def guide(self, share: float) -> tuple[float, float, float, float]:
        """Position and velocity of the guide, ``share`` in [0, 1] of the step."""
        a, b = self.begin, self.end
        x, vx = _hermite((a.x_m, a.vx_mps), (b.x_m, b.vx_mps), share, self.step_s)
        y, vy = _hermite((a.y_m, a.vy_mps), (b.y_m, b.vy_mps), share, self.step_s)
        return x, y, vx, vy

    def pose(self, time_s: float) -> Pose:
        """The body ``time_s`` after the step's beginning."""
        share = time_s / self.step_s
        x, y, vx, vy = self.guide(share)
        heading, yaw = self._heading(share)
        to_centre_m = self.length_m / 2 - self.guide_m
        east, north = cos(heading), sin(heading)
        up = self.begin.z_m + share * (self.end.z_m - self.begin.z_m)
        slope = self.begin.slope + share * (self.end.slope - self.begin.slope)
        return Pose(
            x - to_centre_m * east,
            y - to_centre_m * north,
            up - to_centre_m * slope,
            heading,
            vx + to_centre_m * yaw * north,
            vy - to_centre_m * yaw * east,
            yaw,
        )

    @property
    def way_m(self) -> float:
        """How far the guide gets, straight on."""
        return hypot(self.end.x_m - self.begin.x_m, self.end.y_m - self.begin.y_m)

    @property
    def fastest_mps(self) -> float:
        """No point of the body is faster during the step: hodographs of cubics lie within their control points."""
        a, b, h = self.begin, self.end, self.step_s
        middle = hypot(
            3 * (b.x_m - a.x_m) / h - a.vx_mps - b.vx_mps,
            3 * (b.y_m - a.y_m) / h - a.vy_mps - b.vy_mps,
        )
        guide = max(hypot(a.vx_mps, a.vy_mps), hypot(b.vx_mps, b.vy_mps), middle)
        first, last = self._rates()
        yaw = max(abs(first), abs(last), abs(3 * (self.end_heading_rad - self.heading_rad) / h - first - last))
        return guide + yaw * 1.5 * self.length_m

    def _rates(self) -> tuple[float, float]:
        def rate(node: Node, heading: float) -> float:
            return (node.vy_mps * cos(heading) - node.vx_mps * sin(heading)) / self.wheelbase_m

        return rate(self.begin, self.heading_rad), rate(self.end, self.end_heading_rad)

    def _heading(self, share: float) -> tuple[float, float]:
        first, last = self._rates()
        return _hermite((self.heading_rad, first), (self.end_heading_rad, last), share, self.step_s)


@dataclass(frozen=True)
class Wreck:
    """A body that touched another at ``pose``, ``since_s`` on the run's clock: it slides straight on and stops."""

    pose: Pose
    since_s: float

    def at(self, time_s: float) -> Pose:
        """The body at a time of the run, not before ``since_s``."""
        p = self.pose
        speed = hypot(p.vx_mps, p.vy_mps)
        if speed < 1e-9:
            return Pose(p.x_m, p.y_m, p.z_m, p.heading_rad, 0.0, 0.0, 0.0)
        passed = min(time_s - self.since_s, speed / CRASH_MPS2)
        left = 1.0 - passed * CRASH_MPS2 / speed
        slid_s = passed * (1.0 + left) / 2  # metres slid over the speed at the contact
        return Pose(
            p.x_m + p.vx_mps * slid_s,
            p.y_m + p.vy_mps * slid_s,
            p.z_m,
            p.heading_rad + p.yaw_radps * slid_s,
            p.vx_mps * left,
            p.vy_mps * left,
            p.yaw_radps * left,
        )


def _hermite(begin: tuple[float, float], end: tuple[float, float], share: float, step_s: float) -> tuple[float, float]:
    """Cubic between two values, each with its rate: value and rate at ``share``."""
    a, b = begin[0], end[0]
    da, db, way = begin[1] * step_s, end[1] * step_s, b - a
    c2, c3 = 3 * way - 2 * da - db, da + db - 2 * way
    value = a + share * (da + share * (c2 + share * c3))
    return value, (da + share * (2 * c2 + share * 3 * c3)) / step_s
