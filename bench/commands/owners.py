"""``gantry calibrate``, ``locate`` and ``views``: for owners of real cameras. Nothing of the simulation is loaded."""

import re
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    help="Calibrate a real camera from images of a board, from picks on a map, or from images of the road.",
    no_args_is_help=True,
)


class Model(StrEnum):
    """What ``gantry calibrate camera`` fits."""

    FULL = "full"
    PAN_TILT = "pan-tilt"
    HOMOGRAPHY = "homography"


class Form(StrEnum):
    """Whose camera file is written."""

    GANTRY = "gantry"
    OPENCV = "opencv"
    ROS = "ros"


Out = Annotated[Path, typer.Option(help="The camera file to write (YAML).")]
FormOption = Annotated[Form, typer.Option(help="gantry, opencv (FileStorage) or ros (camera_info).")]
Name = Annotated[str | None, typer.Option(help="The camera's name; that of its file if not given.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]


@app.command()
def intrinsics(
    images: Annotated[list[Path], typer.Argument(help="Images of the board, held differently.", metavar="IMAGES...")],
    board: Annotated[str, typer.Option(help="Inner corners and square: 9x6:0.025 is 9 x 6 of 25 mm.")],
    out: Out,
    name: Name = None,
    form: FormOption = Form.GANTRY,
    json: Json = False,
) -> None:
    """Calibrate the lens from images of a checkerboard."""
    from bench.owners.calibrations import calibrate_lens
    from bench.owners.printed import print_lens

    print_lens(calibrate_lens(images, _board(board), name or out.stem, out, form.value), out, json=json)


@app.command()
def camera(
    picks: Annotated[
        Path, typer.Argument(help="Table of picks; its header is in docs/owners.md.", metavar="PICKS.csv")
    ],
    size: Annotated[str, typer.Option(help="The image's size in pixels: 1920x1080.")],
    out: Out,
    map_: Annotated[Path | None, typer.Option("--map", help="HD map (GeoJSON) for picks that name features.")] = None,
    model: Annotated[Model, typer.Option(help="What is fitted.")] = Model.FULL,
    name: Name = None,
    origin: Annotated[str | None, typer.Option(help="Of local metres, without a map: LATITUDE,LONGITUDE.")] = None,
    noise_px: Annotated[float, typer.Option(help="Standard deviation of a pick, as you believe.")] = 1.0,
    height_m: Annotated[float | None, typer.Option(help="The camera's height to half a metre, if known.")] = None,
    seed: Annotated[int, typer.Option(help="Of the random samples.")] = 0,
    form: FormOption = Form.GANTRY,
    json: Json = False,
) -> None:
    """Calibrate a camera from points and lines of a map, picked in its image."""
    from bench.owners.calibrations import Wanted, calibrate_from_picks
    from bench.owners.printed import print_calibration

    wanted = Wanted(
        model.value, name or out.stem, _pair(size, "x", "--size", int), noise_px, height_m, seed, form.value
    )
    place = _pair(origin, ",", "--origin", float) if origin else None
    print_calibration(calibrate_from_picks(picks, map_, place, wanted, out), out, json=json)


@app.command()
def frames(
    images: Annotated[list[Path], typer.Argument(help="Images of the empty or busy road.", metavar="IMAGES...")],
    map_: Annotated[Path, typer.Option("--map", help="HD map (GeoJSON) with the road's paint.")],
    near: Annotated[Path, typer.Option(help="Camera file of about where it hangs, from gantry calibrate about.")],
    out: Out,
    map_sigma_m: Annotated[float, typer.Option(help="Standard deviation of the map's places, per axis.")] = 0.0,
    name: Name = None,
    form: FormOption = Form.GANTRY,
    json: Json = False,
) -> None:
    """Calibrate a camera from images of the road alone: its paint is found and laid under the map's."""
    from bench.owners.paint import calibrate_from_images
    from bench.owners.printed import print_calibration

    calibration = calibrate_from_images(images, (map_, map_sigma_m), near, out, name=name or out.stem, form=form.value)
    print_calibration(calibration, out, json=json)


@app.command()
def about(
    map_: Annotated[Path, typer.Option("--map", help="HD map (GeoJSON) on which it stands.")],
    height_m: Annotated[float, typer.Option(help="Height of the camera.")],
    heading_deg: Annotated[float, typer.Option(help="Where it looks, counter-clockwise from east: north is 90.")],
    down_deg: Annotated[float, typer.Option(help="How far it looks down from the horizon.")],
    out: Out,
    at_m: Annotated[str | None, typer.Option(help="Its foot in the map's metres: EAST,NORTH.")] = None,
    at_deg: Annotated[str | None, typer.Option(help="Or on the Earth: LATITUDE,LONGITUDE.")] = None,
    lens: Annotated[Path | None, typer.Option(help="Camera file from gantry calibrate intrinsics.")] = None,
    size: Annotated[str | None, typer.Option(help="Or, without one, the image's size in pixels: 1920x1080,")] = None,
    focal_px: Annotated[float | None, typer.Option(help="and the focal length.")] = None,
    name: Name = None,
) -> None:
    """Write down about where a camera hangs, from where gantry calibrate frames sets out."""
    from bench.owners.about import Hanging, known_lens, write_about

    known = known_lens(name or out.stem, lens, _pair(size, "x", "--size", int) if size else None, focal_px)
    foot_m = _pair(at_m, ",", "--at-m", float) if at_m else None
    foot_deg = _pair(at_deg, ",", "--at-deg", float) if at_deg else None
    write_about(known, Hanging(foot_m, foot_deg, height_m, heading_deg, down_deg), map_, out)
    print(out)


def locate(
    pixels: Annotated[
        Path, typer.Argument(help="Table: u_px, v_px [, height_m, sigma_px, name].", metavar="PIXELS.csv")
    ],
    camera: Annotated[Path, typer.Option(help="Camera file, from gantry calibrate or your own.")],
    map_: Annotated[Path | None, typer.Option("--map", help="HD map (GeoJSON) whose ground they lie on.")] = None,
    json: Json = False,
) -> None:
    """Place pixels on the ground: local metres and WGS84, with covariance."""
    from bench.owners.places import locate_table
    from bench.owners.printed import print_places

    print_places(locate_table(camera, pixels, map_), json=json)


def views(
    cameras: Annotated[list[Path], typer.Argument(help="Camera files that tell where they stand.", metavar="CAM...")],
    out: Annotated[Path, typer.Option(help="The GeoJSON file to write.")],
    map_: Annotated[
        Path | None, typer.Option("--map", help="HD map (GeoJSON): adds the road that no camera sees.")
    ] = None,
    farthest_m: Annotated[float, typer.Option(help="Farther from its foot a camera does not count as seeing.")] = 60.0,
) -> None:
    """Write the ground that cameras see, and the road's blind spots, as a map layer."""
    from bench.owners.views import write_views

    for name, area_m2 in write_views(cameras, map_, farthest_m, out).items():
        print(f"{name}: {area_m2:.1f} m2")
    print(out)


def _board(text: str) -> tuple[int, int, float]:
    from contracts import InputError

    found = re.fullmatch(r"(\d+)x(\d+):([0-9.]+)", text)
    try:
        assert found
        return int(found[1]), int(found[2]), float(found[3])
    except (AssertionError, ValueError) as error:
        raise InputError(f'--board "{text}" is not COLUMNSxROWS:SQUARE_M, for example 9x6:0.025') from error


def _pair(text: str, between: str, option: str, number: type) -> tuple:  # type: ignore[type-arg]
    from contracts import InputError

    try:
        first, second = (number(part) for part in text.split(between))
    except ValueError as error:
        raise InputError(f'{option} "{text}" is not two numbers with "{between}" between them') from error
    return first, second
