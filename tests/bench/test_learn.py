import json

import cv2
import numpy as np
import pytest

from bench.export import export_run
from bench.learn import labelled_frames, learn_models
from bench.roofs import roof_quads_px
from contracts import InputError
from perception.colour_models import ColourModels
from tests.bench.equality import same
from tests.bench.filmless import filmless_run, record


@pytest.fixture(scope="module")
def run():
    return filmless_run(hidden=0.6)


@pytest.fixture(scope="module")
def directory(run, tmp_path_factory):
    return record(tmp_path_factory.mktemp("run"), run)


@pytest.fixture
def coco(directory, tmp_path):
    return export_run(directory, "coco", tmp_path / "coco")


def changed(path, change):
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    return path


def test_a_run_gives_its_frames_with_the_roofs_and_what_shows_of_them(run, directory):
    recording, images = run
    samples = list(labelled_frames(directory))
    assert len(samples) == 8
    for sample, place in zip(samples, [(k, c) for c in range(2) for k in range(4)], strict=True):
        step, camera = place
        truth = recording.steps[step].truth
        assert same(sample.frame, images[step][camera])
        assert sample.labels == ("red", "blue")
        assert sample.visible_fractions.tolist() == [1.0, 0.6]
        expected = roof_quads_px(truth, recording.manifest.true_cameras[camera])
        assert np.abs(sample.roof_quads_px - expected).max() < 1e-9
        assert sample.heights_m.tolist() == [0.06, 0.06]


def test_coco_teaches_the_same_as_the_run_that_it_was_exported_from(directory, coco):
    from_run = {(s.frame.camera, s.frame.index): s for s in labelled_frames(directory)}
    from_coco = {(s.frame.camera, s.frame.index): s for s in labelled_frames(coco)}
    assert from_run.keys() == from_coco.keys()
    for key, sample in from_run.items():
        again = from_coco[key]
        assert same(sample.frame, again.frame)
        assert (sample.labels, sample.heights_m.tolist()) == (again.labels, again.heights_m.tolist())
        assert np.abs(sample.roof_quads_px - again.roof_quads_px).max() < 1e-9


def test_models_are_learned_and_saved(tmp_path):
    directory = record(tmp_path / "run", filmless_run())
    learn_models([directory], tmp_path / "model.json")
    models = ColourModels.load(tmp_path / "model.json").models
    assert [model.label for model in models] == ["blue", "red"]
    for model in models:
        assert np.abs(np.array(model.roof_size_m) - (0.12, 0.06)).max() < 0.0005
        assert abs(model.roof_height_m - 0.06) < 1e-9


def test_an_outline_of_many_corners_becomes_its_smallest_rotated_box(coco):
    ring = [[100 + 20 * np.cos(a) + 0.5, 60 + 20 * np.sin(a) + 0.5] for a in np.arange(0, 2 * np.pi, 0.01)]

    def outline(content):
        content["annotations"] = content["annotations"][:1]
        content["annotations"][0]["segmentation"] = [np.ravel(ring).tolist()]

    sample = next(labelled_frames(changed(coco, outline)))
    assert np.abs(sample.roof_quads_px.mean(axis=1) - [100, 60]).max() < 0.05
    sides = np.linalg.norm(np.diff(sample.roof_quads_px[0], axis=0), axis=1)
    assert np.abs(sides - 40).max() < 0.1


def test_a_mark_without_outline_counts_as_its_upright_box(coco):
    def box_only(content):
        content["annotations"] = content["annotations"][:1]
        content["annotations"][0] |= {"segmentation": [], "bbox": [10.5, 20.5, 30, 40]}

    sample = next(labelled_frames(changed(coco, box_only)))
    assert sample.roof_quads_px.tolist() == [[[10, 20], [40, 20], [40, 60], [10, 60]]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content["annotations"][0].pop("roof_height_m"), "annotation 1 lacks roof_height_m"),
        (lambda content: content["images"][0].pop("focal_px"), "image 1 lacks focal_px and camera_height_m"),
        (lambda content: content["annotations"][0].update(category_id=9), "annotation 1: there is no category 9"),
        (lambda content: content["images"][0].update(file_name="x.png"), r"image 1: .*x\.png is no image"),
        (lambda content: content["images"][0].update(width=1), "320 x 180 pixels, marked as 1 x 180"),
        (lambda content: content.pop("images"), "is no COCO annotation file: .*`images`"),
        (lambda content: content["annotations"][0].update(bbox=[1]), "is no COCO annotation file: .*bbox"),
        (lambda content: content["annotations"][0].update(segmentation=[[1, 2, 3]]), "annotation 1: its outline"),
    ],
)
def test_what_is_wrong_in_a_coco_file_is_named(coco, change, message):
    with pytest.raises(InputError, match=message):
        list(labelled_frames(changed(coco, change)))


def test_an_image_file_that_is_no_image_is_named(coco):
    (coco.parent / "images" / "west_000000.png").write_text("no image")
    with pytest.raises(InputError, match=r"west_000000\.png is no image that can be read"):
        list(labelled_frames(coco))


def test_a_missing_or_foreign_marks_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.json: cannot be read"):
        list(labelled_frames(tmp_path / "none.json"))
    (tmp_path / "bad.json").write_text("{")
    with pytest.raises(InputError, match=r"bad\.json: is no COCO annotation file"):
        list(labelled_frames(tmp_path / "bad.json"))


def test_a_run_without_its_images_teaches_nothing(run, tmp_path):
    record(tmp_path, run, keep_frames=False)
    with pytest.raises(InputError, match="holds no images of camera 'west'"):
        list(labelled_frames(tmp_path))


def test_a_model_that_cannot_be_written_is_named(tmp_path):
    directory = record(tmp_path / "run", filmless_run())
    with pytest.raises(InputError, match="cannot be written"):
        learn_models([directory], tmp_path / "nowhere" / "model.json")


def test_the_marks_of_an_export_lie_on_the_pixels(coco):
    for sample in labelled_frames(coco):
        centre = np.round(sample.roof_quads_px[0].mean(axis=0)).astype(int)
        assert sample.frame.image[centre[1], centre[0]].tolist() == [40, 40, 210]
        assert cv2.contourArea(sample.roof_quads_px[0].astype(np.float32)) > 100
