# SPDX-License-Identifier: Apache-2.0
import math

import numpy
import pytest

import fransac


def test_room(room):
    found = fransac.segment_cloud(room, planes=2, seed=3)
    floor, wall = found.planes
    assert found.labels.shape == (5000,) and found.labels.dtype == numpy.uint8 and found.method == "fransac"
    assert (found.labels[:3000] == 1).mean() > 0.95 and (found.labels[3000:4500] == 2).mean() > 0.9
    assert numpy.allclose(floor.coefficients, [0, 0, 1, 1.5], atol=0.01)
    assert numpy.allclose(wall.coefficients, [-1, 0, 0, 4], atol=0.01)
    assert numpy.allclose(floor.distance(room)[:3000], room[:3000, 2] + 1.5, atol=0.02)
    assert found.camera is None and found.up is None


def test_the_same_as_any_dtype_and_stride(room):
    expected = fransac.segment_cloud(room.astype(numpy.float32), planes=2)
    single = room.astype(numpy.float32)
    with_colours = numpy.zeros((5000, 6), numpy.float32)
    with_colours[:, :3] = single
    record = numpy.zeros(5000, [("xyz", numpy.float32, 3), ("label", numpy.uint8)])
    record["xyz"] = single
    for name, points in {
        "columns of a wider array": with_colours[:, :3],
        "columns first": numpy.asfortranarray(single),
        "backwards in memory": single[::-1].copy()[::-1],
        "every second": numpy.repeat(single, 2, axis=0)[::2],
        "double": single.astype(numpy.float64),
    }.items():
        found = fransac.segment_cloud(points, planes=2)
        assert numpy.array_equal(found.labels, expected.labels), name
        assert numpy.array_equal(found.planes[0].coefficients, expected.planes[0].coefficients), name


def test_every_number_type_and_byte_order(room):
    whole = numpy.round(room * 100).astype(numpy.int16)
    options = {"planes": 2, "threshold": 2.0, "leaf_size": 5.0}
    expected = fransac.segment_cloud(whole.astype(numpy.float64), **options)
    for kind in ("int16", "int32", "int64", ">i4", ">f4", ">f8"):
        assert numpy.array_equal(fransac.segment_cloud(whole.astype(kind), **options).labels, expected.labels), kind
    with_intensity = numpy.c_[whole, numpy.full(len(whole), 99.0)]
    assert numpy.array_equal(fransac.segment_cloud(with_intensity, **options).labels, expected.labels)
    assert len(fransac.voxel_grid(with_intensity, 50.0)) == len(fransac.voxel_grid(whole, 50.0))


def test_a_mask_hides_points(room):
    masked = numpy.ma.array(room, mask=False)
    masked[:1000] = numpy.ma.masked
    found = fransac.segment_cloud(masked, planes=2)
    hidden = room.copy()
    hidden[:1000] = numpy.nan
    assert (found.labels[:1000] == 0).all() and numpy.array_equal(found.labels, fransac.segment_cloud(hidden, planes=2).labels)


def test_points_that_were_not_measured(room):
    points = room.copy()
    points[::10] = numpy.nan
    points[1::10] = 0.0
    points[2::10, 1] = numpy.inf
    labels = fransac.segment_cloud(points).labels
    assert (labels[::10] == 0).all() and (labels[1::10] == 0).all() and (labels[2::10] == 0).all()
    assert (labels[3::10] != 0).all()


def test_large_coordinates_keep_their_precision(room):
    shift = numpy.array([512345.0, 5412345.0, 300.0])
    far = fransac.segment_cloud(room + shift, planes=2)
    near = fransac.segment_cloud(room, planes=2)
    assert (far.labels == near.labels).mean() > 0.98
    plane = far.planes[0]
    assert abs(plane.normal @ shift + plane.d - 1.5 * math.copysign(1.0, plane.normal[2])) < 0.2 * 1e3  # of 5,412 km
    assert numpy.abs(plane.distance(room + shift)[:3000]).mean() < 0.005


def test_organised(desk):
    camera = desk.camera
    v, u = numpy.mgrid[: camera.height, : camera.width]
    z = desk.depth / camera.depth_scale
    points = numpy.stack([z * (u - camera.cx) / camera.fx, z * (v - camera.cy) / camera.fy, z], axis=-1)
    points[desk.depth == 0] = numpy.nan
    cloud = fransac.segment_cloud(points, obstacles=True)
    image = fransac.segment(z.astype(numpy.float32), camera, obstacles=True)
    assert cloud.method == "cells" and cloud.labels.shape == (480, 640)
    assert (cloud.labels == image.labels).mean() > 0.98
    assert cloud.obstacle_labels.shape == (480, 640) and cloud.obstacle_labels.dtype == numpy.uint16
    swapped = fransac.segment_cloud(points.transpose(1, 0, 2)[::-1].transpose(1, 0, 2)[:, ::-1])
    assert numpy.array_equal(swapped.labels, fransac.segment_cloud(points).labels)


@pytest.mark.parametrize("function", [fransac.segment_cloud, fransac.voxel_grid, fransac.ransac])
@pytest.mark.parametrize(
    ("points", "error", "message"),
    [
        (None, TypeError, "points: .* got NoneType"),
        ([[0, 0, 0]], TypeError, "points: .* got list"),
        (numpy.zeros((5, 3), bool), TypeError, "points: expected whole numbers, float16, float32 or float64 values, got bool"),
        (numpy.full((5, 3), 2**60), ValueError, "points: whole numbers beyond"),
        (numpy.zeros((5, 5)), ValueError, r"points: .*\(N, 3\) or \(H, W, 3\).*, got \(5, 5\)"),
        (numpy.zeros(3), ValueError, r"points: .* got \(3,\)"),
        (numpy.zeros((2, 2, 2, 3)), ValueError, r"points: .* got \(2, 2, 2, 3\)"),
    ],
)
def test_errors(function, points, error, message):
    with pytest.raises(error, match=message):
        function(points)


@pytest.mark.parametrize("function", [fransac.segment_cloud, fransac.ransac])
def test_no_data(function):
    line = numpy.linspace(1, 2, 50)[:, None] * [1.0, 2.0, 3.0]
    for points in (numpy.zeros((0, 3)), numpy.full((9, 3), numpy.nan), numpy.ones((2, 3)), line):
        with pytest.raises(fransac.NoDataError):
            function(points)


def test_voxel_grid(room):
    grid = fransac.voxel_grid(room, 0.25)
    assert grid.points.shape == (len(grid), 3) and grid.points.dtype == numpy.float64
    assert grid.counts.sum() == len(room) and (grid.counts > 0).all()
    for leaf in (0, 7, len(grid) - 1):
        mine = room[grid.leaf_of == leaf]
        assert len(mine) == grid.counts[leaf]
        assert numpy.allclose(mine.mean(axis=0), grid.points[leaf], atol=1e-4)
        assert len({tuple(p) for p in numpy.floor(mine.astype(numpy.float32) / numpy.float32(0.25))}) == 1
    keys = numpy.floor(room / 0.25).astype(int)
    assert len(grid) == len(numpy.unique(keys, axis=0))
    centres = fransac.voxel_grid(room.astype(numpy.float32), 0.25, leaf_point="centre").points
    assert centres.dtype == numpy.float32 and numpy.allclose(centres / 0.25 % 1, 0.5, atol=1e-3)


def test_voxel_grid_leaves_out_what_is_not_finite(room):
    points = room[:1000].reshape(20, 50, 3).copy()
    points[3] = numpy.nan
    grid = fransac.voxel_grid(points, 0.1)
    assert grid.leaf_of.shape == (20, 50) and (grid.leaf_of[3] == -1).all() and (grid.leaf_of[4:] >= 0).all()
    assert grid.counts.sum() == 950
    assert len(fransac.voxel_grid(numpy.full((4, 3), numpy.nan))) == 0
    for bad in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="^leaf_size: must be"):
            fransac.voxel_grid(room, bad)
    with pytest.raises(ValueError, match="leaf_size"):
        fransac.voxel_grid(room, 1e-12)


def test_ransac(room):
    found = fransac.ransac(room, threshold=0.02, seed=1)
    distances = numpy.abs(room @ found.normal + found.d)
    assert numpy.array_equal(found.inliers, numpy.flatnonzero(distances <= 0.02))
    assert found.inliers.dtype == numpy.int64 and len(found.inliers) > 2990
    assert found.rms_m == pytest.approx(numpy.sqrt((distances[found.inliers] ** 2).mean()), rel=1e-3)
    assert numpy.allclose(found.coefficients, [0, 0, 1, 1.5], atol=0.005)
    assert found.stop_reason == "confidence" and 0 < found.iterations < 1000
    again = fransac.ransac(room, threshold=0.02, seed=1, threads=4)
    assert numpy.array_equal(again.coefficients, found.coefficients)
    with_gaps = room.copy()
    with_gaps[::7] = numpy.nan
    assert (fransac.ransac(with_gaps, threshold=0.02).inliers % 7 != 0).all()


def test_results_are_arrays_of_their_own(room):
    inliers, points = fransac.ransac(room).inliers, fransac.voxel_grid(room).points
    copies = inliers.copy(), points.copy()
    for _ in range(5):
        fransac.ransac(room[:100])
        fransac.voxel_grid(room[:100])
    assert numpy.array_equal(inliers, copies[0]) and numpy.array_equal(points, copies[1])
