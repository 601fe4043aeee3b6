"""The networks that come with Gantry, for tests."""

from functools import cache
from pathlib import Path

import scenarios
from sim.road_network import RoadNetwork, read_network

NETWORKS = Path(scenarios.__file__).parent / "networks"
NAMES = tuple(sorted(path.name for path in NETWORKS.iterdir() if path.is_dir()))


def path_of(name: str) -> Path:
    return NETWORKS / name / f"{name}.net.xml"


@cache
def network(name: str) -> RoadNetwork:
    return read_network(path_of(name))
