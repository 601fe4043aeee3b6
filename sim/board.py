"""The checkerboard that is held before a camera, drawn exactly: every edge is where the print has it."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, Checkerboard, FloatArray, Frame, ImageArray, IntArray, Intrinsics, Pose
from sim.lens import Lens
from sim.projection import project
from sim.sensor import Sensor, SensorSpec
from sim.streams import stream

BOARD = Checkerboard(columns=9, rows=6, square_m=0.04)
VIEWS = 20

_BLACK, _WHITE, _ROOM = 28.0, 224.0, 96.0  # grey levels of print, paper and what is behind
_PAPER_SQUARES = 0.9  # white margin around the outer squares
_TILT_RAD = np.radians(38.0)
_MARGIN_PX = 12.0


@dataclass(frozen=True, eq=False)
class BoardPose:
    """Where the board is: ``point_in_camera = camera_from_board @ (x, y, 0) + origin_m``.

    Board axes: x along the columns, y along the rows, origin at the first inner corner, metres.
    """

    camera_from_board: FloatArray
    origin_m: FloatArray

    def corners_in_camera(self, board: Checkerboard) -> FloatArray:
        """Inner corners, (rows * columns, 3), row by row."""
        x, y = np.meshgrid(np.arange(board.columns), np.arange(board.rows))
        flat = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3) * board.square_m
        corners: FloatArray = flat @ self.camera_from_board.T + self.origin_m
        return corners


def board_views(
    camera: Camera, lens: Lens, sensor: SensorSpec, board: Checkerboard, *, seed: int, noise_seed: int
) -> Iterator[Frame]:
    """``VIEWS`` frames of the board in poses drawn from ``seed``, all inner corners inside the image."""
    size = camera.intrinsics
    film = Sensor(sensor, f"{camera.name}/board", size.width_px, size.height_px, noise_seed)
    for index, pose in enumerate(board_poses(size, board, stream(seed, f"board/{camera.name}"))):
        grey = film.focus(lens.bend(draw_board(lens.pinhole, board, pose)))
        yield Frame(camera.name, index, index * 1_000_000_000, film.grain(np.repeat(grey[..., None], 3, axis=2), index))


def board_poses(intrinsics: Intrinsics, board: Checkerboard, rng: np.random.Generator) -> list[BoardPose]:
    """Poses that fill the image: centres spread over it, tilts to all sides, some near and some far."""
    poses = []
    for index in range(VIEWS):
        # an additive recurrence on the golden ratios of the plane spreads any number of points evenly (Roberts 2018)
        spread = np.mod(0.5 + (index + 1) * np.array([0.7548776662, 0.5698402910]), 1.0) * 2.0 - 1.0
        turn = _turn(rng)
        share = rng.uniform(0.42, 0.72)
        poses.append(_fitted(intrinsics, board, turn, spread, share))
    return poses


def draw_board(pinhole: Intrinsics, board: Checkerboard, pose: BoardPose) -> ImageArray:
    """The board through a pinhole, (H, W) grey, each pixel the mean over its area to first order."""
    to_image = pinhole.matrix @ np.column_stack([pose.camera_from_board[:, :2] * board.square_m, pose.origin_m])
    picture = np.full((pinhole.height_px, pinhole.width_px), round(_ROOM), np.uint8)
    rows, columns = _paper_window(pinhole, board, to_image)
    to_board = np.linalg.inv(to_image)
    u = np.arange(columns.start, columns.stop)[None, :]
    v = np.arange(rows.start, rows.stop)[:, None]
    w = (to_board[2, 0] * u + (to_board[2, 1] * v + to_board[2, 2])).astype(np.float32)
    x, y = (_Axis.of(row, to_board[2], u, v, w) for row in to_board[:2])
    # squares: columns + 1 by rows + 1, from -1 to columns and to rows
    printed = x.between(-1.0, board.columns) * y.between(-1.0, board.rows)
    paper = x.between(-1.0 - _PAPER_SQUARES, board.columns + _PAPER_SQUARES)
    paper *= y.between(-1.0 - _PAPER_SQUARES, board.rows + _PAPER_SQUARES)
    black = printed * (1.0 + x.stripes(board.columns - 1) * y.stripes(board.rows - 1)) / 2.0
    level = _ROOM + paper * (_WHITE - _ROOM) + black * (_BLACK - _WHITE)
    picture[rows, columns] = np.rint(level)
    return picture


def _paper_window(pinhole: Intrinsics, board: Checkerboard, to_image: FloatArray) -> tuple[slice, slice]:
    """Rows and columns of the image that hold all of the paper; the whole image if part of it is behind the camera."""
    x = np.array([-1.0 - _PAPER_SQUARES, board.columns + _PAPER_SQUARES])
    y = np.array([-1.0 - _PAPER_SQUARES, board.rows + _PAPER_SQUARES])
    corners = to_image @ np.stack([*np.meshgrid(x, y), np.ones((2, 2))]).reshape(3, 4)
    if corners[2].min() <= 0:
        return slice(0, pinhole.height_px), slice(0, pinhole.width_px)
    pixels = (corners[:2] / corners[2]).T
    size = np.array([pinhole.width_px, pinhole.height_px])
    low = np.clip(np.floor(pixels.min(axis=0)) - 1, 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + 2, 0, size).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])


@dataclass(frozen=True, eq=False)
class _Axis:
    """One board coordinate over the image, in squares, and how many pixels one square spans; both (h, w)."""

    at: NDArray[np.float32]
    px: NDArray[np.float32]

    @classmethod
    def of(cls, row: FloatArray, scale: FloatArray, u: IntArray, v: IntArray, w: NDArray[np.float32]) -> "_Axis":
        at = (row[0] * u + (row[1] * v + row[2])).astype(np.float32) / w
        slope = [np.float32(row[k]) - at * np.float32(scale[k]) for k in range(2)]
        return cls(at, np.abs(w) / np.sqrt(slope[0] * slope[0] + slope[1] * slope[1]))

    def between(self, low: float, high: float) -> NDArray[np.float32]:
        """Share of each pixel for which the coordinate lies between two bounds."""
        inside = np.minimum(self.at - np.float32(low), np.float32(high) - self.at)
        share: NDArray[np.float32] = np.clip(inside * self.px + np.float32(0.5), 0.0, 1.0)
        return share

    def stripes(self, last: int) -> NDArray[np.float32]:
        """+1 and -1 in turn from square to square, a ramp of one pixel between; the last inner edge is ``last``."""
        nearest = np.clip(np.rint(self.at), 0, last)
        ramp = np.clip(np.float32(2.0) * (self.at - nearest) * self.px, -1.0, 1.0)
        ramp *= 1 - 2 * (nearest.astype(np.int8) & 1)  # the remainder of floats takes as long as all the rest
        return np.asarray(ramp)


def _turn(rng: np.random.Generator) -> FloatArray:
    """A board that faces the camera, tilted to a random side and turned a little in its plane."""
    side, tilt, roll = rng.uniform(-np.pi, np.pi), rng.uniform(0.25, 1.0) * _TILT_RAD, rng.normal(0.0, 0.15)
    tilted, _ = cv2.Rodrigues(np.array([np.cos(side), np.sin(side), 0.0]) * tilt)
    rolled, _ = cv2.Rodrigues(np.array([0.0, 0.0, roll]))
    return np.asarray(tilted @ rolled, dtype=np.float64)


def _fitted(
    intrinsics: Intrinsics, board: Checkerboard, turn: FloatArray, spread: FloatArray, share: float
) -> BoardPose:
    """The board as far out towards ``spread`` (in [-1, 1] of the image) as its corners stay inside.

    share: of the image's width that the board takes.
    """
    middle = turn @ np.array([board.columns - 1, board.rows - 1, 0.0]) * board.square_m / 2
    distance = intrinsics.fx_px * (board.columns + 1) * board.square_m / (share * intrinsics.width_px)
    distance = max(distance, intrinsics.fy_px * (board.rows + 1) * board.square_m / (0.8 * intrinsics.height_px))
    reach = np.array([intrinsics.width_px / intrinsics.fx_px, intrinsics.height_px / intrinsics.fy_px]) / 2
    for outward in np.linspace(1.0, 0.0, 21):
        centre = np.array([*(spread * outward * reach), 1.0]) * distance
        pose = BoardPose(turn, centre - middle)
        if _inside(intrinsics, pose.corners_in_camera(board)):
            break
    return pose


def _inside(intrinsics: Intrinsics, points_in_camera: FloatArray) -> bool:
    """Whether all points show inside the image, a margin away from its edge."""
    pixels, valid = project(Camera("board", intrinsics, Pose(np.eye(3), np.zeros(3))), points_in_camera)
    far = np.array([intrinsics.width_px, intrinsics.height_px]) - 1 - _MARGIN_PX
    return bool(valid.all() and (pixels >= _MARGIN_PX).all() and (pixels <= far).all())
