# SPDX-License-Identifier: Apache-2.0
"""A folder of depth frames as a table of planes: tum_planes.py [FOLDER] [--camera FILE]

FOLDER is a TUM RGB-D sequence or any other folder of frames; without one, frames are rendered. Tracked planes keep their number from
frame to frame.
"""

import argparse
from collections.abc import Iterator

import fransac


def frames(folder: str | None, camera: str | None) -> Iterator[fransac.Frame | fransac.SynthFrame]:
    if folder is not None:
        return fransac.frames(folder, camera)
    return (fransac.synth("office", frame=i, motion="walk") for i in range(3))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--camera", help="a camera.json, or freiburg1 to freiburg3")
    arguments = parser.parse_args()

    tracker = fransac.Tracker()
    print(f"{'frame':>5} {'plane':>5} {'kind':<10} {'m2':>6} {'rms mm':>6} {'normal':^23} {'d m':>6} {'frames':>6}")
    for number, frame in enumerate(frames(arguments.folder, arguments.camera)):
        found = fransac.segment(frame.depth, frame.camera)
        for plane, tracked in zip(found.planes, tracker.update(found).planes):
            x, y, z = tracked.normal
            print(
                f"{number:5} {tracked.id:5} {plane.kind:<10} {plane.area_m2:6.2f} {1e3 * plane.rms_m:6.1f} "
                f"{x:7.3f} {y:7.3f} {z:7.3f} {tracked.d:6.3f} {tracked.age:6}"
            )


if __name__ == "__main__":
    main()
