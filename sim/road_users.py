"""Who uses the road: kinds with real sizes, and how they drive or walk."""

from dataclasses import dataclass
from enum import StrEnum
from xml.sax.saxutils import quoteattr

SHY_M = 0.25  # of air that drivers keep on either side besides SUMO's own gap: they do not know their corners to a hand


Size = tuple[float, float, float]  # length, width, height in metres


class RoadLabel(StrEnum):
    """What perception calls them."""

    CAR = "car"
    VAN = "van"
    TRUCK = "truck"
    BUS = "bus"
    TWO_WHEELER = "two_wheeler"
    PEDESTRIAN = "pedestrian"
    STROLLER = "stroller"
    OTHER = "other"


@dataclass(frozen=True)
class Kind:
    """One kind of road user.

    size_m: usual length, width, height; the riders of two-wheelers and whoever pushes a stroller are part of it.
    lane_class: SUMO's vehicle class, which decides the lanes that it may use.
    front_axle, rear_axle: shares of the length from the front end; the first follows the lane, the body turns about the
    second.
    """

    name: str
    label: RoadLabel
    size_m: Size
    lane_class: str
    top_speed_mps: float
    acceleration_mps2: float = 2.6
    braking_mps2: float = 4.5
    front_axle: float = 0.2
    rear_axle: float = 0.8

    @property
    def walks(self) -> bool:
        """Whether it goes on foot."""
        return self.lane_class == "pedestrian"


_KINDS = (
    Kind("city_car", RoadLabel.CAR, (3.60, 1.62, 1.52), "passenger", 40.0),
    Kind("saloon", RoadLabel.CAR, (4.72, 1.84, 1.45), "passenger", 50.0),
    Kind("suv", RoadLabel.CAR, (4.65, 1.90, 1.68), "passenger", 50.0),
    Kind("delivery_van", RoadLabel.VAN, (5.53, 2.05, 2.45), "delivery", 40.0, 2.0),
    Kind("minivan", RoadLabel.VAN, (5.15, 1.99, 1.85), "passenger", 45.0, 2.2),
    Kind("light_truck", RoadLabel.TRUCK, (6.20, 2.10, 2.70), "truck", 30.0, 1.3, 4.0),
    Kind("lorry", RoadLabel.TRUCK, (8.50, 2.49, 3.40), "truck", 25.0, 1.1, 4.0),
    Kind("city_bus", RoadLabel.BUS, (10.95, 2.49, 3.25), "bus", 25.0, 1.2, 4.0, 0.25, 0.77),
    Kind("bicycle", RoadLabel.TWO_WHEELER, (1.75, 0.60, 1.75), "bicycle", 5.5, 1.2, 3.0),
    Kind("motorcycle", RoadLabel.TWO_WHEELER, (2.10, 0.80, 1.65), "motorcycle", 40.0, 3.5, 5.0),
    Kind("adult", RoadLabel.PEDESTRIAN, (0.40, 0.50, 1.72), "pedestrian", 1.4),
    Kind("child", RoadLabel.PEDESTRIAN, (0.30, 0.38, 1.25), "pedestrian", 1.2),
    Kind("stroller", RoadLabel.STROLLER, (1.45, 0.58, 1.68), "pedestrian", 1.1),
    Kind("robot", RoadLabel.OTHER, (0.72, 0.60, 0.65), "pedestrian", 1.0),
)
KINDS = {kind.name: kind for kind in _KINDS}


def room_m(kind: Kind, size_m: Size) -> Size:
    """Length, width and height that SUMO keeps free for somebody of this size."""
    length, width, height = size_m
    return length, width if kind.walks else width + 2 * SHY_M, height


def types_xml(extra: dict[str, tuple[str, dict[str, str]]]) -> str:
    """SUMO's vehicle types: every kind by its name, and under further names kinds with further attributes."""
    named: dict[str, tuple[str, dict[str, str]]] = {name: (name, {}) for name in KINDS}
    rows = [_type_xml(id_, KINDS[name], more) for id_, (name, more) in (named | extra).items()]
    return "<additional>\n" + "\n".join(rows) + "\n</additional>\n"


def _type_xml(id_: str, kind: Kind, more: dict[str, str]) -> str:
    length, width, height = room_m(kind, kind.size_m)
    keys = {
        "vClass": kind.lane_class,
        "length": length,
        "width": width,
        "height": height,
        "maxSpeed": kind.top_speed_mps,
    }
    if not kind.walks:
        keys |= {"accel": kind.acceleration_mps2, "decel": kind.braking_mps2, "emergencyDecel": 8.0, "sigma": 0.3}
        # across a lane at most 1.2 m/s and 0.15 of the speed along it: a body on wheels cannot move sideways
        keys |= {"maxSpeedLat": 1.2, "lcMaxSpeedLatStanding": 0.0, "lcMaxSpeedLatFactor": 0.15}
    attributes = {key: str(value) for key, value in keys.items()} | more
    return f"<vType id={quoteattr(id_)} " + " ".join(f"{k}={quoteattr(v)}" for k, v in attributes.items()) + "/>"
