# SPDX-License-Identifier: Apache-2.0
"""Planes that keep their numbers while the camera moves, and its path: 04_track.py [FOLDER]. Without one, frames are rendered."""

import sys
from collections.abc import Iterator

import fransac

frames: Iterator[fransac.Frame | fransac.SynthFrame]
frames = fransac.frames(sys.argv[1]) if len(sys.argv) > 1 else (fransac.synth("office", frame=i, motion="walk") for i in range(3))
tracker = fransac.Tracker()
for number, frame in enumerate(frames):
    tracked = tracker.update(fransac.segment(frame.depth, frame.camera))
    x, y, z = tracked.pose[:3, 3]
    print(f"frame {number}: camera at {x:.3f} {y:.3f} {z:.3f}, planes {[plane.id for plane in tracked.planes]}")
