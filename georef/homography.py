"""Homographies: between a horizontal plane and the lens-free image, and between point sets."""

import numpy as np

from contracts import CalibrationError, Camera, FloatArray

_LEAST_POINTS = 4


def image_from_plane(camera: Camera, height_m: float = 0.0) -> FloatArray:
    """(3, 3) homography from the plane z = ``height_m`` (east, north in metres) to pixels of the image without lens.

    H = K R^T [e_x  e_y  h e_z - position]. Source: Hartley & Zisserman 2004, section 8.1.1.
    """
    plane = np.eye(3)
    plane[:, 2] = np.array([0.0, 0.0, height_m]) - camera.pose.position_m
    homography: FloatArray = camera.intrinsics.matrix @ camera.pose.world_from_camera.T @ plane
    return homography


def plane_from_image(camera: Camera, height_m: float = 0.0) -> FloatArray:
    """The inverse of ``image_from_plane``: pixels of the image without lens to metres on the plane.

    Raises CalibrationError for a camera that lies in the plane.
    """
    homography = image_from_plane(camera, height_m)
    if abs(camera.pose.position_m[2] - height_m) < 1e-9:
        raise CalibrationError(f'camera "{camera.name}" lies in the plane z = {height_m} m: no homography')
    inverse: FloatArray = np.linalg.inv(homography).astype(np.float64)
    return inverse


def transform(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Map ``points`` (..., 2); points on the vanishing line give NaN."""
    mapped = np.asarray(points) @ homography[:, :2].T + homography[:, 2]
    weight = mapped[..., 2:]
    return mapped[..., :2] / np.where(np.abs(weight) > 1e-300, weight, np.nan)


def fit_homography(source: FloatArray, target: FloatArray) -> FloatArray:
    """(3, 3) homography from ``source`` to ``target``, both (N, 2), N >= 4, by the normalised direct linear transform.

    Raises CalibrationError for too few or collinear points. Source: Hartley & Zisserman 2004, algorithm 4.2.
    """
    if len(source) < _LEAST_POINTS or len(source) != len(target):
        raise CalibrationError(f"a homography needs at least 4 point pairs, got {len(source)} and {len(target)}")
    to_source, to_target = _normaliser(source), _normaliser(target)
    x, y = transform(to_source, source).T
    u, v = transform(to_target, target).T
    one, zero = np.ones_like(x), np.zeros_like(x)
    rows_u = np.stack([x, y, one, zero, zero, zero, -u * x, -u * y, -u], axis=-1)  # (N, 9)
    rows_v = np.stack([zero, zero, zero, x, y, one, -v * x, -v * y, -v], axis=-1)
    _, singular, rows = np.linalg.svd(np.concatenate([rows_u, rows_v]))
    if singular[7] < 1e-9 * singular[0]:
        raise CalibrationError("the points lie on a line: they determine no homography")
    homography: FloatArray = np.linalg.inv(to_target) @ rows[8].reshape(3, 3) @ to_source
    return homography


def _normaliser(points: FloatArray) -> FloatArray:
    """Similarity that moves the centroid to the origin and the mean distance from it to sqrt(2)."""
    centre = points.mean(axis=0)
    spread = np.linalg.norm(points - centre, axis=1).mean()
    if not spread > 0:
        raise CalibrationError("the points coincide: they determine no homography")
    scale = np.sqrt(2.0) / spread
    return np.array([[scale, 0.0, -scale * centre[0]], [0.0, scale, -scale * centre[1]], [0.0, 0.0, 1.0]])
