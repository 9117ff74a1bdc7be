# SPDX-License-Identifier: Apache-2.0
"""What a call from Python adds to the library's own time: overhead.py [--frames N] [--input FRAME]

In one process, in turns so that both see the same machine: calls of fransac.segment timed from outside, and calls of the C++ function,
timed in C++ with memory reused. Prints machine, compiler and input; --max-us fails above a limit.
"""

import argparse
import platform
import re
import statistics
import sys
import sysconfig
import time

import numpy

import fransac
from fransac import _core


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        model = re.search(r"model name\s*: (.*)", file.read())
    return model.group(1) if model else platform.processor()


def measure(depth, camera, frames):
    """Microseconds a call: of C++, of Python in all, of Python beyond what the library says it took; medians and the spread."""
    cpp, outside, beyond = [], [], []
    for _ in range(frames):
        # The first call of each turn finds the other's memory in the caches, and is not counted.
        cpp += [1e3 * ms for ms in _core.time_in_cpp(depth, camera, 2)[1:]]
        fransac.segment(depth, camera)
        start = time.perf_counter_ns()
        found = fransac.segment(depth, camera)
        us = (time.perf_counter_ns() - start) / 1e3
        labels = found.labels  # as a caller would
        outside.append(us)
        beyond.append(us - 1e3 * found.timing_ms["total"])
        del found, labels
    return cpp, outside, beyond


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--input", help="a frame folder or depth PNG; else a rendered one")
    parser.add_argument("--max-us", type=float, help="fail when a call adds more, in the median")
    arguments = parser.parse_args()
    frame = next(fransac.frames(arguments.input)) if arguments.input else fransac.synth("desk")
    name = arguments.input or "synth desk"

    print(f"machine   {machine()}, {fransac.instruction_set()}")
    print(f"compiler  {_core.compiler}")
    print(f"Python    {platform.python_version()}, NumPy {numpy.__version__}, {sysconfig.get_config_var('SOABI')}, {_core.__file__.rpartition('/')[2]}")
    worst = 0.0
    small = fransac.Camera(width=64, height=48, fx=50, fy=50, cx=31.5, cy=23.5)
    inputs = {
        f"{name}, {frame.depth.shape[1]} x {frame.depth.shape[0]} uint16": (frame.depth, frame.camera),
        "wall, 64 x 48 uint16": (numpy.full((48, 64), 2000, numpy.uint16), small),
        "wall, 64 x 48 float32": (numpy.full((48, 64), 2.0, numpy.float32), small),
    }
    for title, (depth, camera) in inputs.items():
        measure(depth, camera, 20)
        cpp, outside, beyond = (statistics.quantiles(values, n=20) for values in measure(depth, camera, arguments.frames))
        print(f"input     {title}, {arguments.frames} calls; median (5 % to 95 %), microseconds")
        print(f"  C++ call            {cpp[9]:9.1f} ({cpp[0]:.1f} to {cpp[18]:.1f})")
        print(f"  Python call         {outside[9]:9.1f} ({outside[0]:.1f} to {outside[18]:.1f})")
        print(f"  beyond the library  {beyond[9]:9.1f} ({beyond[0]:.1f} to {beyond[18]:.1f})")
        worst = max(worst, beyond[9])
    if arguments.max_us is not None and worst > arguments.max_us:
        sys.exit(f"a call adds {worst:.1f} us, more than {arguments.max_us}")


if __name__ == "__main__":
    main()
