# SPDX-License-Identifier: Apache-2.0
"""Frames from files, rendered frames, and how labels compare with the truth."""

import json
import struct
import zlib

import numpy
import pytest

import fransac


def write_png(path, image):
    """A greyscale PNG, 8 or 16 bit."""
    height, width = image.shape
    rows = b"".join(b"\0" + row.astype(image.dtype.newbyteorder(">")).tobytes() for row in image)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, 8 * image.itemsize, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


@pytest.fixture
def folder(tmp_path, wall, camera):
    for i in range(3):
        frame = tmp_path / f"frame{i}"
        frame.mkdir()
        write_png(frame / "depth.png", wall + numpy.uint16(i))
        write_png(frame / "labels.png", numpy.ones((48, 64), numpy.uint8))
        (frame / "camera.json").write_text(json.dumps(camera.to_dict()), encoding="utf-8")
    return tmp_path


def test_frames(folder, wall, camera):
    frames = list(fransac.frames(folder))
    assert [frame.name for frame in frames] == ["frame0", "frame1", "frame2"]
    for i, frame in enumerate(frames):
        assert numpy.array_equal(frame.depth, wall + i) and frame.depth.dtype == numpy.uint16
        assert frame.camera == camera and (frame.labels == 1).all() and frame.objects is None and frame.timestamp_s is None
    (one,) = fransac.frames(str(folder / "frame1"), {"fx": 80, "fy": 80, "cx": 30, "cy": 20})
    assert one.camera == fransac.Camera(width=64, height=48, fx=80, fy=80, cx=30, cy=20)


def test_images_larger_than_max_size_are_refused(folder):
    assert len(list(fransac.frames(folder, max_size=48 * 64))) > 0
    with pytest.raises(ValueError, match="more than the limit"):
        list(fransac.frames(folder, max_size=48 * 64 - 1))
    with pytest.raises(ValueError, match="max_size"):
        fransac.frames(folder, max_size=0)


def test_frames_errors(folder, tmp_path_factory):
    with pytest.raises(OSError, match="nowhere"):
        fransac.frames(folder / "nowhere")
    with pytest.raises(ValueError):
        fransac.frames(tmp_path_factory.mktemp("empty"))
    with pytest.raises(TypeError):
        fransac.frames(3)
    (folder / "frame0" / "camera.json").unlink()
    with pytest.raises(ValueError, match="camera"):
        next(fransac.frames(folder / "frame0"))
    (folder / "frame0" / "depth.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(ValueError, match="depth.png"):
        list(fransac.frames(folder / "frame0", "freiburg1"))


def test_sequence(data):
    frames = fransac.frames(next((data / "tum_sequence").glob("rgbd_dataset_*")))
    first, second = next(frames), next(frames)
    assert first.timestamp_s < second.timestamp_s and first.depth.shape == (480, 640)
    assert first.camera.depth_scale == 5000


def test_synth():
    frame = fransac.synth("desk", seed=5)
    again = fransac.synth("desk", seed=5)
    assert numpy.array_equal(frame.depth, again.depth) and not numpy.array_equal(frame.depth, fransac.synth("desk").depth)
    assert frame.depth.shape == frame.labels.shape == frame.objects.shape == frame.exact_depth.shape == (480, 640)
    assert frame.colour.shape == (480, 640, 3) and frame.pose.shape == (4, 4)
    v, u = numpy.mgrid[:480, :640]
    c, z = frame.camera, frame.exact_depth.astype(float)
    points = numpy.stack([z * (u - c.cx) / c.fx, z * (v - c.cy) / c.fy, z], axis=-1)
    label, normal, d = frame.planes[0]
    assert label == 1 and numpy.abs(points[frame.labels == 1] @ normal + d).max() < 1e-3
    small = fransac.synth("hall", noise="none", camera=fransac.Camera(width=64, height=48, fx=50, fy=50, cx=32, cy=24))
    assert small.depth.shape == (48, 64)
    assert "desk" in fransac.scene_names


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"scene": "moon"}, ValueError, "moon"),
        ({"scene": 1}, TypeError, "^scene: "),
        ({"noise": "loud"}, ValueError, "^noise: expected one of 'none', "),
        ({"motion": "run"}, ValueError, "^motion: "),
        ({"seed": -1}, ValueError, "^seed: "),
        ({"frame": -1}, ValueError, "frame"),
        ({"frame": 1.5}, TypeError, "^frame: "),
        ({"camera": {"fx": float("nan"), "fy": 1, "cx": 1, "cy": 1}}, ValueError, "fx"),
        ({"camera": {"fx": 500, "fy": 500, "cx": 1, "cy": 1, "width": 30000, "height": 30000}}, ValueError, "."),
    ],
)
def test_synth_errors(options, error, message):
    with pytest.raises(error, match=message):
        fransac.synth(**options)


def test_evaluate():
    truth = numpy.zeros((10, 20), numpy.uint8)
    truth[:, :10], truth[:, 10:18] = 1, 2
    predicted = numpy.full((10, 20), 255, numpy.uint8)
    predicted[:, :8], predicted[:, 10:18] = 2, 1
    result = fransac.evaluate(truth, predicted)
    assert result.dominant.f1 == 0.0 and (result.dominant.false_positives, result.dominant.false_negatives) == (80, 100)
    assert result.best_label == 2 and result.best.precision == 1.0 and result.best.recall == pytest.approx(0.8)
    assert result.matched_label == 2 and result.matched.f1 == 1.0
    planes = result.planes
    assert (planes.true_planes, planes.predicted_planes, planes.at50.matched, planes.at75.matched) == (2, 2, 2, 2)
    assert planes.at50.mean_iou == pytest.approx(0.9) and planes.weighted_iou == pytest.approx((0.8 * 100 + 80) / 180)
    assert planes.missed == planes.noise == planes.over_segmentation == planes.under_segmentation == 0.0
    flipped = fransac.evaluate(truth[::-1], numpy.asfortranarray(predicted)[::-1])
    assert flipped.planes.weighted_iou == planes.weighted_iou
    assert "f1 0.000" in repr(result) and "recall 0.800" in repr(result.best) and "2 matched" in repr(planes.at50)


def test_evaluate_errors():
    good = numpy.ones((4, 5), numpy.uint8)
    with pytest.raises(TypeError, match="^truth: expected uint8 values, got int64"):
        fransac.evaluate(good.astype(int), good)
    with pytest.raises(TypeError, match="^predicted: .* got list"):
        fransac.evaluate(good, [1])
    with pytest.raises(ValueError, match="^predicted: not of truth's shape"):
        fransac.evaluate(good, good.T)
    for bad in (-0.1, 1.1, float("nan")):
        with pytest.raises(ValueError, match="^min_share"):
            fransac.evaluate(good, good, min_share=bad)
