#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An example of the adapter prints the planes that it prints with PCL: compare_examples.py NAME OURS PCL'S"""

import itertools
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

TOLERANCE = 1e-2  # of a plane's coefficients
LOST = 0.001  # of the inliers


def table_scene():
    """A table 1.2 m x 0.8 m, a wall behind it and three boxes on it, 3 mm of noise."""
    draw = random.Random(20)

    def noise():
        return draw.gauss(0.0, 0.003)

    points = [(draw.uniform(-0.6, 0.6), 0.5 + noise(), draw.uniform(0.8, 1.6)) for _ in range(40000)]
    points += [(draw.uniform(-0.8, 0.8), draw.uniform(-0.3, 0.6), 1.8 + noise()) for _ in range(25000)]
    for x, z, size in ((-0.4, 1.0, 0.12), (0.0, 1.3, 0.15), (0.35, 1.05, 0.1)):
        # Front and top of a box.
        points += [(x + draw.uniform(0, size), 0.5 - draw.uniform(0, size), z + noise()) for _ in range(3000)]
        points += [(x + draw.uniform(0, size), 0.5 - size + noise(), z + draw.uniform(0, size)) for _ in range(3000)]
    return points


def write_pcd(path, points):
    header = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA binary\n"
    )
    path.write_bytes(header.encode() + b"".join(struct.pack("<3f", *point) for point in points))


def planes(lines):
    """(coefficients with d >= 0, inliers) of every line `plane a b c d inliers n`."""
    found = []
    for line in lines:
        words = line.split()
        if words[0] != "plane":
            continue
        values = [float(word) for word in words[1:5]]
        sign = 1 if values[3] >= 0 else -1
        found.append(([sign * value for value in values], int(words[6])))
    return found


def complaints(ours, theirs):
    found, wanted = planes(ours), planes(theirs)
    if not wanted or len(found) != len(wanted):
        yield f"{len(found)} planes, PCL {len(wanted)}"
    # From the second plane on the two search what each left over itself, so that who took more before has fewer points to find:
    # inliers count together with those before. pcl_adapter_test compares each plane on the same points.
    sums = itertools.accumulate(inliers for _, inliers in found)
    pcl_sums = itertools.accumulate(inliers for _, inliers in wanted)
    for (plane, _), (pcl_plane, _), inliers, pcl_inliers in zip(found, wanted, sums, pcl_sums):
        if max(abs(a - b) for a, b in zip(plane, pcl_plane)) > TOLERANCE:
            yield f"plane {plane}, PCL {pcl_plane}"
        # Both end with a least-squares fit, which may lose a few of the inliers that the search had.
        if inliers < (1.0 - LOST) * pcl_inliers:
            yield f"{inliers} inliers, PCL {pcl_inliers}"
    clusters = [sum(line.startswith("cluster") for line in lines) for lines in (ours, theirs)]
    if clusters[0] != clusters[1]:
        yield f"{clusters[0]} clusters, PCL {clusters[1]}"


def main():
    name, *programs = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        arguments = []
        if name == "cluster_extraction":
            arguments = [str(pathlib.Path(folder) / "table.pcd")]
            write_pcd(pathlib.Path(arguments[0]), table_scene())
        printed = [
            subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout.splitlines()
            for program in programs
        ]
    print("\n".join(f"{side}: {line}" for side, lines in zip(("ours", "PCL"), printed) for line in lines))
    sys.exit("\n".join(complaints(*printed)) or 0)


if __name__ == "__main__":
    main()
