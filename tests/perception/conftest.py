import numpy as np
import pytest
from drawn_frames import training_frames

from perception.colour_models import ColourModels
from perception.learning import learn

LABELS = ("blue", "red")


@pytest.fixture(scope="session")
def models() -> ColourModels:
    """Models of blue and red, learned from drawn frames."""
    return learn(training_frames(1, LABELS, 20))


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)
