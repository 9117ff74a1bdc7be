# SPDX-License-Identifier: Apache-2.0
"""Frame after frame in the same memory: 02_stream.py [FOLDER]. Without one, frames are rendered."""

import sys
import time
from collections.abc import Iterator

import fransac

frames: Iterator[fransac.Frame | fransac.SynthFrame]
frames = fransac.frames(sys.argv[1]) if len(sys.argv) > 1 else (fransac.synth("office", frame=i) for i in range(3))
for number, frame in enumerate(frames):
    begin = time.perf_counter()
    found = fransac.segment(frame.depth, frame.camera)
    print(f"frame {number}: {len(found.planes)} planes in {1e3 * (time.perf_counter() - begin):.2f} ms")
