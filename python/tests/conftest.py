# SPDX-License-Identifier: Apache-2.0
import pathlib

import numpy
import pytest

import fransac

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
DATA = REPOSITORY.parent / "shared" / "data"


@pytest.fixture(scope="session")
def data():
    """Real frames with truth."""
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}")
    return DATA


@pytest.fixture(scope="session")
def camera():
    return fransac.Camera(width=64, height=48, fx=50.0, fy=50.0, cx=31.5, cy=23.5, depth_scale=1000.0)


@pytest.fixture(scope="session")
def wall():
    """A wall two metres in front of the camera, in millimetres."""
    return numpy.full((48, 64), 2000, numpy.uint16)


@pytest.fixture(scope="session")
def desk():
    return fransac.synth("desk")


@pytest.fixture(scope="session")
def room():
    """5,000 points: a floor z = -1.5, a wall x = 4, and a tenth of clutter; seeded."""
    random = numpy.random.default_rng(7)
    floor = numpy.c_[random.uniform(-3, 3, (3000, 2)), numpy.full(3000, -1.5)]
    wall = numpy.c_[numpy.full(1500, 4.0), random.uniform(-3, 3, 1500), random.uniform(-1.5, 1.5, 1500)]
    clutter = random.uniform(-1, 1, (500, 3))
    points = numpy.concatenate([floor, wall, clutter])
    return points + random.normal(0, 0.002, points.shape)
