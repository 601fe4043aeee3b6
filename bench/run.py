"""The whole bench in one loop: a world is filmed, perception sees the frames, location places them, all is recorded.

Everything else in this room chooses what goes into the loop (``wiring``) or reads what came out of it (``scoring``,
``report``, ``diff``, ``export``).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from bench.ledger import ledger_of
from bench.recording import RecordedStep
from bench.recording_file import Recorder
from contracts import GroundTracks, Motions, Tracks
from contracts.truth import Step

Perception = Callable[[Step], tuple[Tracks, ...]]
Location = Callable[[Step, tuple[Tracks, ...]], tuple[GroundTracks, ...]]


@dataclass(frozen=True)
class Chain:
    """The stages of one run. Honest ones look at ``step.frames`` only; an oracle, named in the manifest, at the truth.

    perceive: the tracks of every camera.
    locate: each camera's tracks on the ground.
    fuse: one row per object over all cameras.
    analyse: how each of them moves.
    """

    perceive: Perception
    locate: Location
    fuse: Callable[[tuple[GroundTracks, ...]], GroundTracks]
    analyse: Callable[[GroundTracks], Motions]


def run(steps: Iterable[Step], chain: Chain, recorder: Recorder) -> None:
    """Send every step through the chain and record what each stage said."""
    for index, step in enumerate(steps):
        tracks = chain.perceive(step)
        views = chain.locate(step, tracks)
        fused = chain.fuse(views)
        motions = chain.analyse(fused)
        ledger = ledger_of(step, tracks, views)
        recorder.write(
            RecordedStep(index, fused.time_ns, step.truth, tracks, views, fused, motions, ledger), step.frames
        )
