"""A camera as calibration left it: the estimate and how far it can be trusted."""

from dataclasses import dataclass

from contracts import Camera, FloatArray
from contracts.arrays import freeze

PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "rx", "ry", "rz", "x", "y", "z")


@dataclass(frozen=True, eq=False)
class CalibratedCamera:
    """An estimated camera with the covariance of its parameters.

    camera: the estimate.
    covariance: (15, 15) of ``PARAMETERS``: px, the lens's own numbers, radians, metres. The rotation is a small vector
        in world axes applied from the left: ``world_from_camera = exp([r]) @ camera.pose.world_from_camera``.
        Zero where a parameter is taken as known.
    """

    camera: Camera
    covariance: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "covariance", shape=(len(PARAMETERS), len(PARAMETERS)))
