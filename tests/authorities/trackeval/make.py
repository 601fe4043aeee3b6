"""Makes ``sequences.json`` and ``trackeval.json`` beside it: small sequences, and TrackEval's raw output for them.

TrackEval needs the windowed OpenCV, so it gets an environment of its own:

    python3 -m venv /tmp/trackeval && /tmp/trackeval/bin/pip install trackeval==1.3.0
    /tmp/trackeval/bin/python tests/authorities/trackeval/make.py
"""

import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
from trackeval.metrics import CLEAR, HOTA, Identity

HERE = Path(__file__).parent
FAULTS = ("missed", "ghosts", "swap")  # share missed, ghosts per frame, chance of two ids changing places
CASES = {  # name: (seed, objects, frames, *FAULTS)
    "clean": (1, 3, 12, 0.0, 0.0, 0.0),
    "missed": (2, 4, 20, 0.3, 0.0, 0.0),
    "haunted": (3, 3, 20, 0.1, 0.8, 0.0),
    "swapped": (4, 5, 25, 0.1, 0.2, 0.3),
    "crowded": (5, 8, 30, 0.2, 1.5, 0.15),
    "sparse": (6, 1, 15, 0.6, 0.3, 0.5),
    "no tracks": (7, 2, 5, 1.0, 0.0, 0.0),
    "no objects": (8, 0, 6, 0.0, 1.0, 0.0),
}


def sequence(seed: int, objects: int, frames: int, *, missed: float, ghosts: float, swap: float) -> list[dict]:
    """Objects on a random walk, tracks that follow them roughly; ids are numbered from 0 over the sequence."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 1, (objects, 2))
    names = np.arange(objects)
    rows = []
    for _ in range(frames):
        places = places + rng.normal(0, 0.05, places.shape)
        if objects > 1 and rng.random() < swap:
            a, b = rng.choice(objects, 2, replace=False)
            names[[a, b]] = names[[b, a]]
        present = np.flatnonzero(rng.random(objects) > 0.1)
        seen = present[rng.random(len(present)) >= missed]
        ghost_count = rng.poisson(ghosts)
        tracked = np.concatenate(
            [places[seen] + rng.normal(0, 0.06, (len(seen), 2)), rng.uniform(0, 1, (ghost_count, 2))]
        )
        ids = np.concatenate([names[seen], objects + rng.choice(6, ghost_count, replace=False)])
        distances = np.linalg.norm(places[present][:, None] - tracked[None], axis=2)
        similarity = np.round(np.maximum(0, 1 - distances / 0.4), 6)
        rows.append({"objects": present.tolist(), "tracks": ids.tolist(), "similarity": similarity.tolist()})
    return renumbered(rows)


def renumbered(rows: list[dict]) -> list[dict]:
    """TrackEval wants the ids of a sequence without gaps."""
    for key in ("objects", "tracks"):
        numbers = {name: k for k, name in enumerate(sorted({name for row in rows for name in row[key]}))}
        for row in rows:
            row[key] = [numbers[name] for name in row[key]]
    return rows


def raw_output(rows: list[dict]) -> dict:
    """Every field of TrackEval's three metrics."""
    data = {
        "gt_ids": [np.array(row["objects"], dtype=int) for row in rows],
        "tracker_ids": [np.array(row["tracks"], dtype=int) for row in rows],
        "similarity_scores": [
            np.array(row["similarity"], dtype=float).reshape(len(row["objects"]), len(row["tracks"])) for row in rows
        ],
        "num_timesteps": len(rows),
    }
    data["num_gt_dets"] = sum(len(ids) for ids in data["gt_ids"])
    data["num_tracker_dets"] = sum(len(ids) for ids in data["tracker_ids"])
    data["num_gt_ids"] = len({name for ids in data["gt_ids"] for name in ids.tolist()})
    data["num_tracker_ids"] = len({name for ids in data["tracker_ids"] for name in ids.tolist()})
    quiet = {"PRINT_CONFIG": False}
    metrics = {
        "CLEAR": CLEAR({"THRESHOLD": 0.5} | quiet),
        "Identity": Identity({"THRESHOLD": 0.5} | quiet),
        "HOTA": HOTA(),
    }
    return {name: plain(metric.eval_sequence(data)) for name, metric in metrics.items()}


def plain(result: dict) -> dict:
    return {key: np.asarray(value, dtype=float).tolist() for key, value in result.items()}


def write(name: str, content: dict) -> None:
    lines = json.dumps(content).replace('}, {"objects"', '},\n{"objects"').replace('}, "', '},\n"')
    (HERE / name).write_text(lines + "\n")


sequences = {name: sequence(*shape[:3], **dict(zip(FAULTS, shape[3:], strict=True))) for name, shape in CASES.items()}
write("sequences.json", sequences)
write(
    "trackeval.json",
    {"trackeval": {"version": version("trackeval")}} | {k: raw_output(v) for k, v in sequences.items()},
)
