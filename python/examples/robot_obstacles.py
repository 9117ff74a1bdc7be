# SPDX-License-Identifier: Apache-2.0
"""What is in front of a robot: robot_obstacles.py [FRAME]

FRAME is a depth PNG with a camera.json beside it, or a folder of one; without it a frame is rendered. Prints what stands in the way of
a robot of the given width that drives where the camera looks, and how far it can go.
"""

import argparse

import numpy

import fransac

WIDTH_M = 0.5
HEIGHT_M = 1.2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("frame", nargs="?")
    arguments = parser.parse_args()
    frame: fransac.Frame | fransac.SynthFrame
    if arguments.frame is None:
        frame = fransac.synth("corridor", seed=2)
    else:
        frame = next(fransac.frames(arguments.frame))

    found = fransac.segment(frame.depth, frame.camera, obstacles=True)
    if found.ground is None:
        print("no floor is seen: stop")
        return
    print(f"{len(found.obstacles)} obstacles, floor by {found.planes[found.support[0] - 1]}")
    free_m = numpy.inf
    for obstacle in found.obstacles:
        ahead, left = obstacle.box.centre[:2]
        reach = float(numpy.hypot(*obstacle.box.size[:2])) / 2  # of its footprint, whichever way it is turned
        in_the_way = abs(left) - reach < WIDTH_M / 2 and obstacle.min_height_m < HEIGHT_M
        where = "ahead" if in_the_way else "left" if left > 0 else "right"
        print(f"  {obstacle.kind:<6} {where:<5} {ahead:5.2f} m ahead, {left:5.2f} m left, up to {obstacle.max_height_m:.2f} m high")
        if in_the_way:
            free_m = min(free_m, ahead - reach)
    print("the way is free as far as is seen" if numpy.isinf(free_m) else f"free for {max(free_m, 0.0):.2f} m")


if __name__ == "__main__":
    main()
