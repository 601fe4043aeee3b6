"""Was everything found that is there, and nothing else? Counted per camera frame, matched on the ground."""

from collections.abc import Sequence

from bench.scores import Score
from bench.scoring.population import Population


def detection_scores(prefix: str, populations: Sequence[Population]) -> list[Score]:
    """Recall, precision and F1 of all ``populations`` together, and the counts behind them.

    Recall is not valid without a target, precision not without an estimate, F1 not without either.
    """
    hits = sum(population.hit_count for population in populations)
    misses = sum(population.miss_count for population in populations)
    false_alarms = sum(population.false_alarm_count for population in populations)
    frames = sum(len(population.frames) for population in populations)
    return [
        _share(f"{prefix}.recall", hits, hits + misses),
        _share(f"{prefix}.precision", hits, hits + false_alarms),
        _share(f"{prefix}.f1", 2 * hits, 2 * hits + misses + false_alarms),
        Score.of(f"{prefix}.targets", hits + misses, "count", frames),
        Score.of(f"{prefix}.misses", misses, "count", hits + misses),
        Score.of(f"{prefix}.false_alarms", false_alarms, "count", frames),
    ]


def label_scores(populations: Sequence[Population]) -> list[Score]:
    """Share of the hits that bear the right label, and the number that do not."""
    pairs = [pair for population in populations for pair in _labels(population)]
    right = sum(said == true for said, true in pairs)
    return [
        _share("label.accuracy", right, len(pairs)),
        Score.of("label.wrong", len(pairs) - right, "count", len(pairs)),
    ]


def _labels(population: Population) -> list[tuple[str, str]]:
    hits = population.hits
    return list(zip(hits.labels, hits.object_labels, strict=True))


def _share(name: str, part: int, whole: int) -> Score:
    return Score.of(name, part / whole if whole else 0.0, "1", whole)
