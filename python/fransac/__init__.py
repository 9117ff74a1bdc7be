# SPDX-License-Identifier: Apache-2.0
"""Planes and obstacles in depth frames and point clouds.

    import fransac
    frame = fransac.synth("desk")
    found = fransac.segment(frame.depth, frame.camera)
    print(found)

Metres, radians, pixels; the camera frame is optical: x right, y down, z forward. docs/python.md is the guide.
"""

import copyreg
import os
from collections.abc import Iterator, Mapping

from ._core import (
    Box,
    Camera,
    Detection,
    Evaluation,
    Frame,
    Ground,
    NoDataError,
    Obstacle,
    Plane,
    PlaneEvidence,
    PlaneMetrics,
    PlanesAtIou,
    RansacResult,
    Segmentation,
    SynthFrame,
    TrackedFrame,
    TrackedObject,
    TrackedPlane,
    Tracker,
    VoxelGrid,
    evaluate,
    instruction_set,
    list_frames as _list_frames,
    load_frame as _load_frame,
    ransac,
    scene_names,
    segment,
    segment_cloud,
    synth,
    version as __version__,
    voxel_grid,
)

__all__ = [
    "Box",
    "Camera",
    "Detection",
    "Evaluation",
    "Frame",
    "Ground",
    "NoDataError",
    "Obstacle",
    "Plane",
    "PlaneEvidence",
    "PlaneMetrics",
    "PlanesAtIou",
    "RansacResult",
    "Segmentation",
    "SynthFrame",
    "TrackedFrame",
    "TrackedObject",
    "TrackedPlane",
    "Tracker",
    "VoxelGrid",
    "__version__",
    "evaluate",
    "frames",
    "instruction_set",
    "ransac",
    "scene_names",
    "segment",
    "segment_cloud",
    "synth",
    "voxel_grid",
]


# Functions are pickled by name, as Python's own: multiprocessing takes them.
copyreg.pickle(type(segment), lambda function: function.__name__)


def frames(
    path: str | os.PathLike[str],
    camera: Camera | Mapping[str, float] | str | os.PathLike[str] | None = None,
    *,
    max_size: int | None = None,
) -> Iterator[Frame]:
    """The frames of a depth image, a frame folder, a folder of frames or a TUM RGB-D sequence, loaded one by one.

    Parameters
    ----------
        path: what `fransac segment` takes, clouds aside.
        camera: instead of the frames' own, as segment takes it.
        max_size: the largest image that is read, in pixels; larger ones are a ValueError. Default: 2**25.

    Raises
    ------
        OSError: a file that cannot be read. ValueError: one that holds something else, or no camera. NoDataError: no frame.
    """
    files = _list_frames(path, max_size)
    return (_load_frame(file, camera) for file in files)
