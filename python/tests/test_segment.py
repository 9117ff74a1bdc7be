# SPDX-License-Identifier: Apache-2.0
import concurrent.futures
import copy
import gc
import multiprocessing
import pickle
import re
import threading

import numpy
import pytest

import fransac


def test_wall(wall, camera):
    found = fransac.segment(wall, camera)
    (plane,) = found.planes
    assert found.method == "cells" and found.labels.dtype == numpy.uint8 and found.labels.shape == (48, 64)
    assert (found.labels == 1).mean() > 0.99
    assert numpy.allclose(plane.normal, [0, 0, -1], atol=1e-4) and plane.d == pytest.approx(2.0, abs=1e-3)
    assert numpy.allclose(plane.coefficients, [*plane.normal, plane.d])
    assert plane.area_m2 == pytest.approx(64 * 48 * (2 / 50) ** 2, rel=0.01)
    assert plane.covariance.shape == (4, 4) and numpy.allclose(plane.covariance, plane.covariance.T)
    assert plane.inliers == (found.labels == 1).sum()
    assert found.stop_reason in ("confidence", "max_iterations")
    assert found.timing_ms["total"] >= max(found.timing_ms[stage] for stage in ("cells", "labels"))
    assert found.obstacles == [] and found.obstacle_labels is None and found.ground is None and found.residuals is None
    assert found.camera == camera


def test_the_same_as_any_dtype_and_stride(desk):
    expected = fransac.segment(desk.depth, desk.camera, "fransac")
    metres = desk.depth / numpy.float64(desk.camera.depth_scale)
    wide = numpy.zeros((480, 1280), numpy.uint16)
    wide[:, :640] = desk.depth
    spread = numpy.zeros((480, 1280), numpy.uint16)
    spread[:, ::2] = desk.depth
    unaligned = numpy.zeros(desk.depth.nbytes + 1, numpy.uint8)[1:].view(numpy.uint16).reshape(desk.depth.shape)
    unaligned[:] = desk.depth
    read_only = desk.depth.copy()
    read_only.flags.writeable = False
    for name, depth in {
        "rows with gaps": wide[:, :640],
        "columns with gaps": spread[:, ::2],
        "upside down in memory": desk.depth[::-1].copy()[::-1],
        "columns first": numpy.asfortranarray(desk.depth),
        "unaligned": unaligned,
        "read only": read_only,
    }.items():
        found = fransac.segment(depth, desk.camera, "fransac")
        assert numpy.array_equal(found.labels, expected.labels), name
    single = fransac.segment(metres.astype(numpy.float32), desk.camera, "fransac")
    double = fransac.segment(metres, desk.camera, "fransac")
    assert numpy.array_equal(single.labels, double.labels)
    assert (single.labels == expected.labels).mean() > 0.99
    assert numpy.allclose(single.planes[0].normal, expected.planes[0].normal, atol=0.02)


def test_every_number_type_and_byte_order(desk):
    expected = fransac.segment(desk.depth, desk.camera, "fransac")
    for kind in (">u2", "int32", ">i4", "uint32", "int64"):  # int32 is what PIL makes of a 16-bit PNG
        assert numpy.array_equal(fransac.segment(desk.depth.astype(kind), desk.camera, "fransac").labels, expected.labels), kind
    metres = desk.depth / numpy.float32(desk.camera.depth_scale)
    single = fransac.segment(metres, desk.camera, "fransac")
    for kind in (">f4", ">f8"):
        assert numpy.array_equal(fransac.segment(metres.astype(kind), desk.camera, "fransac").labels, single.labels), kind
    half = fransac.segment(metres.astype(numpy.float16), desk.camera, "fransac")
    assert half.valid_points == single.valid_points
    for values in (desk.depth.astype(int) - 1, desk.depth.astype(int) + 65000):
        with pytest.raises(ValueError, match=r"^depth: raw depth must be 0 to 65535, these int64 values are -?\d+ to \d+$"):
            fransac.segment(values, desk.camera)
    with pytest.raises(TypeError, match="^depth: expected whole numbers .* values, got bool"):
        fransac.segment(desk.depth > 0, desk.camera)


def test_a_mask_hides_pixels(desk):
    for depth in (desk.depth, desk.depth.astype(numpy.int32), desk.depth / numpy.float32(desk.camera.depth_scale)):
        masked = numpy.ma.array(depth, mask=False)
        masked[:, :320] = numpy.ma.masked
        found = fransac.segment(masked, desk.camera)
        assert (found.labels[:, :320] == 0).all()
        zeroed = depth.copy()
        zeroed[:, :320] = 0
        assert numpy.array_equal(found.labels, fransac.segment(zeroed, desk.camera).labels)


def everything(result):
    """All that can be compared of a result."""
    names = [name for name in dir(result) if not name.startswith("_") and not callable(getattr(result, name))]
    return {name: getattr(result, name) for name in names}


def assert_same(a, b):
    assert type(a) is type(b)
    if isinstance(a, numpy.ndarray):
        assert numpy.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    elif isinstance(a, (list, tuple)):
        assert len(a) == len(b)
        for x, y in zip(a, b):
            assert_same(x, y)
    elif type(a).__module__.startswith("fransac") and not isinstance(a, fransac.Camera):
        ours, theirs = everything(a), everything(b)
        assert ours.keys() == theirs.keys()
        for name in ours:
            assert_same(ours[name], theirs[name])
    else:
        assert a == b


def test_results_can_be_pickled_and_copied(desk, room):
    results = [
        fransac.segment(desk.depth, desk.camera, obstacles=True, residuals=True),
        fransac.segment_cloud(room, planes=2),
    ]
    for found in [*results, *results[0].planes, *results[0].obstacles, results[0].obstacles[0].box, desk.camera]:
        for again in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found), copy.copy(found)):
            assert again is not found
            assert_same(again, found)
    with pytest.raises(ValueError, match="^state: "):
        plane = results[0].planes[0]
        fransac.Plane.__new__(fransac.Plane).__setstate__(plane.__getstate__()[:-1])


def test_results_come_back_from_other_processes(desk):
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        found = pool.submit(fransac.segment, desk.depth, desk.camera).result()
    assert_same(found.planes, fransac.segment(desk.depth, desk.camera).planes)


def test_an_empty_result_says_why(wall, camera):
    assert fransac.segment(wall, camera).note is None
    noise = numpy.random.default_rng(3).integers(500, 5000, (48, 64)).astype(numpy.uint16)
    found = fransac.segment(noise, camera, "fransac", min_support=0.5)
    assert found.planes == []
    assert re.match(r"no plane has the minimum support, 0\.5 of the \d+ sampled points; try a larger threshold \(now 0\.01 m\) or", found.note)
    assert found.note in repr(found)
    found = fransac.segment(wall, camera, min_area=1e6)
    assert found.planes == [] and found.note.endswith("; min_area may have left planes out")


def test_missing_floats_are_no_measurement(camera):
    depth = numpy.full((48, 64), 2.0, numpy.float32)
    depth[:8] = numpy.nan
    depth[8:12] = -1.0
    depth[12:16] = numpy.inf
    depth[16:20] = 0.0
    labels = fransac.segment(depth, camera).labels
    assert (labels[:20] == 0).all() and (labels[20:] == 1).all()


def test_labels_own_their_memory(wall, camera):
    found = fransac.segment(wall, camera)
    labels = found.labels
    del found
    gc.collect()
    other = numpy.where(numpy.arange(64) < 32, wall, 0).astype(numpy.uint16)
    kept = [fransac.segment(other, camera) for _ in range(20)]
    assert (labels == 1).mean() > 0.99
    assert all((found.labels[:, 40:] == 0).all() for found in kept)
    labels[:] = 7  # theirs to write to
    assert (fransac.segment(wall, camera).labels == 1).mean() > 0.99


def test_memory_does_not_grow(wall, camera):
    def resident():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * 4096

    big = numpy.kron(wall, numpy.ones((10, 10), numpy.uint16))
    lens = fransac.Camera(width=640, height=480, fx=500, fy=500, cx=319.5, cy=239.5)
    for _ in range(5):
        fransac.segment(big, lens)
    before = resident()
    for _ in range(100):
        fransac.segment(big, lens)
    assert resident() - before < 8 << 20  # a hundred label images are 30 MB


def test_threads_work_at_the_same_time_and_agree(desk):
    expected = fransac.segment(desk.depth, desk.camera).labels
    results = [None] * 4

    def work(i):
        for _ in range(3):
            results[i] = fransac.segment(desk.depth, desk.camera).labels

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(numpy.array_equal(result, expected) for result in results)


def test_the_gil_is_released(desk):
    """While a thread is in the library, this one counts."""
    done = threading.Event()

    def work():
        for _ in range(20):
            fransac.segment(desk.depth, desk.camera, "ransac", max_iterations=2000, probability=0.9999999, planes=5)
        done.set()

    thread = threading.Thread(target=work)
    # With the lock held a switch would have to wait for a whole call: at most some hundred rounds.
    thread.start()
    rounds = 0
    while not done.is_set():
        rounds += 1
    thread.join()
    assert rounds > 10000


@pytest.mark.parametrize(
    "method", ["auto", "cells", "fransac", "voxel-ransac", "rransac", "ransac"]
)
def test_methods(method, desk):
    found = fransac.segment(desk.depth, desk.camera, method)
    assert found.planes and found.planes[0].inliers > 10000
    assert found.method == ("cells" if method == "auto" else method)


def test_same_as_the_truth_says(desk):
    result = fransac.evaluate(desk.labels, fransac.segment(desk.depth, desk.camera))
    assert result.planes.at50.f1 > 0.8 and result.planes.plane_pixel_f1 > 0.9


def test_cameras(wall, camera, tmp_path):
    expected = fransac.segment(wall, camera).planes[0].coefficients
    file = tmp_path / "camera.json"
    import json

    file.write_text(json.dumps(camera.to_dict()), encoding="utf-8")
    without_size = {"fx": 50, "fy": 50.0, "cx": 31.5, "cy": 23.5, "depth_scale": 1000}
    for given in (camera.to_dict(), without_size, str(file), file):
        assert numpy.array_equal(fransac.segment(wall, given).planes[0].coefficients, expected)
    assert numpy.array_equal(fransac.segment(wall, **without_size).planes[0].coefficients, expected)
    assert fransac.Camera.from_file(file) == camera == fransac.Camera(**camera.to_dict())
    assert hash(camera) == hash(fransac.Camera(**camera.to_dict())) and eval(f"fransac.{camera!r}") == camera
    assert fransac.Camera.from_file("freiburg1").fx == 517.3


def test_camera_errors(wall, camera, tmp_path):
    good = camera.to_dict()
    for field in good:
        for bad in (float("nan"), float("inf"), -1e9):
            kind = TypeError if field in ("width", "height") else ValueError
            with pytest.raises(kind, match=field):
                fransac.Camera(**{**good, field: bad}) if kind is ValueError else fransac.segment(wall, {**good, field: bad})
    with pytest.raises(ValueError, match="width"):
        fransac.Camera(**{**good, "width": 0})
    with pytest.raises(TypeError, match="'deph_scale'; did you mean 'depth_scale'"):
        fransac.segment(wall, {**good, "deph_scale": 1})
    with pytest.raises(TypeError, match="camera: 'fx' is missing"):
        fransac.segment(wall, {"fy": 1})
    with pytest.raises(TypeError, match="needs a camera, or fx, fy, cx and cy: 'fx' is missing"):
        fransac.segment(wall)
    with pytest.raises(TypeError, match="camera: expected a Camera, a dict or the path of a camera's file, got int"):
        fransac.segment(wall, 5)
    with pytest.raises(TypeError, match="camera: given, and so is fx"):
        fransac.segment(wall, camera, fx=5.0)
    with pytest.raises(TypeError, match="fx: expected a float, got str"):
        fransac.segment(wall, {**good, "fx": "50"})
    with pytest.raises(OSError, match="missing.json"):
        fransac.segment(wall, tmp_path / "missing.json")
    (tmp_path / "empty.json").write_text("{}", encoding="utf-8")
    with pytest.raises(ValueError, match="empty.json"):
        fransac.segment(wall, tmp_path / "empty.json")
    with pytest.raises(ValueError, match="camera is for 64 x 48 pixels"):
        fransac.segment(wall[:40], camera)
    with pytest.raises(AttributeError):
        camera.fx = 3.0


@pytest.mark.parametrize(
    ("depth", "error", "message"),
    [
        (None, TypeError, r"depth: expected an array of shape \(H, W\), got NoneType"),
        ([[1, 2]], TypeError, "depth: .* got list"),
        ("depth.png", TypeError, "depth: .* got str"),
        (numpy.zeros((48, 64), complex), TypeError, "depth: expected whole numbers .* values, got complex128"),
        (numpy.zeros((48, 64), object), TypeError, "depth: .* of object"),
        (numpy.zeros((48, 64, 1), numpy.uint16), ValueError, r"depth: .*\(H, W\), got \(48, 64, 1\)"),
        (numpy.zeros(64, numpy.uint16), ValueError, r"depth: .* got \(64,\)"),
        (numpy.zeros((0, 64), numpy.uint16), ValueError, r"depth: .* got \(0, 64\)"),
        (numpy.broadcast_to(numpy.uint16(1), (1, 40000)), ValueError, r"depth: .* got \(1, 40000\)"),
    ],
)
def test_depth_errors(depth, error, message, camera):
    with pytest.raises(error, match=message):
        fransac.segment(depth, camera)


def test_nothing_measured(camera):
    with pytest.raises(fransac.NoDataError):
        fransac.segment(numpy.zeros((48, 64), numpy.uint16), camera)
    assert issubclass(fransac.NoDataError, ValueError)


def test_text_and_html(desk):
    found = fransac.segment(desk.depth, desk.camera, obstacles=True)
    text = repr(found)
    assert text.startswith("Segmentation of 640 x 480 pixels by cells: ") and "<Plane 1 " in text
    page = found._repr_html_()
    encoded = re.search(r'src="data:image/png;base64,([A-Za-z0-9+/=]+)"', page).group(1)
    import base64

    assert base64.b64decode(encoded)[:8] == b"\x89PNG\r\n\x1a\n"
    assert page.count("<tr>") == 1 + len(found.planes)
    cloud = fransac.segment_cloud(numpy.random.default_rng(1).uniform(0, 1, (500, 3)) * [1, 1, 0.001])
    assert "500 points" in repr(cloud) and "<img" not in cloud._repr_html_()


def test_errors_of_the_sensor(desk):
    found = fransac.segment(desk.depth, desk.camera)
    for noise in (found.noise, found.slow_noise):
        assert list(noise) == ["constant_m", "linear", "quadratic_per_m"] and all(value >= 0 for value in noise.values())
    assert sum(found.noise.values()) > 0 and found.bias_m >= 0
    other = fransac.segment(desk.depth, desk.camera, "ransac")
    assert other.noise is None and other.slow_noise is None and other.bias_m is None


def test_confidence_and_its_evidence(desk):
    found = fransac.segment(desk.depth, desk.camera, min_confidence=0)
    assert len(found.planes) > 1 and all(0 < plane.confidence < 1 for plane in found.planes)
    for plane in found.planes:
        seen = plane.evidence
        # Cells decide before pixels do, so the labels' share is a little different.
        assert seen.share == pytest.approx(plane.inliers / found.valid_points, rel=0.5, abs=0.02)
        assert seen.turn_rad >= 0 and seen.turn_sigma_rad > 0 and 0 <= seen.smooth_border <= 1
    other = fransac.segment(desk.depth, desk.camera, "ransac").planes[0]
    assert other.confidence == 1 and other.evidence.share == 0


def test_picture(desk):
    found = fransac.segment(desk.depth, desk.camera)
    for picture in (found.picture(), found.picture(desk.depth), found.picture(colour=desk.colour)):
        assert picture.shape == (480, 640, 3) and picture.dtype == numpy.uint8
        colours = {tuple(picture[found.labels == plane.id].mean(axis=0).round()) for plane in found.planes}
        assert len(colours) == len(found.planes)
    with pytest.raises(ValueError, match="depth: not the size"):
        found.picture(desk.depth[:100])
    with pytest.raises(ValueError, match="colour: "):
        found.picture(colour=desk.colour[:100])


def test_residuals(desk):
    found = fransac.segment(desk.depth, desk.camera, residuals=True)
    on_plane = (found.labels > 0) & (found.labels < 255)
    assert found.residuals.shape == (480, 640) and found.residuals.dtype == numpy.float32
    assert numpy.isfinite(found.residuals[on_plane]).all() and numpy.isnan(found.residuals[~on_plane]).all()
    first = found.planes[0]
    assert numpy.sqrt((found.residuals[found.labels == 1].astype(float) ** 2).mean()) == pytest.approx(first.rms_m, rel=0.05)


def test_real_frame(data):
    (frame,) = fransac.frames(data / "tum" / "scene1")
    result = fransac.evaluate(frame.labels, fransac.segment(frame.depth, frame.camera, sensor="structured-light"))
    assert result.dominant.f1 > 0.9
