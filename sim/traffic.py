"""The traffic's motion on a road network, and its exact truth at any moment.

SUMO decides who goes where, in steps of 50 ms; ``sim.smooth_motion`` draws bodies along behind, which are the truth and
what is filmed. SUMO runs 0.65 s ahead of them, because a smooth body needs to know what comes. Whoever touches somebody
else comes to rest, and SUMO is told where, so that the others see the wreck.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

from contracts import InputError
from contracts.truth import Truth
from sim.road_network import RoadNetwork
from sim.smooth_motion import SPAN
from sim.sumo_run import STEP_S, SumoRun
from sim.traffic_check import check_traffic
from sim.traffic_run import TrafficRun
from sim.traffic_spec import WARM_UP_S, TrafficSpec
from sim.user_sizes import Sizes

_AHEAD = SPAN // 2 + 1  # steps by which SUMO is ahead of the step whose motion is decided
STEP_NS = round(STEP_S * 1e9)


class TrafficMotion:
    """All traffic on ``network`` that ``spec`` describes.

    routes: SUMO's file of the network's own traffic; None for a network without any.
    seed: decides that traffic; who is named in ``spec`` does exactly what it says, as far as the others let them.
    Raises TrafficFaultError, an InputError, if the network lacks what the specification names.
    """

    def __init__(self, network: RoadNetwork, routes: Path | None, spec: TrafficSpec, seed: int) -> None:
        check_traffic(network, spec)
        self._network, self._routes, self._spec, self._seed = network, routes, spec, seed

    def run(self, times_ns: Iterable[int]) -> Iterator[Truth]:
        """The truth at each of ``times_ns``, which must rise from 0 or later; from the start at each call.

        The traffic runs to its end before the first truth is handed out, so that SUMO is free again.
        """
        return iter(list(self._run(times_ns)))

    def _run(self, times_ns: Iterable[int]) -> Iterator[Truth]:
        with SumoRun(self._network, self._routes, self._spec, self._seed) as sumo:
            run = TrafficRun(sumo, self._spec, Sizes(self._seed))
            for _ in range(round(WARM_UP_S / STEP_S) + _AHEAD):
                run.step()
            previous_ns = -1
            for index, time_ns in enumerate(times_ns):
                if time_ns <= previous_ns:
                    raise InputError(f"times must rise from 0: {time_ns} ns follows {previous_ns} ns; sort them")
                while run.begin_ns + STEP_NS <= time_ns:
                    run.step()
                yield run.truth(index, time_ns)
                previous_ns = time_ns
