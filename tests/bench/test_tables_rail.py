"""The remade tables: planted errors come back as exact figures, and the page holds what was measured."""

import json
import re
from dataclasses import replace
from io import StringIO

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from bench.scoring.rays import to_pixels
from bench.tables.centres import cases, quad_overlap, together
from bench.tables.figure19 import all_cameras_fps, figure19, one_camera_fps
from bench.tables.figure21 import figure21
from bench.tables.films import Watched, film, frames_per_second, light_name, watch
from bench.tables.outlines import Outlines, intersection_over_union, outlines, overlap
from bench.tables.owners import owners
from bench.tables.page import print_parts, tables_page
from bench.tables.part import number
from bench.tables.precision import precision
from bench.tables.rail import Evaluation, evaluate, sequences, write_tables
from bench.tables.region import region
from bench.tables.table1 import WORLD_FROM_PAPER, in_paper_axes, table1
from bench.tables.table3 import table3
from bench.wiring import Stages
from contracts import InputError, Tracks
from georef.calibrated import CalibratedCamera
from perception.silhouette import Silhouette
from scenarios.loader import load_scenario
from sim.light_program import LightChange
from sim.lights import LightPreset
from tests.bench.filmless import filmless_run, overhead_camera

STEPS = 6


def recording(change=lambda tracks, ground: (tracks, ground)):
    """A run of the truth itself, injured by ``change`` in every camera's tracks and all ground tracks."""
    run, _ = filmless_run(steps=STEPS)
    calibrated = tuple(CalibratedCamera(camera, np.zeros((15, 15))) for camera in run.manifest.true_cameras)
    steps = []
    for step in run.steps:
        changed = [change(tracks, ground) for tracks, ground in zip(step.tracks, step.views, strict=True)]
        fused = change(step.tracks[0], step.fused)[1]
        steps.append(
            replace(step, tracks=tuple(t for t, _ in changed), views=tuple(g for _, g in changed), fused=fused)
        )
    return replace(run, manifest=replace(run.manifest, calibrated_cameras=calibrated), steps=tuple(steps))


def watched(run=None, method="hybrid", light="sunny", seconds=(0.01, 0.03)):
    return Watched(
        "painted",
        light,
        method,
        dict.fromkeys(range(STEPS), light),
        run or recording(),
        {name: np.full(STEPS, each) for name, each in zip(("west", "east"), seconds, strict=True)},
    )


def shifted(du_px, dv_px):
    def change(tracks, ground):
        objects, by_px = tracks.objects, np.array([du_px, dv_px])
        there = replace(objects, anchors_px=objects.anchors_px + by_px, quads_px=objects.quads_px + by_px)
        return replace(tracks, objects=there), ground

    return change


def moved(east_m, north_m):
    by_m = np.array([east_m, north_m])
    return lambda tracks, ground: (tracks, replace(ground, positions_m=ground.positions_m + by_m))


def renamed(tracks, ground):
    return replace(tracks, objects=replace(tracks.objects, labels=tracks.objects.labels[::-1])), ground


def by_name(part):
    return {score.name: score.value for score in part.scores}


def test_the_truth_itself_is_precise_at_every_threshold():
    seen = cases(recording())
    assert len(seen) == 2 * 2 * STEPS
    assert seen.precision(np.array([1e-6, 20.0])).tolist() == [1.0, 1.0]
    assert (seen.overlaps > 0.999).all()


@given(st.floats(-15, 15), st.floats(-15, 15))
@settings(max_examples=10, deadline=None)
def test_a_shift_in_the_image_is_the_centre_error(du_px, dv_px):
    seen = cases(recording(shifted(du_px, dv_px)))
    assert np.abs(seen.distances_px - np.hypot(du_px, dv_px)).max() < 1e-9
    assert seen.precision(np.array([np.hypot(du_px, dv_px) + 0.01])).tolist() == [1.0]


def test_a_vehicle_under_another_s_name_is_lost():
    seen = cases(recording(renamed))
    assert seen.precision(np.array([15.0])).tolist() == [0.0]
    nobody = cases(
        recording(lambda tracks, ground: (Tracks([], tracks.objects.empty(tracks.objects.camera, 0, 0)), ground))
    )
    assert np.isinf(nobody.distances_px).all()
    assert (nobody.overlaps == 0).all()
    assert together([seen, nobody]).distances_px.shape == (2 * len(seen),)


@given(st.floats(0, 12), st.floats(-3, 3))
@settings(max_examples=30, deadline=None)
def test_overlap_of_shifted_rectangles_is_that_of_the_formula(shift_px, angle_rad):
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cos, sin], [-sin, cos]])
    box = np.array([[0, 0], [10, 0], [10, 6], [0, 6]], float)
    there = box + np.array([shift_px, 0.0])
    shared = max(0.0, 10 - shift_px) * 6
    assert quad_overlap(box @ turn, there @ turn) == pytest.approx(shared / (120 - shared), abs=1e-9)


def test_overlap_of_masks_counts_pixels():
    a, b = np.zeros((10, 10), bool), np.zeros((10, 10), bool)
    a[:4, :5], b[2:6, :5] = True, True
    assert intersection_over_union(a, b) == 10 / 30
    assert intersection_over_union(a & b & ~a, ~a & a) == 0.0


def test_an_outline_is_held_against_the_vehicle_of_its_name():
    truth = recording().steps[0].truth
    instances = np.zeros((180, 320), np.uint8)
    instances[20:40, 30:60], instances[100:120, 30:60] = 1, 2  # red, blue
    view = replace(truth.cameras[0], instances=instances)
    raw = np.ones((20, 30), np.uint8)
    raw[:5] = 0
    outline = Silhouette(np.array([30, 20]), np.ones_like(raw), raw, ((45.0, 30.0), (30.0, 20.0), 0.0))
    assert overlap(outline, "red", truth, view) == 0.75
    assert overlap(outline, "blue", truth, view) == 0.0
    assert overlap(outline, "green", truth, view) == 0.0
    hidden = replace(view, visible_fractions=np.array([0.5, 1.0]))
    assert np.isnan(overlap(outline, "red", truth, hidden))


def test_speeds_are_frames_over_processor_time():
    one = watched(seconds=(0.01, 0.03))
    assert one_camera_fps([one]) == pytest.approx(100)
    assert all_cameras_fps([one, one]) == pytest.approx(25)
    part = figure19([one], [watched(seconds=(0.04, 0.06), method="detection")])
    assert by_name(part)["figure19.tracking_fps"] == pytest.approx(100)
    assert by_name(part)["figure19.detection_all_cameras_fps"] == pytest.approx(10)
    assert np.isnan(frames_per_second([]))


def test_a_shift_on_the_ground_is_the_root_of_figure_21():
    part = figure21([watched(recording(moved(0.003, -0.001)))])
    scores = by_name(part)
    assert abs(scores["figure21.mse_x_m2"] - 9e-6) < 1e-12
    assert abs(scores["figure21.rms_y_m"] - 0.001) < 1e-12
    (east, *_, as_square, as_metre), _ = part.grids[0].rows
    assert east == "x (east)"
    assert (as_square, as_metre) == ("30", "0.92")
    assert len(part.grids[1].rows) == 10


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
@settings(max_examples=15, deadline=None)
def test_table_1_s_vectors_image_points_as_the_camera_does(east_m, north_m):
    camera = overhead_camera("west", 0.3, distortion=(0, 0, 0, 0, 0))
    fx, fy, cx, cy, *vectors = in_paper_axes(camera)
    rotation, _ = cv2.Rodrigues(np.array(vectors[:3]))
    x, y, z = rotation @ (WORLD_FROM_PAPER.T @ (east_m, north_m, 0.0)) + vectors[3:]
    pixel = to_pixels(camera, np.array([[east_m, north_m, 0.0]]))[0]
    assert np.abs(pixel - (fx * x / z + cx, fy * y / z + cy)).max() < 1e-9
    assert np.abs(vectors[:3]).max() < 1e-9  # straight down: the paper's axes are the camera's


def test_perfect_cameras_have_no_error_in_table_1():
    part = table1([recording().manifest])
    assert max(abs(score.value) for score in part.scores) < 1e-9
    assert [grid.head[0] for grid in part.grids] == ["camera west", "camera east", "sequence"]


def test_the_owner_is_the_stage_that_was_injured_in_the_light_where_it_was():
    def biased(tracks, ground):
        tracks, ground = shifted(2.0, 0.0)(tracks, ground)
        return moved(2 * 2.74 / 500, 0.0)(tracks, ground)

    part = owners([watched(light="dusk"), watched(recording(biased), light="lamps")])
    scores = by_name(part)
    assert scores["owners.dusk.anchor_rms_m"] < 1e-4
    assert scores["owners.lamps.anchor_rms_m"] == pytest.approx(0.01096 / np.sqrt(2), abs=3e-4)
    assert scores["owners.lamps.calibration_rms_m"] < 1e-4
    assert [row[0] for row in part.grids[0].rows] == ["dusk", "lamps", "all"]
    assert part.grids[0].rows[1][-1] == "anchor"


def test_table_3_counts_what_was_lost():
    def half(tracks, ground):
        return tracks, replace(ground, valid=[True, False])

    masks = Outlines(np.array([0.9, 0.7]), np.array([0.5, np.nan]))
    part = table3({"HBP": [watched()], "CRD": [watched(recording(half))]}, {"HBP": [masks], "CRD": [masks]})
    scores = by_name(part)
    assert scores["table3.HBP.recall"] == 1.0
    assert scores["table3.CRD.recall"] == 0.5
    assert scores["table3.HBP.rectangularity"] == pytest.approx(0.8)
    assert scores["table3.HBP.mask_overlap"] == pytest.approx(0.5)
    assert part.grids[0].rows[0][1:5] == ("0.800", "0.79", "50.0", "34")


def test_nothing_seen_gives_dashes_and_invalid_scores():
    part = table3({"HBP": []}, {"HBP": []})
    assert not any(score.valid for score in part.scores if score.unit != "count")
    assert part.grids[0].rows[0][1] == "—"
    assert number(float("nan")) == number(None) == "—"


def evaluation():
    one = watched()
    masks = Outlines(np.array([0.9]), np.array([0.5]))
    return Evaluation(
        [one.recording.manifest], {"HBP": [one]}, {"HBP": [masks]}, {"detection <b>": [one], "hybrid": [one]}
    )


def test_the_page_holds_every_part_and_no_foreign_markup(tmp_path):
    parts = write_tables(evaluation(), tmp_path / "out")
    html = (tmp_path / "out" / "tables.html").read_text()
    for part in parts:
        assert part.title in html
        assert all(f'id="{part.name}-{k}"' in html for k in range(len(part.charts)))
    charts = json.loads(re.search(r'id="charts">(.*?)</script>', html, re.DOTALL)[1])
    assert len(charts) == sum(len(part.charts) for part in parts)
    assert "detection <b>" not in html
    assert json.loads((tmp_path / "out" / "scores.json").read_text())[0]["name"] == "table3.HBP.rectangularity"


def test_no_score_has_a_space_in_its_name():
    assert not [score.name for part in evaluation().parts() for score in part.scores if " " in score.name]


def test_the_terminal_shows_every_table():
    text = StringIO()
    print_parts(evaluation().parts(), Console(file=text, width=160))
    assert "Table 3: detectors" in text.getvalue()
    assert "paper (i5-8250U)" in text.getvalue()


def test_a_page_needs_no_chart():
    assert "<h2>Title</h2>" in tables_page("Title", ["a fact"], [])
    assert precision({"none": []}).grids[0].rows[0][1] == "—"


def test_a_light_that_fades_has_the_names_of_both():
    scenario = replace(
        load_scenario("oval-two-vehicles"),
        light_change=(LightChange(2.0, LightPreset.DUSK, 1.0), LightChange(5.0, LightPreset.LAMPS)),
    )
    names = [light_name(scenario, round(1e9 * t)) for t in (0.0, 1.99, 2.5, 3.0, 4.99, 5.0)]
    assert names == ["sunny", "sunny", "sunny to dusk", "dusk", "dusk", "lamps"]


def test_errors_go_to_the_light_of_their_moment():
    def later(tracks, ground):
        return moved(0.004 if ground.time_ns >= 3 * 40_000_000 else 0.0, 0.0)(tracks, ground)

    one = replace(watched(recording(later)), lights={k: "dusk" if k < 3 else "lamps" for k in range(STEPS)})
    scores = by_name(owners([one]))
    assert abs(scores["owners.dusk.rms_x_m"]) < 1e-12
    assert abs(scores["owners.lamps.rms_x_m"] - 0.004) < 1e-12
    assert abs(scores["owners.all.rms_x_m"] - 0.004 / np.sqrt(2)) < 1e-12


def test_sequences_are_chosen_by_name_or_by_their_split():
    assert [one.name for one in sequences(["oval-two-vehicles"])] == ["oval-two-vehicles"]
    assert {one.split for one in sequences([])} == {"test"}
    assert {one.split for one in sequences([], "train")} == {"train"}
    with pytest.raises(InputError, match="name none beside it"):
        sequences(["oval-two-vehicles"], "test")
    with pytest.raises(InputError, match='split = "tets"'):
        sequences([], "tets")


def test_wrong_input_is_refused(tmp_path):
    with pytest.raises(InputError, match="name scenarios"):
        evaluate([])
    with pytest.raises(InputError, match="--frames 0"):
        evaluate([load_scenario("oval-two-vehicles")], frames=0)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write_tables(evaluation(), tmp_path / "file")


@pytest.mark.film
def test_all_methods_see_the_frames_of_one_film():
    shown = film(load_scenario("oval-two-vehicles"), frames=1, stages=Stages(oracles=("calibrate",)))
    plain = watch(shown, "HBP", Stages().make_perceiver)
    assert [len(times) for times in plain.seconds.values()] == [1, 1]
    assert plain.recording.steps[0].truth.cameras[0].instances is None
    cameras = [one.camera for one in shown.manifest.calibrated_cameras]
    seen = outlines(shown, {camera.name: Stages().make_detector(camera) for camera in cameras})
    assert (seen.rectangularity > 0.85).all()
    assert (seen.overlaps > 0.8).all()
    assert cases(plain.recording).precision(np.array([2.0])).tolist() == [1.0]


def test_each_size_of_the_region_has_its_own_speed_and_precision():
    part = region({1.5: [watched(seconds=(0.001, 0.003))], 3.0: [watched(recording(shifted(3.0, 4.0)))]})
    scores = by_name(part)
    assert scores["region.1.5.fps"] == pytest.approx(500)
    assert (scores["region.1.5.within_1_px"], scores["region.3.within_1_px"]) == (1.0, 0.0)
    assert scores["region.3.median_px"] == pytest.approx(5.0)
    assert [row[0] for row in part.grids[0].rows] == ["1.5", "3", "paper, reduced region"]
    assert part.grids[0].rows[-1][1] == "400"
