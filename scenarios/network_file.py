"""Road networks by name or by file."""

from functools import cache
from pathlib import Path

from contracts import InputError
from sim.road_network import RoadNetwork, read_network

NETWORKS = Path(__file__).parent / "networks"


def network_names() -> tuple[str, ...]:
    """Names of the networks that come with Gantry."""
    return tuple(sorted(path.parent.name for path in NETWORKS.glob("*/*.net.xml")))


@cache
def load_network(name_or_path: str | Path) -> RoadNetwork:
    """The network of that name, or in that ``.net.xml`` file, read once; InputError naming file and fault."""
    path = Path(name_or_path)
    if not path.name.endswith(".net.xml"):
        if str(name_or_path) not in network_names():
            raise InputError(
                f"network {str(name_or_path)!r} is unknown; there are {', '.join(network_names())}, or a .net.xml file"
            )
        path = NETWORKS / path / f"{path}.net.xml"
    return read_network(path)


def routes_of(network: RoadNetwork) -> Path | None:
    """The file of the network's own traffic, which lies beside it; None if there is none."""
    path = network.path.with_name(network.path.name.removesuffix(".net.xml") + ".rou.xml")
    return path if path.is_file() else None
