"""How large a roof looks, and which way its walls lean, at each place of a camera's image.

A camera of which one only knows focal length and height serves as well as a calibrated one; the better the camera is
known, lens and tilt included, the truer the sizes are. Nothing here comes from an image.
"""

from dataclasses import dataclass

import numpy as np

from contracts import Camera, FloatArray, Intrinsics, Pose
from georef.location import on_plane
from georef.projection import project_with_derivatives

CELL_PX = 64.0  # of the grid on which the view is computed; between its nodes it is interpolated


@dataclass(frozen=True, eq=False)
class LocalView:
    """The view at one place of the image.

    px_from_m: (2, 2) image motion per metre of the roof's motion to the east and to the north.
    lean_px: (2,) from a point of the roof to the point of the ground below it.
    """

    px_from_m: FloatArray
    lean_px: FloatArray

    @property
    def px_per_m(self) -> float:
        """Mean over all directions."""
        return float(np.sqrt(abs(np.linalg.det(self.px_from_m))))

    def px_per_m_along(self, directions: FloatArray) -> FloatArray:
        """(N,) along unit vectors of the image (N, 2)."""
        metres = np.linalg.solve(self.px_from_m, directions.T)  # (2, N)
        return np.asarray(1 / np.linalg.norm(metres, axis=0))


@dataclass(frozen=True, eq=False)
class RoofView:
    """The view of the horizontal plane of all roofs of one height, at the nodes of a grid over the image.

    nodes: (R, C, 6) px_from_m row by row, then the lean; node (0, 0) lies on the first pixel's centre.
    """

    nodes: FloatArray

    @classmethod
    def of(cls, camera: Camera, roof_height_m: float) -> "RoofView":
        """As ``camera`` sees roofs ``roof_height_m`` above the ground; nodes that it cannot see are as their mean."""
        columns = np.arange(0.0, camera.intrinsics.width_px + CELL_PX, CELL_PX)
        rows = np.arange(0.0, camera.intrinsics.height_px + CELL_PX, CELL_PX)
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1)  # (R, C, 2)
        points_m, seen = on_plane(camera, pixels, roof_height_m)
        roof = project_with_derivatives(camera, points_m)
        foot = project_with_derivatives(camera, points_m * (1.0, 1.0, 0.0))
        px_from_m = roof.by_point[..., :2].reshape(*seen.shape, 4)
        nodes = np.concatenate([px_from_m, foot.pixels - pixels], axis=-1)
        known = seen & np.isfinite(nodes).all(axis=-1)
        nodes[~known] = nodes[known].mean(axis=0)
        return cls(nodes)

    def at(self, place_px: FloatArray) -> LocalView:
        """At (u, v); outside the image as at its border."""
        last_row, last_column = self.nodes.shape[0] - 2, self.nodes.shape[1] - 2
        u, v = (place_px / CELL_PX).tolist()
        column, row = min(max(int(u), 0), last_column), min(max(int(v), 0), last_row)
        a, b = min(max(u - column, 0.0), 1.0), min(max(v - row, 0.0), 1.0)
        (near, right), (below, far) = self.nodes[row : row + 2, column : column + 2]
        node = (1 - b) * ((1 - a) * near + a * right) + b * ((1 - a) * below + a * far)
        return LocalView(node[:4].reshape(2, 2), node[4:])


def straight_down(focal_px: float, height_m: float, size_px: tuple[int, int], *, name: str = "") -> Camera:
    """A camera without a lens's faults over the world's origin; ``size_px`` is the width and height of its image."""
    (width, height), upright = size_px, np.diag([1.0, -1.0, -1.0])
    intrinsics = Intrinsics(width, height, focal_px, focal_px, (width - 1) / 2, (height - 1) / 2, np.zeros(5))
    return Camera(name, intrinsics, Pose(upright, np.array([0.0, 0.0, height_m])))
