# SPDX-License-Identifier: Apache-2.0
"""The planes of a depth image, and a picture of them: 01_segment.py [DEPTH]. Without one, a desk is rendered."""

import pathlib
import sys

import fransac

frame: fransac.Frame | fransac.SynthFrame
frame = next(fransac.frames(sys.argv[1])) if len(sys.argv) > 1 else fransac.synth("desk")
found = fransac.segment(frame.depth, frame.camera)
for plane in found.planes:
    print(f"plane {plane.id}: {plane.kind}, {plane.area_m2:.2f} m2, {plane.d:.2f} m away")
picture = found.picture(frame.depth)
height, width, _ = picture.shape
pathlib.Path("planes.ppm").write_bytes(f"P6 {width} {height} 255\n".encode() + picture.tobytes())
