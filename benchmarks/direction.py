"""Direction and speed of every scenario's vehicles, from their true places plus noise: how well, and at what cost.

``python -m benchmarks.direction --json`` prints scores named ``analyst.<noise>mm.*``: those of
``bench.scoring.direction`` averaged over the scenarios by their populations (flips are summed), and the processor time
per vehicle and moment. Each place gets independent noise of that size, which its covariance states; nothing is filmed.
"""

import argparse
import math
import time
from collections.abc import Iterator, Sequence

import numpy as np

from bench.matching import gate_m
from bench.recording import Manifest, RecordedStep, Recording
from bench.scores import Score
from bench.scoring.direction import direction_scores
from benchmarks.command import show
from contracts import GroundTracks
from contracts.truth import Truth
from georef.motion import WindowAnalyst
from scenarios.loader import list_scenarios, load_scenario
from scenarios.worlds import build_world

NOISES_M = (0.3e-3, 0.8e-3)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("scenarios", nargs="*", help="names; all of the rail world if none is given")
    options.add_argument("--json", action="store_true", help="print the scores as JSON and nothing else")
    given = options.parse_args()
    names = given.scenarios or [name for name in list_scenarios() if load_scenario(name).world == "rail"]
    truths = {name: [step.truth for step in build_world(load_scenario(name), film=False).steps()] for name in names}
    scores = [score for noise_m in NOISES_M for score in measured(list(truths.values()), noise_m)]
    show(scores, title=f"{len(names)} scenarios", json=given.json)


def measured(runs: Sequence[Sequence[Truth]], noise_m: float) -> Iterator[Score]:
    prefix = f"analyst.{1e3 * noise_m:g}mm"
    seconds, rows = 0.0, 0
    scored: list[list[Score]] = []
    for seed, truths in enumerate(runs):
        recording, cost_s = analysed(truths, noise_m, np.random.default_rng(seed))
        scored.append(direction_scores(recording, gate_m("rail")))
        seconds, rows = seconds + cost_s, rows + sum(len(truth.ids) for truth in truths)
    for same in zip(*scored, strict=True):
        yield together(f"{prefix}.{same[0].name}", same)
    yield Score.of(f"{prefix}.cost_s", seconds / rows, "s", rows)


def together(name: str, scores: Sequence[Score]) -> Score:
    """Counts are summed, root mean squares averaged as squares, everything else as it is, all by population."""
    known = [score for score in scores if score.value is not None]
    n = sum(score.n for score in known)
    power = 2 if "rms" in name else 1
    total = sum(score.value**power * (1 if score.unit == "count" else score.n) for score in known)
    value = total if scores[0].unit == "count" or not n else (total / n) ** (1 / power)
    return Score.of(name, value if n else math.nan, scores[0].unit, n)


def analysed(truths: Sequence[Truth], noise_m: float, rng: np.random.Generator) -> tuple[Recording, float]:
    analyst, steps, seconds = WindowAnalyst(), [], 0.0
    for truth in truths:
        n = len(truth.ids)
        places_m = truth.positions_m[:, :2] + noise_m * rng.normal(size=(n, 2))
        covs_m2 = np.tile(np.eye(2) * noise_m**2, (n, 1, 1))
        fused = GroundTracks("fused", truth.time_ns, np.arange(n), truth.labels, places_m, covs_m2, np.ones(n, bool))
        start = time.thread_time()
        motions = analyst.analyse(fused)
        seconds += time.thread_time() - start
        steps.append(RecordedStep(truth.index, truth.time_ns, truth, (), (), fused, motions, ()))
    manifest = Manifest("", "", "rail", 0, 25.0, {}, (), {}, None, (), ())
    return Recording(manifest, tuple(steps)), seconds


if __name__ == "__main__":
    main()
