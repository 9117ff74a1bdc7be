# SPDX-License-Identifier: Apache-2.0
import pickle

import numpy
import pytest

import fransac


@pytest.fixture(scope="module")
def found(desk):
    return fransac.segment(desk.depth, desk.camera, obstacles=True)


def test_obstacles(found, desk):
    assert [o.id for o in found.obstacles] == list(range(1, len(found.obstacles) + 1))
    assert [o.nearest_m for o in found.obstacles] == sorted(o.nearest_m for o in found.obstacles)
    for o in found.obstacles:
        assert o.pixels == (found.obstacle_labels == o.id).sum()
        assert o.kind in ("object", "plane", "drop") and isinstance(o.contact, bool)
        assert o.box.centre.shape == (3,) and o.box.size[0] >= o.box.size[1] >= 0
        assert o.min_height_m <= o.max_height_m
        assert set(o.planes) <= {plane.id for plane in found.planes}
    assert found.support and found.planes[found.support[0] - 1].kind == "floor"
    assert found.timing_ms["obstacles"] > 0
    floor = found.planes[found.support[0] - 1]
    assert numpy.allclose(found.ground.axes[:, 2], floor.normal, atol=1e-6)
    assert numpy.allclose(found.ground.axes @ found.ground.axes.T, numpy.eye(3))
    assert abs(floor.normal @ found.ground.origin + floor.d) < 1e-6


def test_true_objects_are_found(found, desk):
    for thing in numpy.unique(desk.objects[desk.objects > 0]):
        mine = desk.objects == thing
        if mine.sum() > 3000:
            assert (found.obstacle_labels[mine] > 0).mean() > 0.7


def test_options(desk):
    table = fransac.segment(desk.depth, desk.camera, obstacles=True, support="table")
    assert table.planes[table.support[0] - 1].kind == "horizontal"
    third = fransac.segment(desk.depth, desk.camera, obstacles=True, support=3)
    assert third.support[0] == 3
    big = fransac.segment(desk.depth, desk.camera, obstacles=True, min_size=0.1)
    assert len(big.obstacles) < len(fransac.segment(desk.depth, desk.camera, obstacles=True).obstacles)


def test_the_support_is_explained(desk):
    found = fransac.segment(desk.depth, desk.camera, obstacles=True)
    assert found.support_reason == "floor" and found.support_doubt is None and found.note is None
    assert 0 < found.up_sigma_rad < 0.1 and numpy.array_equal(found.sensor_position, [0, 0, 0])
    given = fransac.segment(desk.depth, desk.camera, up=tuple(found.up))
    assert given.up_sigma_rad is None and given.support_reason is None
    tilted = fransac.segment(desk.depth, desk.camera, obstacles=True, support=found.support[0], up=(0.3, -1, 0))
    assert tilted.support_reason == "named" and tilted.support_doubt == "tilted"
    again = pickle.loads(pickle.dumps(tilted))
    assert again.support_doubt == "tilted" and numpy.array_equal(again.sensor_position, [0, 0, 0])


def test_without_support_all_is_an_obstacle(wall, camera):
    for up, reason in ((None, "up_unknown"), ((0, -1, 0), "no_level_plane")):
        found = fransac.segment(wall, camera, obstacles=True, support="table", up=up)
        assert found.support == [] and found.support_reason == reason and "no support" in found.note
        assert found.ground is not None and not any(o.contact for o in found.obstacles)
        assert numpy.array_equal(found.obstacle_labels > 0, found.labels > 0)


def test_kinds_follow_from_the_sensors_position_or_from_what_lies_above():
    random = numpy.random.default_rng(4)
    floor = numpy.c_[random.uniform(0, 3, (20000, 2)), random.normal(0, 0.003, 20000)]
    table = numpy.c_[random.uniform(2, 2.8, (6000, 2)), random.normal(0.7, 0.003, 6000)]
    for origin in ((0, 0, 0), (0, 0, 0.3), (0, 0, 20), (0, 0, -0.3), (456789, 5432100, 312)):
        points = numpy.concatenate([floor, table]) + origin
        for sensor in (None, numpy.add(origin, (1, 1, 1.5))):
            found = fransac.segment_cloud(points, planes="all", up=(0, 0, 1), sensor_position=sensor)
            assert [plane.kind for plane in found.planes] == ["floor", "horizontal"], origin
            assert (found.sensor_position is None) == (sensor is None)
    below = fransac.segment_cloud(floor + (0, 0, 5), up=(0, 0, 1), sensor_position=(0, 0, 4))
    assert below.planes[0].kind == "ceiling"


def test_of_a_cloud(room):
    random = numpy.random.default_rng(3)
    box = random.uniform([1, 1, -1.5], [1.3, 1.3, -1.2], (400, 3))
    floor = numpy.c_[random.uniform(-3, 3, (6000, 2)), random.normal(-1.5, 0.002, 6000)]
    found = fransac.segment_cloud(numpy.concatenate([floor, box]), obstacles=True, support=1)
    nearest = found.obstacles[0]
    assert found.obstacle_labels.shape == (6400,)
    assert (found.obstacle_labels[6000:] == nearest.id).mean() > 0.8
    assert numpy.allclose(nearest.box.size, 0.3, atol=0.06)
