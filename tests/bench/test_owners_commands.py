"""The commands for owners of real cameras, on picks and boards imaged by OpenCV; nothing of the simulation loaded."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli import app
from contracts import CalibrationError, InputError
from georef.camera_file import read_stored
from georef.geo_reference import GeoReference
from georef.hd_map import Facility, FacilityKind, HdMap, LaneCentreline, LaneMarking, MarkingKind, RoadClass
from georef.hd_map_file import write_map

ROOT = Path(__file__).parents[2]
ORIGIN = GeoReference(37.398, 127.112)
K = np.array([[1500.0, 0, 970.0], [0, 1500.0, 530.0], [0, 0, 1]])
LENS = np.array([-0.2, 0.03, 0.0, 0.0, 0.0])
DOWN = np.arctan2(8.0, 28.0)
CAMERA_FROM_WORLD = np.array([[0, -1, 0], [-np.sin(DOWN), 0, -np.cos(DOWN)], [np.cos(DOWN), 0, -np.sin(DOWN)]])


def image(points):
    rvec = cv2.Rodrigues(CAMERA_FROM_WORLD)[0]
    tvec = -CAMERA_FROM_WORLD @ [0.0, 0.0, 8.0]
    return cv2.projectPoints(np.asarray(points, float), rvec, tvec, K, LENS)[0].reshape(-1, 2)


PLACES = np.array([[x, y, 0.0] for x in (14.0, 20.0, 30.0, 45.0, 58.0) for y in (-6.5, -3.0, 0.5, 4.0, 7.0)])
PLACES[::6, 2] = 3.0
SEEN = (image(PLACES) > 0).all(axis=1) & (image(PLACES) < [1919, 1079]).all(axis=1)


def table(path, header, rows):
    path.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


def picks(tmp_path, *, wgs84=False, noise=0.5):
    points = PLACES[SEEN]
    pixels = image(points) + noise * np.random.default_rng(0).standard_normal((len(points), 2))
    pixels[3] += [80.0, -30.0]
    if not wgs84:
        rows = [(f"p{i}", *pixels[i], *points[i]) for i in range(len(points))]
        return table(tmp_path / "picks.csv", "name,u_px,v_px,x_m,y_m,z_m", rows)
    places = ORIGIN.to_wgs84(points[:, :2])
    rows = [(f"p{i}", *pixels[i], *map(repr, places[i].tolist()), points[i, 2]) for i in range(len(points))]
    return table(tmp_path / "picks.csv", "name,u_px,v_px,latitude_deg,longitude_deg,z_m", rows)


def gantry(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def told(*arguments):
    done = gantry(*arguments, "--json")
    assert done.exception is None, done.exception
    return json.loads(done.stdout)


@pytest.mark.parametrize("form", ["gantry", "opencv", "ros"])
def test_picks_become_a_camera_that_places_pixels_on_the_earth(tmp_path, form):
    file = tmp_path / "camera.yaml"
    options = ("--size", "1920x1080", "--origin", "37.398,127.112", "--noise-px", 0.5, "--form", form, "--out", file)
    found = told("calibrate", "camera", picks(tmp_path, wgs84=True), *options)
    assert found["wrong_picks"] == ["p3"]
    for name, true in (("f_px", 1500.0), ("z_m", 8.0), ("x_m", 0.0)):
        assert abs(found["parameters"][name]["value"] - true) < 5 * found["parameters"][name]["sigma"]
    pixels = image([[25.0, 1.0, 0.0], [30.0, 2.0, 0.0]])
    rows = [("car", *pixels[0]), ("van", *pixels[1]), ("sky", 960, 1)]
    places = told("locate", "--camera", file, table(tmp_path / "pixels.csv", "name,u_px,v_px", rows))
    assert [place["valid"] for place in places] == [True, True, False]
    assert np.hypot(places[0]["x_m"] - 25.0, places[0]["y_m"] - 1.0) < 0.1
    assert np.linalg.eigvalsh(places[0]["cov_m2"]).min() > 0
    there = ORIGIN.to_local([places[1]["latitude_deg"], places[1]["longitude_deg"]])
    assert np.abs(there - [places[1]["x_m"], places[1]["y_m"]]).max() < 1e-4


@pytest.mark.parametrize("model", ["pan-tilt", "homography"])
def test_the_simpler_models_say_how_badly_they_fit(tmp_path, model):
    file = tmp_path / "camera.yaml"
    found = told("calibrate", "camera", picks(tmp_path), "--size", "1920x1080", "--model", model, "--out", file)
    assert found["noise_px"] > 1.0  # of picks with half a pixel's noise
    places = told("locate", "--camera", file, table(tmp_path / "p.csv", "u_px,v_px", image([[30.0, 1.0, 0.0]])))
    assert np.hypot(places[0]["x_m"] - 30.0, places[0]["y_m"] - 1.0) < 3.0
    assert "latitude_deg" not in places[0]


def test_picks_may_name_features_of_a_map_and_the_map_offers_the_next(tmp_path):
    points = PLACES[SEEN]
    lamps = tuple(Facility(f"lamp-{i}", p, FacilityKind.STREETLAMP) for i, p in enumerate(points))
    marking = LaneMarking("edge", np.array([[12.0, -2.0, 0.0], [40.0, -2.0, 0.0], [70.0, -2.0, 0.0]]), MarkingKind.EDGE)
    course = np.array([[12.0, 1.0, 0.0], [60.0, 1.0, 0.0]])
    unseen = LaneCentreline("lane", course, RoadClass.CITY, 3.0)  # nobody can pick what is not painted
    write_map(tmp_path / "map.geojson", HdMap(ORIGIN, (marking,), (), (unseen,), facilities=lamps))
    pixels = image(points)
    rows = [(f"lamp-{i}", *pixels[i]) for i in range(len(points) - 2)]
    rows += [("edge", *pixel) for pixel in image([[18.0, -2.0, 0.0], [33.0, -2.0, 0.0]])]
    rows.append(("edge#2", *image([[40.0, -2.0, 0.0]])[0]))
    file = table(tmp_path / "picks.csv", "feature,u_px,v_px", rows)
    options = ("--size", "1920x1080", "--map", tmp_path / "map.geojson", "--noise-px", 0.1)
    found = told("calibrate", "camera", file, *options, "--out", tmp_path / "west.yaml")
    assert found["picks"] == len(rows)
    assert found["wrong_picks"] == []
    assert found["next_pick"] in {f"lamp-{len(points) - 1}", f"lamp-{len(points) - 2}", "edge#1", "edge#3"}
    assert (read_stored(tmp_path / "west.yaml").name, read_stored(tmp_path / "west.yaml").geo) == ("west", ORIGIN)


def test_on_the_ground_of_a_map_places_are_as_high_as_its_lines(tmp_path):
    file = tmp_path / "camera.yaml"
    told("calibrate", "camera", picks(tmp_path), "--size", "1920x1080", "--origin", "37.398,127.112", "--out", file)
    courses = [np.array([[10.0, y, 1.0], [70.0, y, 1.0]]) for y in (-8.0, 8.0)]
    lanes = tuple(LaneMarking(f"edge {k}", course, MarkingKind.EDGE) for k, course in enumerate(courses))
    write_map(tmp_path / "map.geojson", HdMap(ORIGIN, lane_markings=lanes))
    pixels = table(tmp_path / "p.csv", "u_px,v_px", image([[30.0, 1.0, 1.0]]))
    (there,) = told("locate", "--camera", file, pixels, "--map", tmp_path / "map.geojson")
    (flat,) = told("locate", "--camera", file, pixels)
    assert np.hypot(there["x_m"] - 30.0, there["y_m"] - 1.0) < 0.2
    assert flat["x_m"] - there["x_m"] > 3.0
    write_map(tmp_path / "elsewhere.geojson", HdMap(GeoReference(37.0, 127.0), lane_markings=lanes))
    error = gantry_error("locate", "--camera", file, pixels, "--map", tmp_path / "elsewhere.geojson")
    assert "elsewhere.geojson: its metres begin elsewhere" in str(error)


@pytest.fixture(scope="module")
def boards(tmp_path_factory):
    """Five images of a board of 8 x 5 corners, and after them one without."""
    directory = tmp_path_factory.mktemp("boards")
    rng, square = np.random.default_rng(3), 60
    board = np.full((8 * square, 11 * square), 255, np.uint8)
    for row in range(6):
        for column in range(9):
            if (row + column) % 2 == 0:
                board[(row + 1) * square : (row + 2) * square, (column + 1) * square : (column + 2) * square] = 20
    files, k = [], np.array([[900.0, 0, 319.5], [0, 900.0, 239.5], [0, 0, 1]])
    for number in range(5):
        turn = cv2.Rodrigues(rng.uniform(-0.5, 0.5, 3))[0]
        centred = np.array([[1, 0, -board.shape[1] / 2], [0, 1, -board.shape[0] / 2], [0, 0, 1.0]])
        pose = np.column_stack([turn[:, :2], [0.0, 0.0, 1600.0]])
        drawn = cv2.warpPerspective(
            board, k @ pose @ centred, (640, 480), flags=cv2.INTER_AREA, borderMode=cv2.BORDER_CONSTANT, borderValue=255
        )
        files.append(directory / f"{number}.png")
        cv2.imwrite(str(files[-1]), cv2.cvtColor(drawn, cv2.COLOR_GRAY2BGR))
    files.append(directory / "empty.png")
    cv2.imwrite(str(files[-1]), np.full((480, 640, 3), 90, np.uint8))
    return files


def test_a_lens_is_calibrated_from_images_of_a_board_and_those_without_are_named(boards, tmp_path):
    found = told("calibrate", "intrinsics", *boards, "--board", "8x5:0.06", "--out", tmp_path / "lens.yaml")
    assert abs(found["parameters"]["fx_px"]["value"] - 900.0) < 15.0
    assert (found["views"], found["no_board_found_in"]) == (5, [str(boards[-1])])
    with pytest.raises(InputError, match="give the pose either"):
        raise gantry_error("run", "--video", boards[0], "--camera", tmp_path / "lens.yaml")


def test_boards_too_few_or_of_several_sizes_are_refused_by_name(boards, tmp_path):
    small, out = tmp_path / "small.png", tmp_path / "lens.yaml"
    cv2.imwrite(str(small), np.full((240, 320, 3), 90, np.uint8))
    for files, message in (
        ([*boards[:2], boards[-1]], r"found in 2 of 3 views, at least 3 are needed; not in .*empty\.png"),
        (boards[:2], "found in 2 of 2 views, at least 3 are needed; give more"),
        ([*boards, small], r"small\.png is 320x240, but .*0\.png 640x480"),
    ):
        with pytest.raises(CalibrationError, match=message):
            raise gantry_error("calibrate", "intrinsics", *files, "--board", "8x5:0.06", "--out", out)
    assert not out.exists()


def gantry_error(*arguments):
    return gantry(*arguments).exception


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("u_px,v_px\n1,2\n", "line 2: give the place by one of"),
        ("u_px,x_m,y_m\n1,2,3\n", "line 1: the column v_px is missing"),
        ("u_px,v_px,x,y\n1,2,3,4\n", 'line 1: the column "x" is not known; accepted are name, u_px'),
        ("u_px,v_px,x_m,y_m\n1,2,three,4\n", 'line 2, column x_m: "three" is no number'),
        ("u_px,v_px,x_m,y_m\n1,2,nan,4\n", 'column x_m: "nan" is no number'),
        ("u_px,v_px,x_m,y_m\n1,2,3\n", "line 2: has 3 cells, but the header names 4 columns"),
        ("u_px,v_px,x_m,y_m\n1,2,3,\n", "line 2, column y_m: is empty"),
        ("u_px,v_px,x_m,y_m,sigma_m\n1,2,3,4,-1\n", "column sigma_m: -1 must not be negative"),
        ("u_px,v_px,x_m,y_m\n1,2,3,4\n5000,2,3,4\n", "line 3: the pixel 5000, 2 lies outside the image of 1920x1080"),
        ("u_px,v_px,x_m,y_m\n1,-2,3,4\n", "line 2: the pixel 1, -2 lies outside the image"),
        ("u_px,v_px,feature\n1,2,lamp\n", 'column feature: "lamp" needs a map'),
        ("u_px,v_px,latitude_deg,longitude_deg\n1,2,127.1,37.4\n", "line 2: the origin 127.1"),
        ("u_px,v_px,x_m,y_m,x2_m,y2_m\n1,2,3,4,3,4\n", "the line's two places are one and the same"),
        ("u_px,v_px,x_m,y_m\n", "holds no row"),
        ("", "line 1: the column u_px is missing"),
    ],
)
def test_what_is_wrong_with_picks_is_named_with_file_line_and_column(tmp_path, text, message):
    file = tmp_path / "picks.csv"
    file.write_text(text)
    error = gantry_error("calibrate", "camera", file, "--size", "1920x1080", "--out", tmp_path / "camera.yaml")
    assert isinstance(error, InputError)
    assert str(error).startswith(str(file))
    assert message in str(error)
    assert not (tmp_path / "camera.yaml").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--size", "big"), '--size "big" is not two numbers'),
        (("--size", "0x10"), "--size 0x10 must be positive"),
        (("--size", "1920x1080", "--noise-px", 0), "--noise-px 0.0 must be positive"),
        (("--size", "1920x1080", "--height-m", -1), "--height-m -1.0 must be positive"),
        (("--size", "1920x1080", "--origin", "here"), '--origin "here" is not two numbers'),
        (("--size", "1920x1080", "--model", "homography", "--form", "ros"), "a homography is no camera"),
        (("--size", "1920x1080", "--map", "absent.geojson"), "absent.geojson"),
    ],
)
def test_impossible_options_are_refused(tmp_path, options, message):
    error = gantry_error("calibrate", "camera", picks(tmp_path), *options, "--out", tmp_path / "camera.yaml")
    assert isinstance(error, InputError)
    assert message in str(error)


def test_picks_on_the_border_and_a_pixel_beyond_it_are_accepted(tmp_path):
    file = picks(tmp_path)
    with file.open("a") as stream:
        stream.writelines(f"{u},{u},{v},20,0,0\n" for u, v in ((-1, -1), (1920, 1080), (-0.5, 1079.5)))
    found = told("calibrate", "camera", file, "--size", "1920x1080", "--out", tmp_path / "camera.yaml")
    assert found["picks"] == SEEN.sum() + 3


def test_picks_on_a_line_are_refused_with_the_file_s_name(tmp_path):
    rows = [(u, 500 + 0.1 * u, 20 + u / 100, 3.0) for u in range(100, 1700, 60)]
    file = table(tmp_path / "picks.csv", "u_px,v_px,x_m,y_m", rows)
    error = gantry_error("calibrate", "camera", file, "--size", "1920x1080", "--out", tmp_path / "camera.yaml")
    assert isinstance(error, CalibrationError)
    assert "picks.csv" in str(error)
    assert "lie on a line on the map" in str(error)


def test_wrong_input_ends_with_status_two_and_nothing_of_the_simulation_is_loaded(tmp_path):
    out = tmp_path / "camera.yaml"
    program = (
        "import sys\nfrom bench.cli import main\nstatus = 0\n"
        "try:\n    main()\nexcept SystemExit as ended:\n    status = ended.code or 0\n"
        "loaded = [name for name in ('sim', 'mujoco', 'libsumo', 'perception') if name in sys.modules]\n"
        "print(loaded, file=sys.stderr)\nsys.exit(status)\n"
    )

    def run(*arguments):
        command = [sys.executable, "-c", program, *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)

    done = run("calibrate", "camera", picks(tmp_path), "--size", "1920x1080", "--out", out)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (0, "[]")
    refused = run("locate", "--camera", out, tmp_path / "absent.csv")
    assert refused.returncode == 2
    assert refused.stdout == ""
    assert "absent.csv: cannot be read" in refused.stderr.splitlines()[0]
    assert refused.stderr.splitlines()[-1] == "[]"
