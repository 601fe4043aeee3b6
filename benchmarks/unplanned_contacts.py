"""Does anybody touch anybody whom no author sent into a collision? On every network, over many seeds.

    python -m benchmarks.unplanned_contacts [--seconds 120 --seeds 3 --density 1 --json]

Nobody is named in these runs: whatever touches is the network's own traffic, which is to drive as people do who see
where they go. No film. Also told: how many users there were at most, and the greatest acceleration and yaw rate.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import scenarios
from bench.scores import Score, to_json
from contracts import Event, EventKind
from contracts.truth import Truth
from sim.road_network import read_network
from sim.traffic import TrafficMotion
from sim.traffic_spec import TrafficSpec

NETWORKS = Path(scenarios.__file__).parent / "networks"
NAMES = tuple(sorted(path.name for path in NETWORKS.iterdir() if path.is_dir()))
FIRST_SEED = 100  # no seed below was looked at while the traffic was mended
PERIOD_NS = 40_000_000
WALKER_M = 1.0  # shorter bodies may turn on the spot


@dataclass(frozen=True)
class Job:
    """One run."""

    network: str
    seed: int
    seconds: float
    density: float


@dataclass(frozen=True)
class Outcome:
    """What happened in it. yaw_radps: of bodies longer than people."""

    job: Job
    contacts: tuple[Event, ...]
    users: int
    acceleration_mps2: float
    yaw_radps: float


def run(job: Job) -> Outcome:
    file = NETWORKS / job.network / f"{job.network}.net.xml"
    routes = file.with_name(f"{job.network}.rou.xml")
    times_ns = range(0, round(job.seconds * 1e9), PERIOD_NS)
    motion = TrafficMotion(read_network(file), routes, TrafficSpec(density=job.density), job.seed)
    truths = list(motion.run(times_ns))
    contacts = tuple(event for truth in truths for event in truth.events if event.kind is EventKind.CONTACT)
    steps = [_step(before, after) for before, after in pairwise(truths)]
    most = np.max(steps, axis=0, initial=0.0)
    return Outcome(job, contacts, max(len(truth.ids) for truth in truths), float(most[0]), float(most[1]))


def _step(before: Truth, after: Truth) -> tuple[float, float]:
    """Greatest acceleration and yaw rate from one frame to the next."""
    rows = [(before.ids.index(id_), row) for row, id_ in enumerate(after.ids) if id_ in before.ids]
    if not rows:
        return 0.0, 0.0
    old, new = np.array(rows).T
    faster = np.linalg.norm(after.velocities_mps[new] - before.velocities_mps[old], axis=1)
    turned = np.abs(np.angle(np.exp(1j * (after.headings_rad[new] - before.headings_rad[old]))))
    turned = turned[after.sizes_m[new, 0] > WALKER_M]
    return faster.max() / (PERIOD_NS * 1e-9), turned.max(initial=0.0) / (PERIOD_NS * 1e-9)


def run_all(jobs: Sequence[Job], workers: int) -> list[Outcome]:
    """Each run in a process of its own, because SUMO runs only once in one."""
    with ProcessPoolExecutor(workers, get_context("spawn"), max_tasks_per_child=1) as pool:
        return list(pool.map(run, jobs))


def scores(outcomes: Sequence[Outcome]) -> list[Score]:
    found = []
    for name in NAMES:
        mine = [outcome for outcome in outcomes if outcome.job.network == name]
        seconds = round(sum(outcome.job.seconds for outcome in mine))
        for key, value, unit in (
            ("contacts", float(sum(len(outcome.contacts) for outcome in mine)), "count"),
            ("users_max", float(max(outcome.users for outcome in mine)), "count"),
            ("acceleration_max", max(outcome.acceleration_mps2 for outcome in mine), "m/s2"),
            ("yaw_rate_max", max(outcome.yaw_radps for outcome in mine), "rad/s"),
        ):
            found.append(Score.of(f"traffic.{name}.{key}", value, unit, seconds))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--density", type=float, default=1.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    seeds = range(FIRST_SEED, FIRST_SEED + asked.seeds)
    outcomes = run_all(
        [Job(name, seed, asked.seconds, asked.density) for name in NAMES for seed in seeds], asked.workers
    )
    if asked.json:
        print(to_json(scores(outcomes)))
        return
    print("| network | seed | contacts | users at most | m/s2 at most | rad/s at most |")
    print("| --- | --- | --- | --- | --- | --- |")
    for outcome in outcomes:
        job, pairs = outcome.job, ", ".join(" - ".join(event.subjects) for event in outcome.contacts)
        print(
            f"| `{job.network}` | {job.seed} | {len(outcome.contacts)} {pairs} | {outcome.users} | "
            f"{outcome.acceleration_mps2:.1f} | {outcome.yaw_radps:.2f} |"
        )


if __name__ == "__main__":
    main()
