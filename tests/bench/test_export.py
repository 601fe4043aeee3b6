import configparser
import csv
import json
from dataclasses import replace

import cv2
import numpy as np
import pyproj
import pytest

from bench.export import EXPORTS, export_run
from bench.export.geojson import feature_collection, local_metres
from bench.export.mot import track_lines, truth_lines
from contracts import InputError
from tests.bench.filmless import filmless_run, record

PIXEL = 0.5  # from an edge that counts from the image's corner to one that counts from the first pixel's centre


@pytest.fixture(scope="module")
def run():
    return filmless_run(hidden=0.6)


@pytest.fixture(scope="module")
def directory(run, tmp_path_factory):
    return record(tmp_path_factory.mktemp("run"), run)


@pytest.fixture(scope="module")
def exported(directory, tmp_path_factory):
    out = tmp_path_factory.mktemp("exports")
    return {to: export_run(directory, to, out / to) for to in EXPORTS}


def rows(path):
    with path.open(newline="") as stream:
        return [[float(value) for value in row] for row in csv.reader(stream)]


def test_mot_tracks_are_read_back(run, exported):
    recording, _ = run
    read = rows(exported["mot"] / "west" / "tracks.txt")
    expected = [
        [step.index + 1, number + 1, *tracks.objects.boxes_px[row], tracks.objects.scores[row]]
        for step in recording.steps
        for tracks in step.tracks[:1]
        for row, number in enumerate(tracks.ids.tolist())
    ]
    assert len(read) == len(expected) == 8
    for got, (frame, number, x1, y1, x2, y2, score) in zip(read, expected, strict=True):
        assert got[:2] == [frame, number]
        box = [got[2] - 1 - PIXEL, got[3] - 1 - PIXEL, got[2] + got[4] - 1 - PIXEL, got[3] + got[5] - 1 - PIXEL]
        assert np.abs(np.subtract(box, [x1, y1, x2, y2])).max() < 2e-4
        assert got[6:] == [score, -1, -1, -1]


def test_a_box_at_the_left_edge_of_the_image_begins_at_one(run):
    recording, _ = run
    tracks = recording.steps[0].tracks[0]
    boxes = np.array([[-0.5, -0.5, 9.5, 19.5]] * 2)
    moved = replace(tracks, objects=replace(tracks.objects, boxes_px=boxes))
    step = replace(recording.steps[0], tracks=(moved,))
    assert next(track_lines(replace(recording, steps=(step,)), "west")).startswith("1,1,1.0000,1.0000,10.0000,20.0000,")


def test_mot_truth_marks_what_is_hardly_visible_as_a_distractor(exported):
    read = rows(exported["mot"] / "east" / "gt" / "gt.txt")
    assert [row[:2] + row[6:] for row in read[:3]] == [[1, 1, 1, 1, 1], [1, 2, 0, 8, 0.6], [2, 1, 1, 1, 1]]
    assert (exported["mot"] / "east" / "gt" / "identities.txt").read_text() == "1 a\n2 b\n"


def test_mot_truth_without_a_box_is_left_out(run):
    recording, _ = run
    truth = recording.steps[0].truth
    behind = replace(truth.cameras[0], full_boxes_px=np.full((2, 4), np.nan))
    unseen = replace(truth.cameras[0], visible_fractions=np.zeros(2))
    for view in (behind, unseen):
        step = replace(recording.steps[0], truth=replace(truth, cameras=(view,)))
        assert list(truth_lines(replace(recording, steps=(step,)), "west")) == []


def test_mot_sequences_say_what_they_are(exported):
    parser = configparser.ConfigParser()
    parser.optionxform = str
    parser.read(exported["mot"] / "west" / "seqinfo.ini")
    assert dict(parser["Sequence"]) == {
        "name": "west",
        "imDir": "img1",
        "frameRate": "25",
        "seqLength": "4",
        "imWidth": "320",
        "imHeight": "180",
        "imExt": ".png",
    }


def test_mot_comes_with_the_images(run, exported):
    files = sorted((exported["mot"] / "west" / "img1").iterdir())
    assert [file.name for file in files] == [f"{number:06d}.png" for number in range(1, 5)]
    assert np.array_equal(cv2.imread(str(files[0])), run[1][0][0].image)


def test_the_images_alone_are_as_they_were_seen(run, exported, tmp_path):
    files = sorted((exported["images"] / "west").iterdir())
    assert [file.name for file in files] == [f"{index:06d}.png" for index in range(4)]
    assert np.array_equal(cv2.imread(str(files[2])), run[1][2][0].image)
    record(tmp_path / "run", run, keep_frames=False)
    with pytest.raises(InputError, match="holds no images: only `gantry run --frames` keeps them"):
        export_run(tmp_path / "run", "images", tmp_path / "images")
    assert not (tmp_path / "images").exists()


def test_coco_polygons_cover_the_painted_roofs(exported):
    """OpenCV counts from pixel centres, COCO from the image's corner: half a pixel lies between them."""
    content = json.loads(exported["coco"].read_text())
    names = {category["id"]: category["name"] for category in content["categories"]}
    files = {image["id"]: exported["coco"].parent / image["file_name"] for image in content["images"]}
    assert len(content["annotations"]) == 16
    for mark in content["annotations"]:
        image = cv2.imread(str(files[mark["image_id"]]))
        mask = np.zeros(image.shape[:2], np.uint8)
        outline = np.array(mark["segmentation"][0]).reshape(-1, 2) - PIXEL
        cv2.fillConvexPoly(mask, np.round(outline).astype(np.int32), 1)
        colours = np.unique(image[mask == 1], axis=0)
        assert {"red": [[40, 40, 210]], "blue": [[210, 70, 30]]}[names[mark["category_id"]]] == colours.tolist()


def test_coco_boxes_and_areas_fit_their_polygons(exported):
    for mark in json.loads(exported["coco"].read_text())["annotations"]:
        outline = np.array(mark["segmentation"][0]).reshape(-1, 2)
        low, high = outline.min(axis=0), outline.max(axis=0)
        assert np.abs(np.array(mark["bbox"]) - [*low, *(high - low)]).max() < 1e-9
        assert abs(mark["area"] - cv2.contourArea(outline.astype(np.float32))) < 1e-2
        assert mark["visible_fraction"] == {"a": 1.0, "b": 0.6}[mark["object"]]


def test_coco_numbers_are_unique_and_refer_to_each_other(exported):
    content = json.loads(exported["coco"].read_text())
    ids = {name: [entry["id"] for entry in content[name]] for name in ("images", "annotations", "categories")}
    assert all(len(set(numbers)) == len(numbers) for numbers in ids.values())
    assert {mark["image_id"] for mark in content["annotations"]} <= set(ids["images"])
    assert {mark["category_id"] for mark in content["annotations"]} <= set(ids["categories"])


def test_without_recorded_images_there_are_only_annotations(run, tmp_path):
    record(tmp_path / "run", run, keep_frames=False)
    path = export_run(tmp_path / "run", "coco", tmp_path / "coco")
    assert [file.name for file in path.parent.iterdir()] == ["annotations.json"]


def test_a_plant_in_a_room_is_put_nowhere_on_the_globe(exported):
    content = json.loads(exported["geojson"].read_text())
    assert content["type"] == "FeatureCollection"
    assert {feature["geometry"] for feature in content["features"]} == {None}
    assert "not on WGS84" in content["local_frame"]["note"]
    first = content["features"][0]["properties"]
    assert first == {
        "kind": "truth",
        "identity": "a",
        "label": "red",
        "index": 0,
        "time_ns": 0,
        "position_m": [-0.3, 0.1],
    }
    assert len(content["features"]) == 4 * 4


def test_a_world_on_the_globe_is_exported_in_degrees():
    recording, _ = filmless_run(geo=local_metres(lat_deg=52.5, lon_deg=13.4))
    content = feature_collection(recording)
    assert "local_frame" not in content
    geod = pyproj.Geod(ellps="WGS84")
    for feature in content["features"]:
        lon_deg, lat_deg = feature["geometry"]["coordinates"]
        azimuth_deg, _, distance_m = geod.inv(13.4, 52.5, lon_deg, lat_deg)
        azimuth_rad = np.radians(azimuth_deg)
        again_m = distance_m * np.array([np.sin(azimuth_rad), np.cos(azimuth_rad)])
        assert np.linalg.norm(again_m - feature["properties"]["position_m"]) < 2e-4


def test_a_geo_reference_that_is_none_is_named():
    recording, _ = filmless_run(steps=1, geo="somewhere")
    with pytest.raises(InputError, match="geo 'somewhere' is no PROJ string"):
        feature_collection(recording)


def test_an_unlocated_track_is_left_out(run):
    recording, _ = run
    fused = replace(recording.steps[0].fused, valid=[True, False])
    step = replace(recording.steps[0], fused=fused)
    features = feature_collection(replace(recording, steps=(step,)))["features"]
    assert [feature["properties"]["kind"] for feature in features] == ["truth", "truth", "estimate"]


def test_real_footage_has_no_truth_to_export(run, tmp_path):
    recording, images = run
    blind = replace(recording, steps=tuple(replace(step, truth=None) for step in recording.steps))
    record(tmp_path / "run", (blind, images))
    assert (export_run(tmp_path / "run", "mot", tmp_path / "mot") / "west" / "gt" / "gt.txt").read_text() == ""
    with pytest.raises(InputError, match="holds no truth of images"):
        export_run(tmp_path / "run", "coco", tmp_path / "coco")


def test_a_run_without_tracks_has_nothing_for_mot(run, tmp_path):
    recording, images = run
    empty = replace(recording, steps=tuple(replace(step, tracks=()) for step in recording.steps))
    record(tmp_path / "run", (empty, images))
    with pytest.raises(InputError, match="holds no tracks in images"):
        export_run(tmp_path / "run", "mot", tmp_path / "mot")


def test_an_unknown_format_is_refused(directory, tmp_path):
    with pytest.raises(InputError, match="no export to 'xml', choose from mot, coco, geojson"):
        export_run(directory, "xml", tmp_path)


def test_an_export_into_a_file_is_refused(directory, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="taken cannot be written to"):
        export_run(directory, "geojson", tmp_path / "taken")
