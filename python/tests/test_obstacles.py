# SPDX-License-Identifier: Apache-2.0
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


def test_without_support(wall, camera):
    found = fransac.segment(wall, camera, obstacles=True, support="table")
    assert found.support == [] and found.ground is None and found.obstacles == []
    assert not found.obstacle_labels.any() and found.obstacle_labels.shape == found.labels.shape


def test_of_a_cloud(room):
    random = numpy.random.default_rng(3)
    box = random.uniform([1, 1, -1.5], [1.3, 1.3, -1.2], (400, 3))
    floor = numpy.c_[random.uniform(-3, 3, (6000, 2)), random.normal(-1.5, 0.002, 6000)]
    found = fransac.segment_cloud(numpy.concatenate([floor, box]), obstacles=True, support=1)
    nearest = found.obstacles[0]
    assert found.obstacle_labels.shape == (6400,)
    assert (found.obstacle_labels[6000:] == nearest.id).mean() > 0.8
    assert numpy.allclose(nearest.box.size, 0.3, atol=0.06)
