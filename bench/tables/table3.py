"""Table 3 of paper R: rectangularity and speed of four detectors; and what the paper could not measure."""

from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np

from bench.matching import gate_m
from bench.scores import Score
from bench.scoring.detection import detection_scores
from bench.scoring.population import Population, camera_names, camera_population
from bench.tables.films import Watched, frames_per_second
from bench.tables.outlines import Outlines
from bench.tables.part import Grid, Part, number

PAPER = {"CRD": (0.42, 30.0), "CCR": (0.75, 7.0), "GMM": (0.94, 0.7), "HBP": (0.79, 34.0)}  # rectangularity, fps
HEAD = (
    "detector",
    "rectangularity",
    "paper",
    "fps",
    "paper",
    "recall",
    "precision",
    "mask overlap (IoU)",
    "found",
)


def table3(detectors: Mapping[str, Sequence[Watched]], masks: Mapping[str, Sequence[Outlines]]) -> Part:
    """One row per detector, over all sequences.

    detectors, masks: by the detector's name, what it made of each sequence.
    """
    scores = [score for name in detectors for score in _scores(name, detectors[name], masks[name])]
    rows = [_row(name, [score for score in scores if score.name.startswith(f"table3.{name}.")]) for name in detectors]
    images = max((_images(watched) for watched in detectors.values()), default=0)
    says = (
        "Rectangularity: raw mask pixels over the smallest rotated rectangle, nothing filled, over every accepted "
        "outline. fps: frames of one camera per second of processor time on one thread, frames in memory, all "
        "colours sought at once; the paper's were measured on an i5-8250U. Recall and precision: against the exact "
        "truth, matched on the ground. Mask overlap: raw mask against the exact mask of the vehicle that the "
        "outline is named after. Detectors have no memory, so they are shown frames spread over the sequences: "
        f"{images} of them."
    )
    return Part("table3", "Table 3: detectors", says, (Grid(HEAD, tuple(rows)),), scores=tuple(scores))


def populations(watched: Sequence[Watched]) -> list[Population]:
    """What each camera of each sequence placed on the ground, against the truth."""
    return [
        camera_population(one.recording, camera, gate_m(one.recording.manifest.world))
        for one in watched
        for camera in camera_names(one.recording)
    ]


def _images(watched: Sequence[Watched]) -> int:
    return sum(len(times) for one in watched for times in one.seconds.values())


def _scores(name: str, watched: Sequence[Watched], masks: Sequence[Outlines]) -> list[Score]:
    rectangularity = np.concatenate([np.empty(0), *(one.rectangularity for one in masks)])
    overlaps = np.concatenate([np.empty(0), *(one.overlaps for one in masks)])
    overlaps = overlaps[np.isfinite(overlaps)]
    seconds = list(chain.from_iterable(one.seconds.values() for one in watched))
    prefix = f"table3.{name}"
    return [
        Score.of(f"{prefix}.rectangularity", _mean(rectangularity), "1", len(rectangularity)),
        Score.of(f"{prefix}.fps", frames_per_second(seconds), "1/s", sum(map(len, seconds))),
        Score.of(f"{prefix}.mask_overlap", _mean(overlaps), "1", len(overlaps)),
        *detection_scores(prefix, populations(watched)),
    ]


def _row(name: str, scores: Sequence[Score]) -> tuple[str, ...]:
    value = {score.name.rpartition(".")[2]: score.value for score in scores}
    rectangularity, fps = PAPER.get(name, (None, None))
    return (
        name,
        number(value["rectangularity"], ".3f"),
        number(rectangularity),
        number(value["fps"], ".1f"),
        number(fps, "g"),
        number(value["recall"], ".4f"),
        number(value["precision"], ".4f"),
        number(value["mask_overlap"], ".3f"),
        f"{number(_found(scores), '.0f')} of {number(value['targets'], '.0f')}",
    )


def _found(scores: Sequence[Score]) -> float | None:
    by_end = {score.name.rpartition(".")[2]: score.value for score in scores}
    targets, misses = by_end["targets"], by_end["misses"]
    return None if targets is None or misses is None else targets - misses


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else float("nan")
