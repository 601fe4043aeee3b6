"""The shipped models on rendered frames of a scenario that nothing was learned from; 18 frames."""

from dataclasses import replace

import numpy as np
import pytest

from perception.hbp import HistogramBackProjection
from scenarios.loader import load_scenario
from scenarios.worlds import build_world
from sim.lights import LightPreset

WHOLE = 0.98  # visible share from which a vehicle counts as whole
LEAST_SEEN = 0.8


@pytest.mark.film
@pytest.mark.parametrize("light", ["sunny", "lamps", "dusk"])
def test_every_vehicle_is_found_where_it_is_and_no_other(light):
    scenario = replace(load_scenario("oval-two-vehicles"), light=LightPreset(light), duration_s=9.0, fps=1 / 3)
    detector = HistogramBackProjection()
    errors, normalised = [], []
    for step in build_world(scenario).steps():
        for frame, view in zip(step.frames, step.truth.cameras, strict=True):
            found = detector.detect(frame)
            seen = dict(zip(step.truth.labels, view.visible_fractions.tolist(), strict=True))
            assert {label for label, share in seen.items() if share >= LEAST_SEEN} <= set(found.labels)
            assert all(seen.get(label, 0) > 0 for label in found.labels)
            for row, label in enumerate(found.labels):
                error = found.anchors_px[row] - view.roofs_px[step.truth.labels.index(label)]
                normalised.append(error @ np.linalg.inv(found.anchor_covs_px2[row]) @ error)
                if seen[label] >= WHOLE:
                    errors.append(error)
    assert len(errors) >= 4
    assert np.sqrt(np.mean(np.square(errors))) < 0.2
    assert np.mean(normalised) < 8
