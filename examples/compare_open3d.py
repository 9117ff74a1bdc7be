# SPDX-License-Identifier: Apache-2.0
"""One plane of a point cloud, by Open3D and by fransac with the same call: compare_open3d.py

Needs Open3D (pip install open3d); says so without.
"""

import importlib.util
import time
from collections.abc import Callable
from typing import Any

import numpy

import fransac
import fransac.open3d


def median_ms(call: Callable[[], Any], repeat: int = 5) -> float:
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - start))
    return float(numpy.median(times))


def main() -> None:
    if importlib.util.find_spec("open3d") is None:
        print("Open3D is not installed: nothing to compare with")
        return
    import open3d

    frame = fransac.synth("desk")
    camera = frame.camera
    v, u = numpy.nonzero(frame.depth)
    z = frame.depth[v, u] / camera.depth_scale
    points = numpy.stack([z * (u - camera.cx) / camera.fx, z * (v - camera.cy) / camera.fy, z], axis=1)
    pcd = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))

    def by_open3d() -> Any:
        return pcd.segment_plane(distance_threshold=0.01, ransac_n=3, num_iterations=1000)

    def by_fransac() -> Any:
        return fransac.open3d.segment_plane(pcd, distance_threshold=0.01, ransac_n=3, num_iterations=1000)

    print(f"{len(points)} points")
    for name, call in (("Open3D", by_open3d), ("fransac", by_fransac)):
        model, inliers = call()
        print(f"{name:<8} {median_ms(call):8.1f} ms, {len(inliers):6} inliers, plane {numpy.round(model, 3)}")


if __name__ == "__main__":
    main()
