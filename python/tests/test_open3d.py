# SPDX-License-Identifier: Apache-2.0
"""Open3D's signature, without Open3D and beside it."""

import inspect
import types

import numpy
import pytest

import fransac
import fransac.open3d


def test_signature():
    parameters = inspect.signature(fransac.open3d.segment_plane).parameters
    assert list(parameters)[:5] == ["pcd", "distance_threshold", "ransac_n", "num_iterations", "probability"]
    assert [p.default for p in list(parameters.values())[1:5]] == [0.01, 3, 100, 0.99999999]


def test_without_open3d(room):
    pcd = types.SimpleNamespace(points=room)
    model, inliers = fransac.open3d.segment_plane(pcd, 0.02, 3, 1000)
    assert isinstance(model, numpy.ndarray) and model.shape == (4,) and model.dtype == numpy.float64
    assert isinstance(inliers, list) and all(type(i) is int for i in inliers[:10])
    distances = numpy.abs(room @ model[:3] + model[3])
    assert inliers == numpy.flatnonzero(distances <= 0.02).tolist() and numpy.linalg.norm(model[:3]) == pytest.approx(1)
    assert fransac.open3d.segment_plane(types.SimpleNamespace(points=room.tolist()), 0.02, 4, 1000)[1] == inliers


def test_probability_one_asks_for_every_iteration(room):
    pcd = types.SimpleNamespace(points=room)
    model, inliers = fransac.open3d.segment_plane(pcd, 0.02, 3, 200, probability=1.0)
    assert len(inliers) >= 0.99 * len(fransac.open3d.segment_plane(pcd, 0.02, 3, 1000)[1])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"distance_threshold": 0.0}, ValueError, "^distance_threshold: must be"),
        ({"distance_threshold": float("nan")}, ValueError, "^distance_threshold: "),
        ({"ransac_n": 2}, ValueError, "^ransac_n: must be at least 3"),
        ({"ransac_n": 3.0}, TypeError, "^ransac_n: expected an int"),
        ({"num_iterations": 0}, ValueError, "^num_iterations: "),
        ({"probability": 1.5}, ValueError, "^probability: "),
        ({"num_iterations": "9"}, TypeError, "^num_iterations: expected an int, got str"),
    ],
)
def test_errors(arguments, error, message, room):
    with pytest.raises(error, match=message):
        fransac.open3d.segment_plane(types.SimpleNamespace(points=room), **arguments)


def test_no_data():
    with pytest.raises(fransac.NoDataError, match="^pcd: "):
        fransac.open3d.segment_plane(types.SimpleNamespace(points=numpy.zeros((2, 3))))
    with pytest.raises(ValueError, match="^pcd: expected points of shape"):
        fransac.open3d.segment_plane(types.SimpleNamespace(points=numpy.zeros((2, 4))))
    with pytest.raises(fransac.NoDataError, match="^pcd: "):
        fransac.open3d.segment_plane(types.SimpleNamespace(points=numpy.full((20, 3), numpy.nan)))


def test_beside_open3d(room):
    open3d = pytest.importorskip("open3d", reason="Open3D is not installed")
    pcd = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(room))
    theirs, their_inliers = pcd.segment_plane(distance_threshold=0.02, ransac_n=3, num_iterations=1000)
    ours, our_inliers = fransac.open3d.segment_plane(pcd, distance_threshold=0.02, ransac_n=3, num_iterations=1000)
    assert type(ours) is type(theirs) and type(our_inliers) is type(their_inliers)
    theirs = theirs / numpy.linalg.norm(theirs[:3])
    sign = numpy.sign(ours[:3] @ theirs[:3])
    assert numpy.allclose(ours, sign * theirs, atol=0.02)
    assert len(our_inliers) >= 0.99 * len(their_inliers)
    assert len(set(our_inliers) & set(their_inliers)) > 0.98 * len(their_inliers)
