import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import Camera, InputError, Intrinsics, Pose
from georef.calibrated import PARAMETERS, CalibratedCamera
from georef.camera_file import read_camera, read_stored, write_camera, write_stored
from georef.camera_forms import CameraForm, StoredCamera
from georef.geo_reference import GeoReference

GOOD = {
    "name": "west",
    "width_px": 320,
    "height_px": 180,
    "fx_px": 500,
    "fy_px": 501.5,
    "cx_px": 159.5,
    "cy_px": 89.5,
    "distortion": [0.1, 0, 0, 0, 0],
    "position_m": [1, 2, 2.8],
    "world_from_camera": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
}


def written(tmp_path, **changes):
    content = {key: value for key, value in (GOOD | changes).items() if value is not None}
    path = tmp_path / "camera.yaml"
    path.write_text(yaml.safe_dump(content))
    return path


def test_a_camera_is_read(tmp_path):
    calibrated = read_camera(written(tmp_path))
    camera = calibrated.camera
    assert (camera.name, camera.intrinsics.width_px, camera.intrinsics.height_px) == ("west", 320, 180)
    assert camera.intrinsics.matrix.tolist() == [[500, 0, 159.5], [0, 501.5, 89.5], [0, 0, 1]]
    assert camera.intrinsics.distortion.tolist() == [0.1, 0, 0, 0, 0]
    assert camera.pose.position_m.tolist() == [1, 2, 2.8]
    assert camera.pose.world_from_camera.tolist() == [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
    assert not calibrated.covariance.any()


def test_numbers_may_have_an_exponent_without_a_point(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text().replace("fx_px: 500", "fx_px: 5e2"))
    assert read_camera(path).camera.intrinsics.fx_px == 500.0


@settings(max_examples=30, deadline=None)
@given(rvec=st.tuples(*[st.floats(-3, 3)] * 3), position_m=st.tuples(*[st.floats(0.1, 9)] * 3))
def test_opencv_s_pose_means_the_same_camera(tmp_path_factory, rvec, position_m):
    tvec = -cv2.Rodrigues(np.array(rvec))[0] @ position_m
    opencv = {"position_m": None, "world_from_camera": None, "rvec": list(rvec), "tvec": tvec.tolist()}
    pose = read_camera(written(tmp_path_factory.mktemp("camera"), **opencv)).camera.pose
    point_in_world = np.array([0.3, -0.2, 0.1])
    expected = cv2.Rodrigues(np.array(rvec))[0] @ point_in_world + tvec
    assert np.abs(pose.world_from_camera.T @ (point_in_world - pose.position_m) - expected).max() < 1e-9


def test_standard_deviations_become_a_covariance(tmp_path):
    sigmas = {"fx_px": 2.0, "k1": 0.01, "rz_rad": 0.001, "x_m": 0.003}
    calibrated = read_camera(written(tmp_path, sigmas=sigmas))
    diagonal = dict(zip(PARAMETERS, np.diag(calibrated.covariance).tolist(), strict=True))
    expected = {"fx": 4.0, "k1": 1e-4, "rz": 1e-6, "x": 9e-6}
    assert all(abs(diagonal[name] - expected.get(name, 0.0)) < 1e-15 for name in PARAMETERS)
    assert np.count_nonzero(calibrated.covariance) == 4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": None}, "missing required field `name`"),
        ({"fx_px": "wide"}, r"Expected `float`, got `str` - at `\$\.fx_px`"),
        ({"focal": 3}, "contains unknown field `focal`"),
        ({"fx_px": float("nan")}, "must be finite"),
        ({"distortion": [0, 0]}, r"length 5.*distortion"),
        ({"position_m": None}, "give the pose either as position_m and world_from_camera, or as rvec and tvec"),
        ({"rvec": [0, 0, 0]}, "give the pose either as"),
        ({"position_m": [0, 0, float("nan")]}, "Pose.position_m holds NaN"),
        ({"position_m": [0, 0, -1]}, "lies below the ground"),
        ({"world_from_camera": [[1, 0, 0], [0, 1, 0], [0, 0, 2]]}, "is not a rotation matrix"),
        ({"sigmas": {"fx": 1}}, "sigmas.fx: no such parameter, choose from fx_px, fy_px"),
        ({"covariance": [[1.0]]}, r"covariance has shape \(1, 1\), expected 15 x 15"),
        ({"covariance": [[1.0]], "sigmas": {"k1": 1}}, "give either sigmas or covariance, not both"),
        ({"sigmas": {"x_m": -1}}, "sigmas.x_m = -1.0 must not be negative"),
    ],
)
def test_what_is_wrong_is_named_with_its_file(tmp_path, changes, message):
    with pytest.raises(InputError, match=f"camera.yaml: .*{message}"):
        read_camera(written(tmp_path, **changes))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "Expected `object`"),
        (b"{", "is not YAML"),
        (b"\xff\xfe\xfa", "is no UTF-8"),
        (b"- 1", "Expected `object`"),
    ],
)
def test_a_file_that_is_no_camera_is_named(tmp_path, data, message):
    (tmp_path / "camera.yaml").write_bytes(data)
    with pytest.raises(InputError, match=f"camera.yaml: .*{message}"):
        read_camera(tmp_path / "camera.yaml")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.yaml: cannot be read: No such file"):
        read_camera(tmp_path / "absent.yaml")


@settings(max_examples=20, deadline=None)
@given(numbers=st.lists(st.floats(1e-300, 1e300), min_size=9, max_size=9), rvec=st.tuples(*[st.floats(-3, 3)] * 3))
def test_a_camera_is_read_back_to_the_bit(tmp_path_factory, numbers, rvec):
    pose = Pose(cv2.Rodrigues(np.array(rvec))[0], np.array(numbers[:3]))
    intrinsics = Intrinsics(640, 480, *numbers[3:7], np.array([0.1, -1e-17, 0, 1e300, -0.0]))
    camera = CalibratedCamera(Camera("süd: 1", intrinsics, pose), np.full((15, 15), numbers[8]))
    path = tmp_path_factory.mktemp("camera") / "camera.yaml"
    write_camera(path, camera)
    again = read_camera(path)
    assert again.camera.name == "süd: 1"
    assert again.camera.intrinsics.matrix.tolist() == intrinsics.matrix.tolist()
    assert again.camera.intrinsics.distortion.tobytes() == intrinsics.distortion.tobytes()
    assert again.camera.pose.world_from_camera.tobytes() == pose.world_from_camera.tobytes()
    assert again.camera.pose.position_m.tobytes() == pose.position_m.tobytes()
    assert again.covariance.tobytes() == camera.covariance.tobytes()


def test_a_place_that_cannot_be_written_to_is_named(tmp_path):
    camera = read_camera(written(tmp_path))
    with pytest.raises(InputError, match="cannot be written"):
        write_camera(tmp_path / "nowhere" / "camera.yaml", camera)


FORMS = st.sampled_from(list(CameraForm))


@settings(max_examples=30, deadline=None)
@given(
    form=FORMS, rvec=st.tuples(*[st.floats(-3, 3)] * 3), numbers=st.lists(st.floats(0.1, 2e3), min_size=8, max_size=8)
)
def test_every_form_reads_back_what_it_wrote(tmp_path_factory, form, rvec, numbers):
    pose = Pose(cv2.Rodrigues(np.array(rvec))[0], np.array(numbers[:3]))
    intrinsics = Intrinsics(640, 480, *numbers[3:7], np.array([0.1, -0.02, 1e-4, 0, 0.3]))
    geo = GeoReference(37.398, 127.112)
    stored = StoredCamera("south-1", intrinsics, pose, np.diag(np.full(15, numbers[7])), geo)
    path = tmp_path_factory.mktemp("camera") / "camera.yaml"
    write_stored(path, stored, form)
    again = read_stored(path)
    assert (again.name, again.geo) == ("south-1", geo)
    assert again.intrinsics.matrix.tolist() == intrinsics.matrix.tolist()
    assert again.intrinsics.distortion.tolist() == intrinsics.distortion.tolist()
    assert again.pose is not None
    assert np.abs(again.pose.world_from_camera - pose.world_from_camera).max() < 1e-12
    assert np.abs(again.pose.position_m - pose.position_m).max() < 1e-9
    assert again.covariance.tolist() == stored.covariance.tolist()


@pytest.mark.parametrize("form", list(CameraForm))
def test_a_lens_alone_has_no_pose(tmp_path, form):
    lens = read_camera(written(tmp_path)).camera.intrinsics
    write_stored(tmp_path / "lens.yaml", StoredCamera("west", lens, None, np.zeros((15, 15))), form)
    assert read_stored(tmp_path / "lens.yaml").pose is None
    with pytest.raises(InputError, match="give the pose either as"):
        read_camera(tmp_path / "lens.yaml")


def test_what_opencv_and_ros_write_themselves_is_read(tmp_path):
    storage = cv2.FileStorage(str(tmp_path / "opencv.yml"), cv2.FILE_STORAGE_WRITE)
    for name, value in (("image_width", 640), ("image_height", 480), ("avg_reprojection_error", 0.3)):
        storage.write(name, value)
    storage.write("camera_matrix", np.array([[500.0, 0, 320], [0, 501, 240], [0, 0, 1]]))
    storage.write("distortion_coefficients", np.array([[0.1], [0.2], [0.0], [0.0]]))
    storage.release()
    (tmp_path / "ros.yaml").write_text(
        "image_width: 640\nimage_height: 480\ncamera_name: narrow_stereo\n"
        "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500, 0, 320, 0, 501, 240, 0, 0, 1]\n"
        "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0.2, 0, 0, 0]\n"
        "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
    )
    for file in ("opencv.yml", "ros.yaml"):
        lens = read_stored(tmp_path / file).intrinsics
        assert lens.matrix.tolist() == [[500, 0, 320], [0, 501, 240], [0, 0, 1]]
        assert lens.distortion.tolist() == [0.1, 0.2, 0, 0, 0]


ROS = "image_width: 6\nimage_height: 4\ncamera_matrix: {rows: 3, cols: 3, data: [5, 0, 3, 0, 5, 2, 0, 0, 1]}\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("%YAML:1.0\n---\nimage_width: [1", "FileStorage|lacks"),
        ("%YAML:1.0\n---\nimage_width: 3\n", "lacks image_height"),
        (ROS, "missing required field `distortion_coefficients`"),
        (ROS + "distortion_coefficients: {rows: 1, cols: 3, data: [1, 2, 3]}", "must be k1, k2, p1, p2"),
        (
            ROS + "distortion_model: fisheye\ndistortion_coefficients: {rows: 1, cols: 4, data: [0, 0, 0, 0]}",
            "not known",
        ),
        (
            ROS.replace("5, 0, 3", "5, 1, 3") + "distortion_coefficients: {rows: 1, cols: 4, data: [0, 0, 0, 0]}",
            "fx, 0",
        ),
    ],
)
def test_wrong_files_of_other_programs_are_named(tmp_path, text, message):
    (tmp_path / "camera.yaml").write_text(text)
    with pytest.raises(InputError, match=rf"camera\.yaml: .*({message})"):
        read_stored(tmp_path / "camera.yaml")
