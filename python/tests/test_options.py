# SPDX-License-Identifier: Apache-2.0
"""Every option of the C++ structs, as the generated signatures list them."""

import inspect
import re

import numpy
import pytest

import fransac

NUMBERS = {"float", "float | None"}
WHOLE = {"int", "int | None", "int | typing.Literal['all'] | None"}


def options_of(function):
    """{name: (type, default)} of a generated signature's keyword arguments."""
    (signature, *_), *_ = function.__nb_signature__
    inside = signature[signature.index("*,") + 2 :].rpartition(") ->")[0]
    return {
        name: (kind, default)
        for name, kind, default in re.findall(r"(\w+): ((?:[^=\[]|\[[^\]]*\])+?) = ('[^']*'|[^,]+)(?:,|$)", inside)
    }


SEGMENT = {
    name: option
    for name, option in options_of(fransac.segment).items()
    if name not in ("fx", "fy", "cx", "cy", "depth_scale", "obstacles")
}
TRACK = options_of(fransac.Tracker.__init__)


def test_signatures_hold_what_the_headers_do(request):
    root = request.config.rootpath
    folder = next(p for p in [root, *root.parents] if (p / "include" / "fransac").is_dir()) / "include" / "fransac"
    visited = {}
    for header, function in {
        "planes/options.hpp": "for_each_option",
        "core/sensor.hpp": "for_each_parameter",
        "obstacles/obstacles.hpp": "for_each_obstacle_option",
        "track/tracker.hpp": "for_each_track_option",
    }.items():
        text = (folder / header).read_text(encoding="utf-8")
        body = text[text.index("void " + function) :]
        body = body[: body.index("\n}\n")]
        visited[function] = {name.replace("-", "_") for name in re.findall(r'(?:Info\{|\.name = )"([a-z-]+)"', body)}
        assert len(visited[function]) >= 5
    assert set(TRACK) == visited.pop("for_each_track_option")
    assert set(SEGMENT) == set().union(*visited.values()) - {"method"} | {"support"}
    assert set(options_of(fransac.segment_cloud)) == set(SEGMENT) | {"obstacles"}


def test_every_option_has_a_line_of_documentation():
    for name in SEGMENT:
        assert re.search(rf"^    {name}: \w", fransac.segment.__doc__, re.M), name


def call(name, value, wall, camera):
    """Segments with one option; those of obstacles need obstacles."""
    names = list(SEGMENT)
    obstacles = names.index(name) >= names.index("support")
    return fransac.segment(wall, camera, obstacles=obstacles, **{name: value})


@pytest.mark.parametrize("name", SEGMENT)
def test_default(name, wall, camera):
    default = eval(SEGMENT[name][1])  # as in Python, says the table
    assert call(name, default, wall, camera).planes


@pytest.mark.parametrize("name", SEGMENT)
def test_wrong_values(name, wall, camera):
    kind = SEGMENT[name][0]
    with pytest.raises(TypeError, match=f"^{name}: expected .*, got object$"):
        call(name, object(), wall, camera)
    if "None" not in kind:
        with pytest.raises(TypeError, match=f"^{name}: .* got NoneType$"):
            call(name, None, wall, camera)
    if kind in NUMBERS:
        for bad in (float("nan"), float("inf"), float("-inf"), numpy.float32("nan")):
            with pytest.raises(ValueError, match=f"^{name}\\b.*(must be|out of range)"):
                call(name, bad, wall, camera)
        for bad in (True, "1", 1j):
            with pytest.raises(TypeError, match=f"^{name}: expected a float, got"):
                call(name, bad, wall, camera)
    elif kind in WHOLE:
        for bad in (-1, 2**64):
            with pytest.raises(ValueError, match=f"^{name}: "):
                call(name, bad, wall, camera)
        for bad in (1.0, True, numpy.float64(1)):
            with pytest.raises(TypeError, match=f"^{name}: expected an int, got"):
                call(name, bad, wall, camera)
    elif "Literal" in kind:
        with pytest.raises(ValueError, match=f"^{name}: expected one of .*, got 'nonsense'"):
            call(name, "nonsense", wall, camera)
    elif "bool" in kind:
        with pytest.raises(TypeError, match=f"^{name}: expected a bool, got int"):
            call(name, 1, wall, camera)
    else:
        assert "Sequence" in kind
        out_of_range = (0, 1e31, 0) if name == "sensor_position" else (0, 0, 0)
        for bad in (out_of_range, (1, 2), (1, 2, float("nan")), numpy.zeros(4)):
            with pytest.raises(ValueError, match=f"^{name}: "):
                call(name, bad, wall, camera)
        with pytest.raises(TypeError, match=f"^{name}: "):
            call(name, "xyz", wall, camera)


def test_sensor_from_a_file(tmp_path, desk):
    import json

    file = tmp_path / "sensor.json"
    terms = [0.0] * 25
    known = {"type": "fransac-sensor", "version": 1, "kind": "stereo", "slow": 0.5, "bias_m": 0.004}
    file.write_text(json.dumps(known | {"noise": {"quadratic_per_m": 0.002}, "distortion": None}))
    plain = fransac.segment(desk.depth, desk.camera, sensor="stereo", quadratic=0.002, slow=0.5, bias=0.004)
    for given in (file, str(file)):
        assert numpy.array_equal(fransac.segment(desk.depth, desk.camera, sensor=given).labels, plain.labels)
    bent = [0.01, *terms[1:]]
    file.write_text(json.dumps(known | {"distortion": {"width": 640, "height": 480, "offset_per_m": bent, "gain": terms}}))
    assert fransac.segment(desk.depth, desk.camera, sensor=file).planes[0].d != plain.planes[0].d
    with pytest.raises(ValueError, match="another shape"):
        fransac.segment(desk.depth[:, :320], sensor=file, fx=500, fy=500, cx=160, cy=240)
    file.write_text(json.dumps(known | {"slow": "much"}))
    with pytest.raises(ValueError, match=r'sensor\.json: field "slow" must be a number'):
        fransac.segment(desk.depth, desk.camera, sensor=file)
    with pytest.raises(OSError, match="missing.json"):
        fransac.segment(desk.depth, desk.camera, sensor=tmp_path / "missing.json")


def test_unknown_options(wall, camera, room):
    with pytest.raises(TypeError, match=r"segment\(\) has no option 'treshold'; did you mean 'threshold'\?"):
        fransac.segment(wall, camera, treshold=0.01)
    with pytest.raises(TypeError, match=r"segment\(\) has no option 'zzz'$"):
        fransac.segment(wall, camera, zzz=1, threshold=0.01)
    with pytest.raises(TypeError, match=r"segment_cloud\(\) has no option 'plane'; did you mean 'planes'\?"):
        fransac.segment_cloud(room, plane=1)
    with pytest.raises(TypeError, match=r"ransac\(\) has no option 'leaf_point'"):
        fransac.ransac(room, leaf_point="centre")
    with pytest.raises(TypeError, match=r"voxel_grid\(\) has no option 'leafsize'; did you mean 'leaf_size'\?"):
        fransac.voxel_grid(room, leafsize=1)
    with pytest.raises(TypeError, match=r"Tracker\(\) has no option 'gap'"):
        fransac.Tracker(gap=1)


def test_options_that_do_not_go_together(wall, camera):
    with pytest.raises(ValueError, match="least_height: needs obstacles=True"):
        fransac.segment(wall, camera, least_height=0.01)
    with pytest.raises(ValueError, match="pass_through_min: must be below pass_through_max"):
        fransac.segment(wall, camera, pass_through_min=5.0)
    with pytest.raises(ValueError, match="parallel_to: means nothing to method ransac"):
        fransac.segment(wall, camera, "ransac", parallel_to=(0, 0, 1))
    with pytest.raises(ValueError, match="^baseline"):
        fransac.segment(wall, camera, sensor="tof", baseline=0.1)
    with pytest.raises(ValueError, match="^method: expected one of 'auto', "):
        fransac.segment(wall, camera, "best")
    with pytest.raises(TypeError, match="^method: expected a str, got int"):
        fransac.segment(wall, camera, 3)
    with pytest.raises(ValueError, match="^support"):
        fransac.segment(wall, camera, obstacles=True, support=0)


def test_options_do_what_they_say(desk):
    def segment(**options):
        return fransac.segment(desk.depth, desk.camera, **options)

    assert len(segment(planes=2).planes) == 2
    assert len(segment(planes="all").planes) == len(segment().planes) > 2
    with pytest.raises(ValueError, match="^planes: must be at least 1, or 'all', is 0$"):
        segment(planes=0)
    assert segment(up=(0, -1, 0)).up_source == "given"
    assert all(plane.area_m2 >= 0.2 for plane in segment(min_area=0.2).planes)
    by_support = [plane.inliers for plane in segment(order="support").planes]
    assert by_support == sorted(by_support, reverse=True)
    few = segment(method="ransac", max_iterations=3)
    assert few.iterations == 3 and few.stop_reason == "max_iterations"
    one, four = segment(method="fransac", threads=1), segment(method="fransac", threads=numpy.int64(4))
    assert numpy.array_equal(one.labels, four.labels)
    near = segment(method="ransac", pass_through=True, pass_through_max=1.5)
    metres = desk.depth / desk.camera.depth_scale
    assert near.planes and (near.labels[metres > 1.5] == 255).all()


@pytest.mark.parametrize("name", TRACK)
def test_track_options(name):
    kind, default = TRACK[name]
    fransac.Tracker(**{name: eval(default)})
    bad = float("nan") if kind == "float" else -1
    with pytest.raises(ValueError, match=f"^{name}\\b.*(must be|out of range)"):
        fransac.Tracker(**{name: bad})


def test_signatures_can_be_inspected():
    assert inspect.getdoc(fransac.segment).startswith("segment(depth") or "depth: (H, W) array" in fransac.segment.__doc__
