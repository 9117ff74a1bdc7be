# SPDX-License-Identifier: Apache-2.0
import threading

import numpy
import pytest

import fransac


@pytest.fixture(scope="module")
def walk():
    """Five frames of a walk: what was rendered and what was found."""
    frames = [fransac.synth("office", noise="none", frame=i, motion="walk") for i in range(5)]
    return [(f, fransac.segment(f.depth, f.camera, obstacles=True)) for f in frames]


def test_ids_stay_and_the_pose_follows(walk):
    tracker = fransac.Tracker()
    tracked = [tracker.update(found) for _, found in walk]
    assert tracked[0].pose_source in ("estimated", "guessed") and numpy.array_equal(tracked[0].pose, numpy.eye(4))
    assert {p.id for p in tracked[0].planes} & {p.id for p in tracked[-1].planes}
    assert max(p.age for p in tracked[-1].planes) == 5
    for (_, found), frame in zip(walk, tracked):
        assert [p.label for p in frame.planes] == [p.id for p in found.planes]
        assert all(abs(numpy.linalg.norm(p.normal) - 1) < 1e-9 and p.covariance.shape == (4, 4) for p in frame.planes)
        assert {o.obstacle for o in frame.objects} <= {o.id for o in found.obstacles}
    first = numpy.linalg.inv(walk[0][0].pose)
    truth = first @ walk[-1][0].pose
    assert numpy.linalg.norm(tracked[-1].pose[:3, 3] - truth[:3, 3]) < 0.05


def test_given_poses(walk):
    tracker = fransac.Tracker()
    for frame, found in walk:
        tracked = tracker.update(found, frame.pose)
        assert tracked.pose_source == "given" and numpy.allclose(tracked.pose, frame.pose)
    tracker.reset()
    assert min(p.id for p in tracker.update(walk[0][1]).planes) == 1


def test_errors(walk, wall, camera):
    tracker = fransac.Tracker()
    found = walk[0][1]
    for pose in (numpy.eye(3), numpy.eye(4, dtype=numpy.float32), 2 * numpy.eye(4), numpy.diag([1.0, 1, -1, 1]),
                 numpy.full((4, 4), numpy.nan)):  # fmt: skip
        with pytest.raises(ValueError, match="^pose: "):
            tracker.update(found, pose)
    with pytest.raises(TypeError, match="^pose: .* got list"):
        tracker.update(found, [[1]])
    with pytest.raises(ValueError, match="covariance|cells"):
        tracker.update(fransac.segment(wall, camera, "ransac"))


def test_threads_take_turns(walk):
    tracker = fransac.Tracker()
    threads = [threading.Thread(target=lambda: [tracker.update(found) for _, found in walk]) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert tracker.update(walk[0][1]).planes
