# SPDX-License-Identifier: Apache-2.0
"""Open3D's plane segmentation by its signature: one line changes.

    plane_model, inliers = pcd.segment_plane(distance_threshold=0.01, ransac_n=3, num_iterations=1000)
    plane_model, inliers = fransac.open3d.segment_plane(pcd, distance_threshold=0.01, ransac_n=3, num_iterations=1000)

Open3D itself is not needed.
"""

from typing import Any, Protocol

import numpy
from numpy.typing import NDArray

from ._core import NoDataError, ransac

__all__ = ["segment_plane"]


class HasPoints(Protocol):
    """Anything with points: N x 3 coordinates that NumPy can see as an array, such as open3d.geometry.PointCloud."""

    @property
    def points(self) -> Any: ...


def segment_plane(
    pcd: HasPoints,
    distance_threshold: float = 0.01,
    ransac_n: int = 3,
    num_iterations: int = 100,
    probability: float = 0.99999999,
    *,
    seed: int = 0,
    threads: int = 1,
) -> tuple[NDArray[numpy.float64], list[int]]:
    """The plane with the most points within a distance, as `open3d.geometry.PointCloud.segment_plane` returns it.

    Parameters
    ----------
        pcd: a point cloud with `points`; they are read in place. Coordinates that are not finite are on no plane.
        distance_threshold: largest distance of an inlier to the plane, in the points' unit (metres).
        ransac_n: points of a sample in Open3D, 3 or more. Here every hypothesis comes from three, the fewest that make a plane,
            and good ones are refitted to all their inliers.
        num_iterations: cap on the hypotheses.
        probability: confidence with which the search may stop before the cap, up to 1.0.
        seed: of the random samples; the same seed gives the same answer.
        threads: 0 for all cores; never changes the answer.

    Returns
    -------
        (a, b, c, d) of a x + b y + c z + d = 0 as a float64 array with (a, b, c) of unit length and d >= 0, and the inliers' numbers.

    Raises
    ------
        ValueError: a number out of its range. NoDataError (a ValueError): fewer than three points, or all on one line.
        TypeError: a value of another type; the message names the argument.
    """
    if isinstance(ransac_n, bool) or not isinstance(ransac_n, (int, numpy.integer)):
        raise TypeError(f"ransac_n: expected an int, got {type(ransac_n).__name__}")
    if ransac_n < 3:
        raise ValueError(f"ransac_n: must be at least 3, is {ransac_n}")
    if probability == 1.0:  # Open3D's way to ask for every iteration
        probability = float(numpy.nextafter(1.0, 0.0))
    points = numpy.asanyarray(pcd.points)
    if points.ndim != 2 or points.shape[1:] != (3,):
        raise ValueError(f"pcd: expected points of shape (N, 3), got {points.shape}")
    if len(points) < ransac_n:
        raise NoDataError(f"pcd: {len(points)} points, fewer than ransac_n")
    try:
        found = ransac(
            points,
            threshold=distance_threshold,
            max_iterations=num_iterations,
            probability=probability,
            seed=seed,
            threads=threads,
        )
    except (TypeError, ValueError) as error:
        raise type(error)(_open3d_names(str(error))) from None
    return found.coefficients, found.inliers.tolist()


def _open3d_names(message: str) -> str:
    """A message with the argument's name as it stands here."""
    names = {"threshold": "distance_threshold", "max_iterations": "num_iterations", "points": "pcd"}
    argument, colon, rest = message.partition(":")
    return names.get(argument, argument) + colon + rest
