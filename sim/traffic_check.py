"""Whether a specification of traffic fits a network: each fault with the key at which it stands."""

from contracts import InputError
from sim.road_network import RoadNetwork
from sim.traffic_spec import DriverSpec, TrafficSpec


class TrafficFaultError(InputError):
    """A specification that the network cannot serve.

    keys: where the fault stands, in the words of a scenario file: ``("vehicle", 0, "route")``.
    """

    def __init__(self, keys: tuple[str | int, ...], what: str) -> None:
        super().__init__(what)
        self.keys = keys


def check_traffic(network: RoadNetwork, spec: TrafficSpec) -> None:
    """Raise TrafficFaultError for the first thing in ``spec`` that ``network`` does not have."""
    for index, driver in enumerate(spec.drivers):
        _check_route(network, driver, ("vehicle", index, "route"))
        first = network.edges[driver.route[0]]
        if driver.lane is not None and driver.lane >= len(first.lanes):
            what = f"edge {first.id} has {len(first.lanes)} lanes, from 0; there is no lane {driver.lane}"
            raise TrafficFaultError(("vehicle", index, "lane"), what)
    ids = [driver.id for driver in spec.drivers]
    for index, event in enumerate(spec.events):
        if event.vehicle not in ids:
            what = f"vehicle {event.vehicle!r} is unknown; there are {', '.join(ids) or 'none'}"
            raise TrafficFaultError(("event", index, "vehicle"), what)


def _check_route(network: RoadNetwork, driver: DriverSpec, keys: tuple[str | int, ...]) -> None:
    roads = [road.id for road in network.roads]
    for edge in driver.route:
        if edge not in roads:
            raise TrafficFaultError(keys, f"edge {edge!r} is unknown; there are {', '.join(roads)}")
    ways = {(c.from_lane.rsplit("_", 1)[0], c.to_lane.rsplit("_", 1)[0]) for c in network.connections}
    for a, b in zip(driver.route, driver.route[1:], strict=False):
        if (a, b) not in ways:
            raise TrafficFaultError(keys, f"no lane leads from {a} to {b}")
