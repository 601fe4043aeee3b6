"""The road's tables: planted errors come back exactly, and a camera's film goes through as a whole."""

import numpy as np
import pytest

from bench.tables.ranges import PlaceErrors, ranges
from bench.tables.road import RoadEvaluation, roads
from bench.tables.road_film import CALIBRATORS, film_road
from bench.tables.tablea1 import POINTS, Projected, table_a1
from contracts import InputError

NOTHING = dict.fromkeys(CALIBRATORS, 0)


def projected(errors_m):
    errors = np.asarray(errors_m, float)
    return Projected(
        "pole", "lane", np.zeros((len(errors), 2)), np.zeros((len(errors), 2)), np.zeros((len(errors), 2)), errors
    )


def scores(part):
    return {score.name: score.value for score in part.scores}


def test_planted_distances_come_back():
    part = table_a1({"whole": [projected([0.3, 0.4]), projected([0.0])], "frames": []})
    found = scores(part)
    assert found["tableA1.whole.mean_m"] == pytest.approx(0.7 / 3, abs=1e-12)
    assert found["tableA1.whole.rms_m"] == pytest.approx(np.sqrt(0.25 / 3), abs=1e-12)
    assert found["tableA1.whole.largest_m"] == 0.4
    assert found["tableA1.whole.smallest_m"] == 0.0
    assert not next(score for score in part.scores if score.name == "tableA1.frames.mean_m").valid
    assert len(part.grids[1].rows) == 2  # the first lane in full


def test_errors_fall_into_their_ranges_and_places_without_one_are_left_out():
    seen = {name: [] for name in CALIBRATORS}
    seen["whole"] = [
        PlaceErrors(
            np.array([5.0, 25.0, 25.0, 45.0, 39.0]),
            np.array([0.1, 0.3, 0.4, 2.0, np.nan]),
            np.array([True, True, False, True, False]),
        )
    ]
    found = scores(ranges(seen, NOTHING))
    assert found["ranges.whole.rms_0_20_m"] == pytest.approx(0.1, abs=1e-12)
    assert found["ranges.whole.rms_20_30_m"] == pytest.approx(np.sqrt(0.125), abs=1e-12)
    assert found["ranges.whole.rms_40_50_m"] == pytest.approx(2.0, abs=1e-12)
    assert found["ranges.whole.mean_within_40_m"] == pytest.approx(0.8 / 3, abs=1e-12)
    assert found["ranges.whole.rms_30_40_m"] is None
    assert found["ranges.whole.coverage_90"] == 0.75
    assert found["ranges.frames.coverage_90"] is None


def test_scenarios_of_the_rail_are_refused():
    with pytest.raises(InputError, match="oval-one-vehicle is no scenario of the road"):
        roads(["oval-one-vehicle"])
    assert {scenario.network for scenario in roads([])} == {"crossroads", "avenue", "merge", "roundabout"}


@pytest.mark.film
def test_pose_and_lens_of_filmed_cameras_come_back_from_their_frames():
    evaluation = RoadEvaluation()
    for filmed in film_road(roads(["avenue-day"])[0]):
        evaluation.add(filmed)
    parts = {part.name: part for part in evaluation.parts()}
    found = scores(parts["tableA1"]) | scores(parts["ranges"])
    assert found["ranges.frames.mean_within_40_m"] <= 0.15
    assert found["tableA1.frames.mean_m"] <= 0.15
    assert found["tableA1.frames.largest_m"] <= 0.48
    assert all(len(one.errors_m) == POINTS for one in evaluation.lanes["frames"])
    assert parts["lanes"].picture.startswith("<img")
