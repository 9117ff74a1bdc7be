# SPDX-License-Identifier: Apache-2.0
"""Rendered frames through every peer that was built: all have times and sane labels. Usage: smoke_test.py BENCH_PEERS"""

import json
import subprocess
import sys

ALWAYS = {"cells", "fransac", "voxel-ransac", "rransac", "ransac", "obstacles"}


def rows_of(suites, frames):
    command = [sys.argv[1], "--suite", suites, "--dataset", "synth", "--frames", frames, "--repeat", "1", "--json", "-"]
    document = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return [row for row in document["rows"] if not row.get("note", "").startswith("not built")]


def main():
    # The first is a room without objects, the second a desk.
    rows = rows_of("segment,planes,voxel_grid,sac,floor", "1") + rows_of("objects", "2")
    complaints = []
    for row in rows:
        name = f"{row['suite']} {row['peer']}"
        if row.get("note", "").endswith(" s a run"):
            continue  # a slow rival on a slow machine
        if len(row["times_ms"]) != 1 or not 0 < row["times_ms"][0] < 60_000:
            complaints.append(f"{name}: times {row['times_ms']} {row.get('note', '')}")
        # A rendered empty room: whichever of its walls is found, most of its pixels are right.
        if row["suite"] == "segment" and not row.get("precision", 0) + row.get("best_f1", 0) > 0.8:
            complaints.append(f"{name}: F1 {row.get('best_f1')}")
        if row["suite"] == "planes" and row["library"] != "floor" and not 0 <= row.get("instance_f1_50", -1) <= 1:
            complaints.append(f"{name}: instance F1 {row.get('instance_f1_50')}")
        if row["suite"] == "objects" and row["library"] != "floor":
            if ("object_f1_50" in row) != (row.get("true_objects", 0) > 0) or not 0 <= row.get("object_f1_50", 0) <= 1:
                complaints.append(f"{name}: {row.get('true_objects')} objects, F1 {row.get('object_f1_50')}")
        if row["suite"] == "voxel_grid" and not 100 < row.get("leaves", 0) < row["points"]:
            complaints.append(f"{name}: {row.get('leaves')} leaves")
        if row["suite"] == "sac" and not 0.1 * row["points"] < row.get("inliers", 0) <= row["points"]:
            complaints.append(f"{name}: {row.get('inliers')} inliers")
    if not any(row.get("true_objects") and row["peer"] == "obstacles" for row in rows):
        complaints.append("objects: no frame with one")
    missing = ALWAYS - {row["peer"] for row in rows}
    if missing:
        complaints.append(f"missing: {sorted(missing)}")
    print("\n".join(complaints) or f"{len(rows)} rows")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
