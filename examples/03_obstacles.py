# SPDX-License-Identifier: Apache-2.0
"""What stands on the floor or falls away from it, nearest first: 03_obstacles.py [DEPTH]. Without one, a corridor is rendered."""

import sys

import fransac

frame: fransac.Frame | fransac.SynthFrame
frame = next(fransac.frames(sys.argv[1])) if len(sys.argv) > 1 else fransac.synth("corridor", seed=2)
found = fransac.segment(frame.depth, frame.camera, obstacles=True)
if found.ground is None or not found.support:
    sys.exit("no floor is seen: stop")
for obstacle in found.obstacles:
    ahead, left = obstacle.box.centre[:2]
    length, width, height = obstacle.box.size
    print(f"{obstacle.kind}: {ahead:.2f} m ahead, {left:.2f} m to the left, {length:.2f} x {width:.2f} x {height:.2f} m")
