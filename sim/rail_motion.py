"""The vehicles' motion on a plant, and its exact truth at any moment.

Time runs in internal steps of ``sim.rail_run.STEP_NS``. At the beginning of a step commands take effect, vehicles ask
for switches over their links, switches begin or end their movement, and each driver chooses one acceleration. Within
the step everything is closed form: the state at any moment, the moments of contacts, of balises passed, of derailments.
So the truth at a moment does not depend on which moments are asked for, and is as exact between two steps as at their
ends.

Whoever touches another vehicle, a buffer stop or a switch that lies against it comes to rest at once. After a contact a
vehicle obeys new commands, as far as they do not press it against the other; a derailed one stands for good.
"""

from collections.abc import Iterable, Iterator

from contracts import InputError
from contracts.truth import Truth
from rail.plant import Plant
from sim.motion_check import check_motion
from sim.motion_spec import MotionSpec
from sim.rail_run import STEP_NS, RailRun


class RailMotion:
    """All motion on ``plant`` that ``spec`` describes; ``seed`` decides which requests of the links are lost.

    Raises MotionFaultError, an InputError, if the plant lacks what the specification names or the start is impossible.
    """

    def __init__(self, plant: Plant, spec: MotionSpec, seed: int) -> None:
        check_motion(plant, spec)
        self._plant, self._spec, self._seed = plant, spec, seed

    def run(self, times_ns: Iterable[int]) -> Iterator[Truth]:
        """The truth at each of ``times_ns``, which must rise from 0 or later; from the start at each call.

        ``Truth.index`` counts them; ``Truth.events`` holds what happened since the previous one, this moment included.
        """
        run = RailRun(self._plant, self._spec, self._seed)
        previous_ns = -1
        for index, time_ns in enumerate(times_ns):
            if time_ns <= previous_ns:
                raise InputError(f"times must rise from 0: {time_ns} ns follows {previous_ns} ns; sort them")
            while run.begin_ns + STEP_NS <= time_ns:
                run.step()
            yield run.truth(index, time_ns)
            previous_ns = time_ns
