"""A body on two axles: both run on the track's centre line, and the body lies between them."""

from dataclasses import dataclass
from math import atan2, cos, hypot, sin

from rail.curves import Pose2
from rail.graph import Location, SwitchStates, advance, pose_at
from rail.plant import Plant

AXLE_TOLERANCE_M = 1e-12  # of the distance between the axles
MAX_ITERATIONS = 50
MAX_AXLE_GAIN = (
    1.1  # an axle's speed over the centre's; holds where the track at the axles is within 30 deg of the body
)


@dataclass(frozen=True)
class BodyPose:
    """Where a body is.

    centre: midway between the axles, and so the centre of the footprint; its heading goes from rear to front axle.
    front, rear: the axles' places on the centre line, with its direction there.
    velocity_per_speed: velocity x, y of the centre at one metre per second along the track.
    """

    centre: Pose2
    front: Pose2
    rear: Pose2
    velocity_per_speed: tuple[float, float]


def body_pose(plant: Plant, midway: Location, states: SwitchStates, wheelbase_m: float) -> BodyPose:
    """The body whose axles stand ``wheelbase_m`` apart, equally far along the track before and behind ``midway``."""
    half_m = wheelbase_m / 2.0
    for _ in range(MAX_ITERATIONS):
        front = pose_at(plant, advance(plant, midway, half_m, states).location)
        rear = pose_at(plant, advance(plant, midway, -half_m, states).location)
        excess_m = hypot(front.x_m - rear.x_m, front.y_m - rear.y_m) - wheelbase_m
        if abs(excess_m) <= AXLE_TOLERANCE_M:
            break
        half_m -= excess_m / 2.0  # Newton's step: the chord grows by almost 2 m for each metre
    heading_rad = atan2(front.y_m - rear.y_m, front.x_m - rear.x_m)
    centre = Pose2((front.x_m + rear.x_m) / 2.0, (front.y_m + rear.y_m) / 2.0, heading_rad)
    return BodyPose(centre, front, rear, _velocity_per_speed(front, rear, heading_rad))


def reach(length_m: float, width_m: float, wheelbase_m: float) -> float:
    """How many metres any point of the body moves at most for each metre that it runs along the track.

    A point of the body is a sum of both axles' places and of a part across, so that its way is at most
    (length + width) / wheelbase times that of the faster axle.
    """
    return MAX_AXLE_GAIN * (max(length_m, wheelbase_m) + width_m) / wheelbase_m


def _velocity_per_speed(front: Pose2, rear: Pose2, heading_rad: float) -> tuple[float, float]:
    """Mean of the axles' velocities, 1 + g and 1 - g along their tangents; that the wheelbase is rigid gives g."""
    along_front = cos(front.heading_rad - heading_rad)
    along_rear = cos(rear.heading_rad - heading_rad)
    g = (along_rear - along_front) / (along_rear + along_front)
    x = (1.0 + g) * cos(front.heading_rad) + (1.0 - g) * cos(rear.heading_rad)
    y = (1.0 + g) * sin(front.heading_rad) + (1.0 - g) * sin(rear.heading_rad)
    return x / 2.0, y / 2.0
