"""The inner corners of a checkerboard in an image, to a few hundredths of a pixel."""

import cv2
import numpy as np

from contracts import Checkerboard, FloatArray, Frame

_LEAST_WINDOW_PX, _LARGEST_WINDOW_PX = 2, 11


def board_points(board: Checkerboard) -> FloatArray:
    """(columns * rows, 3) inner corners in the board's own axes, metres, row by row, z = 0."""
    row, column = np.divmod(np.arange(board.columns * board.rows), board.columns)
    return board.square_m * np.stack([column, row, np.zeros_like(row)], axis=-1).astype(np.float64)


def find_corners(frame: Frame, board: Checkerboard) -> FloatArray | None:
    """(columns * rows, 2) pixels of the inner corners in the order of ``board_points``, or None if not all are seen.

    Found by OpenCV's sector-based detector (Duda & Frese 2018), refined by the gradient condition of Foerstner 1987
    (``cornerSubPix``) in a window that stays clear of the neighbouring corners.
    """
    grey = cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY)
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    found, corners = cv2.findChessboardCornersSB(grey, (board.columns, board.rows), flags=flags)
    if not found:
        return None
    corners = corners.reshape(-1, 1, 2).astype(np.float32)
    window = _window(corners.reshape(board.rows, board.columns, 2).astype(np.float64))
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    refined = cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), criteria)
    return refined.reshape(-1, 2).astype(np.float64)


def _window(grid: FloatArray) -> int:
    """Half width of the refinement window: 0.4 of the smallest step from corner to corner."""
    along = np.linalg.norm(np.diff(grid, axis=1), axis=-1).min()
    across = np.linalg.norm(np.diff(grid, axis=0), axis=-1).min()
    return int(np.clip(0.4 * min(along, across), _LEAST_WINDOW_PX, _LARGEST_WINDOW_PX))
