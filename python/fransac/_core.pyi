# SPDX-License-Identifier: Apache-2.0
# Written by python/make-stubs from the compiled module, whose options are those of the C++ headers.
"""
Planes and obstacles in depth frames and point clouds: the compiled part of fransac.
"""

from collections.abc import Mapping, Sequence
import os
from typing import Any, Literal

import numpy
import numpy.typing


class NoDataError(ValueError):
    """Nothing was measured, or too little for a plane."""

class Camera:
    """
    Pinhole intrinsics of a depth image. A pixel (u, v) of depth z lies at z * ((u - cx) / fx, (v - cy) / fy, 1): x right,
    y down, z forward; pixel (0, 0) is the centre of the top left one. Cannot be changed; equal cameras have equal hashes.

    Parameters
    ----------
        width, height: pixels, 1 to 32768.
        fx, fy: focal lengths, pixels.
        cx, cy: principal point, pixels.
        depth_scale: raw units of integer depth per metre: metres = value / depth_scale.

    Raises
    ------
        ValueError: a number is not finite or out of its range; the message names the field.
    """

    def __init__(self, *, width: int, height: int, fx: float, fy: float, cx: float, cy: float, depth_scale: float = 1000.0) -> None: ...

    @staticmethod
    def from_file(path: str | os.PathLike[str]) -> Camera:
        """
        Reads a camera's file (camera.json, ROS, Open3D, RealSense, ORB-SLAM), or returns the camera of the TUM RGB-D benchmark's 'freiburg1', 'freiburg2' or 'freiburg3'.

        Raises OSError for a file that cannot be read, ValueError for one whose content is wrong.
        """

    @property
    def width(self) -> int:
        """Columns, pixels."""

    @property
    def height(self) -> int:
        """Rows, pixels."""

    @property
    def fx(self) -> float:
        """Focal length along u, pixels."""

    @property
    def fy(self) -> float:
        """Focal length along v, pixels."""

    @property
    def cx(self) -> float:
        """Principal point, column, pixels."""

    @property
    def cy(self) -> float:
        """Principal point, row, pixels."""

    @property
    def depth_scale(self) -> float:
        """Raw units of integer depth per metre."""

    def to_dict(self) -> dict[str, float]:
        """The fields by name, as camera.json has them."""

    def __repr__(self) -> str: ...

    def __eq__(self, other: object, /) -> bool: ...

    def __getstate__(self) -> tuple[int, int, float, float, float, float, float]: ...

    def __setstate__(self, arg: tuple[int, int, float, float, float, float, float], /) -> None: ...

    def __hash__(self) -> int: ...

class PlaneEvidence:
    """
    What cells saw of a plane when it judged it: what its confidence follows from.
    """

    @property
    def share(self) -> float:
        """Of the measured pixels, 0 to 1."""

    @property
    def turn_rad(self) -> float:
        """
        By how much the surface's normal turns from end to end, radians: with or without its border, which is blurred; the lesser.
        """

    @property
    def turn_sigma_rad(self) -> float:
        """One sigma of turn_rad, radians."""

    @property
    def smooth_border(self) -> float:
        """Share of the border beyond which the surface goes on smoothly, 0 to 1."""

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

class Plane:
    """
    A plane of a segmentation: the points p with normal . p + d = 0, metres.
    """

    @property
    def id(self) -> int:
        """Its label, from 1."""

    @property
    def normal(self) -> numpy.typing.NDArray[numpy.float64]:
        """Unit normal, shape (3,); the camera is on its side."""

    @property
    def d(self) -> float:
        """Distance of the origin, metres, >= 0."""

    @property
    def coefficients(self) -> numpy.typing.NDArray[numpy.float64]:
        """(normal, d), shape (4,)."""

    @property
    def kind(self) -> str:
        """
        'floor', 'ceiling', 'wall', 'horizontal', 'other', or 'unknown' where nothing tells what is up.
        """

    @property
    def inliers(self) -> int:
        """Pixels or points with this label."""

    @property
    def support(self) -> int:
        """Searched points within the threshold when it was found."""

    @property
    def iterations(self) -> int:
        """Hypotheses of the search that found it."""

    @property
    def stop_reason(self) -> str:
        """Why that search ended."""

    @property
    def rms_m(self) -> float:
        """Root mean square distance of the labelled points, metres."""

    @property
    def confidence(self) -> float:
        """
        Probability that this is a plane of the scene, 0 to 1 (cells; else 1: the other methods do not judge).
        """

    @property
    def evidence(self) -> PlaneEvidence:
        """What that follows from (cells; else zero)."""

    @property
    def area_m2(self) -> float:
        """Visible area, square metres."""

    @property
    def centroid(self) -> numpy.typing.NDArray[numpy.float64]:
        """Of the labelled points, metres, shape (3,) (cells, clouds; else zero)."""

    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """Of (normal, d), shape (4, 4), rank 3 (cells; else zero)."""

    def distance(self, points: numpy.typing.NDArray[Any]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Signed distances of points, (N, 3) or (H, W, 3), in metres, positive on the camera's side; NaN where a point is not finite.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

class Box:
    """A box that stands upright on the support, in the ground frame."""

    @property
    def centre(self) -> numpy.typing.NDArray[numpy.float64]:
        """x ahead, y left, z up from the camera's foot, metres, shape (3,)."""

    @property
    def size(self) -> numpy.typing.NDArray[numpy.float64]:
        """Length >= width, height; metres, shape (3,)."""

    @property
    def yaw_rad(self) -> float:
        """Of the length against the ground's x, in (-pi/2, pi/2]."""

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

class Obstacle:
    """What stands on, hangs above or falls away from the support."""

    @property
    def id(self) -> int:
        """Its number in obstacle_labels, from 1, nearest first."""

    @property
    def kind(self) -> str:
        """
        'object'; 'plane', of which one face is all that is seen; 'drop': a hole, a step down.
        """

    @property
    def pixels(self) -> int:
        """Pixels or points."""

    @property
    def centroid(self) -> numpy.typing.NDArray[numpy.float64]:
        """Of its points, camera frame, metres, shape (3,)."""

    @property
    def box(self) -> Box:
        """In the ground frame."""

    @property
    def min_height_m(self) -> float:
        """Its lowest point above the support, metres; negative: below."""

    @property
    def max_height_m(self) -> float:
        """Its highest point above the support, metres."""

    @property
    def nearest_m(self) -> float:
        """Distance of its nearest point from the camera, metres."""

    @property
    def contact(self) -> bool:
        """Whether it is seen to come down to the support."""

    @property
    def planes(self) -> list[int]:
        """Labels of the planes that a tenth or more of its pixels are on."""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

class Ground:
    """
    Coordinates on the support: the camera's foot is the origin, z up along its normal.
    """

    @property
    def origin(self) -> numpy.typing.NDArray[numpy.float64]:
        """In the camera's frame, metres, shape (3,)."""

    @property
    def axes(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Columns: x (ahead), y (left) and z (up) in the camera's frame, shape (3, 3).
        """

class Segmentation:
    """
    Planes, and obstacles where they were asked for, of a depth image or a point cloud.
    """

    @property
    def labels(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        One per pixel or point, uint8 of shape (H, W) or (N,): 0 nothing was measured, 1, 2, ... the planes, 255 on no plane.
        The memory is this result's own; no later call writes to it.
        """

    @property
    def planes(self) -> list[Plane]:
        """In the order asked for: planes[i].id == i + 1."""

    @property
    def obstacles(self) -> list[Obstacle]:
        """Nearest first: obstacles[i].id == i + 1. Empty without obstacles=True."""

    @property
    def obstacle_labels(self) -> numpy.typing.NDArray[numpy.uint16] | None:
        """
        uint16 like labels: 0, or an obstacle's id. None without obstacles=True.
        """

    @property
    def support(self) -> list[int]:
        """
        Labels of the support's planes, the chosen first; empty: there is none, as support_reason says, and all that is seen is an obstacle; or obstacles were not asked for.
        """

    @property
    def support_reason(self) -> str | None:
        """
        Why this is the support: 'named', 'floor' or 'surface' (that things stand on); or why there is none: 'no_planes', 'no_such_plane', 'up_unknown', 'no_floor' or 'no_level_plane'. None without obstacles=True.
        """

    @property
    def support_doubt(self) -> str | None:
        """
        What speaks against the support: 'up_unknown', 'tilted' (by more than a ramp of 1 : 12), 'up_uncertain' (by more than 3 degrees) or 'something_lower' (it stands for the floor, and something is seen below it); else None.
        """

    @property
    def ground(self) -> Ground | None:
        """
        Coordinates on the support, or without one on a level plane below all that is seen; None without obstacles=True.
        """

    @property
    def residuals(self) -> numpy.typing.NDArray[numpy.float32] | None:
        """
        Distance of each pixel to its plane, metres, NaN where there is none; None without residuals=True.
        """

    @property
    def method(self) -> str:
        """The method that ran; never 'auto'."""

    @property
    def stop_reason(self) -> str:
        """
        Why the first plane's search ended: 'confidence', 'max_iterations' or 'degenerate'.
        """

    @property
    def timing_ms(self) -> dict[str, float]:
        """Milliseconds by stage, and 'total'."""

    @property
    def up(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """Unit vector in the input's coordinates, shape (3,); None: unknown."""

    @property
    def up_source(self) -> str:
        """'given', 'estimated' or 'none'."""

    @property
    def up_sigma_rad(self) -> float | None:
        """
        One sigma of the estimated up's angle, radians; None where up is given or unknown.
        """

    @property
    def sensor_position(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        Where the sensor was, in the input's coordinates, metres, shape (3,); None: unknown.
        """

    @property
    def noise(self) -> dict[str, float] | None:
        """
        Pixel noise that cells worked with, independent from pixel to pixel: one sigma of a depth z is the root of constant_m**2 + (linear * z)**2 + (quadratic_per_m * z**2)**2. None for other methods.
        """

    @property
    def slow_noise(self) -> dict[str, float] | None:
        """
        The same of what pixels near each other share, over tens of pixels. None for other methods.
        """

    @property
    def bias_m(self) -> float | None:
        """
        By how much cells took planes to be bent or shifted, the same in every frame, metres. None for other methods.
        """

    @property
    def iterations(self) -> int:
        """Hypotheses, over all planes."""

    @property
    def valid_points(self) -> int:
        """Measured pixels or points."""

    @property
    def sampled_points(self) -> int:
        """Points that were searched."""

    @property
    def camera(self) -> Camera | None:
        """Of a depth image; None for a cloud."""

    def picture(self, depth: numpy.typing.NDArray[Any] | None = None, colour: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]:
        """
        The planes in colour, (H, W, 3) uint8, over the depth image or a colour picture of its size where given.

        Raises ValueError for a cloud, and for arrays of another size.
        """

    @property
    def note(self) -> str | None:
        """
        Why there is no plane or no support, and what to try; None where there are planes and, with obstacles=True, a support.
        """

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    def __repr__(self) -> str: ...

def segment(depth: numpy.typing.NDArray[Any], camera: Camera | Mapping[str, float] | str | os.PathLike[str] | None = None, method: Literal['auto', 'cells', 'fransac', 'voxel-ransac', 'rransac', 'ransac'] = 'auto', *, fx: float = ..., fy: float = ..., cx: float = ..., cy: float = ..., depth_scale: float = 1000.0, obstacles: bool = False, planes: int | Literal['all'] | None = None, min_support: float | None = None, order: Literal['area', 'support'] | None = None, min_area: float = 0.0, seed: int = 0, threads: int = 1, saturated: int = 65535, up: Sequence[float] | numpy.typing.NDArray[Any] | None = None, sensor_position: Sequence[float] | numpy.typing.NDArray[Any] | None = None, pass_through: bool | None = None, pass_through_axis: Literal['x', 'y', 'z'] = 'z', pass_through_min: float = 0.0, pass_through_max: float = 4.5, pass_through_outside: bool = False, sensor: Literal['auto', 'structured-light', 'stereo', 'tof', 'none'] | str | os.PathLike[str] = 'auto', baseline: float | None = None, disparity_error: float | None = None, constant: float | None = None, linear: float | None = None, quadratic: float | None = None, slow: float | None = None, bias: float | None = None, min_confidence: float = 0.55, parallel_to: Sequence[float] | numpy.typing.NDArray[Any] | None = None, perpendicular_to: Sequence[float] | numpy.typing.NDArray[Any] | None = None, prior_angle: float = 10.0, residuals: bool = False, threshold: float = 0.01, probability: float = 0.99, max_iterations: int = 1000, pretest_points: int | None = None, scoring: Literal['inliers', 'msac'] = 'msac', local_optimisation: bool = True, refine: bool = True, labels_from: Literal['pixels', 'leaves'] = 'pixels', leaf_size: float = 0.02, leaf_point: Literal['centroid', 'centre'] = 'centroid', support: Literal['auto', 'floor', 'table'] | int = 'auto', height_sigmas: float = 4.0, least_height: float = 0.005, least_drop: float = 0.03, min_size: float = 0.01, touching_size: float = 0.02, cluster_distance: float = 0.0) -> Segmentation:
    """
    Finds the planes of a depth image, and on request its obstacles.

    Parameters
    ----------
        depth: (H, W) array of z along the optical axis. uint16: raw units, metres = value / camera.depth_scale, 0 is no measurement.
            float32 and float64: metres; 0, negative, NaN and infinite values are no measurement. Read in place where the values of a
            row lie side by side; other strides, float64, float16, whole numbers of other types from 0 to 65535, and other byte orders
            are copied once. What a masked array hides is no measurement.
        camera: a Camera, a dict of its fields, the path of a camera's file, 'freiburg1' to 'freiburg3', or None with the keywords fx, fy,
            cx, cy and depth_scale. Must be of the image's size; a dict may leave the size out.
        method: how planes are found; 'auto' is 'cells', every plane of the image.
        obstacles: whether to look for obstacles, too.

    Options (keywords)
    ------------------
        planes: how many planes to peel off, or 'all' [planes]. Default: by the method
        min_support: smallest support of a plane, as a share of the sampled points [share]. Default: by the method
        order: which plane comes first: most visible square metres, or most points. Default: by the method
        min_area: smallest visible area of a plane [m^2]. Default: 0.0
        seed: seed of the random samples. Default: 0
        threads: threads to use, 0 for all cores; never changes the answer [threads]. Default: 1
        saturated: raw 16-bit value that means no measurement beside 0; 0: none. Default: 65535
        up: up in the frame of the camera or cloud, which tells floors from walls; cells estimates it. Default: by the method
        sensor_position: where the sensor was: floors are below it; of clouds else the PCD's VIEWPOINT [m]. Default: by the method
        pass_through: keep only points within limits along an axis. Default: by the method
        pass_through_axis: the axis that the limits apply to. Default: 'z'
        pass_through_min: lower limit [m]. Default: 0.0
        pass_through_max: upper limit [m]. Default: 4.5
        pass_through_outside: keep what lies outside the limits instead. Default: False
        sensor: cells: how depth was measured, which tells cells its noise; auto: estimated from the frame; or a sensor.json. Default: 'auto'
        baseline: cells: between projector and camera, or between two cameras [m]. Default: by the method
        disparity_error: cells: one sigma of the disparity [px]. Default: by the method
        constant: cells: part of one sigma of the depth at any distance [m]. Default: by the method
        linear: cells: part of one sigma of the depth per metre of distance [m per m]. Default: by the method
        quadratic: cells: part of one sigma of the depth per squared metre of distance [m per m^2]. Default: by the method
        slow: cells: one sigma of what pixels near each other share, of that of a pixel [share]. Default: by the method
        bias: cells: by how much planes may be bent or shifted [m]. Default: by the method
        min_confidence: cells: planes less certain than this are left out. Default: 0.55
        parallel_to: cells: only planes whose normal has this direction. Default: by the method
        perpendicular_to: cells: only planes whose normal is perpendicular to this direction. Default: by the method
        prior_angle: cells: by how much a normal may differ from parallel-to and perpendicular-to [degrees]. Default: 10.0
        residuals: cells: keep the distance of every pixel to its plane. Default: False
        threshold: all methods but cells: largest distance of an inlier to its plane [m]. Default: 0.01
        probability: all methods but cells: confidence of having drawn a sample of inliers only. Default: 0.99
        max_iterations: all methods but cells: cap on the hypotheses per plane [hypotheses]. Default: 1000
        pretest_points: all methods but cells: d of the T(d,d) pre-test, 0 for none [points]. Default: by the method
        scoring: all methods but cells: compare hypotheses by inlier count or truncated squared distance. Default: 'msac'
        local_optimisation: all methods but cells: refit promising hypotheses to their inliers. Default: True
        refine: all methods but cells: least-squares fit of the final plane to its inliers. Default: True
        labels_from: all methods but cells: label every pixel near a plane, or the pixels whose leaf is an inlier (the paper). Default: 'pixels'
        leaf_size: fransac and voxel-ransac: edge of a voxel-grid leaf [m]. Default: 0.02
        leaf_point: fransac and voxel-ransac: the point that stands for a leaf. Default: 'centroid'

    Options with obstacles=True
    ---------------------------
        support: the plane that obstacles are above or below; auto: the floor, else as table; table: the surface that things stand on; or a plane's label. Default: 'auto'
        height_sigmas: noise that is no obstacle, in standard deviations of a pixel's height [sigmas]. Default: 4.0
        least_height: height above the support that is no obstacle [m]. Default: 0.005
        least_drop: depth below the support that is no drop [m]. Default: 0.03
        min_size: smallest obstacle, as the square root of its visible area [m]. Default: 0.01
        touching_size: smallest obstacle that is told from another that it touches, likewise [m]. Default: 0.02
        cluster_distance: clouds: points nearer to each other than this are of one obstacle; 0: four times their spacing [m]. Default: 0.0

    Raises
    ------
        TypeError: an unknown option, or a value of another type than its own; the message names it.
        ValueError: a value out of its range, a shape that does not fit; the message names the argument.
        NoDataError: fewer than three measured points, none within the pass-through limits, or all on one line.
        MemoryError: not enough memory.
    """

def segment_cloud(points: numpy.typing.NDArray[Any], method: Literal['auto', 'cells', 'fransac', 'voxel-ransac', 'rransac', 'ransac'] = 'auto', *, obstacles: bool = False, planes: int | Literal['all'] | None = None, min_support: float | None = None, order: Literal['area', 'support'] | None = None, min_area: float = 0.0, seed: int = 0, threads: int = 1, saturated: int = 65535, up: Sequence[float] | numpy.typing.NDArray[Any] | None = None, sensor_position: Sequence[float] | numpy.typing.NDArray[Any] | None = None, pass_through: bool | None = None, pass_through_axis: Literal['x', 'y', 'z'] = 'z', pass_through_min: float = 0.0, pass_through_max: float = 4.5, pass_through_outside: bool = False, sensor: Literal['auto', 'structured-light', 'stereo', 'tof', 'none'] | str | os.PathLike[str] = 'auto', baseline: float | None = None, disparity_error: float | None = None, constant: float | None = None, linear: float | None = None, quadratic: float | None = None, slow: float | None = None, bias: float | None = None, min_confidence: float = 0.55, parallel_to: Sequence[float] | numpy.typing.NDArray[Any] | None = None, perpendicular_to: Sequence[float] | numpy.typing.NDArray[Any] | None = None, prior_angle: float = 10.0, residuals: bool = False, threshold: float = 0.01, probability: float = 0.99, max_iterations: int = 1000, pretest_points: int | None = None, scoring: Literal['inliers', 'msac'] = 'msac', local_optimisation: bool = True, refine: bool = True, labels_from: Literal['pixels', 'leaves'] = 'pixels', leaf_size: float = 0.02, leaf_point: Literal['centroid', 'centre'] = 'centroid', support: Literal['auto', 'floor', 'table'] | int = 'auto', height_sigmas: float = 4.0, least_height: float = 0.005, least_drop: float = 0.03, min_size: float = 0.01, touching_size: float = 0.02, cluster_distance: float = 0.0) -> Segmentation:
    """
    Finds the planes of a point cloud, and on request its obstacles.

    Parameters
    ----------
        points: (N, 3) or, organised, (H, W, 3) array of float32 or float64, metres, with any strides; other numbers are converted, and a
            fourth value of each point is not looked at. Points that are not finite, that a masked array hides, or that are
            exactly (0, 0, 0), are no measurements: label 0. Coordinates of any size keep their precision.
        method: how planes are found; 'auto' is 'cells' for what a pinhole camera saw, else 'fransac', which finds one plane unless planes
            says otherwise.
        obstacles: whether to look for obstacles, too.

    Options (keywords)
    ------------------
        planes: how many planes to peel off, or 'all' [planes]. Default: by the method
        min_support: smallest support of a plane, as a share of the sampled points [share]. Default: by the method
        order: which plane comes first: most visible square metres, or most points. Default: by the method
        min_area: smallest visible area of a plane [m^2]. Default: 0.0
        seed: seed of the random samples. Default: 0
        threads: threads to use, 0 for all cores; never changes the answer [threads]. Default: 1
        saturated: raw 16-bit value that means no measurement beside 0; 0: none. Default: 65535
        up: up in the frame of the camera or cloud, which tells floors from walls; cells estimates it. Default: by the method
        sensor_position: where the sensor was: floors are below it; of clouds else the PCD's VIEWPOINT [m]. Default: by the method
        pass_through: keep only points within limits along an axis. Default: by the method
        pass_through_axis: the axis that the limits apply to. Default: 'z'
        pass_through_min: lower limit [m]. Default: 0.0
        pass_through_max: upper limit [m]. Default: 4.5
        pass_through_outside: keep what lies outside the limits instead. Default: False
        sensor: cells: how depth was measured, which tells cells its noise; auto: estimated from the frame; or a sensor.json. Default: 'auto'
        baseline: cells: between projector and camera, or between two cameras [m]. Default: by the method
        disparity_error: cells: one sigma of the disparity [px]. Default: by the method
        constant: cells: part of one sigma of the depth at any distance [m]. Default: by the method
        linear: cells: part of one sigma of the depth per metre of distance [m per m]. Default: by the method
        quadratic: cells: part of one sigma of the depth per squared metre of distance [m per m^2]. Default: by the method
        slow: cells: one sigma of what pixels near each other share, of that of a pixel [share]. Default: by the method
        bias: cells: by how much planes may be bent or shifted [m]. Default: by the method
        min_confidence: cells: planes less certain than this are left out. Default: 0.55
        parallel_to: cells: only planes whose normal has this direction. Default: by the method
        perpendicular_to: cells: only planes whose normal is perpendicular to this direction. Default: by the method
        prior_angle: cells: by how much a normal may differ from parallel-to and perpendicular-to [degrees]. Default: 10.0
        residuals: cells: keep the distance of every pixel to its plane. Default: False
        threshold: all methods but cells: largest distance of an inlier to its plane [m]. Default: 0.01
        probability: all methods but cells: confidence of having drawn a sample of inliers only. Default: 0.99
        max_iterations: all methods but cells: cap on the hypotheses per plane [hypotheses]. Default: 1000
        pretest_points: all methods but cells: d of the T(d,d) pre-test, 0 for none [points]. Default: by the method
        scoring: all methods but cells: compare hypotheses by inlier count or truncated squared distance. Default: 'msac'
        local_optimisation: all methods but cells: refit promising hypotheses to their inliers. Default: True
        refine: all methods but cells: least-squares fit of the final plane to its inliers. Default: True
        labels_from: all methods but cells: label every pixel near a plane, or the pixels whose leaf is an inlier (the paper). Default: 'pixels'
        leaf_size: fransac and voxel-ransac: edge of a voxel-grid leaf [m]. Default: 0.02
        leaf_point: fransac and voxel-ransac: the point that stands for a leaf. Default: 'centroid'

    Options with obstacles=True
    ---------------------------
        support: the plane that obstacles are above or below; auto: the floor, else as table; table: the surface that things stand on; or a plane's label. Default: 'auto'
        height_sigmas: noise that is no obstacle, in standard deviations of a pixel's height [sigmas]. Default: 4.0
        least_height: height above the support that is no obstacle [m]. Default: 0.005
        least_drop: depth below the support that is no drop [m]. Default: 0.03
        min_size: smallest obstacle, as the square root of its visible area [m]. Default: 0.01
        touching_size: smallest obstacle that is told from another that it touches, likewise [m]. Default: 0.02
        cluster_distance: clouds: points nearer to each other than this are of one obstacle; 0: four times their spacing [m]. Default: 0.0

    Raises
    ------
        TypeError: an unknown option, or a value of another type than its own; the message names it.
        ValueError: a value out of its range, a shape that does not fit; the message names the argument.
        NoDataError: fewer than three measured points, none within the pass-through limits, or all on one line.
        MemoryError: not enough memory.
    """

def png_of(segmentation: Segmentation) -> bytes:
    """Its picture as a PNG file."""

def time_in_cpp(depth: numpy.typing.NDArray[Any], camera: Camera, repeat: int) -> list[float]:
    """Milliseconds of calls of the library itself, for benchmarks."""

class VoxelGrid:
    """One point per occupied cube of a regular grid."""

    @property
    def points(self) -> numpy.typing.NDArray[Any]:
        """
        Of the leaves, (M, 3), metres, of the input's type, in the order in which the input first enters them.
        """

    @property
    def counts(self) -> numpy.typing.NDArray[numpy.int32]:
        """Input points in each leaf, (M,) int32."""

    @property
    def leaf_of(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        The leaf of each input point, int32 of shape (N,) or (H, W); -1 for points that are not finite.
        """

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

def voxel_grid(points: numpy.typing.NDArray[Any], leaf_size: float = 0.02, *, threads: int = 1, leaf_point: Literal['centroid', 'centre'] = 'centroid') -> VoxelGrid:
    """
    Sorts points into cubes and keeps one point for each.

    Parameters
    ----------
        points: (N, 3) or (H, W, 3) array of float32 or float64, metres, with any strides. Points that are not finite are in no leaf.
        leaf_size: edge of a cube, metres. The lattice contains the origin.

    Options (keywords)
    ------------------
        threads: threads to use, 0 for all cores; never changes the answer [threads]. Default: 1
        leaf_point: fransac and voxel-ransac: the point that stands for a leaf. Default: 'centroid'

    Raises
    ------
        TypeError, ValueError: as segment; the message names the argument. A leaf too small for the cloud's extent is a ValueError.
    """

class RansacResult:
    """A plane, n . p + d = 0 in metres, and the points within the threshold."""

    @property
    def normal(self) -> numpy.typing.NDArray[numpy.float64]:
        """Unit normal, shape (3,); the origin is on its side."""

    @property
    def d(self) -> float:
        """Distance of the origin, metres, >= 0."""

    @property
    def coefficients(self) -> numpy.typing.NDArray[numpy.float64]:
        """(normal, d), shape (4,)."""

    @property
    def inliers(self) -> numpy.typing.NDArray[numpy.int64]:
        """Numbers of the points within the threshold, ascending."""

    @property
    def rms_m(self) -> float:
        """Root mean square distance of the inliers, metres."""

    @property
    def iterations(self) -> int:
        """Hypotheses drawn."""

    @property
    def stop_reason(self) -> str:
        """'confidence' or 'max_iterations'."""

    def __repr__(self) -> str: ...

def ransac(points: numpy.typing.NDArray[Any], *, seed: int = 0, threads: int = 1, threshold: float = 0.01, probability: float = 0.99, max_iterations: int = 1000, pretest_points: int | None = None, scoring: Literal['inliers', 'msac'] = 'msac', local_optimisation: bool = True, refine: bool = True) -> RansacResult:
    """
    The plane with the most support, by RANSAC (Fischler & Bolles 1981) with eq. 2 of Zeineldin & El-Fishawy as its stop.

    Parameters
    ----------
        points: (N, 3) or (H, W, 3) array of float32 or float64, metres, with any strides. Points that are not finite are no inliers.

    Options (keywords)
    ------------------
        seed: seed of the random samples. Default: 0
        threads: threads to use, 0 for all cores; never changes the answer [threads]. Default: 1
        threshold: all methods but cells: largest distance of an inlier to its plane [m]. Default: 0.01
        probability: all methods but cells: confidence of having drawn a sample of inliers only. Default: 0.99
        max_iterations: all methods but cells: cap on the hypotheses per plane [hypotheses]. Default: 1000
        pretest_points: all methods but cells: d of the T(d,d) pre-test, 0 for none [points]. Default: by the method
        scoring: all methods but cells: compare hypotheses by inlier count or truncated squared distance. Default: 'msac'
        local_optimisation: all methods but cells: refit promising hypotheses to their inliers. Default: True
        refine: all methods but cells: least-squares fit of the final plane to its inliers. Default: True

    Raises
    ------
        TypeError, ValueError: as segment; the message names the argument.
        NoDataError: fewer than three finite points, or all on one line.
    """

class TrackedPlane:
    """A plane that keeps its id from frame to frame, smoothed."""

    @property
    def id(self) -> int:
        """For as long as it is tracked, from 1; no two have the same."""

    @property
    def label(self) -> int:
        """Of the frame's segmentation."""

    @property
    def normal(self) -> numpy.typing.NDArray[numpy.float64]:
        """Unit normal in this frame's camera frame, shape (3,)."""

    @property
    def d(self) -> float:
        """Distance of the camera, metres."""

    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """Of (normal, d), shape (4, 4), rank 3."""

    @property
    def age(self) -> int:
        """Frames in which it was seen, this one included."""

    def __repr__(self) -> str: ...

class TrackedObject:
    """An obstacle that keeps its id from frame to frame."""

    @property
    def id(self) -> int:
        """As a plane's, counted by itself."""

    @property
    def obstacle(self) -> int:
        """Its id in the frame's obstacles."""

    @property
    def age(self) -> int:
        """Frames in which it was seen, this one included."""

    def __repr__(self) -> str: ...

class TrackedFrame:
    """What a tracker says of one frame."""

    @property
    def pose(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        T_world_camera, shape (4, 4): from the camera's frame to the first frame's, or to that of the poses given; metres.
        """

    @property
    def pose_source(self) -> str:
        """'given', 'estimated' or 'guessed'."""

    @property
    def planes(self) -> list[TrackedPlane]:
        """In the order of the segmentation."""

    @property
    def objects(self) -> list[TrackedObject]:
        """In the order of the obstacles; drops are left out."""

class Tracker:
    """
    Planes and obstacles that keep their ids from frame to frame, and the camera's pose. Feed it frames in order; threads take
    turns. docs/algorithms.md, "Tracking", derives the steps.

    Options (keywords)
    ------------------
        track_rotation: one sigma of how the camera's turning changes between frames [deg]. Default: 1.5
        track_translation: one sigma of how the camera's motion changes between frames [m]. Default: 0.02
        track_gate: largest difference of a plane to the one of the frame before [sigmas]. Default: 3.0
        track_gap: longest absence after which an id comes back [frames]. Default: 30
        track_drift_angle: one sigma of a plane's apparent turning per frame [deg]. Default: 0.02
        track_drift_offset: one sigma of a plane's apparent motion per frame [m]. Default: 0.0005
        track_object_reach: farthest that an object's middle may seem to jump [m]. Default: 0.1
    """

    def __init__(self, *, track_rotation: float = 1.5, track_translation: float = 0.02, track_gate: float = 3.0, track_gap: int = 30, track_drift_angle: float = 0.02, track_drift_offset: float = 0.0005, track_object_reach: float = 0.1) -> None: ...

    def update(self, segmentation: Segmentation, pose: numpy.typing.NDArray[numpy.float64] | None = None) -> TrackedFrame:
        """
        Takes the next frame.

        Parameters
        ----------
            segmentation: of method 'cells'; its obstacles are tracked where they were asked for.
            pose: T_world_camera, (4, 4) float64, where it is known; known in one frame, it should be in all.

        Raises
        ------
            ValueError: a pose that is no rotation and translation; a method without covariances.
        """

    def reset(self) -> None:
        """Forgets everything but the options."""

class Detection:
    """
    Precision, recall and F1 (Zeineldin & El-Fishawy eqs. 3 to 5), from pixel counts.
    """

    @property
    def precision(self) -> float:
        """TP / (TP + FP); 0 when nothing was predicted."""

    @property
    def recall(self) -> float:
        """TP / (TP + FN); 0 when nothing is true."""

    @property
    def f1(self) -> float:
        """Harmonic mean; 0 when both are 0."""

    @property
    def true_positives(self) -> int:
        """Pixels."""

    @property
    def false_positives(self) -> int:
        """Pixels."""

    @property
    def false_negatives(self) -> int:
        """Pixels."""

    def __repr__(self) -> str: ...

class PlanesAtIou:
    """Planes matched at one least IoU."""

    @property
    def threshold(self) -> float:
        """The least IoU of a match."""

    @property
    def matched(self) -> int:
        """Pairs."""

    @property
    def precision(self) -> float:
        """
        Share of the predicted planes that are matched; what is mostly on ignored pixels and unmatched is left out.
        """

    @property
    def recall(self) -> float:
        """Share of the true planes that are matched."""

    @property
    def f1(self) -> float:
        """Harmonic mean."""

    @property
    def mean_iou(self) -> float:
        """Of the matched pairs; 0 without any."""

    def __repr__(self) -> str: ...

class PlaneMetrics:
    """Matches of predicted to true planes (EVOPS 2022, Hoover et al. 1996)."""

    @property
    def true_planes(self) -> int:
        """Planes of the truth that count."""

    @property
    def predicted_planes(self) -> int:
        """Predicted planes that count."""

    @property
    def at50(self) -> PlanesAtIou:
        """IoU >= 0.5."""

    @property
    def at75(self) -> PlanesAtIou:
        """IoU >= 0.75."""

    @property
    def under_segmentation(self) -> float:
        """Share of predicted planes over two or more true ones."""

    @property
    def over_segmentation(self) -> float:
        """Share of true planes under two or more predicted ones."""

    @property
    def missed(self) -> float:
        """Share of the true planes without a match at 0.5."""

    @property
    def noise(self) -> float:
        """1 - precision at 0.5; 0 when no predicted plane counts."""

    @property
    def weighted_iou(self) -> float:
        """Best IoU of each true plane, mean weighted by pixels."""

    @property
    def plane_pixel_f1(self) -> float:
        """F1 of 'on some plane' over the judged pixels."""

class Evaluation:
    """How well labels agree with the truth."""

    @property
    def dominant(self) -> Detection:
        """
        The first predicted plane not mostly on ignored pixels, against true plane 1.
        """

    @property
    def best(self) -> Detection:
        """The predicted plane that overlaps true plane 1 most, against it."""

    @property
    def best_label(self) -> int:
        """Its label; 0: none overlaps."""

    @property
    def matched(self) -> Detection:
        """The same predicted plane against the true plane that it fits best."""

    @property
    def matched_label(self) -> int:
        """That plane's label in the truth; 0: none."""

    @property
    def planes(self) -> PlaneMetrics:
        """All planes, matched by IoU."""

    def __repr__(self) -> str: ...

def evaluate(truth: numpy.typing.NDArray[numpy.uint8], predicted: Segmentation | numpy.typing.NDArray[numpy.uint8], *, min_share: float = 0.005) -> Evaluation:
    """
    Compares labels with true labels.

    Parameters
    ----------
        truth: uint8 labels, (H, W) or (N,): 0 not judged, 1 the dominant plane, 2, ... others, 255 on no plane.
        predicted: a Segmentation, or labels of the same shape.
        min_share: planes with a smaller share of the judged pixels are left out of `planes`.

    Raises
    ------
        TypeError: labels that are not uint8. ValueError: shapes that differ, a share outside 0 to 1.
    """

class FrameFiles:
    """Where a frame's files are; nothing is loaded yet."""

def list_frames(path: str | os.PathLike[str], max_size: int | None = None) -> list[FrameFiles]: ...

def load_frame(files: FrameFiles, camera: Camera | Mapping[str, float] | str | os.PathLike[str] | None = None) -> Frame: ...

class Frame:
    """A depth frame from files."""

    @property
    def name(self) -> str:
        """The frame folder's name, or the timestamp of a sequence."""

    @property
    def timestamp_s(self) -> float | None:
        """Of a TUM sequence, seconds."""

    @property
    def camera(self) -> Camera:
        """Of the image's size."""

    @property
    def depth(self) -> numpy.typing.NDArray[numpy.uint16] | numpy.typing.NDArray[numpy.float32]:
        """
        (H, W) uint16, raw units: metres = value / camera.depth_scale; or float32, metres, where the file holds floats. 0 is no measurement.
        """

    @property
    def labels(self) -> numpy.typing.NDArray[numpy.uint8] | None:
        """True labels, (H, W) uint8, where the frame has some."""

    @property
    def objects(self) -> numpy.typing.NDArray[numpy.uint16] | None:
        """True objects, (H, W) uint16, where the frame has some."""

    def __repr__(self) -> str: ...

class SynthFrame:
    """A rendered depth frame and the truth about it."""

    @property
    def camera(self) -> Camera:
        """That took it."""

    @property
    def depth(self) -> numpy.typing.NDArray[numpy.uint16]:
        """
        (H, W) uint16, raw units: metres = value / camera.depth_scale; 0 is no measurement.
        """

    @property
    def exact_depth(self) -> numpy.typing.NDArray[numpy.float32]:
        """(H, W) float32, metres, without noise; 0: the ray hits nothing."""

    @property
    def labels(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        (H, W) uint8: 0 no depth or not to be judged, 1 the dominant plane, 2, ... others, 255 on no plane.
        """

    @property
    def objects(self) -> numpy.typing.NDArray[numpy.uint16]:
        """(H, W) uint16: which free-standing thing each pixel sees; 0: none."""

    @property
    def colour(self) -> numpy.typing.NDArray[numpy.uint8]:
        """(H, W, 3) uint8, a shaded picture."""

    @property
    def planes(self) -> list[tuple[int, numpy.typing.NDArray[numpy.float64], float]]:
        """(label, normal, d) of the true planes, in the camera's frame, metres."""

    @property
    def pose(self) -> numpy.typing.NDArray[numpy.float64]:
        """T_world_camera, shape (4, 4), metres; the world's z is up."""

    def __repr__(self) -> str: ...

def synth(scene: str = 'desk', *, noise: Literal['none', 'kinect1', 'stereo', 'tof'] = 'kinect1', seed: int = 0, frame: int = 0, motion: Literal['sway', 'walk'] = 'sway', camera: Camera | Mapping[str, float] | str | os.PathLike[str] | None = None) -> SynthFrame:
    """
    Renders a frame of a made-up scene with exact truth. The same arguments give the same bytes.

    Parameters
    ----------
        scene: 'empty_room', 'desk', 'stairs', 'corridor', 'kerb', 'office', 'boxes', 'hall', 'curved'.
        noise: how depth is measured: 'none' is exact; 'kinect1' structured light; 'stereo'; 'tof' time of flight.
        seed: another seed, another room.
        frame: frames of one seed show one scene from a moving camera.
        motion: 'sway' about 1 cm, or 'walk' through the scene.
        camera: as segment takes it; without one 640 x 480 pixels of 0.2 mm.

    Raises
    ------
        ValueError: an unknown scene, noise or motion, a camera out of its range, a negative frame.
    """

scene_names: tuple[str, ...]

def instruction_set() -> str:
    """
    The instruction set that runs on this machine: 'AVX2', 'SSE4', 'NEON', 'SCALAR', ...
    """

version: str

compiler: str
