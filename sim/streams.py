"""Random streams: one per concern, so that adding noise to one camera changes no traffic."""

import hashlib

import numpy as np


def stream(seed: int, concern: str) -> np.random.Generator:
    """The generator for ``concern`` (for example ``"pose/west"``) under ``seed``; independent of all other concerns."""
    words = np.frombuffer(hashlib.sha256(concern.encode()).digest()[:16], dtype="<u4")
    return np.random.default_rng(np.random.SeedSequence([seed, *words.tolist()]))
